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

TEST(LegView, APlumbLineGivesTheVertical) {
  const Eigen::Vector2d up = gait::UpFromPlumbLine(gait::LegView{}, {100, 500}, {110, 100});
  EXPECT_NEAR(up.x(), 10 / std::hypot(10, 400), 1e-12);
  EXPECT_GT(up.y(), 0.9);
  EXPECT_LT((gait::UpFromPlumbLine(gait::LegView{}, {110, 100}, {100, 500}) - up).norm(), 1e-12);
  EXPECT_THROW(gait::UpFromPlumbLine(gait::LegView{}, {1, 1}, {1, 1}), Error);
}

}  // namespace
}  // namespace lake
