// Frame times from a subject's true paths, shown as editors show them; no pictures.
#include "lake/tracking/frame_times.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "lake/core/error.h"
#include "lake/synth/scene.h"

namespace lake::tracking {
namespace {

constexpr double kRateHz = 60, kNoisePx = 0.03;

struct ShownFrames {
  motion::MarkerRecording recording;
  std::vector<int> source;  // frame of the scene that each frame shows
};

// The scene's frames in this order at this rate. What is shown again is measured at the same place.
ShownFrames Show(const synth::Scene& scene, std::uint64_t seed, std::vector<int> source, double rate_hz = kRateHz,
                 double noise_px = kNoisePx) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, noise_px);
  ShownFrames shown{{}, std::move(source)};
  for (const std::string& name : scene.Motion().Names()) shown.recording.markers.push_back({name, {}});
  for (std::size_t i = 0; i < shown.source.size(); ++i) {
    shown.recording.frame.push_back(static_cast<std::int64_t>(i));
    shown.recording.time_s.push_back(static_cast<double>(i) / rate_hz);
    const synth::FrameTruth truth = scene.Truth(shown.source[i]);
    for (std::size_t m = 0; m < truth.markers.size(); ++m) {
      auto& samples = shown.recording.markers[m].samples;
      const Eigen::Vector2d off(noise(random), noise(random));
      if (i > 0 && shown.source[i] == shown.source[i - 1])
        samples.push_back(samples.back());
      else
        samples.push_back({truth.markers[m].px + off, noise_px, motion::SampleStatus::kDetected});
    }
  }
  return shown;
}

synth::Scene OneRise(std::uint64_t seed, double rate_hz = kRateHz) {
  synth::SceneOptions options = synth::CleanScene(seed);
  options.motion.repetitions = 1;
  options.frame_rate_hz = rate_hz;
  return synth::Scene(options);
}

// How far the markers go from a frame to the next, root mean square, px.
double StepPx(const synth::Scene& scene, int frame) {
  const synth::FrameTruth from = scene.Truth(frame), to = scene.Truth(frame + 1);
  double squares = 0;
  for (std::size_t m = 0; m < from.markers.size(); ++m)
    squares += (to.markers[m].px - from.markers[m].px).squaredNorm();
  return std::sqrt(squares / static_cast<double>(from.markers.size()));
}

// Where the trunk alone begins to move, all markers together hardly do; a picture that is shown again there is no time
// that is missing behind it.
TEST(FrameTimes, OfFramesDroppedUnevenlyAreTheirStamps) {
  double worst_s = 0;
  int jumps = 0, repeated = 0, wrong = 0;
  for (std::uint64_t seed = 701; seed < 713; ++seed) {
    const synth::Scene scene = OneRise(seed);
    const int first = 2 + static_cast<int>(seed % 3), second = 3 + static_cast<int>(seed % 5);
    // As ffmpeg's select='not(…)',fps=60 makes it: dropped, and the one before it shown once more.
    std::vector<int> source = {0};
    for (int i = 1; i < scene.Frames(); ++i) source.push_back(i % 7 == first || i % 11 == second ? source.back() : i);
    ShownFrames shown = Show(scene, seed, source);
    const FrameTimes times = CorrectFrameTimes({}, shown.recording);
    jumps += static_cast<int>(std::ranges::count_if(times.jumps, &TimeJump::is_applied));
    repeated += static_cast<int>(times.repeated.size());
    for (const std::int64_t frame : times.repeated)
      wrong += shown.source[static_cast<std::size_t>(frame)] == static_cast<int>(frame);
    for (std::size_t i = 0; i < shown.source.size(); ++i)
      if (shown.source[i] == static_cast<int>(i))
        worst_s = std::max(worst_s, std::abs(shown.recording.time_s[i] - static_cast<double>(i) / kRateHz));
  }
  std::printf("dropped unevenly: %d jumps, worst time %.4f s, %d repeated, %d of them new\n", jumps, worst_s, repeated,
              wrong);
  EXPECT_EQ(jumps, 0);
  EXPECT_LE(worst_s, 1e-9);
  EXPECT_GE(repeated, 12 * 20);  // 22 % of some 250 frames in which something moves
  EXPECT_LE(wrong, repeated / 50);
}

