// SPDX-License-Identifier: Apache-2.0
#include "scene_file/xml_tree.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include <pugixml.hpp>

namespace manylight::scene_file {

namespace fs = std::filesystem;

namespace {

/// Deeper nesting than any scene needs; keeps the recursion off the stack's end.
constexpr int k_max_nesting = 64;

/// Files that include files twice, or parameters made of parameters, must not exhaust the memory.
constexpr int k_max_includes = 1000;
constexpr std::size_t k_max_text = std::size_t{1} << 20;

std::string file_bytes(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw SceneFileError(path.string(), 0, "", "is a folder, not a scene file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw SceneFileError(path.string(), 0, "", "no such file, or not readable");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Starts of lines of a file, to turn the parser's offsets into line numbers.
class LineIndex {
 public:
  explicit LineIndex(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') ends_.push_back(static_cast<std::ptrdiff_t>(i));
    }
  }
  [[nodiscard]] int line_of(std::ptrdiff_t offset) const {
    return 1 + static_cast<int>(std::lower_bound(ends_.begin(), ends_.end(), offset) - ends_.begin());
  }

 private:
  std::vector<std::ptrdiff_t> ends_;
};

std::string canonical_tag(std::string_view tag) {
  std::string result;
  for (const char c : tag) {
    if (c != '_') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

bool is_name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Builds the tree: follows includes, keeps the parameters in document order.
class Reader {
 public:
  Reader(Document& document, const Definitions& definitions) : document_(document), parameters_(definitions) {}

  void read_top(const fs::path& path) {
    document_.search_paths = {path.has_parent_path() ? path.parent_path() : fs::path(".")};
    read_file(path, document_.root);
    set_version(document_.root);
  }

  void require_all_used(const Definitions& definitions, const fs::path& path) const {
    for (const auto& [name, value] : definitions) {
      if (used_.count(name) == 0) {
        throw SceneFileError(path.string(), 0, "", "parameter '" + name + "' is not used; known are " + known());
      }
    }
  }

 private:
  void read_file(const fs::path& path, Element& root);
  void read_children(const pugi::xml_node& node, Element& parent, const LineIndex& lines, int depth);
  void read_child(const pugi::xml_node& node, Element& parent, const LineIndex& lines, int depth);
  void read_attributes(const pugi::xml_node& node, Element& element);
  void include(const Element& directive, Element& parent);
  void add_search_path(const Element& directive);
  void set_default(const Element& directive);
  void set_version(const Element& root);
  [[nodiscard]] std::string substitute(const Element& element, const std::string& text);
  [[nodiscard]] std::string known() const;

  Document& document_;
  Definitions parameters_;
  std::set<std::string, std::less<>> used_;
  std::vector<fs::path> open_files_;
  int includes_ = 0;
};

void Reader::read_file(const fs::path& path, Element& root) {
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(path, error);
  if (std::find(open_files_.begin(), open_files_.end(), canonical) != open_files_.end()) {
    throw SceneFileError(path.string(), 0, "<include>", "the file includes itself");
  }
  open_files_.push_back(canonical);
  const std::string text = file_bytes(path);
  const LineIndex lines(text);
  const auto name = std::make_shared<const std::string>(path.string());
  pugi::xml_document xml;
  const pugi::xml_parse_result result = xml.load_buffer(text.data(), text.size());
  if (!result) {
    throw SceneFileError(*name, lines.line_of(result.offset), "",
                         std::string("malformed XML: ") + result.description());
  }
  const pugi::xml_node scene = xml.document_element();
  root.file = name;
  root.line = lines.line_of(scene.offset_debug());
  root.tag = canonical_tag(scene.name());
  read_attributes(scene, root);
  if (root.tag != "scene") fail(root, "the outermost element must be <scene>");
  read_children(scene, root, lines, 0);
  open_files_.pop_back();
}

void Reader::read_children(const pugi::xml_node& node, Element& parent, const LineIndex& lines, int depth) {
  if (depth > k_max_nesting) fail(parent, "elements are nested too deeply");
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() == pugi::node_element) read_child(child, parent, lines, depth);
    const bool is_text = child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata;
    if (is_text) fail(parent, "unexpected text '" + std::string(child.value()).substr(0, 40) + "'");
  }
}

void Reader::read_child(const pugi::xml_node& node, Element& parent, const LineIndex& lines, int depth) {
  auto element = std::make_unique<Element>();
  element->file = parent.file;
  element->line = lines.line_of(node.offset_debug());
  element->tag = canonical_tag(node.name());
  read_attributes(node, *element);
  if (element->tag == "default") return set_default(*element);
  if (element->tag == "include") return include(*element, parent);
  if (element->tag == "path") return add_search_path(*element);
  read_children(node, *element, lines, depth + 1);
  parent.children.push_back(std::move(element));
}

void Reader::read_attributes(const pugi::xml_node& node, Element& element) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const bool is_first = element.attributes.emplace(attribute.name(), substitute(element, attribute.value())).second;
    if (!is_first) fail(element, std::string("attribute '") + attribute.name() + "' is given twice");
  }
}

void Reader::set_default(const Element& directive) {
  const std::string& name = directive.get("name");
  if (name.empty() || !directive.has("value")) fail(directive, "needs a name and a value");
  parameters_.emplace(name, directive.get("value"));  // an earlier definition wins
}

void Reader::include(const Element& directive, Element& parent) {
  if (parent.tag != "scene") fail(directive, "may only stand directly inside of <scene>");
  if (++includes_ > k_max_includes) fail(directive, "more than 1000 files are included");
  const fs::path path = document_.resolve(directive, directive.get("filename"));
  Element included;
  read_file(path, included);
  for (std::unique_ptr<Element>& child : included.children) parent.children.push_back(std::move(child));
}

void Reader::add_search_path(const Element& directive) {
  const fs::path value = directive.get("value");
  const fs::path folder = value.is_absolute() ? value : document_.search_paths.front() / value;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) fail(directive, "no such folder: " + folder.string());
  document_.search_paths.push_back(folder);
}

