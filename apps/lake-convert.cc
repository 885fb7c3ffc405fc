// lake-convert: a trial in another program's format. Writes one file, so it has no folder of results.
#include <fmt/format.h>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/exchange/convert.h"
#include "program.h"

int main(int argc, char** argv) {
  CLI::App cli(
      "A trial in another program's format. The ending of OUT says which:\n"
      "  .trc          OpenSim, Pose2Sim: 3-D, y up\n"
      "  .c3d          Vicon, Qualisys, Visual3D\n"
      "  .txt, .trk    Tracker: table in mm or px; project over the video (px)\n"
      "  _kinovea.csv, .kva   Kinovea: table; annotations over the video (px)\n"
      "  .csv          lake\n"
      "  .mot, .sto    OpenSim: knee angle and tilts, from kinematics.csv or a folder that has one",
      "lake-convert");
  cli.footer(
      "Examples:\n"
      "  lake-convert walking.c3d walking.trc --forward +x\n"
      "  lake-convert trial.trc side.csv --map ankle=RANK,knee=RKNE,hip=RHIP --crop 2.5,6\n"
      "  lake-convert lake-out/human human.mot --flexion-negative");
  std::string in, out, map, up, crop;
  lake::exchange::ConvertOptions options;
  cli.add_option("in", in, "A lake-track or lake-gait folder, or .trc, .c3d, .trk, .trz, .kva, .txt, .csv, .mot, .sto")
      ->required();
  cli.add_option("out", out, "The file to write")->required();
  cli.add_option("--map", map, "NAME=MARKER,…: only these markers, under these names; A+B is the middle of two");
  cli.add_option("--units", options.unit, "mm, cm or m: of a .trc that is written")->capture_default_str();
  cli.add_option("--up", up, "x, y or z: vertical axis of a 3-D input (default: TRC y, C3D its own or z)");
  cli.add_option("--forward", options.reading.forward,
                 "+x, -x, …: where the subject faces in a 3-D input; then x is forward, y up, z to the right");
  cli.add_option("--crop", crop, "START,END: keep these seconds only");
  cli.add_option("--mm-per-unit", options.reading.mm_per_unit,
                 "Of inputs that do not say their unit (Tracker text, Kinovea's CSV)")
      ->capture_default_str();
  cli.add_option("--rate", options.reading.rate_hz, "Hz, of inputs without times (DLTdv)");
  bool smoothed = false;
  cli.add_flag("--smoothed", smoothed, "Write the fit's estimates of a trajectory.csv, not from the measurements");
  cli.add_flag("--flexion-negative", options.flexion_negative,
               "Knee angle of a .mot as OpenSim's older models have it");
  return lake::ParseAndRun(cli, argc, argv, [&] {
    options.reading.names = lake::exchange::ParseNameMap(map);
    if (smoothed) options.reading.values = lake::motion::MarkerValues::kEstimated;
    options.reading.up = lake::exchange::ParseUp(up);
    if (!(options.reading.mm_per_unit > 0))
      throw lake::UsageError(fmt::format("--mm-per-unit {}: not positive", options.reading.mm_per_unit));
    if (!crop.empty()) {
      const std::vector<double> ends = lake::ParseNumbers(crop, 2, "--crop");
      options.crop_s = {ends[0], ends[1]};
    }
    for (const std::string& warning : lake::exchange::ConvertFile(in, out, options))
      fmt::print(stderr, "lake-convert: warning: {}\n", warning);
    return 0;
  });
}
