// The leg fit on real motions, seen with noise of known size: people move less smoothly than drawn figures.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "lake/core/statistics.h"
#include "lake/dynamics/path_smoother.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

struct RealMotion {
  const char *name, *file, *markers;
};

constexpr RealMotion kRealMotions[] = {{"SquatsRight", "real_motions/subject4_squats1.trc", kRightLeg},
                                       {"SquatsLeft", "real_motions/subject4_squats1.trc", kLeftLeg},
                                       {"DropJump", "real_motions/subject4_DJ1.trc", kRightLeg},
                                       {"SitToStandRight", "sts_force_plates/STS1.trc", kRightLeg},
                                       {"SitToStandLeft", "sts_force_plates/STS1.trc", kLeftLeg},
                                       {"AnotherSitToStand", "opencap_sts/sts_default_markers.trc", kLeftLeg}};

fs::path FileOf(const RealMotion& motion) {
  return SharedData() / motion.file;
}

exchange::Trial Read(const RealMotion& motion) {
  return exchange::ReadTrial(FileOf(motion), {NameMap(motion.markers), {}, ""});
}

// The markers in the plane at another rate, between the file's frames by a cubic spline through them.
struct ResampledLeg {
  std::vector<double> time_s;
  std::vector<gait::LegPoints> points_mm;
  gait::LateralPlaces lateral_mm;
};

// The smoothest path through the values that are known (it has the least jerk), at other times.
std::vector<double> Interpolated(const std::vector<double>& time_s, const std::vector<double>& values,
                                 const std::vector<double>& at_s) {
  constexpr double kSigma_mm = 1e-3, kDensity = 1e9;
  std::map<double, double> known;
  for (const double t : at_s) known[t] = motion::LegSample::kUnknown;
  for (std::size_t i = 0; i < time_s.size(); ++i) known[time_s[i]] = values[i];
  dynamics::SeenPath seen{1, {}, {}, {}};
  for (const auto& [t, value] : known) {
    seen.time_s.push_back(t);
    seen.place.emplace_back(std::isfinite(value) ? value : 0, 0, 0);
    seen.sigma.push_back(std::isfinite(value) ? kSigma_mm : motion::LegSample::kUnknown);
  }
  const dynamics::PathModel model{std::vector(known.size(), kDensity)};
  const dynamics::SmoothedPath path = dynamics::SmoothPath(seen, model, dynamics::PersonPrior(1));
  std::vector<double> result;
  for (const double t : at_s)
    result.push_back(path.point[static_cast<std::size_t>(std::distance(known.begin(), known.find(t)))].position.x());
  return result;
}

ResampledLeg Resample(const exchange::Trial& trial, double rate_hz) {
  const motion::MarkerRecording& recording = trial.recording;
  const std::vector<double>& time_s = recording.time_s;
  ResampledLeg leg;
  const double length_s = time_s.back() - time_s.front();
  for (int i = 0; i <= length_s * rate_hz; ++i) leg.time_s.push_back(time_s.front() + i / rate_hz);
  leg.points_mm.resize(leg.time_s.size());
  const std::pair<const char*, std::optional<Eigen::Vector2d> gait::LegPoints::*> markers[] = {
      {"ankle", &gait::LegPoints::ankle},
      {"knee", &gait::LegPoints::knee},
      {"hip", &gait::LegPoints::hip},
      {"waist", &gait::LegPoints::waist}};
  const auto at_times = [&](const std::vector<double>& values) { return Interpolated(time_s, values, leg.time_s); };
  for (const auto& [name, point] : markers) {
    if (!recording.Find(name)) continue;
    for (gait::LegPoints& points : leg.points_mm) points.*point = Eigen::Vector2d::Zero();
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> values;
      for (const motion::MarkerSample& sample : recording.Find(name)->samples)
        values.push_back(sample.IsKnown() ? sample.position[axis] : motion::LegSample::kUnknown);
      const std::vector<double> resampled = at_times(values);
      for (std::size_t i = 0; i < leg.time_s.size(); ++i) (*(leg.points_mm[i].*point))[axis] = resampled[i];
    }
    leg.lateral_mm[name] = at_times(trial.lateral_mm.at(name));
  }
  return leg;
}

