// Tests of the firmware with its plant on this PC: a design's program, its stroke table, the rig.
#pragma once

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include "actuator/program_fixture.h"
#include "host_rig.h"

namespace lake {

using Act = std::function<void(HostRig&)>;

// Breaks that part of the rig so.
template <typename Part>
Act Breaks(Part RigBreaks::*which, Part how) {
  return [=](HostRig& rig) { rig.Breaks().*which = how; };
}

// The wires of the end stops off.
inline Act PullsWires(bool retract, bool extend) {
  return [=](HostRig& rig) {
    if (retract) rig.PullWire(true, true);
    if (extend) rig.PullWire(false, true);
  };
}

class HostFirmwareTest : public RigTest<HostRig> {
 protected:
  void Build(const linkage::Design& design, const actuator::ScheduleOptions& how = {}) {
    MakeProgram(design, how);
    actuator_.supply_v = firmware_options_.supply_v;
    rig_ = std::make_unique<HostRig>(firmware_options_.feedback, header_, actuator_);
    rig_->Run(0.05);
    rig_->KeepTalking(true);
  }

  // Planned stroke and drift as the firmware says them now.
  std::pair<double, double> SaidStrokeAndDrift() {
    double stroke = NAN, drift = NAN;
    const std::string status = rig_->Status();
    EXPECT_EQ(std::sscanf(status.c_str(), "<%*[a-z]|stroke:%lf|drift:%lf", &stroke, &drift), 2) << status;
    return {stroke, drift};
  }
};

}  // namespace lake
