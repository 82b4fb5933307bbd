// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "manylight/core/vector.hpp"
#include "scene_file/xml_tree.hpp"

namespace manylight::scene_file {

/// The elements with an id; <ref> and <alias> lead to them.
class Names {
 public:
  /// Collects the ids of a document. Throws SceneFileError for one that is given twice, an alias to nothing, and
  /// references that lead back to themselves.
  explicit Names(const Element& root);
  /// The element that a <ref> leads to. Throws SceneFileError at `reference`.
  [[nodiscard]] const Element& resolve(const Element& reference) const;

 private:
  void collect(const Element& element);
  void add(const Element& where, const std::string& id, const Element& target);
  /// Levels of elements below one, references followed. Throws SceneFileError where they lead back to themselves.
  int depth_below(const Element& element, int depth);

  std::map<std::string, const Element*, std::less<>> targets_;
  std::map<const Element*, int> depths_;
};

/// Numbers separated by white space or commas, each finite. Throws SceneFileError at `element`.
[[nodiscard]] std::vector<double> parse_numbers(const Element& element, std::string_view text);

/// Exactly one number. Throws SceneFileError at `element`.
[[nodiscard]] double parse_number(const Element& element, std::string_view text);

/// What stands inside of an element, taken out piece by piece: `finish` complains about what nobody asked for.
class Properties {
 public:
  /// A child, or what a <ref> child leads to.
  struct Item {
    const Element* element;  ///< the target of a reference
    const Element* place;    ///< where it stands in the file: the reference itself
    std::string name;        ///< snake case; may be empty
    bool is_taken = false;
  };

  Properties(const Element& element, const Names& names);

  [[nodiscard]] const Element& element() const { return element_; }

  /// Takes the child called `name`, if there is one.
  [[nodiscard]] const Element* take(std::string_view name);
  /// Takes all children with this tag.
  [[nodiscard]] std::vector<const Item*> take_all(std::string_view tag);

  [[nodiscard]] std::optional<double> number(std::string_view name);
  [[nodiscard]] double number(std::string_view name, double otherwise) { return number(name).value_or(otherwise); }
  [[nodiscard]] std::optional<int> integer(std::string_view name);
  [[nodiscard]] bool flag(std::string_view name, bool otherwise);
  [[nodiscard]] std::optional<std::string> text(std::string_view name);
  [[nodiscard]] std::optional<Vec3<float>> vector(std::string_view name);

  /// A number that must be above 0 (and finite). Throws SceneFileError.
  [[nodiscard]] double positive(std::string_view name, double otherwise);

  /// Known properties without influence on the picture.
  void ignore(std::initializer_list<std::string_view> names);
  void ignore_tags(std::initializer_list<std::string_view> tags);

  /// Throws SceneFileError at the first child that was neither taken nor ignored, naming what was looked for.
  void finish() const;

 private:
  void require_tag(const Element& child, std::initializer_list<std::string_view> tags) const;

  const Element& element_;
  std::vector<Item> items_;
  std::vector<std::string> known_;
};

/// <point> and <vector>: three numbers in `value`, or x, y and z with a default.
[[nodiscard]] Vec3<float> parse_vector(const Element& element, float missing);

}  // namespace manylight::scene_file
