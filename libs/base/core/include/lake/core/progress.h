// Progress of one long step on stderr: done/total, rate, a note if there is one, and time left. On a terminal one line
// that is rewritten, elsewhere a plain line every few seconds. Silent for steps under half a second. Safe to call from
// one thread at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace lake {

class Progress {
 public:
  // `total` may be unknown. `quiet` shows nothing.
  Progress(std::string what, std::string unit, std::optional<std::int64_t> total, bool quiet);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  void Advance(std::int64_t steps = 1);
  // What else is known by now: "bound 151.2°".
  void Note(std::string note) { note_ = std::move(note); }

 private:
  using Clock = std::chrono::steady_clock;
  void Show(Clock::time_point now);

  std::string what_, unit_, note_;
  std::optional<std::int64_t> total_;
  bool quiet_, terminal_, shown_ = false;
  std::int64_t done_ = 0;
  Clock::time_point start_, last_shown_;
};

}  // namespace lake
