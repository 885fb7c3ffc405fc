#include "fuzz_reader.h"
#include "lake/exchange/mot.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".mot", [](const std::filesystem::path& path) { lake::exchange::ReadMot(path); });
}
