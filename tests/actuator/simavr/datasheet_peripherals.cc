#include "datasheet_peripherals.h"

#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_interrupts.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace lake {
namespace {

// Registers in data space, their bits, vectors.
constexpr std::uint16_t kAdcl = 0x78, kAdch = 0x79, kAdcsra = 0x7A, kAdmux = 0x7C, kUcsr0a = 0xC0, kUdr0 = 0xC6;
constexpr std::uint8_t kAden = 0x80, kAdsc = 0x40, kAdif = 0x10, kPrescaler = 0x07, kChannel = 0x0F, kRxc = 0x80,
                       kDor = 0x08;
constexpr std::uint16_t kTimsk1 = 0x6F, kTcnt1 = 0x84, kTop1 = 0x86, kCompare1 = 0x88;
constexpr std::uint8_t kToie1 = 0x01, kOcie1a = 0x02;
constexpr int kAdcVector = 21, kReceiveVector = 18, kCompareVector = 11;
constexpr double kReference_mv = 5000;
constexpr double kCyclesPerByte = 16e6 / 115200 * 10;

avr_int_vector_t* VectorOf(avr_t* avr, int number) {
  for (int i = 0; i < avr->interrupts.vector_count; ++i)
    if (avr->interrupts.vector[i]->vector == number) return avr->interrupts.vector[i];
  throw std::runtime_error("simavr's atmega328p lacks an interrupt");
}

// In place of simavr's own.
void OnRead(avr_t* avr, std::uint16_t address, avr_io_read_t function, void* self) {
  avr->io[AVR_DATA_TO_IO(address)].r = {self, function};
}
void OnWrite(avr_t* avr, std::uint16_t address, avr_io_write_t function, void* self) {
  avr->io[AVR_DATA_TO_IO(address)].w = {self, function};
}

}  // namespace

DatasheetAdc::DatasheetAdc(avr_t* avr) : avr_(avr), vector_(VectorOf(avr, kAdcVector)) {
  OnWrite(avr, kAdcsra, WriteControl, this);
  OnWrite(avr, kAdmux, WriteChannel, this);
  OnRead(avr, kAdcl, ReadLow, this);
  OnRead(avr, kAdch, ReadHigh, this);
}

avr_cycle_count_t DatasheetAdc::Clock() const {
  const int exponent = avr_->data[kAdcsra] & kPrescaler;
  return avr_cycle_count_t{1} << std::max(exponent, 1);
}

bool DatasheetAdc::IsBusy() const {
  return avr_->data[kAdcsra] & kAdsc;
}

void DatasheetAdc::WriteControl(avr_t* avr, avr_io_addr_t, std::uint8_t value, void* self) {
  DatasheetAdc& adc = *static_cast<DatasheetAdc*>(self);
  const std::uint8_t before = avr->data[kAdcsra];
  const bool was_enabled = before & kAden, was_busy = adc.IsBusy(), enabled = value & kAden;
  if (value & kAdif) avr_clear_interrupt(avr, adc.vector_);
  const std::uint8_t raised = avr->data[kAdcsra] & kAdif;  // a 0 leaves the flag as it is
  avr->data[kAdcsra] = static_cast<std::uint8_t>((value & ~kAdif & ~kAdsc) | raised | (was_busy ? kAdsc : 0));
  if (!enabled) {
    avr_cycle_timer_cancel(avr, OnTime, self);
    avr->data[kAdcsra] &= static_cast<std::uint8_t>(~kAdsc);
    return;
  }
  if (!was_enabled) {
    adc.enabled_at_ = avr->cycle;
    adc.is_first_ = true;
  }
  if (!(value & kAdsc)) return;
  if (was_busy)
    ++adc.starts_while_busy_;
  else
    adc.Start();
}

void DatasheetAdc::WriteChannel(avr_t* avr, avr_io_addr_t, std::uint8_t value, void* self) {
  DatasheetAdc& adc = *static_cast<DatasheetAdc*>(self);
  if (adc.IsBusy() && (value & kChannel) != (avr->data[kAdmux] & kChannel)) ++adc.changes_while_busy_;
  avr->data[kAdmux] = value;
}

