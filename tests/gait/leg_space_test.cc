#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "synthetic_leg.h"
#include "temporary_folder.h"

namespace lake {
namespace {

struct Squat {
  exchange::PointRecording points;  // y up
  std::vector<double> knee_deg;     // between the vectors in space
};

// Rigid segments, squatting twice; the knees open, so that the leg's plane turns outwards by up to `open_deg` about the
// vertical while the foot stays.
Squat MakeSquat(double open_deg, double rate_hz, double noise_mm, unsigned seed) {
  constexpr double kShank = 430, kThigh = 410;
  Squat squat;
  squat.points.points = {{"ankle", {}}, {"knee", {}}, {"hip", {}}, {"waist", {}}};
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_mm);
  const auto frames = static_cast<int>(8 * rate_hz);
  for (int i = 0; i < frames; ++i) {
    const double t = i / rate_hz, phase = std::fmod(t, 4.0);
    const double depth = MinimumJerk((phase - 0.5) / 1.2) - MinimumJerk((phase - 2.2) / 1.2);
    const double shank = RadiansFromDegrees(4 + 28 * depth), thigh = RadiansFromDegrees(-2 - 78 * depth);
    const Eigen::AngleAxisd outwards(-RadiansFromDegrees(open_deg * depth), Eigen::Vector3d::UnitY());
    const Eigen::Vector3d ankle(20, 90, 30), ak(kShank * std::sin(shank), kShank * std::cos(shank), 0),
        kh(kThigh * std::sin(thigh), kThigh * std::cos(thigh), 0), hw(40, 250, -20);
    const std::array<Eigen::Vector3d, 3> vectors = {outwards * ak, outwards * kh, hw};
    Eigen::Vector3d point = ankle;
    squat.points.frame.push_back(i), squat.points.time_s.push_back(t);
    for (std::size_t m = 0; m < 4; ++m) {
      if (m > 0) point += vectors[m - 1];
      squat.points.points[m].positions.push_back(point + Eigen::Vector3d{noise(random), noise(random), noise(random)});
    }
    squat.knee_deg.push_back(DegreesFromRadians(std::acos(ak.dot(kh) / (kShank * kThigh))));
  }
  return squat;
}

gait::LegFitResult FitSquat(const Squat& squat, const std::string& forward, gait::LegFilter filter) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "squat.trc", squat.points);
  exchange::TrialOptions reading;
  reading.forward = forward;
  const exchange::Trial trial = exchange::ReadTrial(folder / "squat.trc", reading);
  gait::LegFitOptions options;
  options.filter = filter;
  options.facing = motion::Facing::kRight;
  return gait::FitLeg(trial.recording, gait::MakeLegView(trial.recording.unit, std::nullopt), options, trial.across_mm);
}

TEST(LegInSpace, LengthsAndFlexionOfASquatWithOpeningKneesAreThreeDimensional) {
  // Seen from the side, a thigh that turns outwards by 50° is a third shorter.
  double all_normalised = 0;
  int fits = 0;
  for (const auto& [open_deg, rate_hz, seed] : {std::tuple{50.0, 100.0, 1u}, {60.0, 60.0, 2u}, {-45.0, 250.0, 3u}})
    for (const char* forward : {"+x", ""}) {
      const Squat squat = MakeSquat(open_deg, rate_hz, 0.3, seed);
      const gait::LegFitResult result = FitSquat(squat, forward, gait::LegFilter::kSpline);
      ASSERT_EQ(result.segments.size(), 3u);
      EXPECT_NEAR(result.segments[0].length, 430, 0.1) << open_deg;
      EXPECT_NEAR(result.segments[1].length, 410, 0.1) << open_deg;
      EXPECT_LT(result.segments[1].variation, 0.3) << open_deg;
      double square = 0, normalised = 0, raw = 0;
      for (std::size_t i = 0; i < squat.knee_deg.size(); ++i) {
        const motion::LegSample& sample = result.motion.samples[i];
        const double error = sample.knee_deg - squat.knee_deg[i];
        square += error * error, normalised += std::pow(error / sample.knee_sigma_deg, 2);
        raw += std::pow(sample.knee_raw_deg - squat.knee_deg[i], 2);
      }
      const auto n = static_cast<double>(squat.knee_deg.size());
      // A single frame of 0.3 mm per axis knows the angle to 0.09°; its neighbours help.
      EXPECT_LT(std::sqrt(raw / n), 0.12) << open_deg;
      EXPECT_LT(std::sqrt(square / n), 0.06) << open_deg << " at " << rate_hz << " Hz";
      all_normalised += normalised / n, ++fits;
      EXPECT_LT(std::sqrt(normalised / n), 1.4) << open_deg << " at " << rate_hz << " Hz";
      const Json json = gait::LegFitJson(result);
      ASSERT_TRUE(json.contains("across_plane"));
      if (*forward) {
        EXPECT_NEAR(json["across_plane"]["largest_thigh_deg"].get<double>(),
                    DegreesFromRadians(
                        std::asin(std::sin(RadiansFromDegrees(80)) * std::sin(RadiansFromDegrees(std::abs(open_deg))))),
                    0.3);
        EXPECT_GT(json["across_plane"]["rms_mm"].get<double>(), 50);
      }
    }
  // A single one scatters by 0.09: the errors of a smooth curve are few independent ones.
  EXPECT_GT(std::sqrt(all_normalised / fits), 0.6);
}

TEST(LegInSpace, SpeedIsThatOfTheAngleAndOtherFiltersAgree) {
  const Squat squat = MakeSquat(50, 100, 0.05, 7);
  for (const gait::LegFilter filter : {gait::LegFilter::kSpline, gait::LegFilter::kButterworth, gait::LegFilter::kNone})
    for (std::size_t i = 20; const gait::LegFitResult& result : {FitSquat(squat, "+x", filter)})
      for (; i + 20 < squat.knee_deg.size(); ++i) {
        const double slope = (squat.knee_deg[i + 1] - squat.knee_deg[i - 1]) * 50;
        ASSERT_NEAR(result.motion.samples[i].knee_deg, squat.knee_deg[i], 0.3) << i;
        if (filter == gait::LegFilter::kSpline) {
          ASSERT_NEAR(result.motion.samples[i].knee_deg_s, slope, 3) << i;
        }
      }
}

TEST(LegInSpace, ALimbThatChangesItsLengthInSpaceIsRefusedStill) {
  Squat squat = MakeSquat(0, 100, 0.1, 5);
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i)
    squat.points.points[2].positions[i].z() += 5 * squat.knee_deg[i];  // up to 540 mm sideways
  try {
    FitSquat(squat, "+x", gait::LegFilter::kSpline);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'knee' to 'hip' changes by"));
  }
}

TEST(LegInSpace, PointsOfAPlaneInAFileOfSpaceAreALegInAPlane) {
  Squat squat = MakeSquat(0, 100, 0, 1);
  for (exchange::PointTrack& point : squat.points.points)
    for (Eigen::Vector3d& p : point.positions) p.z() = 0;
  const gait::LegFitResult result = FitSquat(squat, "+x", gait::LegFilter::kSpline);
  EXPECT_FALSE(gait::LegFitJson(result).contains("across_plane"));
  EXPECT_NEAR(result.motion.samples.front().knee_deg, squat.knee_deg.front(), 0.01);
}

}  // namespace
}  // namespace lake
