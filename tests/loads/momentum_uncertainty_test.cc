// The centre of mass's largest speeds against their standard deviations: on force plates, and of drawn people whose
// head and arms move.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "gait/synthetic_leg.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/exchange/ground_forces.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "lake/loads/loads.h"
#include "leg_path_of.h"
#include "name_map.h"
#include "places.h"

namespace lake {
namespace {

using Eigen::Vector2d;

// Errors over their standard deviations.
struct Scores {
  std::vector<double> values;

  void Add(double error, double sd) { values.push_back(error / sd); }
  double Within(double deviations) const {
    const auto count = std::ranges::count_if(values, [&](double z) { return std::abs(z) <= deviations; });
    return static_cast<double>(count) / static_cast<double>(values.size());
  }
  double Rms() const {
    double square = 0;
    for (const double z : values) square += z * z;
    return std::sqrt(square / static_cast<double>(values.size()));
  }
  std::string Text() const {
    return fmt::format("{} values: RMS {:.2f}, {:.0f} % within 1 SD, {:.0f} % within 2, mean {:.2f}", values.size(),
                       Rms(), 100 * Within(1), 100 * Within(2), Mean(values));
  }
};

// What both plates give the body since the recording's begin.
class Impulse {
 public:
  explicit Impulse(const exchange::GroundForceRecording& ground) : time_s_(ground.time_s) {
    for (std::size_t i = 0; i < time_s_.size(); ++i) {
      force_n_.push_back((ground.plates[0].force_n[i] + ground.plates[1].force_n[i]).head<2>());
      sum_ns_.push_back(
          i == 0 ? Vector2d(0, 0)
                 : Vector2d(sum_ns_.back() + (time_s_[i] - time_s_[i - 1]) / 2 * (force_n_[i - 1] + force_n_[i])));
    }
  }

  std::size_t At(double at_s) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(time_s_, at_s - 1e-9) - time_s_.begin());
  }
  double TimeS(std::size_t i) const { return time_s_[i]; }
  const Vector2d& ForceN(std::size_t i) const { return force_n_[i]; }
  Vector2d Between(std::size_t begin, std::size_t end) const { return sum_ns_[end] - sum_ns_[begin]; }

 private:
  std::vector<double> time_s_;
  std::vector<Vector2d> force_n_, sum_ns_;
};

