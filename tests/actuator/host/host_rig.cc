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
#include "actuator/screw_speed.h"
#include "board.h"
#include "lake/actuator/firmware.h"
#include "lake/actuator/serial_frame.h"
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

std::filesystem::path Library(const std::string& stroke_table) {
  const std::filesystem::path host = SourceDir() / "tests/actuator/host";
  const std::string command = fmt::format(
      "{} -std=gnu99 -O1 -g1 -fPIC -shared -Wl,-Bsymbolic -Wall -Wextra -Werror {} -I. -I{} {} {} "
      "-o firmware.so",
      LAKE_HOST_CC, kSanitizers, Quoted(host), kPortableSources, Quoted(host / "host_board.c"));
  return CompiledOnce(stroke_table, command, "firmware.so",
                      ReadTextFile(host / "host_board.c") + ReadTextFile(host / "host_board.h"));
}

}  // namespace

HostRig::HostRig(const std::string& stroke_table, const HostActuator& actuator)
    : actuator_(actuator), random_(actuator.seed) {
  // A copy: a library that is loaded twice would share its variables.
  std::filesystem::copy_file(Library(stroke_table), folder_ / "firmware.so");
  SetStroke(actuator.stroke_mm);
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
  find(guard_interrupt_, "guard_interrupt");
  find(controller_turn_, "controller_turn");
  find(controller_remember_, "controller_remember");
  find(controller_status_, "controller_status");
  find(protocol_turn_, "protocol_turn");
  find(protocol_realtime_, "protocol_realtime");
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

void HostRig::SetStroke(double stroke_mm) {
  motor_mm_ = stroke_mm_ = stroke_mm;
  speed_mm_s_ = 0;
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
  const realtime_t realtime = protocol_realtime_(c);
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

double HostRig::Load() const {
  return actuator_.load_n ? actuator_.load_n(Time(), stroke_mm_) : 0;
}

double HostRig::Supply() const {
  if (actuator_.has_relay && !is_relay_closed_) return 0;
  return actuator_.supply ? actuator_.supply(Time()) : 1;
}

BridgeInputs HostRig::Sent() const {
  return {board_->enabled / double{actuator::kPwmPeriod}, board_->in1 != 0, board_->in2 != 0};
}

// What arrives at the motor: the firmware's inputs through whole or broken wires.
double HostRig::MotorDuty() const {
  if (Supply() <= 0 || breaks_.is_motor_unplugged) return 0;
  if (breaks_.shorted != 0) return breaks_.shorted;
  return breaks_.Arriving(Sent()).Duty();
}

void HostRig::Move() {
  const double duty = breaks_.is_reversed ? -MotorDuty() : MotorDuty(), supply = Supply();
  free_mm_s_ = actuator_.speed_factor * FreeSpeed(*actuator_.table, duty, supply);
  target_mm_s_ = LoadedSpeed(free_mm_s_, duty, Load(), actuator_.mm_s_per_n);
  const bool is_brake = breaks_.Arriving(Sent()).IsBrake() && supply > 0;
  if (duty == 0 && !is_brake)
    speed_mm_s_ = std::copysign(std::max(0.0, std::abs(speed_mm_s_) - actuator_.coast_mm_s2 * 1e-3), speed_mm_s_);
  else
    speed_mm_s_ += (target_mm_s_ - speed_mm_s_) * (1 - std::exp(-1e-3 / (is_brake ? 0.01 : actuator_.time_constant_s)));
  if (breaks_.is_blocked) speed_mm_s_ = 0;
  motor_mm_ += (speed_mm_s_ + breaks_.runs_away_mm_s) * 1e-3;
  stroke_mm_ = std::clamp(stroke_mm_, motor_mm_ - actuator_.play_mm / 2, motor_mm_ + actuator_.play_mm / 2);
}

// Friction, load, and the torque that still accelerates it; no more than a motor takes at standstill with that voltage,
// but where the friction alone takes more, which stands for a short.
double HostRig::Current() const {
  const double duty = MotorDuty();
  if (duty == 0) return 0;
  const double lacks = free_mm_s_ > 0 ? (std::abs(target_mm_s_) - std::abs(speed_mm_s_)) / free_mm_s_ : 1;
  const double load_n = std::max(0.0, (duty > 0 ? 1 : -1) * Load());
  const double torque_a =
      actuator_.idle_a + actuator_.a_per_n * load_n + actuator_.stall_a * std::abs(duty) * std::max(0.0, lacks);
  const double most_a = std::max(actuator_.idle_a, actuator_.stall_a * std::abs(duty) * Supply());
  return std::copysign(std::min(torque_a, most_a), duty);
}

std::uint16_t HostRig::Read(double volt) {
  std::normal_distribution<double> noise(0, 1);
  std::uniform_real_distribution<double> any(0, 1);
  if (any(random_) < actuator_.spikes) return static_cast<std::uint16_t>(4092 * any(random_));
  int sum = 0;
  for (int i = 0; i < 4; ++i)
    sum += static_cast<int>(
        std::clamp(std::floor(1023 * volt / 5 + 0.5 + actuator_.noise_counts * noise(random_)), 0.0, 1023.0));
  return static_cast<std::uint16_t>(sum);
}

void HostRig::Sense() {
  board_->open =
      static_cast<std::uint8_t>((pulled_[0] || stroke_mm_ <= actuator_.retract_stop_mm ? END_STOP_RETRACT : 0) |
                                (pulled_[1] || stroke_mm_ >= actuator_.extend_stop_mm ? END_STOP_EXTEND : 0) |
                                (is_button_released_ ? BUTTON_RELEASED : 0));
  const auto [at_0, at_5] = actuator_.potentiometer_mm;
  using Wiper = RigBreaks::Wiper;
  if (breaks_.wiper != Wiper::kFrozen) frozen_v_ = 5 * (stroke_mm_ - at_0) / (at_5 - at_0);
  const double wiper_v = breaks_.wiper == Wiper::kLost ? 0 : breaks_.wiper == Wiper::kShorted ? 5 : frozen_v_;
  const double supply = Supply();
  board_->adc[0] = Read(wiper_v);
  board_->adc[1] = Read(breaks_.current_wire ? 0 : 2.5 + breaks_.current_offset_v + 0.185 * Current());
  board_->adc[2] = Read(breaks_.supply_wire ? 0 : supply * actuator_.supply_v / actuator_.supply_divider);
}

// What the pins of the UNO feel of broken wires, and of the relay.
void HostRig::SetLevels() {
  board_->enable_is_held = breaks_.ena == Wire::kFive;
  board_->in1_is_high = breaks_.in1 == Wire::kOpen || breaks_.in1 == Wire::kFive;
  board_->in2_is_high = breaks_.in2 == Wire::kOpen || breaks_.in2 == Wire::kFive;
  board_->output_is_stuck = breaks_.shorted != 0 && Supply() > 0;
  board_->outputs_contradict = board_->bridge == HOST_DRIVE && breaks_.Contradict(Sent(), Supply() > kReadsHigh);
  const bool is_closed = board_->relay || breaks_.is_relay_welded;
  relay_ms_ = is_closed == is_relay_closed_ ? 0 : relay_ms_ + 1;
  if (relay_ms_ >= (is_closed ? 15 : 10)) is_relay_closed_ = is_closed;
}

void HostRig::TickMs() {
  ++now_ms_;
  SetLevels();
  Move();
  Sense();
  if (talking_ && now_ms_ % kTalkEvery_ms == 0) Send("alive");
  for (int i = 0; i < kBytesPerMs && !to_send_.empty(); ++i) {
    Receive(to_send_.front());
    to_send_.pop_front();
  }
  hung_ms_ = hangs_ ? hung_ms_ + 1 : 0;
  if (hung_ms_ > kLate_ms) board_->is_late = 1;
  guard_interrupt_();
  if (!hangs_) controller_turn_();
  for (int turn = 0; !hangs_ && turn < kTurnsPerMs; ++turn) {
    protocol_turn_();
    controller_remember_();
  }
  TakeSaid();
  samples_.push_back(
      {Time(), stroke_mm_, Duty(), board_->bridge == HOST_BRAKE, 1e-3 * controller_status_().stroke_um, MotorDuty()});
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

bool HostRig::Asks(const std::string& line, const std::string& answer) {
  Send(line);
  return RunUntil(answer + "\n", 0.2);
}

std::string HostRig::Status() {
  const std::size_t from = serial_.size();
  SendNow('?');
  Run(0.002);
  const std::size_t begin = serial_.find('<', from);
  return begin == std::string::npos ? "" : serial_.substr(begin, serial_.find('\n', begin) - begin);
}

}  // namespace lake
