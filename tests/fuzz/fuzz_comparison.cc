#include "fuzz_reader.h"
#include "lake/compare/comparison_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".json",
                         [](const std::filesystem::path& path) { lake::compare::ReadComparison(path); });
}
