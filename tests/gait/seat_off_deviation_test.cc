// The standard deviation of seat-off against how far the two legs of one body differ in it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

std::map<int, motion::StsEvent> SeatOffs(const gait::LegFitResult& fit) {
  std::map<int, motion::StsEvent> seat_offs;
  for (const motion::StsEvent& event : fit.events)
    if (event.kind == motion::StsEventKind::kSeatOff) seat_offs[event.repetition] = event;
  return seat_offs;
}

// Differences of two legs' seat-offs over the standard deviation of the difference.
std::vector<double> Scores(const std::map<int, motion::StsEvent>& one, const std::map<int, motion::StsEvent>& other) {
  std::vector<double> scores;
  for (const auto& [repetition, event] : one)
    if (other.contains(repetition))
      scores.push_back(std::abs(event.time_s - other.at(repetition).time_s) /
                       std::hypot(event.sd_s, other.at(repetition).sd_s));
  return scores;
}

double Within(const std::vector<double>& scores, double deviations) {
  return static_cast<double>(std::ranges::count_if(scores, [&](double score) { return score <= deviations; })) /
         static_cast<double>(scores.size());
}

// A body leaves the seat once.
TEST(SeatOffDeviation, HoldsTheDifferenceBetweenRealLegs) {
  std::vector<double> scores;
  for (const char* file : {"sts_force_plates/STS1.trc", "opencap_sts/sts_default_markers.trc"}) {
    if (!std::filesystem::exists(SharedData() / file)) GTEST_SKIP() << file << " is not here";
    const auto seat_offs = [&](const char* names) {
      const exchange::Trial trial = exchange::ReadTrial(SharedData() / file, {NameMap(names), {}, "x"});
      return SeatOffs(gait::FitLeg(trial.recording, gait::MakeLegView(motion::LengthUnit::kMm, {})));
    };
    const auto right = seat_offs(kRightLeg), left = seat_offs(kLeftLeg);
    for (const double score : Scores(right, left)) scores.push_back(score);
    for (const auto& [repetition, event] : right) {
      RecordProperty(fmt::format("{} {}", file, repetition),
                     fmt::format("{:.4f} ± {:.4f} s", event.time_s, event.sd_s));
      EXPECT_GT(event.sd_s, 0.005) << file << " " << repetition;
    }
  }
  ASSERT_EQ(scores.size(), 10u);
  EXPECT_GE(Within(scores, 1), 0.6);
  EXPECT_EQ(Within(scores, 2), 1);
}

// Markers of two legs that move alike slide on the skin, along the segment and across it, with the knee's flexion.
TEST(SeatOffDeviation, HoldsTheDifferenceBetweenLegsUnderDrawnSkin) {
  constexpr double kSkin_mm = 10;  // where the knee is bent by 90°
  std::mt19937_64 random(1);
  std::normal_distribution<double> slide(0, kSkin_mm);
  const SyntheticLeg bones = MakeSyntheticLeg({.repetitions = 1});
  const auto seat_offs = [&] {
    std::vector<gait::LegPoints> points_mm = bones.points_mm;
    const Eigen::Vector2d knee(slide(random), slide(random)), hip(slide(random), slide(random));
    for (gait::LegPoints& at : points_mm) {
      const Eigen::Vector2d shank = (*at.knee - *at.ankle).normalized(), thigh = (*at.hip - *at.knee).normalized();
      const double bent = std::abs(shank.x() * thigh.y() - shank.y() * thigh.x());
      const auto slid = [&](const Eigen::Vector2d& by, const Eigen::Vector2d& along) {
        return Eigen::Vector2d(bent * (by.x() * along + by.y() * Eigen::Vector2d(along.y(), -along.x())));
      };
      *at.hip += slid(hip, thigh);
      *at.knee += slid(knee, thigh);
    }
    return SeatOffs(gait::FitLeg(MakeTracks(bones.time_s, points_mm, ScaledView(), {}, 1), ScaledView()));
  };
  std::vector<double> scores;
  for (int body = 0; body < 40; ++body) {
    const auto one = seat_offs(), other = seat_offs();
    for (const double score : Scores(one, other)) scores.push_back(score);
  }
  ASSERT_GE(scores.size(), 38u);
  EXPECT_GE(Within(scores, 1), 0.6);
  EXPECT_GE(Within(scores, 2), 0.9);
}

}  // namespace
}  // namespace lake
