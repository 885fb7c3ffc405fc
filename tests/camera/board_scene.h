// Boards with known truth: projected corners with noise, and rendered pictures.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "lake/camera/board.h"
#include "lake/camera/camera.h"
#include "lake/video/image.h"
#include "places.h"

namespace lake {

inline const camera::Board kBoard = camera::ParseBoard("chessboard:9x6:25");
inline const camera::Camera kSmallCamera{640, 480, 610, 606, 331, 236, {-0.24, 0.09, 4e-4, -3e-4, 0}};

}  // namespace lake

namespace lake::scene {

inline camera::Camera Lens() {
  return {1280, 720, 1010, 1004, 652, 348, {-0.21, 0.08, 4e-4, -3e-4, -0.015}};
}

// The rotation of a board that stands upright before the camera: x right, y up, z towards it.
inline Eigen::Matrix3d Facing() {
  return Eigen::Vector3d(1, -1, -1).asDiagonal();
}

inline Eigen::Vector2d Centre(const camera::Board& board) {
  return Eigen::Vector2d(board.CornerColumns() - 1, board.CornerRows() - 1) * board.square_mm / 2;
}

// A board tilted by up to `tilt_deg` about any axis, its centre at a pixel, its width about `width_px`.
inline Eigen::Isometry3d PoseAt(const camera::Camera& camera, const camera::Board& board, const Eigen::Vector2d& pixel,
                                double width_px, double tilt_deg, double tilt_axis_deg, double roll_deg) {
  const double rad = std::numbers::pi / 180;
  const Eigen::Vector3d axis(std::cos(tilt_axis_deg * rad), std::sin(tilt_axis_deg * rad), 0);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Facing() * Eigen::AngleAxisd(tilt_deg * rad, axis).toRotationMatrix() *
                  Eigen::AngleAxisd(roll_deg * rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const double distance = camera.fx * board.CornerColumns() * board.square_mm / width_px;
  const Eigen::Vector2d centre = Centre(board);
  pose.translation() =
      distance * camera::RayFromPixel(camera, pixel) - pose.linear() * Eigen::Vector3d(centre.x(), centre.y(), 0);
  return pose;
}

inline std::vector<Eigen::Vector2d> CornerPixels(const camera::Camera& camera, const camera::Board& board,
                                                 const Eigen::Isometry3d& pose) {
  std::vector<Eigen::Vector2d> pixels;
  for (const auto& p : camera::BoardCorners(board)) pixels.push_back(camera::PixelFromPlane(camera, pose, p));
  return pixels;
}

// With room for half a square around the outer corners.
inline bool InsidePicture(const camera::Camera& camera, const std::vector<Eigen::Vector2d>& pixels, double margin_px) {
  return std::all_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& p) {
    return p.x() > margin_px && p.y() > margin_px && p.x() < camera.image_width - margin_px &&
           p.y() < camera.image_height - margin_px;
  });
}

template <typename Random>
Eigen::Isometry3d RandomPose(const camera::Camera& camera, const camera::Board& board, Random& random,
                             double most_tilt_deg = 45) {
  std::uniform_real_distribution<double> unit(0, 1);
  for (;;) {
    const Eigen::Vector2d pixel(unit(random) * camera.image_width, unit(random) * camera.image_height);
    const double width = (0.3 + 0.45 * unit(random)) * camera.image_width;
    const double tilt = most_tilt_deg * unit(random), axis = 360 * unit(random), roll = 40 * unit(random) - 20;
    const Eigen::Isometry3d pose = PoseAt(camera, board, pixel, width, tilt, axis, roll);
    if (InsidePicture(camera, CornerPixels(camera, board, pose), 3)) return pose;
  }
}

template <typename Random>
camera::BoardView NoisyView(const camera::Camera& camera, const camera::Board& board, const Eigen::Isometry3d& pose,
                            double sigma_px, Random& random) {
  std::normal_distribution<double> noise(0, 1);
  camera::BoardView view;
  view.pixel = CornerPixels(camera, board, pose);
  for (std::size_t i = 0; i < view.pixel.size(); ++i) {
    view.corner.push_back(static_cast<int>(i));
    view.pixel[i] += sigma_px * Eigen::Vector2d(noise(random), noise(random));
  }
  return view;
}

// The same with room for the detector, which needs the outer squares.
template <typename Random>
Eigen::Isometry3d PoseWellInside(const camera::Camera& camera, const camera::Board& board, Random& random,
                                 double margin_px) {
  for (;;) {
    const Eigen::Isometry3d pose = RandomPose(camera, board, random, 40);
    if (InsidePicture(camera, CornerPixels(camera, board, pose), margin_px)) return pose;
  }
}

