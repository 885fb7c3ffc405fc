// Recordings of walking that are none, or in which no stride is whole: a sentence says what was seen, and no cycle is
// made up.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "drawn_walk.h"
#include "fitted_movement.h"
#include "lake/exchange/trial.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/movement.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

gait::LegFitResult FitAs(const motion::MarkerRecording& recording, gait::MovementKind kind,
                         double camera_distance = 0) {
  gait::LegFitResult leg = gait::FitLeg(recording, gait::MakeLegView(recording.unit, {}), {});
  if (camera_distance > 0) leg.sight = {.camera_mm = {0, 0, camera_distance}, .depths = {}};
  gait::MovementOptions options;
  options.kind = kind;
  gait::ChooseMovement(options, leg);
  return leg;
}

DrawnWalkOptions Quiet(double length_s) {
  DrawnWalkOptions walk;
  walk.length_s = length_s;
  walk.noise_mm = 0.3;
  return walk;
}

// So many seconds of a recording from one on.
motion::MarkerRecording Part(const motion::MarkerRecording& whole, double from_s, double length_s) {
  motion::MarkerRecording part = whole;
  const auto first = static_cast<std::ptrdiff_t>(from_s * 100),
             end = first + static_cast<std::ptrdiff_t>(length_s * 100);
  const auto cut = [&](auto& values) {
    values = std::decay_t<decltype(values)>(values.begin() + first, values.begin() + end);
  };
  cut(part.frame);
  cut(part.time_s);
  for (motion::MarkerTrack& marker : part.markers) cut(marker.samples);
  return part;
}

TEST(NotWalking, NoWholeStrideIsSaidAndNoneIsMeasured) {
  const motion::MarkerRecording whole = DrawWalk(Quiet(6));
  for (const double from_s : {1.0, 1.2, 1.4, 1.6, 1.8}) {
    const gait::LegFitResult leg = FitAs(Part(whole, from_s, 0.95), gait::MovementKind::kWalking);
    EXPECT_EQ(leg.movement.walk.strides, 0) << from_s;
    EXPECT_THAT(gait::MeasureGaitCycles(leg).rows, IsEmpty()) << from_s;
    EXPECT_THAT(WarningsOf(leg), HasSubstr("no cycle is measured")) << from_s;
    for (const motion::LegSample& sample : leg.motion.samples) EXPECT_FALSE(sample.repetition);
  }
}

TEST(NotWalking, WhoStandsIsSaidNotToWalk) {
  motion::MarkerRecording standing = DrawWalk(Quiet(5));
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.3);
  for (motion::MarkerTrack& marker : standing.markers) {
    const Eigen::Vector2d place = marker.samples[130].position;
    for (std::size_t i = 0; i < marker.samples.size(); ++i) {
      const double height = place.y() / 900, sway = 8 * std::sin(0.02 * static_cast<double>(i)) * height;
      marker.samples[i].position = place + Eigen::Vector2d(sway + noise(random), noise(random));
    }
  }
  const gait::LegFitResult leg = FitAs(standing, gait::MovementKind::kWalking);
  EXPECT_THAT(leg.events, IsEmpty());
  EXPECT_THAT(WarningsOf(leg), HasSubstr("nobody is seen to walk"));
  EXPECT_THAT(FitAs(standing, gait::MovementKind::kAuto).events, IsEmpty());
}

// The way of a recording, a second out of sight, and the way back as `back` makes it of each sample.
template <typename Back>
motion::MarkerRecording ThereAndBack(const motion::MarkerRecording& way, const Back& back) {
  motion::MarkerRecording both = way;
  for (std::size_t m = 0; m < way.markers.size(); ++m) {
    auto& samples = both.markers[m].samples;
    samples.resize(samples.size() + 100);
    for (const motion::MarkerSample& sample : way.markers[m].samples) samples.push_back(back(sample));
  }
  for (std::size_t i = way.frame.size(); i < both.markers[0].samples.size(); ++i) {
    both.frame.push_back(way.frame.front() + static_cast<std::int64_t>(i));
    both.time_s.push_back(static_cast<double>(i) / 100);
  }
  return both;
}

// Through the picture, out of sight, and back with the other side to the camera.
TEST(NotWalking, WhoTurnsIsMeasuredOneWayOnly) {
  const motion::MarkerRecording way = DrawWalk(Quiet(6));
  const double far = way.Find("hip")->samples.back().position.x();
  const auto back = [&](motion::MarkerSample sample) {
    sample.position.x() = far - sample.position.x();
    return sample;
  };
  const gait::LegFitResult leg = FitAs(ThereAndBack(way, back), gait::MovementKind::kAuto);
  EXPECT_THAT(WarningsOf(leg), HasSubstr("faces the other way"));
  const gait::Measures<gait::GaitCycle> cycles = gait::MeasureGaitCycles(leg);
  EXPECT_GE(cycles.rows.size(), 3u);
  const bool is_first = cycles.rows.front().begin_s.value < 6;
  for (const gait::GaitCycle& cycle : cycles.rows) {
    EXPECT_EQ(cycle.begin_s.value < 6, is_first);
    EXPECT_NEAR(cycle.stride_s.value, 1.1, 0.02);
  }
}

