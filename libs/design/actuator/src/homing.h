// How the actuator gets from the retract end stop to the program's start, how far it may be from its plan, and what is
// wired to the board. Not part of the interface.
#pragma once

#include <cmath>
#include <cstdint>

#include "lake/actuator/firmware.h"

namespace lake::actuator {

inline constexpr double kMostStroke_mm = 2000;  // in nm within 32 bits

inline std::int64_t Um(double mm) {
  return std::llround(mm * 1e3);
}

// PWM counts for a speed, within what the table has.
int CountsFor(const DutyTable& table, double speed_mm_s);

// Where the program starts, how the actuator gets there from the retract end stop.
struct Homing {
  double stroke_mm = 0, speed_mm_s = 0, position_speed_mm_s = 0;
  int counts = 0, position_counts = 0;
  std::int64_t timeout_ms = 0, back_off_ms = 0, touch_timeout_ms = 0;
  // From where the end stop was seen to release, one of them 0: on to the start, or back to it.
  std::int64_t position_ms = 0, return_ms = 0;
  // Off a pressed end stop while it is not known which way the motor turns: the way, the speeds.
  double check_mm = 0, extend_creep_mm_s = 0, retract_creep_mm_s = 0;
  double guard_mm = 0;  // below it the end stop has not come: by the potentiometer
};

Homing HomingOf(const Sketch& sketch);

// The bound as the firmware has it: integers, ms by ms.
class DriftBound {
 public:
  DriftBound() = default;
  explicit DriftBound(const Sketch& sketch, std::int64_t velocity_um_s = 0)
      : start_um_(std::llround(std::ceil(1e3 * (sketch.options.home_error_mm + sketch.stroke.pwm_error_mm)))),
        per_1024_(std::llround(std::ceil(10.24 * sketch.TolerancePercent()))),
        lag_ms_(std::llround(std::ceil(1e3 * sketch.options.lag_s))),
        velocity_um_s_(velocity_um_s) {}

  std::int64_t StartUm() const { return start_um_; }
  std::int64_t Per1024() const { return per_1024_; }
  std::int64_t LagMs() const { return lag_ms_; }

  void Turn(std::int64_t velocity_um_s) {
    const std::int64_t change = velocity_um_s - velocity_um_s_;
    velocity_um_s_ = velocity_um_s;
    (change < 0 ? slowing_nm_ : speeding_nm_) += std::abs(change) * lag_ms_;
  }
  void Go(std::int64_t ms) {
    way_nm_ += std::abs(velocity_um_s_) * ms;
    rounding_nm_ += velocity_um_s_ == 0 ? 0 : ms;
    tolerance_nm_ += ms * ((std::abs(velocity_um_s_) * per_1024_ + 1023) / 1024);
  }

  double Drift() const { return 1e-6 * static_cast<double>(FixedNm() + tolerance_nm_); }
  // The largest per_1024_ that stays below a room.
  double TolerablePer1024(double room_mm) const {
    const double left_nm = 1e6 * room_mm - static_cast<double>(FixedNm() + rounding_nm_);
    return way_nm_ > 0 ? std::floor(1024 * left_nm / static_cast<double>(way_nm_)) : left_nm > 0 ? 1024 : -1;
  }

 private:
  std::int64_t FixedNm() const { return 1000 * start_um_ + std::max(speeding_nm_, slowing_nm_); }

  std::int64_t start_um_ = 0, per_1024_ = 0, lag_ms_ = 0, velocity_um_s_ = 0;
  std::int64_t way_nm_ = 0, rounding_nm_ = 0, tolerance_nm_ = 0, speeding_nm_ = 0, slowing_nm_ = 0;
};

// Throws Error, with ways out, where homing or the drift may carry the actuator past the linkage's ends.
void RequireRoomForDrift(const Sketch& sketch, const Homing& homing);

// What may be wired to a pin of the board: its LAKE_PIN_… in stroke_table.h (none: the pin is always the same), its
// name in messages, and on the schematic what stands in the wire, what pulls it down, where it goes.
struct Connection {
  const char *define, *name;
  int pin;
  bool is_wired;
  const char *in_line, *pull_down, *to;
};
std::vector<Connection> ConnectionsOf(const FirmwareOptions& options);

// As it is printed on the board.
std::string PinName(int pin);

}  // namespace lake::actuator
