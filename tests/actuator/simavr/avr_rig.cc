#include "avr_rig.h"

#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_interrupts.h>
#include <simavr/sim_irq.h>

#include <algorithm>
#include <stdexcept>

#include "lake/actuator/firmware.h"
#include "lake/actuator/stroke_session.h"

// simavr does not free what avr_make_mcu_by_name and elf_read_firmware allocate; the leak check of the asan preset asks
// here.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libsimavr";
}

namespace lake {
namespace {

constexpr std::uint64_t kCyclesPerMs = 16000;
constexpr double kHertz = 16e6;
constexpr std::uint32_t kSupply_mv = 5000;
// Registers of the ATmega328P in data space.
constexpr std::uint16_t kDdrB = 0x24, kPortB = 0x25, kDdrD = 0x2A, kPortD = 0x2B, kTccr1a = 0x80, kIcr1 = 0x86,
                        kOcr1a = 0x88, kSpl = 0x5D, kSph = 0x5E;
constexpr std::uint8_t kTimer2CompareA = 7;  // its vector
constexpr int kRamEnd = 0x8FF;
constexpr std::size_t kTalkEverySamples = 500;
constexpr int kCom1a1 = 7;  // of TCCR1A: the timer drives the pin
enum Pin { kIn2 = 0, kEna = 1, kRetractStop = 2, kExtendStop = 3, kButton = 4, kRelay = 5, kIn1 = 7, kOut1 = 3 };

bool HasBit(std::uint8_t value, int bit) {
  return (value >> bit) & 1;
}

}  // namespace

AvrRig::AvrRig(const std::filesystem::path& elf, const lake::Actuator& actuator) : plant_(actuator) {
  elf_firmware_t firmware{};
  if (elf_read_firmware(elf.c_str(), &firmware) != 0) throw std::runtime_error("not an ELF file: " + elf.string());
  avr_ = avr_make_mcu_by_name("atmega328p");
  if (!avr_) throw std::runtime_error("simavr has no atmega328p");
  avr_init(avr_);
  avr_->log = LOG_NONE;
  avr_->sleep = [](avr_t*, avr_cycle_count_t) {};  // simulated time does not wait for real time
  firmware.frequency = static_cast<std::uint32_t>(kHertz);
  firmware.vcc = firmware.avcc = firmware.aref = kSupply_mv;
  avr_load_firmware(avr_, &firmware);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), OnSerial, this);
  avr_irq_register_notify(avr_get_interrupt_irq(avr_, kTimer2CompareA) + AVR_INT_IRQ_RUNNING, OnTick, this);
  // The firmware reads its end stops' pins and never asks for their interrupts; simavr would poll each of them in every
  // cycle while it is low, and the processor would never sleep.
  for (const std::uint8_t external_interrupt : {0, 1}) avr_extint_set_strict_lvl_trig(avr_, external_interrupt, 0);
  std::uint32_t flags = 0;
  avr_ioctl(avr_, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);  // nothing to the test's own output
  adc_ = std::make_unique<DatasheetAdc>(avr_);
  adc_->SetNoise(actuator.noise_counts, actuator.seed);
  receiver_ = std::make_unique<DatasheetReceiver>(avr_);
  pwm_ = std::make_unique<DatasheetPwm>(avr_, [this](bool is_high) { SetBridgePins(is_high); });
  SetEndStopPins();
}

AvrRig::~AvrRig() {
  avr_terminate(avr_);
}

double AvrRig::Time() const {
  return static_cast<double>(avr_->cycle) / kHertz;
}
bool AvrRig::HasEnded() const {
  return avr_->state == cpu_Done || avr_->state == cpu_Crashed;
}

bool AvrRig::IsPwm() const {
  return HasBit(avr_->data[kTccr1a], kCom1a1) && HasBit(avr_->data[kDdrB], kEna);
}

