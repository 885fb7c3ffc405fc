#include "nucleo_rig.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "actuator/compiled_once.h"
#include "actuator/host/host_rig.h"
#include "chip_on_pc.h"
#include "lake/actuator/firmware.h"
#include "lake/actuator/serial_frame.h"
#include "lake/core/atomic_file.h"
#include "places.h"

namespace lake {
namespace {

constexpr std::uint32_t kPeripherals = 0x40000000, kPeripheralsEnd = 0x40024000, kCore = 0xE0000000,
                        kCoreEnd = 0xE000F000, kFlash = 0x08040000, kSectorBytes = 0x20000;
constexpr std::uint32_t kPortA = 0x40020000, kPortBytes = 0x400;
constexpr std::uint32_t kMode = 0x00, kPull = 0x0C, kInput = 0x10, kOutput = 0x14, kSetReset = 0x18;
constexpr std::uint32_t kRcc = 0x40023800, kUsart = 0x40004400, kAdc = 0x40012000, kWatchdog = 0x40003000,
                        kFlashControl = 0x40023C00;
constexpr std::uint32_t kTimerBase[2] = {0x40000400, 0x40000800};
constexpr int kTimerIrq[2] = {29, 30}, kAdcIrq = 18, kUsartIrq = 38;
constexpr std::uint32_t kCycles = 0xE0001004, kInterruptEnables = 0xE000E100;
constexpr std::uint64_t kClocksPerMs = 16'000, kClocksPerByte = 10 * 139;
constexpr std::uint64_t kClocksPerAccess = 4, kConversionClocks = 2 * (84 + 12);
constexpr int kPins = 20;
// A sector of 128 KB by PSIZE: the data sheets' table of the flash's programming, the same for all three chips.
constexpr double kEraseMost_s[4] = {4, 2.6, 2, 2};

// Port and bit of D0 to D13, A0 to A5: UM1724, the Arduino connectors of a Nucleo-64.
struct Place {
  char port;
  std::uint32_t bit;
};
constexpr Place kPlaces[kPins] = {{'A', 3}, {'A', 2}, {'A', 10}, {'B', 3}, {'B', 5}, {'B', 4}, {'B', 10},
                                  {'A', 8}, {'A', 9}, {'C', 7},  {'B', 6}, {'A', 7}, {'A', 6}, {'A', 5},
                                  {'A', 0}, {'A', 1}, {'A', 4},  {'B', 0}, {'C', 1}, {'C', 0}};
// D9 is channel 2 of timer 3, D10 channel 1 of timer 4, both in alternate function 2.
constexpr std::uint32_t CompareOf(int pin) {
  return pin == 9 ? kTimerBase[0] + 0x38 : kTimerBase[1] + 0x34;
}

bool IsBitSet(std::uint32_t word, unsigned bit) {
  return word >> bit & 1;
}

std::filesystem::path NucleoLibrary(const std::string& stroke_table) {
  const std::filesystem::path here = SourceDir() / "tests/actuator/nucleo";
  const std::string command = fmt::format(
      "{} -std=gnu99 -O1 -g1 -fPIC -shared -fexceptions -Wl,-Bsymbolic -Wall -Wextra -Werror "
      "-I. -I{} -include {} {} firmware.c board.c bridge.c serial.c kept.c pins.c chip.c {} -o nucleo.so",
      LAKE_HOST_CC, Quoted(here), Quoted(here / "chip_on_pc.h"), kPortableSources, Quoted(here / "chip_on_pc.c"));
  return CompiledOnce(stroke_table, command, "nucleo.so",
                      ReadTextFile(here / "chip_on_pc.c") + ReadTextFile(here / "chip_on_pc.h"),
                      actuator::Board::kNucleo);
}

}  // namespace

NucleoRig::NucleoRig(const std::string& stroke_table) : flash_(2 * kSectorBytes, 0xFF), flash_before_(flash_) {
  std::filesystem::copy_file(NucleoLibrary(stroke_table), folder_ / "nucleo.so");
  input_v_[0] = 1.65;
  for (const int end_stop : {2, 3}) Hold(end_stop, false);
  PowerUp();
}

NucleoRig::~NucleoRig() {
  dlclose(library_);
}

void NucleoRig::OpenLibrary() {
  if (library_) dlclose(library_);
  library_ = dlopen((folder_ / "nucleo.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) throw std::runtime_error(dlerror());
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library_, name));
  };
  chip_on_pc_t* on_pc = nullptr;
  find(on_pc, "chip_on_pc");
  *on_pc = {this, &NucleoRig::At, &NucleoRig::Sleep};
  find(chip_init_, "chip_init");
  find(firmware_begin_, "firmware_begin");
  find(firmware_turn_, "firmware_turn");
  find(sys_tick_, "SysTick_Handler");
  find(adc_, "ADC_IRQHandler");
  find(usart_, "USART2_IRQHandler");
  find(timer_[0], "TIM3_IRQHandler");  // only with the bridge's outputs
  find(timer_[1], "TIM4_IRQHandler");
  find(board_remembered_, "board_remembered");
  find(board_remember_, "board_remember");
}