std::vector<motion::LegSample> TruthOf(const ResampledLeg& leg, motion::Facing facing) {
  std::vector<motion::LegSample> truth;
  for (const gait::LegPoints& points : leg.points_mm)
    truth.push_back(gait::MakeLegSample(points, facing, Eigen::Vector2d::UnitY()));
  return truth;
}

gait::LegFitOptions KnownSigmas() {
  gait::LegFitOptions options;
  options.known_sigmas = true;
  return options;
}

class RealMotionFit : public testing::TestWithParam<RealMotion> {
 protected:
  void SetUp() override {
    if (!fs::exists(FileOf(GetParam()))) GTEST_SKIP() << FileOf(GetParam()) << " is not here";
  }
};

// A marker's path has jolts that the density of a tenth of a second does not know: where the noise is a few hundredths
// of a millimetre, errors are up to 1.75 SD.
constexpr double kMostNormalized = 1.4, kMostNormalizedByJolts = 1.75;

TEST_P(RealMotionFit, TheEstimateIsNoWorseThanTheMeasurement) {
  const exchange::Trial trial = Read(GetParam());
  unsigned seed = 0;
  for (const double rate_hz : {25.0, 60.0})
    for (const double sigma_px : {0.03, 0.1, 0.3}) {
      const ResampledLeg leg = Resample(trial, rate_hz);
      const auto tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {sigma_px}, ++seed);
      const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView(), KnownSigmas());
      const KneeErrors errors = CompareKnee(result.motion, TruthOf(leg, result.motion.facing));
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, " << sigma_px << " px");
      EXPECT_LE(errors.rms_deg, 1.03 * errors.raw_rms_deg);
      EXPECT_GE(errors.normalized, 0.7);
      EXPECT_LE(errors.normalized, kMostNormalized);
      EXPECT_TRUE(result.outliers.empty());
    }
}

// What coding displaces lasts for some frames: the path goes along with it, so nothing is gained by taking it away.
// Where all noise was taken for white, error/SD was up to 1.6.
TEST_P(RealMotionFit, ErrorsThatLastForSomeFramesAreStatedAndDoNotBendTheEstimate) {
  const ResampledLeg leg = Resample(Read(GetParam()), 30);
  gait::LegFitOptions options = KnownSigmas();
  options.lasting_share = 0.7;
  const gait::LegFitResult result = gait::FitLeg(
      MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.1, NoiseKind::kBrief}, 7), ScaledView(), options);
  const KneeErrors errors = CompareKnee(result.motion, TruthOf(leg, result.motion.facing));
  EXPECT_GE(errors.normalized, 0.8);
  EXPECT_LE(errors.normalized, 1.3);
  EXPECT_LE(errors.rms_deg, 1.03 * errors.raw_rms_deg);
}

// The frames by themselves, without noise: what the angle in space is.
gait::LegFitResult ExactInSpace(const ResampledLeg& leg, const gait::LegView& view) {
  gait::LegFitOptions options;
  options.filter = gait::LegFilter::kNone;
  return gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, view, {1e-9, NoiseKind::kWhite, 0.1}, 1), view, options,
                      leg.lateral_mm);
}

gait::LegFitResult FitInSpace(const ResampledLeg& leg, const gait::LegView& view, double sigma_mm,
                              motion::Facing facing, unsigned seed) {
  gait::LateralPlaces lateral_mm = leg.lateral_mm;
  std::mt19937 random(seed + 1000);
  std::normal_distribution<double> noise(0, sigma_mm);
  for (auto& [name, values] : lateral_mm)
    for (double& value : values) value += noise(random);
  gait::LegFitOptions options = KnownSigmas();
  options.facing = facing;
  return gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, view, {sigma_mm}, seed), view, options, lateral_mm);
}

