// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

/// Short vectors by the compilers' vector extension (g++ and clang++), as wide as the target's registers: one source
/// for every instruction set, no intrinsics.
namespace manylight::detail {

#if defined(__AVX__)
inline constexpr std::size_t k_pack_bytes = 32;
#else
inline constexpr std::size_t k_pack_bytes = 16;
#endif

/// Lanes of a pack of S on this target: 4 or 8 floats, 2 or 4 doubles.
template <std::floating_point S>
inline constexpr std::size_t k_lanes = k_pack_bytes / sizeof(S);

template <class T, std::size_t Lanes>
struct PackOf {
  typedef T type __attribute__((vector_size(Lanes * sizeof(T))));
};
template <std::floating_point S>
using Pack = typename PackOf<S, k_lanes<S>>::type;
/// What comparing two packs gives: all bits of a lane set or none.
template <std::floating_point S>
using PackMask = typename PackOf<std::conditional_t<sizeof(S) == 4, std::int32_t, std::int64_t>, k_lanes<S>>::type;

template <std::floating_point S>
[[nodiscard]] inline Pack<S> broadcast(S x) noexcept {
  return x - Pack<S>{};  // minus, not plus: also -0 stays what it is
}
template <std::floating_point S>
[[nodiscard]] inline Pack<S> pack_min(const Pack<S>& a, const Pack<S>& b) noexcept {
  return a < b ? a : b;
}
template <std::floating_point S>
[[nodiscard]] inline Pack<S> pack_max(const Pack<S>& a, const Pack<S>& b) noexcept {
  return a > b ? a : b;
}

template <std::floating_point S>
[[nodiscard]] inline PackMask<S> sign_bits() noexcept {
  return std::bit_cast<PackMask<S>>(broadcast(S(-0.0)));
}
template <std::floating_point S>
[[nodiscard]] inline Pack<S> pack_abs(const Pack<S>& x) noexcept {
  return std::bit_cast<Pack<S>>(std::bit_cast<PackMask<S>>(x) & ~sign_bits<S>());
}
/// +-1 with the sign of x, also of zeros.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> pack_sign(const Pack<S>& x) noexcept {
  return std::bit_cast<Pack<S>>((std::bit_cast<PackMask<S>>(x) & sign_bits<S>()) |
                                std::bit_cast<PackMask<S>>(broadcast(S(1))));
}
/// Correctly rounded, as std::sqrt, which the compilers keep scalar for its errno.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> pack_sqrt(const Pack<S>& x) noexcept {
#if __has_builtin(__builtin_elementwise_sqrt)
  return __builtin_elementwise_sqrt(x);
#elif defined(__AVX__)
  if constexpr (sizeof(S) == 4) {
    return __builtin_ia32_sqrtps256(x);
  } else {
    return __builtin_ia32_sqrtpd256(x);
  }
#elif defined(__SSE2__)
  if constexpr (sizeof(S) == 4) {
    return __builtin_ia32_sqrtps(x);
  } else {
    return __builtin_ia32_sqrtpd(x);
  }
#else
  Pack<S> root = x;
  for (std::size_t lane = 0; lane < k_lanes<S>; ++lane) root[lane] = std::sqrt(x[lane]);
  return root;
#endif
}

/// a * b - c * d with both products rounded: its sign is then the exact one or 0. Fused into one multiply-add, which
/// the compilers do unasked, the sign could be wrong, and swapping (a, b) with (c, d) would not just negate the result.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> difference_of_products(const Pack<S>& a, const Pack<S>& b, const Pack<S>& c,
                                                    const Pack<S>& d) noexcept {
#if defined(__clang__)
#pragma clang fp contract(off)
  return a * b - c * d;
#else
  Pack<S> ab = a * b;
  Pack<S> cd = c * d;
  // An empty statement that may have changed the product; g++ has no pragma for one function that keeps inlining.
#if defined(__x86_64__) || defined(__i386__)
  asm("" : "+x"(ab), "+x"(cd));
#elif defined(__aarch64__)
  asm("" : "+w"(ab), "+w"(cd));
#else
  asm("" : "+m"(ab), "+m"(cd));
#endif
  return ab - cd;
#endif
}

/// The set lanes of a mask, to be walked in ascending order: `while (lanes.any()) use(lanes.pop());`.
class LaneSet {
 public:
  template <std::floating_point S>
  [[nodiscard]] static LaneSet of(const PackMask<S>& mask) noexcept {
    return LaneSet(bits<S>(mask));
  }
  [[nodiscard]] static LaneSet none() noexcept { return LaneSet(0); }
  [[nodiscard]] bool any() const noexcept { return bits_ != 0; }
  std::uint32_t pop() noexcept {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits_)) / k_bits_per_lane;
    bits_ &= bits_ - 1;
    return lane;
  }

 private:
  explicit LaneSet(std::uint64_t bits) noexcept : bits_(bits) {}

  // Each branch is what the compiler turns into the fewest instructions on that target (2 to 7).
#if defined(__clang__) || defined(__AVX512VL__)
  static constexpr std::uint32_t k_bits_per_lane = 8;
  template <std::floating_point S>
  [[nodiscard]] static std::uint64_t bits(const PackMask<S>& mask) noexcept {
    constexpr std::size_t n = k_lanes<S>;
    using Bytes = typename PackOf<signed char, n>::type;
    using Word = std::conditional_t<n == 8, std::uint64_t, std::conditional_t<n == 4, std::uint32_t, std::uint16_t>>;
    return std::bit_cast<Word>(__builtin_convertvector(mask, Bytes)) & (0x0101010101010101u >> (64 - 8 * n));
  }
#else
  static constexpr std::uint32_t k_bits_per_lane = 1;
  template <std::floating_point S>
  [[nodiscard]] static std::uint64_t bits(const PackMask<S>& mask) noexcept {
    if constexpr (k_lanes<S> == 8) {
      PackMask<S> m = mask & PackMask<S>{1, 2, 4, 8, 16, 32, 64, 128};
      m |= __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3);
      m |= __builtin_shufflevector(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
      m |= __builtin_shufflevector(m, m, 1, 0, 3, 2, 5, 4, 7, 6);
      return static_cast<std::uint64_t>(m[0]);
    } else if constexpr (k_lanes<S> == 4) {
      PackMask<S> m = mask & PackMask<S>{1, 2, 4, 8};
      m |= __builtin_shufflevector(m, m, 2, 3, 0, 1);
      m |= __builtin_shufflevector(m, m, 1, 0, 3, 2);
      return static_cast<std::uint64_t>(m[0]);
    } else {
      return static_cast<std::uint64_t>((mask[0] & 1) | (mask[1] & 2));
    }
  }
#endif

  std::uint64_t bits_;
};

}  // namespace manylight::detail
