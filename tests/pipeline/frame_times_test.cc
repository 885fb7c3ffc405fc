// Recordings whose frames are not what their time stamps say: repeated, cut out, frozen, shown at another rate.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "lake/core/error.h"
#include "lake/video/video_writer.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

constexpr double kRateHz = 60;

// One rise, a leg before an even background, as pictures; all tests of a seed encode from these.
class Footage {
 public:
  explicit Footage(std::uint64_t seed) : scene_(Options(seed)) {
    for (int frame = 0; frame < scene_.Frames(); ++frame) pictures_.push_back(scene_.Render(frame));
  }

  static const Footage& OfSeed(std::uint64_t seed) {
    static std::map<std::uint64_t, Footage> all;
    return all.try_emplace(seed, seed).first->second;
  }

  const synth::Scene& Scene() const { return scene_; }
  int Frames() const { return static_cast<int>(pictures_.size()); }

  // The frames of this list, one after the other, at 60 Hz.
  void Write(const std::filesystem::path& path, const std::vector<int>& frames, int crf) const {
    video::VideoWriterOptions options;
    options.width = pictures_.front().cols;
    options.height = pictures_.front().rows;
    options.frame_rate_hz = kRateHz;
    options.crf = crf;
    options.grey = true;
    video::VideoWriter writer(path, options);
    for (std::size_t i = 0; i < frames.size(); ++i)
      writer.Write(pictures_[static_cast<std::size_t>(frames[i])], static_cast<double>(i) / kRateHz);
    writer.Finish();
  }

 private:
  static synth::SceneOptions Options(std::uint64_t seed) {
    synth::SceneOptions scene = synth::CleanScene(seed);
    scene.room = scene.body = false;
    scene.duration_s = 4;
    return scene;
  }

  synth::Scene scene_;
  std::vector<cv::Mat> pictures_;
};

struct Shown {
  Json summary;
  motion::MarkerRecording tracks;
  double knee_deg = 0;     // rms of the knee's error, each frame at the time the tables give it
  double raw_deg = 0;      // the same of the frames' own
  double z_deviation = 0;  // of the knee's error over its sigma
  double time_s = 0;       // rms error of the frames' times, of those that show something new
  double detected_px = 0;  // rms of the detected positions' error, 2-D
};

// The knee angle at any time, between the frames' own by a cubic (Catmull & Rom 1974).
double TrueKnee(const synth::Scene& scene, double time_s) {
  const int last = scene.Frames() - 1;
  const double frame = std::clamp(time_s * kRateHz, 0.0, static_cast<double>(last));
  const int i = std::min(static_cast<int>(frame), last - 1);
  const double u = frame - i;
  const auto knee = [&](int k) { return scene.Truth(std::clamp(k, 0, last)).knee_deg; };
  const double a = knee(i - 1), b = knee(i), c = knee(i + 1), d = knee(i + 2);
  return b + 0.5 * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
}

// Tracks what `frames` show, which was captured `slower` times as slowly, and prints how far off that is. Times are
// compared apart from an offset.
Shown TrackShown(const std::string& what, const Footage& footage, const std::vector<int>& frames, int crf = 20,
                 double slower = 1) {
  TemporaryFolder folder;
  footage.Write(folder / "video.mp4", frames, crf);
  camera::WriteCameraProfile(folder / "camera.yaml", footage.Scene().Profile());
  commands::TrackRunOptions options;
  options.video = folder / "video.mp4";
  options.camera = folder / "camera.yaml";
  options.overlay = false;
  options.track.quiet = true;
  Run run({"lake-track", "test", Json::object(), folder / "trial", true});
  Shown shown;
  shown.summary = run.WriteSummary(commands::RunTrack(options, run));
  shown.tracks = motion::ReadMarkerCsv(folder / "trial" / "tracks.csv");
  const motion::LegMotion motion = motion::ReadKinematicsCsv(folder / "trial" / "kinematics.csv");

  const auto is_new = [&](std::size_t i) { return i == 0 || frames[i] != frames[i - 1]; };
  std::vector<double> offsets;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (is_new(i)) offsets.push_back(motion.time_s[i] - slower * frames[i] / kRateHz);
  const double offset_s = Median(offsets);
  std::vector<double> knee, raw, z, time, position;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (is_new(i)) time.push_back(motion.time_s[i] - offset_s - slower * frames[i] / kRateHz);
    const double truth = TrueKnee(footage.Scene(), (motion.time_s[i] - offset_s) / slower);
    const motion::LegSample& sample = motion.samples[i];
    if (std::isfinite(sample.knee_deg)) {
      knee.push_back(sample.knee_deg - truth);
      z.push_back(knee.back() / sample.knee_sigma_deg);
    }
    if (std::isfinite(sample.knee_raw_deg)) raw.push_back(sample.knee_raw_deg - truth);
    const synth::FrameTruth at = footage.Scene().Truth(frames[i]);
    for (std::size_t m = 0; m < shown.tracks.markers.size(); ++m)
      if (shown.tracks.markers[m].samples[i].status == motion::SampleStatus::kDetected)
        position.push_back((shown.tracks.markers[m].samples[i].position - at.markers[m].px).norm());
  }
  shown.knee_deg = RootMeanSquare(knee);
  shown.raw_deg = RootMeanSquare(raw);
  shown.z_deviation = RootMeanSquare(z);
  shown.time_s = RootMeanSquare(time);
  shown.detected_px = RootMeanSquare(position);
  fmt::print("{}: knee {:.4f} deg, raw {:.4f}, z {:.2f}, times {:.5f} s, detected {:.4f} px, {} rises; {}\n", what,
             shown.knee_deg, shown.raw_deg, shown.z_deviation, shown.time_s, shown.detected_px,
             shown.summary["sit_to_stands"].size(), shown.summary["warnings"].dump());
  return shown;
}

