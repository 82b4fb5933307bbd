// SPDX-License-Identifier: Apache-2.0
#include "scene_file/properties.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace manylight::scene_file {

namespace {

bool is_separator(char c) { return c == ' ' || c == ',' || c == '\t' || c == '\n' || c == '\r'; }

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

}  // namespace

// ---- names -----------------------------------------------------------------------------------

Names::Names(const Element& root) {
  collect(root);
  for (const auto& child : root.children) {
    if (child->tag != "alias") continue;
    const auto target = targets_.find(child->get("id"));
    if (target == targets_.end()) fail(*child, "refers to unknown id " + in_quotes(child->get("id")));
    add(*child, child->get("as"), *target->second);
  }
  static_cast<void>(depth_below(root, 0));
}

int Names::depth_below(const Element& element, int depth) {
  constexpr int k_deepest = 200;
  if (depth > k_deepest) fail(element, "refers to itself, or references are nested too deeply");
  const auto known = depths_.find(&element);
  if (known != depths_.end()) return known->second;
  int deepest = 0;
  for (const auto& child : element.children) {
    const Element& target = child->tag == "ref" ? resolve(*child) : *child;
    deepest = std::max(deepest, 1 + depth_below(target, depth + 1));
  }
  if (depth + deepest > k_deepest) fail(element, "refers to itself, or references are nested too deeply");
  depths_[&element] = deepest;
  return deepest;
}

void Names::collect(const Element& element) {
  for (const auto& child : element.children) {
    const bool defines = child->tag != "ref" && child->tag != "alias" && child->has("id");
    if (defines) add(*child, child->get("id"), *child);
    collect(*child);
  }
}

void Names::add(const Element& where, const std::string& id, const Element& target) {
  if (id.empty()) fail(where, "has an empty id");
  const auto [found, is_new] = targets_.emplace(id, &target);
  if (is_new) return;
  const Element& first = *found->second;
  fail(where, "id " + in_quotes(id) + " is used before, in " + *first.file + ":" + std::to_string(first.line));
}

const Element& Names::resolve(const Element& reference) const {
  const auto found = targets_.find(reference.get("id"));
  if (found == targets_.end()) fail(reference, "refers to unknown id " + in_quotes(reference.get("id")));
  return *found->second;
}

// ---- numbers ---------------------------------------------------------------------------------

double parse_number(const Element& element, std::string_view text) {
  const std::vector<double> numbers = parse_numbers(element, text);
  if (numbers.size() != 1) fail(element, "needs one number, not " + in_quotes(text));
  return numbers.front();
}

std::vector<double> parse_numbers(const Element& element, std::string_view text) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < text.size();) {
    if (is_separator(text[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && !is_separator(text[end])) ++end;
    const std::string_view word = text.substr(i, end - i);
    const std::size_t sign = word.front() == '+' ? 1 : 0;  // from_chars takes no plus
    double value = 0;
    const auto [stop, code] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
    if (code != std::errc() || stop != word.data() + word.size()) fail(element, in_quotes(word) + " is not a number");
    const bool fits = std::isfinite(value) && std::abs(value) <= double{std::numeric_limits<float>::max()};
    if (!fits) fail(element, in_quotes(word) + " is out of range, allowed: finite numbers");
    numbers.push_back(value);
    i = end;
  }
  return numbers;
}

Vec3<float> parse_vector(const Element& element, float missing) {
  Vec3<float> result(missing);
  if (element.has("value")) {
    const std::vector<double> numbers = parse_numbers(element, element.get("value"));
    if (numbers.size() != 1 && numbers.size() != 3) fail(element, "needs one or three numbers");
    for (int i = 0; i < 3; ++i)
      result[i] = static_cast<float>(numbers[numbers.size() == 1 ? 0 : static_cast<std::size_t>(i)]);
  }
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (element.has(axes[i])) result[i] = static_cast<float>(parse_number(element, element.get(axes[i])));
  }
  return result;
}

// ---- properties ------------------------------------------------------------------------------

