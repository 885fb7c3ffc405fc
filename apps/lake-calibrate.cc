// lake-calibrate: a camera from pictures of a board; the sagittal plane from one picture; boards to print.
#include <fmt/format.h>

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
      "coverage {:.0f} %, largest tilt {:.0f}°{}\n",
      s["views"].size(), number(s, "rms_px"), number(s, "inlier_rms_px"), s["outliers"].size(),
      s["worst_view"].get<std::string>(), number(s, "worst_view_rms_px"), number(camera, "fx"), number(sd, "fx"),
      number(camera, "fy"), number(sd, "fy"), number(camera, "cx"), number(sd, "cx"), number(camera, "cy"),
      number(sd, "cy"), 100 * number(s, "coverage"), number(s, "largest_tilt_deg"),
      s.contains("cross_validation")
          ? fmt::format(", odd and even views differ by {:.3f} px RMS", number(s["cross_validation"], "rms_px"))
          : "");
}

constexpr const char* kBoardHelp =
    "chessboard:COLSxROWS:SQUARE_MM (inner corners) or charuco:COLSxROWS:SQUARE_MM:MARKER_MM:DICT (squares)";

void BindCalibrate(CLI::App& cli, commands::CalibrateRunOptions& a, std::string& loss) {
  cli.add_option("pictures", a.pictures, "Images of the board, or one video of a moving board")
      ->type_name("IMAGES|VIDEO");
  cli.add_option("--board", a.board, kBoardHelp);
  cli.add_option("--loss", loss, "robust, or squared as OpenCV")->check(CLI::IsMember({"robust", "squared"}));
  cli.add_flag("--fix-k3", a.calibration.fix_k3, "k3 = 0, for views that leave the corners of the picture empty");
  cli.add_flag("--square-pixels", a.calibration.square_pixels, "fx = fy");
  cli.add_option("--max-views", a.find.most_views, "Of a video: how many sharp, spread frames to use")
      ->check(CLI::Range(3, 200));
}

CLI::App* BindPlane(CLI::App& cli, commands::PlaneRunOptions& a) {
  CLI::App* sub = cli.add_subcommand("plane", "The sagittal plane from one board image or four and more known points");
  sub->add_option("image", a.picture, "The picture")->required()->type_name("IMAGE");
  sub->add_option("--camera", a.camera, "camera.yaml of this camera")->required()->type_name("FILE");
  sub->add_option("--board", a.board, kBoardHelp);
  sub->add_option("--points", a.points, "\"X,Y=XMM,YMM; …\": pixels and millimetres, x right, y up");
  sub->add_option("--click-sigma", a.click_sigma_px, "How well a point of --points is known, px")
      ->check(CLI::PositiveNumber);
  sub->footer("Example:\n  lake-calibrate plane board.png --camera camera.yaml --board chessboard:9x6:25 -o plane");
  sub->fallthrough();
  return sub;
}

CLI::App* BindSheet(CLI::App& cli, commands::SheetRunOptions& a) {
  CLI::App* sub = cli.add_subcommand("board", "A board to print, as PDF 1:1");
  sub->add_option("--board", a.board, kBoardHelp)->required();
  sub->add_option("--paper", a.paper, "a4, a3 or letter");
  sub->footer("Example:\n  lake-calibrate board --board chessboard:9x6:25 --paper a4 -o print");
  sub->fallthrough();
  return sub;
}

}  // namespace
}  // namespace lake

int main(int argc, char** argv) {
  using namespace lake;
  Program program("lake-calibrate", "A camera from pictures of a board, with error bars",
                  "lake-calibrate board/*.jpg --board chessboard:9x6:25 -o camera");
  commands::CalibrateRunOptions calibrate;
  std::string loss = "robust";
  commands::PlaneRunOptions plane;
  commands::SheetRunOptions sheet;
  BindCalibrate(program.Cli(), calibrate, loss);
  const CLI::App* plane_command = BindPlane(program.Cli(), plane);
  const CLI::App* sheet_command = BindSheet(program.Cli(), sheet);
  program.Cli().require_subcommand(0, 1);
  return program.Main(
      argc, argv, [] { return "calibrate"; },
      [&](Run& run) {
        if (plane_command->parsed()) return commands::RunPlane(plane, run);
        if (sheet_command->parsed()) return commands::RunSheet(sheet, run);
        calibrate.calibration.robust = loss == "robust";
        return commands::RunCalibrate(calibrate, run);
      },
      Report);
}
