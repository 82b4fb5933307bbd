// SPDX-License-Identifier: Apache-2.0
#include "scene_file/transforms.hpp"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace manylight::scene_file {

namespace {

/// 16 numbers row by row, or the 9 of a 3 x 3 matrix.
glm::dmat4 parse_matrix(const Element& element) {
  const std::vector<double> numbers = parse_numbers(element, element.get("value"));
  if (numbers.size() != 16 && numbers.size() != 9) fail(element, "a matrix needs 16 or 9 numbers");
  const std::size_t side = numbers.size() == 16 ? 4 : 3;
  glm::dmat4 matrix(1.0);
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      matrix[static_cast<int>(column)][static_cast<int>(row)] = numbers[row * side + column];
    }
  }
  const bool is_affine = matrix[0][3] == 0 && matrix[1][3] == 0 && matrix[2][3] == 0 && matrix[3][3] == 1;
  if (!is_affine) fail(element, "the last row of a matrix must be 0 0 0 1");
  return matrix;
}

glm::dvec3 take_point(const Element& element, const char* name) {
  const std::vector<double> numbers = parse_numbers(element, element.get(name));
  if (numbers.size() != 3) fail(element, std::string("needs three numbers in '") + name + "'");
  return {numbers[0], numbers[1], numbers[2]};
}

/// Columns left, up, forward: the local +x of a camera points to the left of its image.
glm::dmat4 parse_look_at(const Element& element) {
  const glm::dvec3 origin = take_point(element, "origin");
  const glm::dvec3 forward = take_point(element, "target") - origin;
  const glm::dvec3 up = take_point(element, "up");
  const glm::dvec3 left = glm::cross(up, forward);
  if (!(glm::length(left) > 0)) fail(element, "target must differ from origin, and up must not point to the target");
  const glm::dvec3 x = glm::normalize(left);
  const glm::dvec3 z = glm::normalize(forward);
  return {glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0), glm::dvec4(origin, 1)};
}

glm::dmat4 parse_rotate(const Element& element) {
  const glm::dvec3 axis(parse_vector(element, 0.0F));
  if (!(glm::length(axis) > 0)) fail(element, "needs an axis of rotation");
  const double radians = parse_number(element, element.get("angle")) * k_pi<double> / 180.0;
  return glm::rotate(glm::dmat4(1.0), radians, glm::normalize(axis));
}

glm::dmat4 parse_step(const Element& step) {
  if (step.tag == "matrix") return parse_matrix(step);
  if (step.tag == "lookat") return parse_look_at(step);
  if (step.tag == "rotate") return parse_rotate(step);
  if (step.tag == "translate") return glm::translate(glm::dmat4(1.0), glm::dvec3(parse_vector(step, 0.0F)));
  if (step.tag == "scale") return glm::scale(glm::dmat4(1.0), glm::dvec3(parse_vector(step, 1.0F)));
  fail(step, "unknown transformation; supported are <translate>, <rotate>, <scale>, <matrix> and <lookat>");
}

}  // namespace

glm::mat4 parse_transform(const Element& element) {
  if (element.tag != "transform") fail(element, "wrong kind of property, expected <transform>");
  glm::dmat4 matrix(1.0);
  for (const auto& step : element.children) matrix = parse_step(*step) * matrix;
  for (int column = 0; column < 4; ++column) {
    const glm::dvec4 c = matrix[column];
    if (!is_finite(Vec3<float>(c))) fail(element, "the transformation is not finite");
  }
  return glm::mat4(matrix);
}

glm::mat4 invertible_transform(const Element& element) {
  const glm::mat4 matrix = parse_transform(element);
  const float determinant = glm::determinant(glm::mat3(matrix));
  if (determinant == 0.0F || !std::isfinite(determinant)) fail(element, "the transformation cannot be inverted");
  return matrix;
}

glm::mat4 take_transform(Properties& properties, std::string_view name) {
  const Element* child = properties.take(name);
  return child == nullptr ? glm::mat4(1.0F) : invertible_transform(*child);
}

UvTransform<float> take_uv_transform(Properties& properties) {
  UvTransform<float> result;
  if (const Element* child = properties.take("to_uv")) {
    const glm::mat4 m = parse_transform(*child);
    result = {m[0][0], m[1][0], m[3][0], m[0][1], m[1][1], m[3][1]};
  }
  // The older files scale and shift each coordinate by itself, after any to_uv there may be.
  const auto u_scale = static_cast<float>(properties.number("uscale", 1.0));
  const auto v_scale = static_cast<float>(properties.number("vscale", 1.0));
  const auto u_offset = static_cast<float>(properties.number("uoffset", 0.0));
  const auto v_offset = static_cast<float>(properties.number("voffset", 0.0));
  return {u_scale * result.xx, u_scale * result.xy, u_scale * result.x0 + u_offset,
          v_scale * result.yx, v_scale * result.yy, v_scale * result.y0 + v_offset};
}

}  // namespace manylight::scene_file
