// The firmware's portable part with any stroke table, compiled for this PC, with a model of bridge, motor, screw, end
// stops and potentiometer around it: thousands of times faster than simavr, for what takes long or has many cases.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "actuator/plant_model.h"
#include "controller.h"
#include "host_board.h"
#include "lake/actuator/firmware.h"
#include "serial.h"
#include "temporary_folder.h"

namespace lake {

// Every file of the firmware that knows nothing of the chip; a board's own, the tests' or another chip's, come beside.
inline constexpr const char* kPortableSources =
    "controller.c guard.c state.c kept.c divide.c program.c motor.c power.c end_stops.c protocol.c analog.c "
    "plant_*.c";

class HostRig {
 public:
  // Compiles the firmware with this stroke table, once per table. Throws if it does not without a warning.
  HostRig(actuator::Feedback feedback, const std::string& stroke_table, const lake::Actuator& actuator);
  HostRig(const HostRig&) = delete;
  HostRig& operator=(const HostRig&) = delete;
  ~HostRig();

  void PowerUp();  // as after a reset: the actuator stays where it is
  void Run(double seconds);
  bool RunUntil(const std::string& serial_text, double most_seconds);  // false if it was not said in time
  std::string Status();                                                // the answer to `?`

  void Send(const std::string& line);        // with its check sum
  void SendPlain(const std::string& bytes);  // as they are
  void SendNow(char c);
  void KeepTalking(bool on) { talking_ = on; }
  void PullWire(bool retract, bool pulled) { plant_.PullWire(retract, pulled); }
  void ReleaseButton(bool released) { plant_.is_button_released = released; }
  void Hang(bool on) { hangs_ = on; }  // the main loop

  double Time() const { return 1e-3 * static_cast<double>(now_ms_); }
  double Stroke() const { return plant_.Stroke(); }
  void SetStroke(double stroke_mm) { plant_.SetStroke(stroke_mm); }
  double Duty() const;  // of the bridge now, signed
  bool IsShorted() const { return board_->shorted != 0; }
  lake::Actuator& Actuator() { return plant_.actuator; }
  RigBreaks& Breaks() { return plant_.breaks; }
  host_board_t& Board() { return *board_; }
  const std::string& Serial() const { return serial_; }  // without the check sums, which were right
  const std::string& Wire() const { return wire_; }      // with them
  const std::vector<RigSample>& Samples() const { return samples_; }

 private:
  void OpenLibrary();
  void TickMs();
  void Receive(char c);
  void TakeSaid();
  void Sense();
  std::uint16_t Read(double volt);
  BridgeInputs Sent() const;  // by the firmware
  double MotorDuty() const;
  double Supply() const;  // part of the nominal voltage, at the bridge
  void SetLevels();

  TemporaryFolder folder_;
  void* library_ = nullptr;
  host_board_t* board_ = nullptr;
  void (*motor_init_)() = nullptr;
  void (*end_stops_init_)() = nullptr;
  void (*power_init_)() = nullptr;
  void (*analog_init_)() = nullptr;
  void (*controller_init_)() = nullptr;
  void (*board_interrupt_)() = nullptr;
  void (*controller_turn_)() = nullptr;
  void (*controller_remember_)() = nullptr;
  status_t (*controller_status_)() = nullptr;
  void (*protocol_turn_)() = nullptr;
  realtime_t (*serial_realtime_)(char) = nullptr;
  Plant plant_;
  std::mt19937 random_;
  bool talking_ = false, hangs_ = false;
  int hung_ms_ = 0;
  int relay_ms_ = 0;  // for which the contacts are as they will be
  bool is_relay_closed_ = false;
  std::int64_t now_ms_ = 0;
  std::deque<char> to_send_;
  std::string serial_, wire_;
  std::vector<RigSample> samples_;
};

}  // namespace lake