std::vector<int> AllFrames(const Footage& footage) {
  std::vector<int> frames(static_cast<std::size_t>(footage.Frames()));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = static_cast<int>(i);
  return frames;
}

class RepeatedFrames : public testing::TestWithParam<int> {};

// As select='not(eq(mod(n,5),1))',fps=60 makes it: a frame in `every` is not there, the one before it is shown again.
TEST_P(RepeatedFrames, AreNoMeasurements) {
  const std::uint64_t seed = std::map<int, int>{{3, 28275}, {4, 69330}, {5, 97541}, {6, 12908}}.at(GetParam());
  const Footage& footage = Footage::OfSeed(seed);
  std::vector<int> frames = AllFrames(footage);
  int repeated = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (static_cast<int>(i) % GetParam() == 1) frames[i] = frames[i - 1], ++repeated;
  const Shown shown = TrackShown(fmt::format("one frame in {} repeated, seed {}", GetParam(), seed), footage, frames);
  EXPECT_LE(shown.knee_deg, 0.05);
  EXPECT_LE(shown.raw_deg, 0.1);
  EXPECT_LE(shown.z_deviation, 1.4);
  EXPECT_LE(shown.time_s, 1e-3);
  EXPECT_LE(shown.detected_px, 0.1);
  EXPECT_EQ(shown.summary["sit_to_stands"].size(), 1u);
  EXPECT_GE(shown.summary["video"].value("repeated_frames", 0), repeated / 4)
      << "a quarter of the time something moves";
  EXPECT_THAT(shown.summary["warnings"].dump(), testing::HasSubstr("repeated"));
}

INSTANTIATE_TEST_SUITE_P(OneIn, RepeatedFrames, testing::Values(3, 4, 5, 6),
                         [](const auto& info) { return std::to_string(info.param); });

class StretchedRate : public testing::TestWithParam<int> {};

// A recording of fewer frames a second than it is shown with: the frames are equally far apart, their stamps are not.
TEST_P(StretchedRate, GivesTheFramesTheirOwnTimesBack) {
  const std::uint64_t seed = GetParam() == 3 ? 66591 : 25536;
  const Footage& footage = Footage::OfSeed(seed);
  const int period = GetParam();
  std::vector<int> frames;
  for (int frame = 0; frame < footage.Frames(); ++frame) {
    frames.push_back(frame);
    if (frame % (period - 1) == 1) frames.push_back(frame);
  }
  const double slower = static_cast<double>(period) / (period - 1);
  const Shown shown = TrackShown(fmt::format("{} frames in the time of {}, seed {}", period - 1, period, seed), footage,
                                 frames, 20, slower);
  EXPECT_LE(shown.knee_deg, 0.05);
  EXPECT_LE(shown.raw_deg, 0.1);
  EXPECT_LE(shown.z_deviation, 1.4);
  EXPECT_LE(shown.time_s, 1e-3);
  EXPECT_NEAR(shown.summary["video"].value("captured_rate_hz", 0.0), kRateHz / slower, 0.01);
  EXPECT_EQ(shown.summary["sit_to_stands"].size(), 1u);
  EXPECT_THAT(shown.summary["warnings"].dump(), testing::HasSubstr("repeated"));
}

INSTANTIATE_TEST_SUITE_P(OneIn, StretchedRate, testing::Values(3, 6),
                         [](const auto& info) { return std::to_string(info.param); });

