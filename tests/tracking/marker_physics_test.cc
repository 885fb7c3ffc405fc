#include "lake/tracking/marker_physics.h"

#include <gmock/gmock.h>

#include "lake/core/error.h"

namespace lake {
namespace {

TEST(MarkerPhysics, IsInRadiiOfAMarker) {
  const tracking::MarkerPhysics small;
  EXPECT_EQ(small.AccelerationRadii(), 1200);
  EXPECT_EQ(small.SpeedRadii(), 250);
  EXPECT_EQ(small.FastStartRadii(), 20);
  tracking::MarkerPhysics large;
  large.radius_mm = 16;
  EXPECT_EQ(large.AccelerationRadii(), 600);
}

TEST(MarkerPhysics, NamesTheValueThatCannotBe) {
  EXPECT_NO_THROW(tracking::MarkerPhysics().Check());
  tracking::MarkerPhysics physics;
  physics.turns_after_s = 0;
  EXPECT_THAT([&] { physics.Check(); }, testing::ThrowsMessage<UsageError>(testing::HasSubstr("turns back, s: 0")));
  physics = {};
  physics.max_speed_mm_s = -1;
  EXPECT_THAT([&] { physics.Check(); }, testing::ThrowsMessage<UsageError>(testing::HasSubstr("speed, mm/s: -1")));
  physics = {};
  physics.radius_mm = std::nan("");
  EXPECT_THAT([&] { physics.Check(); }, testing::ThrowsMessage<UsageError>(testing::HasSubstr("radius")));
}

}  // namespace
}  // namespace lake
