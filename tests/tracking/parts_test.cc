// The parts of tracking, each against what it must find: assignment, association, search, noise, sigma.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "lake/core/statistics.h"
#include "lake/tracking/assignment.h"
#include "lake/tracking/blob_search.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/noise_estimate.h"
#include "lake/tracking/sigma_calibration.h"
#include "lake/tracking/tracklet.h"
#include "tracking/marker_scene.h"

namespace lake {
namespace {

using Eigen::Vector2d;

constexpr double kForbidden = 1.0;

// Each row with a column below `forbidden`, or none at the price of `forbidden`.
double TotalCost(const Eigen::MatrixXd& cost, const std::vector<int>& columns) {
  double total = 0;
  for (std::size_t row = 0; row < columns.size(); ++row)
    total += columns[row] < 0 ? kForbidden : cost(static_cast<Eigen::Index>(row), columns[row]);
  return total;
}

double LeastCost(const Eigen::MatrixXd& cost, Eigen::Index row, unsigned taken) {
  if (row == cost.rows()) return 0;
  double least = kForbidden + LeastCost(cost, row + 1, taken);
  for (Eigen::Index column = 0; column < cost.cols(); ++column)
    if (!(taken >> column & 1) && cost(row, column) < kForbidden)
      least = std::min(least, cost(row, column) + LeastCost(cost, row + 1, taken | 1u << column));
  return least;
}

TEST(Assignment, IsTheCheapestOfAll) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> side(0, 6);
  std::uniform_real_distribution<double> level(0, 1.5);  // a third is forbidden
  for (int trial = 0; trial < 400; ++trial) {
    Eigen::MatrixXd cost(side(random), side(random));
    for (Eigen::Index i = 0; i < cost.size(); ++i) cost.data()[i] = level(random);
    const std::vector<int> columns = tracking::AssignRows(cost, kForbidden);
    ASSERT_EQ(columns.size(), static_cast<std::size_t>(cost.rows()));
    unsigned taken = 0;
    for (std::size_t row = 0; row < columns.size(); ++row) {
      if (columns[row] < 0) continue;
      ASSERT_LT(columns[row], cost.cols());
      ASSERT_FALSE(taken >> columns[row] & 1) << "a column twice";
      taken |= 1u << columns[row];
      ASSERT_LT(cost(static_cast<Eigen::Index>(row), columns[row]), kForbidden);
    }
    ASSERT_NEAR(TotalCost(cost, columns), LeastCost(cost, 0, 0), 1e-12) << cost;
  }
}

// Sees points at given places, all of the same look, in any order.
class PointDetector : public tracking::MarkerDetector {
 public:
  PointDetector(std::function<std::vector<Vector2d>(std::int64_t)> places, unsigned seed)
      : places_(std::move(places)), random_(seed) {}

  std::vector<tracking::MarkerDetection> Detect(const video::VideoFrame& frame,
                                                std::span<const tracking::MarkerPrediction>, tracking::Look) override {
    std::vector<tracking::MarkerDetection> detections;
    for (const Vector2d& place : places_(frame.index)) {
      tracking::MarkerDetection detection;
      detection.position = place + Vector2d{noise_(random_), noise_(random_)};
      detection.sigma_px = 0.05;
      detection.appearance = tracking::DiscBlob(detection.position, 4);
      detection.appearance.amplitude = 150;
      detections.push_back(detection);
    }
    std::shuffle(detections.begin(), detections.end(), random_);
    return detections;
  }

 private:
  std::function<std::vector<Vector2d>(std::int64_t)> places_;
  std::mt19937 random_;
  std::normal_distribution<double> noise_{0, 0.05};
};

std::vector<tracking::Tracklet> Follow(tracking::MarkerDetector& detector, int frames, double rate_hz = 60) {
  tracking::TrackletBuilder builder(detector, {});
  for (int i = 0; i < frames; ++i) {
    video::VideoFrame frame;
    frame.index = i, frame.time_s = i / rate_hz;
    builder.Add(frame);
  }
  return builder.Finish();
}

TEST(TrackletBuilder, CrossingMarkersKeepTheirIdentity) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    // They pass each other at 1 px, moving 5 px a frame to the sides.
    const auto a = [&](double t) { return Vector2d(100 + 2.5 * t, 200); };
    const auto b = [&](double t) { return Vector2d(352 - 2.5 * t + 0.1 * seed, 201); };
    PointDetector detector(
        [&](std::int64_t f) {
          return std::vector{a(static_cast<double>(f)), b(static_cast<double>(f))};
        },
        seed);
    const std::vector<tracking::Tracklet> tracklets = Follow(detector, 100);
    ASSERT_EQ(tracklets.size(), 2u) << "seed " << seed;
    for (const tracking::Tracklet& tracklet : tracklets) {
      ASSERT_EQ(tracklet.samples.size(), 100u);
      const bool is_a = tracklet.samples.front().position.x() < 200;
      for (const tracking::TrackletSample& sample : tracklet.samples) {
        const auto f = static_cast<double>(sample.frame);
        ASSERT_LE((sample.position - (is_a ? a(f) : b(f))).norm(), 0.5) << "seed " << seed << " frame " << f;
      }
    }
  }
}