void NucleoRig::PowerUp() {
  OpenLibrary();
  peripherals_.assign((kPeripheralsEnd - kPeripherals) / 4, 0);
  core_.assign((kCoreEnd - kCore) / 4, 0);
  Word(kRcc) = 3;  // the internal clock runs
  Word(kUsart) = 1 << 7;
  Word(kUsart + 4) = 0x100;  // as long as nothing was written there
  Word(kFlashControl + 0x10) = 1U << 31;
  Word(kRcc + 0x74) = 7U << 25;               // by power
  Word(kPortA + kPortBytes + kMode) = 0x280;  // PB3 and PB4 are the debugger's
  clocks_ = next_byte_ = 0;
  keys_ = 0;
  erasing_s_ = 0;
  next_tick_ = kClocksPerMs;
  for (const std::size_t i : {0U, 1U}) timers_[i] = {.base = kTimerBase[i]};
  enabled_ = {};
  conversion_ends_.reset();
  to_send_.clear();
  chip_init_();
  firmware_begin_();
}

std::uint32_t& NucleoRig::Word(std::uint32_t address) {
  if (address >= kPeripherals && address < kPeripheralsEnd) return peripherals_[(address - kPeripherals) / 4];
  if (address >= kCore && address < kCoreEnd) return core_[(address - kCore) / 4];
  throw std::runtime_error(fmt::format("nothing is at {:#x}", address));
}

std::uint32_t NucleoRig::Register(std::uint32_t address) const {
  return const_cast<NucleoRig*>(this)->Word(address);
}

void* NucleoRig::At(void* self, std::uint32_t address) {
  NucleoRig& rig = *static_cast<NucleoRig*>(self);
  rig.clocks_ += kClocksPerAccess;
  rig.Settle();
  if (address >= kFlash && address < kFlash + 2 * kSectorBytes) return rig.flash_.data() + (address - kFlash);
  return reinterpret_cast<std::uint8_t*>(&rig.Word(address)) + address % 4;
}

std::uint32_t NucleoRig::PortOf(int pin) const {
  return kPortA + kPortBytes * static_cast<std::uint32_t>(kPlaces[pin].port - 'A');
}

int NucleoRig::Mode(int pin) const {
  return static_cast<int>(Register(PortOf(pin) + kMode) >> (2 * kPlaces[pin].bit) & 3);
}

bool NucleoRig::Level(int pin) const {
  return IsBitSet(Register(PortOf(pin) + kInput), kPlaces[pin].bit);
}

double NucleoRig::PwmOf(int pin) const {
  if (Mode(pin) != 2) return Mode(pin) == 1 && Level(pin) ? 1 : 0;
  const std::uint32_t timer = kTimerBase[pin == 9 ? 0 : 1];
  return std::min(1.0, Register(CompareOf(pin)) / (Register(timer + 0x2C) + 1.0));
}

// What was written since the last access acts.
void NucleoRig::Settle() {
  SettleClock();
  for (Timer& timer : timers_) SettleTimer(timer);
  SettlePorts();
  SettleConverter();
  SettleSerial();
  SettleFlash();
  SettleWatchdog();
}

void NucleoRig::SettleClock() {
  std::uint32_t &control = Word(kRcc), &configuration = Word(kRcc + 0x08);
  if (IsBitSet(control, 16)) control |= 1 << 17;
  if (IsBitSet(control, 24)) control |= 1 << 25;
  configuration = (configuration & ~12U) | (configuration & 3) << 2;
  for (const std::uint32_t i : {0U, 1U}) enabled_[i] = Word(kInterruptEnables + 4 * i) |= enabled_[i];
  if (IsBitSet(Word(0xE000EDFC), 24)) Word(kCycles) = static_cast<std::uint32_t>(clocks_);
}

