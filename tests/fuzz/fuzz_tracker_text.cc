#include "fuzz_reader.h"
#include "lake/exchange/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".txt",
                         [](const std::filesystem::path& path) { lake::exchange::ReadPoints(path); });
}
