#include "lake/gait/leg_fit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <set>

#include "draws.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/picture_scale.h"
#include "message_of.h"
#include "synthetic_leg.h"
#include "temporary_folder.h"

namespace lake {
namespace {

// Synthetic recordings with the detections' noise alone. Errors over sigmas: 1 is right. Errors of a smooth curve are
// few independent ones, so a single recording scatters: here by 0.05 about 0.78, at 240 Hz by 0.02 about 0.58, as some
// lasting noise is always reckoned with. kCautious is for those whose sigma is known to be up to 1.8 times too large.
constexpr double kCautious = 0.55, kSingle = 0.65;
void ExpectHonest(const KneeErrors& errors, double least = kSingle) {
  EXPECT_GE(errors.cover, 0.90);
  EXPECT_GE(errors.normalized, least);
  EXPECT_LE(errors.normalized, 1.25);
  EXPECT_LE(errors.peak_deg, 0.1);
}

std::string FitMessage(const motion::MarkerRecording& tracks, const gait::LegView& view,
                       const gait::LegFitOptions& options = {}) {
  return MessageOf([&] { gait::FitLeg(tracks, view, options); });
}

struct FitCase {
  const char* name;
  SyntheticLegOptions leg;
  bool calibrated;
  NoiseKind noise;
  double least_normalized = 0.75;  // of the three recordings together
};

class LegFitAccuracy : public testing::TestWithParam<FitCase> {};

TEST_P(LegFitAccuracy, KneeAngleIsRightAndItsSigmaHonest) {
  double square = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const SyntheticLeg leg = MakeSyntheticLeg(GetParam().leg, seed);
    const gait::LegView view = GetParam().calibrated ? CalibratedView() : ScaledView();
    const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, view, {0.03, GetParam().noise}, seed);
    const gait::LegFitResult result = gait::FitLeg(tracks, view);
    const KneeErrors errors = CompareKnee(result.motion, leg.truth);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", rms " << errors.rms_deg << ", raw " << errors.raw_rms_deg);
    ExpectHonest(errors, std::min(kSingle, GetParam().least_normalized));
    square += errors.normalized * errors.normalized / 3;
    // Noise that changes slowly cannot be told from motion: then the fit is only required not to be worse than single
    // frames.
    EXPECT_LE(errors.rms_deg, GetParam().noise == NoiseKind::kWhite ? 0.02 : 1.02 * errors.raw_rms_deg);
    EXPECT_EQ(result.motion.facing, GetParam().leg.facing);
    EXPECT_TRUE(result.outliers.empty());
    EXPECT_TRUE(result.warnings.empty());
  }
  EXPECT_GE(std::sqrt(square), GetParam().least_normalized);
}

INSTANTIATE_TEST_SUITE_P(
    , LegFitAccuracy,
    testing::Values(
        FitCase{"Rigid", {}, false, NoiseKind::kWhite}, FitCase{"RigidThroughLens", {}, true, NoiseKind::kWhite},
        FitCase{"Skin", {.skin_mm = 12}, true, NoiseKind::kWhite},
        FitCase{"FacingLeft", {.skin_mm = 12, .facing = motion::Facing::kLeft}, true, NoiseKind::kWhite},
        FitCase{"StartsStanding", {.starts_standing = true, .facing = motion::Facing::kLeft}, false, NoiseKind::kWhite},
        FitCase{"IrregularStamps", {.time_jitter = 0.8}, false, NoiseKind::kWhite},
        FitCase{"SlowMotion240Hz", {.rate_hz = 240, .repetitions = 1}, false, NoiseKind::kWhite, kCautious},
        FitCase{"Autoregressive", {.skin_mm = 6}, false, NoiseKind::kAutoregressive},
        FitCase{"FrozenByVideoCoding", {.repetitions = 4}, true, NoiseKind::kFrozen}),
    [](const auto& info) { return info.param.name; });

TEST(LegFit, FillsNothingBeforeAMarkerIsFirstSeenOrAfterItsLast) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 5);
  std::vector<motion::MarkerSample>& ankle = tracks.markers[0].samples;
  const std::size_t first = 40, gap = 100, last = ankle.size() - 30;
  std::fill(ankle.begin(), ankle.begin() + first, motion::MarkerSample{});
  std::fill(ankle.begin() + last + 1, ankle.end(), motion::MarkerSample{});
  std::fill(ankle.begin() + gap, ankle.begin() + gap + 5, motion::MarkerSample{});
  const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
  for (std::size_t i = 0; i < ankle.size(); ++i) {
    const auto expected = i < first || i > last     ? motion::SampleStatus::kMissing
                          : i >= gap && i < gap + 5 ? motion::SampleStatus::kFilled
                                                    : motion::SampleStatus::kDetected;
    EXPECT_EQ(result.trajectory.markers[0].samples[i].status, expected) << "frame " << i;
    EXPECT_EQ(std::isfinite(result.motion.samples[i].knee_deg), expected != motion::SampleStatus::kMissing) << i;
  }
}

