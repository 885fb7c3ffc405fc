// The motor's current: a short, a stall and a motor that takes none are told and stopped, within the time stated.
#include "host/host_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class CurrentSenseTest : public HostFirmwareTest {
 protected:
  void SetUp() override {
    firmware_options_.current_sense = true;
    actuator_.noise_counts = 1, actuator_.spikes = 0.01;
  }
  void Start() {
    Build(FreeDesign({{0, 300}, {8, 340}}));
    ZeroAndRun();
    rig_->Run(1);
    ASSERT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  }
  void ExpectAlarm(const char* alarm, double within_s) {
    const double since = rig_->Time();
    EXPECT_TRUE(rig_->RunUntil(alarm, 2)) << rig_->Serial();
    EXPECT_LE(rig_->Time() - since, within_s);
    rig_->Run(0.2);
    EXPECT_EQ(rig_->Duty(), 0);
  }
};

TEST_F(CurrentSenseTest, RunsUnderLoadAndSaysTheCurrent) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    actuator_.seed = seed;
    actuator_.load_n = [](double, double) { return 200; };
    Start();
    rig_->Run(0.2);
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
    const std::size_t row = rig_->Serial().rfind(",running,");
    int adc = 0, stops = 0;
    double current_a = 0;
    ASSERT_EQ(std::sscanf(rig_->Serial().c_str() + row, ",running,%d,%d,%lf", &adc, &stops, &current_a), 3);
    // 0.3 A and 0.8 A of load; noise of a count is 26 mA, smoothed over 4 x 8 readings; the lag's share is gone by 1 s.
    EXPECT_NEAR(current_a, 1.1, 0.1) << seed;
    EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 8)) << rig_->Serial();
  }
}

// What breaks while it runs, and within which time it is reported. A stall at 5 mm/s draws 0.3 A and 4 A times the duty
// of 0.65: 2.9 A, less than a short. A lost sense wire, pulled down, reads what no motor takes.
TEST_F(CurrentSenseTest, WhateverBreaksIsReportedInTime) {
  const std::pair<Act, double> breaks[] = {{[](HostRig& rig) { rig.Actuator().idle_a = 6; }, 0.03},
                                           {Breaks(&RigBreaks::is_blocked, true), 0.35},
                                           {Breaks(&RigBreaks::current_wire, true), 0.03}};
  for (const auto& [act, within_s] : breaks) {
    Start();
    act(*rig_);
    ExpectAlarm("ALARM:12\n", within_s);
  }
}

// By its inrush, at each start: a load that helps may leave a turning motor without any.
TEST_F(CurrentSenseTest, AMotorThatIsUnpluggedIsToldAtItsStart) {
  Build(FreeDesign({{0, 300}, {8, 340}}));
  rig_->Breaks().is_motor_unplugged = true;
  ZeroAndRun();
  ExpectAlarm("ALARM:13\n", 0.42);  // 60 ms of checks before it is driven
}

TEST_F(CurrentSenseTest, ALoadThatRelievesTheMotorIsNoFault) {
  Start();
  rig_->Actuator().idle_a = 0, rig_->Actuator().stall_a = 0;
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 8)) << rig_->Serial();
}

// What the sensor reads at rest is its zero, up to 0.1 V off.
TEST_F(CurrentSenseTest, AnOffsetIsLearntAtRest) {
  for (const double offset_v : {-0.08, -0.03, 0.03, 0.08}) {
    Build(FreeDesign({{0, 300}, {8, 340}}));
    rig_->Breaks().current_offset_v = offset_v;
    rig_->PowerUp();
    rig_->Run(0.1);
    ZeroAndRun();
    EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 9)) << offset_v << rig_->Serial();
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  }
}

TEST_F(CurrentSenseTest, AnInrushIsNoStall) {
  actuator_.time_constant_s = 0.12;
  Start();
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 8)) << rig_->Serial();
}

}  // namespace
}  // namespace lake
