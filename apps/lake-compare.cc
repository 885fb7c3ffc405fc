// lake-compare: the misalignment between a human's and an exoskeleton's knee in sit-to-stand.
#include "lake/compare/misalignment.h"
#include "lake/core/error.h"
#include "lake/pipeline/compare.h"
#include "program.h"

namespace {

std::string Report(const lake::Json& summary) {
  const lake::Json& metrics = summary["metrics"];
  const lake::Json& parts = summary["decomposition"];
  const auto number = [](const lake::Json& value) {
    return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
  };
  const auto part = [&](const char* name) { return 100 * number(parts[name]["fraction"]); };
  std::string text =
      fmt::format("misalignment {:.2f} mm RMS, {:.2f} mm at most; relative error {:.2f} % RMS, {:.2f} % at most\n",
                  number(metrics["rms_mm"]), number(metrics["max_mm"]), 100 * number(metrics["relative_rms"]),
                  100 * number(metrics["relative_max"]));
  if (summary.contains("intervals")) {
    const lake::Json& interval = summary["intervals"]["relative_rms"];
    text += fmt::format("95 % interval of the relative error {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                        100 * number(interval[0]), 100 * number(interval[1]),
                        100 * number(summary["noise_floor_relative"]));
  }
  text += fmt::format("placement {:.1f} %, timing {:.1f} %, shape {:.1f} %\n", part("placement"), part("timing"),
                      part("shape"));
  const lake::Json& joint = summary["mount_mm"].is_array() ? summary["mount_mm"] : parts["offset_mm"];
  return text +
         fmt::format("the exoskeleton's joint sits {}\n", lake::DescribeJoint({number(joint[0]), number(joint[1])}));
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-compare", "The misalignment between a human's and an exoskeleton's knee in sit-to-stand",
                        "lake-compare track/human track/exo --human-knee knee --exo-knee exo_knee -o comparison");
  lake::CompareRunOptions options;
  std::string human, exo, map, exo_map, up, forward, exo_knee;
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
  cli.add_option("--resamples", options.misalignment.resamples, "of the bootstrap intervals; 0: none");
  cli.add_option("--seed-number", options.misalignment.seed, "of the bootstrap");
  return program.Main(
      argc, argv, [] { return std::string("comparison"); },
      [&](lake::Run& run) {
        options.human = human, options.exo = exo;
        if (!exo_knee.empty()) options.exo_knee = exo_knee;
        options.human_reading.names = lake::ParseNameMap(map);
        options.exo_reading.names = lake::ParseNameMap(exo_map.empty() ? map : exo_map);
        for (lake::TrialOptions* reading : {&options.human_reading, &options.exo_reading}) {
          reading->up = lake::ParseUp(up);
          reading->forward = forward;
        }
        return lake::RunCompare(options, run);
      },
      Report);
}
