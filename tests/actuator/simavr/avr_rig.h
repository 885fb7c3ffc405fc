// The firmware in simavr, with the converter and the receiver of the data sheet, and a bridge, a motor with its screw,
// two end stops and a serial line around it.
#pragma once

#include <simavr/sim_avr.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "actuator/rig_breaks.h"
#include "datasheet_peripherals.h"
#include "lake/actuator/duty_table.h"

namespace lake {

// What the bridge does to the motor.
enum class Drive { kOff, kExtend, kRetract, kBrake };

inline Drive DriveOf(const BridgeInputs& inputs) {
  return inputs.in1 == inputs.in2 ? Drive::kBrake : inputs.in1 ? Drive::kExtend : Drive::kRetract;
}

// One ms of the simulation.
struct RigSample {
  double time_s = 0, stroke_mm = 0, speed_mm_s = 0;
  double duty = 0;  // signed mean over the ms
  bool brake = false;
};

// A change of IN1 and IN2.
struct DriveChange {
  double time_s = 0;
  Drive drive = Drive::kOff;  // from then on; kOff never
  double enable = 0;          // of ENA at that moment
};

// Speed follows the table, times a factor, with a time constant while driven, 10 ms when shorted; off it coasts, as in
// HostActuator.
struct ActuatorModel {
  const actuator::DutyTable* table = nullptr;
  double speed_factor = 1;
  double stroke_mm = 0;
  double retract_stop_mm = 0, extend_stop_mm = 1000;  // where the switches act
  double time_constant_s = 0.03;
  double coast_mm_s2 = 100;
  double supply_v = 12;
  bool has_relay = false;                 // in the supply, before its sense
  double potentiometer_mm[2] = {0, 500};  // strokes at 0 V and 5 V of A0
  double noise_counts = 0;                // SD of each conversion, of every channel
  double play_mm = 0;                     // between motor and rod
  double supply = 1, load_n = 0;          // part of the nominal voltage; against extension, …
  double mm_s_per_n = 0;                  // … of the force-speed line
  unsigned seed = 1;
};

struct AvrBreaks : RigBreaks {
  double motor_a = 0.5;  // while it is driven
};

class AvrRig {
 public:
  AvrRig(const std::filesystem::path& elf, const ActuatorModel& actuator);
  AvrRig(const AvrRig&) = delete;
  AvrRig& operator=(const AvrRig&) = delete;
  ~AvrRig();

  void Run(double seconds);
  bool RunUntil(const std::string& serial_text, double most_seconds);  // false if it was not said in time

  void Send(const std::string& line);           // with its check sum
  void SendPlain(const std::string& bytes);     // as they are
  void SendNow(char c);                         // ahead of what waits, as a real-time command
  void KeepTalking(bool on) { talking_ = on; }  // a sign of life every half second, as a host does
  void PullWire(bool retract, bool pulled);     // an end stop's wire off: reads as pressed
  void ReleaseButton(bool released);            // D4, held otherwise

  AvrBreaks& Breaks() { return breaks_; }
  double Time() const;
  double Stroke() const { return actuator_.stroke_mm; }
  void SetStroke(double stroke_mm) { actuator_.stroke_mm = motor_mm_ = stroke_mm; }
  bool IsRelayClosed() const;  // its pin, D5
  void FlipBit(int address, int bit) { avr_->data[address] ^= static_cast<std::uint8_t>(1 << bit); }
  bool HasEnded() const;                                 // `quit`
  const std::string& Serial() const { return serial_; }  // whole lines, without their check sums
  const std::vector<RigSample>& Samples() const { return samples_; }
  const std::vector<DriveChange>& Changes() const { return changes_; }
  DatasheetAdc& Adc() { return *adc_; }
  const DatasheetReceiver& Receiver() const { return *receiver_; }
  // From the timer's interrupt on until the processor sleeps again, with all interrupts.
  double LongestTurn_us() const { return static_cast<double>(longest_turn_) / 16; }
  std::uint64_t Ticks() const { return ticks_; }
  // For which interrupts were blocked, since the firmware first allowed them.
  double LongestBlocked_us() const { return static_cast<double>(longest_blocked_) / 16; }
  int DeepestStack() const { return deepest_stack_; }  // bytes, interrupts included

 private:
  static void OnSerial(avr_irq_t* irq, uint32_t value, void* rig);
  BridgeInputs ReadInputs() const;
  bool HasSupply() const { return !actuator_.has_relay || IsRelayClosed(); }
  bool IsPwm() const;  // whether the timer drives ENA
  void SetBridgePins(bool is_high);
  void CountOnTime();
  void EndMillisecond();
  void SetEndStopPins();
  void Sense(double duty);

  avr_t* avr_ = nullptr;
  ActuatorModel actuator_;
  AvrBreaks breaks_;
  double speed_mm_s_ = 0, motor_mm_ = 0, wiper_ = 0;
  BridgeInputs inputs_;
  bool pulled_[2] = {false, false}, is_button_released_ = false;
  std::uint64_t counted_to_ = 0;
  double on_cycles_[4] = {};  // by Drive, in this ms
  std::string serial_, line_;
  std::unique_ptr<DatasheetAdc> adc_;
  std::unique_ptr<DatasheetReceiver> receiver_;
  std::unique_ptr<DatasheetPwm> pwm_;
  bool talking_ = false;
  static void OnTick(avr_irq_t* irq, uint32_t runs, void* rig);
  void WatchInterrupts(std::uint64_t before);
  void WatchSleep();
  std::uint64_t turn_began_ = 0, longest_turn_ = 0, ticks_ = 0;
  std::uint64_t blocked_since_ = 0, longest_blocked_ = 0;
  bool has_allowed_interrupts_ = false;
  int deepest_stack_ = 0;
  std::vector<RigSample> samples_;
  std::vector<DriveChange> changes_;
};

}  // namespace lake
