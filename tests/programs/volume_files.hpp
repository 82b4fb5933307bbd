// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace manylight::test {

/// A number's bytes at the end of `bytes`; this machine's order must be little-endian.
template <class T>
inline void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// A .vol file of float32 samples, x fastest, over the box [lo, hi].
[[nodiscard]] inline std::string volume_file(const std::array<std::int32_t, 3>& size, std::int32_t channels,
                                             const std::array<float, 6>& box, const std::vector<float>& values) {
  std::string file = "VOL\3";
  put(file, std::int32_t{1});
  for (const std::int32_t n : size) put(file, n);
  put(file, channels);
  for (const float x : box) put(file, x);
  for (const float x : values) put(file, x);
  return file;
}

}  // namespace manylight::test