Properties::Properties(const Element& element, const Names& names) : element_(element) {
  std::set<std::string, std::less<>> seen;
  for (const auto& child : element.children) {
    const Element& target = child->tag == "ref" ? names.resolve(*child) : *child;
    std::string name = snake_case(child->get("name"));
    if (!name.empty() && !seen.insert(name).second) fail(*child, "property " + in_quotes(name) + " is given twice");
    items_.push_back({&target, child.get(), std::move(name)});
  }
}

const Element* Properties::take(std::string_view name) {
  known_.emplace_back(name);
  for (Item& item : items_) {
    if (item.name != name) continue;
    item.is_taken = true;
    return item.element;
  }
  return nullptr;
}

std::vector<const Properties::Item*> Properties::take_all(std::string_view tag) {
  known_.push_back("<" + std::string(tag) + ">");
  std::vector<const Item*> found;
  for (Item& item : items_) {
    if (item.is_taken || item.element->tag != tag) continue;
    item.is_taken = true;
    found.push_back(&item);
  }
  return found;
}

void Properties::require_tag(const Element& child, std::initializer_list<std::string_view> tags) const {
  if (std::find(tags.begin(), tags.end(), child.tag) != tags.end()) return;
  std::vector<std::string> names;
  for (const std::string_view tag : tags) names.push_back("<" + std::string(tag) + ">");
  fail(child, "wrong kind of property, expected " + listed(names));
}

std::optional<double> Properties::number(std::string_view name) {
  const Element* child = take(name);
  if (child == nullptr) return std::nullopt;
  require_tag(*child, {"float", "integer"});
  return parse_number(*child, child->get("value"));
}

double Properties::positive(std::string_view name, double otherwise) {
  const Element* child = take(name);
  if (child == nullptr) return otherwise;
  require_tag(*child, {"float", "integer"});
  const double value = parse_number(*child, child->get("value"));
  if (!(value > 0)) fail(*child, in_quotes(child->get("value")) + " is out of range, allowed: above 0");
  return value;
}

std::optional<int> Properties::integer(std::string_view name) {
  const Element* child = take(name);
  if (child == nullptr) return std::nullopt;
  require_tag(*child, {"integer"});
  const double value = parse_number(*child, child->get("value"));
  if (value != std::floor(value) || std::abs(value) > double{std::numeric_limits<int>::max()}) {
    fail(*child, in_quotes(child->get("value")) + " is not a whole number in range");
  }
  return static_cast<int>(value);
}

bool Properties::flag(std::string_view name, bool otherwise) {
  const Element* child = take(name);
  if (child == nullptr) return otherwise;
  require_tag(*child, {"boolean"});
  const std::string& value = child->get("value");
  if (value == "true" || value == "True" || value == "1") return true;
  if (value == "false" || value == "False" || value == "0") return false;
  fail(*child, in_quotes(value) + " is neither true nor false");
}

std::optional<std::string> Properties::text(std::string_view name) {
  const Element* child = take(name);
  if (child == nullptr) return std::nullopt;
  require_tag(*child, {"string"});
  return child->get("value");
}

std::optional<Vec3<float>> Properties::vector(std::string_view name) {
  const Element* child = take(name);
  if (child == nullptr) return std::nullopt;
  require_tag(*child, {"point", "vector"});
  return parse_vector(*child, 0.0F);
}

void Properties::ignore(std::initializer_list<std::string_view> names) {
  for (Item& item : items_) {
    if (std::find(names.begin(), names.end(), item.name) != names.end()) item.is_taken = true;
  }
}

void Properties::ignore_tags(std::initializer_list<std::string_view> tags) {
  for (Item& item : items_) {
    if (std::find(tags.begin(), tags.end(), item.element->tag) != tags.end()) item.is_taken = true;
  }
}

void Properties::finish() const {
  for (const Item& item : items_) {
    if (item.is_taken) continue;
    std::vector<std::string> known = known_;
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    const std::string supported = known.empty() ? "nothing" : listed(known);
    fail(*item.place, "not known inside of " + element_.describe() + "; supported are " + supported);
  }
}

}  // namespace manylight::scene_file
