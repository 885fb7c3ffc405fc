// Writes the stroke table with which the firmware's portable part is compiled into the tests.
#include "actuator/model_program.h"
#include "lake/actuator/firmware.h"
#include "lake/core/atomic_file.h"

int main(int, char** arguments) {
  lake::actuator::FirmwareOptions options;
  options.home_stroke_mm = 297, options.speed_tolerance_percent = 10;
  lake::WriteTextFile(arguments[1], lake::actuator::StrokeTableHeader(
                                        {lake::HostSchedule(), lake::ModelTable(), options}, "For tests."));
}
