// Bridge, motor with its screw, end stops and sensors, whatever runs the firmware; and what may break of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "lake/actuator/duty_table.h"

namespace lake {

enum class Wire { kWhole, kOpen, kGround, kFive };

// An L298N's inputs: levels, ENA as the part of the time for which it is high.
struct BridgeInputs {
  double enable = 0;
  bool in1 = false, in2 = false;

  // Of the motor: signed part of the supply; 0 also where both outputs are alike.
  double Duty() const { return in1 == in2 ? 0 : in1 ? enable : -enable; }
  bool IsBrake() const { return in1 == in2 && enable > 0.5; }
  bool OutputsAreLow() const { return enable == 0 || (!in1 && !in2); }
  bool operator==(const BridgeInputs&) const = default;
};

// The end stops' wires are pulled by PullWire.
struct RigBreaks {
  enum class Wiper { kFine, kLost, kShorted, kFrozen };

  Wiper wiper = Wiper::kFine;  // lost: pulled down to 0 V; shorted: at 5 V
  bool supply_wire = false, current_wire = false;
  bool is_reversed = false;                                         // the motor
  bool is_blocked = false;                                          // the rod
  double runs_away_mm_s = 0;                                        // whatever the bridge does
  Wire ena = Wire::kWhole, in1 = Wire::kWhole, in2 = Wire::kWhole;  // from the UNO to the bridge
  int shorted = 0;  // transistors: 1 drives with all of the supply to extend, -1 to retract, while there is a supply
  bool drives_by_inputs = false;  // as if ENA were high inside the bridge, where no pin of the UNO sees it
  bool is_relay_welded = false, is_motor_unplugged = false;
  double current_offset_v = 0;

  // As they arrive at the bridge: its inputs float to high where they are open, and 10 kOhm pull ENA down.
  BridgeInputs Arriving(BridgeInputs sent) const {
    if (ena != Wire::kWhole) sent.enable = ena == Wire::kFive ? 1 : 0;
    if (drives_by_inputs) sent.enable = 1;
    if (in1 != Wire::kWhole) sent.in1 = in1 != Wire::kGround;
    if (in2 != Wire::kWhole) sent.in2 = in2 != Wire::kGround;
    return sent;
  }
  // Whether outputs that are read back are other than a bridge's that drives: in the PWM's high part the driven one
  // high and the other low, in its low part, where the motor's current still flows, the driven one low.
  bool Contradict(const BridgeInputs& sent, bool has_supply) const {
    const BridgeInputs at = Arriving(sent);
    const bool is_on = has_supply && shorted == 0 && at.enable > 0;
    const bool out1 = has_supply && (shorted > 0 || (is_on && at.in1));
    const bool out2 = has_supply && (shorted < 0 || (is_on && at.in2));
    const bool driven = sent.in1 ? out1 : out2, other = sent.in1 ? out2 : out1;
    const bool low_part = has_supply && sent.enable < 1 && (shorted != 0 || ena == Wire::kFive) && driven;
    return !driven || other || low_part;
  }
  // Of the outputs, read back while ENA is as it is.
  bool OutputsAreLow(const BridgeInputs& sent) const { return shorted == 0 && Arriving(sent).OutputsAreLow(); }
};

// Speed follows the table at duty times supply, less what the load costs, with a time constant while driven, 10 ms when
// shorted. Off it coasts: what the screw's friction takes of the speed, which is what keeps it still in the dead band
// of the duty table, 3.5 mm/s of the model's, over the time constant. The screw holds by itself; between motor and rod
// there is play.
struct Actuator {
  const actuator::DutyTable* table = nullptr;
  double speed_factor = 1;
  double stroke_mm = 0;
  double retract_stop_mm = 0, extend_stop_mm = 1000;  // where the switches act
  double time_constant_s = 0.03;
  double coast_mm_s2 = 100;  // 3.5 mm/s in 0.03 s, rounded down
  bool has_relay = false;    // before the supply's sense; 15 ms to close, 10 to open
  double play_mm = 0;
  double mm_s_per_n = 0;                                          // of the force–speed line
  std::function<double(double time_s)> supply;                    // part of the nominal voltage; none: 1
  std::function<double(double time_s, double stroke_mm)> load_n;  // against extension; none: 0
  double potentiometer_mm[2] = {240, 380};                        // strokes at 0 V and 5 V of A0
  double noise_counts = 0, spikes = 0;                            // SD of every reading, part of readings that are wild
  double supply_v = 12, supply_divider = 4.9;                     // on A2
  double idle_a = 0.3, a_per_n = 0.004, stall_a = 4;              // of the motor; an ACS712-05B on A1
  unsigned seed = 1;
};

// One ms.
struct RigSample {
  double time_s = 0, stroke_mm = 0;
  double duty = 0;  // signed, as the firmware drives
  bool brake = false;
  double planned_mm = 0;  // by the firmware, whose plan may wait
  double motor_duty = 0;  // as it arrives at the motor, with a supply
};

class Plant {
 public:
  explicit Plant(Actuator model) : actuator(std::move(model)) { SetStroke(actuator.stroke_mm); }