// A recording made 24 Hz from 60 Hz, then 30 Hz from that: no frame's stamp is true within 8 ms, which is two degrees
// of knee angle. That is said, with its size; the times stand. Recordings that were taken at 24 Hz get their times
// back.
TEST(FrameTimes, OfAConvertedRateAreSaidToBeUneven) {
  for (const std::uint64_t seed : {741u, 742u, 743u}) {
    const synth::Scene scene = OneRise(seed), slow = OneRise(seed, 24);
    std::vector<int> converted, taken;
    for (int i = 0; i * 2 + 3 < scene.Frames(); ++i) {
      const int at_24_hz = i * 4 / 5;
      converted.push_back(static_cast<int>(std::lround(2.5 * at_24_hz)));
      taken.push_back(at_24_hz);
    }
    taken.erase(std::find_if(taken.begin(), taken.end(), [&](int i) { return i >= slow.Frames(); }), taken.end());
    ShownFrames wrong = Show(scene, seed, converted, 30), right = Show(slow, seed, taken, 30);
    const std::vector<double> stamps_s = wrong.recording.time_s;
    const FrameTimes times = CorrectFrameTimes({}, wrong.recording);
    // The stamps are 0 or 1/60 s late: 8.3 ms root mean square about their mean.
    EXPECT_NEAR(times.uneven_s, 0.0083, 0.25 * 0.0083) << seed;
    double worst_s = 0;
    for (std::size_t i = 1; i < stamps_s.size(); ++i)
      if (wrong.source[i] != wrong.source[i - 1])
        worst_s = std::max(worst_s, std::abs(wrong.recording.time_s[i] - stamps_s[i]));
    EXPECT_LE(worst_s, 1e-9) << seed;
    const FrameTimes of_right = CorrectFrameTimes({}, right.recording);
    EXPECT_EQ(of_right.uneven_s, 0) << seed;
    EXPECT_NEAR(of_right.captured_hz, 24, 0.01) << seed;
  }
}

// At rest the noise moves the markers like a slow movement, and a repetition cannot be told from a person who rests: of
// the repetitions fewer are found than of the new frames. They were taken for those of a higher rate.
TEST(FrameTimes, OfALowerRateAreFoundByItsPatternAlone) {
  constexpr double kNoisy_px = 0.25;
  for (const std::uint64_t seed : {745u, 746u})
    for (const double shown_hz : {50.0, 30.0}) {
      const synth::Scene scene = OneRise(seed, 25);
      std::vector<int> source;
      int repeated = 0;
      for (int i = 0; i * 25 / shown_hz < scene.Frames(); ++i) {
        source.push_back(static_cast<int>(i * 25 / shown_hz));
        repeated += i > 0 && source.back() == source[source.size() - 2];
      }
      ShownFrames shown = Show(scene, seed, source, shown_hz, kNoisy_px);
      EXPECT_EQ(CorrectFrameTimes({}, shown.recording).repeated.size(), repeated) << seed << ", " << shown_hz;
    }
}