bool AvrRig::IsRelayClosed() const {
  return HasBit(avr_->data[kPortD], kRelay) && HasBit(avr_->data[kDdrD], kRelay);
}

// As they arrive at the bridge. A pin that is no output reads low: the board has pull-downs.
// The timer's registers rather than the pin: simavr 1.6 does not move the pin's compare event when OCR1A is written.
BridgeInputs AvrRig::ReadInputs() const {
  const std::uint8_t* data = avr_->data;
  const auto level = [&](std::uint16_t port, std::uint16_t ddr, int bit) {
    return HasBit(data[port], bit) && HasBit(data[ddr], bit);
  };
  const auto word = [&](std::uint16_t address) { return data[address] | data[address + 1] << 8; };
  const double duty = IsPwm() ? std::min(1.0, (word(kOcr1a) + 1.0) / (word(kIcr1) + 1.0)) : 1;
  BridgeInputs inputs;
  inputs.in1 = level(kPortD, kDdrD, kIn1);
  inputs.in2 = level(kPortB, kDdrB, kIn2);
  inputs.enable = IsPwm() || level(kPortB, kDdrB, kEna) ? duty : 0;
  return plant_.breaks.Arriving(inputs);
}

void AvrRig::CountOnTime() {
  const double cycles = static_cast<double>(avr_->cycle - counted_to_);
  on_cycles_[static_cast<int>(DriveOf(inputs_))] += inputs_.enable * cycles;
  on_cycles_[static_cast<int>(Drive::kOff)] += (1 - inputs_.enable) * cycles;
  counted_to_ = avr_->cycle;
}

void AvrRig::OnSerial(avr_irq_t*, std::uint32_t value, void* self) {
  AvrRig& rig = *static_cast<AvrRig*>(self);
  rig.line_.push_back(static_cast<char>(value));
  if (static_cast<char>(value) != '\n') return;
  rig.line_.pop_back();
  // A reset may have cut a line off: such a one is shown as it is.
  rig.serial_ += actuator::Unframed(rig.line_).value_or(rig.line_) + "\n";
  rig.line_.clear();
}

void AvrRig::OnTick(avr_irq_t*, std::uint32_t runs, void* self) {
  AvrRig& rig = *static_cast<AvrRig*>(self);
  if (!runs) return;
  if (rig.turn_began_ == 0) rig.turn_began_ = rig.avr_->cycle;
  ++rig.ticks_;
}

// Before the next instruction: is it `sleep`?
void AvrRig::WatchSleep() {
  constexpr int kSleep = 0x9588;
  if (turn_began_ == 0 || avr_->state != cpu_Running) return;
  if ((avr_->flash[avr_->pc] | avr_->flash[avr_->pc + 1] << 8) != kSleep) return;
  longest_turn_ = std::max(longest_turn_, avr_->cycle - turn_began_);
  turn_began_ = 0;
}

void AvrRig::Send(const std::string& line) {
  SendPlain(actuator::Framed(line) + "\n");
}

void AvrRig::SendPlain(const std::string& bytes) {
  for (const char c : bytes) receiver_->Send(static_cast<std::uint8_t>(c));
}

void AvrRig::SendNow(char c) {
  receiver_->SendFirst(static_cast<std::uint8_t>(c));
}

void AvrRig::PullWire(bool retract, bool pulled) {
  plant_.PullWire(retract, pulled);
  SetEndStopPins();
}

void AvrRig::ReleaseButton(bool released) {
  plant_.is_button_released = released;
  SetEndStopPins();
}

void AvrRig::SetEndStopPins() {
  const bool retract = plant_.IsPressed(true), extend = plant_.IsPressed(false), released = plant_.is_button_released;
  avr_ioport_external_t pins{};
  pins.name = 'D';
  pins.mask = (1 << kRetractStop) | (1 << kExtendStop) | (1 << kButton);
  pins.value = static_cast<unsigned>(retract << kRetractStop | extend << kExtendStop | released << kButton) & 0xFF;
  avr_ioctl(avr_, AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &pins);
  avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), kRetractStop), retract);
  avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), kExtendStop), extend);
  avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), kButton), released);
}

