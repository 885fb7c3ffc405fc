// Pictures of the stroke program, of a duty calibration, and of a prototype held against its prediction.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/prototype_validation.h"
#include "lake/actuator/stroke_schedule.h"

namespace lake::figure {

// Stroke with its soft limits, speed with duty (if known), and knee angle over time.
void DrawStrokeProgram(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                       const std::vector<actuator::ScheduleRow>& rows);

// Speed over duty in both directions: plateaus, table with errors, the curve the program uses, dead band.
void DrawDutyCalibration(const std::filesystem::path& path, const actuator::DutyCalibration& calibration);

// The paper's last figure: knee angle over stroke, predicted and measured; beside it both over time, and their
// difference.
void DrawValidation(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                    const actuator::Validation& validation);

}  // namespace lake::figure