TEST(LegFit, SegmentLengthsAreExactThroughACalibratedPlane) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const gait::LegView view = CalibratedView();
  const gait::LegFitResult result = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, view, {0.1}, 4), view);
  const double expected[] = {430, 410, 260};
  ASSERT_EQ(result.segments.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_NEAR(result.segments[s].length, expected[s], 0.3);
    EXPECT_LT(result.segments[s].length_sigma, 0.1);
    EXPECT_LT(result.segments[s].variation,
              0.2);  // rigid: what noise of 0.3 mm per axis leaves of a difference of variances
  }
}

TEST(LegFit, VaryingLengthsAreReportedNotForcedRigid) {
  const SyntheticLeg leg = MakeSyntheticLeg({.skin_mm = 20});
  const gait::LegView view = CalibratedView();
  const gait::LegFitResult result = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, view, {0.03}, 4), view);
  std::vector<double> shank;
  double worst_mm = 0;
  for (std::size_t i = 0; i < leg.truth.size(); ++i) {
    shank.push_back(leg.truth[i].ak.norm());
    worst_mm = std::max(worst_mm, std::abs(result.motion.samples[i].ak.norm() - leg.truth[i].ak.norm()));
  }
  EXPECT_NEAR(result.segments[0].variation, StandardDeviation(shank), 0.05);
  EXPECT_LT(worst_mm, 0.5);  // five sigma of a single detection, 0.1 mm
}

// Half a second at 60 Hz, at rest, at seat-off, in full motion and at standing. Not all of each time, but each marker
// at each of three times or two, and each time of three markers or two.
TEST(LegFit, AMarkerHiddenForHalfASecondIsBridged) {
  unsigned count = 0;
  for (const double skin_mm : {0.0, 12.0})
    for (std::size_t marker = 0; marker < 4; ++marker)
      for (const std::size_t first : {20u, 95u, 120u, 150u, 210u}) {
        if (count++ % Draws(2, 1) != 0) continue;
        const SyntheticLeg leg = MakeSyntheticLeg({.skin_mm = skin_mm});
        motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 5);
        const motion::MarkerTrack truth = tracks.markers[marker];
        for (std::size_t i = first; i < first + 30; ++i) tracks.markers[marker].samples[i] = {};
        const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
        for (std::size_t i = first; i < first + 30; ++i) {
          const motion::MarkerSample& sample = result.tracks.markers[marker].samples[i];
          ASSERT_EQ(sample.status, motion::SampleStatus::kFilled);
          EXPECT_LT((sample.position - truth.samples[i].position).norm(), 2) << truth.name << " frame " << i;
          EXPECT_TRUE(std::isnan(result.motion.samples[i].knee_raw_deg) || marker == 3);
          EXPECT_TRUE(std::isfinite(result.motion.samples[i].knee_deg));
        }
        EXPECT_GT(result.tracks.markers[marker].samples[first + 15].sigma, 0);
        const KneeErrors errors = CompareKnee(result.motion, leg.truth);
        EXPECT_GE(errors.cover, 0.90);
        EXPECT_LE(errors.normalized, 1.5);
      }
}

TEST(LegFit, ALongAbsenceIsMissingNotInvented) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 5);
  for (auto& marker : tracks.markers)
    for (std::size_t i = 100; i < 400; ++i) marker.samples[i] = {};
  const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
  EXPECT_EQ(result.tracks.markers[1].samples[250].status, motion::SampleStatus::kMissing);
  EXPECT_TRUE(std::isnan(result.motion.samples[250].knee_deg));
  EXPECT_GT(result.markers[1].missing, 200);
}

TEST(LegFit, OutliersAreListedAndDoNotPull) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  for (const unsigned seed : {3u, 4u, 6u, 7u, 8u}) {
    motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, seed);
    std::mt19937 random(seed);
    std::set<std::pair<std::int64_t, std::string>> wrong;
    for (std::size_t burst = 0; burst < 10; ++burst) {
      motion::MarkerTrack& marker = tracks.markers[random() % 4];
      const std::size_t first = 30 + 60 * burst, length = 1 + random() % 6;
      const double angle = static_cast<double>(random() % 628) / 100, size_px = 20 + static_cast<double>(random() % 40);
      for (std::size_t i = first; i < first + length; ++i) {
        marker.samples[i].position += size_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        wrong.emplace(static_cast<std::int64_t>(i), marker.name);
      }
    }
    const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
    std::set<std::pair<std::int64_t, std::string>> listed;
    for (const gait::OutlierReport& outlier : result.outliers) {
      listed.emplace(outlier.frame, outlier.marker);
      EXPECT_NE(result.tracks.Find(outlier.marker)->samples[static_cast<std::size_t>(outlier.frame)].status,
                motion::SampleStatus::kDetected);
    }
    EXPECT_EQ(listed, wrong) << "seed " << seed;
    const KneeErrors errors = CompareKnee(result.motion, leg.truth);
    EXPECT_LT(errors.rms_deg, 0.02) << "seed " << seed;
    EXPECT_GE(errors.cover, 0.90) << "seed " << seed;
  }
}

