#include "lake/tracking/sigma_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "lake/core/statistics.h"

namespace lake {
namespace {

using Eigen::Vector2d;

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

constexpr double kFit_px = 0.02, kExtra_px = 0.05;

// What is found of kExtra_px, as a share of it, in each of 16 recordings and on average.
template <typename Make>
void ExpectExtraFound(const Make& recording_of, double each, double mean) {
  std::vector<double> found;
  for (unsigned seed = 0; seed < 16; ++seed) {
    motion::MarkerRecording recording = recording_of(seed);
    found.push_back(ExtraScatterPx(tracking::CalibrateSigmas(kH264, recording)) / kExtra_px);
    EXPECT_NEAR(found.back(), 1, each) << seed;
  }
  EXPECT_NEAR(Mean(found), 1, mean);
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
  const auto halved = [](unsigned seed) {
    motion::MarkerRecording recording = Curves(std::hypot(kFit_px, kExtra_px), kFit_px, seed);
    for (motion::MarkerTrack& marker : recording.markers)
      for (std::size_t i = 1; i < marker.samples.size(); i += 2) marker.samples[i] = {};
    return recording;
  };
  ExpectExtraFound(halved, 0.2, 0.03);
}

// A walking leg at 25 frames/s: its path is so quick that it hides its errors, its segments do not.
TEST(SigmaCalibration, FindsItOfWhoWalksAtFewFrames) {
  const auto walk = [](unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, std::hypot(kFit_px, kExtra_px));
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
            {places[m] + Vector2d{noise(random), noise(random)}, kFit_px, motion::SampleStatus::kDetected});
    }
    return recording;
  };
  ExpectExtraFound(walk, 0.4, 0.05);
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
