#include "places.h"

#include <cstdlib>

namespace lake {
namespace {

std::filesystem::path Said(const char* variable, const char* configured) {
  const char* said = std::getenv(variable);
  return said ? said : configured;
}

}  // namespace

std::filesystem::path SourceDir() {
  return Said("LAKE_SOURCE", LAKE_SOURCE_DIR);
}
std::filesystem::path BinDir() {
  return Said("LAKE_BIN", LAKE_BIN_DIR);
}
std::filesystem::path SharedData() {
  return LAKE_SHARED_DATA;
}

}  // namespace lake