// A film of 25 frames per second that ffmpeg's fps filter shows at 29.97, from a camera on a tripod: pictures that are
// shown again are measured at nearly the same place. Some were taken for frames chosen from a film of 100 frames per
// second, and later ones set back by 60 to 180 ms. Right are the times of the film's own frames.
TEST(FrameTimes, OfAFilmShownAt2997AreThoseOfItsFrames) {
  constexpr double kShownHz = 30000 / 1001.0;
  for (std::uint64_t seed = 801; seed < 809; ++seed)
    for (const double coding_px : {0.0, 0.02}) {
      const synth::Scene scene = OneRise(seed, 25);
      std::vector<int> source;
      for (int frame = 0; frame < scene.Frames(); ++frame)  // from output frame floor(j R / r + 1/2) on
        while (static_cast<double>(source.size()) < std::floor((frame + 1) * kShownHz / 25 + 0.5))
          source.push_back(frame);
      ShownFrames shown = Show(scene, seed, source, kShownHz, 0.1);
      std::mt19937_64 random(seed);
      std::normal_distribution<double> coding(0, 1);
      for (motion::MarkerTrack& marker : shown.recording.markers)
        for (motion::MarkerSample& sample : marker.samples) {
          const double x = coding(random), y = coding(random);
          sample.position += coding_px * Eigen::Vector2d(x, y);
        }
      const FrameTimes times = CorrectFrameTimes({}, shown.recording);
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", coding " << coding_px);
      EXPECT_EQ(times.chosen_from_hz, 0);
      EXPECT_TRUE(times.jumps.empty());
      double worst_s = 0;
      for (std::size_t i = 1; i < source.size(); ++i)
        if (source[i] != source[i - 1])
          worst_s =
              std::max(worst_s, std::abs(shown.recording.time_s[i] - shown.recording.time_s[0] - source[i] / 25.0));
      EXPECT_LE(worst_s, 1e-3);
    }
}

// Films as ffmpeg's fps filter shows them at another rate, each frame the nearest one: while the markers move, the
// times are those of the film, up to one that all have in common.
TEST(FrameTimes, OfConvertedFilmsAreThoseOfTheFilm) {
  constexpr double kNtscHz = 30000 / 1001.0, kLeastStepPx = 1;
  for (const auto& [film_hz, shown_hz] : {std::pair(25.0, kNtscHz),
                                          {25.0, 30.0},
                                          {15.0, 25.0},
                                          {24.0, 25.0},
                                          {30.0, 25.0},
                                          {50.0, kNtscHz},
                                          {2 * kNtscHz, 50.0}})
    for (const std::uint64_t seed : {921u, 922u, 923u}) {
      const synth::Scene scene = OneRise(seed, film_hz);
      std::vector<int> source;
      while ((static_cast<double>(source.size()) + 0.5) * film_hz / shown_hz < scene.Frames())
        source.push_back(static_cast<int>((static_cast<double>(source.size()) + 0.5) * film_hz / shown_hz));
      ShownFrames shown = Show(scene, seed, source, shown_hz, 0.1);
      const FrameTimes times = CorrectFrameTimes({}, shown.recording);
      SCOPED_TRACE(testing::Message() << film_hz << " Hz shown at " << shown_hz << " Hz, seed " << seed);
      EXPECT_NEAR(times.captured_hz + times.chosen_from_hz, film_hz, 0.01);
      EXPECT_TRUE(times.jumps.empty());
      std::vector<double> late_s;
      for (std::size_t i = 1; i < source.size(); ++i)
        if (source[i] != source[i - 1] && source[i] + 1 < scene.Frames() && StepPx(scene, source[i]) > kLeastStepPx)
          late_s.push_back(shown.recording.time_s[i] - source[i] / film_hz);
      const auto [least, most] = std::ranges::minmax(late_s);
      EXPECT_LE(most - least, 2e-3);
    }
}

// Containers round stamps to milliseconds: of 30 Hz two in three intervals are 33 ms, which is not 25 Hz by a
// hundredth.
TEST(FrameTimes, OfALowerRateAreThoseOfRoundedStamps) {
  const synth::Scene scene = OneRise(745, 25);
  std::vector<int> source;
  for (int i = 0; i * 25 / 30 < scene.Frames(); ++i) source.push_back(i * 25 / 30);
  ShownFrames shown = Show(scene, 745, source, 30);
  for (double& time_s : shown.recording.time_s) time_s = std::round(1e3 * time_s) / 1e3;
  const FrameTimes times = CorrectFrameTimes({}, shown.recording);
  EXPECT_NEAR(times.captured_hz, 25, 0.01);
  const std::vector<double>& time_s = shown.recording.time_s;
  for (std::size_t i = 1; i < source.size(); ++i)
    if (source[i] != source[i - 1]) {
      EXPECT_NEAR(time_s[i] - time_s[0], source[i] / 25.0, 2e-3);
    }
}

