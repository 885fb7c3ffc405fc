// What stops the motor, and within which time.
#include "firmware_fixture.h"
#include "lake/actuator/stroke_session.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;
using namespace std::string_literals;

// The power fails in the middle of a program; when it is back nothing moves until the actuator has been homed.
TEST_F(FirmwareTest, PowerUpInMidStrokeIsStillAndAsksToBeHomed) {
  Build(FreeDesign({{0, 300}, {2, 308}}));
  Start();
  rig_->Run(1);
  ASSERT_GT(rig_->Samples().back().duty, 0);
  actuator_.stroke_mm = rig_->Stroke();
  ASSERT_NEAR(actuator_.stroke_mm, 304, 0.3);
  PowerUp();
  rig_->KeepTalking(true);
  rig_->Run(1);
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0) << sample.time_s;
  EXPECT_TRUE(rig_->Changes().empty());
  EXPECT_THAT(rig_->Serial(), HasSubstr("<idle|stroke:|drift:|duty:0.0000|stops:0>"));
  EXPECT_TRUE(Asks("run", "error:5")) << rig_->Serial();
  Home(5);
  RunToEnd(4);
  // Run-on past the switch and lags, 5 mm/s x (4 ms + 10 ms), 5 mm/s x (30 - 10) ms.
  EXPECT_NEAR(rig_->Stroke(), 308, 0.07 + 0.2 + 0.03);
}

// Within one tick of 1 ms, the time the interrupt itself takes included.
TEST_F(FirmwareTest, EndStopAheadBrakesWithinOneTick) {
  home_below_start_mm_ = 12;  // far from where either belongs: there it would be no fault
  for (const bool retract : {false, true}) {
    Build(FreeDesign(retract ? std::vector<linkage::StrokeProgram::Knot>{{0, 310}, {3, 300}}
                             : std::vector<linkage::StrokeProgram::Knot>{{0, 300}, {3, 310}}));
    actuator_.retract_stop_mm = 0;  // only the wires act here
    for (const double moment_s : {0.7, 0.7003, 0.7007}) {
      PowerUp();
      Start();
      rig_->Run(moment_s);
      ASSERT_NE(rig_->Samples().back().duty, 0);
      const double pressed = rig_->Time();
      rig_->PullWire(retract, true);
      EXPECT_TRUE(rig_->RunUntil("ALARM:1\n", 0.2)) << rig_->Serial();
      EXPECT_LE(BrakeAfter(pressed), 1.1e-3);
    }
    rig_->PullWire(retract, false);
    EXPECT_TRUE(Asks("run", "error:4")) << "a fault stays until reset";
    EXPECT_EQ(rig_->Samples().back().duty, 0);
    EXPECT_TRUE(Asks("reset", "ok"));
    EXPECT_TRUE(Asks("run", "error:5")) << "the stroke is unknown after a fault";
  }
}

TEST_F(FirmwareTest, HoldBrakesWithinTwoMilliseconds) {
  Build(FreeDesign({{0, 300}, {3, 310}}));
  Start();
  rig_->Run(0.5);
  const double asked = rig_->Time();
  rig_->SendNow('!');
  rig_->Run(0.1);
  EXPECT_LE(BrakeAfter(asked), 3e-3);  // up to 1 ms until the rig sends it, 0.1 ms on the line, then the next tick
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
}

TEST_F(FirmwareTest, ASilentHostHoldsTheProgram) {
  Build(FreeDesign({{0, 300}, {4, 316}}));
  Start();
  rig_->Run(0.3);
  rig_->KeepTalking(false);
  rig_->Send("alive");
  rig_->Run(0.0025);
  const double last_heard = rig_->Time();
  rig_->Run(2.2);
  EXPECT_NEAR(BrakeAfter(last_heard), firmware_options_.command_timeout_s, 0.003);
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:host silent, stopped]"));
  EXPECT_THAT(rig_->Serial(), HasSubstr(",hold,"));
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, GarbageIsNoHost) {
  Build(FreeDesign({{0, 300}, {4, 316}}));
  Start();
  rig_->KeepTalking(false);
  const double since = rig_->Time();
  for (int i = 0; i < 25; ++i) rig_->SendPlain("\xfe\x80 noise?\nalive\n"), rig_->Run(0.1);
  EXPECT_LT(BrakeAfter(since), firmware_options_.command_timeout_s + 0.01);
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:host silent, stopped]"));
}