// Turned about at almost 1 g, at the very time of a frame: the places before and after are the same, yet nothing rests.
TEST(TrackletBuilder, QuickTurnsAreFollowed) {
  PointDetector detector(
      [](std::int64_t f) { return std::vector{Vector2d(200 + 41 * std::cos(M_PI / 9 * static_cast<double>(f)), 50)}; },
      1);
  const std::vector<tracking::Tracklet> tracklets = Follow(detector, 90, 30);
  ASSERT_EQ(tracklets.size(), 1u);
  EXPECT_EQ(tracklets[0].samples.size(), 90u);
}

TEST(TrackletBuilder, ShortGapsAreBridgedAndLongOnesEndATracklet) {
  const auto path = [](std::int64_t f) { return Vector2d(100 + 1.5 * static_cast<double>(f), 50); };
  const auto seen_but = [&](std::int64_t first, std::int64_t last) {
    return [=](std::int64_t f) { return f >= first && f <= last ? std::vector<Vector2d>{} : std::vector{path(f)}; };
  };
  PointDetector short_gap(seen_but(40, 43), 1), long_gap(seen_but(40, 69), 1);
  const std::vector<tracking::Tracklet> bridged = Follow(short_gap, 100), ended = Follow(long_gap, 100);
  ASSERT_EQ(bridged.size(), 1u);
  EXPECT_EQ(bridged[0].samples.size(), 96u);
  EXPECT_EQ(bridged[0].SampleIn(41), nullptr);
  ASSERT_NE(bridged[0].SampleIn(44), nullptr);
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].LastFrame(), 39);
  EXPECT_EQ(ended[1].FirstFrame(), 70);
}

TEST(BlobSearch, FindsDiscsOfAllSizesAndNothingElse) {
  const cv::Size size(320, 240);
  const SceneNoise noise;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> fraction(-0.5, 0.5);
  for (const double radius : {2.0, 3.0, 4.5, 6.0, 9.0, 13.0, 20.0, 30.0}) {
    SceneMarker marker;
    marker.center = Vector2d(170, 120) + Vector2d{fraction(random), fraction(random)};
    marker.radius_px = radius;
    const cv::Mat grey = AddNoise(DrawMarkers(size, {marker}, 0.7, 40), noise, random);
    const auto found = tracking::FindBlobs(grey, {{0, 0}, size}, {});
    ASSERT_EQ(found.size(), 1u) << "radius " << radius;
    EXPECT_LE((found[0].position - marker.center).norm(), std::max(1.5, 0.5 * radius)) << "radius " << radius;
    EXPECT_LE(std::abs(std::log(found[0].radius_px / radius)), std::log(1.6))
        << "radius " << radius << ": " << found[0].radius_px;
  }
}

// What the function gives of the distance from a line through the picture's middle at this angle.
template <typename Level>
cv::Mat AcrossALine(double angle_deg, Level level) {
  cv::Mat picture(240, 320, CV_64F);
  const double a = angle_deg * CV_PI / 180;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<double>(y, x) = level((x - 160) * std::sin(a) - (y - 120) * std::cos(a));
  return picture;
}

std::size_t BlobsIn(const cv::Mat& levels, std::mt19937& random) {
  return tracking::FindBlobs(AddNoise(levels, SceneNoise{}, random), {{0, 0}, levels.size()}, {}).size();
}

constexpr double kAngles[] = {0, 20, 45, 77, 90};  // deg