void Reader::set_version(const Element& root) {
  const std::string& version = root.get("version");
  if (version.empty()) fail(root, "needs a version attribute");
  const auto [end, code] = std::from_chars(version.data(), version.data() + version.size(), document_.major_version);
  const bool is_number = code == std::errc() && (end == version.data() + version.size() || *end == '.');
  if (!is_number || document_.major_version < 0 || document_.major_version > 3) {
    fail(root, "version '" + version + "' is not supported; supported are 0.4 to 3.x");
  }
}

std::string Reader::substitute(const Element& element, const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] != '$') {
      result += text[i++];
      continue;
    }
    std::size_t end = i + 1;
    while (end < text.size() && is_name_character(text[end])) ++end;
    const std::string name = text.substr(i + 1, end - i - 1);
    const auto found = parameters_.find(name);
    if (found == parameters_.end()) {
      fail(element, "parameter '$" + name + "' has no value; give it with -D " + name + "=VALUE");
    }
    used_.insert(name);
    result += found->second;
    if (result.size() > k_max_text) fail(element, "parameter '$" + name + "' grows beyond all measure");
    i = end;
  }
  return result;
}

std::string Reader::known() const {
  std::vector<std::string> names;
  for (const std::string& name : used_) names.push_back(name);
  return names.empty() ? "none" : listed(names);
}

}  // namespace

const std::string& Element::get(std::string_view attribute) const {
  static const std::string k_none;
  const auto found = attributes.find(attribute);
  return found == attributes.end() ? k_none : found->second;
}

std::string Element::describe() const {
  std::string text = "<" + tag;
  for (const char* attribute : {"type", "name", "id"}) {
    if (has(attribute)) text += std::string(" ") + attribute + "=\"" + get(attribute) + "\"";
  }
  return text + ">";
}

void fail(const Element& element, std::string_view reason) {
  throw SceneFileError(element.file ? *element.file : "", element.line, element.describe(), reason);
}

fs::path Document::resolve(const Element& element, const std::string& name) const {
  if (name.empty()) fail(element, "needs a file name");
  std::error_code ignored;
  // Later <path> elements come first, the folder of the scene file last.
  for (auto folder = search_paths.rbegin(); folder != search_paths.rend(); ++folder) {
    const fs::path candidate = *folder / name;  // an absolute name replaces the folder
    if (fs::exists(candidate, ignored)) return candidate;
  }
  fail(element, "no such file: " + name);
}

Document read_document(const fs::path& path, const Definitions& definitions) {
  Document document;
  Reader reader(document, definitions);
  reader.read_top(path);
  reader.require_all_used(definitions, path);
  return document;
}

std::string snake_case(std::string_view name) {
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool starts_word =
        std::isupper(c) != 0 && i > 0 && std::islower(static_cast<unsigned char>(name[i - 1])) != 0;
    if (starts_word) result += '_';
    result += static_cast<char>(std::tolower(c));
  }
  return result;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace manylight::scene_file
