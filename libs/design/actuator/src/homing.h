// How the actuator gets from the retract end stop to the program's start, and how far it may be from its plan. Not part
// of the interface.
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
  double stroke_mm, speed_mm_s, position_speed_mm_s;
  int counts, position_counts;
  std::int64_t timeout_ms, back_off_ms, touch_timeout_ms;
  // From where the end stop was seen to release, one of them 0: on to the start, or back to it.
  std::int64_t position_ms = 0, return_ms = 0;
  // Off a pressed end stop while it is not known which way the motor turns: the way, the speeds.
  double check_mm, extend_creep_mm_s, retract_creep_mm_s;
  double guard_mm;  // below it the end stop has not come: by the potentiometer
};

Homing HomingOf(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                const FirmwareOptions& options);

// How far speeds may differ from the table, percent.
double ToleranceOf(const DutyTable& table, const FirmwareOptions& options);

// The bound as the firmware has it: integers, ms by ms.
class DriftBound {
 public:
  DriftBound(const StrokeTable& stroke, const DutyTable& table, const FirmwareOptions& options,
             std::int64_t velocity_um_s = 0)
      : start_um_(std::llround(std::ceil(1e3 * (options.home_error_mm + stroke.pwm_error_mm)))),
        per_1024_(std::llround(std::ceil(10.24 * ToleranceOf(table, options)))),
        lag_ms_(std::llround(std::ceil(1e3 * options.lag_s))),
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

  std::int64_t start_um_, per_1024_, lag_ms_;
  std::int64_t velocity_um_s_;
  std::int64_t way_nm_ = 0, rounding_nm_ = 0, tolerance_nm_ = 0, speeding_nm_ = 0, slowing_nm_ = 0;
};

// Throws Error, with ways out, where homing or the drift may carry the actuator past the linkage's ends.
void RequireRoomForDrift(const Homing& homing, const StrokeTable& stroke, const StrokeSchedule& schedule,
                         const DutyTable& table, const FirmwareOptions& options);

}  // namespace lake::actuator
