// The commands over the serial line: hold, stop, homing, jogs, the calibration firmware.
#include <fmt/format.h>

#include "firmware_fixture.h"
#include "lake/actuator/duty_calibration.h"

namespace lake {
namespace {

using testing::HasSubstr;

TEST_F(FirmwareTest, HoldAndStop) {
  Build(FreeDesign({{0, 300}, {2, 310}}));
  Start();
  rig_->Run(0.5);
  rig_->SendNow('!');
  rig_->Run(0.4);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_TRUE(Asks("run", "error:4")) << "a hold ends by stop";
  rig_->SendNow('?');
  EXPECT_TRUE(rig_->RunUntil("<hold|stroke:302.", 0.1)) << rig_->Serial();
  EXPECT_TRUE(Asks("stop", "ok"));
  EXPECT_TRUE(Asks("run", "error:5")) << "it begins again with homing";

  PowerUp();
  Start();
  rig_->Run(0.5);
  EXPECT_TRUE(Asks("stop", "ok"));
  rig_->Run(0.3);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_TRUE(Asks("run", "error:5")) << "half way is not the start";
}

// Grbl's soft reset: everything ends, the place is forgotten, the greeting says so.
TEST_F(FirmwareTest, ControlXResets) {
  Build(FreeDesign({{0, 300}, {2, 310}}));
  Start();
  rig_->Run(0.5);
  rig_->SendNow('\x18');
  EXPECT_TRUE(rig_->RunUntil("[MSG:lake-stroke]\n", 0.1)) << rig_->Serial();
  rig_->Run(0.1);
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_TRUE(Asks("run", "error:5"));
}

TEST_F(FirmwareTest, StatusTellsStrokeDriftDutyAndStops) {
  Build(FreeDesign({{0, 300}, {2, 310}}));
  Start();
  rig_->Run(1);
  const auto status = [&] {
    const std::size_t from = rig_->Serial().size();
    rig_->SendNow('?');
    EXPECT_TRUE(rig_->RunUntil(">\n", 0.1));
    return rig_->Serial().substr(rig_->Serial().find('<', from));
  };
  const std::string said = status();
  double stroke = 0, drift = 0, duty = 0;
  int stops = 0;
  ASSERT_EQ(
      std::sscanf(said.c_str(), "<running|stroke:%lf|drift:%lf|duty:%lf|stops:%d>", &stroke, &drift, &duty, &stops), 4)
      << said;
  EXPECT_NEAR(stroke, 305.05, 0.1);
  EXPECT_NEAR(duty, (5 / 1.1 + 3.2) / 12, 2e-4);
  EXPECT_EQ(stops, 0);
  // A tenth of the way, 0.1 mm of homing, 50 ms of lag of one run-up.
  EXPECT_NEAR(drift, 0.1 * (stroke - 300) + 0.1 + 0.25 + stroke_table_.pwm_error_mm, 0.02);
  // An end stop behind that the motion away from it presses is a fault, after which no stroke is known.
  rig_->PullWire(true, true);
  rig_->Run(0.005);
  EXPECT_THAT(status(), testing::HasSubstr("<fault|stroke:|drift:|duty:0.0000|stops:1>"));
}

TEST_F(FirmwareTest, HomesToTheEndStopThenToTheStart) {
  actuator_.stroke_mm = 0;
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SetStroke(303.7);
  rig_->Run(0.05);
  rig_->KeepTalking(true);
  rig_->Send("home");
  ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 8)) << rig_->Serial();
  rig_->Run(0.2);
  // Run-on past the switch: 5 mm/s x (4 ms + 10 ms brake); the way out loses 5 mm/s x (30 - 10) ms; PWM rounding below
  // 0.02.
  EXPECT_NEAR(rig_->Stroke(), 300, 0.07 + 0.10 + 0.03);
  EXPECT_TRUE(Asks("run", "ok"));
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 4)) << rig_->Serial();
  EXPECT_NEAR(rig_->Stroke(), 306, 0.07 + 0.2 + 0.03);
}

TEST_F(FirmwareTest, JogKeepsTheSoftLimits) {
  Build(FreeDesign({{0, 372}, {1, 373}}));  // the upper soft limit is 374.02 mm
  rig_->Run(0.05);
  ASSERT_TRUE(Asks("zero", "ok"));
  rig_->Send("jog 700 5000");
  EXPECT_TRUE(rig_->RunUntil("[MSG:jog ended at a limit]", 5)) << rig_->Serial();
  rig_->Run(0.1);
  EXPECT_LE(rig_->Stroke(), schedule_.limits.upper_mm + 0.15);
  EXPECT_GE(rig_->Stroke(), 373.7) << "it went as far as the drift leaves room: 374.5 - 0.6 mm, less 0.1 of lag";
  EXPECT_TRUE(Asks("jog 700 500", "error:8"));
  rig_->Send("jog -700 300");
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 1)) << "back is allowed";
  EXPECT_TRUE(Asks("run", "error:5")) << "after a jog the start is somewhere else";
}

TEST_F(FirmwareTest, CalibrationFirmwareJogsAndHasNoProgram) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  const auto elf = BuildFirmware(actuator::CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR");
  rig_ = std::make_unique<AvrRig>(elf, actuator_);
  rig_->Run(0.05);
  EXPECT_TRUE(Asks("run", "error:6")) << rig_->Serial();
  rig_->Send("jog -500 800");
  rig_->Run(0.5);
  EXPECT_NEAR(rig_->Samples().back().duty, -0.5, 0.5 / actuator::kPwmPeriod);
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", 1)) << rig_->Serial();
}

// The whole way of a new actuator: the calibration firmware jogs it, its serial output with the potentiometer's
// readings becomes a duty table, and that table is the actuator's.
TEST_F(FirmwareTest, SerialOutputOfJogsBecomesTheActuatorsDutyTable) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  actuator_.potentiometer_mm[0] = 240, actuator_.potentiometer_mm[1] = 380;
  rig_ =
      std::make_unique<AvrRig>(BuildFirmware(actuator::CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR"), actuator_);
  rig_->Run(0.05);
  for (const int duty : {200, 400, 700, 1000})
    for (const int sign : {1, -1}) {
      rig_->Send(fmt::format("jog {} 1200", sign * duty));
      ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 2)) << rig_->Serial();
      rig_->Run(0.15);
    }
  WriteTextFile(folder_ / "serial.csv", rig_->Serial());
  const actuator::DutyLog log =
      actuator::ReadDutyLog(folder_ / "serial.csv", actuator::ParsePotentiometerScale("0=240,1023=380"));
  const actuator::DutyTable measured = actuator::MakeDutyTable(actuator::CalibrateDuty({log}, {}).rows, "measured");
  for (const int direction : {1, -1}) {
    const actuator::DutyCurve &truth = table_.Curve(direction), &found = measured.Curve(direction);
    // Ten readings in steps of 0.14 mm (uniform: 0.04 mm SD) over 1 s: 0.04 / sqrt(10 x 0.29^2) = 0.045 mm/s, times 3.
    for (const double duty : {0.4, 0.7, 1.0}) EXPECT_NEAR(found.SpeedFor(duty), truth.SpeedFor(duty), 0.14) << duty;
    EXPECT_NEAR(found.DeadBandDuty(), truth.DeadBandDuty(),
                0.02);  // 0.14 mm/s of 13 mm/s per duty, extrapolated: twice that
  }
}

}  // namespace
}  // namespace lake