// Where the knee turns fastest.
int FastestFrame(const synth::Scene& scene) {
  int fastest = 20;
  double most = 0;
  for (int i = 20; i + 40 < scene.Frames(); ++i) {
    const double speed = std::abs(scene.Truth(i + 1).knee_deg - scene.Truth(i - 1).knee_deg);
    if (speed > most) most = speed, fastest = i;
  }
  return fastest;
}

// One, of this true duration, with an honest sigma.
void ExpectJump(const Shown& shown, double true_s) {
  const Json& jumps = shown.summary["video"]["time_jumps"];
  ASSERT_EQ(jumps.size(), 1u);
  const double sigma_s = jumps[0]["moved_sigma_s"].get<double>();
  EXPECT_NEAR(jumps[0]["moved_s"].get<double>(), true_s, 3 * sigma_s);
  EXPECT_LE(sigma_s, 0.1 * true_s);
}

TEST(FrozenPicture, IsNoMeasurementWhileTimeGoesOn) {
  const std::uint64_t seed = 51709;
  const Footage& footage = Footage::OfSeed(seed);
  std::vector<int> frames = AllFrames(footage);
  const int from = FastestFrame(footage.Scene()) - 7;
  for (int i = from + 1; i <= from + 15; ++i) frames[static_cast<std::size_t>(i)] = from;
  const Shown shown = TrackShown(fmt::format("15 frames frozen from {}, seed {}", from, seed), footage, frames);
  EXPECT_LE(shown.knee_deg, 1);
  EXPECT_LE(shown.raw_deg, 0.05);
  EXPECT_LE(shown.z_deviation, 1.4);
  EXPECT_LE(shown.time_s, 1e-3);
  EXPECT_THAT(shown.summary["warnings"].dump(), testing::HasSubstr(fmt::format("{} to {}", from + 1, from + 15)));
}

TEST(FrozenPicture, IsNoMeasurementWhileTimeStandsStill) {
  const std::uint64_t seed = 64603;
  const Footage& footage = Footage::OfSeed(seed);
  std::vector<int> frames = AllFrames(footage);
  const int from = FastestFrame(footage.Scene());
  frames.insert(frames.begin() + from, 15, from);
  const Shown shown = TrackShown(fmt::format("15 frames inserted at {}, seed {}", from, seed), footage, frames);
  EXPECT_LE(shown.knee_deg, 0.05);
  EXPECT_LE(shown.time_s, 1e-3);
  ExpectJump(shown, 1 / kRateHz);
  EXPECT_THAT(shown.summary["warnings"].dump(), testing::HasSubstr(fmt::format("{} to {}", from + 1, from + 15)));
}

class MissingTime : public testing::TestWithParam<int> {};

TEST_P(MissingTime, IsToldFromTheMotion) {
  const std::uint64_t seed = GetParam() == 3 ? 5721 : 2018;
  const Footage& footage = Footage::OfSeed(seed);
  std::vector<int> frames = AllFrames(footage);
  const int at = FastestFrame(footage.Scene()) - GetParam() / 2;
  frames.erase(frames.begin() + at, frames.begin() + at + GetParam());
  const Shown shown =
      TrackShown(fmt::format("{} frames cut out at {}, seed {}", GetParam(), at, seed), footage, frames);
  EXPECT_LE(shown.knee_deg, 0.05 + 0.02 * GetParam());
  EXPECT_LE(shown.raw_deg, 0.05 + 0.02 * GetParam());
  EXPECT_LE(shown.time_s, 0.03 * GetParam() / kRateHz);
  ExpectJump(shown, (GetParam() + 1) / kRateHz);
  EXPECT_THAT(shown.summary["warnings"].dump(), testing::HasSubstr(fmt::format("frames {} and {}", at - 1, at)));
}

INSTANTIATE_TEST_SUITE_P(Frames, MissingTime, testing::Values(3, 20),
                         [](const auto& info) { return std::to_string(info.param); });

TEST(WholeRecording, IsTakenAsItIs) {
  const std::uint64_t seed = 66129;
  const Footage& footage = Footage::OfSeed(seed);
  for (const int crf : {17, 30}) {
    const Shown shown = TrackShown(fmt::format("whole, crf {}, seed {}", crf, seed), footage, AllFrames(footage), crf);
    EXPECT_EQ(shown.summary["video"].value("repeated_frames", 0), 0);
    EXPECT_EQ(shown.summary["warnings"].size(), 0u);
    EXPECT_LE(shown.time_s, 1e-4);
  }
}

}  // namespace
}  // namespace lake
