// The firmware's portable part with any stroke table, compiled for this PC, with a model of bridge, motor, screw, end
// stops and potentiometer around it: thousands of times faster than simavr, for what takes long or has many cases.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "actuator/rig_breaks.h"
#include "controller.h"
#include "host_board.h"
#include "lake/actuator/duty_table.h"
#include "serial.h"
#include "temporary_folder.h"

namespace lake {

// Every file of the firmware that knows nothing of the chip; a board's own, the tests' or another chip's, come beside.
inline constexpr const char* kPortableSources =
    "controller.c guard.c state.c kept.c divide.c program.c calibration.c motor.c power.c end_stops.c protocol.c "
    "line.c "
    "analog.c plant_open.c plant_pot.c";

// Speed follows the table at duty times supply, less what the load costs, with a time constant while driven, 10 ms when
// shorted. Off it coasts: what the screw's friction takes of the speed, which is what keeps it still in the dead band
// of the duty table, 3.5 mm/s of the model's, over the time constant. The screw holds by itself; between motor and rod
// there is play.
struct HostActuator {
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
  double potentiometer_mm[2] = {0, 500};                          // strokes at 0 V and 5 V of A0
  double noise_counts = 0, spikes = 0;                            // SD of every reading, part of readings that are wild
  double supply_v = 12, supply_divider = 4.9;                     // on A2
  double idle_a = 0.3, a_per_n = 0.004, stall_a = 4;              // of the motor; an ACS712-05B on A1
  unsigned seed = 1;
};

struct HostSample {
  double time_s = 0, stroke_mm = 0;
  double duty = 0;  // signed, as the firmware drives
  bool brake = false;
  double planned_mm = 0;  // by the firmware, whose plan may wait
  double motor_duty = 0;  // as it arrives at the motor, with a supply
};

class HostRig {
 public:
  // Compiles the firmware with this stroke table, once per table. Throws if it does not without a warning.
  HostRig(const std::string& stroke_table, const HostActuator& actuator);
  HostRig(const HostRig&) = delete;
  HostRig& operator=(const HostRig&) = delete;
  ~HostRig();

  void PowerUp();  // as after a reset: the actuator stays where it is
  void Run(double seconds);
  bool RunUntil(const std::string& serial_text, double most_seconds);  // false if it was not said in time
  bool Asks(const std::string& line, const std::string& answer);       // whether it answers so within 0.2 s
  std::string Status();                                                // the answer to `?`

  void Send(const std::string& line);        // with its check sum
  void SendPlain(const std::string& bytes);  // as they are
  void SendNow(char c);
  void KeepTalking(bool on) { talking_ = on; }
  void PullWire(bool retract, bool pulled) { pulled_[retract ? 0 : 1] = pulled; }
  void ReleaseButton(bool released) { is_button_released_ = released; }
  void Hang(bool on) { hangs_ = on; }  // the main loop

  double Time() const { return 1e-3 * static_cast<double>(now_ms_); }
  double Stroke() const { return stroke_mm_; }
  void SetStroke(double stroke_mm);
  double Duty() const;  // of the bridge now, signed
  bool IsShorted() const { return board_->shorted != 0; }
  HostActuator& Actuator() { return actuator_; }
  RigBreaks& Breaks() { return breaks_; }
  host_board_t& Board() { return *board_; }
  const std::string& Serial() const { return serial_; }  // without the check sums, which were right
  const std::string& Wire() const { return wire_; }      // with them
  const std::vector<HostSample>& Samples() const { return samples_; }

 private:
  void OpenLibrary();
  void TickMs();
  void Receive(char c);
  void TakeSaid();
  void Move();
  void Sense();
  std::uint16_t Read(double volt);
  double Current() const;
  BridgeInputs Sent() const;  // by the firmware
  double MotorDuty() const;
  double Supply() const;  // part of the nominal voltage, at the bridge
  void SetLevels();
  double Load() const;

  TemporaryFolder folder_;
  void* library_ = nullptr;
  host_board_t* board_ = nullptr;
  void (*motor_init_)() = nullptr;
  void (*end_stops_init_)() = nullptr;
  void (*power_init_)() = nullptr;
  void (*analog_init_)() = nullptr;
  void (*controller_init_)() = nullptr;
  void (*guard_interrupt_)() = nullptr;
  void (*controller_turn_)() = nullptr;
  void (*controller_remember_)() = nullptr;
  status_t (*controller_status_)() = nullptr;
  void (*protocol_turn_)() = nullptr;
  realtime_t (*protocol_realtime_)(char) = nullptr;
  HostActuator actuator_;
  RigBreaks breaks_;
  double target_mm_s_ = 0, free_mm_s_ = 0, frozen_v_ = 0;
  std::mt19937 random_;
  double speed_mm_s_ = 0, motor_mm_ = 0, stroke_mm_ = 0;
  bool pulled_[2] = {false, false};
  bool talking_ = false, hangs_ = false, is_button_released_ = false;
  int hung_ms_ = 0;
  int relay_ms_ = 0;  // for which the contacts are as they will be
  bool is_relay_closed_ = false;
  std::int64_t now_ms_ = 0;
  std::deque<char> to_send_;
  std::string serial_, wire_;
  std::vector<HostSample> samples_;
};

}  // namespace lake