// Of 24 frames in a second, shown at 25, one in 25 is a repetition. Two in 25 agree with nearly as many frames: new
// frames were taken for repetitions, and the time behind one of them to stand still. In a single rise four are seen.
TEST(FrameTimes, OfALowerRateAreThoseOfTheLikeliestPattern) {
  for (const int rises : {1, 3})
    for (const std::uint64_t seed : {745u, 746u, 747u, 748u}) {
      synth::SceneOptions options = synth::CleanScene(seed);
      options.motion.repetitions = rises;
      options.frame_rate_hz = 24;
      const synth::Scene scene(options);
      std::vector<int> source;
      for (int i = 0; i * 24 / 25 < scene.Frames(); ++i) source.push_back(i * 24 / 25);
      ShownFrames shown = Show(scene, seed, source, 25);
      const FrameTimes times = CorrectFrameTimes({}, shown.recording);
      EXPECT_NEAR(times.captured_hz, 24, 0.01) << seed << ", rises: " << rises;
      EXPECT_TRUE(times.jumps.empty()) << seed << ", rises: " << rises;
      for (const std::int64_t frame : times.repeated)
        EXPECT_EQ(source[static_cast<std::size_t>(frame)], source[static_cast<std::size_t>(frame) - 1]) << seed;
    }
}

// Strong coding changes a picture that is shown again, and none is the one before.
TEST(FrameTimes, OfALowerRateAreFoundWhereCodingChangesTheCopies) {
  for (const std::uint64_t seed : {745u, 746u, 747u}) {
    const synth::Scene scene = OneRise(seed, 30);
    std::vector<int> source;
    for (int i = 0; i < 2 * scene.Frames(); ++i) source.push_back(i / 2);
    ShownFrames shown = Show(scene, seed, source, 60);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> coding(0, 0.04);
    for (motion::MarkerTrack& marker : shown.recording.markers)
      for (std::size_t i = 1; i < source.size(); i += 2)
        marker.samples[i].position += Eigen::Vector2d(coding(random), coding(random));
    const FrameTimes times = CorrectFrameTimes({}, shown.recording);
    EXPECT_NEAR(times.captured_hz > 0 ? times.captured_hz : 30, 30, 0.01) << seed;
    EXPECT_EQ(times.repeated.size(), source.size() / 2) << seed;
    EXPECT_TRUE(times.jumps.empty()) << seed;
  }
}

// Of 60 Hz every 2.4th frame, the nearest one, is up to 8 ms early or late: at 25 Hz a fifth of the time between two.
// Frames that were taken at 25 Hz keep their stamps.
TEST(FrameTimes, OfFramesChosenFromAFasterFilmAreTheirs) {
  for (const auto& [seed, shown_hz, phase] :
       {std::tuple(761u, 25.0, 0.5), {762u, 50.0, 0.1}, {763u, 24.0, 0.3}, {761u, 24.0, 0.3}}) {
    const synth::Scene scene = OneRise(seed), slow = OneRise(seed, shown_hz);
    std::vector<int> chosen, all(static_cast<std::size_t>(slow.Frames()));
    for (int i = 0; kRateHz / shown_hz * i + 1 < scene.Frames(); ++i)
      chosen.push_back(static_cast<int>(std::floor(kRateHz / shown_hz * i + phase)));
    std::iota(all.begin(), all.end(), 0);
    ShownFrames fast = Show(scene, seed, chosen, shown_hz), own = Show(slow, seed, all, shown_hz);
    const std::vector<double> stamps_s = own.recording.time_s;
    EXPECT_EQ(CorrectFrameTimes({}, fast.recording).chosen_from_hz, 60) << seed << ", " << shown_hz;
    for (std::size_t i = 1; i < chosen.size(); ++i)
      EXPECT_NEAR(fast.recording.time_s[i] - fast.recording.time_s[0], (chosen[i] - chosen[0]) / kRateHz, 1e-9);
    EXPECT_EQ(CorrectFrameTimes({}, own.recording).chosen_from_hz, 0) << seed << ", " << shown_hz;
    EXPECT_EQ(own.recording.time_s, stamps_s);
  }
}