// A limit in the flash that homing would leave: the firmware itself does not.
TEST_F(FirmwareTest, PositioningAndRunningKeepTheLimitsWithTheDrift) {
  Build(FreeDesign({{0, 300}, {4, 320}}));
  const auto with = [&](const std::string& name, const std::string& value) {
    const std::size_t from = header_.find("#define " + name + " ");
    EXPECT_NE(from, std::string::npos) << name;
    std::string changed = header_;
    return changed.replace(from, header_.find('\n', from) - from, "#define " + name + " " + value);
  };
  const auto power_up = [&](const std::string& text) {
    elf_ = BuildFirmware(actuator::Feedback::kNone, text, "-DLAKE_SIMULATOR");
    actuator_.stroke_mm = 300;
    PowerUp();
    rig_->Run(0.05);
    rig_->KeepTalking(true);
  };
  power_up(with("LAKE_UPPER_LIMIT_UM", "299000L"));
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_TRUE(rig_->RunUntil("ALARM:3\n", 8)) << rig_->Serial();
  EXPECT_LT(rig_->Stroke(), 299.05 + 0.15);

  // 310 mm less the drift there: 0.1 mm of homing, 0.25 of lag, a tenth of the way.
  power_up(with("LAKE_UPPER_END_UM", "310000L"));
  ZeroAndRun();
  EXPECT_TRUE(rig_->RunUntil("ALARM:3\n", 4)) << rig_->Serial();
  rig_->Run(0.2);
  EXPECT_NEAR(rig_->Stroke(), 300 + (10 - 0.35 - PwmError()) / (1 + 103 / 1024.0), 0.1 + 0.05);
}

// On a bench without a person the user may do without that limit, and the firmware says so.
TEST_F(FirmwareTest, AnAcceptedDriftIsSaidInTheGreetingAndRuns) {
  firmware_options_.accept_drift = true;
  Build(FreeDesign({{0, 370}, {0.8, 374}}));
  Start();
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:drift accepted, no person]\n"));
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 2)) << rig_->Serial();
}

TEST_F(FirmwareTest, ASpikeOnAnEndStopDoesNotStopBothWiresOffDo) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  Start();
  rig_->Run(0.3);
  for (int i = 0; i < 40; ++i) {  // at any phase of the tick
    rig_->PullWire(false, true);
    rig_->Run(5e-6);  // shorter than four readings take
    rig_->PullWire(false, false);
    rig_->Run(0.00099);
  }
  EXPECT_GT(rig_->Samples().back().duty, 0);
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  rig_->PullWire(true, true);
  rig_->PullWire(false, true);
  EXPECT_TRUE(rig_->RunUntil("ALARM:2\n", 0.2)) << rig_->Serial();
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, AHangingMainLoopIsOffAtOnceAndResetByTheWatchdog) {
  Build(FreeDesign({{0, 300}, {4, 312}}));
  Start();
  rig_->Run(0.3);
  ASSERT_GT(rig_->Samples().back().duty, 0);
  const double hung = rig_->Time();
  rig_->Send("hang");
  EXPECT_TRUE(rig_->RunUntil("[MSG:lake-stroke, reset by the watchdog]", 1)) << rig_->Serial();
  EXPECT_LE(DriveTimeAfter(hung), 0.009);  // 2 ms until it was sent and obeyed, 5 ms late, and a sample
  rig_->Run(0.5);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_TRUE(Asks("run", "error:5")) << rig_->Serial();
}