// Error over SD of all markers' positions, root mean square per axis.
double PositionDeviations(const motion::MarkerRecording& estimate, const motion::MarkerRecording& truth) {
  double square = 0;
  int count = 0;
  for (std::size_t m = 0; m < estimate.markers.size(); ++m)
    for (std::size_t i = 0; i < estimate.Frames(); ++i)
      if (const motion::MarkerSample& sample = estimate.markers[m].samples[i]; sample.IsKnown()) {
        square += (sample.position - truth.markers[m].samples[i].position).squaredNorm() / std::pow(sample.sigma, 2);
        count += 2;
      }
  return std::sqrt(square / count);
}

// In space, with the noise of laboratories and of cameras.
TEST_P(RealMotionFit, InSpaceTheEstimateIsNoWorseThanTheMeasurement) {
  const exchange::Trial trial = Read(GetParam());
  unsigned seed = 0;
  const gait::LegView view = gait::MakeLegView(motion::LengthUnit::kMm, {});
  for (const double rate_hz : {25.0, 60.0}) {
    const ResampledLeg leg = Resample(trial, rate_hz);
    const gait::LegFitResult exact = ExactInSpace(leg, view);
    for (const double sigma_mm : {0.02, 0.15, 1.0}) {
      const gait::LegFitResult result = FitInSpace(leg, view, sigma_mm, exact.motion.facing, ++seed);
      const KneeErrors knee = CompareKnee(result.motion, exact.motion.samples);
      const double positions = PositionDeviations(result.trajectory, exact.measured);
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, " << sigma_mm << " mm, " << result.outliers.size()
                                      << " outliers");
      EXPECT_LE(knee.rms_deg, 1.03 * knee.raw_rms_deg);
      EXPECT_GE(knee.normalized, 0.65);
      EXPECT_LE(knee.normalized, kMostNormalizedByJolts);
      EXPECT_GE(positions, 0.7);
      EXPECT_LE(positions, 1.4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, RealMotionFit, testing::ValuesIn(kRealMotions),
                         [](const auto& info) { return info.param.name; });

// Hides one marker at a time, for 1/60 to 0.7 s, about once a second; returns how many frames each gap has that a frame
// lies in, 0: none.
std::vector<std::size_t> Hide(motion::MarkerRecording& tracks, std::mt19937& random) {
  constexpr double kShortest_s = 1.0 / 60, kLongest_s = 0.7, kMargin_s = 0.4;
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::vector<double>& time_s = tracks.time_s;
  std::vector<std::size_t> gaps(time_s.size(), 0);
  for (double at_s = time_s.front() + kMargin_s; at_s < time_s.back() - kLongest_s - kMargin_s;) {
    const double end_s = at_s + kShortest_s * std::pow(kLongest_s / kShortest_s, uniform(random));
    const auto begin = std::ranges::lower_bound(time_s, at_s), end = std::ranges::lower_bound(time_s, end_s);
    const auto first = static_cast<std::size_t>(begin - time_s.begin()), frames = static_cast<std::size_t>(end - begin);
    std::vector<motion::MarkerSample>& samples = tracks.markers[random() % 3].samples;
    for (std::size_t i = first; i < first + frames; ++i) samples[i] = {}, gaps[i] = frames;
    at_s = end_s + 0.5 + 0.7 * uniform(random);
  }
  return gaps;
}

// What a person did while a marker was hidden nobody saw, and people move unevenly. Of these gaps 11 % of the frames
// were off by more than 2 SD, when a gap was taken to be as smooth as its sides.
TEST(RealMotionGaps, TheSdHoldsWhereAMarkerIsHidden) {
  struct Frames {
    std::vector<double> deviations, sigmas_deg;
    double Beyond(double sds) const {
      return static_cast<double>(
                 std::ranges::count_if(deviations, [&](double deviation) { return std::abs(deviation) > sds; })) /
             static_cast<double>(deviations.size());
    }
  } seen, brief, hidden;
  constexpr double kBrief_s = 0.1;
  std::mt19937 random(11);
  for (const RealMotion& motion : kRealMotions) {
    if (!fs::exists(FileOf(motion))) GTEST_SKIP() << FileOf(motion) << " is not here";
    const exchange::Trial trial = Read(motion);
    for (const double rate_hz : {25.0, 60.0}) {
      const ResampledLeg leg = Resample(trial, rate_hz);
      for (const double sigma_px : {0.05, 0.2}) {
        motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {sigma_px}, random());
        const std::vector<std::size_t> gaps = Hide(tracks, random);
        const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView(), KnownSigmas());
        const std::vector<motion::LegSample> truth = TruthOf(leg, result.motion.facing);
        for (std::size_t i = 0; i < gaps.size(); ++i) {
          const motion::LegSample& sample = result.motion.samples[i];
          if (!std::isfinite(sample.knee_deg)) continue;
          Frames& frames = gaps[i] == 0 ? seen : static_cast<double>(gaps[i]) < kBrief_s * rate_hz ? brief : hidden;
          frames.deviations.push_back((sample.knee_deg - truth[i].knee_deg) / sample.knee_sigma_deg);
          frames.sigmas_deg.push_back(sample.knee_sigma_deg);
        }
      }
    }
  }
  ASSERT_GT(hidden.deviations.size(), 600u);
  // Frames of one gap err alike: of some 80 gaps the share beyond 2 SD is known to 0.03.
  EXPECT_LE(hidden.Beyond(2), 0.08);
  EXPECT_LE(hidden.Beyond(4), 0.006);
  EXPECT_LE(RootMeanSquare(hidden.deviations), 1.2);
  EXPECT_GE(RootMeanSquare(hidden.deviations), 0.8);
  EXPECT_LE(seen.Beyond(2), 0.06);
  // A gap of a few frames is bridged nearly as well as the frames beside it are seen.
  EXPECT_LE(Median(brief.sigmas_deg), 2.3 * Median(seen.sigmas_deg));
}

