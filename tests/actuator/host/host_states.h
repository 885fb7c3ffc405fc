// The states in which what breaks is tried.
#pragma once

#include <string>
#include <vector>

#include "host_fixture.h"

namespace lake {

inline constexpr const char* kAtLimit = "running, at the upper limit";

// Those of RISKS.md.
inline const std::vector<std::string>& States() {
  static const std::vector<std::string> states = {"idle, stroke unknown",
                                                  "idle, at the start",
                                                  "homing, seeking",
                                                  "homing, backing off",
                                                  "homing, coming again",
                                                  "positioning",
                                                  "running, extending",
                                                  "running, resting",
                                                  "running, retracting",
                                                  kAtLimit,
                                                  "hold",
                                                  "jogging, extending",
                                                  "jogging, retracting"};
  return states;
}

class HostStatesTest : public HostFirmwareTest {
 protected:
  // Until it says that state, driving that way.
  void Until(const char* state, int sign) {
    for (int ms = 0; ms < 40'000; ++ms) {
      rig_->Run(1e-3);
      const double duty = rig_->Duty();
      if ((sign == 0 || duty * sign > 0) && rig_->Status().find(state) != std::string::npos) return;
    }
    FAIL() << "never " << state << "\n" << rig_->Serial();
  }

  void Begin(const char* command) {
    ASSERT_TRUE(Asks("zero", "ok"));
    if (*command == 0) return;
    ASSERT_TRUE(Asks(command, "ok")) << rig_->Serial();
  }

  void Reach(const std::string& state) {
    const bool at_limit = state == kAtLimit;
    firmware_options_.home_stroke_mm = at_limit ? 366 : 299;
    Build(at_limit ? FreeDesign({{0, 368}, {1.5, 372.5}, {2, 372.5}, {3.5, 368.5}})
                   : FreeDesign({{0, 303}, {1, 307}, {1.5, 307}, {2.9, 303.5}}));
    if (state.find("homing") != std::string::npos || state.find("jogging") != std::string::npos)
      rig_->SetStroke(schedule_.knots.front().stroke_mm + 2);
    rig_->PowerUp();
    rig_->Run(0.6);  // the relay has been seen open
    const auto home = [&](int legs) {
      rig_->Send("home");
      for (int leg = 0; leg < legs; ++leg) Until("<homing", leg % 2 == 0 ? -1 : 1);
    };
    if (state == "idle, at the start") Begin("");
    if (state == "homing, seeking") home(1);
    if (state == "homing, backing off") home(2);
    if (state == "homing, coming again") home(3);
    if (state == "homing, backing off once more") home(4);
    if (state == "positioning") rig_->Send("home"), Until("<positioning", 1);
    if (state == "running, extending" || state == "hold") Begin("run"), Until("<running", 1), rig_->Run(0.4);
    if (state == "running, resting") Begin("run"), Until("<running", 1), rig_->Run(1.3);
    if (state == "running, retracting") Begin("run"), Until("<running", -1), rig_->Run(0.2);
    if (state == "hold") rig_->SendNow('!'), rig_->Run(0.3);
    if (at_limit) {
      Begin("run"), Until("<running", 1);
      while (rig_->Stroke() < 372) rig_->Run(1e-3);
    }
    if (state == "jogging, extending") rig_->Send("jog 500 6000"), Until("<jogging", 1), rig_->Run(0.3);
    if (state == "jogging, retracting") rig_->Send("jog -400 6000"), Until("<jogging", -1), rig_->Run(0.3);
    ASSERT_THAT(rig_->Serial(), testing::Not(testing::HasSubstr("ALARM"))) << state;
  }
};

}  // namespace lake
