#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "message_of.h"
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
  if (!forward.empty()) options.facing = motion::Facing::kRight;  // a fitted plane may look at either side
  return gait::FitLeg(trial.recording, gait::MakeLegView(trial.recording.unit, std::nullopt), options,
                      trial.lateral_mm);
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
  using gait::LegFilter;
  for (const LegFilter filter : {LegFilter::kSpline, LegFilter::kButterworth, LegFilter::kNone}) {
    const gait::LegFitResult result = FitSquat(squat, "+x", filter);
    for (std::size_t i = 20; i + 20 < squat.knee_deg.size(); ++i) {
      const double slope = (squat.knee_deg[i + 1] - squat.knee_deg[i - 1]) * 50;
      ASSERT_NEAR(result.motion.samples[i].knee_deg, squat.knee_deg[i], 0.3) << i;
      if (filter == LegFilter::kSpline) {
        ASSERT_NEAR(result.motion.samples[i].knee_deg_s, slope, 3) << i;
      }
    }
  }
}

struct Stance {
  double standing_deg, turned_deg, opening_deg;  // knee as it stands; the leg's plane, always and with the squat
  double side;                                   // 1 right leg, −1 left leg
  bool faces_left;
  double noise_mm;
  const char* name;
};

// Sit-to-stands of rigid segments, in space and as a camera square to the leg's own plane sees them.
struct StandingTrial {
  exchange::PointRecording in_space, in_plane;
  std::vector<double> knee_deg;
};

StandingTrial MakeStandingTrial(const Stance& stance, unsigned seed) {
  constexpr double kShank = 430, kThigh = 410, kRate_hz = 100;
  StandingTrial trial;
  trial.in_space.points = trial.in_plane.points = {{"ankle", {}}, {"knee", {}}, {"hip", {}}, {"waist", {}}};
  trial.in_plane.space = exchange::PointSpace::kPlane;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, stance.noise_mm);
  for (int i = 0; i < 900; ++i) {
    const double t = i / kRate_hz, phase = std::fmod(t, 4.5);
    const double seated = 1 - MinimumJerk((phase - 0.6) / 1.2) + MinimumJerk((phase - 3.0) / 1.2);
    const double shank = RadiansFromDegrees(stance.standing_deg / 2 + (12 - stance.standing_deg / 2) * seated),
                 thigh = RadiansFromDegrees(-stance.standing_deg / 2 - (84 - stance.standing_deg / 2) * seated);
    const std::array<Eigen::Vector3d, 3> vectors = {
        Eigen::Vector3d(kShank * std::sin(shank), kShank * std::cos(shank), 0),
        {kThigh * std::sin(thigh), kThigh * std::cos(thigh), 0},
        {40, 250, 0}};
    const Eigen::AngleAxisd turn(-stance.side * RadiansFromDegrees(stance.turned_deg + stance.opening_deg * seated),
                                 Eigen::Vector3d::UnitY());
    Eigen::Vector3d in_plane(20, 90, 0), in_space(20, 90, 80 * stance.side);
    for (auto* points : {&trial.in_space, &trial.in_plane}) points->frame.push_back(i), points->time_s.push_back(t);
    const double ahead = stance.faces_left ? -1 : 1;
    for (std::size_t m = 0; m < 4; ++m) {
      if (m > 0) in_plane += vectors[m - 1], in_space += turn * vectors[m - 1];
      const auto seen = [&](const Eigen::Vector3d& p, bool has_depth) {
        return Eigen::Vector3d{ahead * p.x() + noise(random), p.y() + noise(random),
                               has_depth ? p.z() + noise(random) : 0};
      };
      trial.in_space.points[m].positions.push_back(seen(in_space, true));
      trial.in_plane.points[m].positions.push_back(seen(in_plane, false));
    }
    trial.knee_deg.push_back(DegreesFromRadians(shank - thigh));
  }
  return trial;
}

