// What may break in a model of bridge, motor and sensors, whatever runs the firmware; and the bridge's own logic.
#pragma once

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

}  // namespace lake
