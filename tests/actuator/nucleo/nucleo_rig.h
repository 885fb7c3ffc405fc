// The whole firmware of the Nucleo, compiled for this PC, on a model of the STM32F4's registers as the reference manual
// has them: clock, ports, timers, converter, serial line, flash, watchdog. Each interrupt is served when it comes, but
// for one inside another.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "temporary_folder.h"

namespace lake {

// What is thrown where power is lost.
struct PowerLost {};

class NucleoRig {
 public:
  explicit NucleoRig(const std::string& stroke_table);
  NucleoRig(const NucleoRig&) = delete;
  NucleoRig& operator=(const NucleoRig&) = delete;
  ~NucleoRig();

  void PowerUp();  // as after a reset: the flash stays as it is
  void Run(double seconds);
  bool RunUntil(const std::string& serial_text, double most_seconds);
  bool Asks(const std::string& line, const std::string& answer);
  void Send(const std::string& line);  // with its check sum

  // A pin by its number on the Arduino connectors.
  void Hold(int pin, std::optional<bool> is_high) { held_[pin] = is_high; }  // from outside, if it is an input
  bool IsOutput(int pin) const { return Mode(pin) == 1; }
  bool IsInput(int pin) const { return Mode(pin) == 0; }
  bool Level(int pin) const;
  double PwmOf(int pin) const;  // the part of the time for which it is high; of no PWM, its level
  void SetInput(int channel, double volt) { input_v_[channel] = volt; }
  void StopConverter() { is_converter_dead_ = true; }
  // Both outputs of the bridge on A3 and A4, as the inputs and ENA have them, unless OUT1 is stuck high.
  void WireOutputs(bool is_bts7960 = false) {
    has_outputs_ = true;
    is_bts7960_ = is_bts7960;
  }
  void StickOutput(bool is_stuck) { is_out1_stuck_ = is_stuck; }
  void LosePowerAtFlashWork(int number) { flash_work_left_ = number; }

  const std::string& Serial() const { return serial_; }
  std::uint32_t Register(std::uint32_t address) const;
  int Conversions() const { return conversions_; }
  int WatchdogFeeds() const { return feeds_; }
  int Erasures() const { return erasures_; }
  double ErasingSeconds() const { return erasing_s_; }              // at most, since the last reset
  const std::vector<std::string>& Wrong() const { return wrong_; }  // what no STM32F4 allows
  void Remember(std::uint8_t place, std::uint8_t number) { board_remember_(place, number); }
  std::uint8_t Remembered(std::uint8_t place) const { return board_remembered_(place); }

 private:
  struct Timer {
    std::uint32_t base = 0;
    std::uint64_t begun = 0, seen = 0;
    std::uint32_t flags = 0;
  };

  void OpenLibrary();
  static void* At(void* rig, std::uint32_t address);
  static void Sleep(void* rig);
  std::uint32_t& Word(std::uint32_t address);
  int Mode(int pin) const;
  std::uint32_t PortOf(int pin) const;
  void Settle();
  void SettlePorts();
  void SettleClock();
  void SettleTimer(Timer& timer);
  void SettleConverter();
  void SettleSerial();
  void SettleFlash();
  void SettleWatchdog();
  void CountFlashWork();
  bool Serve();  // one interrupt that waits
  bool IsEnabled(int interrupt) const;

  TemporaryFolder folder_;
  void* library_ = nullptr;
  void (*chip_init_)() = nullptr;
  void (*firmware_begin_)() = nullptr;
  void (*firmware_turn_)() = nullptr;
  void (*sys_tick_)() = nullptr;
  void (*adc_)() = nullptr;
  void (*usart_)() = nullptr;
  void (*timer_[2])() = {};
  std::uint8_t (*board_remembered_)(std::uint8_t) = nullptr;
  void (*board_remember_)(std::uint8_t, std::uint8_t) = nullptr;

  std::vector<std::uint32_t> peripherals_, core_;
  std::vector<std::uint8_t> flash_, flash_before_;
  std::uint64_t clocks_ = 0, next_tick_ = 0, next_byte_ = 0;
  std::map<int, std::optional<bool>> held_;
  std::array<double, 16> input_v_{};
  Timer timers_[2];
  std::array<std::uint32_t, 2> enabled_{};  // of the interrupts: a one that is written stays
  std::optional<std::uint64_t> conversion_ends_;
  std::uint32_t converting_ = 0;
  bool is_converter_dead_ = false, has_outputs_ = false, is_bts7960_ = false, is_out1_stuck_ = false;
  int conversions_ = 0, feeds_ = 0, erasures_ = 0;
  int flash_work_left_ = -1, keys_ = 0;
  double erasing_s_ = 0;
  std::deque<char> to_send_;
  std::string line_, serial_;
  std::vector<std::string> wrong_;
};

}  // namespace lake