// Of a body on its feet alone the plates give the velocity up to a constant, v = g (∫F dt / W − t), where W is what
// they read of its weight. From where the seat is left to where it is touched again, W = ∫F dt / (t + Δv/g): 95.2 to
// 97.2 % of 62.6 kg in each of ten windows, so that with 62.6 kg v would drift by 0.4 m/s a second. The constant is
// the mean over the rise.
TEST(MomentumUncertainty, LargestSpeedsAreWithinTheirDeviationsOfThePlates) {
  const std::filesystem::path folder = SharedData() / "sts_force_plates";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder.string() << " is not here";
  constexpr double kMass_kg = 62.6, kGravity_m_s2 = 9.80665, kRegained = 0.95;
  const Impulse impulse(exchange::ReadGroundForces(folder / "STS1_grf.mot"));
  for (const bool has_shoulder : {true, false}) {
    Scores forward, upward;
    std::vector<double> slowed_m_s, slowed_by_plates_m_s;
    for (const std::string names : {"ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS,shoulder=R_Shoulder",
                                    "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS,shoulder=L_Shoulder"}) {
      const std::string map = has_shoulder ? names : names.substr(0, names.find(",shoulder"));
      const exchange::Trial trial = exchange::ReadTrial(folder / "STS1.trc", {NameMap(map), {}, "x"});
      const gait::LegFitResult fit = gait::FitLeg(trial.recording, gait::MakeLegView(motion::LengthUnit::kMm, {}));
      loads::LoadsOptions options;
      options.body.mass_kg = kMass_kg;
      const loads::LoadsResult result = loads::FindLoads(fit.trajectory, fit.motion, fit.events, PathOf(fit), options);
      const loads::LegPath path = loads::MakeLegPath(fit.trajectory, PathOf(fit));
      const loads::LegBody body = loads::MakeLegBody(options.body, path);
      std::vector<Vector2d> velocity_m_s;
      for (const loads::LegPoints& points : path.frames)
        velocity_m_s.push_back(loads::CentreOfMassOf(points, body, kMass_kg, Vector2d::Zero()).velocity_m_s);
      ASSERT_EQ(result.rises.size(), 5u);
      for (const loads::RiseLoads& rise : result.rises) {
        const auto seated = std::ranges::find_if(fit.events, [&](const motion::StsEvent& event) {
          return event.repetition == rise.repetition && event.kind == motion::StsEventKind::kSeated;
        });
        ASSERT_NE(seated, fit.events.end());
        const std::size_t end = impulse.At(seated->time_s - 0.15), standing = impulse.At(rise.standing_s);
        std::size_t begin = impulse.At(rise.seat_off_s);
        double weight_n = kMass_kg * kGravity_m_s2;
        for (int pass = 0; pass < 2; ++pass) {
          while (impulse.ForceN(begin).y() < kRegained * weight_n) ++begin;
          weight_n = impulse.Between(begin, end).y() / (impulse.TimeS(end) - impulse.TimeS(begin) +
                                                        (velocity_m_s[end] - velocity_m_s[begin]).y() / kGravity_m_s2);
          begin = impulse.At(rise.seat_off_s);
        }
        while (impulse.ForceN(begin).y() < kRegained * weight_n) ++begin;
        EXPECT_NEAR(weight_n / (kMass_kg * kGravity_m_s2), 0.96, 0.02);
        std::vector<Vector2d> given_m_s;
        Vector2d constant = Vector2d::Zero();
        for (std::size_t i = begin; i <= standing; ++i) {
          given_m_s.push_back(kGravity_m_s2 * (impulse.Between(begin, i) / weight_n -
                                               Vector2d(0, impulse.TimeS(i) - impulse.TimeS(begin))));
          constant += (velocity_m_s[i] - given_m_s.back()) / static_cast<double>(standing + 1 - begin);
        }
        const auto largest = [](auto from, auto to) {
          Vector2d most = *from;
          for (auto v = from; v != to; ++v) most = most.cwiseMax(*v);
          return most;
        };
        const Vector2d error = largest(velocity_m_s.begin() + static_cast<std::ptrdiff_t>(begin),
                                       velocity_m_s.begin() + static_cast<std::ptrdiff_t>(standing) + 1) -
                               largest(given_m_s.begin(), given_m_s.end()) - constant;
        forward.Add(error.x(), rise.momentum_sd.forward_max_m_s);
        upward.Add(error.y(), rise.momentum_sd.upward_max_m_s);
        slowed_m_s.push_back(velocity_m_s[begin].x() - velocity_m_s[standing].x());
        slowed_by_plates_m_s.push_back(given_m_s.front().x() - given_m_s.back().x());
      }
    }
    // Ten windows of one person: a trunk's centre that lies elsewhere is the same in all of them.
    EXPECT_GE(forward.Within(1), 0.6) << forward.Text();
    EXPECT_EQ(forward.Within(2), 1) << forward.Text();
    EXPECT_GE(upward.Within(1), 0.6) << upward.Text();
    EXPECT_EQ(upward.Within(2), 1) << upward.Text();
    if (has_shoulder) {
      EXPECT_NEAR(Mean(slowed_m_s) / Mean(slowed_by_plates_m_s), 1, 0.05);
    }
  }
}

// A person of de Leva's segments (J. Biomech. 29(9), 1996, table 4, men), each drawn: trunk, head and arms apart.
class DrawnPerson {
 public:
  explicit DrawnPerson(std::mt19937_64& random) : arms_(static_cast<Arms>(random() % 4)), gazes_(random() % 2 == 0) {
    std::normal_distribution<double> normal;
    for (double& mass : mass_) mass *= std::exp(0.1 * normal(random));
    for (double& centre : centre_) centre += 0.03 * normal(random);
    for (int axis = 0; axis < 2; ++axis) bend_m_[axis] = 0.02 * normal(random);
  }

  // From joints (foot at rest aside), m; `risen`: 0 seated, 1 standing.
  Vector2d Centre(const Vector2d& ankle, const Vector2d& knee, const Vector2d& hip, const Vector2d& shoulder,
                  double risen) const {
    const Vector2d up = (shoulder - hip).normalized(), forward(up.y(), -up.x());
    const Vector2d head_up = gazes_ ? Vector2d(0, 1) : up, neck = shoulder + 0.088 * up;
    const double sum = 2 * (mass_[kFoot] + mass_[kShank] + mass_[kThigh] + mass_[kArm]) + mass_[kTrunk] + mass_[kHead];
    return (2 * mass_[kFoot] * (ankle + Vector2d(0.05, -0.03)) +
            2 * mass_[kShank] * (knee + centre_[kShank] * (ankle - knee)) +
            2 * mass_[kThigh] * (hip + centre_[kThigh] * (knee - hip)) +
            mass_[kTrunk] * (shoulder + centre_[kTrunk] * (hip - shoulder) + bend_m_.x() * up + bend_m_.y() * forward) +
            mass_[kHead] * (neck + 0.121 * head_up) + 2 * mass_[kArm] * (shoulder + FromShoulder(up, forward, risen))) /
           sum;
  }

