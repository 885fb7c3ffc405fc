// A design's program with its firmware's options, whatever runs the firmware.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "actuator/model_program.h"
#include "lake/actuator/firmware.h"

namespace lake {

// As the potentiometer of the rigs.
inline void WirePotentiometer(actuator::FirmwareOptions& options) {
  options.feedback = actuator::Feedback::kPotentiometer;
  options.potentiometer = {0, 240, 1023, 380};
}

// Potentiometer, sense of the supply and of the current.
inline void WireSensors(actuator::FirmwareOptions& options) {
  WirePotentiometer(options);
  options.supply_v = 12, options.current_sense = true;
}

// All but the button.
inline void WireAll(actuator::FirmwareOptions& options) {
  WireSensors(options);
  options.bridge_sense = true, options.pins.safety_relay = 5, options.speed_limit_mm_s = 6;
  options.force_limit_n = 400, options.force_n_per_a = 250, options.idle_a = 0.3;
}

class ProgramFixture : public testing::Test {
 protected:
  // The retract end stop so far below the program's start, unless the options have it.
  void MakeProgram(const linkage::Design& design, const actuator::ScheduleOptions& how) {
    schedule_ = actuator::MakeSchedule(design, how);
    if (firmware_options_.home_stroke_mm == 0)
      firmware_options_.home_stroke_mm = schedule_.knots.front().stroke_mm - home_below_start_mm_;
    if (!firmware_options_.speed_tolerance_percent) firmware_options_.speed_tolerance_percent = 10;
    header_ = actuator::StrokeTableHeader(Sketch(), "test");
  }
  actuator::Sketch Sketch() const { return {schedule_, table_, firmware_options_}; }
  // By which the plan may be off for the PWM's steps.
  double PwmError() const { return Sketch().stroke.pwm_error_mm; }

  double home_below_start_mm_ = 2;
  actuator::FirmwareOptions firmware_options_;
  actuator::DutyTable table_ = ModelTable();
  actuator::StrokeSchedule schedule_;
  std::string header_;
};

}  // namespace lake