// A marker that is hidden but for a moment, when something `size_px` away is taken for it.
struct HiddenButForAMoment {
  motion::MarkerRecording tracks;
  SyntheticLeg leg;
  int seen = 0;  // meanwhile
};

HiddenButForAMoment HideButForAMoment(unsigned seed, double size_px) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  HiddenButForAMoment hidden;
  hidden.leg =
      MakeSyntheticLeg({.rate_hz = seed % 2 ? 60.0 : 25.0, .repetitions = 1, .skin_mm = seed % 3 ? 0.0 : 12.0}, seed);
  const std::vector<double>& time_s = hidden.leg.time_s;
  hidden.tracks = MakeTracks(time_s, hidden.leg.points_mm, ScaledView(), {0.05}, seed);
  std::vector<motion::MarkerSample>& samples = hidden.tracks.markers[random() % 3].samples;
  const double begin_s = 0.5 + 3 * uniform(random), hidden_s = 0.4 + 0.8 * uniform(random);
  const double seen_s = begin_s + hidden_s * uniform(random), angle = 2 * std::numbers::pi * uniform(random);
  const int most_seen = 1 + static_cast<int>(random() % 4);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (time_s[i] < begin_s || time_s[i] >= begin_s + hidden_s) continue;
    if (time_s[i] < seen_s || hidden.seen == most_seen)
      samples[i] = {};
    else
      samples[i].position += size_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)), ++hidden.seen;
  }
  return hidden;
}

double WorstDeviation(const gait::LegFitResult& result, const std::vector<motion::LegSample>& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (const motion::LegSample& sample = result.motion.samples[i]; std::isfinite(sample.knee_deg))
      worst = std::max(worst, std::abs(sample.knee_deg - truth[i].knee_deg) / sample.knee_sigma_deg);
  return worst;
}

// Half of these were followed, by up to 23 deg at an SD of 0.02.
TEST(LegFit, ALoneWrongDetectionWithinAGapDoesNotPull) {
  int wrong = 0, left_out = 0;
  for (unsigned seed = 1; seed <= Draws(16, 40); ++seed) {
    const double size_px = 15 * std::pow(20, (seed * 7 % 40) / 40.0);
    const HiddenButForAMoment hidden = HideButForAMoment(seed, size_px);
    gait::LegFitOptions options;
    options.known_sigmas = seed % 4 < 2;
    const gait::LegFitResult result = gait::FitLeg(hidden.tracks, ScaledView(), options);
    wrong += hidden.seen, left_out += static_cast<int>(result.outliers.size());
    // A frame in a thousand beyond 3 SD, and a gap's frames err alike.
    EXPECT_LE(WorstDeviation(result, hidden.leg.truth), 5) << "seed " << seed << ", " << size_px << " px";
  }
  EXPECT_GE(left_out, 0.95 * wrong);
}

TEST(LegFit, WhatIsSeenForAMomentWithinAGapIsUsed) {
  for (unsigned seed = 1; seed <= Draws(8, 20); ++seed) {
    const HiddenButForAMoment hidden = HideButForAMoment(seed, 0);
    const gait::LegFitResult result = gait::FitLeg(hidden.tracks, ScaledView());
    EXPECT_TRUE(result.outliers.empty()) << "seed " << seed;
    EXPECT_LE(WorstDeviation(result, hidden.leg.truth), 5) << "seed " << seed;
  }
}

TEST(LegFit, SigmasThatAreTooSmallAreNoticed) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const gait::LegFitResult result = gait::FitLeg(
      MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.06, NoiseKind::kWhite, 0.03}, 5), ScaledView());
  for (const gait::MarkerReport& marker : result.markers)
    EXPECT_NEAR(marker.noise_scale, 2, 0.2);  // 670 frames: 2 % SD
  ExpectHonest(CompareKnee(result.motion, leg.truth), kCautious);
}

