#include <gtest/gtest.h>

#include <cmath>

#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"

namespace lake {
namespace {

motion::MarkerSample At(double x, double y) {
  return {{x, y}, 0.1, motion::SampleStatus::kDetected};
}

TEST(MedianDistance, IsOfTheFramesInWhichBothAreKnown) {
  motion::MarkerRecording recording;
  recording.frame = {0, 1, 2, 3};
  recording.time_s = {0, 0.1, 0.2, 0.3};
  recording.markers = {{"knee", {At(0, 0), At(0, 0), {}, At(1, 1)}},
                       {"hip", {At(3, 4), At(0, 7), At(9, 9), At(1, 10)}}};
  EXPECT_DOUBLE_EQ(motion::MedianDistance(recording, "knee", "hip"), 7);  // of 5, 7 and 9
  EXPECT_TRUE(std::isnan(motion::MedianDistance(recording, "knee", "ankle"))) << "there is no ankle";
  recording.markers[1].samples.assign(4, {});
  EXPECT_TRUE(std::isnan(motion::MedianDistance(recording, "knee", "hip"))) << "the hip is never seen";
}

TEST(MedianLength, IsOfTheFramesInWhichTheVectorIsKnown) {
  motion::LegMotion leg;
  leg.samples.resize(4);
  leg.samples[0].ak = {3, 4};
  leg.samples[1].ak = {0, 6};
  leg.samples[3].ak = {0, 100};
  EXPECT_DOUBLE_EQ(motion::MedianLength(leg, &motion::LegSample::ak), 6);
  EXPECT_TRUE(std::isnan(motion::MedianLength(leg, &motion::LegSample::kh)));
}

}  // namespace
}  // namespace lake
