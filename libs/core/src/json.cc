#include "lake/core/json.h"

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake {

Json ReadJsonFile(const std::filesystem::path& path) {
  try {
    return Json::parse(ReadTextFile(path));
  } catch (const Json::parse_error& error) {
    throw Fail("{}: not JSON: {}", path.string(), error.what());
  }
}

void WriteJsonFile(const std::filesystem::path& path, const Json& value) {
  WriteTextFile(path, value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace lake
