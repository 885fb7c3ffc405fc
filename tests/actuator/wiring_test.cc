// What is seen where everything is wired; which way the motor turns where nothing measures it; all combinations.
#include "actuator/combinations.h"
#include "host/host_fixture.h"
#include "lake/core/error.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class EverythingWiredTest : public HostFirmwareTest {
 protected:
  void SetUp() override {
    WireAll(firmware_options_);
    actuator_.noise_counts = 0.5;
    actuator_.has_relay = true;
  }
  void BuildAtStart() {
    Build(FreeDesign({{0, 300}, {3, 315}}));
    rig_->Run(0.6);
    ASSERT_TRUE(Asks("zero", "ok"));
  }
  void StartRun() {
    BuildAtStart();
    ASSERT_TRUE(Asks("run", "ok")) << rig_->Serial();
    rig_->Run(1);
    ASSERT_GT(rig_->Duty(), 0) << rig_->Serial();
  }
};

// 400 N are 1.6 A beyond the idle current.
TEST_F(EverythingWiredTest, AForceAboveItsLimitIsOff) {
  EXPECT_NEAR(firmware_options_.StallCurrent(), 1.9, 1e-9);
  actuator_.a_per_n = 1 / 250.0;
  StartRun();
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  rig_->Actuator().load_n = [](double, double) { return 420; };
  EXPECT_TRUE(rig_->RunUntil("ALARM:12\n", 0.4)) << rig_->Serial();
}

// At rest the relay is open: nothing that the bridge does moves the motor.
TEST_F(EverythingWiredTest, TheRelayIsOpenAtRestAndAfterAFault) {
  BuildAtStart();
  EXPECT_EQ(rig_->Board().relay, 0);
  ASSERT_TRUE(Asks("run", "ok"));
  rig_->Run(1);
  EXPECT_EQ(rig_->Board().relay, 1);
  rig_->PullWire(false, true);
  ASSERT_TRUE(rig_->RunUntil("ALARM:1\n", 0.1)) << rig_->Serial();
  rig_->Run(0.002);
  EXPECT_EQ(rig_->Board().relay, 0);
}

TEST_F(EverythingWiredTest, AWeldedRelayIsFoundBeforeAnythingMoves) {
  Build(FreeDesign({{0, 300}, {3, 315}}));
  rig_->Breaks().is_relay_welded = true;
  EXPECT_TRUE(rig_->RunUntil("ALARM:16\n", 1)) << rig_->Serial();
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.motor_duty, 0);
}

// Power that a shorted transistor takes is off within 100 ms and 1 mm, whichever way it drives and the program goes.
TEST_F(EverythingWiredTest, AShortedTransistorIsSwitchedOffByTheRelay) {
  for (const int way : {1, -1})
    for (const bool is_held : {false, true}) {
      StartRun();
      if (is_held) {
        rig_->SendNow('!');
        rig_->Run(0.3);
      }
      const double since = rig_->Time(), from = rig_->Stroke();
      rig_->Breaks().shorted = way;
      rig_->Run(0.3);
      double last = since, way_mm = 0;
      for (const RigSample& sample : rig_->Samples())
        if (sample.time_s > since && sample.motor_duty != 0) {
          last = sample.time_s;
          way_mm = std::abs(sample.stroke_mm - from);
        }
      EXPECT_LE(last - since, 0.1) << way << is_held << rig_->Serial();
      EXPECT_LE(way_mm, 1) << way << is_held;
      EXPECT_EQ(rig_->Board().relay, 0);
      std::printf("shorted transistor: off after %.0f ms, %.2f mm\n", 1e3 * (last - since), way_mm);
    }
}

TEST_F(EverythingWiredTest, FaultsAreLoggedBeyondAReset) {
  BuildAtStart();
  rig_->Breaks().wiper = RigBreaks::Wiper::kLost;
  ASSERT_TRUE(rig_->RunUntil("ALARM:7\n", 0.1));
  rig_->Breaks().wiper = RigBreaks::Wiper::kFine;
  rig_->Run(0.1);
  ASSERT_TRUE(Asks("reset", "ok"));
  rig_->PullWire(true, true);
  rig_->PullWire(false, true);
  ASSERT_TRUE(rig_->RunUntil("ALARM:2\n", 0.1));
  rig_->PowerUp();
  rig_->Run(0.1);
  const std::size_t from = rig_->Serial().size();
  ASSERT_TRUE(Asks("faults", "ok"));
  EXPECT_THAT(rig_->Serial().substr(from), HasSubstr("[FAULT:2,idle,0]\n[FAULT:7,idle,0]\n"));
}

