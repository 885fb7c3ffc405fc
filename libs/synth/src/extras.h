// What makes tracking hard: reflections that stand still, a glint that moves, a hand that hides.
#pragma once

#include "sprite.h"

namespace lake::synth {

// Where the markers go in the picture, for keeping clear of them.
struct MarkerPaths {
  std::vector<std::vector<Eigen::Vector2d>> px;  // [time][marker]
  double radius_px = 0;                          // of a disc; the size of reflections goes by it
  double clear_px = 0;                           // how far everything bright must stay off
};

// Discs and streaks in turn, of 0.7–1.3 times the markers' level.
std::vector<Sprite> Reflections(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths);

// Swings about a place that is clear of every marker's path.
class Glint {
 public:
  Glint(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths);
  Sprite At(const std::vector<double>& times_s) const;

 private:
  Eigen::Vector2d centre_, swing_;
  double radius_px_, level_, hz_[3], phase_rad_[3];
};

// A hand that reaches over one marker: it sweeps across along its own width, at the speed at which that width passes in
// the time for which the marker is to be hidden, and comes and goes along its arm. From where it comes is drawn by lot
// so that it hides no other marker, if that is possible.
class Hand {
 public:
  Hand(const SceneOptions& options, std::size_t occlusion, const MarkerMotion& motion, double soft_px);

  // Its layers (sleeve, hand) at these times of the motion; nothing while it is away.
  std::vector<Layer> At(const std::vector<double>& times_s) const;

 private:
  // Where it comes from.
  struct Approach {
    Eigen::Vector2d point, sweep;  // to the fingertips; the way it goes over the marker
  };
  Eigen::Vector2d Palm(const Approach& approach, double time_s) const;
  int OthersHidden(const Approach& approach) const;

  const MarkerMotion& motion_;
  std::size_t marker_;
  double middle_s_, mm_per_s_, soft_px_;
  bool bright_;
  Approach approach_;
};

}  // namespace lake::synth
