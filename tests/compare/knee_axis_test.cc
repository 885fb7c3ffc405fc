#include "lake/compare/knee_axis.h"

#include <gtest/gtest.h>

#include "lake/core/error.h"

namespace lake {
namespace {

TEST(KneeAxis, PassesThroughItsNodes) {
  EXPECT_NEAR(compare::TibiaOriginInFemur(120).x(), -3.2, 1e-2);
  EXPECT_NEAR(compare::TibiaOriginInFemur(60).x(), 4.1, 1e-3);
  EXPECT_NEAR(compare::TibiaOriginInFemur(30).y(), -399, 1e-3);
}

TEST(KneeAxis, BestFixedHingeLeavesThePublishedGap) {
  // The project's worked-out figures for 0–90°: 0.38 mm RMS, 0.97 mm at most.
  const compare::FixedPivot pivot = compare::BestFixedPivot(0, 90);
  EXPECT_NEAR(pivot.gap_rms_mm, 0.38, 0.005);
  EXPECT_NEAR(pivot.gap_max_mm, 0.97, 0.005);
}

TEST(KneeAxis, AnyOtherPivotIsWorse) {
  const compare::FixedPivot best = compare::BestFixedPivot(0, 90);
  for (const Eigen::Vector2d& shift :
       {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1)}) {
    double square = 0;
    for (int deg = 0; deg <= 90; ++deg) {
      const double c = std::cos(deg * M_PI / 180), s = std::sin(deg * M_PI / 180);
      const Eigen::Vector2d p = best.in_tibia_mm + shift;
      const Eigen::Vector2d in_femur =
          compare::TibiaOriginInFemur(deg) + Eigen::Vector2d(c * p.x() + s * p.y(), -s * p.x() + c * p.y());
      square += (in_femur - best.in_femur_mm).squaredNorm() / 91;
    }
    EXPECT_GT(std::sqrt(square), best.gap_rms_mm);
  }
}

TEST(KneeAxis, OffsetGap) {
  EXPECT_DOUBLE_EQ(compare::OffsetGap(10, 0), 0);
  EXPECT_NEAR(compare::OffsetGap(10, 60), 10, 1e-12);
  EXPECT_NEAR(compare::OffsetGap(10, 90), 14.142136, 1e-6);
}

TEST(KneeAxis, RefusesOtherAngles) {
  EXPECT_THROW(compare::TibiaOriginInFemur(121.0), UsageError);
}

}  // namespace
}  // namespace lake
