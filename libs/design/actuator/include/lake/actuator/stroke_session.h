// A run of the firmware watched from the host: it homes, runs, is kept from its time-out, and every row is in a log.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lake::actuator {

// What is done with the board, with nobody in the exoskeleton.
enum class SessionTask { kHomeAndRun, kHome };

struct SessionOptions {
  SessionTask task = SessionTask::kHomeAndRun;
  std::filesystem::path port;
  double keep_alive_s = 0.25;  // between two signs of life
  double greeting_s = 5;       // the UNO's boot loader takes 2
  double silent_s = 1.5;       // without a row from the firmware: it is given up, and stops by its own time-out
  double homing_s = 300;       // at most
  double run_s = 3600;         // at most
  bool acknowledge = false;    // a fault of before was seen to: else the board is refused
  bool home = true;            // else the actuator stands at the start already: zero
};

// What the firmware was made for, of the stroke_table.h in the folder of the sketch's results.
struct SketchIdentity {
  std::string design_hash, program_hash;  // the latter of the whole stroke_table.h
  double duration_s = 0;
  std::vector<std::string> unknowns;  // what it cannot know or do, a sentence each
};

// Throws Error if there is none, one that is no program, or one that was changed since lake-stroke wrote it.
SketchIdentity ReadSketchIdentity(const std::filesystem::path& folder);

struct SessionResult {
  std::size_t rows = 0;
  double homing_s = 0, run_s = 0;
  // Of these, for an actuator that had not the program's speed; none where the line that may tell it was damaged.
  std::optional<double> waited_s = 0;
};

// Homes and runs, or homes alone. A board that has been homed keeps that, since the line's end does not reset it (HUPCL
// is off).
// Writes the log's header first and to the disk: if that fails nothing has been sent and nothing moves. If a row cannot
// be written, `poll` throws (Ctrl-C), the firmware tells a fault or falls silent, the actuator is told to hold and to
// reset, and the error goes on. `poll` is called at least every 0.1 s with the state and the program's time so far, s.
// Throws Error: the log, the port, another program in the board than the folder's, a refused command, a fault with its
// meaning.
SessionResult RunSession(const SessionOptions& options, const SketchIdentity& sketch, const std::filesystem::path& log,
                         const std::function<void(const std::string& state, double time_s)>& poll);

struct TalkOptions {
  std::filesystem::path port;
  double keep_alive_s = 0.25;  // between two signs of life
};

// A terminal for the firmware, which obeys no line without a check sum. Each whole line that `in` has is sent with one
// (`?` and `!` as they are); what the firmware says goes to `out` and into the log without. At the end of `in`, and
// when `poll` throws, what moves is told to stop. `poll` is called at least every 0.1 s. Throws Error: the log, the
// port.
void RunTalk(const TalkOptions& options, int in, std::ostream& out, const std::filesystem::path& log,
             const std::function<void()>& poll);

// A line of the firmware with its check sum: `text*HHHH`, where HHHH is the CRC-16/MCRF4XX of the text (polynomial
// 0x1021 from the lowest bit on, from 0xFFFF) in hexadecimal digits. The firmware's end is in firmware/protocol.c.
std::string Framed(std::string_view text);
// The text of a line without its end; nothing if the check sum is missing or wrong.
std::optional<std::string> Unframed(std::string_view line);

// What ALARM:N and error:N mean.
std::string AlarmText(int number);
std::string ErrorText(int number);

}  // namespace lake::actuator
