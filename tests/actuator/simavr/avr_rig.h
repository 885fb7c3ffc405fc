// The firmware in simavr, with the converter and the receiver of the data sheet, and a bridge, a motor with its screw,
// two end stops and a serial line around it.
#pragma once

#include <simavr/sim_avr.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "actuator/plant_model.h"
#include "datasheet_peripherals.h"

namespace lake {

// What the bridge does to the motor.
enum class Drive { kOff, kExtend, kRetract, kBrake };

inline Drive DriveOf(const BridgeInputs& inputs) {
  return inputs.in1 == inputs.in2 ? Drive::kBrake : inputs.in1 ? Drive::kExtend : Drive::kRetract;
}

// A change of IN1 and IN2.
struct DriveChange {
  double time_s = 0;
  Drive drive = Drive::kOff;  // from then on; kOff never
  double enable = 0;          // of ENA at that moment
};

class AvrRig {
 public:
  AvrRig(const std::filesystem::path& elf, const lake::Actuator& actuator);
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

  lake::Actuator& Actuator() { return plant_.actuator; }
  RigBreaks& Breaks() { return plant_.breaks; }
  double Time() const;
  double Stroke() const { return plant_.Stroke(); }
  void SetStroke(double stroke_mm) { plant_.SetStroke(stroke_mm); }
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
  bool HasSupply() const { return !plant_.actuator.has_relay || IsRelayClosed(); }
  bool IsPwm() const;  // whether the timer drives ENA
  void SetBridgePins(bool is_high);
  void CountOnTime();
  void EndMillisecond();
  void SetEndStopPins();

  avr_t* avr_ = nullptr;
  Plant plant_;
  BridgeInputs inputs_;
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