// As a file has them: a .trc of space, a .csv of a plane.
gait::LegFitResult FitFile(const exchange::PointRecording& points, const std::string& name = "a.trc",
                           const gait::LegFitOptions& options = {}) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / name, points);
  const exchange::Trial trial = exchange::ReadTrial(folder / name, {});
  return gait::FitLeg(trial.recording, gait::MakeLegView(trial.recording.unit, {}), options, trial.lateral_mm);
}

class Hyperextension : public testing::TestWithParam<Stance> {};

TEST_P(Hyperextension, IsNegativeInSpaceAsInThePlane) {
  const StandingTrial trial = MakeStandingTrial(GetParam(), 11);
  const gait::LegFitResult space = FitFile(trial.in_space), plane = FitFile(trial.in_plane, "a.csv");
  EXPECT_TRUE(space.lateral) << "the file of space was read as one of a plane";
  double square = 0, raw = 0, between = 0, mean_standing = 0;
  int standing = 0;
  for (std::size_t i = 0; i < trial.knee_deg.size(); ++i) {
    const motion::LegSample& sample = space.motion.samples[i];
    square += std::pow(sample.knee_deg - trial.knee_deg[i], 2),
        raw += std::pow(sample.knee_raw_deg - trial.knee_deg[i], 2);
    between += std::pow(sample.knee_deg - plane.motion.samples[i].knee_deg, 2);
    if (std::abs(trial.knee_deg[i] - GetParam().standing_deg) < 1e-6) mean_standing += sample.knee_deg, ++standing;
  }
  const auto n = static_cast<double>(trial.knee_deg.size());
  // A frame's noise of s mm per axis is 0.33 s degrees of this knee. An opening leg's axis where it stands is carried
  // over from where it bends, which costs some hundredths.
  EXPECT_LT(std::sqrt(square / n), 0.04 + 0.1 * GetParam().noise_mm);
  EXPECT_LT(std::sqrt(raw / n), 0.04 + 0.4 * GetParam().noise_mm);
  EXPECT_LT(std::sqrt(between / n), 0.04 + 0.15 * GetParam().noise_mm);
  ASSERT_GT(standing, 200);
  // Without a bias, which |angle| has where noise is as large as the angle.
  EXPECT_NEAR(mean_standing / standing, GetParam().standing_deg, 0.04 + 0.03 * GetParam().noise_mm);
}

INSTANTIATE_TEST_SUITE_P(, Hyperextension,
                         testing::Values(Stance{-8, 0, 0, 1, false, 0.1, "InThePlane"},
                                         Stance{-8, 20, 0, 1, false, 0.3, "ToesOut"},
                                         Stance{-8, 15, 25, -1, false, 0.3, "LeftLegThatOpens"},
                                         Stance{-8, -10, 30, 1, true, 0.3, "FacesLeftAndOpens"},
                                         Stance{0, 10, 0, -1, false, 2, "StraightInNoise"},
                                         Stance{-1, 10, 20, 1, true, 1, "NearlyStraightInNoise"}),
                         [](const auto& info) { return info.param.name; });

TEST(LegInSpace, ABendToTheSideLetsTheAnglePassThroughStraight) {
  // A knee with 6° of valgus that goes from −8° to 60° and back.
  StandingTrial trial = MakeStandingTrial({-8, 0, 0, 1, false, 0.02, ""}, 3);
  for (std::size_t i = 0; i < trial.knee_deg.size(); ++i)
    trial.in_space.points[2].positions[i].z() += 410 * std::tan(RadiansFromDegrees(6));
  const gait::LegFitResult result = FitFile(trial.in_space);
  double steepest = 0, fastest = 0;
  for (std::size_t i = 1; i < trial.knee_deg.size(); ++i) {
    const double step = result.motion.samples[i].knee_deg - result.motion.samples[i - 1].knee_deg,
                 true_step = trial.knee_deg[i] - trial.knee_deg[i - 1];
    steepest = std::max(steepest, std::abs(step - true_step));
    fastest = std::max(fastest, std::abs(true_step));
  }
  // A jump would be of 12°.
  EXPECT_LT(steepest, 2 * fastest);
  EXPECT_LT(result.motion.samples[250].knee_deg, -6);
}

