// A design's program with its firmware's options, and the rig that runs the firmware.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "actuator/model_program.h"
#include "actuator/plant_model.h"
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

template <typename Rig>
class RigTest : public testing::Test {
 protected:
  // The retract end stop so far below the program's start, unless the options have it; the actuator at the start.
  void MakeProgram(const linkage::Design& design, const actuator::ScheduleOptions& how) {
    schedule_ = actuator::MakeSchedule(design, how);
    if (firmware_options_.home_stroke_mm == 0)
      firmware_options_.home_stroke_mm = schedule_.knots.front().stroke_mm - home_below_start_mm_;
    if (!firmware_options_.speed_tolerance_percent) firmware_options_.speed_tolerance_percent = 10;
    header_ = actuator::StrokeTableHeader(Sketch(), "test");
    actuator_.stroke_mm = schedule_.knots.front().stroke_mm;
    actuator_.retract_stop_mm = firmware_options_.home_stroke_mm;
    if (!actuator_.table) actuator_.table = &table_;
  }
  actuator::Sketch Sketch() const { return {schedule_, table_, firmware_options_}; }
  // By which the plan may be off for the PWM's steps.
  double PwmError() const { return Sketch().stroke.pwm_error_mm; }

  // Whether the answer to a line comes within 0.2 s.
  bool Asks(const std::string& line, const std::string& answer) {
    rig_->Send(line);
    return rig_->RunUntil(answer + "\n", 0.2);
  }
  void ZeroAndRun() {
    for (const char* line : {"zero", "run"}) ASSERT_TRUE(Asks(line, "ok")) << rig_->Serial();
  }
  void Home(double most_s) { DoToEnd("home", most_s); }
  void RunToEnd(double most_s) { DoToEnd("run", most_s); }
  void DoToEnd(const char* line, double most_s) {
    ASSERT_TRUE(Asks(line, "ok")) << rig_->Serial();
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", most_s)) << rig_->Serial();
  }

  double home_below_start_mm_ = 2;
  actuator::FirmwareOptions firmware_options_;
  actuator::DutyTable table_ = ModelTable();
  actuator::StrokeSchedule schedule_;
  std::string header_;
  Actuator actuator_;
  std::unique_ptr<Rig> rig_;
};

}  // namespace lake