// A camera at 24 Hz that loses some frames: their neighbours' stamps are true, also where 25 Hz happens to be smoother.
TEST(FrameTimes, OfACameraThatLosesFramesAreTheStamps) {
  constexpr double kNoisy_px = 0.4;
  for (std::uint64_t seed = 770; seed < 787; ++seed) {
    const synth::Scene scene = OneRise(seed, 24);
    std::mt19937_64 random(seed);
    std::vector<int> kept;
    for (int i = 0; i < scene.Frames(); ++i)
      if (i == 0 || random() % 8 != 0) kept.push_back(i);
    ShownFrames shown = Show(scene, seed, kept, 24, kNoisy_px);
    for (std::size_t i = 0; i < kept.size(); ++i) shown.recording.time_s[i] = kept[i] / 24.0;
    const std::vector<double> stamps_s = shown.recording.time_s;
    EXPECT_EQ(CorrectFrameTimes({}, shown.recording).chosen_from_hz, 0) << seed;
    EXPECT_EQ(shown.recording.time_s, stamps_s) << seed;
  }
}

// Who sits down quickly lands on the seat: hip and waist go on by some millimetres at once, as if a frame were missing,
// but the knee does not.
TEST(FrameTimes, WhatTheSeatStrikesIsNoMissingTime) {
  constexpr double kStruck_px = 3;
  constexpr std::size_t kStruckIn = 110;  // frame
  for (std::uint64_t seed = 790; seed < 796; ++seed) {
    const synth::Scene scene = OneRise(seed, 50);
    std::vector<int> all(static_cast<std::size_t>(scene.Frames()));
    std::iota(all.begin(), all.end(), 0);
    ShownFrames shown = Show(scene, seed, all, 50, 0.1);
    const std::vector<double> stamps_s = shown.recording.time_s;
    for (motion::MarkerTrack& marker : shown.recording.markers) {
      if (marker.name != "hip" && marker.name != "waist") continue;
      const Eigen::Vector2d way =
          (marker.samples[kStruckIn + 1].position - marker.samples[kStruckIn].position).normalized();
      for (std::size_t i = kStruckIn + 1; i < marker.samples.size(); ++i)
        marker.samples[i].position += kStruck_px * way;
    }
    CorrectFrameTimes({}, shown.recording);
    EXPECT_EQ(shown.recording.time_s, stamps_s) << seed;
  }
}

// While something moves, the picture stands for a tenth of a second to a second and a half, and an encoder goes on
// refining it: the markers creep by hundredths of a pixel. It was taken for a rest of the person, or for a cut where it
// began. Time goes on meanwhile, and the frames are no measurements.
TEST(FrameTimes, AFrozenPictureIsNeitherARestNorACut) {
  int frozen = 0, found = 0, wrong = 0, films = 0;
  for (const auto& [seed, rate_hz] : {std::pair(771u, 24.0), {773u, 50.0}, {774u, 50.0}}) {
    const synth::Scene scene = OneRise(seed, rate_hz);
    for (const double length_s : {0.1, 0.25, 0.6, 1.5}) {
      const int length = static_cast<int>(std::lround(length_s * rate_hz));
      std::mt19937_64 random(seed + static_cast<std::uint64_t>(100 * length_s));
      std::normal_distribution<double> refined(0, 0.01);
      int begin = static_cast<int>(random() % static_cast<std::uint64_t>(scene.Frames() / 2));
      while (begin + length + 8 < scene.Frames() && (begin < 8 || StepPx(scene, begin - 1) * rate_hz < 30)) ++begin;
      if (begin + length + 8 >= scene.Frames() || StepPx(scene, begin + length - 1) * rate_hz < 30) continue;
      std::vector<int> source(static_cast<std::size_t>(scene.Frames()));
      std::iota(source.begin(), source.end(), 0);
      std::fill_n(source.begin() + begin, length, begin);
      ShownFrames shown = Show(scene, seed, source, rate_hz);
      for (motion::MarkerTrack& marker : shown.recording.markers) {
        Eigen::Vector2d crept = Eigen::Vector2d::Zero();
        for (int i = begin + 1; i < begin + length; ++i) {
          if (i % 4 == 1) crept += Eigen::Vector2d(refined(random), refined(random));
          marker.samples[static_cast<std::size_t>(i)].position += crept;
        }
      }
      ++films;
      FrameTimes times;
      EXPECT_NO_THROW(times = CorrectFrameTimes({}, shown.recording)) << seed << ", " << rate_hz << ", " << length_s;
      for (const std::int64_t frame : times.repeated) ++(frame > begin && frame < begin + length ? found : wrong);
      frozen += length - 1;
      EXPECT_TRUE(std::ranges::none_of(times.jumps, &TimeJump::is_applied)) << seed << ", " << rate_hz;
    }
  }
  std::printf("frozen: %d films, %d of %d frames found, %d others\n", films, found, frozen, wrong);
  EXPECT_GE(films, 8);
  EXPECT_EQ(found, frozen);
  EXPECT_EQ(wrong, 0);
}

