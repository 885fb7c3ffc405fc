// The options of a stroke program, its firmware and a duty table.
#pragma once

#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/firmware.h"
#include "lake/actuator/stroke_schedule.h"
#include "lake/core/options.h"

namespace lake::actuator {

void Describe(ScheduleOptions& o, OptionList& options);

// All but the dead time, which is the schedule's.
void Describe(FirmwareOptions& o, OptionList& options);

void Describe(CalibrateOptions& o, OptionList& options);

}  // namespace lake::actuator
