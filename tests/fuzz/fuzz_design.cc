#include "fuzz_reader.h"
#include "lake/linkage/design_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".yaml",
                         [](const std::filesystem::path& path) { lake::linkage::ReadDesign(path); });
}
