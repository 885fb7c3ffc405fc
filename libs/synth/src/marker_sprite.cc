#include "marker_sprite.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "lake/camera/aruco_opencv.h"
#include "lake/core/error.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kWhiteBorder = 1.0 / 6;  // of an ArUco marker's side, all around: one cell

// Black cells of a marker whose black square has the side `side_mm`, centred, y up.
std::vector<Polygon> BlackCells(int id, double side_mm) {
  constexpr int kDots = 6;  // 4 × 4 with its border
  const cv::Mat bits = camera::DrawArucoMarker(camera::PredefinedArucoDictionary(cv::aruco::DICT_4X4_50), id, kDots);
  const double dot = side_mm / kDots;
  std::vector<Polygon> cells;
  for (int row = 0; row < kDots; ++row)
    for (int column = 0; column < kDots; ++column)
      if (bits.at<std::uint8_t>(row, column) == 0)
        cells.push_back(Box(column * dot - side_mm / 2, side_mm / 2 - (row + 1) * dot, (column + 1) * dot - side_mm / 2,
                            side_mm / 2 - row * dot));
  return cells;
}

}  // namespace

MarkerSprites::MarkerSprites(const SceneOptions& options, const View& view, const MarkerMotion& motion)
    : options_(options), view_(view) {
  const auto& names = motion.Names();
  for (const auto& [name, depth] : options.marker_depth_mm)
    if (IndexOfMarker(motion, name) < 0) throw UsageError("no marker '{}' to stand proud of the plane", name);
  for (std::size_t m = 0; m < names.size(); ++m) {
    const auto depth = options.marker_depth_mm.find(names[m]);
    depth_mm_.push_back(depth == options.marker_depth_mm.end() ? 0 : depth->second);
    const auto colour = options.marker_bgr.find(names[m]);
    bgr_.push_back(colour == options.marker_bgr.end() ? cv::Vec3f::all(static_cast<float>(options.marker_level))
                                                      : colour->second);
    const char* const partner = names[m] == "ankle" || names[m] == "exo_knee" ? "knee"
                                : names[m] == "knee"                          ? "ankle"
                                : names[m] == "hip"                           ? "knee"
                                : names[m] == "waist"                         ? "hip"
                                                                              : "";
    partner_.push_back(IndexOfMarker(motion, partner));
    partner_sign_.push_back(names[m] == "ankle" ? 1 : -1);
    if (options.marker_kind == MarkerKind::kAruco) dark_.push_back(BlackCells(static_cast<int>(m), options.aruco_mm));
  }
  const Vector2d middle = view.Plane({0.5 * view.Size().width, 0.5 * view.Size().height});
  const double px_per_mm = std::sqrt(std::abs(view.Jacobian(middle).determinant()));
  radius_px_ = options.marker_radius_mm * px_per_mm;
  if (options.marker_kind == MarkerKind::kAruco)
    aruco_reach_px_ = std::numbers::sqrt2 * (0.5 + kWhiteBorder) * options.aruco_mm * px_per_mm;
}

std::vector<Vector2d> MarkerSprites::Centres(const std::vector<Vector3d>& mm) const {
  std::vector<Vector2d> px;
  for (std::size_t m = 0; m < mm.size(); ++m) px.push_back(PixelOf(m, mm[m]));
  return px;
}

Vector2d MarkerSprites::PixelOf(std::size_t marker, const Vector3d& mm) const {
  return view_.Pixel(mm.head<2>(), mm.z() + depth_mm_[marker]);
}

Vector2d MarkerSprites::PlaceShown(std::size_t marker, const Vector3d& mm) const {
  if (mm.z() == 0) return mm.head<2>();
  return view_.Plane(PixelOf(marker, mm), depth_mm_[marker]);
}

SpriteInstant MarkerSprites::DiscAt(std::size_t marker, const Vector3d& mm) const {
  constexpr int kCorners = 96;
  SpriteInstant instant;
  const double radius = options_.marker_radius_mm;
  for (const Vector2d& corner : EllipseOutline(mm.head<2>(), radius, radius, 0, kCorners))
    instant.outline.push_back(PixelOf(marker, {corner.x(), corner.y(), mm.z()}));
  return instant;
}

SpriteInstant MarkerSprites::ArucoAt(std::size_t marker, const std::vector<Vector3d>& mm) const {
  Vector2d up = Vector2d::UnitY();
  if (partner_[marker] >= 0) up = (partner_sign_[marker] * (mm[partner_[marker]] - mm[marker]).head<2>()).normalized();
  const Vector2d right(up.y(), -up.x());
  const auto project = [&](const Polygon& polygon) {
    Polygon px;
    for (const Vector2d& p : polygon) {
      const Vector2d corner = mm[marker].head<2>() + p.x() * right + p.y() * up;
      px.push_back(PixelOf(marker, {corner.x(), corner.y(), mm[marker].z()}));
    }
    return px;
  };
  const double half = options_.aruco_mm * (0.5 + kWhiteBorder);
  SpriteInstant instant{project(Box(-half, -half, half, half)), {}};
  for (const Polygon& cell : dark_[marker]) instant.dark.push_back(project(cell));
  return instant;
}

Sprite MarkerSprites::At(std::size_t marker, const std::vector<std::vector<Vector3d>>& positions) const {
  Sprite sprite{bgr_[marker], cv::Vec3f::all(12), {}};
  for (const auto& mm : positions)
    sprite.instants.push_back(options_.marker_kind == MarkerKind::kAruco ? ArucoAt(marker, mm)
                                                                         : DiscAt(marker, mm[marker]));
  return sprite;
}

}  // namespace lake::synth