// Of the knee angle from the truth, in its SDs, where a marker is hidden in frames begin..end − 1; the worst of three
// draws of noise.
double WorstInGap(const ResampledLeg& leg, const char* hidden, std::size_t begin, std::size_t end, double sigma_px) {
  double worst = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {sigma_px}, seed);
    const auto marker = std::ranges::find(tracks.markers, hidden, &motion::MarkerTrack::name);
    for (std::size_t i = begin; i < end; ++i) marker->samples[i] = {};
    const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView(), KnownSigmas());
    const std::vector<motion::LegSample> truth = TruthOf(leg, result.motion.facing);
    for (std::size_t i = begin; i < end; ++i) {
      const motion::LegSample& sample = result.motion.samples[i];
      worst = std::max(worst, std::abs(sample.knee_deg - truth[i].knee_deg) / sample.knee_sigma_deg);
    }
  }
  return worst;
}

// At the end of a slow squat the knee stops at once, while the hip is hidden; nothing that was seen of the thigh in
// this recording is as quick. The knee's angle was off by 4.5 SD there (5.2 in a film of it), when a hidden segment was
// taken to move as that segment does where it is seen.
TEST(RealMotionGaps, TheSdHoldsWhereOnlyOtherSegmentsAreSeenToStop) {
  const RealMotion squat = {"Squat", "real_motions/tabs_squat2.trc", "ankle=RANK,knee=RKNE,hip=RASI+RPSI,waist=RSHO"};
  if (!fs::exists(FileOf(squat))) GTEST_SKIP() << FileOf(squat) << " is not here";
  constexpr double kRateHz = 60, kBefore_s = 0.17, kAfter_s = 0.12;
  const ResampledLeg leg = Resample(Read(squat), kRateHz);
  const auto knee_deg = [](const gait::LegPoints& points) {
    return std::abs(gait::MakeLegSample(points, motion::Facing::kRight, Eigen::Vector2d::UnitY()).knee_deg);
  };
  const auto deepest = std::ranges::max_element(leg.points_mm, {}, knee_deg),
             stops = std::find_if(deepest, leg.points_mm.end() - 1, [&](const gait::LegPoints&points) {
               return knee_deg(points) < 10 && knee_deg(*(&points + 1)) > knee_deg(points);
             });
  const auto at = static_cast<std::size_t>(stops - leg.points_mm.begin());
  const std::size_t begin = at - std::lround(kBefore_s * kRateHz), end = at + std::lround(kAfter_s * kRateHz);
  EXPECT_LT(WorstInGap(leg, "hip", begin, end, 0.05), 4);
}

