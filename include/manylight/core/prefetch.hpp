// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace manylight {

/// Asks for the cache lines of [address, address + bytes) ahead of their use; a hint without effect on results.
inline void prefetch([[maybe_unused]] const void* address, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(__GNUC__)
  constexpr std::size_t k_line = 64;
  const char* const first = static_cast<const char*>(address);
  for (std::size_t offset = 0; offset < bytes; offset += k_line) __builtin_prefetch(first + offset);
  __builtin_prefetch(first + bytes - 1);  // the range need not begin with a line
#endif
}

}  // namespace manylight
