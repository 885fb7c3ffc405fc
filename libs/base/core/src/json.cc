#include "lake/core/json.h"

#include <limits>
#include <string_view>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake {

namespace {

// The library's words without its number, "[json.exception.parse_error.101] ".
std::string_view PlainWords(std::string_view what) {
  const std::size_t end = what.find("] ");
  return what.starts_with('[') && end != std::string_view::npos ? what.substr(end + 2) : what;
}

}  // namespace

Json ReadJsonFile(const std::filesystem::path& path) {
  try {
    return Json::parse(ReadTextFile(path));
  } catch (const Json::parse_error& error) {
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