// Real markers jitter on the skin by more than a camera's noise, from frame to frame. Where the noise is known, that is
// motion: with white jitter of twice the noise the best estimate is off by 2/√5 of the noise, what takes it for noise
// by twice the noise.
TEST(LegFit, WhatScattersBeyondKnownSigmasIsMotion) {
  constexpr double kNoise_px = 0.05, kMmPerPx = 2;
  for (const unsigned seed : {1u, 2u}) {
    SyntheticLeg leg = MakeSyntheticLeg({}, seed);
    std::mt19937 random(seed + 50);
    std::normal_distribution<double> jitter(0, 2 * kNoise_px * kMmPerPx);
    for (std::size_t i = 0; i < leg.points_mm.size(); ++i) {
      gait::LegPoints& points = leg.points_mm[i];
      for (auto* point : {&points.ankle, &points.knee, &points.hip, &points.waist})
        **point += Eigen::Vector2d{jitter(random), jitter(random)};
      leg.truth[i] = gait::MakeLegSample(points, motion::Facing::kRight, Eigen::Vector2d::UnitY());
    }
    const auto tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {kNoise_px}, seed);
    gait::LegFitOptions options;
    options.known_sigmas = true;
    const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView(), options);
    const KneeErrors known = CompareKnee(result.motion, leg.truth);
    EXPECT_LE(known.rms_deg, known.raw_rms_deg) << seed;
    EXPECT_LE(known.normalized, 1.5) << seed;
    for (const gait::MarkerReport& marker : result.markers) EXPECT_GE(marker.noise_scale, 2) << marker.name;  // √5
    const KneeErrors smoothed = CompareKnee(gait::FitLeg(tracks, ScaledView()).motion, leg.truth);
    EXPECT_GE(smoothed.rms_deg, 1.2 * smoothed.raw_rms_deg) << "this would show nothing";
  }
}

TEST(LegFit, SigmasThatAreNotKnownAreEstimated) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.05}, 5);
  for (auto& marker : tracks.markers)
    for (auto& sample : marker.samples) sample.sigma = 0;
  const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
  EXPECT_NEAR(result.tracks.markers[0].samples[5].sigma, 0.05, 0.005);
  ExpectHonest(CompareKnee(result.motion, leg.truth), kCautious);
}

TEST(LegFit, ThreeMarkersAndExtraOnesWork) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 5);
  tracks.markers[3].name = "exo_knee";  // some other marker, hidden for a while
  const motion::MarkerTrack truth = tracks.markers[3];
  for (std::size_t i = 130; i < 145; ++i) tracks.markers[3].samples[i] = {};
  const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView());
  EXPECT_EQ(result.segments.size(), 2u);
  EXPECT_TRUE(std::isnan(result.motion.samples[10].trunk_deg));
  EXPECT_TRUE(std::isnan(result.motion.samples[10].hw.x()));
  ExpectHonest(CompareKnee(result.motion, leg.truth));
  for (std::size_t i = 130; i < 145; ++i) {
    EXPECT_EQ(result.tracks.markers[3].samples[i].status, motion::SampleStatus::kFilled);
    EXPECT_LT((result.tracks.markers[3].samples[i].position - truth.samples[i].position).norm(), 2);
  }
  EXPECT_FALSE(result.events.empty());
}

TEST(LegFit, DepthPutsAMarkerWhereItIs) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  gait::LegView truth = CalibratedView();
  truth.depths["knee"].mm = 40;
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, truth, {0.03}, 6);
  const gait::LegFitResult with = gait::FitLeg(tracks, truth), without = gait::FitLeg(tracks, CalibratedView());
  double worst_mm = 0, worst_without_mm = 0;
  for (std::size_t i = 0; i < leg.time_s.size(); ++i) {
    worst_mm = std::max(worst_mm, (with.trajectory.Find("knee")->samples[i].position - *leg.points_mm[i].knee).norm());
    worst_without_mm = std::max(worst_without_mm,
                                (without.trajectory.Find("knee")->samples[i].position - *leg.points_mm[i].knee).norm());
  }
  EXPECT_LT(worst_mm, 0.3);
  // The report says how large the error can be: so many mm per mm of depth.
  const gait::MarkerReport& report = without.markers[1];
  EXPECT_GT(worst_without_mm, 1);
  EXPECT_NEAR(40 * report.parallax_per_depth, worst_without_mm, 0.35 * worst_without_mm);
}

TEST(LegFit, AnglesDoNotDependOnTheScale) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7);
  const gait::LegFitResult mm = gait::FitLeg(tracks, ScaledView()), px = gait::FitLeg(tracks, gait::LegView{});
  EXPECT_EQ(px.motion.unit, motion::LengthUnit::kPx);
  EXPECT_EQ(px.trajectory.unit, motion::LengthUnit::kPx);
  EXPECT_NEAR(mm.segments[0].length, 2 * px.segments[0].length, 1e-3);
  for (std::size_t i = 0; i < leg.time_s.size(); ++i)
    EXPECT_NEAR(mm.motion.samples[i].knee_deg, px.motion.samples[i].knee_deg, 1e-3);
  ASSERT_EQ(mm.events.size(), px.events.size());
  for (std::size_t i = 0; i < mm.events.size(); ++i) EXPECT_NEAR(mm.events[i].time_s, px.events[i].time_s, 0.035);
}

