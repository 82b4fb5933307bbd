// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bounds of box_pair.hpp, one box per lane of a pack. The same formulas with the same margins: lanes differ from the
// scalar bounds by rounding that the margins cover.

#include <array>
#include <cstddef>
#include <limits>

#include "manylight/bounds/box_pair.hpp"
#include "manylight/geometry/pack.hpp"

namespace manylight::detail {

template <std::floating_point S>
using PackVec = std::array<Pack<S>, 3>;

template <std::floating_point S>
[[nodiscard]] inline Pack<S> dot(const PackVec<S>& a, const PackVec<S>& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <std::floating_point S>
[[nodiscard]] inline Pack<S> length(const PackVec<S>& v) noexcept {
  return pack_sqrt<S>(dot<S>(v, v));
}
template <std::floating_point S>
inline void set_lane(PackVec<S>& pack, std::size_t lane, const Vec3<S>& v) noexcept {
  pack[0][lane] = v.x;
  pack[1][lane] = v.y;
  pack[2][lane] = v.z;
}

template <std::floating_point S>
struct BoxPack {
  PackVec<S> lo{};
  PackVec<S> hi{};

  void set(std::size_t lane, const Box<S>& box) noexcept {
    set_lane(lo, lane, box.lo);
    set_lane(hi, lane, box.hi);
  }
};
template <std::floating_point S>
struct ConePack {
  PackVec<S> axis{};
  Pack<S> cos_half{};
  Pack<S> sin_half{};

  void set(std::size_t lane, const DirectionCone<S>& cone) noexcept {
    set_lane(axis, lane, cone.axis);
    cos_half[lane] = cone.cos_half;
    sin_half[lane] = cone.sin_half;
  }
};

/// See manylight::difference.
template <std::floating_point S>
[[nodiscard]] inline BoxPack<S> difference(const BoxPack<S>& from, const BoxPack<S>& to) noexcept {
  BoxPack<S> vectors;
  for (std::size_t a = 0; a < 3; ++a) {
    vectors.lo[a] = to.lo[a] - from.hi[a];
    vectors.hi[a] = to.hi[a] - from.lo[a];
  }
  return vectors;
}

/// See Box::diagonal; the boxes are not empty.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> diagonal(const BoxPack<S>& box) noexcept {
  return length<S>({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
}

/// See manylight::spread.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> spread(const ConePack<S>& cones) noexcept {
  return cones.cos_half > broadcast(S(0.54)) ? cones.sin_half : broadcast(S(1));
}

/// See manylight::min_squared_length.
template <std::floating_point S>
[[nodiscard]] inline Pack<S> min_squared_length(const BoxPack<S>& vectors) noexcept {
  PackVec<S> gap;
  for (std::size_t a = 0; a < 3; ++a) gap[a] = pack_max<S>(Pack<S>{}, pack_max<S>(vectors.lo[a], -vectors.hi[a]));
  return dot<S>(gap, gap) * (S(1) - S(8) * std::numeric_limits<S>::epsilon());
}

/// See manylight::BoxDirections.
template <std::floating_point S>
class BoxDirectionsPack {
 public:
  explicit BoxDirectionsPack(const BoxPack<S>& vectors) noexcept {
    Pack<S> sum{};
    for (std::size_t a = 0; a < 3; ++a) {
      center_[a] = (vectors.lo[a] + vectors.hi[a]) * S(0.5);
      half_[a] = (vectors.hi[a] - vectors.lo[a]) * S(0.5);
      sum += pack_abs<S>(center_[a]) + half_[a];
    }
    rounding_ = sum * (S(16) * std::numeric_limits<S>::epsilon());
  }

  [[nodiscard]] BoxDirectionsPack operator-() const noexcept {
    BoxDirectionsPack opposite = *this;
    for (Pack<S>& c : opposite.center_) c = -c;
    return opposite;
  }
  [[nodiscard]] const PackVec<S>& center() const noexcept { return center_; }
  [[nodiscard]] Box<S> box(std::size_t lane) const noexcept {
    const Vec3<S> c(center_[0][lane], center_[1][lane], center_[2][lane]);
    const Vec3<S> h(half_[0][lane], half_[1][lane], half_[2][lane]);
    return {c - h - rounding_[lane], c + h + rounding_[lane]};
  }

  friend Pack<S> max_cosine(const ConePack<S>& axes, const BoxDirectionsPack& box) noexcept {
    const S rounding = S(16) * std::numeric_limits<S>::epsilon();
    const Pack<S> one = broadcast(S(1));
    const Pack<S> cosine = box.max_cosine_with(axes.axis) + rounding;  // before the sine, which is steep next to -1
    const Pack<S> sine = pack_sqrt<S>(pack_max<S>(Pack<S>{}, one - cosine * cosine));
    const Pack<S> turned = pack_min<S>(one, cosine * axes.cos_half + sine * axes.sin_half + rounding);
    return cosine >= axes.cos_half ? one : turned;  // full cones, too: their -1 is below every cosine and its rounding
  }

 private:
  [[nodiscard]] Pack<S> max_cosine_with(const PackVec<S>& n) const noexcept {
    const PackVec<S> absolute{pack_abs<S>(n[0]), pack_abs<S>(n[1]), pack_abs<S>(n[2])};
    const Pack<S> z = dot<S>(center_, n) + dot<S>(half_, absolute) + rounding_;
    // Both cases of the sign of z, and of each lane the square of the length that z is divided by.
    Pack<S> longest{};
    for (std::size_t a = 0; a < 3; ++a) {
      const Pack<S> reach = pack_abs<S>(center_[a]) + half_[a] + rounding_;
      longest += reach * reach;
    }
    // The frame of Frame(n).
    const Pack<S> sign = pack_sign<S>(n[2]);
    const Pack<S> f = -broadcast(S(1)) / (sign + n[2]);
    const Pack<S> b = n[0] * n[1] * f;
    const Pack<S> s = min_distance({S(1) + sign * n[0] * n[0] * f, sign * b, -sign * n[0]});
    const Pack<S> t = min_distance({b, sign + n[1] * n[1] * f, -n[1]});
    const Pack<S> across = s * s + t * t;
    const Pack<S> cosine = z / pack_sqrt<S>(z < S(0) ? longest : across + z * z);
    return ((z < S(0)) | (across > S(0))) ? cosine : broadcast(S(1));
  }
  [[nodiscard]] Pack<S> min_distance(const PackVec<S>& axis) const noexcept {
    const PackVec<S> absolute{pack_abs<S>(axis[0]), pack_abs<S>(axis[1]), pack_abs<S>(axis[2])};
    return pack_max<S>(Pack<S>{}, pack_abs<S>(dot<S>(center_, axis)) - dot<S>(half_, absolute) - rounding_);
  }

  PackVec<S> center_;
  PackVec<S> half_;
  Pack<S> rounding_;
};

}  // namespace manylight::detail
