// Cameras that stand, lie or are set otherwise than the calibration: turned, tilted, of another size, read row by row.
#include <gmock/gmock.h>

#include <array>
#include <span>
#include <tuple>

#include "draws.h"
#include "lake/camera/camera.h"
#include "lake/commands/gait.h"
#include "lake/commands/track.h"
#include "lake/core/error.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

synth::SceneOptions OneRise(std::uint64_t seed) {
  synth::SceneOptions scene = CleanLeg(seed);
  scene.motion.repetitions = 1;
  scene.duration_s = 0;
  scene.frame_rate_hz = 30;
  return scene;
}

KneeErrors KneeOf(const RenderedTrial& trial, const std::string& name) {
  return CompareKnee(trial.folder / name / "kinematics.csv", trial);
}

// A standing leg's thigh is upright.
double SmallestThighDeg(const RenderedTrial& trial, const std::string& name) {
  double smallest = 180;
  for (const motion::LegSample& sample : motion::ReadKinematicsCsv(trial.folder / name / "kinematics.csv").samples)
    smallest = std::min(smallest, std::abs(sample.thigh_deg));
  return smallest;
}

void ExpectVerticalOfTheLeg(RenderedTrial& trial, double roll_deg) {
  const Json found = trial.Track("auto", [](commands::TrackRunOptions& options) {
    options.camera.reset();
    options.vertical_from_leg = true;
  });
  EXPECT_EQ(found["sit_to_stands"].size(), 1u) << roll_deg;
  EXPECT_LT(KneeOf(trial, "auto").fitted_deg, 0.03) << roll_deg;
  EXPECT_LT(SmallestThighDeg(trial, "auto"), 5) << roll_deg;
  EXPECT_THAT(found["warnings"].dump(), testing::HasSubstr("the vertical is that of the leg as it stands"));
}

TEST(CameraStance, SidewaysRecordingsAreTurnedByOptionOrToldTheirVertical) {
  for (const auto& [roll_deg, rotate_deg, seed] : {std::tuple{90.0, 270, 3u}, {-90.0, 90, 4u}}) {
    synth::SceneOptions scene = OneRise(seed);
    scene.roll_deg = roll_deg;
    scene.width_px = 800;  // not its height
    RenderedTrial trial(scene, kQuickly);
    const auto uncalibrated = [](commands::TrackRunOptions& options) { options.camera.reset(); };
    const Json turned = trial.Track("turned", [&, rotate_deg = rotate_deg](commands::TrackRunOptions& options) {
      uncalibrated(options);
      options.track.reader.rotate_deg = rotate_deg;
    });
    EXPECT_EQ(turned["video"]["width"], 720);
    EXPECT_EQ(turned["sit_to_stands"].size(), 1u);
    EXPECT_LT(KneeOf(trial, "turned").fitted_deg, 0.03);
    EXPECT_LT(SmallestThighDeg(trial, "turned"), 5);

    // A horizontal plumb line: which of its ends is up, another one in each recording, shows in the leg.
    const Json lined = trial.Track("lined", [&](commands::TrackRunOptions& options) {
      uncalibrated(options);
      options.vertical = std::array<double, 4>{100, 300, 700, 300};
    });
    EXPECT_EQ(lined["sit_to_stands"].size(), 1u);
    EXPECT_LT(KneeOf(trial, "lined").fitted_deg, 0.03);
    EXPECT_LT(SmallestThighDeg(trial, "lined"), 5);

    if (roll_deg > 0) ExpectVerticalOfTheLeg(trial, roll_deg);

    // What fits the folder again stands on the same ground.
    commands::GaitRunOptions again;
    again.trial = trial.folder / "lined";
    lake::Run run({"lake-gait", "test", Json::object(), trial.folder / "again", true});
    EXPECT_EQ(commands::RunGait(again, run)["sit_to_stands"].size(), 1u);
  }
}

