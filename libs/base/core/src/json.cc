#include "lake/core/json.h"

#include <limits>
#include <string_view>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake {
namespace {

// The library writes values by recursion, a level of the stack each.
void CheckDepth(const std::string& text, const std::filesystem::path& path) {
  constexpr int kDeepest = 200;  // far beyond any file of ours
  int depth = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      is_string = !is_string;
    } else if (!is_string) {
      depth += (c == '[' || c == '{') - (c == ']' || c == '}');
      if (depth > kDeepest)
        throw Fail("{}: lists and maps stand more than {} deep in each other", path.string(), kDeepest);
    }
  }
}

// The library's words without its number, "[json.exception.parse_error.101] ".
std::string_view PlainWords(std::string_view what) {
  const std::size_t end = what.find("] ");
  return what.starts_with('[') && end != std::string_view::npos ? what.substr(end + 2) : what;
}

}  // namespace

Json ReadJsonFile(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  CheckDepth(text, path);
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {  // also a number beyond all numbers
    throw Fail("{}: not JSON: {}", path.string(), PlainWords(error.what()));
  }
}

void WriteJsonFile(const std::filesystem::path& path, const Json& value) {
  WriteTextFile(path, value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

double NumberOrNaN(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

std::vector<double> NumbersOrNaN(const Json& values) {
  std::vector<double> numbers;
  for (const Json& value : values) numbers.push_back(NumberOrNaN(value));
  return numbers;
}

}  // namespace lake
