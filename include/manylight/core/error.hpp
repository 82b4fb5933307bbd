// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace manylight {

/// Base of everything thrown by the headers, always at set-up, never from an inner loop.
/// `what()` is one line naming the element, its value and what is allowed.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A parameter outside its range.
class ParameterError : public Error {
 public:
  template <class Value>
  ParameterError(std::string_view element, const Value& value, std::string_view allowed)
      : Error(message(element, value, allowed)) {}

 private:
  template <class Value>
  static std::string message(std::string_view element, const Value& value, std::string_view allowed) {
    std::ostringstream out;
    out << element << " is " << value << ", allowed: " << allowed;
    return out.str();
  }
};

/// Geometry that cannot be used: an empty mesh, an index out of range, a vertex that is not finite.
class GeometryError : public Error {
 public:
  using Error::Error;
};

/// A scene that cannot be rendered: no emitter, no camera, a reference to nothing.
class SceneError : public Error {
 public:
  using Error::Error;
};

/// Throws ParameterError unless `value` is finite and `holds`.
template <class Value>
inline void require(bool holds, std::string_view element, const Value& value, std::string_view allowed) {
  if (!holds) throw ParameterError(element, value, allowed);
}

}  // namespace manylight
