// The calibration firmware and the soft reset; ByHandTest and ControllerTest have what else a serial monitor meets.
#include <fmt/format.h>

#include "firmware_fixture.h"
#include "lake/actuator/duty_calibration.h"

namespace lake {
namespace {

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

// The whole way of a new actuator: the calibration firmware jogs it, its serial output with the potentiometer's
// readings becomes a duty table, and that table is the actuator's.
TEST_F(FirmwareTest, SerialOutputOfJogsBecomesTheActuatorsDutyTable) {
  actuator_.table = &table_;
  actuator_.stroke_mm = 300;
  elf_ = BuildFirmware(actuator::Feedback::kNone, actuator::CalibrationHeader({}, "test"), "-DLAKE_SIMULATOR");
  PowerUp();
  rig_->Run(0.05);
  EXPECT_TRUE(Asks("run", "error:6")) << rig_->Serial();
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