// Stored narrower than shown: the angles and lengths are those of the picture as shown.
TEST(LegFit, PixelsThatAreNotSquareAreStretched) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  gait::LegView square = ScaledView();
  for (const double aspect : {32.0 / 27, 4.0 / 3, 8.0 / 9}) {
    gait::LegView view = square;
    view.pixel_aspect = aspect;
    const Eigen::Vector2d mm(300, 250), px = gait::RecordedFromPlane<double>(view, mm, 0);
    EXPECT_LT((gait::PlaneFromRecorded(view, px, 0) - mm).norm(), 1e-9);
    EXPECT_NEAR(px.x() * aspect, gait::RecordedFromPlane<double>(square, mm, 0).x(), 1e-9);
    const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, view, {0.03}, 7);
    const gait::LegFitResult result = gait::FitLeg(tracks, view);
    const gait::LegFitResult truth = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, square, {0.03}, 7), square);
    for (std::size_t i = 0; i < leg.time_s.size(); ++i)
      EXPECT_NEAR(result.motion.samples[i].knee_deg, truth.motion.samples[i].knee_deg, 0.1);
    EXPECT_NEAR(result.segments[0].length, truth.segments[0].length, 0.5);
  }
}

TEST(PictureScale, ABarIsMeasuredInSquarePixels) {
  const auto mm_per_px = [](const std::array<double, 5>& bar) {
    gait::PictureScale picture;
    picture.scale = bar;
    picture.pixel_aspect = 1.5;
    const gait::LegView view = gait::MakeView(picture, {}, {}, [](const std::string&) {});
    EXPECT_EQ(view.pixel_aspect, 1.5);
    return view.mm_per_px.value();
  };
  EXPECT_NEAR(mm_per_px({0, 0, 100, 0, 300}), 2, 1e-12);
  EXPECT_NEAR(mm_per_px({0, 0, 0, 150, 300}), 2, 1e-12);
}

// The view of tracks whose video is not at hand is the one that the tracker had.
TEST(PictureScale, GivesTheViewOfACameraFileOrABar) {
  const TemporaryFolder folder;
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const gait::LegView calibrated = CalibratedView();
  camera::WriteCameraProfile(folder / "camera.yaml", {*calibrated.camera, calibrated.camera_from_plane, {}, {}});
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, calibrated, {0.03}, 8);
  std::vector<std::string> warnings;
  const auto warn = [&](const std::string& text) { warnings.push_back(text); };
  gait::PictureScale picture;
  picture.camera = folder / "camera.yaml";
  const gait::LegView read = gait::ViewOf(picture, tracks, std::nullopt, warn);
  const Eigen::Vector2d px(600, 300);
  EXPECT_LT((gait::PlaneFromRecorded(read, px, 0) - gait::PlaneFromRecorded(calibrated, px, 0)).norm(), 1e-6);
  EXPECT_TRUE(warnings.empty());
  picture.scale = {0, 0, 100, 0, 200};
  EXPECT_FALSE(gait::ViewOf(picture, tracks, std::nullopt, warn).mm_per_px);
  EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("--scale is not used")));
  picture.camera.reset();
  EXPECT_EQ(gait::ViewOf(picture, tracks, 5, warn).mm_per_px, 2);
  picture.scale.reset();
  EXPECT_EQ(gait::ViewOf(picture, tracks, 5, warn).mm_per_px, 5);  // the file's own
}