TEST_F(EverythingWiredTest, OnePinForTwoIsRefused) {
  firmware_options_.Check();
  firmware_options_.pins.in1 = 8;
  EXPECT_THAT([&] { firmware_options_.Check(); }, ThrowsMessage<Error>(HasSubstr("in1 and in2 are both on D8")));
}

TEST_F(EverythingWiredTest, AFasterProgramThanItsLimitIsRefused) {
  EXPECT_THAT(
      [&] {
        Build(FreeDesign({{0, 300}, {2, 315}}));
      },
      ThrowsMessage<Error>(HasSubstr("the program goes at 7.500 mm/s, and --speed-limit is 6 mm/s")));
}

// Which way the motor turns, where nothing measures the stroke.
class DirectionTest : public HostFirmwareTest {
 protected:
  void BuildNearTheTop() {
    firmware_options_.extend_stop_mm = 0.7;
    Build(FreeDesign({{0, 360}, {2, 366}}));
    rig_->Actuator().extend_stop_mm = schedule_.limits.upper_end_mm - 0.7;
    rig_->Breaks().is_reversed = true;
  }
};

// `home` retracts, and a reversed motor extends: into the extend end stop, or on from it where that is pressed.
TEST_F(DirectionTest, AReversedMotorDoesNotPassTheLinkagesEnd) {
  for (const double below_stop_mm : {5.0, 0.1, -0.01}) {
    BuildNearTheTop();
    rig_->SetStroke(rig_->Actuator().extend_stop_mm - below_stop_mm);
    rig_->Run(0.05);
    for (int i = 0; i < 5; ++i) {
      rig_->Send("home");
      rig_->RunUntil("ALARM:5\n", 3);
      rig_->Run(0.3);
      EXPECT_LT(rig_->Stroke(), schedule_.limits.upper_end_mm) << below_stop_mm << ", attempt " << i;
      rig_->Send("reset");
      rig_->Run(0.1);
    }
    EXPECT_THAT(rig_->Serial(), HasSubstr("ALARM:5\n"));
    EXPECT_TRUE(Asks("home", "error:11")) << "attempts are counted";
  }
}

TEST_F(DirectionTest, AStopTravelThatTheLinkageHasNoRoomForIsRefused) {
  firmware_options_.home_stroke_mm = 242.4978;  // the lower soft limit: 0.5 mm before the dead point
  firmware_options_.stop_travel_mm = 0.51;
  EXPECT_THAT(
      [&] {
        Build(FreeDesign({{0, 300}, {2, 306}}));
      },
      ThrowsMessage<Error>(HasSubstr("--stop-travel 0.51 mm is not less than the 0.500 mm")));
  firmware_options_.stop_travel_mm = 0.4;
  Build(FreeDesign({{0, 300}, {2, 306}}));
}

// Where the retract end stop does not come, by its wire at ground: the stroke is known, or a potentiometer sees it.
TEST_F(DirectionTest, HomingEndsBeforeTheDeadPoint) {
  for (const bool pot : {false, true}) {
    if (pot) WirePotentiometer(firmware_options_);
    firmware_options_.home_stroke_mm = 244;
    Build(FreeDesign({{0, 245}, {2, 250}}));
    ASSERT_TRUE(Asks("zero", "ok"));
    ASSERT_TRUE(Asks("jog 500 1000", "ok"));
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 2));
    rig_->Actuator().retract_stop_mm = -1000;
    rig_->Run(0.3);
    ASSERT_TRUE(Asks("home", "ok"));
    EXPECT_TRUE(rig_->RunUntil("ALARM:4\n", 10)) << rig_->Serial();
    rig_->Run(0.3);
    EXPECT_GT(rig_->Stroke(), schedule_.limits.lower_end_mm) << (pot ? "pot" : "planned");
  }
}

// Whatever is wired: it homes and runs.
class CombinationsTest : public HostFirmwareTest {};

TEST_F(CombinationsTest, PairsOccurInFewOfThem) {
  EXPECT_EQ(AllCombinations().size(), 48U);
  EXPECT_LE(CombinationsOfPairs().size(), 10U);
}

TEST_F(CombinationsTest, EachHomesAndRuns) {
  for (const Combination& one : CombinationsToTry()) {
    SCOPED_TRACE(one.Name());
    firmware_options_ = one.Options();
    actuator_ = {};
    actuator_.has_relay = one.Has(Combination::kRelay);
    Build(FreeDesign({{0, 300}, {2, 306}, {2.5, 306}, {4, 302}}));
    rig_->SetStroke(304);
    rig_->PowerUp();
    rig_->Run(0.6);
    Home(20);
    rig_->Run(0.3);
    RunToEnd(6);
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
    EXPECT_NEAR(rig_->Stroke(), 302, 0.6);  // the lags of five changes of speed, open loop
  }
}

// The motor's current: a short, a stall and a motor that takes none are told and stopped, within the time stated.

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