// So many views of the board from anywhere.
inline std::vector<camera::BoardView> NoisyViews(const camera::Camera& camera, int count, double sigma_px,
                                                 std::uint64_t seed, double most_tilt_deg = 45) {
  std::mt19937_64 random(seed);
  std::vector<camera::BoardView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back(NoisyView(camera, kBoard, RandomPose(camera, kBoard, random, most_tilt_deg), sigma_px, random));
    views.back().name = "view " + std::to_string(i);
  }
  return views;
}

// By how much each corner of a view is off. A board without codes may be taken to stand on its head.
inline std::vector<Eigen::Vector2d> Errors(const camera::BoardView& view, const std::vector<Eigen::Vector2d>& truth) {
  const bool turned = (view.pixel.front() - truth.front()).norm() > (view.pixel.front() - truth.back()).norm();
  std::vector<Eigen::Vector2d> errors;
  for (std::size_t c = 0; c < truth.size(); ++c)
    errors.push_back(view.pixel[c] - truth[turned ? truth.size() - 1 - c : c]);
  return errors;
}

inline double RmsPx(const std::vector<Eigen::Vector2d>& errors) {
  double square = 0;
  for (const Eigen::Vector2d& error : errors) square += error.squaredNorm();
  return std::sqrt(square / static_cast<double>(errors.size()));
}

// OpenCV's published pictures of one side, with a window of the detector or (0) its own choice.
inline std::vector<camera::BoardView> OpenCvViews(const std::string& side, int half_window_px = 0) {
  std::vector<camera::BoardView> views;
  for (int i = 1; i <= 14; ++i) {
    const std::string name = fmt::format("{}{:02}.jpg", side, i);
    if (i == 10) continue;  // not in the set
    camera::BoardDetectionOptions options;
    options.half_window_px = half_window_px;
    const cv::Mat picture = video::ReadImage(SharedData() / "opencv_leftright" / name, false);
    views.push_back(camera::DetectBoard(picture, kBoard, options).value());
    views.back().name = name;
  }
  return views;
}

// A board's sheet at 10 px per mm, one square of white around the board's squares. Its edges cut it into columns and
// rows of fields that have one level each.
struct Sheet {
  static constexpr double kPxPerMm = 10;
  static constexpr float kAround = 120;  // what is not the sheet

  explicit Sheet(const camera::Board& board)
      : left_mm(-2 * board.square_mm), top_mm(board.SquareRows() * board.square_mm) {
    std::vector<cv::Rect> ink;
    for (const camera::BoardRectangle& r : camera::BoardInk(board))
      ink.emplace_back(cv::Point(Px(r.left - left_mm), Px(top_mm - r.bottom - r.height)),
                       cv::Point(Px(r.left + r.width - left_mm), Px(top_mm - r.bottom)));
    std::vector<int> across, down;
    for (const cv::Rect& r : ink) {
      across.insert(across.end(), {r.x, r.br().x});
      down.insert(down.end(), {r.y, r.br().y});
    }
    column = FieldOfEach(across, Px((board.SquareColumns() + 2) * board.square_mm));
    row = FieldOfEach(down, Px((board.SquareRows() + 2) * board.square_mm));
    level = cv::Mat1b(row.back() + 1, column.back() + 1, uchar{235});
    for (const cv::Rect& r : ink)
      level(cv::Range(row[r.y], row[r.br().y - 1] + 1), cv::Range(column[r.x], column[r.br().x - 1] + 1)) = uchar{20};
  }

  static int Px(double mm) { return static_cast<int>(std::lround(mm * kPxPerMm)); }

  // The number of the field that each of `count` pixels lies in, of the fields between the cuts.
  static std::vector<int> FieldOfEach(std::vector<int> cuts, int count) {
    std::vector<int> field(static_cast<std::size_t>(count), 0);
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    for (const int cut : cuts)
      for (int i = cut; i < count; ++i) ++field[i];
    return field;
  }

  int Width() const { return static_cast<int>(column.size()); }
  int Height() const { return static_cast<int>(row.size()); }

  Eigen::Vector2d FromPlane(const Eigen::Vector2d& mm) const {
    return {kPxPerMm * (mm.x() - left_mm), kPxPerMm * (top_mm - mm.y())};
  }
  Eigen::Vector2d ToPlane(double x, double y) const { return {left_mm + x / kPxPerMm, top_mm - y / kPxPerMm}; }