TEST(CameraStance, TheVerticalIsFoundFromTheLegItself) {
  for (const auto& [roll_deg, seed] : {std::pair{180.0, 6u}, {-35.0, 7u}, {20.0, 8u}}) {
    synth::SceneOptions scene = OneRise(seed);
    scene.roll_deg = roll_deg;
    RenderedTrial trial(scene, kQuickly);
    ExpectVerticalOfTheLeg(trial, roll_deg);
  }
}

TEST(CameraStance, ACameraOfAnotherSizeIsScaledAndSaidToBe) {
  RenderedTrial trial(OneRise(9), kQuickly);
  camera::CameraProfile profile = camera::ReadCameraProfile(trial.folder / "camera.yaml");
  profile.camera = *camera::CameraAtSize(profile.camera, 1080, 1080);
  camera::WriteCameraProfile(trial.folder / "large.yaml", profile);
  trial.Track();
  const Json scaled =
      trial.Track("scaled", [&](commands::TrackRunOptions& options) { options.camera = trial.folder / "large.yaml"; });
  EXPECT_THAT(scaled["warnings"].dump(),
              testing::HasSubstr("calibrated at 1080x1080 px and scaled to the video's 720x720"));
  const auto own = motion::ReadMarkerCsv(trial.folder / "trial" / "trajectory.csv"),
             other = motion::ReadMarkerCsv(trial.folder / "scaled" / "trajectory.csv");
  for (std::size_t i = 0; i < own.Frames(); i += 10)
    EXPECT_LT((own.Find("knee")->samples[i].position - other.Find("knee")->samples[i].position).norm(), 1e-6);
  profile.camera.image_width = 1440;
  camera::WriteCameraProfile(trial.folder / "other.yaml", profile);
  EXPECT_THROW(
      trial.Track("other", [&](commands::TrackRunOptions& options) { options.camera = trial.folder / "other.yaml"; }),
      Error);
}

TEST(RollingShutter, IsUndone) {
  constexpr std::array kCases = {std::tuple{0.020, 60.0, 11u}, std::tuple{0.030, 30.0, 12u},
                                 std::tuple{0.008, 120.0, 13u}};
  for (const auto& [readout_s, rate_hz, seed] : std::span(kCases).first(Draws(2, kCases.size()))) {
    synth::SceneOptions scene = OneRise(seed);
    scene.readout_s = readout_s;
    scene.frame_rate_hz = rate_hz;
    RenderedTrial trial(scene, {});
    trial.Track("global");
    const Json rolling = trial.Track(
        "rolling", [readout = readout_s](commands::TrackRunOptions& options) { options.readout_s = readout; });
    const KneeErrors before = KneeOf(trial, "global"), after = KneeOf(trial, "rolling");
    std::printf("readout %.3f s at %.0f Hz, seed %u: knee %.4f deg, error/sd %.2f; with --readout %.4f deg, %.2f\n",
                readout_s, rate_hz, seed, before.fitted_deg, before.z_deviation, after.fitted_deg, after.z_deviation);
    EXPECT_LT(after.fitted_deg, 0.03) << readout_s;
    EXPECT_LT(after.fitted_deg, before.fitted_deg) << readout_s;
    EXPECT_GT(after.z_deviation, 0.5) << readout_s;
    EXPECT_LT(after.z_deviation, 1.4) << readout_s;
    EXPECT_EQ(rolling["video"]["readout_s"], readout_s);
    if (seed == 12) {  // the slowest rate: the camera's profile may say it as well
      camera::CameraProfile profile = camera::ReadCameraProfile(trial.folder / "camera.yaml");
      profile.readout_s = readout_s;
      camera::WriteCameraProfile(trial.folder / "rolling.yaml", profile);
      trial.Track("profile",
                  [&](commands::TrackRunOptions& options) { options.camera = trial.folder / "rolling.yaml"; });
      EXPECT_EQ(KneeOf(trial, "profile").fitted_deg, after.fitted_deg);
    }
    // What was seen stays where it was seen.
    const motion::MarkerRecording tracks = trial.Tracks("rolling");
    for (const motion::MarkerSample& sample : tracks.Find("knee")->samples)
      EXPECT_EQ(sample.status, motion::SampleStatus::kDetected);
  }
}

}  // namespace
}  // namespace lake
