#include "fuzz_reader.h"
#include "lake/motion/corrections.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".csv", [](const std::filesystem::path& path) {
    lake::motion::ReadCorrections(path, {"ankle", "knee", "hip"}, 640, 360);
  });
}
