// Boards with known truth: projected corners with noise, and rendered pictures.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "lake/camera/board.h"
#include "lake/camera/camera.h"

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

// The sheet at 10 px per mm, one square of white around the board's squares; its lower left is (-2, -2) squares.
inline cv::Mat1b Sheet(const camera::Board& board, double& left_mm, double& top_mm) {
  constexpr double kPxPerMm = 10;
  const double s = board.square_mm;
  left_mm = -2 * s, top_mm = (board.SquareRows()) * s;
  cv::Mat1b sheet(static_cast<int>(std::lround((board.SquareRows() + 2) * s * kPxPerMm)),
                  static_cast<int>(std::lround((board.SquareColumns() + 2) * s * kPxPerMm)), uchar{235});
  for (const camera::BoardRectangle& r : camera::BoardInk(board)) {
    const auto at = [&](double mm) { return static_cast<int>(std::lround(mm * kPxPerMm)); };
    const int x0 = at(r.left - left_mm), x1 = at(r.left + r.width - left_mm);
    const int y0 = at(top_mm - r.bottom - r.height), y1 = at(top_mm - r.bottom);
    sheet(cv::Rect(x0, y0, x1 - x0, y1 - y0)) = uchar{20};
  }
  return sheet;
}

struct RenderOptions {
  double blur_px = 0.6;  // standard deviation of the optics
  double noise = 1.5;    // grey levels
  int samples = 6;       // per pixel and axis
};

// A picture by integrating the sheet over each pixel's square.
template <typename Random>
cv::Mat1b Render(const camera::Camera& camera, const camera::Board& board, const Eigen::Isometry3d& pose,
                 Random& random, const RenderOptions& options = {}) {
  double left_mm = 0, top_mm = 0;
  const cv::Mat1b sheet = Sheet(board, left_mm, top_mm);
  cv::Mat1f picture(camera.image_height, camera.image_width);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const camera::PlanePoint middle = camera::PlanePointFromPixel(camera, pose, Eigen::Vector2d(x, y));
      float sum = 0;
      for (int i = 0; i < options.samples * options.samples; ++i) {
        const Eigen::Vector2d offset((i % options.samples + 0.5) / options.samples - 0.5,
                                     (i / options.samples + 0.5) / options.samples - 0.5);
        const Eigen::Vector2d mm = middle.position_mm + middle.mm_per_px * offset;
        const double column = std::floor((mm.x() - left_mm) * 10), row = std::floor((top_mm - mm.y()) * 10);
        const bool on_sheet = column >= 0 && row >= 0 && column < sheet.cols && row < sheet.rows;
        sum += on_sheet ? sheet(static_cast<int>(row), static_cast<int>(column)) : 120;
      }
      picture(y, x) = sum / static_cast<float>(options.samples * options.samples);
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
