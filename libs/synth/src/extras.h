// What makes tracking hard: reflections that stand still, a glint that moves, a hand that hides.
#pragma once

#include <optional>

#include "sprite.h"

namespace lake {

// Positions in px of all markers over the whole motion, for keeping clear of them.
using MarkerPaths = std::vector<std::vector<Eigen::Vector2d>>;  // [time][marker]

// Discs and streaks in turn, of 0.7–1.3 times the markers' level, at least six marker radii off every path.
std::vector<Sprite> Reflections(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths,
                                double radius_px);

// Swings about a place that keeps six marker radii from every marker's path.
class Glint {
 public:
  Glint(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths, double radius_px);
  Sprite At(const std::vector<double>& times_s) const;

 private:
  Eigen::Vector2d centre_, swing_;
  double radius_px_, level_, hz_[3], phase_rad_[3];
};

// The hand's layers (sleeve, hand) at the given times; nothing while it is away. `marker_mm` is where the hidden marker
// is then. It sweeps over the marker along its own width at the speed at which its width passes in the time the marker
// is to be hidden.
std::vector<Layer> HandLayers(const Occlusion& occlusion, std::uint64_t seed, int index, double forward,
                              double marker_radius_mm, bool bright, double soft_px, const std::vector<double>& times_s,
                              const std::vector<Eigen::Vector2d>& marker_mm);

}  // namespace lake
