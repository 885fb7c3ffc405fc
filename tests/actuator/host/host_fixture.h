// Tests of the firmware with its plant on this PC: a design's program, its stroke table, the rig.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "actuator/model_program.h"
#include "host_rig.h"
#include "lake/actuator/firmware.h"

namespace lake {

class HostFirmwareTest : public testing::Test {
 protected:
  // The retract end stop 2 mm below the program's start, unless the options have it.
  void Build(const linkage::Design& design, const actuator::ScheduleOptions& how = {}) {
    schedule_ = actuator::MakeSchedule(design, how);
    if (firmware_options_.home_stroke_mm == 0) firmware_options_.home_stroke_mm = schedule_.knots.front().stroke_mm - 2;
    if (!firmware_options_.speed_tolerance_percent) firmware_options_.speed_tolerance_percent = 10;
    stroke_table_ = actuator::MakeStrokeTable(schedule_, table_, firmware_options_);
    actuator_.stroke_mm = schedule_.knots.front().stroke_mm;
    actuator_.retract_stop_mm = firmware_options_.home_stroke_mm;
    actuator_.supply_v = firmware_options_.supply_v;
    if (!actuator_.table) actuator_.table = &table_;
    header_ = actuator::StrokeTableHeader(stroke_table_, schedule_, table_, firmware_options_, "test");
    rig_ = std::make_unique<HostRig>(header_, actuator_);
    rig_->Run(0.05);
    rig_->KeepTalking(true);
  }

  void WireAll() {
    actuator::FirmwareOptions& options = firmware_options_;
    options.feedback = actuator::Feedback::kPotentiometer;
    options.potentiometer = {0, 240, 1023, 380};
    options.supply_v = 12;
    options.current_sense = true;
    options.bridge_sense = true;
    options.pins.safety_relay = 5;
    options.speed_limit_mm_s = 6;
    options.force_limit_n = 400;
    options.force_n_per_a = 250;
    options.idle_a = 0.3;
  }

  // Planned stroke and drift as the firmware says them now.
  std::pair<double, double> SaidStrokeAndDrift() {
    double stroke = NAN, drift = NAN;
    const std::string status = rig_->Status();
    EXPECT_EQ(std::sscanf(status.c_str(), "<%*[a-z]|stroke:%lf|drift:%lf", &stroke, &drift), 2) << status;
    return {stroke, drift};
  }

  actuator::FirmwareOptions firmware_options_;
  actuator::DutyTable table_ = ModelTable();
  actuator::StrokeSchedule schedule_;
  actuator::StrokeTable stroke_table_;
  HostActuator actuator_;
  std::string header_;
  std::unique_ptr<HostRig> rig_;
};

}  // namespace lake
