// Three peripherals of the ATmega328P as its data sheet has them, in place of simavr's. simavr reads the channel when
// the result is read, its receiver holds 64 bytes, and the PWM's compare event stays where it was when the timer was
// started: firmware that runs there may fail on the chip.
#pragma once

#include <simavr/sim_avr.h>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <random>

namespace lake {

// The converter (data sheet, chapter 24). A conversion begins at the next edge of the converter's clock; then the
// channel is fixed. The voltage is taken 1.5 clocks later (13.5 in the first conversion), the result is there after 13
// (25). Once ADCL has been read a result waits for ADCH.
class DatasheetAdc {
 public:
  explicit DatasheetAdc(avr_t* avr);
  DatasheetAdc(const DatasheetAdc&) = delete;
  DatasheetAdc& operator=(const DatasheetAdc&) = delete;

  void SetMillivolt(int channel, double millivolt) { millivolt_.at(static_cast<std::size_t>(channel)) = millivolt; }

  void SetNoise(double counts, unsigned seed) {  // SD of each conversion
    noise_counts_ = counts;
    random_.seed(seed);
  }

  void StandStill() { stands_still_ = true; }  // a conversion that begins does not end any more

  std::uint64_t Conversions() const { return conversions_; }
  std::uint64_t StartsWhileBusy() const { return starts_while_busy_; }           // which have no effect
  std::uint64_t ChannelChangesWhileBusy() const { return changes_while_busy_; }  // which have one only afterwards

 private:
  enum class Stage { kBegin, kSample, kDone };
  static avr_cycle_count_t OnTime(avr_t* avr, avr_cycle_count_t when, void* self);
  static void WriteControl(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void* self);
  static void WriteChannel(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void* self);
  static std::uint8_t ReadLow(avr_t* avr, avr_io_addr_t address, void* self);
  static std::uint8_t ReadHigh(avr_t* avr, avr_io_addr_t address, void* self);
  avr_cycle_count_t Clock() const;  // of the converter, in cycles
  bool IsBusy() const;
  void Start();
  avr_cycle_count_t Advance(avr_cycle_count_t when);

  avr_t* avr_;
  avr_int_vector_t* vector_;
  std::array<double, 8> millivolt_{};
  double noise_counts_ = 0;
  std::mt19937 random_;
  std::normal_distribution<double> normal_{0, 1};
  avr_cycle_count_t enabled_at_ = 0;
  Stage stage_ = Stage::kDone;
  bool is_first_ = false, is_locked_ = false, stands_still_ = false;
  int channel_ = 0;
  std::uint16_t sampled_ = 0;
  std::uint64_t conversions_ = 0, starts_while_busy_ = 0, changes_while_busy_ = 0;
};

// The receiver (data sheet, chapter 20): bytes come back to back at 115200 baud; two wait in the buffer, one more in
// the shift register until the next start bit, which drops it and sets DOR0.
class DatasheetReceiver {
 public:
  explicit DatasheetReceiver(avr_t* avr);
  DatasheetReceiver(const DatasheetReceiver&) = delete;
  DatasheetReceiver& operator=(const DatasheetReceiver&) = delete;

  void Send(std::uint8_t byte);
  void SendFirst(std::uint8_t byte);  // ahead of what waits
  std::size_t Waiting() const { return on_the_way_.size(); }

  std::uint64_t Lost() const { return lost_; }
  double LongestWait_us() const;  // of a byte in the buffer, until the firmware took it

 private:
  static avr_cycle_count_t OnTime(avr_t* avr, avr_cycle_count_t when, void* self);
  static std::uint8_t ReadData(avr_t* avr, avr_io_addr_t address, void* self);
  void StartBit();
  void StopBit();
  void Buffer(std::uint8_t byte);
  avr_cycle_count_t NextEdge();

  struct Received {
    std::uint8_t byte;
    avr_cycle_count_t at;
  };

  avr_t* avr_;
  avr_int_vector_t* vector_;
  std::deque<std::uint8_t> on_the_way_;
  bool is_byte_on_line_ = false;
  double line_time_ = 0;  // cycles, of the byte's start
  std::deque<Received> buffer_;
  std::optional<std::uint8_t> shift_register_;
  std::uint64_t lost_ = 0;
  avr_cycle_count_t longest_wait_ = 0;
};

// The PWM of timer 1 (data sheet, chapter 16): mode 14, up to ICR1, without a prescaler; simavr's own counter and
// overflow. While the program has one of its interrupts enabled the next rise or fall is told.
class DatasheetPwm {
 public:
  DatasheetPwm(avr_t* avr, std::function<void(bool is_high)> on_edge);
  DatasheetPwm(const DatasheetPwm&) = delete;
  DatasheetPwm& operator=(const DatasheetPwm&) = delete;

 private:
  static void WriteMask(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void* self);
  static void WriteCompare(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void* self);
  static avr_cycle_count_t OnCompare(avr_t* avr, avr_cycle_count_t when, void* self);
  static avr_cycle_count_t OnRise(avr_t* avr, avr_cycle_count_t when, void* self);
  static avr_cycle_count_t OnFall(avr_t* avr, avr_cycle_count_t when, void* self);
  avr_cycle_count_t Until(int count) const;  // cycles, to the next time that the counter has this value
  int Word(int address) const;

  avr_t* avr_;
  avr_int_vector_t* vector_;
  std::function<void(bool is_high)> on_edge_;
};

}  // namespace lake
