#include "lake/commands/calibrate.h"

#include <algorithm>

#include "lake/camera/board.h"
#include "lake/camera/calibration_quality.h"
#include "lake/camera/camera.h"
#include "lake/camera/plane_fit.h"
#include "lake/core/counted.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/figure/calibration_figures.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

std::vector<double> List(const auto& values) {
  return {values.begin(), values.end()};
}

Json CameraJson(const camera::Camera& camera) {
  return {{"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", camera.distortion},
          {"more_distortion", camera.more}};
}

Json OutlierJson(const std::vector<camera::BoardView>& views, const camera::CalibrationResult& result) {
  Json outliers = Json::array();
  for (const camera::CornerOutlier& o : result.outliers)
    outliers.push_back({{"view", views[o.view].name}, {"corner", o.corner}, {"error_px", o.error_px}});
  return outliers;
}

camera::CornerOutlier WorstCorner(const std::vector<camera::BoardView>& views,
                                  const camera::CalibrationResult& result) {
  camera::CornerOutlier worst;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t i = 0; i < views[v].corner.size(); ++i)
      if (const double error = result.residual_px[v][i].norm(); error > worst.error_px)
        worst = {v, views[v].corner[i], error};
  return worst;
}

Json ResultJson(const camera::BoardPictures& pictures, const camera::CalibrationResult& result,
                const camera::CalibrationQuality& quality) {
  const camera::CameraUncertainty sd = camera::UncertaintyOf(result);
  const camera::CornerOutlier worst = WorstCorner(pictures.views, result);
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

std::string ReportOf(const camera::BoardPictures& pictures, const camera::CalibrationResult& result,
                     const camera::CalibrationQuality& quality, camera::LensFamily lens) {
  const camera::Camera& camera = result.camera;
  const Eigen::Vector4d sd = camera::UncertaintyOf(result).intrinsics_sd;
  const auto& crossed = quality.cross_validation;
  return fmt::format(
      "{}, RMS {:.3f} px (inliers {:.3f} px, {}), worst view {} {:.3f} px\n"
      "fx {}  fy {}  cx {}  cy {} px\n"
      "coverage {:.0f} %, largest tilt {:.0f}°{}; lens model {}\n",
      Counted(pictures.views.size(), "view"), result.rms_px, result.inlier_rms_px,
      Counted(result.outliers.size(), "outlier"), pictures.views[quality.worst_view].name,
      result.view_rms_px[quality.worst_view], PlusMinusText(camera.fx, sd[0], 2), PlusMinusText(camera.fy, sd[1], 2),
      PlusMinusText(camera.cx, sd[2], 2), PlusMinusText(camera.cy, sd[3], 2), 100 * quality.coverage.fraction,
      quality.largest_tilt_deg,
      crossed ? fmt::format(", odd and even views differ by {:.3f} px RMS", crossed->rms_px) : "",
      camera::ToString(lens));
}

void WriteResiduals(const fs::path& path, const std::vector<camera::BoardView>& views,
                    const camera::CalibrationResult& result) {
  CsvWriter table({"view", "corner", "x_px", "y_px", "dx_px", "dy_px"});
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v].corner.size(); ++i)
      table.AddRow(views[v].name, views[v].corner[i], views[v].pixel[i].x(), views[v].pixel[i].y(),
                   result.residual_px[v][i].x(), result.residual_px[v][i].y());
  }
  table.Write(path);
}

std::vector<camera::PlaneCorrespondence> CheckedPoints(const std::string& text, const camera::Camera& camera) {
  const std::vector<camera::PlaneCorrespondence> points = camera::ParsePlanePoints(text);
  for (const auto& p : points)
    if (p.pixel.x() < -0.5 || p.pixel.y() < -0.5 || p.pixel.x() > camera.image_width - 0.5 ||
        p.pixel.y() > camera.image_height - 0.5)
      throw UsageError("--points: pixel {},{} is outside the picture of {}x{}", p.pixel.x(), p.pixel.y(),
                       camera.image_width, camera.image_height);
  return points;
}

camera::PlaneFit FitPlaneOf(const PlaneRunOptions& options, const camera::Camera& camera) {
  const cv::Mat grey = video::ReadImage(options.picture, false);
  camera::CheckResolution(camera, options.camera, grey.cols, grey.rows, options.picture);
  if (!options.points.empty())
    return camera::FitPlane(camera, CheckedPoints(options.points, camera), {options.click_sigma_px});
  const camera::Board board = camera::ParseBoard(options.board);
  const std::optional<camera::BoardView> view = camera::DetectBoard(grey, board);
  if (!view)
    throw Fail("{}: the board {} was not seen; is it whole in the picture and lit evenly?", options.picture.string(),
               camera::ToString(board));
  return camera::FitPlaneToBoard(camera, board, *view);
}

// The family asked for, or the one that predicts best.
camera::LensChoice TakeLens(const CalibrateRunOptions& options, const camera::Board& board,
                            const camera::BoardPictures& pictures) {
  if (options.lens) return {*options.lens, {}};
  return camera::ChooseLens(board, pictures.views, pictures.width_px, pictures.height_px, options.calibration);
}