  Actuator actuator;
  RigBreaks breaks;
  bool is_button_released = false;

  double Stroke() const { return stroke_mm_; }
  void SetStroke(double stroke_mm) {
    motor_mm_ = stroke_mm_ = stroke_mm;
    speed_mm_s_ = 0;
  }
  // Parts of the nominal voltage, before a relay.
  double Supply(double time_s) const { return actuator.supply ? actuator.supply(time_s) : 1; }
  void PullWire(bool retract, bool pulled) { pulled_[retract ? 0 : 1] = pulled; }
  bool IsPressed(bool retract) const {
    return retract ? pulled_[0] || stroke_mm_ <= actuator.retract_stop_mm
                   : pulled_[1] || stroke_mm_ >= actuator.extend_stop_mm;
  }

  // A ms at a duty between -1 and 1 of the supply.
  void Move(double time_s, double duty, bool is_brake, double supply) {
    duty_ = duty, supply_ = supply;
    load_n_ = actuator.load_n ? actuator.load_n(time_s, stroke_mm_) : 0;
    const double turned = breaks.is_reversed ? -duty : duty;
    free_mm_s_ = actuator.speed_factor * FreeSpeed(turned);
    target_mm_s_ = LoadedSpeed(turned);
    if (duty == 0 && !is_brake)
      speed_mm_s_ = std::copysign(std::max(0.0, std::abs(speed_mm_s_) - actuator.coast_mm_s2 * 1e-3), speed_mm_s_);
    else
      speed_mm_s_ +=
          (target_mm_s_ - speed_mm_s_) * (1 - std::exp(-1e-3 / (is_brake ? 0.01 : actuator.time_constant_s)));
    if (breaks.is_blocked) speed_mm_s_ = 0;
    motor_mm_ += (speed_mm_s_ + breaks.runs_away_mm_s) * 1e-3;
    stroke_mm_ = std::clamp(stroke_mm_, motor_mm_ - actuator.play_mm / 2, motor_mm_ + actuator.play_mm / 2);
  }

  // At A0, A1 and A2, V, after that ms.
  double Volt(int channel) {
    if (channel == 1) return breaks.current_wire ? 0 : 2.5 + breaks.current_offset_v + 0.185 * Current();
    if (channel == 2) return breaks.supply_wire ? 0 : supply_ * actuator.supply_v / actuator.supply_divider;
    const auto [at_0, at_5] = actuator.potentiometer_mm;
    if (breaks.wiper != RigBreaks::Wiper::kFrozen) wiper_v_ = 5 * (stroke_mm_ - at_0) / (at_5 - at_0);
    return breaks.wiper == RigBreaks::Wiper::kLost ? 0 : breaks.wiper == RigBreaks::Wiper::kShorted ? 5 : wiper_v_;
  }

 private:
  // Without a load, mm/s: as the table has it at duty times supply; beyond its end speed grows with the voltage.
  double FreeSpeed(double duty) const {
    if (duty == 0) return 0;
    const double driven = std::abs(duty) * supply_;
    return std::max(1.0, driven) * actuator.table->Curve(duty > 0 ? 1 : -1).SpeedFor(std::min(1.0, driven));
  }

  // Signed. A screw that holds by itself has an efficiency below one half: what helps it gives back less than half.
  double LoadedSpeed(double duty) const {
    if (duty == 0) return 0;
    const double direction = duty > 0 ? 1 : -1, against_n = direction * load_n_;
    return direction * std::max(0.0, free_mm_s_ - (against_n < 0 ? 0.4 : 1) * against_n * actuator.mm_s_per_n);
  }

  // Friction, load, and the torque that still accelerates it; no more than a motor takes at standstill with that
  // voltage, but where the friction alone takes more, which stands for a short.
  double Current() const {
    if (duty_ == 0) return 0;
    const double lacks = free_mm_s_ > 0 ? (std::abs(target_mm_s_) - std::abs(speed_mm_s_)) / free_mm_s_ : 1;
    const double load_n = std::max(0.0, (duty_ > 0 ? 1 : -1) * load_n_);
    const double torque_a =
        actuator.idle_a + actuator.a_per_n * load_n + actuator.stall_a * std::abs(duty_) * std::max(0.0, lacks);
    const double most_a = std::max(actuator.idle_a, actuator.stall_a * std::abs(duty_) * supply_);
    return std::copysign(std::min(torque_a, most_a), duty_);
  }

  bool pulled_[2] = {false, false};
  double speed_mm_s_ = 0, motor_mm_ = 0, stroke_mm_ = 0, wiper_v_ = 0;
  double duty_ = 0, supply_ = 0, load_n_ = 0, free_mm_s_ = 0, target_mm_s_ = 0;
};

}  // namespace lake