TEST(BlobSearch, EdgesAndFlatPicturesHoldNoBlob) {
  std::mt19937 random(18);
  for (const double angle_deg : kAngles)
    EXPECT_EQ(BlobsIn(AcrossALine(angle_deg, [](double u) { return 40 + 75 * (1 + std::erf(u)); }), random), 0u)
        << angle_deg;
  EXPECT_EQ(BlobsIn(cv::Mat(240, 320, CV_64F, cv::Scalar(90)), random), 0u);
}

// The search may propose a piece of a line; the fit must not take it for a marker. Two frames, as the first only
// teaches the noise.
TEST(ReflectiveDetector, LinesAreNoMarkers) {
  std::mt19937 random(20);
  for (const double width_px : {1.0, 3.0, 6.0})
    for (const double angle_deg : kAngles) {
      const cv::Mat line =
          AcrossALine(angle_deg, [&](double u) { return 40 + 150 * std::exp(-0.5 * u * u / (width_px * width_px)); });
      const auto detector = tracking::MakeReflectiveDetector(tracking::Polarity::kBright, {});
      for (int i = 0; i < 2; ++i) {
        video::VideoFrame frame;
        frame.luma = AddNoise(line, SceneNoise{}, random);
        EXPECT_THAT(detector->Detect(frame, {}, tracking::Look::kEverywhere), testing::IsEmpty())
            << width_px << " px, " << angle_deg << " deg";
      }
    }
}

TEST(BlobSearch, StaysInItsRegion) {
  std::mt19937 random(19);
  SceneMarker inside, outside;
  inside.center = {220, 130}, outside.center = {60, 60};
  const cv::Mat grey = AddNoise(DrawMarkers({320, 240}, {inside, outside}, 0.7, 40), SceneNoise{}, random);
  const auto found = tracking::FindBlobs(grey, {160, 80, 140, 120}, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LE((found[0].position - inside.center).norm(), 2);
}

TEST(NoiseEstimator, RecoversReadNoiseAndGain) {
  for (const auto& [read_sd, gain] : {std::pair(1.5, 0.02), std::pair(1.0, 0.0), std::pair(2.5, 0.05)}) {
    std::mt19937 random(23);
    // A ramp through all levels, and something that moves over it.
    cv::Mat ramp(180, 320, CV_64F);
    for (int y = 0; y < ramp.rows; ++y)
      for (int x = 0; x < ramp.cols; ++x) ramp.at<double>(y, x) = 15 + 215.0 * x / ramp.cols;
    tracking::NoiseEstimator estimator;
    for (int i = 0; i < 12; ++i) {
      cv::Mat picture = ramp.clone();
      picture(cv::Rect(10 * i, 40, 20, 20)) = 230;
      estimator.Add(AddNoise(picture, {read_sd, gain}, random));
    }
    const tracking::NoiseModel model = estimator.Estimate();
    // Rounding to whole levels adds 1/12. 70000 differences fix the line's variance to about 1 %; bins of 16 levels and
    // what moves cost some more.
    for (const double level : {20.0, 120.0, 220.0}) {
      const double truth = read_sd * read_sd + gain * level + 1.0 / 12;
      EXPECT_NEAR(model.Variance(level), truth, 0.08 * truth)
          << "read sd " << read_sd << ", gain " << gain << ", level " << level;
    }
    EXPECT_NEAR(model.gain, gain, 0.005);
  }
}

TEST(NoiseEstimator, KnowsWhereTheVideoSaturates) {
  std::mt19937 random(24);
  cv::Mat picture(120, 160, CV_64F, cv::Scalar(60));
  picture(cv::Rect(40, 40, 30, 30)) = 400;
  cv::Mat clipped = AddNoise(picture, SceneNoise{}, random);
  tracking::NoiseEstimator full, studio, dark;
  full.Add(clipped);
  EXPECT_EQ(full.SaturationLevel(), 255);
  studio.Add(cv::min(clipped, 235));
  EXPECT_EQ(studio.SaturationLevel(), 235);
  dark.Add(AddNoise(cv::Mat(120, 160, CV_64F, cv::Scalar(60)), SceneNoise{}, random));
  EXPECT_EQ(dark.SaturationLevel(), 255);
}

// Four markers on slow curves at more than half a pixel a frame, with white noise of this deviation and fits that state
// `sigma`.
motion::MarkerRecording Curves(double noise_px, double sigma_px, unsigned seed, double jitter = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> early_late(-jitter, jitter);
  std::normal_distribution<double> noise(0, noise_px);
  motion::MarkerRecording recording;
  recording.markers.resize(4);
  for (int f = 0; f < 400; ++f) {
    const double t = (f + early_late(random)) / 60;
    recording.frame.push_back(f), recording.time_s.push_back(t);
    for (std::size_t m = 0; m < 4; ++m) {
      const double a = 0.9 * t + static_cast<double>(m);
      const Vector2d place = Vector2d(500, 400) + 120 * Vector2d(std::cos(a), std::sin(a));
      recording.markers[m].samples.push_back(
          {place + Vector2d{noise(random), noise(random)}, sigma_px, motion::SampleStatus::kDetected});
    }
  }
  return recording;
}

video::VideoInfo CodedBy(const std::string& codec, bool frame_by_frame = false) {
  video::VideoInfo video;
  video.codec = codec, video.coded_frame_by_frame = frame_by_frame;
  return video;
}

const video::VideoInfo kH264 = CodedBy("h264");

video::VideoInfo Lossless() {
  video::VideoInfo video = CodedBy("ffv1", true);
  video.is_lossless = true;
  return video;
}

double ExtraScatterPx(const tracking::SigmaCalibration& found) {
  return std::sqrt(found.scatter_px * found.scatter_px - found.fit_px * found.fit_px);
}

// 1200 distances fix their deviation to 2 %. Of noise as large as the fits say, none besides is the likeliest.
TEST(SigmaCalibration, AddsNothingToWhiteNoise) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    motion::MarkerRecording recording = Curves(0.03, 0.03, seed);
    const tracking::SigmaCalibration calibration = tracking::CalibrateSigmas(kH264, recording);
    EXPECT_NEAR(calibration.fit_px, 0.03, 1e-12);
    EXPECT_NEAR(calibration.scatter_px, 0.03, 0.04 * 0.03);
    EXPECT_LE(recording.markers[0].samples[100].sigma, 1.04 * 0.03);
  }
}