// Beyond it no lens model describes the corners, and what was fitted is no camera.
void CheckRms(const camera::CalibrationResult& result, const camera::Board& board) {
  constexpr double kMost = 0.01;  // of the picture's diagonal; blurred corners of a cheap lens: 0.001
  const double most_px = kMost * std::hypot(result.camera.image_width, result.camera.image_height);
  if (result.rms_px > most_px)
    throw Fail(
        "no camera explains the corners: RMS {:.1f} px, more than {:.1f} (1 % of the diagonal); is the board {} "
        "(columns, "
        "rows), rigid and flat, and are all views of one camera?",
        result.rms_px, most_px, camera::ToString(board));
}

// Leaves out, one after the other and by name, views that are far worse than the others: corners of which were taken
// for their neighbours, or a board that was bent.
camera::CalibrationResult CalibrateWithViewsThatFit(const camera::Board& board,
                                                    const camera::CalibrationOptions& calibration,
                                                    camera::BoardPictures& pictures, Run& run) {
  constexpr double kTimesTheMedian = 5, kLeastPx = 0.5;
  constexpr std::size_t kLeastViews = 6;
  while (true) {
    camera::CalibrationResult result =
        camera::CalibrateCamera(board, pictures.views, pictures.width_px, pictures.height_px, calibration);
    const auto worst = std::max_element(result.view_rms_px.begin(), result.view_rms_px.end());
    const double median = Median(result.view_rms_px), limit = std::max(kTimesTheMedian * median, kLeastPx);
    if (pictures.views.size() <= kLeastViews || *worst <= limit) {
      CheckRms(result, board);
      return result;
    }
    const auto view = pictures.views.begin() + (worst - result.view_rms_px.begin());
    run.Warn("{} does not fit the other views ({:.2f} px RMS, theirs {:.2f}) and is left out", view->name, *worst,
             median);
    pictures.views.erase(view);
  }
}

}  // namespace

std::vector<InputFile> InputsOf(const CalibrateRunOptions& options) {
  std::vector<InputFile> inputs;
  for (const fs::path& picture : options.pictures) inputs.push_back({video::FilesOfVideo(picture), "board"});
  return inputs;
}

std::vector<InputFile> InputsOf(const PlaneRunOptions& options) {
  return {{options.picture, "plane"}, {options.camera, "camera"}};
}

Json RunCalibrate(const CalibrateRunOptions& options, Run& run) {
  if (options.pictures.empty())
    throw UsageError("no pictures given: name images or a video of the board; see lake-calibrate --help");
  if (options.board.empty()) throw UsageError("no board given: e.g. --board chessboard:9x6:25");
  camera::BoardPicturesOptions find = options.find;
  find.quiet = run.Quiet();
  const camera::Board board = camera::ParseBoard(options.board);
  run.AddInputs(InputsOf(options));
  run.Begin({"summary.json", "camera.yaml", "residuals.csv", "residuals.png", "residuals.svg", "cross_validation.png",
             "cross_validation.svg"});
  camera::BoardPictures pictures = camera::FindBoards(options.pictures, board, find);
  if (!pictures.without_board.empty())
    run.Warn("no board seen in {} of {} images, left out: {}", pictures.without_board.size(), pictures.attempts,
             fmt::join(pictures.without_board, ", "));

  const camera::LensChoice choice = TakeLens(options, board, pictures);
  camera::CalibrationOptions calibration = options.calibration;
  calibration.lens = choice.lens;
  const camera::CalibrationResult result = CalibrateWithViewsThatFit(board, calibration, pictures, run);
  if (!result.summary.usable) throw SolverError("the bundle adjustment did not converge: " + result.summary.message);
  const camera::CalibrationQuality quality = camera::AssessCalibration(board, pictures.views, result, calibration);
  if (quality.two_cameras && quality.two_cameras->is_certain)
    throw Fail(
        "the pictures are of two cameras, or of one whose zoom or focus was changed: {}; calibrate each by itself",
        camera::Describe(*quality.two_cameras, pictures.views));
  for (const std::string& warning : quality.warnings) run.Warn(warning);

  camera::WriteCameraProfile(run.Result("camera.yaml"), {result.camera, {}, camera::UncertaintyOf(result), {}});
  WriteResiduals(run.Result("residuals.csv"), pictures.views, result);
  DrawPngAndSvg("residuals", run, figure::WriteResidualFigure, pictures.views, result);
  if (quality.cross_validation)
    DrawPngAndSvg("cross_validation", run, figure::WriteCrossValidationFigure, *quality.cross_validation,
                  pictures.width_px, pictures.height_px);
  Json json = ResultJson(pictures, result, quality);
  json["lens"] = {{"model", camera::ToString(calibration.lens)}, {"chosen", !options.lens}};
  for (const auto& [lens, error_px] : choice.error_px)
    json["lens"]["left_out_error_px"][camera::ToString(lens)] = error_px;
  run.Report(ReportOf(pictures, result, quality, calibration.lens));
  return json;
}