// Four known points of the plane do for a calibrated one: with the lens, and, where it has none, without.
TEST(PictureScale, KnownPointsGiveThePlane) {
  const gait::LegView calibrated = CalibratedView();
  camera::Camera pinhole = *calibrated.camera;
  pinhole.distortion = {};
  gait::LegView truth = calibrated;
  std::vector<std::string> warnings;
  const auto warn = [&](const std::string& text) { warnings.push_back(text); };
  for (const bool knows_lens : {true, false}) {
    truth.camera = knows_lens ? *calibrated.camera : pinhole;
    gait::PictureScale picture;
    for (const Eigen::Vector2d& mm : {Eigen::Vector2d(0, 0), {500, 0}, {450, 800}, {-50, 900}, {200, 400}}) {
      const Eigen::Vector2d px = gait::RecordedFromPlane<double>(truth, mm, 0);
      picture.plane_points += fmt::format("{},{}={},{};", px.x(), px.y(), mm.x(), mm.y());
    }
    picture.plane_points.pop_back();
    std::optional<camera::CameraProfile> profile;
    if (knows_lens) profile = {{*truth.camera, {}, {}, {}}};
    const gait::LegView view = gait::MakeView(picture, profile, {}, warn);
    EXPECT_EQ(PlaneUnit(view), motion::LengthUnit::kMm);
    const Eigen::Vector2d mm(300, 250), px = gait::RecordedFromPlane<double>(truth, mm, 0);
    EXPECT_LT((gait::PlaneFromRecorded(view, px, 0) - mm).norm(), 1e-6) << knows_lens;
    EXPECT_LT((gait::RecordedFromPlane<double>(view, mm, 0) - px).norm(), 1e-6) << knows_lens;
    EXPECT_NEAR(gait::PlaneUnitsPerRecorded(view, mm, 0), gait::PlaneUnitsPerRecorded(truth, mm, 0), 1e-6);
    picture.scale = {0, 0, 100, 0, 200};
    EXPECT_THAT([&] { gait::MakeView(picture, profile, {}, warn); },
                testing::ThrowsMessage<UsageError>(testing::HasSubstr("leave one out")));
  }
  EXPECT_TRUE(warnings.empty());
}

TEST(LegFit, TheFieldsFiltersAreOffered) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.3}, 8);
  gait::LegFitOptions options;
  options.filter = gait::LegFilter::kNone;
  const gait::LegFitResult none = gait::FitLeg(tracks, ScaledView(), options);
  for (const motion::LegSample& sample : none.motion.samples) EXPECT_NEAR(sample.knee_deg, sample.knee_raw_deg, 1e-12);
  EXPECT_NEAR(CompareKnee(none.motion, leg.truth).normalized, 1, 0.1);
  options.filter = gait::LegFilter::kButterworth;
  const KneeErrors butterworth = CompareKnee(gait::FitLeg(tracks, ScaledView(), options).motion, leg.truth);
  EXPECT_LT(butterworth.rms_deg, 0.7 * butterworth.raw_rms_deg);
  EXPECT_NEAR(butterworth.normalized, 1, 0.35);
}

// What a filter takes of the movement is in its standard deviations; one that takes the movement itself is refused.
TEST(LegFit, AFilterCannotTakeTheMovementAwayUnseen) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 8);
  gait::LegFitOptions options;
  options.filter = gait::LegFilter::kButterworth;
  for (const double cutoff_hz : {0.8, 1.5, 6.0}) {
    options.cutoff_hz = cutoff_hz;
    const KneeErrors errors = CompareKnee(gait::FitLeg(tracks, ScaledView(), options).motion, leg.truth);
    EXPECT_NEAR(errors.normalized, 1, 0.35) << cutoff_hz;  // of noise alone it was 200 at 0.8 Hz
  }
  for (const double cutoff_hz : {0.1, 0.3}) {
    options.cutoff_hz = cutoff_hz;
    EXPECT_THAT(FitMessage(tracks, ScaledView(), options), testing::HasSubstr("% of the knee angle's variance"))
        << cutoff_hz;
  }
}

// A cutoff says what motion is, of all markers: errors that last are noise then as well.
TEST(LegFit, ACutoffTakesErrorsThatLastAwayToo) {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.3, NoiseKind::kBrief}, 8);
  motion::MarkerTrack extra = *tracks.Find("knee");
  extra.name = "exo_knee";
  tracks.markers.push_back(extra);
  gait::LegFitOptions options;
  options.known_sigmas = true;
  options.cutoff_hz = 3;
  const gait::LegFitResult none = gait::FitLeg(tracks, ScaledView(), options);
  options.lasting_share = 0.7;
  const gait::LegFitResult lasting = gait::FitLeg(tracks, ScaledView(), options);
  for (const char* name : {"knee", "exo_knee"})
    for (std::size_t i = 0; i < tracks.Frames(); ++i)
      EXPECT_EQ(none.trajectory.Find(name)->samples[i].position, lasting.trajectory.Find(name)->samples[i].position);
}

TEST(LegFit, FiveMinutesAreFittedWhole) {
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 54, .skin_mm = 12});
  ASSERT_GT(leg.time_s.size(), 18000u);
  const gait::LegFitResult result =
      gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, CalibratedView(), {}, 1), CalibratedView());
  ExpectHonest(CompareKnee(result.motion, leg.truth));
  EXPECT_EQ(result.events.size(), 54u * 5);
}

// The refusal, or all warnings.
std::string WhatIsSaid(const motion::MarkerRecording& tracks) {
  std::string said;
  const std::string refusal = MessageOf([&] {
    for (const std::string& warning : gait::FitLeg(tracks, ScaledView()).warnings) said += warning;
  });
  return refusal + said;
}