// 1200 distances of neighbours, of which two share a marker, fix it to 3 % (1 SD).
TEST(SigmaCalibration, FindsAKnownExtraScatter) {
  for (const double extra_px : {0.02, 0.05}) {
    std::vector<double> found;
    for (unsigned seed = 0; seed < 16; ++seed) {
      motion::MarkerRecording recording = Curves(std::hypot(0.02, extra_px), 0.02, seed);
      recording.markers[1].samples[50] = {};
      const tracking::SigmaCalibration calibration = tracking::CalibrateSigmas(kH264, recording);
      found.push_back(calibration.scatter_px / std::hypot(0.02, extra_px));
      EXPECT_NEAR(found.back(), 1, 0.12) << seed;
      EXPECT_NEAR(recording.markers[2].samples[7].sigma, std::hypot(0.02, calibration.compression_px), 1e-12);
      EXPECT_FALSE(recording.markers[1].samples[50].IsKnown());
      EXPECT_EQ(recording.markers[1].samples[50].sigma, 0);
    }
    EXPECT_NEAR(Mean(found), 1, 0.02);
  }
}

// As where a converter shows every picture twice, and the repeats are left out.
TEST(SigmaCalibration, FindsItWhereEverySecondFrameIsLeftOut) {
  std::vector<double> found;
  for (unsigned seed = 0; seed < 16; ++seed) {
    motion::MarkerRecording recording = Curves(std::hypot(0.02, 0.05), 0.02, seed);
    for (motion::MarkerTrack& marker : recording.markers)
      for (std::size_t i = 1; i < marker.samples.size(); i += 2) marker.samples[i] = {};
    found.push_back(ExtraScatterPx(tracking::CalibrateSigmas(kH264, recording)) / 0.05);
    EXPECT_NEAR(found.back(), 1, 0.2) << seed;
  }
  EXPECT_NEAR(Mean(found), 1, 0.03);
}

