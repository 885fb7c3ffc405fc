#include "overlay_labels.h"

#include <array>
#include <limits>

namespace lake::overlay {
namespace {

// Directions from the disc's centre to the label's; the first ones are preferred.
constexpr std::array<std::array<double, 2>, 8> kSides = {
    {{1, 0}, {-1, 0}, {0.8, -0.8}, {-0.8, -0.8}, {0.8, 0.8}, {-0.8, 0.8}, {0, -1}, {0, 1}}};

cv::Rect2d LabelAt(int side, cv::Point2d centre, double radius_px, cv::Size2d size) {
  const auto& [dx, dy] = kSides[static_cast<std::size_t>(side)];
  const auto shift = [](double d, double half) { return d > 0.01 ? half : d < -0.01 ? -half : 0.0; };
  const cv::Point2d middle(centre.x + dx * radius_px + shift(dx, size.width / 2),
                           centre.y + dy * radius_px + shift(dy, size.height / 2));
  return {middle.x - size.width / 2, middle.y - size.height / 2, size.width, size.height};
}

// The part of the line from a to b that lies in the box, by sampling.
double LengthInside(const cv::Rect2d& box, cv::Point2d a, cv::Point2d b) {
  constexpr int kSamples = 32;
  int inside = 0;
  for (int i = 0; i <= kSamples; ++i) inside += box.contains(a + (b - a) * (static_cast<double>(i) / kSamples));
  return inside * cv::norm(b - a) / kSamples;
}

}  // namespace

double OverlayLabels::Cost(const cv::Rect2d& label) const {
  const cv::Rect2d picture({}, cv::Size2d(picture_));
  double cost = 10 * (label.area() - (label & picture).area());
  for (const cv::Rect2d& area : taken_) cost += 4 * (label & area).area();
  for (const auto& [from, to] : lines_) cost += 3 * label.height * LengthInside(label, from, to);
  return cost / label.area();
}

cv::Point2d OverlayLabels::Place(const std::string& name, cv::Point2d centre, double radius_px, cv::Size2d size) {
  constexpr double kPreference = 0.02, kChange = 0.25;  // in covered parts of the label
  const auto last = side_.find(name);
  int best = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (int side = 0; side < static_cast<int>(kSides.size()); ++side) {
    const bool changes = last != side_.end() && last->second != side;
    const double cost = Cost(LabelAt(side, centre, radius_px, size)) + kPreference * side + (changes ? kChange : 0);
    if (cost < lowest) {
      lowest = cost;
      best = side;
    }
  }
  side_[name] = best;
  cv::Rect2d label = LabelAt(best, centre, radius_px, size);
  label.x = std::clamp(label.x, 0.0, std::max(0.0, picture_.width - label.width));
  label.y = std::clamp(label.y, 0.0, std::max(0.0, picture_.height - label.height));
  Avoid(label);
  return label.tl();
}

}  // namespace lake::overlay