void DatasheetAdc::Start() {
  avr_->data[kAdcsra] |= kAdsc;
  stage_ = Stage::kBegin;
  if (stands_still_) return;
  const avr_cycle_count_t clock = Clock(), edge = clock - (avr_->cycle - enabled_at_) % clock;
  avr_cycle_timer_register(avr_, edge, OnTime, this);
}

avr_cycle_count_t DatasheetAdc::OnTime(avr_t*, avr_cycle_count_t when, void* self) {
  return static_cast<DatasheetAdc*>(self)->Advance(when);
}

avr_cycle_count_t DatasheetAdc::Advance(avr_cycle_count_t when) {
  const avr_cycle_count_t half_clock = Clock() / 2, sampling = is_first_ ? 27 : 3, all = is_first_ ? 50 : 26;
  switch (stage_) {
    case Stage::kBegin:
      channel_ = avr_->data[kAdmux] & kChannel;
      stage_ = Stage::kSample;
      return when + sampling * half_clock;
    case Stage::kSample: {
      const double millivolt = channel_ < 8 ? millivolt_[static_cast<std::size_t>(channel_)] : 0;
      const double counts = millivolt * 1024 / kReference_mv + noise_counts_ * normal_(random_);
      sampled_ = static_cast<std::uint16_t>(std::clamp(std::floor(counts), 0.0, 1023.0));
      stage_ = Stage::kDone;
      return when + (all - sampling) * half_clock;
    }
    case Stage::kDone:
      break;
  }
  if (!is_locked_) {
    avr_->data[kAdcl] = static_cast<std::uint8_t>(sampled_ & 0xFF);
    avr_->data[kAdch] = static_cast<std::uint8_t>(sampled_ >> 8);
  }
  is_first_ = false;
  ++conversions_;
  avr_->data[kAdcsra] &= static_cast<std::uint8_t>(~kAdsc);
  avr_raise_interrupt(avr_, vector_);
  return 0;
}

std::uint8_t DatasheetAdc::ReadLow(avr_t* avr, avr_io_addr_t, void* self) {
  static_cast<DatasheetAdc*>(self)->is_locked_ = true;
  return avr->data[kAdcl];
}

std::uint8_t DatasheetAdc::ReadHigh(avr_t* avr, avr_io_addr_t, void* self) {
  static_cast<DatasheetAdc*>(self)->is_locked_ = false;
  return avr->data[kAdch];
}

DatasheetReceiver::DatasheetReceiver(avr_t* avr) : avr_(avr), vector_(VectorOf(avr, kReceiveVector)) {
  OnRead(avr, kUdr0, ReadData, this);
}

double DatasheetReceiver::LongestWait_us() const {
  return static_cast<double>(longest_wait_) / 16;
}

avr_cycle_count_t DatasheetReceiver::NextEdge() {
  line_time_ += kCyclesPerByte;
  return static_cast<avr_cycle_count_t>(std::llround(line_time_));
}

void DatasheetReceiver::Send(std::uint8_t byte) {
  on_the_way_.push_back(byte);
  if (is_byte_on_line_) return;
  line_time_ = static_cast<double>(avr_->cycle);
  StartBit();
  avr_cycle_timer_register(avr_, NextEdge() - avr_->cycle, OnTime, this);
}

void DatasheetReceiver::SendFirst(std::uint8_t byte) {
  if (!is_byte_on_line_) return Send(byte);
  on_the_way_.insert(on_the_way_.begin() + 1, byte);  // after the one that is on the line
}

void DatasheetReceiver::StartBit() {
  is_byte_on_line_ = true;
  if (!shift_register_) return;
  shift_register_.reset();
  ++lost_;
  avr_->data[kUcsr0a] |= kDor;
}

void DatasheetReceiver::StopBit() {
  const std::uint8_t byte = on_the_way_.front();
  on_the_way_.pop_front();
  is_byte_on_line_ = false;
  if (buffer_.size() < 2)
    Buffer(byte);
  else
    shift_register_ = byte;
}

