#include "fuzz_reader.h"
#include "lake/exchange/trc.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".trc", [](const std::filesystem::path& path) { lake::exchange::ReadTrc(path); });
}
