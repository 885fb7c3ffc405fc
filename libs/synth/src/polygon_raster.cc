#include "lake/synth/polygon_raster.h"

#include <algorithm>
#include <cmath>

#include "lake/core/cross.h"

namespace lake::synth {

using Eigen::Vector2d;

double SignedArea(std::span<const Vector2d> polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += Cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
  return 0.5 * twice;
}

PolygonRaster::PolygonRaster(int width, int height)
    : width_(width), height_(height), change_(static_cast<std::size_t>(height) * (width + 1), 0.0) {}

void PolygonRaster::Add(std::span<const Vector2d> polygon, double weight) {
  // With y down, a polygon of positive area has its interior to the right of its upward edges.
  const double oriented = SignedArea(polygon) < 0 ? weight : -weight;
  for (std::size_t i = 0; i < polygon.size(); ++i) AddEdge(polygon[i], polygon[(i + 1) % polygon.size()], oriented);
}

void PolygonRaster::AddEdge(Vector2d from, Vector2d to, double weight) {
  if (from.y() == to.y()) return;
  if (from.y() > to.y()) {
    std::swap(from, to);
    weight = -weight;
  }
  const double slope = (to.x() - from.x()) / (to.y() - from.y());
  const int first = static_cast<int>(std::floor(std::clamp(from.y(), 0.0, double(height_))));
  const int last = static_cast<int>(std::ceil(std::clamp(to.y(), 0.0, double(height_))));
  for (int row = first; row < last; ++row) {
    const double y0 = std::max<double>(from.y(), row), y1 = std::min<double>(to.y(), row + 1);
    AddInRow(row, from.x() + slope * (y0 - from.y()), from.x() + slope * (y1 - from.y()), weight * (y1 - y0));
  }
}

void PolygonRaster::AddInRow(int row, double x0, double x1, double signed_height) {
  if (x0 > x1) std::swap(x0, x1);
  double* const change = &change_[static_cast<std::size_t>(row) * (width_ + 1)];
  const double height_per_x = x1 > x0 ? signed_height / (x1 - x0) : 0;
  const auto height = [&](double a, double b) { return x1 > x0 ? height_per_x * (b - a) : signed_height; };
  if (x0 < 0) change[0] += height(x0, std::min(x1, 0.0));  // all cells lie to the right of this part
  if (x1 < 0 || x0 >= width_) return;
  const double right = std::min<double>(x1, width_);
  double x = std::max(x0, 0.0);
  for (int cell = static_cast<int>(x); cell < width_ && x <= right; ++cell) {
    const double end = std::min<double>(right, cell + 1);
    const double part = height(x, end),
                 covered = 1 - (0.5 * (x + end) - cell);  // the cell's share to the right of this part
    change[cell] += part * covered;
    change[cell + 1] += part * (1 - covered);
    x = end;
    if (end == right) break;
  }
}

cv::Mat PolygonRaster::Coverage() const {
  cv::Mat coverage(height_, width_, CV_32FC1);
  for (int row = 0; row < height_; ++row) {
    const double* const change = &change_[static_cast<std::size_t>(row) * (width_ + 1)];
    double sum = 0;
    for (int column = 0; column < width_; ++column)
      coverage.at<float>(row, column) = static_cast<float>(sum += change[column]);
  }
  return coverage;
}

}  // namespace lake::synth
