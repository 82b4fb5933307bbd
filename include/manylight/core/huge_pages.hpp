// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory for large tables that are read at random, such as a million VPLs and their tree. With pages of 4 KiB nearly
// every read also misses the TLB; the allocator asks the system (Linux) for pages of 2 MiB, and elsewhere is a plain
// one.

#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace manylight {

template <class T>
struct HugePageAllocator {
  using value_type = T;
  static constexpr std::size_t k_page = std::size_t{1} << 21;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>& /*other*/) noexcept {}  // rebinding, implicit as allocators require

  /// Throws std::bad_alloc.
  [[nodiscard]] T* allocate(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / (2 * sizeof(T))) throw std::bad_array_new_length();
    if (!is_large(count)) return static_cast<T*>(::operator new(count * sizeof(T)));
    const std::size_t bytes = (count * sizeof(T) + k_page - 1) / k_page * k_page;
    void* memory = ::operator new(bytes, std::align_val_t{k_page});
#if defined(MADV_HUGEPAGE)
    static_cast<void>(madvise(memory, bytes, MADV_HUGEPAGE));  // a wish: without it reads are only slower
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    if (is_large(count)) {
      ::operator delete(memory, std::align_val_t{k_page});
    } else {
      ::operator delete(memory);
    }
  }
  template <class U>
  [[nodiscard]] bool operator==(const HugePageAllocator<U>& /*other*/) const noexcept {
    return true;
  }

 private:
  [[nodiscard]] static bool is_large(std::size_t count) noexcept { return count * sizeof(T) >= k_page; }
};

template <class T>
using LargeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace manylight
