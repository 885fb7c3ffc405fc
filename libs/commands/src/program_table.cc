#include "program_table.h"

#include "lake/core/angles.h"
#include "lake/core/csv.h"

namespace lake::commands {

void WriteProgramTable(const redesign::DesignInMotion& design, const redesign::HumanMotion& human,
                       const std::filesystem::path& path) {
  CsvWriter table({"percent", "time_s", "stroke_mm", "knee_deg", "human_knee_deg"});
  for (std::size_t i = 0; design.prediction && i < human.size(); ++i) {
    const double percent = static_cast<double>(i);
    table.AddRow(i, design.duration_s * percent / 100, design.prediction->stroke_mm[i],
                 DegreesFromRadians(design.prediction->theta_rad[i]), DegreesFromRadians(human[i].knee_rad));
  }
  table.Write(path);
}

void WarnWithoutLimit(const redesign::MotionLimits& limits, Run& run) {
  if (!redesign::kMisalignment.Counts(limits))
    run.Warn(
        "neither --max-misalignment nor --penalty is given, so only the range is optimised; give one of them to limit "
        "the misalignment");
}

}  // namespace lake::commands
