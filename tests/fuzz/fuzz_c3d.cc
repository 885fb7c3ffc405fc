#include "fuzz_reader.h"
#include "lake/exchange/c3d.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".c3d", [](const std::filesystem::path& path) { lake::exchange::ReadC3d(path); });
}
