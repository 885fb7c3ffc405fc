#include "host_rig.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>

#include "board.h"
#include "lake/actuator/firmware.h"
#include "lake/core/atomic_file.h"

namespace lake {
namespace {

constexpr int kTalkEvery_ms = 500;

// Every file of the firmware that knows nothing of the chip, the tests' board in place of those that do.
constexpr const char* kPortable = "controller.c motor.c end_stops.c protocol.c";

#if defined(__SANITIZE_ADDRESS__)
constexpr const char* kSanitizers = "-fsanitize=address,undefined -fno-sanitize-recover=undefined";
#else
constexpr const char* kSanitizers = "";
#endif

std::filesystem::path Compile(const std::filesystem::path& folder, const std::string& stroke_table) {
  std::filesystem::create_directories(folder);
  WriteTextFile(folder / "stroke_table.h", stroke_table);
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources()) WriteTextFile(folder / file.name, file.text);
  const std::string host = LAKE_SOURCE_DIR "/tests/actuator/host";
  const std::string line = fmt::format(
      "cd '{}' && {} -std=gnu99 -O1 -g1 -fPIC -shared -Wl,-Bsymbolic -Wall -Wextra -Werror {} -I. -I'{}' {} "
      "'{}/host_board.c' -o firmware.so",
      folder.string(), LAKE_HOST_CC, kSanitizers, host, kPortable, host);
  if (std::system(line.c_str()) != 0) throw std::runtime_error("the C compiler failed in " + folder.string());
  return folder / "firmware.so";
}

// Compiled once per stroke table.
std::filesystem::path Library(const std::string& stroke_table) {
  static const TemporaryFolder folder;
  static std::map<std::string, std::filesystem::path> compiled;
  std::filesystem::path& library = compiled[stroke_table];
  if (library.empty()) library = Compile(folder / std::to_string(compiled.size()), stroke_table);
  return library;
}

}  // namespace

HostRig::HostRig(const std::string& stroke_table, const HostActuator& actuator)
    : actuator_(actuator), random_(actuator.seed) {
  // A copy: a library that is loaded twice would share its variables.
  std::filesystem::copy_file(Library(stroke_table), folder_ / "firmware.so");
  library_ = dlopen((folder_ / "firmware.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library_) throw std::runtime_error(dlerror());
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library_, name));
    if (!function) throw std::runtime_error(dlerror());
  };
  find(board_, "host_board");
  find(motor_init_, "motor_init");
  find(end_stops_init_, "end_stops_init");
  find(controller_init_, "controller_init");
  find(controller_tick_, "controller_tick");
  find(protocol_turn_, "protocol_turn");
  find(protocol_realtime_, "protocol_realtime");
  SetStroke(actuator.stroke_mm);
  PowerUp();
}

HostRig::~HostRig() {
  dlclose(library_);
}

void HostRig::PowerUp() {
  std::memset(board_, 0, sizeof *board_);
  to_send_.clear();
  Sense();
  motor_init_();
  end_stops_init_();
  controller_init_();
}

void HostRig::SetStroke(double stroke_mm) {
  motor_mm_ = stroke_mm_ = stroke_mm;
  speed_mm_s_ = 0;
}

double HostRig::Duty() const {
  return board_->bridge == HOST_DRIVE ? board_->direction * board_->counts / double{actuator::kPwmPeriod} : 0;
}

void HostRig::SendNow(char c) {
  protocol_realtime_(c);
}

void HostRig::Move() {
  const double duty = Duty(), supply = actuator_.supply ? actuator_.supply(Time()) : 1;
  const double direction = duty > 0 ? 1 : -1;
  double target = 0;
  if (duty != 0) {
    const double load_n = actuator_.load_n ? actuator_.load_n(Time(), stroke_mm_) : 0;
    const double driven = std::min(1.0, std::abs(duty) * supply);  // a table ends at full duty
    const double over = std::max(1.0, std::abs(duty) * supply);    // beyond it speed grows with the voltage
    const double speed = over * actuator_.speed_factor * actuator_.table->Curve(duty > 0 ? 1 : -1).SpeedFor(driven);
    target = direction * std::max(0.0, speed - direction * load_n * actuator_.mm_s_per_n);
  }
  const double time_constant = board_->bridge == HOST_BRAKE ? 0.01 : duty == 0 ? 0.06 : actuator_.time_constant_s;
  speed_mm_s_ += (target - speed_mm_s_) * (1 - std::exp(-1e-3 / time_constant));
  motor_mm_ += speed_mm_s_ * 1e-3;
  stroke_mm_ = std::clamp(stroke_mm_, motor_mm_ - actuator_.play_mm / 2, motor_mm_ + actuator_.play_mm / 2);
}

std::uint16_t HostRig::Read(double share) {
  std::normal_distribution<double> noise(0, 1);
  std::uniform_real_distribution<double> any(0, 1);
  const double counts =
      any(random_) < actuator_.spikes ? 1023 * any(random_) : 1023 * share + actuator_.noise_counts * noise(random_);
  return static_cast<std::uint16_t>(std::clamp(std::lround(counts), 0L, 1023L));
}

void HostRig::Sense() {
  board_->open =
      static_cast<std::uint8_t>((pulled_[0] || stroke_mm_ <= actuator_.retract_stop_mm ? END_STOP_RETRACT : 0) |
                                (pulled_[1] || stroke_mm_ >= actuator_.extend_stop_mm ? END_STOP_EXTEND : 0));
  const auto [at_0, at_5] = actuator_.potentiometer_mm;
  board_->adc[0] = Read((stroke_mm_ - at_0) / (at_5 - at_0));
}

void HostRig::TickMs() {
  ++now_ms_;
  Move();
  Sense();
  if (talking_ && now_ms_ % kTalkEvery_ms == 0) SendNow('?');
  if (!to_send_.empty() && !board_->line[0]) {
    std::strncpy(board_->line, to_send_.front().c_str(), sizeof board_->line - 1);
    to_send_.pop_front();
  }
  controller_tick_();
  if (!hangs_) protocol_turn_();
  serial_.append(board_->said, board_->said_length);
  board_->said_length = 0;
  samples_.push_back({Time(), stroke_mm_, Duty(), board_->bridge == HOST_BRAKE});
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
