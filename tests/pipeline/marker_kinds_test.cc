// Other markers than bright balls before something darker: each detector on a rendering with known truth.
#include <fmt/format.h>

#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

synth::SceneOptions OneRise(std::uint64_t seed) {
  synth::SceneOptions scene = synth::CleanScene(seed);
  scene.duration_s = 3;
  return scene;
}

// Errors of the estimates, after the tracks themselves were looked at.
TrackErrors TrackAndCompare(RenderedTrial& trial, const char* what, std::uint64_t seed,
                            const std::function<void(commands::TrackRunOptions&)>& change) {
  trial.Track("trial", change);
  const TrackErrors errors = CompareTracks(trial.Tracks(), trial.scene);
  Print(what, seed, errors, CompareKnee(trial.folder / "trial" / "kinematics.csv", trial.scene));
  EXPECT_EQ(errors.false_samples, 0);
  EXPECT_LE(errors.worst_px, 2) << "a marker took another's place";
  EXPECT_GE(errors.recall, 0.995);
  const TrackErrors estimates = CompareTracks(trial.EstimatesInPicture(), trial.scene);
  EXPECT_LE(estimates.rms_px, errors.rms_px) << "the fit's estimate is worse than the measurement it started from";
  return estimates;
}

std::string HexColour(const cv::Vec3f& bgr) {
  const auto level = [](float value) { return static_cast<int>(std::clamp(value, 0.F, 255.F)); };
  return fmt::format("#{:02X}{:02X}{:02X}", level(bgr[2]), level(bgr[1]), level(bgr[0]));
}

TEST(MarkerKinds, ColouredLightsAreFoundByTheirColours) {
  const std::uint64_t seed = SeedOfThisTest();
  synth::SceneOptions scene = OneRise(seed);
  scene.colour = true;
  scene.marker_bgr = synth::LedColours();
  RenderedTrial trial(scene, {.crf = 20, .preset = "medium"});  // for which the limit holds
  const TrackErrors errors = TrackAndCompare(trial, "lights", seed, [](commands::TrackRunOptions& options) {
    options.track.detector = tracking::DetectorKind::kColor;
    for (std::string_view marker : tracking::kLegMarkers)
      options.track.colors.push_back(HexColour(synth::LedColours().at(std::string(marker))));
  });
  // Colour has half the resolution of brightness in H.264's 4:2:0.
  EXPECT_LE(errors.rms_px, 0.10);
}

TEST(MarkerKinds, DarkMarkersInABrightRoom) {
  const std::uint64_t seed = SeedOfThisTest();
  synth::SceneOptions scene = OneRise(seed);
  scene.bright_room = true;
  scene.marker_level = 15;
  RenderedTrial trial(scene, {.crf = 17, .preset = "medium"});
  const TrackErrors errors = TrackAndCompare(trial, "dark", seed, [](commands::TrackRunOptions& options) {
    options.track.polarity = tracking::Polarity::kDark;
  });
  EXPECT_LE(errors.rms_px, 0.040);
}

TEST(MarkerKinds, ArucoMarkersNameThemselves) {
  const std::uint64_t seed = SeedOfThisTest();
  synth::SceneOptions scene = OneRise(seed);
  scene.marker_kind = synth::MarkerKind::kAruco;
  RenderedTrial trial(scene, {.crf = 17, .preset = "medium"});
  const TrackErrors errors = TrackAndCompare(trial, "aruco", seed, [](commands::TrackRunOptions& options) {
    options.track.detector = tracking::DetectorKind::kAruco;
  });
  // Four edges of 30 px each; 0.02 px is usual after H.264.
  EXPECT_LE(errors.rms_px, 0.04);
}

TEST(MarkerKinds, PatchesThatWerePointedAt) {
  const std::uint64_t seed = SeedOfThisTest();
  RenderedTrial trial(OneRise(seed), {.crf = 17});
  const synth::FrameTruth first = trial.scene.Truth(0);
  const TrackErrors errors = TrackAndCompare(trial, "template", seed, [&](commands::TrackRunOptions& options) {
    options.track.detector = tracking::DetectorKind::kTemplate;
    for (std::size_t i = 0; i < tracking::kLegMarkers.size(); ++i)
      options.track.seeds.push_back(
          {std::string(tracking::kLegMarkers[i]),
           first.markers[static_cast<std::size_t>(synth::IndexOfMarker(trial.scene.Motion(), tracking::kLegMarkers[i]))]
               .px,
           0});
  });
  // Against a disc of 4 px, whose model would give 0.03 px: a patch knows its marker as well.
  EXPECT_LE(errors.rms_px, 0.04);
}

}  // namespace
}  // namespace lake