TEST(LegFit, TimesThatWereRoundedAreNamedNotTheMarkers) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1}, 5);
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.05}, 5);
  const auto said = [&](double unit_s) {
    for (std::size_t i = 0; i < tracks.Frames(); ++i) tracks.time_s[i] = std::round(leg.time_s[i] / unit_s) * unit_s;
    return WhatIsSaid(tracks);
  };
  EXPECT_THAT(said(0.01), testing::HasSubstr("the times are rounded to 0.01 s, and frames are 0.0167 s apart"));
  EXPECT_EQ(said(0.001), "") << "a 33rd of a frame";

  // Frames at 100 Hz, some of which are missing, have such times without being rounded.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks.Frames(); ++i)
    tracks.time_s[i] = 0.01 * static_cast<double>(kept += 1 + (i % 50 < 20));
  EXPECT_THAT(WhatIsSaid(tracks), testing::Not(testing::HasSubstr("rounded")));
}

// In the second and third of four equal cycles: what the ends of the recording do to the sigmas has decayed there.
TEST(LegFit, SigmasAreThoseOfTheMotionWhereverItIs) {
  constexpr std::size_t kCycle = 336;
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 4});
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 5);
  for (motion::MarkerTrack& marker : tracks.markers)
    for (std::size_t i = kCycle; i < tracks.Frames(); ++i) marker.samples[i] = marker.samples[i % kCycle];
  const gait::LegFitResult fit = gait::FitLeg(tracks, ScaledView());
  for (std::size_t i = kCycle; i < 2 * kCycle; ++i) {
    const motion::LegSample &second = fit.motion.samples[i], &third = fit.motion.samples[i + kCycle];
    EXPECT_NEAR(second.knee_sigma_deg / third.knee_sigma_deg, 1, 0.05) << i;
    EXPECT_NEAR(second.knee_deg, third.knee_deg, 0.1 * third.knee_sigma_deg) << i;
  }
}

// A thigh that swings at 1 Hz before a shank at rest: the amplitude that is left of it is the penalised spline's gain,
// 1 / (1 + (√2 − 1) (f/f_c)⁶), also where the cutoff takes the swing for noise, and the sigmas are known to hold.
TEST(LegFit, AGivenCutoffHasItsGain) {
  constexpr double kAmplitude_deg = 20, kRate_hz = 60;
  std::vector<double> time_s;
  std::vector<gait::LegPoints> points;
  for (int i = 0; i < 16 * kRate_hz; ++i) {
    time_s.push_back(i / kRate_hz);
    const double thigh_rad = RadiansFromDegrees(-50 + kAmplitude_deg * std::sin(2 * std::numbers::pi * time_s.back()));
    const Eigen::Vector2d ankle(0, 100), knee(0, 530);
    const Eigen::Vector2d hip = knee + 410 * Eigen::Vector2d(std::sin(thigh_rad), std::cos(thigh_rad));
    points.push_back({ankle, knee, hip, Eigen::Vector2d(hip + Eigen::Vector2d(20, 250))});
  }
  const motion::MarkerRecording tracks = MakeTracks(time_s, points, ScaledView(), {0.03}, 1);
  gait::LegFitOptions options;
  options.known_sigmas = true;
  options.cutoff_hz = 0.5;  // which leaves 4 % of the swing
  EXPECT_THAT(FitMessage(tracks, ScaledView(), options), testing::HasSubstr("cutoff of 0.5 Hz takes"));
  for (const double cutoff_hz : {1.2, 1.35, 1.5}) {
    options.cutoff_hz = cutoff_hz;
    const gait::LegFitResult result = gait::FitLeg(tracks, ScaledView(), options);
    EXPECT_NEAR(result.summary.cutoff_hz, cutoff_hz, 0.03 * cutoff_hz);
    double swing = 0;
    int count = 0;
    for (std::size_t i = 4 * 60; i < 12 * 60; ++i, ++count)
      swing += 2 * std::sin(2 * std::numbers::pi * time_s[i]) * result.motion.samples[i].knee_deg;
    const double gain = std::abs(swing / count) / kAmplitude_deg;
    const double found_hz = std::pow((std::numbers::sqrt2 - 1) * gain / (1 - gain), 1.0 / 6);
    EXPECT_NEAR(found_hz / cutoff_hz, 1, 0.08) << cutoff_hz;
  }
}

class LegFitErrors : public testing::Test {
 protected:
  SyntheticLeg leg_ = MakeSyntheticLeg({.repetitions = 1});
  motion::MarkerRecording tracks_ = MakeTracks(leg_.time_s, leg_.points_mm, ScaledView(), {}, 9);

