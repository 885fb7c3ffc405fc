#include "fuzz_reader.h"
#include "lake/actuator/duty_calibration.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return lake::ReadBytes(data, size, ".csv",
                         [](const std::filesystem::path& path) { lake::actuator::ReadDutyLog(path, std::nullopt); });
}
