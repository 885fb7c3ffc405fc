#include "host_rig.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "actuator/compiled_once.h"
#include "board.h"
#include "lake/actuator/firmware.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/atomic_file.h"
#include "places.h"

namespace lake {
namespace {

constexpr int kTalkEvery_ms = 500;
constexpr double kReadsHigh = 0.62;  // of 12 V: 3 V behind the outputs' dividers, which every pin reads as high
constexpr int kBytesPerMs = 11;      // of 115200 baud
constexpr int kLate_ms = 4;          // as on the UNO
constexpr int kTurnsPerMs = 8;       // of the main loop: one for each interrupt, at least

#if defined(__SANITIZE_ADDRESS__)
constexpr const char* kSanitizers = "-fsanitize=address,undefined -fno-sanitize-recover=undefined";
#else
constexpr const char* kSanitizers = "";
#endif

std::filesystem::path Library(actuator::Feedback feedback, const std::string& stroke_table) {
  const std::filesystem::path host = SourceDir() / "tests/actuator/host";
  const std::string command = fmt::format(
      "{} -std=gnu99 -O1 -g1 -fPIC -shared -Wl,-Bsymbolic -Wall -Wextra -Werror {} -I. -I{} {} {} "
      "-o firmware.so",
      LAKE_HOST_CC, kSanitizers, Quoted(host), kPortableSources, Quoted(host / "host_board.c"));
  return CompiledOnce(feedback, stroke_table, command, "firmware.so",
                      ReadTextFile(host / "host_board.c") + ReadTextFile(host / "host_board.h"));
}

}  // namespace

HostRig::HostRig(actuator::Feedback feedback, const std::string& stroke_table, const lake::Actuator& actuator)
    : plant_(actuator), random_(actuator.seed) {
  // A copy: a library that is loaded twice would share its variables.
  std::filesystem::copy_file(Library(feedback, stroke_table), folder_ / "firmware.so");
  PowerUp();
}

HostRig::~HostRig() {
  dlclose(library_);
}

// As a reset does, with all variables as they were made.
void HostRig::OpenLibrary() {
  if (library_) dlclose(library_);
  library_ = dlopen((folder_ / "firmware.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) throw std::runtime_error(dlerror());
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library_, name));
    if (!function) throw std::runtime_error(dlerror());
  };
  find(board_, "host_board");
  find(motor_init_, "motor_init");
  find(end_stops_init_, "end_stops_init");
  find(power_init_, "power_init");
  find(analog_init_, "analog_init");
  find(controller_init_, "controller_init");
  find(board_interrupt_, "board_interrupt");
  find(controller_turn_, "controller_turn");
  find(controller_remember_, "controller_remember");
  find(controller_status_, "controller_status");
  find(protocol_turn_, "protocol_turn");
  find(serial_realtime_, "serial_realtime");
}

void HostRig::PowerUp() {
  std::array<std::uint8_t, 256> remembered{};
  if (board_) std::ranges::copy(board_->remembered, remembered.begin());
  OpenLibrary();
  std::ranges::copy(remembered, board_->remembered);
  to_send_.clear();
  Sense();
  motor_init_();
  end_stops_init_();
  power_init_();
  analog_init_();
  controller_init_();
}

double HostRig::Duty() const {
  return board_->bridge == HOST_DRIVE ? board_->direction * board_->counts / double{actuator::kPwmPeriod} : 0;
}

void HostRig::Send(const std::string& line) {
  SendPlain(actuator::Framed(line) + "\n");
}
void HostRig::SendPlain(const std::string& bytes) {
  to_send_.insert(to_send_.end(), bytes.begin(), bytes.end());
}
void HostRig::SendNow(char c) {
  Receive(c);
}

// As the receiver's interrupt does.
void HostRig::Receive(char c) {
  const realtime_t realtime = serial_realtime_(c);
  if (realtime == REALTIME_DONE) return;
  if (realtime == REALTIME_FORGET) board_->received_tail = board_->received_head;
  board_->received[board_->received_head++] =
      realtime == REALTIME_FORGET ? std::uint8_t{SERIAL_FORGET} : static_cast<std::uint8_t>(c);
}

void HostRig::TakeSaid() {
  // Whole lines: a row is said over some ms.
  const std::string all(board_->said, board_->said_length), said = all.substr(0, all.rfind('\n') + 1);
  all.copy(board_->said, std::string::npos, said.size());
  board_->said_length -= static_cast<std::uint32_t>(said.size());
  wire_ += said;
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    const auto text = actuator::Unframed(line);
    if (!text) throw std::runtime_error("a wrong check sum: " + line);
    serial_ += *text + "\n";
  }
}