// ENA as an input: the jumper's 5 V, or the pull-down. The outputs on A3 and A4, of a PWM those of its high or low
// part. In the low part the motor's current holds the driven one at ground.
void AvrRig::SetBridgePins(bool is_high) {
  avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('B'), kEna), plant_.breaks.ena == Wire::kFive);
  const bool is_off = inputs_.enable == 0 || (IsPwm() && plant_.breaks.ena == Wire::kWhole && !is_high),
             is_on = plant_.breaks.shorted == 0 && !is_off;
  const bool levels[] = {HasSupply() && (plant_.breaks.shorted > 0 || (is_on && inputs_.in1)),
                         HasSupply() && (plant_.breaks.shorted < 0 || (is_on && inputs_.in2))};
  for (const int output : {0, 1})
    avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('C'), kOut1 + output), levels[output]);
}

void AvrRig::EndMillisecond() {
  CountOnTime();
  double total = 0;
  for (const double cycles : on_cycles_) total += cycles;
  const auto share = [&](Drive drive) { return on_cycles_[static_cast<int>(drive)] / total; };
  const double driven = HasSupply() ? share(Drive::kExtend) - share(Drive::kRetract) : 0;
  const bool brake = share(Drive::kBrake) > 0.5;
  plant_.Move(Time(), driven, brake, HasSupply() ? plant_.Supply(Time()) : 0);
  samples_.push_back({Time(), Stroke(), driven, brake});
  for (double& cycles : on_cycles_) cycles = 0;
  SetEndStopPins();
  for (const int channel : {0, 1, 2}) adc_->SetMillivolt(channel, 1e3 * plant_.Volt(channel));
}

void AvrRig::WatchInterrupts(std::uint64_t before) {
  const bool allowed = avr_->sreg[S_I];
  has_allowed_interrupts_ = has_allowed_interrupts_ || allowed;
  if (!has_allowed_interrupts_) return;
  if (allowed) {
    if (blocked_since_ > 0) longest_blocked_ = std::max(longest_blocked_, avr_->cycle - blocked_since_);
    blocked_since_ = 0;
  } else if (blocked_since_ == 0) {
    blocked_since_ = before;
  }
}

void AvrRig::Run(double seconds) {
  const std::uint64_t until = avr_->cycle + static_cast<std::uint64_t>(seconds * kHertz);
  std::uint64_t next_ms = (avr_->cycle / kCyclesPerMs + 1) * kCyclesPerMs;
  while (avr_->cycle < until && !HasEnded()) {
    const std::uint64_t before = avr_->cycle;
    WatchSleep();
    avr_run(avr_);
    WatchInterrupts(before);
    if (const int pointer = avr_->data[kSpl] | avr_->data[kSph] << 8; pointer > 0)  // 0 until the start-up code sets it
      deepest_stack_ = std::max(deepest_stack_, kRamEnd - pointer);
    if (const BridgeInputs now = ReadInputs(); now != inputs_) {
      CountOnTime();
      if (DriveOf(now) != DriveOf(inputs_)) changes_.push_back({Time(), DriveOf(now), now.enable});
      inputs_ = now;
      SetBridgePins(true);
    }
    if (avr_->cycle < next_ms) continue;
    next_ms += kCyclesPerMs;
    EndMillisecond();
    if (talking_ && samples_.size() % kTalkEverySamples == 0) Send("alive");
  }
}

bool AvrRig::RunUntil(const std::string& text, double most_seconds) {
  const std::size_t from = serial_.size();
  const double until = Time() + most_seconds;
  while (Time() < until && !HasEnded()) {
    Run(0.005);
    if (serial_.find(text, from) != std::string::npos) return true;
  }
  return false;
}

}  // namespace lake
