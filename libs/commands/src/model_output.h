// The angle that another program's model worked out, beside the knee angle of the same recording.
#pragma once

#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/motion/leg_motion.h"

namespace lake::commands {

// Degrees of the first component of the output called `name` in each frame, NaN where missing. Throws Error listing the
// outputs of the file if it has none of this name, and for one that is no angle.
std::vector<double> ModelAngle(const exchange::Trial& trial, const std::string& name);

// Writes model_output.csv, and puts `compare_with` into the results: over the frames that have both, the mean of knee
// angle − output, the standard deviation about it, and the correlation of the two.
void WriteModelOutput(const std::string& name, const std::vector<double>& model_deg, const motion::LegMotion& motion,
                      Json& results, Run& run);

}  // namespace lake::commands