// Strong coding changes each copy of a picture that stands for a tenth of a second, so that none is the one before.
TEST(FrameTimes, AShortFreezeIsFoundWhereCodingChangesTheCopies) {
  constexpr double kSlowHz = 30;
  for (const int copies : {1, 2, 3})
    for (const std::uint64_t seed : {775u, 776u, 777u}) {
      const synth::Scene scene = OneRise(seed, kSlowHz);
      int fastest = 8;
      for (int i = 8; i + 12 < scene.Frames(); ++i)
        if (StepPx(scene, i) > StepPx(scene, fastest)) fastest = i;
      std::vector<int> source(static_cast<std::size_t>(scene.Frames()));
      std::iota(source.begin(), source.end(), 0);
      std::fill_n(source.begin() + fastest, copies + 1, fastest);
      ShownFrames shown = Show(scene, seed, source, kSlowHz, 0.1);
      std::mt19937_64 random(seed);
      std::normal_distribution<double> coding(0, 0.05);
      for (motion::MarkerTrack& marker : shown.recording.markers)
        for (int i = fastest + 1; i <= fastest + copies; ++i)
          marker.samples[static_cast<std::size_t>(i)].position += Eigen::Vector2d(coding(random), coding(random));
      const FrameTimes times = CorrectFrameTimes({}, shown.recording);
      std::vector<std::int64_t> repeated(static_cast<std::size_t>(copies));
      std::iota(repeated.begin(), repeated.end(), fastest + 1);
      EXPECT_EQ(times.repeated, repeated) << copies << " copies, seed " << seed;
      EXPECT_TRUE(std::ranges::none_of(times.jumps, &TimeJump::is_applied)) << copies << " copies, seed " << seed;
    }
}

// Who comes to rest as quickly as a person can, rests to the last digit, and starts as quickly, is no frozen picture:
// the markers are where they were.
TEST(FrameTimes, AStillRestIsMeasured) {
  for (const auto& [seed, rate_hz] : {std::pair(781u, 25.0), {782u, 60.0}}) {
    const synth::Scene scene = OneRise(seed, rate_hz);
    const int ease = static_cast<int>(rate_hz / 3), rest = static_cast<int>(rate_hz), all = 2 * ease + rest;
    int middle = ease;
    for (int i = ease; i + ease < scene.Frames(); ++i)
      if (StepPx(scene, i) > StepPx(scene, middle)) middle = i;
    std::vector<int> source(static_cast<std::size_t>(all) + 1, middle);
    ShownFrames shown = Show(scene, seed, source, rate_hz);
    const synth::FrameTruth moved = scene.Truth(middle - ease), stopped = scene.Truth(middle);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, kNoisePx);
    for (int i = 0; i <= all; ++i) {
      const int from_rest = i < ease ? ease - i : std::max(0, i - ease - rest);
      if (from_rest == 0) continue;
      const double part = std::pow(static_cast<double>(from_rest) / ease, 2);
      for (std::size_t m = 0; m < moved.markers.size(); ++m)
        shown.recording.markers[m].samples[static_cast<std::size_t>(i)].position =
            stopped.markers[m].px + part * (moved.markers[m].px - stopped.markers[m].px) +
            Eigen::Vector2d(noise(random), noise(random));
    }
    EXPECT_EQ(CorrectFrameTimes({}, shown.recording).repeated.size(), 0u) << seed << ", " << rate_hz;
  }
}