// A person's own pass: played backward, and followed by its mirror.
TEST(NotWalking, SaysOfPeopleWhetherTheyWalkBackwardOrFaceTheOtherWay) {
  const std::filesystem::path file = SharedData() / "walking_force_plates/walking1.trc";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recordings";
  const motion::MarkerRecording pass =
      exchange::ReadTrial(file, {NameMap(std::string(kRightLeg) + ",heel=r_calc,toe=r_toe"), {}, ""}).recording;
  motion::MarkerRecording back = pass;
  for (motion::MarkerTrack& marker : back.markers) std::ranges::reverse(marker.samples);
  const auto mirrored = [](motion::MarkerSample sample) {
    sample.position.x() *= -1;
    return sample;
  };
  const auto times_said = [](const gait::LegFitResult& leg, const char* what) {
    return std::ranges::count_if(leg.warnings, [&](const auto& said) { return said.find(what) != std::string::npos; });
  };
  const gait::LegFitResult backward = FitAs(back, gait::MovementKind::kAuto),
                           turning = FitAs(ThereAndBack(pass, mirrored), gait::MovementKind::kAuto);
  EXPECT_THAT(backward.events, IsEmpty());
  EXPECT_EQ(times_said(backward, "walks backward"), 1);
  EXPECT_EQ(times_said(turning, "walks backward"), 0);
  EXPECT_EQ(times_said(turning, "faces the other way"), 1);
  EXPECT_EQ(turning.movement.walk.strides, 0);
}

// Seen by a camera at this distance: nearer is larger.
motion::MarkerRecording Askance(double angle_deg, double camera_mm) {
  motion::MarkerRecording recording = DrawWalk(Quiet(4.5));
  const double angle = angle_deg * 0.0174533, middle = recording.Find("hip")->samples[225].position.x();
  for (motion::MarkerTrack& marker : recording.markers)
    for (motion::MarkerSample& sample : marker.samples) {
      const double along = sample.position.x() - middle, scale = camera_mm / (camera_mm - along * std::sin(angle));
      sample.position = {scale * along * std::cos(angle), 900 + scale * (sample.position.y() - 900)};
    }
  return recording;
}

TEST(NotWalking, ObliquelyIsMeasuredWithAWarningThatSaysWhatItDoes) {
  constexpr double kCamera_mm = 6000;
  const gait::LegFitResult straight = FitAs(Askance(0, kCamera_mm), gait::MovementKind::kAuto, kCamera_mm);
  for (const double angle_deg : {-25.0, -18.0, 18.0, 25.0}) {
    const gait::LegFitResult leg = FitAs(Askance(angle_deg, kCamera_mm), gait::MovementKind::kAuto, kCamera_mm);
    EXPECT_EQ(leg.movement.kind, gait::MovementKind::kWalking);
    const std::string warnings = WarningsOf(leg);
    EXPECT_THAT(warnings, HasSubstr(angle_deg > 0 ? "comes nearer" : "goes away"));
    const std::size_t said = warnings.find(", as ");
    ASSERT_NE(said, std::string::npos) << warnings;
    EXPECT_NEAR(std::stod(warnings.substr(said + 5)), std::abs(angle_deg), 3.5);
    const std::size_t off = warnings.find("off by up to ");
    ASSERT_NE(off, std::string::npos);
    // The largest difference of the drawn walk's own knee angle.
    double largest_deg = 0;
    for (std::size_t i = 0; i < leg.motion.samples.size(); ++i)
      largest_deg =
          std::max(largest_deg, std::abs(leg.motion.samples[i].knee_deg - straight.motion.samples[i].knee_deg));
    EXPECT_NEAR(std::stod(warnings.substr(off + 13)), largest_deg, 0.5 + 0.5 * largest_deg);
    EXPECT_THAT(WarningsOf(FitAs(Askance(angle_deg, kCamera_mm), gait::MovementKind::kAuto)),
                HasSubstr("only with a camera that has a calibrated plane"));
  }
  for (const double angle_deg : {-8.0, 0.0, 8.0})
    EXPECT_THAT(WarningsOf(FitAs(Askance(angle_deg, kCamera_mm), gait::MovementKind::kAuto, kCamera_mm)),
                testing::Not(HasSubstr("over the way")));
}

}  // namespace
}  // namespace lake