void DatasheetReceiver::Buffer(std::uint8_t byte) {
  buffer_.push_back({byte, avr_->cycle});
  avr_raise_interrupt(avr_, vector_);
}

avr_cycle_count_t DatasheetReceiver::OnTime(avr_t*, avr_cycle_count_t, void* self) {
  DatasheetReceiver& receiver = *static_cast<DatasheetReceiver*>(self);
  receiver.StopBit();
  if (receiver.on_the_way_.empty()) return 0;
  receiver.StartBit();
  return receiver.NextEdge();
}

std::uint8_t DatasheetReceiver::ReadData(avr_t* avr, avr_io_addr_t, void* self) {
  DatasheetReceiver& receiver = *static_cast<DatasheetReceiver*>(self);
  std::uint8_t byte = avr->data[kUdr0];
  if (!receiver.buffer_.empty()) {
    byte = receiver.buffer_.front().byte;
    receiver.longest_wait_ = std::max(receiver.longest_wait_, avr->cycle - receiver.buffer_.front().at);
    receiver.buffer_.pop_front();
  }
  avr->data[kUcsr0a] &= static_cast<std::uint8_t>(~kDor);
  avr_clear_interrupt(avr, receiver.vector_);
  avr->data[kUcsr0a] &= static_cast<std::uint8_t>(~kRxc);  // which simavr leaves to its own receiver
  if (receiver.shift_register_) {
    receiver.Buffer(*receiver.shift_register_);
    receiver.shift_register_.reset();
  } else if (!receiver.buffer_.empty()) {
    avr_raise_interrupt(avr, receiver.vector_);
  }
  return byte;
}

DatasheetPwm::DatasheetPwm(avr_t* avr, std::function<void(bool is_high)> on_edge)
    : avr_(avr), vector_(VectorOf(avr, kCompareVector)), on_edge_(std::move(on_edge)) {
  OnWrite(avr, kTimsk1, WriteMask, this);
  OnWrite(avr, kCompare1, WriteCompare, this);  // so that simavr has no compare event of its own
}

void DatasheetPwm::WriteCompare(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void*) {
  avr->data[address] = value;
}

int DatasheetPwm::Word(int address) const {
  return avr_->data[address] | avr_->data[address + 1] << 8;
}

avr_cycle_count_t DatasheetPwm::Until(int count) const {
  const auto& read = avr_->io[AVR_DATA_TO_IO(kTcnt1)].r;
  read.c(avr_, kTcnt1, read.param);  // brings the counter's registers up to date
  const int period = Word(kTop1) + 1;
  return static_cast<avr_cycle_count_t>((count - Word(kTcnt1) + 2 * period - 1) % period + 1);
}

void DatasheetPwm::WriteMask(avr_t* avr, avr_io_addr_t address, std::uint8_t value, void* self) {
  const DatasheetPwm& pwm = *static_cast<DatasheetPwm*>(self);
  avr->data[address] = value;
  avr_cycle_timer_cancel(avr, OnCompare, self);
  if (value & kToie1) avr_cycle_timer_register(avr, pwm.Until(0), OnRise, self);
  if (value & kOcie1a) avr_cycle_timer_register(avr, pwm.Until(pwm.Word(kCompare1)), OnCompare, self);
  if (value & kOcie1a) avr_cycle_timer_register(avr, pwm.Until(pwm.Word(kCompare1)) + 1, OnFall, self);
}

avr_cycle_count_t DatasheetPwm::OnCompare(avr_t* avr, avr_cycle_count_t, void* self) {
  avr_raise_interrupt(avr, static_cast<DatasheetPwm*>(self)->vector_);
  return 0;
}

avr_cycle_count_t DatasheetPwm::OnRise(avr_t*, avr_cycle_count_t, void* self) {
  static_cast<DatasheetPwm*>(self)->on_edge_(true);
  return 0;
}

avr_cycle_count_t DatasheetPwm::OnFall(avr_t*, avr_cycle_count_t, void* self) {
  static_cast<DatasheetPwm*>(self)->on_edge_(false);
  return 0;
}

}  // namespace lake