// All markers jump by 20 mm at once, as where somebody pushes the camera: that is said, and the recording stands. A
// second jump soon after the first is said once, too, however near they look like one another.
TEST(FrameTimes, APositionJumpIsSaidAndNoCut) {
  for (const auto& [seed, jumps] : {std::pair(791u, 1), {792u, 1}, {793u, 2}}) {
    const synth::Scene scene = OneRise(seed);
    std::vector<int> source(static_cast<std::size_t>(scene.Frames()));
    std::iota(source.begin(), source.end(), 0);
    ShownFrames shown = Show(scene, seed, source);
    const int at = scene.Frames() / 2;
    const double px_per_mm = (scene.Truth(at).markers[0].px - scene.Truth(at).markers[1].px).norm() /
                             (scene.Truth(at).markers[0].mm - scene.Truth(at).markers[1].mm).norm();
    for (motion::MarkerTrack& marker : shown.recording.markers)
      for (int jump = 0; jump < jumps; ++jump)
        for (auto i = static_cast<std::size_t>(at + 12 * jump); i < marker.samples.size(); ++i)
          marker.samples[i].position.x() += 20 * px_per_mm;
    FrameTimes times;
    ASSERT_NO_THROW(times = CorrectFrameTimes({}, shown.recording)) << seed;
    ASSERT_EQ(std::ssize(times.position_jumps), jumps) << seed;
    for (int jump = 0; jump < jumps; ++jump) {
      EXPECT_EQ(times.position_jumps[static_cast<std::size_t>(jump)].after, at + 12 * jump) << seed;
      // A leg of 850 mm is assumed.
      EXPECT_NEAR(times.position_jumps[static_cast<std::size_t>(jump)].jump_mm, 20, 4) << seed;
    }
    EXPECT_TRUE(times.repeated.empty()) << seed;
  }
}

// A recording joined to itself: from the standing leg to the sitting one and from one movement into another. A fit
// through that was off by degrees on both sides, without a word.
TEST(FrameTimes, ACutIsAnError) {
  for (const auto& [rate_hz, seed] : {std::pair(24.0, 751u), {60.0, 752u}, {240.0, 754u}}) {
    const synth::Scene scene = OneRise(seed, rate_hz);
    const int all = scene.Frames();
    int standing = 0;
    for (int i = 1; i < all; ++i)
      if (scene.Truth(i).knee_deg < scene.Truth(standing).knee_deg) standing = i;
    for (const auto& [cut, again] : {std::pair(standing, 2), {standing / 2, standing}, {all - 1, standing}}) {
      std::vector<int> source(static_cast<std::size_t>(cut + all - again));
      std::iota(source.begin(), source.begin() + cut, 0), std::iota(source.begin() + cut, source.end(), again);
      ShownFrames shown = Show(scene, seed, source, rate_hz);
      EXPECT_THAT([&] { CorrectFrameTimes({}, shown.recording); },
                  testing::ThrowsMessage<Error>(
                      testing::HasSubstr(fmt::format("between frames {} and {} the markers jump", cut - 1, cut))))
          << rate_hz << " Hz, seed " << seed << ", from " << cut << " to " << again;
    }
    std::vector<int> source(static_cast<std::size_t>(all));
    std::iota(source.begin(), source.end(), 0);
    ShownFrames whole = Show(scene, seed, source, rate_hz);
    EXPECT_NO_THROW(CorrectFrameTimes({}, whole.recording));
  }
}

}  // namespace
}  // namespace lake::tracking