// A walking leg at 25 frames/s: its path is so quick that it hides its errors, its segments do not.
TEST(SigmaCalibration, FindsItOfWhoWalksAtFewFrames) {
  std::vector<double> found;
  for (unsigned seed = 0; seed < 16; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, std::hypot(0.02, 0.05));
    motion::MarkerRecording recording;
    recording.markers.resize(4);
    for (int f = 0; f < 150; ++f) {
      const double t = f / 25.0, turn = 2 * std::numbers::pi * t;
      const double thigh = 0.4 * std::sin(turn), shank = thigh - 0.3 * (1 - std::cos(turn)) - 0.25 * std::sin(2 * turn);
      Vector2d place(1500 - 500 * t + 5 * std::sin(2 * turn), 300 + 8 * std::cos(2 * turn));  // the hip
      std::array<Vector2d, 4> places = {place, place, place, place + Vector2d(6, -60)};
      places[1] += 180 * Vector2d(-std::sin(thigh), std::cos(thigh));
      places[0] = places[1] + 180 * Vector2d(-std::sin(shank), std::cos(shank));
      recording.frame.push_back(f), recording.time_s.push_back(t);
      for (std::size_t m = 0; m < 4; ++m)
        recording.markers[m].samples.push_back(
            {places[m] + Vector2d{noise(random), noise(random)}, 0.02, motion::SampleStatus::kDetected});
    }
    found.push_back(ExtraScatterPx(tracking::CalibrateSigmas(kH264, recording)) / 0.05);
    EXPECT_NEAR(found.back(), 1, 0.4) << seed;
  }
  EXPECT_NEAR(Mean(found), 1, 0.05);
}

// So strong is compression only where its errors last for some frames, which scatter does not show.
TEST(SigmaCalibration, StrongCompressionIsMoreThanItsScatter) {
  motion::MarkerRecording recording = Curves(0.1, 0.025, 4);
  video::VideoInfo video = kH264;
  video.bits_per_pixel = 0.001;  // as at crf 40
  const tracking::SigmaCalibration calibration = tracking::CalibrateSigmas(video, recording);
  EXPECT_NEAR(calibration.scatter_px, 0.1, 0.004);
  EXPECT_GE(calibration.compression_px, 0.12);
  EXPECT_LE(calibration.compression_px, 0.15);
}

// Real markers jitter on the skin. Fits as good as these tell that it is not compression.
TEST(SigmaCalibration, JitterOfThePersonIsNoCompression) {
  motion::MarkerRecording recording = Curves(0.15, 0.005, 8);
  // On rendered recordings the error was 3.2 to 6.0 times the fits' sigma.
  EXPECT_LE(tracking::CalibrateSigmas(kH264, recording).compression_px, 6 * 0.005 + 1e-9);
  for (const motion::MarkerTrack& marker : recording.markers)
    for (const motion::MarkerSample& sample : marker.samples)
      ASSERT_LE(sample.sigma, std::hypot(6.0, 1.0) * 0.005 + 1e-9);
}

// Four markers of a leg that go along a curve, rest for a second and go on, seen with errors of this deviation, of
// which each frame keeps a share, as long as they move; at rest the last error stays. `jitter_px` is the person's.
struct GoingAndResting {
  motion::MarkerRecording recording;
  std::vector<std::vector<Vector2d>> truth;  // by marker
};

GoingAndResting GoAndRest(double error_px, double kept, double sigma_px, double jitter_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  GoingAndResting made;
  const char* names[] = {"ankle", "knee", "hip", "waist"};
  for (std::size_t m = 0; m < 4; ++m) {
    motion::MarkerTrack& marker = made.recording.markers.emplace_back();
    marker.name = names[m];
    made.truth.emplace_back();
    const auto noise = [&] { return Vector2d(normal(random), normal(random)); };
    Vector2d error = error_px * noise();
    for (int f = 0; f < 600; ++f) {
      const double phase = f / 60.0, rest = std::floor(phase / 2), within = phase - 2 * rest;  // goes for 1 s of 2
      const double s = std::min(within, 1.0), a = rest + s * s * s * (10 - 15 * s + 6 * s * s);
      const bool moves = within > 0.15 && within < 0.85;
      if (moves) error = kept * error + std::sqrt(1 - kept * kept) * error_px * noise();
      made.truth[m].push_back(Vector2d(400, 200.0 * static_cast<double>(m)) + 120 * Vector2d(std::cos(a), std::sin(a)) +
                              jitter_px * noise());
      marker.samples.push_back({made.truth[m].back() + error, sigma_px, motion::SampleStatus::kDetected});
      if (m == 0) made.recording.frame.push_back(f), made.recording.time_s.push_back(phase);
    }
  }
  return made;
}

