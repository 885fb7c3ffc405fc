#include "lake/actuator/stroke_session.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <ostream>
#include <regex>
#include <utility>

#include "lake/actuator/firmware.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/file_descriptor.h"

namespace lake::actuator {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPoll_s = 0.05, kReply_s = 1;
constexpr double kCounted_s = 4294967.296;  // 2^32 ms
constexpr int kHoldRows = 2;  // the reason comes in the ms in which the hold begins, so before the second row
constexpr const char* kReset = "!\x18";
constexpr std::string_view kAlarm = "ALARM:", kWaited = "[MSG:waited ";

double Since(Clock::time_point when) {
  return std::chrono::duration<double>(Clock::now() - when).count();
}

// A serial line of the operating system (POSIX termios), raw, 8N1.
class SerialPort {
 public:
  // 115200 baud. Throws Error naming the port: it cannot be opened, is no serial line, or another program has it.
  explicit SerialPort(const std::filesystem::path& path);

  // What has arrived, after waiting for at most so long; empty if nothing has. Throws Error if the line is gone.
  std::string Read(double most_s);

  // Throws Error if the line is gone or takes nothing for a second.
  void Write(std::string_view text);

 private:
  std::filesystem::path path_;
  FileDescriptor file_;
};

constexpr int kPatience_ms = 1000;

bool WaitFor(int file, short events, int most_ms) {
  pollfd poll_file{file, events, 0};
  return poll(&poll_file, 1, most_ms) > 0;
}

SerialPort::SerialPort(const std::filesystem::path& path)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (file_ < 0)
    throw Fail("{}: the serial line cannot be opened ({}); is the board plugged in, and are you in the group dialout?",
               path.string(), std::strerror(errno));
  termios settings{};
  const bool is_line = tcgetattr(file_, &settings) == 0;
  if (!is_line || flock(file_, LOCK_EX | LOCK_NB) != 0)
    throw Fail("{}: {}", path.string(),
               is_line ? "another program has this serial line; close its serial monitor" : "this is no serial line");
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);  // the line's end does not reset the board
  cfsetspeed(&settings, B115200);
  tcsetattr(file_, TCSANOW, &settings);
  tcflush(file_, TCIOFLUSH);
}

std::string SerialPort::Read(double most_s) {
  std::array<char, 512> buffer;
  if (!WaitFor(file_, POLLIN, static_cast<int>(std::lround(1e3 * most_s)))) return {};
  const ssize_t count = read(file_, buffer.data(), buffer.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  if (count <= 0) throw Fail("{}: the serial line is gone; was the board unplugged?", path_.string());
  return {buffer.data(), static_cast<std::size_t>(count)};
}

void SerialPort::Write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(file_, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (!(count < 0 && (errno == EAGAIN || errno == EINTR) && WaitFor(file_, POLLOUT, kPatience_ms))) {
      throw Fail("{}: the serial line takes nothing; was the board unplugged?", path_.string());
    }
  }
}

// Every line is on its way to the disk when Write returns: what was moved is known even if the computer fails.
class LogFile {
 public:
  explicit LogFile(const std::filesystem::path& path)
      : path_(path), file_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (file_ < 0) Refuse();
  }

  void Write(const std::string& line) {
    const std::string text = line + "\n";
    if (write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) Refuse();
  }
  void ToDisk() {
    if (fsync(file_) != 0 && errno != EINVAL) Refuse();
  }

 private:
  [[noreturn]] void Refuse() const {
    throw Fail("{}: the log cannot be written ({}): without one nothing moves", path_.string(), std::strerror(errno));
  }

  std::filesystem::path path_;
  FileDescriptor file_;
};

bool IsRow(const std::string& line) {
  return !line.empty() && line.find(',') != std::string::npos && std::isdigit(static_cast<unsigned char>(line[0]));
}

bool IsHeader(const std::string& line) {
  return line.starts_with("time_s,");
}