Json RunPlane(const PlaneRunOptions& options, Run& run) {
  if (options.board.empty() == options.points.empty()) throw UsageError("give either --board or --points");
  camera::CameraProfile profile = camera::ReadCameraProfile(options.camera);
  run.AddInputs(InputsOf(options));
  const camera::PlaneFit fit = FitPlaneOf(options, profile.camera);
  for (const std::string& warning : profile.warnings) run.Warn(warning);
  for (const std::string& warning : fit.warnings) run.Warn(warning);
  profile.camera_from_plane = fit.camera_from_plane;
  profile.plane_uncertainty = fit.uncertainty;
  camera::WriteCameraProfile(run.Result("camera.yaml"), profile);

  const Eigen::Vector2d middle((profile.camera.image_width - 1) / 2.0, (profile.camera.image_height - 1) / 2.0);
  const double distance_mm = fit.camera_from_plane.inverse().translation().z(),
               mm_per_px =
                   camera::SigmaInPlane(camera::PlanePointFromPixel(profile.camera, fit.camera_from_plane, middle), 1);
  run.Report("plane at {:.0f} mm, {:.3f} mm/px in the middle, RMS {:.3f} px\n", distance_mm, mm_per_px,
             fit.uncertainty.rms_px);
  Json json = {{"plane_rms_px", fit.uncertainty.rms_px},
               {"sigma_px", fit.sigma_px},
               {"roll_deg", fit.roll_deg},
               {"distance_mm", distance_mm},
               {"mm_per_px", mm_per_px},
               {"translation_mm", List(fit.camera_from_plane.translation())},
               {"translation_sd_mm", List(fit.uncertainty.translation_sd_mm)},
               {"rotation_sd_rad", List(fit.uncertainty.rotation_sd_rad)}};
  if (fit.other)
    json["other_pose"] = {
        {"rms_px", fit.other->rms_px}, {"apart_deg", fit.other->apart_deg}, {"as_likely", fit.other->as_likely}};
  return json;
}

Json RunSheet(const SheetRunOptions& options, Run& run) {
  const camera::Board board = camera::ParseBoard(options.board);
  const camera::Paper paper = camera::ParsePaper(options.paper);
  const fs::path file = run.Result("board.pdf");
  camera::WriteBoardSheet(file, board, paper);
  run.Report("{} on {}: print it at 100 %\n", file.string(), paper.name);
  return {{"board", camera::ToString(board)}, {"paper", paper.name}, {"file", file.string()}};
}

namespace {

Option& DescribeBoard(std::string& board, OptionList& options) {
  const auto set = [&board](const OptionTexts& texts, const std::string& said) {
    CheckTextCount(texts, 1, said);
    camera::ParseBoard(texts.front());
    board = texts.front();
  };
  return options
      .AddCustom(
          "board",
          "chessboard:COLSxROWS:SQUARE_MM (inner corners) or charuco:COLSxROWS:SQUARE_MM:MARKER_MM:DICT (squares)", set)
      .Value("BOARD");
}

}  // namespace

void Describe(CalibrateRunOptions& o, OptionList& options) {
  options.AddOperand("pictures", o.pictures, "Images of the board, or one video of a moving board")
      .Value("IMAGES|VIDEO")
      .Repeats();
  DescribeBoard(o.board, options);
  options.AddChoice("loss", o.calibration.robust, OptionList::Choices<bool>{{"robust", true}, {"squared", false}},
                    "Loss function: robust, or squared as in OpenCV");
  using camera::LensFamily;
  options
      .AddChoice("lens", o.lens,
                 OptionList::Choices<LensFamily>{{"polynomial", LensFamily::kPolynomial},
                                                 {"rational", LensFamily::kRational},
                                                 {"fisheye", LensFamily::kFisheye}},
                 "Lens model: k1 k2 p1 p2 k3, these and k4 k5 k6, or an odd polynomial of the angle")
      .Otherwise("what predicts left-out views best");
  options.Add("fix-k3", o.calibration.fix_k3, "Keep k3 = 0, for views that leave the corners of the picture empty");
  options.Add("square-pixels", o.calibration.square_pixels, "Force fx = fy");
  options.Add("max-views", o.find.most_views, "Number of sharp, well-spread frames to use from a video")
      .Between(3, 200);
}

void Describe(PlaneRunOptions& o, OptionList& options) {
  options.AddOperand("image", o.picture, "The picture").Value("IMAGE").Required();
  options.Add("camera", o.camera, "camera.yaml of this camera").Required();
  DescribeBoard(o.board, options);
  const auto set_points = [&o](const OptionTexts& texts, const std::string& said) {
    CheckTextCount(texts, 1, said);
    camera::ParsePlanePoints(texts.front());
    o.points = texts.front();
  };
  options.AddCustom("points", "At least four points: pixel = place in the plane (mm; x right, y up)", set_points)
      .Value("\"X,Y=XMM,YMM; ...\"");
  options.Add("click-sigma", o.click_sigma_px, "Standard deviation of the pixels in --points").Unit("px").Positive();
}

void Describe(SheetRunOptions& o, OptionList& options) {
  DescribeBoard(o.board, options).Required();
  options.Add("paper", o.paper, "a4, a3 or letter").Value("a4|a3|letter");
}

}  // namespace lake::commands
