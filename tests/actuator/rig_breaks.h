// What may break in a model of bridge, motor and sensors, whatever runs the firmware.
#pragma once

namespace lake {

// The end stops' wires are pulled by PullWire.
struct RigBreaks {
  enum class Wiper { kFine, kLost, kShorted, kFrozen };

  Wiper wiper = Wiper::kFine;  // lost: pulled down to 0 V; shorted: at 5 V
  bool supply_wire = false, current_wire = false;
  bool is_reversed = false;   // the motor
  bool is_blocked = false;    // the rod
  double runs_away_mm_s = 0;  // whatever the bridge does
};

}  // namespace lake