void NucleoRig::SettlePorts() {
  for (int port = 0; port < 3; ++port) {
    const std::uint32_t base = kPortA + kPortBytes * static_cast<std::uint32_t>(port);
    std::uint32_t& change = Word(base + kSetReset);
    Word(base + kOutput) = (Word(base + kOutput) | (change & 0xFFFF)) & ~(change >> 16);
    change = 0;
  }
  for (int pin = 0; pin < kPins; ++pin) {
    const std::uint32_t base = PortOf(pin), bit = kPlaces[pin].bit;
    bool level = (Word(base + kPull) >> (2 * bit) & 3) == 1;
    if (Mode(pin) == 1) level = IsBitSet(Word(base + kOutput), bit);
    if (Mode(pin) == 2 && (pin == 9 || pin == 10))
      level = Word(kTimerBase[pin == 9 ? 0 : 1] + 0x24) < Word(CompareOf(pin));
    if (Mode(pin) == 0 && held_[pin]) level = *held_[pin];
    if (Mode(pin) == 1 && held_[pin] && *held_[pin] != level)
      wrong_.push_back(fmt::format("D{} drives against what holds it", pin));
    Word(base + kInput) = (Word(base + kInput) & ~(1U << bit)) | static_cast<std::uint32_t>(level) << bit;
  }
  if (!has_outputs_) return;
  const int ena = is_bts7960_ ? 7 : 9, in1 = is_bts7960_ ? 9 : 7, in2 = is_bts7960_ ? 10 : 8;
  held_[17] = is_out1_stuck_ || (Level(ena) && Level(in1));
  held_[18] = Level(ena) && Level(in2);
}

void NucleoRig::SettleTimer(Timer& timer) {
  const std::uint32_t base = timer.base;
  std::uint32_t &status = Word(base + 0x10), &generate = Word(base + 0x14);
  timer.flags &= status;
  if (generate & 1) timer.begun = timer.seen = clocks_;
  generate = 0;
  if (Word(base) & 1) {
    const std::uint64_t period = Word(base + 0x2C) + 1, from = timer.seen - timer.begun, to = clocks_ - timer.begun;
    const auto passed = [&](std::uint64_t at) { return (to + period - at) / period > (from + period - at) / period; };
    if (to / period > from / period) timer.flags |= 1;
    for (const unsigned channel : {0U, 1U})
      if (passed(std::min<std::uint64_t>(Word(base + 0x34 + 4 * channel), period))) timer.flags |= 2U << channel;
    Word(base + 0x24) = static_cast<std::uint32_t>(to % period);
    timer.seen = clocks_;
  }
  status = timer.flags;
}

// The channel counts that was chosen when a conversion begins.
void NucleoRig::SettleConverter() {
  constexpr std::uint32_t kStart = 1U << 30, kEnded = 2;
  std::uint32_t &control = Word(kAdc + 0x08), &status = Word(kAdc);
  if (control & kStart) {
    if (conversion_ends_) wrong_.emplace_back("a conversion is begun while one runs");
    if (!(control & 1)) wrong_.emplace_back("a conversion is begun while the converter is off");
    control &= ~kStart;
    converting_ = Word(kAdc + 0x34);
    if (Word(kAdc + 0x10) >> (3 * converting_) == 0) wrong_.emplace_back("a channel is not given its time");
    conversion_ends_ = clocks_ + kConversionClocks;
  }
  if (!conversion_ends_ || clocks_ < *conversion_ends_ || is_converter_dead_) return;
  conversion_ends_.reset();
  ++conversions_;
  Word(kAdc + 0x4C) = static_cast<std::uint32_t>(std::lround(std::clamp(input_v_[converting_] / 3.3, 0.0, 1.0) * 4095));
  status |= kEnded;
}

void NucleoRig::SettleSerial() {
  std::uint32_t& data = Word(kUsart + 4);
  if (IsBitSet(data, 8)) return;
  if (!IsBitSet(Word(kUsart), 7)) wrong_.emplace_back("a byte is sent over one that has not gone");
  line_ += static_cast<char>(data);
  data = 0x100;
  Word(kUsart) &= ~(1U << 7);
  next_byte_ = std::max(next_byte_, clocks_ + kClocksPerByte);
  if (line_.back() != '\n') return;
  line_.pop_back();
  serial_ += actuator::Unframed(line_).value_or("WRONG CHECK SUM " + line_) + "\n";
  line_.clear();
}

void NucleoRig::CountFlashWork() {
  if (flash_work_left_ > 0 && --flash_work_left_ == 0) throw PowerLost();
}