// In the chip's EEPROM, as in BrokenWiresTest.AFaultIsLatchedUntilItIsAcknowledged.
TEST_F(FirmwareTest, AFaultOutlivesAResetOfTheChip) {
  Build(FreeDesign({{0, 300}, {4, 312}}));
  rig_->Run(0.05);
  rig_->PullWire(true, true), rig_->PullWire(false, true);
  ASSERT_TRUE(rig_->RunUntil("ALARM:2\n", 0.2)) << rig_->Serial();
  rig_->PullWire(true, false), rig_->PullWire(false, false);
  rig_->Run(0.05);
  rig_->Send("hang");
  ASSERT_TRUE(rig_->RunUntil("reset by the watchdog", 1)) << rig_->Serial();
  EXPECT_TRUE(rig_->RunUntil("ALARM:2\n", 0.1)) << rig_->Serial();
  EXPECT_TRUE(Asks("home", "error:4"));
  EXPECT_TRUE(Asks("reset", "ok"));
  rig_->Run(0.05);
  rig_->Send("hang");
  ASSERT_TRUE(rig_->RunUntil("reset by the watchdog", 1)) << rig_->Serial();
  EXPECT_TRUE(Asks("zero", "ok")) << rig_->Serial();
}

TEST_F(FirmwareTest, EndStopsActWhileTheMainLoopHangs) {
  Build(FreeDesign({{0, 300}, {4, 312}}));
  Start();
  rig_->Run(0.3);
  rig_->Send("hang");
  rig_->Run(0.003);
  ASSERT_GT(rig_->Samples().back().duty, 0);
  const double pressed = rig_->Time();
  rig_->PullWire(false, true);
  rig_->Run(0.05);
  EXPECT_LE(BrakeAfter(pressed), 1.1e-3);
}

TEST_F(FirmwareTest, HomingWithoutAnEndStopGivesUp) {
  firmware_options_.home_speed_mm_s = 11;
  linkage::Design design = FreeDesign({{0, 300}, {2, 306}});
  design.d_max_mm = 308;  // little travel, so that it gives up after 3.4 s
  Build(design);
  actuator_.retract_stop_mm = -1000;
  PowerUp();
  rig_->Run(0.05);
  rig_->KeepTalking(true);
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_TRUE(rig_->RunUntil("ALARM:4\n", 5)) << rig_->Serial();
  EXPECT_EQ(rig_->Samples().back().duty, 0);
}

TEST_F(FirmwareTest, ToleratesGarbageOnTheSerialLine) {
  Build(FreeDesign({{0, 300}, {1, 303}}));
  rig_->Run(0.05);
  for (const char* line : {"", "strat", "jog", "run "}) {
    const std::size_t from = rig_->Serial().size();
    rig_->Send(line), rig_->Run(0.1);
    EXPECT_EQ(rig_->Serial().find("error:1\n", from) != std::string::npos, true) << line;
  }
  for (const char* line : {"jog 0 100", "jog 2000 100", "jog 100 99999", "jog 100", "jog 1 2 3", "jog 100 -5", "jog  "})
    EXPECT_TRUE(Asks(line, "error:2")) << line;
  EXPECT_TRUE(Asks("a line that is far longer than the buffer of the receiver, and then some", "error:3"));
  // Of plain text only what stops or tells is obeyed.
  for (const std::string& plain :
       {std::string("home\n"), std::string("zero\n"), std::string("jog 300 100\n"), std::string("reset\n"),
        std::string("\0\n", 2), std::string("\xff\xfe\x01\n"), std::string("stop\0\n", 6), std::string("home*0000\n"),
        actuator::Framed("home") + "\0\n"s, "x" + actuator::Framed("home") + "\n"}) {
    rig_->SendPlain(plain);
    EXPECT_TRUE(rig_->RunUntil("error:9\n", 0.2)) << plain;
  }
  rig_->SendPlain("stop\n");
  EXPECT_TRUE(rig_->RunUntil("ok\n", 0.2));
  for (const char c : {'~', '!', '~', '\x18'}) rig_->SendNow(c), rig_->Run(0.1);
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0);
  Start();
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 2)) << "and goes on to work";
  rig_->Send("quit");
  rig_->Run(0.2);
  EXPECT_TRUE(rig_->HasEnded());
}

}  // namespace
}  // namespace lake