  // Of the recording with this change.
  template <typename Change>
  std::string MessageAfter(const Change& change) const {
    motion::MarkerRecording changed = tracks_;
    change(changed);
    return FitMessage(changed, ScaledView());
  }
};

TEST_F(LegFitErrors, SwappedNamesAreFound) {
  using Markers = std::pair<std::size_t, std::size_t>;
  for (const auto& [a, b] : {Markers{0, 1}, Markers{1, 2}, Markers{2, 3}, Markers{1, 3}, Markers{0, 2}})
    EXPECT_THAT(MessageAfter([&](auto& tracks) { std::swap(tracks.markers[a].samples, tracks.markers[b].samples); }),
                testing::HasSubstr(a == 0 && b == 2 ? "lies below" : "names"))
        << a << b;
}

TEST_F(LegFitErrors, NameTheMarkerOrTheFrame) {
  using testing::HasSubstr;
  EXPECT_THAT(MessageAfter([](auto& tracks) { tracks.markers[1].samples[17].position.x() = std::nan(""); }),
              testing::AllOf(HasSubstr("'knee'"), HasSubstr("frame 17")));
  EXPECT_THAT(MessageAfter([](auto& tracks) { tracks.markers.erase(tracks.markers.begin() + 2); }),
              testing::AllOf(HasSubstr("no marker 'hip'"), HasSubstr("ankle, knee, waist")));
  EXPECT_THAT(MessageAfter([](auto& tracks) {
                for (std::size_t i = 5; i < tracks.Frames(); ++i) tracks.markers[0].samples[i] = {};
              }),
              HasSubstr("5 frames only"));
  EXPECT_THAT(MessageAfter([](auto& tracks) { tracks.time_s[9] = tracks.time_s[8]; }), HasSubstr("frame 9"));
}

TEST_F(LegFitErrors, AHoleOfDaysInTimeIsSaidAndBridgedByNothing) {
  const gait::LegFitResult whole = gait::FitLeg(tracks_, ScaledView());
  for (std::size_t i = 100; i < tracks_.Frames(); ++i) tracks_.time_s[i] += 1e6;
  const gait::LegFitResult parts = gait::FitLeg(tracks_, ScaledView());
  EXPECT_THAT(parts.warnings,
              testing::Contains(testing::HasSubstr("nothing is recorded for 1000000 s after frame 99")));
  for (std::size_t i = 0; i < tracks_.Frames(); ++i)
    EXPECT_NEAR(parts.motion.samples[i].knee_deg, whole.motion.samples[i].knee_deg,
                4 * parts.motion.samples[i].knee_sigma_deg);
}

// At 60 Hz minutes, microseconds and a twentieth, with which a leg is too quick.
TEST_F(LegFitErrors, TimesInAnotherUnitAreNamedNotTheMarkers) {
  const std::vector<double> seconds = tracks_.time_s;
  for (const auto& [factor, step] : {std::pair(60.0, "0.000278"), {1e6 / 60, "0.000001"}, {20.0, "0.000833"}}) {
    for (std::size_t i = 0; i < seconds.size(); ++i) tracks_.time_s[i] = seconds[i] / factor;
    EXPECT_THAT(WhatIsSaid(tracks_),
                testing::AllOf(testing::HasSubstr(fmt::format("{} s apart", step)), testing::HasSubstr("in seconds")));
  }
}

TEST_F(LegFitErrors, TooShortAndBadOptions) {
  gait::LegFitOptions options;
  options.cutoff_hz = -1;
  EXPECT_THAT(FitMessage(tracks_, ScaledView(), options), testing::HasSubstr("cutoff"));
  OptionList list;
  Describe(options, list);
  EXPECT_THROW(list.All().front().SetFromCommandLine({"kalman"}), UsageError);
  EXPECT_THAT(FitMessage({}, ScaledView()), testing::HasSubstr("too short"));
  EXPECT_THROW(gait::MakeLegView(motion::LengthUnit::kPx, {}, -1.0), Error);
  EXPECT_THROW(gait::MakeLegView(motion::LengthUnit::kPx, {}, 2.0, {{"knee", {40}}}), Error);
}

TEST(LegFit, ALegThatHardlyBendsWarnsAboutItsSide) {
  SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 1});
  for (std::size_t i = 0; i < leg.points_mm.size(); ++i) leg.points_mm[i] = leg.points_mm[leg.points_mm.size() / 2];
  const gait::LegFitResult result =
      gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 1), ScaledView());
  EXPECT_THAT(result.warnings, testing::ElementsAre(testing::HasSubstr("facing")));
  EXPECT_TRUE(result.events.empty());
}

}  // namespace
}  // namespace lake