  float At(const Eigen::Vector2d& px) const {
    const bool on_sheet = px.x() >= 0 && px.y() >= 0 && px.x() < Width() && px.y() < Height();
    return on_sheet ? level(row[static_cast<int>(px.y())], column[static_cast<int>(px.x())]) : kAround;
  }

  // The level within `reach` of a place, if that is outside the sheet or within one field.
  std::optional<float> OnlyLevel(const Eigen::Vector2d& px, const Eigen::Vector2d& reach) const {
    const Eigen::Vector2d from = px - reach, to = px + reach;
    if (to.x() < 0 || to.y() < 0 || from.x() >= Width() || from.y() >= Height()) return kAround;
    if (from.x() < 0 || from.y() < 0 || to.x() >= Width() || to.y() >= Height()) return std::nullopt;
    const auto same = [](const std::vector<int>& field, double a, double b) {
      return field[static_cast<int>(a)] == field[static_cast<int>(b)];
    };
    if (!same(column, from.x(), to.x()) || !same(row, from.y(), to.y())) return std::nullopt;
    return At(px);
  }

  double left_mm, top_mm;        // of the sheet, in the board's plane
  std::vector<int> column, row;  // of fields, for every pixel's x and y
  cv::Mat1b level;               // of each field
};

// The part of the picture outside which nothing of the sheet is seen.
inline cv::Rect Reach(const camera::Camera& camera, const Eigen::Isometry3d& pose, const Sheet& sheet) {
  constexpr int kSteps = 40, kMargin_px = 4;  // the lens bends a side by less between two places on it
  std::vector<cv::Point2f> outline;
  const auto add = [&](double u, double v) {
    const Eigen::Vector2d px =
        camera::PixelFromPlane(camera, pose, sheet.ToPlane(u * sheet.Width(), v * sheet.Height()));
    outline.emplace_back(px.x(), px.y());
  };
  for (int i = 0; i <= kSteps; ++i) {
    const double u = static_cast<double>(i) / kSteps;
    add(u, 0);
    add(u, 1);
    add(0, u);
    add(1, u);
  }
  const cv::Rect box = cv::boundingRect(outline);
  return cv::Rect(box.tl() - cv::Point(kMargin_px, kMargin_px), box.br() + cv::Point(kMargin_px, kMargin_px)) &
         cv::Rect(0, 0, camera.image_width, camera.image_height);
}

struct RenderOptions {
  double blur_px = 0.6;  // standard deviation of the optics
  double noise = 1.5;    // grey levels
  int samples = 6;       // per pixel and axis
};

// A pixel's mean over its square, from samples x samples places.
inline float MeanLevel(const Sheet& sheet, const Eigen::Vector2d& middle, const Eigen::Matrix2d& sheet_per_px,
                       int samples) {
  const Eigen::Vector2d reach = sheet_per_px.cwiseAbs() * Eigen::Vector2d(0.5, 0.5);
  if (const std::optional<float> level = sheet.OnlyLevel(middle, reach)) return *level;
  float sum = 0;
  for (int i = 0; i < samples * samples; ++i) {
    const Eigen::Vector2d offset((i % samples + 0.5) / samples - 0.5, (i / samples + 0.5) / samples - 0.5);
    sum += sheet.At(middle + sheet_per_px * offset);
  }
  return sum / static_cast<float>(samples * samples);
}

// A picture by integrating the sheet over each pixel's square.
template <typename Random>
cv::Mat1b Render(const camera::Camera& camera, const camera::Board& board, const Eigen::Isometry3d& pose,
                 Random& random, const RenderOptions& options = {}) {
  const Sheet sheet(board);
  const cv::Rect reach = Reach(camera, pose, sheet);
  const Eigen::Matrix2d sheet_per_mm = Sheet::kPxPerMm * Eigen::Vector2d(1, -1).asDiagonal();
  cv::Mat1f picture(camera.image_height, camera.image_width, Sheet::kAround);
  for (int y = reach.y; y < reach.br().y; ++y) {
    for (int x = reach.x; x < reach.br().x; ++x) {
      const camera::PlanePoint middle = camera::PlanePointFromPixel(camera, pose, Eigen::Vector2d(x, y));
      picture(y, x) =
          MeanLevel(sheet, sheet.FromPlane(middle.position_mm), sheet_per_mm * middle.mm_per_px, options.samples);
    }
  }
  if (options.blur_px > 0) cv::GaussianBlur(picture, picture, {}, options.blur_px);
  std::normal_distribution<float> noise(0, static_cast<float>(options.noise));
  for (float& value : picture) value += noise(random);
  cv::Mat1b grey;
  picture.convertTo(grey, CV_8U);
  return grey;
}

}  // namespace lake::scene
