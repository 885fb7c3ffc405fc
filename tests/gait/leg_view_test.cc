#include "lake/gait/leg_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lake/core/error.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

TEST(LegView, ProjectionAndItsInverseAgree) {
  gait::LegView scaled_lens = CalibratedView();
  scaled_lens.camera_from_plane.reset(), scaled_lens.mm_per_px = 1.7;
  for (const gait::LegView& view : {ScaledView(), CalibratedView(), scaled_lens, gait::LegView{}}) {
    const bool calibrated = view.camera_from_plane.has_value();
    for (const double depth_mm : {0.0, calibrated ? 40.0 : 0.0})
      for (const Eigen::Vector2d& pixel :
           {Eigen::Vector2d(300, 200), Eigen::Vector2d(900, 600), Eigen::Vector2d(640, 360)}) {
        const Eigen::Vector2d point = gait::PlaneFromRecorded(view, pixel, depth_mm);
        EXPECT_LT((gait::RecordedFromPlane<double>(view, point, depth_mm) - pixel).norm(), 1e-8);
        const double scale = gait::PlaneUnitsPerRecorded(view, point, depth_mm);
        const Eigen::Vector2d beside = gait::PlaneFromRecorded(view, pixel + Eigen::Vector2d(0.5, 0.5), depth_mm);
        EXPECT_NEAR((beside - point).norm() / std::sqrt(0.5), scale, 0.1 * scale);
      }
  }
}

// What was taken as in the plane is put at its depth without the camera: where it would have been seen there.
TEST(PlaneSight, PutsAMarkerAtItsDepth) {
  const gait::LegView view = CalibratedView();
  std::optional<gait::PlaneSight> sight = gait::SightOf(view);
  const Eigen::Vector2d pixel(900, 250), flat = gait::PlaneFromRecorded(view, pixel, 0);
  EXPECT_LT((gait::PlaneFromRecorded(view, pixel, -1) - flat - sight->Slope(flat)).norm(), 1e-3);
  motion::MarkerRecording recording{motion::LengthUnit::kMm, {0}, {0}, {}};
  recording.markers.push_back({"exo_knee", {{flat, 0.1, motion::SampleStatus::kDetected}}});
  for (const double depth_mm : {40.0, 15.0}) {  // from the plane, and from another depth
    gait::PutAtDepths({{"exo_knee", {depth_mm, 5}}, {"absent", {1, {}}}}, sight, recording);
    EXPECT_LT((recording.markers[0].samples[0].position - gait::PlaneFromRecorded(view, pixel, depth_mm)).norm(), 1e-9);
    sight = gait::PlaneSightIn({{gait::kPlaneSight, gait::PlaneSightJson(*sight)}}, "summary.json");
    EXPECT_EQ(gait::DepthOf(*sight, "exo_knee"), (gait::MarkerDepth{depth_mm, 5}));
  }
  sight.reset();
  EXPECT_THROW(gait::PutAtDepths({{"exo_knee", {40, 5}}}, sight, recording), UsageError);
  EXPECT_THROW(gait::PlaneSightIn({{gait::kPlaneSight, 3}}, "summary.json"), Error);
}

TEST(PlaneSight, ADepthIsANumberWithItsDeviation) {
  using Value = OptionValue<gait::MarkerDepth>;
  EXPECT_EQ(Value::Parse("40±5", "--depth"), (gait::MarkerDepth{40, 5}));
  EXPECT_EQ(Value::Parse("-3.5", "--depth"), (gait::MarkerDepth{-3.5, {}}));
  EXPECT_EQ(Value::Format({40, 2.5}), "40±2.5");
  for (const char* bad : {"", "±5", "40±", "40±-1", "40+5"}) EXPECT_THROW(Value::Parse(bad, "--depth"), UsageError);
}

TEST(LegView, APlumbLineGivesTheVertical) {
  const Eigen::Vector2d up = gait::UpFromPlumbLine(gait::LegView{}, {100, 500}, {110, 100});
  EXPECT_NEAR(up.x(), 10 / std::hypot(10, 400), 1e-12);
  EXPECT_GT(up.y(), 0.9);
  EXPECT_LT((gait::UpFromPlumbLine(gait::LegView{}, {110, 100}, {100, 500}) - up).norm(), 1e-12);
  EXPECT_THROW(gait::UpFromPlumbLine(gait::LegView{}, {1, 1}, {1, 1}), Error);
}

}  // namespace
}  // namespace lake
