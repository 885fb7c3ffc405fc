// The firmware, compiled as a user does, in a simulator of the ATmega328P with a model of bridge, motor and end stops.
#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "actuator/compiled_once.h"
#include "actuator/program_fixture.h"
#include "avr_rig.h"
#include "lake/core/atomic_file.h"
#include "temporary_folder.h"

namespace lake {

// From a tick until all is done: the controller is late by less than a ms. The budget of board.c.
inline constexpr double kLongestTurn_us = 2000;

// The image of the firmware with this table, compiled once for all tests. Throws if it does not compile without a
// warning.
inline std::filesystem::path BuildFirmware(actuator::Feedback feedback, const std::string& stroke_table,
                                           const std::string& flags) {
  return CompiledOnce(
      feedback, stroke_table,
      LAKE_AVR_GCC " -mmcu=atmega328p -std=gnu99 -Os -flto -Wall -Wextra -Werror " + flags + " *.c -o firmware.elf",
      "firmware.elf");
}

// Up, slower, a reversal without a pause, a rest.
inline const std::vector<linkage::StrokeProgram::Knot> kKnots = {{0, 300},   {0.8, 304.8}, {1.6, 307.2},
                                                                 {2.4, 302}, {2.7, 302},   {3.5, 305}};

// Whose motor takes 0.5 A whatever it does: the times of alarms do not depend on a model of its current.
inline Actuator SteadyActuator() {
  Actuator actuator;
  actuator.idle_a = 0.5, actuator.a_per_n = actuator.stall_a = 0;
  return actuator;
}

class FirmwareTest : public RigTest<AvrRig> {
 protected:
  FirmwareTest() { actuator_ = SteadyActuator(); }

  void Build(const linkage::Design& design, const std::string& flags = "-DLAKE_SIMULATOR",
             const actuator::ScheduleOptions& how = {}) {
    firmware_options_.home_stroke_mm = 0;
    MakeProgram(design, how);
    elf_ = BuildFirmware(firmware_options_.feedback, header_, flags);
    PowerUp();
  }

  // The UNO starts, the actuator standing where the model says.
  void PowerUp() { rig_ = std::make_unique<AvrRig>(elf_, actuator_); }

  // The time from `since` on until the motor is braked; NaN if it is not.
  double BrakeAfter(double since_s) const {
    for (const DriveChange& change : rig_->Changes())
      if (change.time_s > since_s && change.drive == Drive::kBrake) return change.time_s - since_s;
    return NAN;
  }

  // Runs until the program runs, the actuator standing at its start and the host talking.
  void Start() {
    rig_->Run(0.05);
    rig_->KeepTalking(true);
    ZeroAndRun();
  }

  // The first ms in which the bridge drives.
  double FirstDrive() const {
    for (const RigSample& sample : rig_->Samples())
      if (sample.duty != 0) return sample.time_s - 1e-3;
    return NAN;
  }

  // The time from `since` on until the bridge no longer drives.
  double DriveTimeAfter(double since_s) const {
    double last = since_s;
    for (const RigSample& sample : rig_->Samples())
      if (sample.time_s > since_s && sample.duty != 0) last = sample.time_s;
    return last - since_s;
  }

  TemporaryFolder folder_;
  std::filesystem::path elf_;
};

}  // namespace lake