// Two keys open it; bits only go from one to zero, half words while PG is set; a sector is erased by SER and STRT, its
// first half word last: wherever power is lost in that, any half word may stand as it was.
void NucleoRig::SettleFlash() {
  std::uint32_t &key = Word(kFlashControl + 4), &control = Word(kFlashControl + 0x10);
  if (key == 0x45670123) keys_ = 1;
  if (IsBitSet(control, 31) && keys_ == 2) keys_ = 0;
  if (key == 0xCDEF89AB && keys_ == 1) {
    keys_ = 2;
    control &= ~(1U << 31);
  }
  key = 0;
  constexpr std::uint32_t kErase = 1U << 1 | 1U << 16;
  if ((control & kErase) == kErase) {
    const std::uint32_t sector = control >> 3 & 15;
    if (keys_ != 2 || sector < 6 || sector > 7) wrong_.push_back(fmt::format("sector {} is erased", sector));
    erasing_s_ += kEraseMost_s[control >> 8 & 3];
    const auto begin = flash_.begin() + (sector - 6) * kSectorBytes;
    std::fill_n(begin + 2, kSectorBytes - 2, 0xFF);
    flash_before_ = flash_;
    CountFlashWork();
    std::fill_n(begin, 2, 0xFF);
    flash_before_ = flash_;
    control &= ~(1U << 16);
    ++erasures_;
    CountFlashWork();
  }
  if (!IsBitSet(control, 0)) return;
  constexpr std::size_t kLooked = 2 * 8192;  // bytes of each sector that the firmware may fill
  for (const std::size_t sector : {0U, 1U})
    for (std::size_t i = sector * kSectorBytes; i < sector * kSectorBytes + kLooked; i += 2) {
      if (flash_[i] == flash_before_[i] && flash_[i + 1] == flash_before_[i + 1]) continue;
      if (keys_ != 2 || (flash_[i] & ~flash_before_[i]) || (flash_[i + 1] & ~flash_before_[i + 1]))
        wrong_.push_back(fmt::format("flash is written at {:#x}", kFlash + i));
      std::copy_n(flash_.begin() + static_cast<std::ptrdiff_t>(i), 2,
                  flash_before_.begin() + static_cast<std::ptrdiff_t>(i));
      CountFlashWork();
    }
}

void NucleoRig::SettleWatchdog() {
  std::uint32_t& key = Word(kWatchdog);
  feeds_ += key == 0xAAAA;
  key = 0;
}

bool NucleoRig::IsEnabled(int interrupt) const {
  return IsBitSet(enabled_[interrupt / 32], interrupt % 32);
}

bool NucleoRig::Serve() {
  Settle();
  for (const int i : {0, 1}) {
    if (!IsEnabled(kTimerIrq[i]) || !(Word(kTimerBase[i] + 0x0C) & Word(kTimerBase[i] + 0x10))) continue;
    timer_[i]();
    return true;
  }
  if (clocks_ >= next_byte_) Word(kUsart) |= 1 << 7;
  if (clocks_ >= next_byte_ && !to_send_.empty()) {
    Word(kUsart + 4) = 0x100U | static_cast<std::uint8_t>(to_send_.front());
    Word(kUsart) |= 1 << 5;
    to_send_.pop_front();
    next_byte_ = clocks_ + kClocksPerByte;
  }
  const bool receives = IsBitSet(Word(kUsart), 5),
             sends = IsBitSet(Word(kUsart), 7) && IsBitSet(Word(kUsart + 0x0C), 7);
  if (IsEnabled(kUsartIrq) && (receives || sends)) {
    usart_();
    Word(kUsart) &= ~(1U << 5);
    return true;
  }
  if (IsEnabled(kAdcIrq) && (Word(kAdc) & 2)) {
    Word(kAdc) &= ~2U;  // reading the result does
    adc_();
    return true;
  }
  if (clocks_ < next_tick_ || Word(0xE000E010) != 7) return false;
  next_tick_ += Word(0xE000E014) + 1;
  sys_tick_();
  return true;
}

void NucleoRig::Sleep(void* self) {
  NucleoRig& rig = *static_cast<NucleoRig*>(self);
  while (!rig.Serve()) rig.clocks_ += 48;
}

void NucleoRig::Run(double seconds) {
  const std::uint64_t until = clocks_ + static_cast<std::uint64_t>(std::llround(seconds * 16e6));
  while (clocks_ < until) firmware_turn_();
}

bool NucleoRig::RunUntil(const std::string& text, double most_seconds) {
  const std::size_t from = serial_.size();
  for (int left = static_cast<int>(std::lround(most_seconds * 1e3)); left > 0; --left) {
    Run(1e-3);
    if (serial_.find(text, from) != std::string::npos) return true;
  }
  return false;
}

void NucleoRig::Send(const std::string& line) {
  const std::string bytes = actuator::Framed(line) + "\n";
  to_send_.insert(to_send_.end(), bytes.begin(), bytes.end());
}

bool NucleoRig::Asks(const std::string& line, const std::string& answer) {
  Send(line);
  return RunUntil(answer + "\n", 0.2);
}

}  // namespace lake