double ErrorOverSigma(const GoingAndResting& made) {
  double sum = 0;
  int count = 0;
  for (std::size_t m = 0; m < 4; ++m)
    for (std::size_t i = 0; i < made.truth[m].size(); ++i, ++count) {
      const motion::MarkerSample& sample = made.recording.markers[m].samples[i];
      sum += (sample.position - made.truth[m][i]).squaredNorm() / 2 / (sample.sigma * sample.sigma);
    }
  return std::sqrt(sum / count);
}

// A smooth path goes along with errors that last; its scatter is 0.65 of an error of which each frame keeps half. And
// an encoder that smooths the picture makes the fits' sigmas small, not its errors (x265): of rendered recordings the
// error was 2 to 6.5 times that sigma in H.264, 3.5 to 10 times in H.265 (5 to 95 %). What stays at rest is one draw
// for each marker and rest, 20 in all: it varies by a sixth.
TEST(SigmaCalibration, ErrorsMayLastAndBeManyTimesTheFitsSigma) {
  struct Case {
    video::VideoInfo video;
    double sigma_px, kept;
  };
  const video::VideoInfo h265 = CodedBy("hevc");
  for (const auto& [video, sigma_px, kept] : {Case{kH264, 0.03, 0}, Case{kH264, 0.03, 0.25}, Case{kH264, 0.03, 0.5},
                                              Case{h265, 0.019, 0}, Case{h265, 0.019, 0.25}})
    for (unsigned seed = 31; seed < 34; ++seed) {
      GoingAndResting made = GoAndRest(0.12, kept, sigma_px, 0, seed);
      tracking::CalibrateSigmas(video, made.recording);
      EXPECT_NEAR(ErrorOverSigma(made), 1, 0.25) << video.codec << ", " << kept << " kept, seed " << seed;
    }
}

TEST(SigmaCalibration, JitterThatIsThereAtRestTooIsNoCompression) {
  GoingAndResting made = GoAndRest(0, 0, 0.005, 0.08, 35);
  EXPECT_LE(tracking::CalibrateSigmas(kH264, made.recording).compression_px, 6 * 0.005 + 1e-9);
}

// A person's path hides what coding adds, so what is usual counts: of the codec, and of how few bits a pixel has.
TEST(SigmaCalibration, KnowsWhatCodingUsuallyAdds) {
  const auto added_px = [](video::VideoInfo video, double bits_per_pixel) {
    video.bits_per_pixel = bits_per_pixel;
    GoingAndResting made = GoAndRest(0, 0, 0.01, 0.05, 36);
    const double added = tracking::CalibrateSigmas(video, made.recording).compression_px;
    // Slow markers as moving ones (GoAndRest: slow at 3.5 s, moving at 2.5 s).
    const std::vector<motion::MarkerSample>& knee = made.recording.markers[1].samples;
    EXPECT_DOUBLE_EQ(knee[210].sigma, knee[150].sigma);
    return added;
  };
  const video::VideoInfo motion_jpeg = CodedBy("mjpeg", true);
  EXPECT_NEAR(added_px(motion_jpeg, 0.2), 1.05 * 0.01, 1e-6);
  EXPECT_NEAR(added_px(motion_jpeg, 0.9) / added_px(motion_jpeg, 0.2), std::pow(0.9 / 0.2, -0.37), 1e-6);
  EXPECT_EQ(added_px(Lossless(), 0.2), 0);
  const double h264 = added_px(kH264, 0.01), many_bits = added_px(kH264, 0.1), h265 = added_px(CodedBy("hevc"), 0.01);
  EXPECT_GT(h264, 3 * 0.01);
  EXPECT_NEAR(h264 / many_bits, std::pow(10, 0.11), 1e-6);
  EXPECT_GT(h265, h264);
  EXPECT_LT(h265, 1.2 * 0.05);
  const video::VideoInfo mpeg4 = CodedBy("mpeg4");
  EXPECT_NEAR(added_px(mpeg4, 0.04), 2.86 * 0.01, 1e-6);
  EXPECT_NEAR(added_px(mpeg4, 0.04) / added_px(mpeg4, 0.4), std::pow(10, 0.22), 1e-6);
  EXPECT_LT(added_px(mpeg4, 0.01), h264);
}

