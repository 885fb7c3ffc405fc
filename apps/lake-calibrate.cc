// lake-calibrate: a camera from pictures of a board; the sagittal plane from one picture; boards to print.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/camera/board.h"
#include "lake/camera/board_pictures.h"
#include "lake/camera/board_sheet.h"
#include "lake/camera/calibration.h"
#include "lake/camera/calibration_quality.h"
#include "lake/camera/camera.h"
#include "lake/camera/plane_fit.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/render/calibration_figures.h"
#include "lake/video/image.h"
#include "program.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  std::vector<fs::path> pictures;
  std::string board;
  std::string loss = "robust";
  CalibrationOptions options;
  BoardPicturesOptions find;
};

struct PlaneArguments {
  fs::path picture, camera;
  std::string board, points;
  double click_sigma_px = 0.5;
};

struct SheetArguments {
  std::string board, paper = "a4";
};

std::vector<double> List(const auto& values) {
  return {values.begin(), values.end()};
}

Json CameraJson(const Camera& camera) {
  return {
      {"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}, {"distortion", camera.distortion}};
}

Json OutlierJson(const std::vector<BoardView>& views, const CalibrationResult& result) {
  Json outliers = Json::array();
  for (const CornerOutlier& o : result.outliers)
    outliers.push_back({{"view", views[o.view].name}, {"corner", o.corner}, {"error_px", o.error_px}});
  return outliers;
}

CornerOutlier WorstCorner(const std::vector<BoardView>& views, const CalibrationResult& result) {
  CornerOutlier worst;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t i = 0; i < views[v].corner.size(); ++i)
      if (const double error = result.residual_px[v][i].norm(); error > worst.error_px)
        worst = {v, views[v].corner[i], error};
  return worst;
}

Json ResultJson(const BoardPictures& pictures, const CalibrationResult& result, const CalibrationQuality& quality) {
  const CameraUncertainty sd = UncertaintyOf(result);
  const CornerOutlier worst = WorstCorner(pictures.views, result);
  Json views = Json::array();
  for (std::size_t v = 0; v < pictures.views.size(); ++v)
    views.push_back({{"name", pictures.views[v].name},
                     {"corners", pictures.views[v].corner.size()},
                     {"rms_px", result.view_rms_px[v]},
                     {"edge_width_px", pictures.views[v].edge_width_px}});
  Json json = {{"image_width", pictures.width_px},
               {"image_height", pictures.height_px},
               {"camera", CameraJson(result.camera)},
               {"standard_deviations",
                {{"fx", sd.intrinsics_sd[0]},
                 {"fy", sd.intrinsics_sd[1]},
                 {"cx", sd.intrinsics_sd[2]},
                 {"cy", sd.intrinsics_sd[3]},
                 {"distortion", sd.distortion_sd}}},
               {"rms_px", result.rms_px},
               {"inlier_rms_px", result.inlier_rms_px},
               {"sigma_px", result.sigma_px},
               {"seed_rms_px", result.seed_rms_px},
               {"worst_view", pictures.views[quality.worst_view].name},
               {"worst_view_rms_px", result.view_rms_px[quality.worst_view]},
               {"worst_corner",
                {{"view", pictures.views[worst.view].name}, {"corner", worst.corner}, {"error_px", worst.error_px}}},
               {"outliers", OutlierJson(pictures.views, result)},
               {"coverage", quality.coverage.fraction},
               {"largest_tilt_deg", quality.largest_tilt_deg},
               {"pictures_searched", pictures.attempts},
               {"boards_seen", pictures.seen},
               {"without_board", pictures.without_board},
               {"views", views},
               {"solver",
                {{"iterations", result.summary.iterations},
                 {"cost_before", result.summary.cost_before},
                 {"cost_after", result.summary.cost_after},
                 {"message", result.summary.message}}}};
  if (quality.cross_validation)
    json["cross_validation"] = {{"rms_px", quality.cross_validation->rms_px},
                                {"largest_px", quality.cross_validation->largest_px}};
  return json;
}

void WriteResiduals(const fs::path& path, const std::vector<BoardView>& views, const CalibrationResult& result) {
  CsvWriter table({"view", "corner", "x_px", "y_px", "dx_px", "dy_px"});
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v].corner.size(); ++i) {
      table.Add(views[v].name).Add(views[v].corner[i]).Add(views[v].pixel[i].x()).Add(views[v].pixel[i].y());
      table.Add(result.residual_px[v][i].x()).Add(result.residual_px[v][i].y()).EndRow();
    }
  }
  table.Write(path);
}

Json Calibrate(CalibrateArguments arguments, Run& run) {
  if (arguments.pictures.empty())
    throw UsageError("which pictures? name images or a video of the board; see lake-calibrate --help");
  if (arguments.board.empty()) throw UsageError("which board? e.g. --board chessboard:9x6:25");
  arguments.options.robust = arguments.loss == "robust";
  arguments.find.quiet = run.Quiet();
  const Board board = ParseBoard(arguments.board);
  for (const fs::path& picture : arguments.pictures)
    if (picture.string().find('%') == std::string::npos) run.AddInput(picture);
  const BoardPictures pictures = FindBoards(arguments.pictures, board, arguments.find);
  if (!pictures.without_board.empty())
    run.Warn(fmt::format("no board seen in {} of {} images, left out: {}", pictures.without_board.size(),
                         pictures.attempts, fmt::join(pictures.without_board, ", ")));

  const CalibrationResult result =
      CalibrateCamera(board, pictures.views, pictures.width_px, pictures.height_px, arguments.options);
  if (!result.summary.usable) throw SolverError("the bundle adjustment did not converge: " + result.summary.message);
  const CalibrationQuality quality = AssessCalibration(board, pictures.views, result, arguments.options);
  for (const std::string& warning : quality.warnings) run.Warn(warning);

  WriteCameraProfile(run.Result("camera.yaml"), {result.camera, {}, UncertaintyOf(result), {}});
  WriteResiduals(run.Result("residuals.csv"), pictures.views, result);
  WriteResidualFigure(run.Result("residuals.png"), pictures.views, result);
  if (quality.cross_validation)
    WriteCrossValidationFigure(run.Result("cross_validation.png"), *quality.cross_validation, pictures.width_px,
                               pictures.height_px);
  return ResultJson(pictures, result, quality);
}

