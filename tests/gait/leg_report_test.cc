#include "lake/gait/leg_report.h"

#include <gmock/gmock.h>

namespace lake {
namespace {

motion::LegSample Sample(double knee_deg, double sigma_deg) {
  motion::LegSample sample;
  sample.knee_deg = knee_deg;
  sample.knee_sigma_deg = sigma_deg;
  return sample;
}

TEST(LegFitText, NamesTheMarkersNoiseAndNeverSaysThatItIsZero) {
  gait::LegFitResult fit;
  fit.motion.unit = motion::LengthUnit::kMm;
  fit.motion.samples = {Sample(9.5, 0.0001), Sample(96.25, 0.0001)};
  fit.segments = {{.name = "ak", .length = 430}};
  EXPECT_EQ(gait::LegFitText(fit),
            "shank (ankle to knee)  430.0 mm, varies by < 0.1 (SD)\n"
            "knee 9.50° to 96.25°, marker noise < 0.001° (1 SD): kinematics.csv\n"
            "0°: ankle, knee and hip markers in line, which need not be how the person stands (--neutral)\n");
}

TEST(LegFitText, LeavesOutAnglesThatAreUncertain) {
  gait::LegFitResult fit;
  fit.motion.samples = {Sample(9.5, 0.1), Sample(120, 2), Sample(96.25, 0.1)};
  EXPECT_THAT(gait::LegFitText(fit), testing::StartsWith("knee 9.50° to 96.25°"));
  fit.motion.samples = {Sample(120, 2)};
  EXPECT_EQ(gait::LegFitText(fit), "");
}

}  // namespace
}  // namespace lake