double HostRig::Supply() const {
  return plant_.actuator.has_relay && !is_relay_closed_ ? 0 : plant_.Supply(Time());
}

BridgeInputs HostRig::Sent() const {
  return {board_->enabled / double{actuator::kPwmPeriod}, board_->in1 != 0, board_->in2 != 0};
}

// What arrives at the motor: the firmware's inputs through whole or broken wires.
double HostRig::MotorDuty() const {
  if (Supply() <= 0 || plant_.breaks.is_motor_unplugged) return 0;
  if (plant_.breaks.shorted != 0) return plant_.breaks.shorted;
  return plant_.breaks.Arriving(Sent()).Duty();
}

std::uint16_t HostRig::Read(double volt) {
  std::normal_distribution<double> noise(0, 1);
  std::uniform_real_distribution<double> any(0, 1);
  if (any(random_) < plant_.actuator.spikes) return static_cast<std::uint16_t>(4092 * any(random_));
  int sum = 0;
  for (int i = 0; i < 4; ++i)
    sum += static_cast<int>(
        std::clamp(std::floor(1023 * volt / 5 + 0.5 + plant_.actuator.noise_counts * noise(random_)), 0.0, 1023.0));
  return static_cast<std::uint16_t>(sum);
}

void HostRig::Sense() {
  board_->open = static_cast<std::uint8_t>((plant_.IsPressed(true) ? END_STOP_RETRACT : 0) |
                                           (plant_.IsPressed(false) ? END_STOP_EXTEND : 0) |
                                           (plant_.is_button_released ? BUTTON_RELEASED : 0));
  for (const int channel : {0, 1, 2}) board_->adc[channel] = Read(plant_.Volt(channel));
}

// What the pins of the UNO feel of broken wires, and of the relay.
void HostRig::SetLevels() {
  board_->enable_is_held = plant_.breaks.ena == Wire::kFive;
  board_->in1_is_high = plant_.breaks.in1 == Wire::kOpen || plant_.breaks.in1 == Wire::kFive;
  board_->in2_is_high = plant_.breaks.in2 == Wire::kOpen || plant_.breaks.in2 == Wire::kFive;
  board_->output_is_stuck = plant_.breaks.shorted != 0 && Supply() > 0;
  board_->outputs_contradict = board_->bridge == HOST_DRIVE && plant_.breaks.Contradict(Sent(), Supply() > kReadsHigh);
  const bool is_closed = board_->relay || plant_.breaks.is_relay_welded;
  relay_ms_ = is_closed == is_relay_closed_ ? 0 : relay_ms_ + 1;
  if (relay_ms_ >= (is_closed ? 15 : 10)) is_relay_closed_ = is_closed;
}

void HostRig::TickMs() {
  ++now_ms_;
  SetLevels();
  plant_.Move(Time(), MotorDuty(), plant_.breaks.Arriving(Sent()).IsBrake() && Supply() > 0, Supply());
  Sense();
  if (talking_ && now_ms_ % kTalkEvery_ms == 0) Send("alive");
  for (int i = 0; i < kBytesPerMs && !to_send_.empty(); ++i) {
    Receive(to_send_.front());
    to_send_.pop_front();
  }
  hung_ms_ = hangs_ ? hung_ms_ + 1 : 0;
  if (hung_ms_ > kLate_ms) board_->is_late = 1;
  board_interrupt_();
  if (!hangs_) controller_turn_();
  for (int turn = 0; !hangs_ && turn < kTurnsPerMs; ++turn) {
    protocol_turn_();
    controller_remember_();
  }
  TakeSaid();
  samples_.push_back(
      {Time(), Stroke(), Duty(), board_->bridge == HOST_BRAKE, 1e-3 * controller_status_().stroke_um, MotorDuty()});
}

void HostRig::Run(double seconds) {
  for (std::int64_t left = std::llround(seconds * 1e3); left > 0; --left) TickMs();
}

bool HostRig::RunUntil(const std::string& text, double most_seconds) {
  const std::size_t from = serial_.size();
  for (std::int64_t left = std::llround(most_seconds * 1e3); left > 0; --left) {
    TickMs();
    if (serial_.find(text, from) != std::string::npos) return true;
  }
  return false;
}

std::string HostRig::Status() {
  const std::size_t from = serial_.size();
  SendNow('?');
  Run(0.002);
  const std::size_t begin = serial_.find('<', from);
  return begin == std::string::npos ? "" : serial_.substr(begin, serial_.find('\n', begin) - begin);
}

}  // namespace lake
