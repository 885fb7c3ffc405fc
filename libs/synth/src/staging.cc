#include "lake/synth/staging.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

class WalkIn : public MarkerMotion {
 public:
  WalkIn(std::shared_ptr<const MarkerMotion> motion, double walk_s, double distance_mm)
      : motion_(std::move(motion)),
        walk_s_(walk_s),
        distance_mm_(distance_mm),
        hip_(IndexOfMarker(*motion_, "hip")),
        swinging_{IndexOfMarker(*motion_, "ankle"), IndexOfMarker(*motion_, "knee")} {
    if (hip_ < 0) throw Fail("a subject who walks in needs a marker 'hip'");
    if (!(walk_s > 0)) throw UsageError("walking in takes a positive time");
  }

  const std::vector<std::string>& Names() const override { return motion_->Names(); }
  motion::Facing FacingInImage() const override { return motion_->FacingInImage(); }
  double DurationS() const override { return walk_s_ + motion_->DurationS(); }

  std::vector<Vector2d> At(double time_s) const override {
    std::vector<Vector2d> positions = motion_->At(std::max(0.0, time_s - walk_s_));
    const double s = std::clamp(time_s / walk_s_, 0.0, 1.0);
    if (s == 1) return positions;
    const double way = s * s * s * (10 - 15 * s + 6 * s * s);  // jerk-limited: speed and acceleration end at 0
    const double forward = FacingInImage() == motion::Facing::kRight ? 1 : -1;
    constexpr double kStepsHz = 0.9, kSwing_rad = 0.35;
    const double fade = std::pow(4 * s * (1 - s), 3);
    const Eigen::Rotation2Dd swing(kSwing_rad * fade * std::sin(2 * std::numbers::pi * kStepsHz * time_s));
    const Vector2d hip = positions[static_cast<std::size_t>(hip_)];
    for (const int marker : swinging_)
      if (marker >= 0) {
        Vector2d& position = positions[static_cast<std::size_t>(marker)];
        position = hip + swing * Vector2d(position - hip);
      }
    for (Vector2d& position : positions) position.x() -= forward * distance_mm_ * (1 - way);
    return positions;
  }

  std::vector<double> DepthsAt(double time_s) const override {
    return motion_->DepthsAt(std::max(0.0, time_s - walk_s_));
  }

 private:
  std::shared_ptr<const MarkerMotion> motion_;
  double walk_s_, distance_mm_;
  int hip_;
  std::array<int, 2> swinging_;
};

class TwoPeople : public MarkerMotion {
 public:
  TwoPeople(std::shared_ptr<const MarkerMotion> subject, std::shared_ptr<const MarkerMotion> other, double offset_mm)
      : subject_(std::move(subject)), other_(std::move(other)), offset_mm_(offset_mm), names_(subject_->Names()) {
    for (const std::string& name : other_->Names()) names_.push_back("other_" + name);
  }

  const std::vector<std::string>& Names() const override { return names_; }
  motion::Facing FacingInImage() const override { return subject_->FacingInImage(); }
  double DurationS() const override { return subject_->DurationS(); }

  std::vector<Vector2d> At(double time_s) const override {
    std::vector<Vector2d> positions = subject_->At(time_s);
    for (const Vector2d& position : other_->At(time_s)) positions.emplace_back(position + Vector2d(offset_mm_, 0));
    return positions;
  }

  std::vector<double> DepthsAt(double time_s) const override {
    std::vector<double> depths = subject_->DepthsAt(time_s);
    for (const double depth : other_->DepthsAt(time_s)) depths.push_back(depth);
    return depths;
  }

 private:
  std::shared_ptr<const MarkerMotion> subject_, other_;
  double offset_mm_;
  std::vector<std::string> names_;
};

}  // namespace

std::unique_ptr<MarkerMotion> MakeWalkIn(std::shared_ptr<const MarkerMotion> motion, double walk_s,
                                         double distance_mm) {
  return std::make_unique<WalkIn>(std::move(motion), walk_s, distance_mm);
}

std::unique_ptr<MarkerMotion> MakeTwoPeople(std::shared_ptr<const MarkerMotion> subject,
                                            std::shared_ptr<const MarkerMotion> other, double offset_mm) {
  return std::make_unique<TwoPeople>(std::move(subject), std::move(other), offset_mm);
}

}  // namespace lake::synth