std::string Field(const std::string& row, int index) {
  std::size_t begin = 0;
  for (; index > 0 && begin != std::string::npos; --index) begin = row.find(',', begin) + 1;
  return row.substr(begin, row.find(',', begin) - begin);
}

// The board at the other end of the line.
class Board {
 public:
  Board(const std::filesystem::path& port, double keep_alive_s) : port_(port), keep_alive_s_(keep_alive_s) {}

  void Say(std::string_view text) { port_.Write(text); }
  void SayLine(const std::string& line) { port_.Write(Framed(line) + "\n"); }

  // The next whole line as it came, if there is one within kPoll_s; meanwhile it says that somebody is there.
  std::optional<std::string> Line() {
    if (Since(last_said_) > keep_alive_s_) {
      SayLine("alive");
      last_said_ = Clock::now();
    }
    if (buffer_.find('\n') == std::string::npos) buffer_ += port_.Read(kPoll_s);
    const std::size_t end = buffer_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return line;
  }

  // Whatever it does.
  void Stop() noexcept {
    try {
      port_.Write(kReset);
      for (const auto begin = Clock::now(); Since(begin) < 0.3;) buffer_ += port_.Read(kPoll_s);
    } catch (const std::exception&) {
      // The line is gone: the firmware stops by its time-out.
    }
  }

 private:
  SerialPort port_;
  double keep_alive_s_;
  std::string buffer_;
  Clock::time_point last_said_ = Clock::now();
};

class Session {
 public:
  Session(const SessionOptions& options, LogFile& log, const std::function<void(const std::string&, double)>& poll)
      : options_(options), log_(log), poll_(poll), board_(options.port, options.keep_alive_s) {}

  // Opening the port resets an UNO unless it has been open before. Then Ctrl-X makes it greet.
  void Greet(const SketchIdentity& sketch) {
    std::string design, program;
    bool has_header = false;
    int asked = 0;
    for (const auto begin = Clock::now(); design.empty() || program.empty() || !has_header;) {
      if (Since(begin) > options_.greeting_s)
        Refuse("no greeting of lake-stroke's firmware within {} s: is it uploaded?", options_.greeting_s);
      if (Since(begin) > (asked + 1) * options_.greeting_s / 4) {
        board_.Say(kReset);
        ++asked;
      }
      const std::optional<std::string> line = Line();
      if (!line) continue;
      if (line->starts_with("[MSG:design ")) design = line->substr(12, line->find(',') - 12);
      if (line->starts_with("[MSG:program ")) program = line->substr(13, line->find(']') - 13);
      if (IsHeader(*line)) {
        has_header = true;
        header_ = *line;
      }
    }
    if (design != sketch.design_hash)
      Refuse("the board has the program of design {}, the folder that of {}: upload the folder's sketch", design,
             sketch.design_hash);
    if (program != sketch.program_hash)
      Refuse(
          "the board has another program of this design, {}, than the folder, {} (strokes, duty table or options "
          "differ): upload the folder's sketch",
          program, sketch.program_hash);
    TakeUpFault();
  }

  void WriteHeader() {
    log_.Write(header_);
    log_.ToDisk();
    is_logging_ = true;
  }

  void Ask(const std::string& command) {
    board_.SayLine(command);
    for (const auto begin = Clock::now(); Since(begin) < kReply_s;) {
      const std::optional<std::string> line = Line();
      if (line == "ok") return;
      if (line && line->starts_with("error:"))
        Refuse("'{}' was refused, {}: {}", command, *line, ErrorText(std::atoi(line->c_str() + 6)));
    }
    Refuse("no answer to '{}'", command);
  }

