// The times that the definitions of lake/gait/sit_to_stand.h and sts_events.h give for a rise in closed form, read from
// its own angles at a rate so high that differences are derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "lake/gait/leg_angles.h"
#include "lake/motion/leg_motion.h"

namespace lake {

// When what happens, s; `leaned`: the shank leans forward most.
struct TrueRiseTimes {
  double onset_s = 0, seat_off_s = 0, leaned_s = 0, standing_s = 0, steady_s = 0, descent_s = 0, seated_s = 0;
};

class TrueRises {
 public:
  explicit TrueRises(double rate_hz) : rate_hz_(rate_hz) {}

  // The frames in order, from 0 s on.
  void Add(const gait::LegPoints& points_mm, motion::Facing facing) {
    const motion::LegSample sample = gait::MakeLegSample(points_mm, facing, Eigen::Vector2d::UnitY());
    height_.value.push_back(points_mm.hip->y());
    knee_.value.push_back(sample.knee_deg);
    trunk_.value.push_back(sample.trunk_deg);
    shank_.value.push_back(sample.shank_deg);
    hip_.value.push_back(sample.trunk_deg - sample.thigh_deg);
  }

  // Of a rise, with the rest behind it, and the lowering that follows.
  TrueRiseTimes Times(double rise_s, double lowering_s, double end_s) {
    Derive();
    const std::size_t begin = At(rise_s), middle = At(lowering_s), end = At(end_s);
    const std::size_t lift = height_.Fastest(begin, middle), forward = trunk_.Fastest(begin, lift);
    TrueRiseTimes times;
    times.onset_s = Time(Slow(trunk_, 0.03 * trunk_.Peak(begin, lift), forward, -1));
    times.seat_off_s = Time(Slow(height_, 0.10 * height_.Peak(begin, middle), lift, -1));
    std::size_t leaned = At(times.seat_off_s);
    for (std::size_t i = leaned; i < middle; ++i)
      if (shank_.value[i] > shank_.value[leaned]) leaned = i;
    times.leaned_s = Time(leaned);
    const std::size_t standing = Slow(knee_, 0.05 * knee_.Peak(begin, middle), knee_.Fastest(begin, middle), 1);
    times.standing_s = Time(standing);
    std::size_t steady = standing;
    for (const Course* course : {&hip_, &knee_, &height_})
      for (std::size_t i = standing; i < middle; ++i)
        if (std::abs(course->speed[i]) > 0.05 * course->Peak(begin, standing)) steady = std::max(steady, i + 1);
    times.steady_s = Time(steady);
    times.descent_s = Time(Slow(knee_, 0.05 * knee_.Peak(middle, end), knee_.Fastest(middle, end), -1));
    times.seated_s = Time(Slow(height_, 0.10 * height_.Peak(middle, end), height_.Fastest(middle, end), 1));
    return times;
  }

 private:
  struct Course {
    std::vector<double> value, speed;

    std::size_t Fastest(std::size_t begin, std::size_t end) const {
      std::size_t fastest = begin;
      for (std::size_t i = begin; i < end; ++i)
        if (std::abs(speed[i]) > std::abs(speed[fastest])) fastest = i;
      return fastest;
    }
    double Peak(std::size_t begin, std::size_t end) const { return std::abs(speed[Fastest(begin, end)]); }
  };

  void Derive() {
    for (Course* course : {&height_, &knee_, &trunk_, &shank_, &hip_}) {
      course->speed.assign(course->value.size(), 0);
      for (std::size_t i = 1; i + 1 < course->value.size(); ++i)
        course->speed[i] = (course->value[i + 1] - course->value[i - 1]) * rate_hz_ / 2;
    }
  }

  std::size_t At(double time_s) const {
    return std::min(static_cast<std::size_t>(std::lround(time_s * rate_hz_)), height_.value.size() - 1);
  }
  double Time(std::size_t i) const { return static_cast<double>(i) / rate_hz_; }

  // From a frame, in steps of `by`, to the first at which the speed is not above the limit.
  static std::size_t Slow(const Course& course, double limit, std::size_t i, std::ptrdiff_t by) {
    while (std::abs(course.speed[i]) > limit) i = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + by);
    return i;
  }

  double rate_hz_;
  Course height_, knee_, trunk_, shank_, hip_;
};

}  // namespace lake