 private:
  enum Segment { kFoot, kShank, kThigh, kTrunk, kHead, kArm, kSegments };
  enum class Arms { kHang, kCrossed, kForward, kSwing };

  // The arms' centre: 0.3 m from the shoulder where they are straight.
  Vector2d FromShoulder(const Vector2d& up, const Vector2d& forward, double risen) const {
    constexpr double kCentre_m = 0.3;
    switch (arms_) {
      case Arms::kCrossed:
        return -0.15 * up + 0.12 * forward;
      case Arms::kForward:
        return {kCentre_m, 0};
      case Arms::kSwing: {  // up to 60° forward and back
        const double lifted = M_PI / 3 * std::sin(M_PI * risen);
        return kCentre_m * Vector2d(std::sin(lifted), -std::cos(lifted));
      }
      default:
        return {0, -kCentre_m};
    }
  }

  std::array<double, kSegments> mass_ = {0.0137, 0.0433, 0.1416, 0.4346, 0.0694, 0.0494},
                                centre_ = {0, 0.4395, 0.4095, 0.4310, 0, 0};
  Vector2d bend_m_;  // of the spine: where the trunk's centre is beside the table's
  Arms arms_;
  bool gazes_;
};

// What is not seen of a person, head, arms, how the mass is distributed and where the joints are, is in the deviations.
TEST(MomentumUncertainty, HoldsHeadAndArmsOfDrawnPeople) {
  constexpr double kRest_s = 1;
  constexpr int kPeople = 25;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Scores forward, upward;
  for (const double move_s : {1.0, 1.4, 2.0}) {
    const SyntheticLeg leg =
        MakeSyntheticLeg({.rate_hz = 100, .repetitions = 1, .rest_s = kRest_s, .move_s = move_s, .trunk_mm = 515});
    const gait::LegFitResult fit =
        gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 1), ScaledView());
    loads::LegPathOptions path = PathOf(fit);
    path.shoulder = "waist";  // the drawn leg's last marker, at a shoulder's distance
    for (int i = 0; i < kPeople; ++i) {
      const DrawnPerson person(random);
      Vector2d largest_m_s = Vector2d::Zero();
      std::vector<Vector2d> centre_m;
      for (std::size_t k = 0; k < leg.time_s.size() && leg.time_s[k] < kRest_s + 1.2 * move_s; ++k) {
        const gait::LegPoints& points = leg.points_mm[k];
        centre_m.push_back(person.Centre(*points.ankle / kMmPerM, *points.knee / kMmPerM, *points.hip / kMmPerM,
                                         *points.waist / kMmPerM,
                                         std::clamp((leg.time_s[k] - kRest_s) / move_s, 0.0, 1.0)));
        if (k >= 2)
          largest_m_s = largest_m_s.cwiseMax((centre_m[k] - centre_m[k - 2]) / (leg.time_s[k] - leg.time_s[k - 2]));
      }
      // Markers beside the joints: 10 mm, the hip's 15 mm, the shoulder's on the acromion.
      motion::MarkerRecording seen = fit.trajectory;
      for (motion::MarkerTrack& track : seen.markers) {
        const double beside_mm = track.name == "hip" ? 15 : 10;
        Vector2d moved(beside_mm * normal(random), beside_mm * normal(random));
        if (track.name == "waist") moved.y() += 30;
        for (motion::MarkerSample& sample : track.samples) sample.position += moved;
      }
      loads::LoadsOptions options;
      options.body.mass_kg = 70;
      options.draws = 100;
      options.seed = static_cast<std::uint64_t>(i);
      const loads::LoadsResult result = loads::FindLoads(seen, fit.motion, fit.events, path, options);
      const loads::RiseLoads& rise = result.rises.front();
      forward.Add(rise.momentum.forward_max_m_s - largest_m_s.x(), rise.momentum_sd.forward_max_m_s);
      upward.Add(rise.momentum.upward_max_m_s - largest_m_s.y(), rise.momentum_sd.upward_max_m_s);
    }
  }
  for (const Scores* scores : {&forward, &upward}) {
    EXPECT_GE(scores->Within(1), 0.6) << scores->Text();
    EXPECT_GE(scores->Within(2), 0.93) << scores->Text();
  }
}

}  // namespace
}  // namespace lake