// Four markers of a person at 25 Hz, of which one is moved by far more jerk, each measured with an error of 0.05 px.
motion::MarkerRecording OneIsJerked(unsigned seed) {
  constexpr double kFrame_s = 0.04, kError_px = 0.05, kSmooth = 1e5, kJerked = 1e9;  // px²/s⁵
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const auto noise = [&] { return Vector2d(normal(random), normal(random)); };
  motion::MarkerRecording recording;
  const char* names[] = {"ankle", "knee", "hip", "waist"};
  for (std::size_t m = 0; m < 4; ++m) {
    recording.markers.push_back({names[m], {}});
    Vector2d position(400, 200.0 * static_cast<double>(m)), velocity(50, 0), acceleration(0, 0);
    for (int f = 0; f < 300; ++f) {
      position += kFrame_s * velocity + 0.5 * kFrame_s * kFrame_s * acceleration;
      velocity = 0.98 * velocity + kFrame_s * acceleration;
      acceleration = 0.9 * acceleration + std::sqrt((m == 2 ? kJerked : kSmooth) * kFrame_s) * noise();
      recording.markers[m].samples.push_back({position + kError_px * noise(), 0.01, motion::SampleStatus::kDetected});
      if (m > 0) continue;
      recording.frame.push_back(f);
      recording.time_s.push_back(f * kFrame_s);
    }
  }
  return recording;
}

// Its movement hides its errors: they are taken to be as large as the others'.
TEST(SigmaCalibration, IsThatOfTheOthersWhereAPathTellsNothing) {
  for (unsigned seed = 38; seed < 43; ++seed) {
    motion::MarkerRecording recording = OneIsJerked(seed);
    tracking::CalibrateSigmas(kH264, recording);
    EXPECT_NEAR(recording.markers[2].samples[150].sigma / recording.markers[1].samples[150].sigma, 1, 0.2) << seed;
  }
}

// Smoothing takes the fits' own errors away, and 0.3 of what coding adds; of what holds still at rest all that changes.
TEST(SigmaCalibration, SaysWhatOfAPersonsErrorsLasts) {
  const auto calibrated = [](const video::VideoInfo& video, double jitter_px, double error_px = 0.12) {
    GoingAndResting made = GoAndRest(error_px, 0.5, 0.01, jitter_px, 37);
    return tracking::CalibrateSigmas(video, made.recording);
  };
  constexpr double kJitter_px = 0.1;
  EXPECT_EQ(calibrated(kH264, 0).lasting_share, 0);
  const tracking::SigmaCalibration person = calibrated(kH264, kJitter_px);
  const double added_share = std::pow(person.compression_px / std::hypot(person.compression_px, 0.01), 2);
  EXPECT_GT(added_share, 0.9);
  EXPECT_NEAR(person.lasting_share, 0.7 * added_share, 1e-6);
  EXPECT_EQ(calibrated(Lossless(), kJitter_px).lasting_share, 0);
  // Coarse coding holds a person still, too.
  EXPECT_GT(calibrated(kH264, 0, 0.6).lasting_share, 0.5);
}

// One of little contrast has larger fits' sigmas, and is displaced farther than the others.
TEST(SigmaCalibration, IsOfEachMarker) {
  motion::MarkerRecording recording = Curves(0.04, 0.02, 6);
  const motion::MarkerRecording scattered = Curves(0.08, 0.04, 6);
  recording.markers[1] = scattered.markers[1];
  tracking::CalibrateSigmas(kH264, recording);
  const auto added_px = [&](std::size_t marker, double fit_px) {
    return std::sqrt(std::pow(recording.markers[marker].samples[100].sigma, 2) - fit_px * fit_px);
  };
  // All have one scatter, so twice the sigma is half of it in sigmas.
  EXPECT_NEAR(added_px(1, 0.04) / added_px(2, 0.02), 2 * std::pow(0.5, 0.45), 1e-6);
  EXPECT_EQ(added_px(0, 0.02), added_px(2, 0.02));
}

// Times that scatter by 0.3 frames are no noise of the positions, nor is a frame in four that is not there.
TEST(SigmaCalibration, GoesByTime) {
  motion::MarkerRecording recording = Curves(std::hypot(0.02, 0.05), 0.02, 12, 0.3);
  for (motion::MarkerTrack& marker : recording.markers)
    for (std::size_t i = 0; i < marker.samples.size(); i += 4) marker.samples[i] = {};
  const tracking::SigmaCalibration calibration = tracking::CalibrateSigmas(kH264, recording);
  EXPECT_NEAR(ExtraScatterPx(calibration), 0.05, 0.08 * 0.05);
}

}  // namespace
}  // namespace lake
