// lake-calibrate: a camera from pictures of a board; the sagittal plane from one picture; boards to print.
#include <fmt/format.h>

#include <functional>
#include <string>

#include "lake/commands/calibrate.h"
#include "program.h"

namespace lake {
namespace {

std::string Report(const Json& s) {
  if (s.contains("file"))
    return fmt::format("{} on {}: print it at 100 %\n", s["file"].get<std::string>(), s["paper"].get<std::string>());
  if (s.contains("plane_rms_px"))
    return fmt::format("plane at {:.0f} mm, {:.3f} mm/px in the middle, RMS {:.3f} px\n",
                       s["distance_mm"].get<double>(), s["mm_per_px"].get<double>(), s["plane_rms_px"].get<double>());
  const Json &camera = s["camera"], &sd = s["standard_deviations"];
  const auto number = [](const Json& json, const char* key) { return json[key].get<double>(); };
  return fmt::format(
      "{} views, RMS {:.3f} px (inliers {:.3f} px, {} outliers), worst view {} {:.3f} px\n"
      "fx {:.2f} ± {:.2f}  fy {:.2f} ± {:.2f}  cx {:.2f} ± {:.2f}  cy {:.2f} ± {:.2f} px\n"
      "coverage {:.0f} %, largest tilt {:.0f}°{}; lens model {}\n",
      s["views"].size(), number(s, "rms_px"), number(s, "inlier_rms_px"), s["outliers"].size(),
      s["worst_view"].get<std::string>(), number(s, "worst_view_rms_px"), number(camera, "fx"), number(sd, "fx"),
      number(camera, "fy"), number(sd, "fy"), number(camera, "cx"), number(sd, "cx"), number(camera, "cy"),
      number(sd, "cy"), 100 * number(s, "coverage"), number(s, "largest_tilt_deg"),
      s.contains("cross_validation")
          ? fmt::format(", odd and even views differ by {:.3f} px RMS", number(s["cross_validation"], "rms_px"))
          : "",
      s["lens"]["model"].get<std::string>());
}

}  // namespace
}  // namespace lake

int main(int argc, char** argv) {
  using namespace lake;
  Program program("lake-calibrate", "A camera from pictures of a board, with error bars",
                  "lake-calibrate board/*.jpg --board chessboard:9x6:25 -o camera");
  commands::CalibrateRunOptions calibrate;
  commands::PlaneRunOptions plane;
  commands::SheetRunOptions sheet;
  program.Add(OptionsOf(calibrate));
  const std::function<bool()> plane_command = program.AddCommand(
      "plane", "The sagittal plane from one board image or four and more known points",
      "lake-calibrate plane board.png --camera camera.yaml --board chessboard:9x6:25 -o plane", OptionsOf(plane));
  const std::function<bool()> sheet_command =
      program.AddCommand("board", "A board to print, as PDF 1:1",
                         "lake-calibrate board --board chessboard:9x6:25 --paper a4 -o print", OptionsOf(sheet));
  return program.Main(
      argc, argv, [] { return "calibrate"; },
      [&](Run& run) {
        if (plane_command()) return commands::RunPlane(plane, run);
        if (sheet_command()) return commands::RunSheet(sheet, run);
        return commands::RunCalibrate(calibrate, run);
      },
      Report);
}
