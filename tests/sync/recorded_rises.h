// Rises and sittings-down of a person as two cameras record them on their own clocks.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "lake/core/numbers.h"
#include "lake/sync/movement.h"

namespace lake {

// A person's rises and sittings-down of any pace, with rests between them: knee, hip and waist over the ankle.
class Rises {
 public:
  explicit Rises(unsigned seed, double until_s = 30) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    double at_s = between(0.5, 2);
    for (bool up = true; at_s < until_s; up = !up) {
      moves_.push_back({at_s, between(0.8, 2.2), up, between(20, 45), between(0.1, 0.4)});
      at_s += moves_.back().takes_s + between(0.2, 2);
    }
  }

  // The same person at the same pace once more: each move and each rest takes that part longer or shorter, 1 SD.
  Rises Again(unsigned seed, double part) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(1, part);
    Rises again = *this;
    double before_s = 0, now_s = 0;  // ends of the moves before
    for (std::size_t i = 0; i < moves_.size(); ++i) {
      now_s += (moves_[i].begin_s - before_s) * std::max(0.2, normal(random));
      before_s = moves_[i].begin_s + moves_[i].takes_s;
      Move& move = again.moves_[i];
      move.begin_s = now_s;
      move.takes_s *= std::max(0.2, normal(random));
      move.lean_deg *= normal(random);
      now_s += move.takes_s;
    }
    return again;
  }

  // Knee, hip and waist, mm.
  std::array<Eigen::Vector2d, 3> At(double time_s) const {
    double bent = 1, lean_deg = 5;
    for (const Move& move : moves_) {
      const double part = std::clamp((time_s - move.begin_s) / move.takes_s, 0.0, 1.0),
                   done = part * part * part * (10 + part * (6 * part - 15));
      if (time_s >= move.begin_s) bent = move.up ? 1 - done : done;
      // The trunk leads a rise and follows a lowering.
      const double phase = std::clamp(part + (move.up ? move.leads : -move.leads), 0.0, 1.0);
      lean_deg += move.lean_deg * std::pow(std::sin(kPi * phase), 3);
    }
    const auto direction = [](double deg) {
      return Eigen::Vector2d(std::sin(deg * kPi / 180), std::cos(deg * kPi / 180));
    };
    const Eigen::Vector2d knee = 430 * direction(4 + 12 * bent), hip = knee + 420 * direction(2 - 85 * bent);
    return {knee, hip, hip + 450 * direction(lean_deg)};
  }

 private:
  struct Move {
    double begin_s, takes_s;
    bool up;
    double lean_deg, leads;
  };
  std::vector<Move> moves_;
};

struct Camera {
  double rate_hz = 60, noise = 0.05;                          // of the markers, unit of the picture
  double correlation = 0;                                     // of the noise, from frame to frame
  Eigen::Matrix2d view = Eigen::Matrix2d::Identity();         // per mm
  double from_s = 0, to_s = 30, offset_s = 0, drift_ppm = 0;  // the movement's time is t + offset + drift t
};

inline sync::Movement Record(const Rises& rises, const Camera& camera, unsigned seed) {
  sync::Movement movement{.file = "camera", .names = {"knee", "hip", "waist"}, .dimensions = 2, .up = 1};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, camera.noise * std::sqrt(1 - camera.correlation * camera.correlation));
  std::array<Eigen::Vector2d, 3> noise = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  const double drift = 1e-6 * camera.drift_ppm;
  const auto own = [&](double time_s) { return (time_s - camera.offset_s) / (1 + drift); };
  const auto frames = static_cast<int>((own(camera.to_s) - own(camera.from_s)) * camera.rate_hz);
  movement.values.resize(frames, 6);
  for (int i = 0; i < frames; ++i) {
    movement.time_s.push_back(own(camera.from_s) + i / camera.rate_hz);
    const auto points = rises.At(movement.time_s.back() * (1 + drift) + camera.offset_s);
    for (std::size_t m = 0; m < 3; ++m) {
      noise[m] = camera.correlation * noise[m] + Eigen::Vector2d(normal(random), normal(random));
      movement.values.block<1, 2>(i, 2 * static_cast<Eigen::Index>(m)) =
          (camera.view * points[m] + noise[m]).transpose();
    }
  }
  return movement;
}

}  // namespace lake