// The knee is hidden while the person meets the seat, where the thigh's skin is jolted. The angle was off by 5.3 SD in
// a film of it and by 5.0 and 4.8 here (seeds 1 and 2), when a hidden marker was taken to be jolted only as beside the
// gap; it is by 4.6 and 4.2 now.
TEST(RealMotionGaps, TheSdHoldsWhereTheSeatIsMet) {
  const RealMotion rise = {"SitToStand", "sts_force_plates/STS1.trc", kRightLeg};
  if (!fs::exists(FileOf(rise))) GTEST_SKIP() << FileOf(rise) << " is not here";
  constexpr double kRateHz = 30, kFrom_s = 7.68, kTo_s = 7.87;
  const ResampledLeg leg = Resample(Read(rise), kRateHz);
  const auto index_of = [&](double at_s) {
    return static_cast<std::size_t>(std::ranges::lower_bound(leg.time_s, at_s) - leg.time_s.begin());
  };
  EXPECT_LT(WorstInGap(leg, "knee", index_of(kFrom_s), index_of(kTo_s), 0.1), 4.7);
}

class GoldStandard : public testing::TestWithParam<RealMotion> {};

// As the laboratory recorded it: nothing is left out, and the angle is the markers'. With a few bad frames: those are
// left out, whichever marker they are of.
TEST_P(GoldStandard, IsTakenAsItIsAndBadFramesAreLeftOut) {
  if (!fs::exists(FileOf(GetParam()))) GTEST_SKIP() << FileOf(GetParam()) << " is not here";
  const exchange::Trial trial = Read(GetParam());
  const gait::LegView view = gait::MakeLegView(motion::LengthUnit::kMm, {});
  const gait::LegFitResult as_is = gait::FitLeg(trial.recording, view, {}, trial.lateral_mm);
  EXPECT_TRUE(as_is.outliers.empty());
  double square = 0;
  for (const motion::LegSample& sample : as_is.motion.samples)
    if (std::isfinite(sample.knee_raw_deg)) square += std::pow(sample.knee_deg - sample.knee_raw_deg, 2);
  EXPECT_LT(std::sqrt(square / static_cast<double>(as_is.motion.samples.size())), 0.025);

  for (const char* name : {"ankle", "knee", "hip"}) {
    exchange::Trial bad = trial;
    const std::size_t at = bad.recording.Frames() / 2;
    for (motion::MarkerTrack& marker : bad.recording.markers)
      for (std::size_t i = at; marker.name == name && i < at + 2; ++i)
        marker.samples[i].position += Eigen::Vector2d(400, -300);
    const gait::LegFitResult result = gait::FitLeg(bad.recording, view, {}, bad.lateral_mm);
    const auto frame = trial.recording.frame[at];
    EXPECT_THAT(result.warnings,
                testing::Contains(testing::AllOf(testing::HasSubstr(name), testing::HasSubstr("left out"),
                                                 testing::HasSubstr(fmt::format("{} to {}", frame, frame + 1)))));
    for (std::size_t i = 0; i < result.motion.samples.size(); ++i) {
      const double knee_deg = result.motion.samples[i].knee_deg, expected_deg = as_is.motion.samples[i].knee_deg;
      if (std::isfinite(knee_deg) && std::isfinite(expected_deg)) {
        EXPECT_NEAR(knee_deg, expected_deg, 1) << name << ' ' << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , GoldStandard,
    testing::Values(RealMotion{"Walking", "real_motions/subject4_walking1.trc", kRightLeg},
                    RealMotion{"DropJump", "real_motions/subject4_DJ1.trc", kLeftLeg},
                    RealMotion{"Squat", "real_motions/tabs_squat2.trc", "ankle=LANK,knee=LKNE,hip=LASI+LPSI"},
                    RealMotion{"Stairs", "real_motions/tabs_stairs3.trc", "ankle=LANK,knee=LKNE,hip=LASI+LPSI"},
                    RealMotion{"WalkingAt200Hz", "real_motions/gait_200hz.trc",
                               "ankle=RxLatMal,knee=RxLatCon,hip=RxThigh"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace lake