TEST(LegInSpace, AFacingThatIsWrongMakesFlexionNegative) {
  const StandingTrial trial = MakeStandingTrial({0, 10, 0, 1, false, 0.3, ""}, 5);
  gait::LegFitOptions options;
  options.facing = motion::Facing::kRight;
  EXPECT_GT(FitFile(trial.in_space, "a.trc", options).motion.samples.front().knee_deg, 90);
  options.facing = motion::Facing::kLeft;
  EXPECT_THROW(FitFile(trial.in_space, "a.trc", options), Error);
}

TEST(LegInSpace, ALimbThatChangesItsLengthInSpaceIsRefusedStill) {
  Squat squat = MakeSquat(0, 100, 0.1, 5);
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i)
    squat.points.points[2].positions[i].z() += 5 * squat.knee_deg[i];  // up to 540 mm sideways
  EXPECT_THAT(MessageOf([&] { FitSquat(squat, "+x", gait::LegFilter::kSpline); }),
              testing::HasSubstr("'knee' to 'hip' changes by"));
}

// Points of a program that needs no markers: the thigh is a third shorter in the deep squat than in standing. The trial
// is read, and the angle's standard deviation is wide where the length is off.
TEST(LegInSpace, ALimbWhoseLengthChangesByAThirdHasWiderSigmas) {
  Squat squat = MakeSquat(0, 100, 0.5, 5);
  auto& points = squat.points.points;
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i) {
    const Eigen::Vector3d shorter = -0.38 * squat.knee_deg[i] / 110 * (points[2].positions[i] - points[1].positions[i]);
    points[2].positions[i] += shorter, points[3].positions[i] += shorter;
  }
  const gait::LegFitResult result = FitSquat(squat, "+x", gait::LegFilter::kSpline);
  EXPECT_THAT(result.warnings, testing::Contains(testing::AllOf(testing::HasSubstr("'knee' to 'hip' changes by"),
                                                                testing::HasSubstr("standard deviation is larger"))));
  int deep = 0;
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i) {
    const motion::LegSample& sample = result.motion.samples[i];
    ASSERT_TRUE(std::isfinite(sample.knee_deg)) << i;
    EXPECT_NEAR(sample.knee_deg, squat.knee_deg[i], 2);
    if (squat.knee_deg[i] < 40) {
      EXPECT_LT(sample.knee_sigma_deg, 1) << squat.knee_deg[i];
    } else if (squat.knee_deg[i] > 105) {
      EXPECT_GT(sample.knee_sigma_deg, 4) << squat.knee_deg[i];
      ++deep;
    }
  }
  EXPECT_GT(deep, 50);
}

// Half a second in which a marker is somewhere else leaves the rest of the trial as it is.
TEST(LegInSpace, FramesOfAnotherPointAreLeftOut) {
  Squat squat = MakeSquat(0, 100, 0.5, 6);
  const auto is_wrong = [](std::size_t i) { return i >= 300 && i < 350; };  // while the person stands
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i)
    if (is_wrong(i)) squat.points.points[2].positions[i] += Eigen::Vector3d(300, 500, 0);
  const gait::LegFitResult result = FitSquat(squat, "+x", gait::LegFilter::kSpline);
  int known = 0;
  for (std::size_t i = 0; i < squat.knee_deg.size(); ++i) {
    const motion::LegSample& sample = result.motion.samples[i];
    if (is_wrong(i) || !std::isfinite(sample.knee_deg)) continue;
    EXPECT_NEAR(sample.knee_deg, squat.knee_deg[i], 2) << i;
    ++known;
  }
  EXPECT_GT(known, 700);
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