  // Until what moves says that it is done, or the rows do: the remark may be damaged on its way.
  double WaitForDone(const std::string& what, double most_s) {
    const auto begin = Clock::now();
    bool has_moved = false;
    int rows_in_hold = 0;
    while (Since(begin) < most_s) {
      const std::optional<std::string> line = Line();
      poll_(state_, Since(begin));
      if (!line) continue;
      if (line == "[MSG:done]") return Since(begin);
      RefuseIfHeld(*line);
      if (!IsRow(*line)) continue;
      if (state_ == "idle" && has_moved) return Since(begin);
      has_moved = has_moved || state_ != "idle";
      rows_in_hold = state_ == "hold" ? rows_in_hold + 1 : 0;
      if (rows_in_hold > kHoldRows)
        Refuse("{} is held at its place, and the firmware's reason was damaged on the line", what);
    }
    Refuse("{} has not ended within {:.0f} s", what, most_s);
  }

  void Stop() noexcept { board_.Stop(); }

  std::size_t Rows() const { return rows_; }
  // Of the program, s: the firmware tells it once, after the last row of the running program. Without a potentiometer
  // no program waits.
  std::optional<double> Waited() const {
    const bool may_wait = header_.find("measured_mm") != std::string::npos;
    if (waited_s_ || (may_wait && has_lost_line_)) return waited_s_;
    return 0;
  }

 private:
  // Names the port.
  template <typename... Values>
  [[noreturn]] void Refuse(fmt::format_string<Values...> text, Values&&... values) const {
    throw Fail("{}: {}", options_.port.string(), fmt::format(text, std::forward<Values>(values)...));
  }

  void RefuseIfHeld(const std::string& line) const {
    if (line.starts_with("[MSG:host silent"))
      Refuse("the firmware did not hear this program in time and stopped; is the computer too busy?");
    if (line.starts_with("[MSG:button released")) Refuse("the button was released, and the firmware stopped");
  }

  // What the first row after the greeting tells of before; the fault itself is told between them. One that is still
  // there is told again.
  void TakeUpFault() {
    state_.clear();
    for (const auto begin = Clock::now(); state_.empty() && Since(begin) < kReply_s;) Line();
    if (state_.empty()) Refuse("no row within {} s", kReply_s);
    if (state_ != "fault") return;
    if (!options_.acknowledge)
      Refuse("the board has a fault that nobody has acknowledged, {}: {}; see to it, then run with --acknowledge",
             alarm_, AlarmText(AlarmNumber(alarm_)));
    Ask("reset");
  }

  static int AlarmNumber(const std::string& line) {
    return line.starts_with(kAlarm) ? std::atoi(line.c_str() + kAlarm.size()) : 0;
  }

  // The next whole line, if one has come. Throws on a fault or long silence.
  std::optional<std::string> Line() {
    const std::optional<std::string> line = board_.Line();
    if (!line) {
      if (is_logging_ && Since(last_heard_) > options_.silent_s)
        Refuse("the firmware has been silent for {} s", options_.silent_s);
      return std::nullopt;
    }
    last_heard_ = Clock::now();
    // A line that was damaged on its way says nothing: rows come again, a reply that does not come is an error, and
    // each row says whether there is a fault, a hold or an end.
    std::optional<std::string> text = Unframed(*line);
    has_lost_line_ = has_lost_line_ || !text;
    if (text) Take(*text);
    return text;
  }

  void Take(const std::string& line) {
    if (line.starts_with(kAlarm)) alarm_ = line;
    if (line.starts_with(kWaited)) waited_s_ = std::strtod(line.c_str() + kWaited.size(), nullptr);
    if (IsRow(line)) {
      state_ = Field(line, 5);
      has_lost_line_ = has_lost_line_ && state_ == "idle";
    }
    if (!is_logging_) return;
    if (line.starts_with(kAlarm)) Refuse("the firmware stopped with {}: {}", line, AlarmText(AlarmNumber(line)));
    if (line.starts_with("[MSG:lake-stroke")) Refuse("the board was reset");
    if (!IsRow(line)) return;
    RefuseIfReset(line);
    log_.Write(WithWholeTime(line));
    ++rows_;
    if (state_ == "fault") Refuse("the firmware stopped with a fault");
  }

