#define TOML_ASSERT(expression) static_cast<void>(0)  // damaged files reach its assertions, and then its errors
#include <toml++/toml.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>

#include "camera_formats.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/yaml.h"

namespace lake::camera {
namespace {

bool IsSame(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// Elements of one name become a list.
Json TreeOf(const pugi::xml_node& node, const std::string& where, int depth = 0) {
  constexpr int kDeepest = 100;
  if (depth > kDeepest) throw Fail("{}: elements stand more than {} deep in each other", where, kDeepest);
  Json tree = Json::object();
  for (const pugi::xml_attribute attribute : node.attributes()) tree[attribute.name()] = attribute.value();
  for (const pugi::xml_node child : node.children()) {
    if (child.type() != pugi::node_element) continue;
    Json value = TreeOf(child, where, depth + 1);
    Json& known = tree[child.name()];
    if (known.is_null())
      known = std::move(value);
    else if (known.is_array())
      known.push_back(std::move(value));
    else
      known = Json::array({std::move(known), std::move(value)});
  }
  return tree.empty() ? Json(node.text().as_string()) : tree;
}

void AppendNumbers(const Json& value, const std::string& what, std::vector<double>& numbers) {
  if (value.is_number()) {
    numbers.push_back(value);
  } else if (value.is_array()) {
    for (const Json& element : value) AppendNumbers(element, what, numbers);
  } else if (const Json* data = FindKey(value, "data")) {
    AppendNumbers(*data, what, numbers);
  } else if (value.is_string()) {
    std::istringstream words(value.get<std::string>());
    for (std::string word; words >> word;) {
      const std::optional<double> number = ParseNumber(word);
      if (!number) throw Fail("{} holds '{}', not a finite number", what, word);
      numbers.push_back(*number);
    }
  } else {
    throw Fail("{} holds something else than numbers", what);
  }
}

}  // namespace

Json ReadTree(const std::filesystem::path& path) {
  constexpr std::size_t kMostBytes = 1 << 24;
  std::string text = ReadTextFile(path, kMostBytes);
  // A byte order mark may stand before it, and the letters of UTF-16 are two bytes.
  const std::size_t first = text.find_first_not_of(std::string_view(" \t\r\n\xEF\xBB\xBF\xFF\xFE\0", 10));
  if (first == std::string::npos) throw Fail("{}: is empty", path.string());
  if (text[first] == '<') {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
    if (!parsed)
      throw Fail("{}: not XML, or cut off: {} at byte {}", path.string(), parsed.description(), parsed.offset);
    return TreeOf(document.document_element(), path.string());
  }
  if (IsSame(path.extension().string(), ".toml")) try {
      std::ostringstream json;
      json << toml::json_formatter(toml::parse(text));
      return Json::parse(json.str());
    } catch (const toml::parse_error& error) {
      throw Fail("{}:{}: not TOML: {}", path.string(), error.source().begin.line, error.description());
    }
  if (text[first] == '%') std::replace(text.begin(), text.begin() + 1, '%', '#');  // OpenCV's "%YAML:1.0"
  return YamlNode::ReadText(text, path).ToJson();
}

const Json* FindKey(const Json& map, std::string_view key) {
  if (!map.is_object()) return nullptr;
  for (const auto& [name, value] : map.items())
    if (IsSame(name, key)) return &value;
  return nullptr;
}

std::vector<double> NumbersAt(const Json& map, std::string_view key, const std::string& where, std::size_t count) {
  std::vector<double> numbers;
  if (key.empty()) return numbers;
  const Json* value = FindKey(map, key);
  if (!value) throw Fail("{}: no key '{}'", where, key);
  AppendNumbers(*value, fmt::format("{}: '{}'", where, key), numbers);
  const Json *data = FindKey(*value, "data"), &list = data ? *data : *value;
  const bool says_none = list.is_array() && list.empty();  // not one that is cut off
  if ((numbers.empty() && !says_none) || (count > 0 && numbers.size() != count))
    throw Fail("{}: '{}' has {} numbers, not {}", where, key, numbers.size(), std::max<std::size_t>(count, 1));
  return numbers;
}

}  // namespace lake::camera
