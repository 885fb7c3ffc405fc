// sync.yaml, and the files that lake sync reads.
#include "lake/sync/clock.h"

#include <gmock/gmock.h>

#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/sync/movement.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Clock, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const sync::Clock clock{.offset_s = -1.25,
                          .drift_ppm = 40,
                          .from_s = 2,
                          .sd_s = 0.003,
                          .method = "motion",
                          .a = "trial: 'human'",
                          .b = "forces.mot"};
  sync::WriteClock(folder / "sync.yaml", clock);
  const sync::Clock read = sync::ReadClock(folder / "sync.yaml");
  EXPECT_EQ(read.offset_s, clock.offset_s);
  EXPECT_EQ(read.drift_ppm, clock.drift_ppm);
  EXPECT_EQ(read.from_s, clock.from_s);
  EXPECT_EQ(read.sd_s, clock.sd_s);
  EXPECT_EQ(read.a, clock.a);
  EXPECT_DOUBLE_EQ(read.FromB(12), 12 - 1.25 + 40e-6 * 10);
  EXPECT_EQ(sync::ReadClockOf(folder / "sync.yaml", "x/forces.mot").b, clock.b);
  EXPECT_THAT(MessageOf([&] { sync::ReadClockOf(folder / "sync.yaml", "trial: 'human'"); }),
              HasSubstr("not the other way"));
  WriteTextFile(folder / "least.yaml", "offset_s: 0.5\n");
  EXPECT_EQ(sync::ReadClock(folder / "least.yaml").FromB(1), 1.5);
}

TEST(Clock, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  const auto said = [&](const char* text) {
    WriteTextFile(folder / "sync.yaml", text);
    return MessageOf([&] { sync::ReadClock(folder / "sync.yaml"); });
  };
  EXPECT_THAT(said("drift_ppm: 3\n"), HasSubstr("no offset_s"));
  EXPECT_THAT(said("offset_s: soon\n"), HasSubstr("sync.yaml:1"));
  EXPECT_THAT(said("offset_s: 1\ndrift_ppm: 200000\n"), HasSubstr("none of a clock's"));
  EXPECT_THAT(said("offset_s: 1\nofset: 2\n"), HasSubstr("ofset"));
}

TEST(Movement, ReadsASensorsTableAndItsTrigger) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "imu.csv",
                "Time (ms),Gyroscope X (deg/s),Gyroscope Y (deg/s),Accelerometer X (g),sync\n"
                "0,1,2,0,0\n10,3,,0,0\n20,5,6,0,4\n30,7,8,0,4\n40,9,10,0,0\n50,9,10,0,1\n60,9,10,0,5\n");
  const sync::Movement movement = sync::ReadMovement(folder / "imu.csv");
  EXPECT_EQ(movement.kind, sync::MovementKind::kInertial);
  EXPECT_THAT(movement.names, ElementsAre("Gyroscope X (deg/s)", "Gyroscope Y (deg/s)"));
  EXPECT_DOUBLE_EQ(movement.time_s[2], 0.02);
  EXPECT_TRUE(std::isnan(movement.values(1, 1)));
  // Through 2.5, the middle of 0 and 5.
  EXPECT_THAT(sync::RisesOf(folder / "imu.csv", "sync"),
              ElementsAre(testing::DoubleNear(0.01625, 1e-9), testing::DoubleNear(0.05375, 1e-9)));
  EXPECT_THAT(MessageOf([&] { sync::RisesOf(folder / "imu.csv", "led"); }), HasSubstr("no signal 'led'"));
  EXPECT_THAT(MessageOf([&] { sync::RisesOf(folder / "imu.csv", "Accelerometer X (g)"); }), HasSubstr("never rises"));
}

TEST(Movement, SeesALampAsAMarkerThatComesIntoSight) {
  const TemporaryFolder folder;
  WriteTextFile(
      folder / "tracks.csv",
      "frame,time_s,knee_x_px,knee_y_px,led_x_px,led_y_px\n0,0,1,1,,\n1,0.1,1,1,,\n2,0.2,1,1,9,9\n3,0.3,1,1,9,9\n");
  EXPECT_THAT(sync::RisesOf(folder / "tracks.csv", "led"), ElementsAre(testing::DoubleNear(0.15, 1e-9)));
  EXPECT_THAT(MessageOf([&] { sync::RisesOf(folder / "tracks.csv", "knee"); }), HasSubstr("never comes into sight"));
  EXPECT_THAT(MessageOf([&] { sync::RisesOf(folder / "tracks.csv", "lamp"); }), HasSubstr("knee, led"));
}

}  // namespace
}  // namespace lake
