// A recorded motion, rendered: its truth is the recording.
#include <gtest/gtest.h>

#include "lake/synth/scene.h"
#include "places.h"
#include "real_leg.h"

namespace lake {
namespace {

TEST(RealMotion, RendersWithTheRecordingsOwnAnglesAndFiveRises) {
  const auto leg = RealLeg("right");
  if (!leg) GTEST_SKIP() << "no recording in " << SharedData() / "opencap_sts";
  const synth::MotionTable& table = *leg;
  ASSERT_EQ(table.time_s.size(), 861u);
  for (const bool mirror : {false, true}) {
    synth::SceneOptions options = synth::CleanScene(1);
    options.duration_s = 0;
    options.frame_rate_hz = 100;  // as recorded, so that frames meet rows
    const synth::Scene scene(options, synth::MakeTableMotion(table, mirror));
    EXPECT_EQ(scene.Motion().FacingInImage(), mirror ? motion::Facing::kLeft : motion::Facing::kRight);
    ASSERT_EQ(scene.Frames(), 860);
    std::vector<double> falls_through_35;
    double lowest = 1e9, highest = -1e9, last = 0;
    for (int frame = 0; frame < scene.Frames(); ++frame) {
      const synth::FrameTruth truth = scene.Truth(frame);
      const auto at = [&](const char* name) {
        return table.positions[std::ranges::find(table.names, name) - table.names.begin()][frame];
      };
      EXPECT_NEAR(truth.knee_deg, synth::KneeAngleDeg(at("ankle"), at("knee"), at("hip"), motion::Facing::kRight),
                  1e-6);
      for (const synth::MarkerTruth& marker : truth.markers) EXPECT_TRUE(marker.visible) << frame;
      lowest = std::min(lowest, truth.knee_deg);
      highest = std::max(highest, truth.knee_deg);
      if (frame > 0 && last > 35 && truth.knee_deg <= 35) falls_through_35.push_back(table.time_s[frame]);
      last = truth.knee_deg;
    }
    EXPECT_NEAR(lowest, 4.2, 0.1);  // the data's README: 4.2..95.7° in the x–y plane
    EXPECT_NEAR(highest, 95.7, 0.1);
    const double listed[] = {0.76, 2.44, 4.09, 5.61, 7.24};  // of the 3-D angle, ±0.05 s
    ASSERT_EQ(falls_through_35.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(falls_through_35[i], listed[i], 0.1);
  }
}

}  // namespace
}  // namespace lake
