#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <set>

#include "lake/synth/scene.h"
#include "synth/plain_scene.h"

namespace lake {
namespace {

struct HiddenRun {
  std::string marker;
  int first = 0, frames = 0;
};

std::vector<HiddenRun> HiddenRuns(const synth::Scene& scene) {
  std::vector<HiddenRun> runs;
  const auto& names = scene.Motion().Names();
  std::vector<bool> hidden(names.size(), false);
  std::vector<std::size_t> open(names.size());
  for (int frame = 0; frame < scene.Frames(); ++frame) {
    const synth::FrameTruth truth = scene.Truth(frame);
    for (std::size_t m = 0; m < names.size(); ++m) {
      if (!truth.markers[m].visible && !hidden[m]) open[m] = runs.size(), runs.push_back({names[m], frame, 0});
      hidden[m] = !truth.markers[m].visible;
      if (hidden[m]) ++runs[open[m]].frames;
    }
  }
  return runs;
}

class HardSceneOfSeed : public ::testing::TestWithParam<int> {};

TEST_P(HardSceneOfSeed, HidesThreeMarkersForEightTo26FramesAndNoOther) {
  const synth::Scene scene(synth::HardScene(static_cast<std::uint64_t>(GetParam())));
  const std::vector<HiddenRun> runs = HiddenRuns(scene);
  ASSERT_EQ(runs.size(), 3u);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const synth::Occlusion& asked = scene.Options().occlusions[i];
    EXPECT_EQ(runs[i].marker, asked.marker);
    EXPECT_NEAR(runs[i].frames, asked.hidden_s * 60, 1.01);
    EXPECT_NEAR(runs[i].first, asked.start_s * 60, 2);
    EXPECT_GE(runs[i].frames, 8);
    EXPECT_LE(runs[i].frames, 26);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, HardSceneOfSeed, ::testing::Values(1, 2, 3, 4, 5, 6, 7, 8, 101, 4711));

TEST(Occlusion, CoveredIsThePartOfTheLightThatIsMissing) {
  synth::SceneOptions options = test::PlainOptions();
  options.width_px = 640;
  options.height_px = 480;
  options.duration_s = 1;
  options.occlusions = {{"ball", 0.3, 0.3}};
  options.shutter = 0.5;
  const synth::Scene scene(options, test::OneMarker({0, 0}));
  double whole = 0;
  int between = 0;
  for (int frame = 0; frame < scene.Frames(); ++frame) {
    const double covered = scene.Truth(frame).markers[0].covered;
    const synth::ImagePatch patch = scene.RenderMarker(frame, "ball", {0, 0});
    const double light = cv::sum(patch.image)[0];
    if (frame == 0) {
      whole = light;
      EXPECT_LT(covered, 1e-6);
    }
    EXPECT_NEAR(light / whole, 1 - covered, 1e-4);
    between += covered > 0.1 && covered < 0.9;
    EXPECT_EQ(scene.Truth(frame).markers[0].visible, covered < 0.1);
  }
  EXPECT_GE(between, 2);
  EXPECT_GT(scene.Truth(27).markers[0].covered, 0.999);
}

TEST(Occlusion, AMarkerOutsideThePictureIsNotVisible) {
  synth::SceneOptions options = test::PlainOptions();
  options.camera = synth::Scene(options, test::OneMarker({0, 0})).Profile();
  const double half_width_mm = 0.5 * options.width_px * options.marker_radius_mm / options.marker_radius_px;
  const auto at = [&](double x) { return synth::Scene(options, test::OneMarker({x, 0})).Truth(0).markers[0]; };
  EXPECT_TRUE(at(half_width_mm - 8).visible);
  EXPECT_NEAR(at(half_width_mm).covered, 0.5, 0.03);  // the picture's middle lies half a pixel from the path's
  EXPECT_FALSE(at(half_width_mm).visible);
  EXPECT_EQ(at(half_width_mm + 100).covered, 1);
}

}  // namespace
}  // namespace lake
