// lake-compare: the misalignment between a human's and an exoskeleton's knee in sit-to-stand.
#include <cmath>
#include <limits>
#include <string>

#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/compare/misalignment.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "program.h"

namespace {

std::string Report(const lake::Json& summary) {
  const lake::Json& metrics = summary["metrics"];
  const lake::Json& parts = summary["decomposition"];
  using lake::NumberOrNaN;
  const auto part = [&](const char* name) { return 100 * NumberOrNaN(parts[name]["fraction"]); };
  std::string text =
      fmt::format("misalignment {:.2f} mm RMS, {:.2f} mm at most; relative error {:.2f} % RMS, {:.2f} % at most\n",
                  NumberOrNaN(metrics["rms_mm"]), NumberOrNaN(metrics["max_mm"]),
                  100 * NumberOrNaN(metrics["relative_rms"]), 100 * NumberOrNaN(metrics["relative_max"]));
  if (summary.contains("intervals")) {
    const lake::Json& interval = summary["intervals"]["relative_rms"];
    text += fmt::format("95 % interval of the relative error {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                        100 * NumberOrNaN(interval[0]), 100 * NumberOrNaN(interval[1]),
                        100 * NumberOrNaN(summary["noise_floor_relative"]));
  }
  if (!std::isfinite(part("placement"))) return text + "both paths are one: there are no parts\n";
  text += fmt::format("placement {:.1f} %, timing {:.1f} %, shape {:.1f} %\n", part("placement"), part("timing"),
                      part("shape"));
  const lake::Json& joint = summary["mount_mm"].is_array() ? summary["mount_mm"] : parts["offset_mm"];
  return text + fmt::format("the exoskeleton's joint sits {}\n",
                            lake::compare::DescribeJoint({NumberOrNaN(joint[0]), NumberOrNaN(joint[1])}));
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-compare", "The misalignment between a human's and an exoskeleton's knee in sit-to-stand",
                        "lake-compare track/human track/exo --human-knee knee --exo-knee exo_knee -o comparison");
  lake::commands::CompareRunOptions options;
  std::string human, exo, map, exo_map, up, forward, exo_knee, unit = "mm", exo_unit;
  CLI::App& cli = program.Cli();
  cli.add_option(
         "human", human,
         "A lake-track folder, .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker), or a comparison's folder")
      ->required();
  cli.add_option("exo", exo, "The trial with the exoskeleton, likewise, or lake-optimize's predicted/")->required();
  cli.add_option("--human-knee", options.human_knee, "The compared marker of the human trial");
  cli.add_option("--exo-knee", exo_knee, "The compared marker of the exoskeleton trial (default: exo_knee, else knee)");
  cli.add_option(
      "--replacement-sd", options.misalignment.replacement_sd_mm,
      "mm per axis: how well a marker is put back on the same spot between trials; 0 when both are in one recording");
  cli.add_option("--map", map,
                 "ankle=NAME,knee=NAME,hip=NAME,waist=NAME: the markers of files; A+B is the middle of two");
  cli.add_option("--exo-map", exo_map, "The same for the exoskeleton trial (default: as --map)");
  cli.add_option("--up", up, "x, y or z: vertical axis of 3-D files (default: TRC y, C3D its own or z)");
  cli.add_option("--forward", forward, "+x, -x, …: where the subject faces (default: found from the movement)");
  cli.add_option("--unit", unit, "mm, cm or m: of files that do not say (Tracker text, Kinovea)");
  cli.add_option("--exo-unit", exo_unit, "The same for the exoskeleton trial (default: as --unit)");
  bool smoothed = false;
  cli.add_flag("--smoothed", smoothed, "Start from the fit's estimates of a trajectory.csv, not from the measurements");
  cli.add_option("--resamples", options.misalignment.resamples, "of the bootstrap intervals; 0: none");
  cli.add_option("--seed-number", options.misalignment.seed, "of the bootstrap");
  return program.Main(
      argc, argv, [] { return std::string("comparison"); },
      [&](lake::Run& run) {
        options.human = human, options.exo = exo;
        if (!exo_knee.empty()) options.exo_knee = exo_knee;
        options.human_reading.names = lake::exchange::ParseNameMap(map);
        options.exo_reading.names = lake::exchange::ParseNameMap(exo_map.empty() ? map : exo_map);
        for (lake::exchange::TrialOptions* reading : {&options.human_reading, &options.exo_reading}) {
          reading->up = lake::exchange::ParseUp(up);
          reading->forward = forward;
          if (smoothed) reading->values = lake::motion::MarkerValues::kEstimated;
        }
        options.human_reading.mm_per_unit = lake::commands::MmPerUnit(unit);
        options.exo_reading.mm_per_unit = lake::commands::MmPerUnit(exo_unit.empty() ? unit : exo_unit);
        return lake::commands::RunCompare(options, run);
      },
      Report);
}