  // The firmware counts ms in 32 bits and begins anew after 49.7 days; where it does so earlier it was reset, whether
  // or not its greeting has come whole.
  void RefuseIfReset(const std::string& row) const {
    constexpr double kRowsLost_s = 60;
    if (std::strtod(row.c_str(), nullptr) < last_time_s_ && last_time_s_ < kCounted_s - kRowsLost_s)
      Refuse("the board was reset");
  }

  std::string WithWholeTime(const std::string& row) {
    const double time_s = std::strtod(row.c_str(), nullptr);
    if (time_s < last_time_s_) before_s_ += kCounted_s;
    last_time_s_ = time_s;
    return before_s_ == 0 ? row : fmt::format("{:.3f}{}", before_s_ + time_s, row.substr(row.find(',')));
  }

  const SessionOptions& options_;
  LogFile& log_;
  const std::function<void(const std::string&, double)>& poll_;
  Board board_;
  std::string header_, state_, alarm_;
  Clock::time_point last_heard_ = Clock::now();
  bool is_logging_ = false;
  double last_time_s_ = 0, before_s_ = 0;
  std::size_t rows_ = 0;
  std::optional<double> waited_s_;
  bool has_lost_line_ = false;  // since anything moved
};

// Lines of a person to the firmware, and back.
class Talk {
 public:
  Talk(const TalkOptions& options, LogFile& log, std::ostream& out)
      : log_(log), out_(out), board_(options.port, options.keep_alive_s) {}

  // What the person has said meanwhile; false at the end.
  bool Hear(int in) {
    pollfd waiting{in, POLLIN, 0};
    if (::poll(&waiting, 1, 0) <= 0) return true;
    std::array<char, 256> bytes;
    const ssize_t count = read(in, bytes.data(), bytes.size());
    if (count <= 0) return count < 0 && (errno == EINTR || errno == EAGAIN);
    said_.append(bytes.data(), static_cast<std::size_t>(count));
    for (std::size_t end; (end = said_.find('\n')) != std::string::npos; said_.erase(0, end + 1)) {
      const std::string line(Trim(said_.substr(0, end)));
      is_status_asked_ = is_status_asked_ || line == "?";
      if (!line.empty()) board_.Say(line == "?" || line == "!" ? line : Framed(line) + "\n");
    }
    return true;
  }

  // What the firmware says.
  void Pass() {
    const std::optional<std::string> heard = board_.Line();
    if (!heard) return;
    const std::optional<std::string> text = Unframed(*heard);
    if (text && text->starts_with("<") && !std::exchange(is_status_asked_, false)) return;  // of a sign of life
    const std::string line = text.value_or("# a line was damaged");
    log_.Write(line);
    out_ << line << std::endl;
  }

  void Stop() noexcept { board_.Stop(); }

 private:
  LogFile& log_;
  std::ostream& out_;
  Board board_;
  std::string said_;
  bool is_status_asked_ = false;
};

// The first has number 1.
std::string NumberedText(const std::vector<std::string>& texts, int number, const char* otherwise) {
  return number >= 1 && number <= static_cast<int>(texts.size()) ? texts[static_cast<std::size_t>(number) - 1]
                                                                 : otherwise;
}

}  // namespace

void RunTalk(const TalkOptions& options, int in, std::ostream& out, const std::filesystem::path& log,
             const std::function<void()>& poll) {
  LogFile file(log);
  Talk talk(options, file, out);
  try {
    while (talk.Hear(in)) {
      talk.Pass();
      poll();
    }
  } catch (...) {
    talk.Stop();
    throw;
  }
  talk.Stop();
}