std::vector<PlaneCorrespondence> CheckedPoints(const std::string& text, const Camera& camera) {
  const std::vector<PlaneCorrespondence> points = ParsePlanePoints(text);
  for (const auto& p : points)
    if (p.pixel.x() < -0.5 || p.pixel.y() < -0.5 || p.pixel.x() > camera.image_width - 0.5 ||
        p.pixel.y() > camera.image_height - 0.5)
      throw UsageError(fmt::format("--points: pixel {},{} is outside the picture of {}x{}", p.pixel.x(), p.pixel.y(),
                                   camera.image_width, camera.image_height));
  return points;
}

PlaneFit FitPlaneOf(const PlaneArguments& arguments, const Camera& camera) {
  const cv::Mat grey = ReadImage(arguments.picture, false);
  CheckResolution(camera, arguments.camera, grey.cols, grey.rows, arguments.picture);
  if (!arguments.points.empty())
    return FitPlane(camera, CheckedPoints(arguments.points, camera), {arguments.click_sigma_px});
  const Board board = ParseBoard(arguments.board);
  const std::optional<BoardView> view = DetectBoard(grey, board);
  if (!view)
    throw Fail("{}: the board {} was not seen; is it whole in the picture and lit evenly?", arguments.picture.string(),
               ToString(board));
  return FitPlaneToBoard(camera, board, *view);
}

Json Plane(const PlaneArguments& arguments, Run& run) {
  if (arguments.board.empty() == arguments.points.empty()) throw UsageError("give either --board or --points");
  CameraProfile profile = ReadCameraProfile(arguments.camera);
  run.AddInput(arguments.picture), run.AddInput(arguments.camera);
  const PlaneFit fit = FitPlaneOf(arguments, profile.camera);
  for (const std::string& warning : fit.warnings) run.Warn(warning);
  profile.camera_from_plane = fit.camera_from_plane;
  profile.plane_uncertainty = fit.uncertainty;
  WriteCameraProfile(run.Result("camera.yaml"), profile);

  const Eigen::Vector2d middle((profile.camera.image_width - 1) / 2.0, (profile.camera.image_height - 1) / 2.0);
  Json json = {{"plane_rms_px", fit.uncertainty.rms_px},
               {"sigma_px", fit.sigma_px},
               {"roll_deg", fit.roll_deg},
               {"distance_mm", fit.camera_from_plane.inverse().translation().z()},
               {"mm_per_px", SigmaInPlane(PlanePointFromPixel(profile.camera, fit.camera_from_plane, middle), 1)},
               {"translation_mm", List(fit.camera_from_plane.translation())},
               {"translation_sd_mm", List(fit.uncertainty.translation_sd_mm)},
               {"rotation_sd_rad", List(fit.uncertainty.rotation_sd_rad)}};
  if (fit.other)
    json["other_pose"] = {
        {"rms_px", fit.other->rms_px}, {"apart_deg", fit.other->apart_deg}, {"as_likely", fit.other->as_likely}};
  return json;
}

Json Sheet(const SheetArguments& arguments, Run& run) {
  const Board board = ParseBoard(arguments.board);
  const Paper paper = ParsePaper(arguments.paper);
  WriteBoardSheet(run.Result("board.pdf"), board, paper);
  return {{"board", ToString(board)}, {"paper", paper.name}, {"file", (run.Folder() / "board.pdf").string()}};
}

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

void BindCalibrate(CLI::App& cli, CalibrateArguments& a) {
  cli.add_option("pictures", a.pictures, "Images of the board, or one video of a moving board")
      ->type_name("IMAGES|VIDEO");
  cli.add_option("--board", a.board, kBoardHelp);
  cli.add_option("--loss", a.loss, "robust, or squared as OpenCV")->check(CLI::IsMember({"robust", "squared"}));
  cli.add_flag("--fix-k3", a.options.fix_k3, "k3 = 0, for views that leave the corners of the picture empty");
  cli.add_flag("--square-pixels", a.options.square_pixels, "fx = fy");
  cli.add_option("--max-views", a.find.most_views, "Of a video: how many sharp, spread frames to use")
      ->check(CLI::Range(3, 200));
}

CLI::App* BindPlane(CLI::App& cli, PlaneArguments& a) {
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

CLI::App* BindSheet(CLI::App& cli, SheetArguments& a) {
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
  CalibrateArguments calibrate;
  PlaneArguments plane;
  SheetArguments sheet;
  BindCalibrate(program.Cli(), calibrate);
  const CLI::App* plane_command = BindPlane(program.Cli(), plane);
  const CLI::App* sheet_command = BindSheet(program.Cli(), sheet);
  program.Cli().require_subcommand(0, 1);
  return program.Main(
      argc, argv, [] { return "calibrate"; },
      [&](Run& run) {
        if (plane_command->parsed()) return Plane(plane, run);
        if (sheet_command->parsed()) return Sheet(sheet, run);
        return Calibrate(calibrate, run);
      },
      Report);
}
