#include "model_output.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::commands {

std::vector<double> ModelAngle(const exchange::Trial& trial, const std::string& name) {
  const auto found = std::ranges::find(trial.outputs, name, &exchange::ModelOutput::name);
  std::vector<std::string> names;
  for (const exchange::ModelOutput& output : trial.outputs) names.push_back(output.name);
  if (found == trial.outputs.end())
    throw Fail("--compare-with {}: {} has no such output of a model; it has: {}", name, trial.file.string(),
               names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")));
  if (found->kind != "angle")
    throw Fail("--compare-with {}: is a {} ({}), not an angle", name, found->kind, found->unit);
  const bool in_radians = found->unit.starts_with("rad");
  std::vector<double> angle_deg;
  for (const Eigen::Vector3d& value : found->positions)
    angle_deg.push_back(in_radians ? DegreesFromRadians(value.x()) : value.x());
  return angle_deg;
}

void WriteModelOutput(const std::string& name, const std::vector<double>& model_deg, const motion::LegMotion& motion,
                      Json& results, Run& run) {
  CsvWriter table({"frame", "time_s", "knee_deg", "model_deg", "difference_deg"});
  std::vector<double> ours, theirs, difference;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const double knee_deg = motion.samples[i].knee_deg, other_deg = model_deg.at(i);
    table.AddRow(motion.frame[i], motion.time_s[i], knee_deg, other_deg, knee_deg - other_deg);
    if (!std::isfinite(knee_deg - other_deg)) continue;
    ours.push_back(knee_deg);
    theirs.push_back(other_deg);
    difference.push_back(knee_deg - other_deg);
  }
  if (difference.size() < 2) throw Fail("--compare-with {}: no frames have both it and a knee angle", name);
  if (!(StandardDeviation(theirs) > 0))
    throw Fail("--compare-with {}: is {:g}° in all frames: was it worked out?", name, theirs.front());
  const double mean_ours = Mean(ours), mean_theirs = Mean(theirs);
  double product = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) product += (ours[i] - mean_ours) * (theirs[i] - mean_theirs);
  const double offset_deg = Mean(difference), sd_deg = StandardDeviation(difference),
               correlation = product / static_cast<double>(ours.size() - 1) /
                             (StandardDeviation(ours) * StandardDeviation(theirs));
  table.Write(run.Result("model_output.csv"));
  results["compare_with"] = {{"name", name},
                             {"frames", difference.size()},
                             {"offset_deg", offset_deg},
                             {"sd_deg", sd_deg},
                             {"correlation", correlation}};
  run.Report("knee angle − {}: {:.1f}° on average, ± {:.1f}° about that (1 SD over {} frames), correlation {:.4f}\n",
             name, offset_deg, sd_deg, difference.size(), correlation);
}

}  // namespace lake::commands