SketchIdentity ReadSketchIdentity(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "stroke_table.h";
  const std::string text = ReadTextFile(file);
  SketchIdentity identity;
  std::smatch match;
  if (text.find("#define LAKE_HAS_PROGRAM 0") != std::string::npos ||
      !std::regex_search(text, match, std::regex("#define LAKE_DESIGN \"([^\"]*)\"")))
    throw Fail("{}: no program of lake-stroke with a design in it; write it again with lake-stroke", file.string());
  identity.design_hash = match[1];
  identity.program_hash = ProgramHash(text);
  if (!std::regex_search(text, match, std::regex("#define LAKE_PROGRAM \"([^\"]*)\"")) ||
      match[1] != identity.program_hash)
    throw Fail("{}: it is not as lake-stroke wrote it: write it again, and upload that sketch", file.string());
  static const std::regex unknown("// CANNOT KNOW: ([^\n]*)");
  for (std::sregex_iterator at(text.begin(), text.end(), unknown), end; at != end; ++at)
    identity.unknowns.push_back((*at)[1]);
  static const std::regex segment("\\{([0-9]+), -?[0-9]+, [0-9]+\\},");
  for (std::sregex_iterator at(text.begin(), text.end(), segment), end; at != end; ++at)
    identity.duration_s = std::stod((*at)[1]) / 1e3;
  return identity;
}

SessionResult RunSession(const SessionOptions& options, const SketchIdentity& sketch, const std::filesystem::path& log,
                         const std::function<void(const std::string&, double)>& poll) {
  LogFile file(log);
  Session session(options, file, poll);
  SessionResult result;
  try {
    session.Greet(sketch);
    session.WriteHeader();
    session.Ask(options.home ? "home" : "zero");
    if (options.home) result.homing_s = session.WaitForDone("homing", options.homing_s);
    if (options.task != SessionTask::kHome) {
      session.Ask("run");
      result.run_s = session.WaitForDone("the program", std::min(options.run_s, 2 * sketch.duration_s + 10));
      result.waited_s = session.Waited();
    }
  } catch (...) {
    session.Stop();
    throw;
  }
  result.rows = session.Rows();
  return result;
}

std::string AlarmText(int number) {
  static const std::vector<std::string> texts = {
      "an end stop in the direction of motion",
      "both end stops at once: their wires",
      "a limit was reached, of the program or of the linkage",
      "no end stop met while homing",
      "an end stop is pressed away from its place: its wire, or the motor turns the wrong way",
      "the motor's supply is off or outside its limits: emergency stop, or the sense wire",
      "the potentiometer reads what it cannot: wiper lost or shorted, or it contradicts home",
      "driven, it does not move: a stall, a frozen wiper, or no supply",
      "it moves against the drive: motor or potentiometer reversed",
      "it moves undriven, or much faster than driven",
      "too far from the plan, or too slow for it",
      "over-current: a short or a stall",
      "driven, it takes no current: motor, supply or sense wire",
      "a conversion or the main loop was late: the board, or a bug",
      "the bridge does not follow its commands: ENA's jumper, a wire, a shorted transistor",
      "the safety relay does not open",
      "the board's memory has changed by itself"};
  return NumberedText(texts, number, "a fault of a newer firmware");
}

std::string ErrorText(int number) {
  static const std::vector<std::string> texts = {"no such command",
                                                 "a number out of range",
                                                 "the line is too long",
                                                 "not in this state",
                                                 "it is not at the program's start",
                                                 "the firmware has no program",
                                                 "an end stop is pressed in that direction",
                                                 "a soft limit is reached in that direction",
                                                 "the line had no check sum, or a wrong one",
                                                 "nobody holds the button",
                                                 "homing has failed three times: mend it, then power off and on"};
  return NumberedText(texts, number, "a reply of a newer firmware");
}

std::string Framed(std::string_view text) {
  boost::crc_optimal<16, 0x1021, 0xFFFF, 0, true, true> crc;
  crc.process_bytes(text.data(), text.size());
  return fmt::format("{}*{:04X}", text, crc.checksum());
}

std::optional<std::string> Unframed(std::string_view line) {
  std::string text(line.substr(0, line.rfind('*')));
  if (Framed(text) != line) return std::nullopt;
  return text;
}

}  // namespace lake::actuator
