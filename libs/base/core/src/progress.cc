#include "lake/core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "lake/core/uncertain_text.h"

namespace lake {
namespace {

using namespace std::chrono_literals;
constexpr auto kSilence = 500ms;           // steps shorter than this show nothing
constexpr auto kTerminalInterval = 100ms;  // a line that is rewritten
constexpr auto kPlainInterval = 2s;        // a line that stays

std::string FormatDuration(double seconds) {
  const auto whole = std::lround(std::min(seconds, 1e9));
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string what, std::string unit, std::optional<std::int64_t> total, bool quiet)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_shown_(start_) {}

Progress::~Progress() {
  if (shown_ && terminal_) std::fputs("\r\x1b[K", stderr);
}

void Progress::Advance(std::int64_t steps) {
  done_ += steps;
  if (quiet_) return;
  const auto now = Clock::now();
  if (now - start_ < kSilence) return;
  if (now - last_shown_ >= (terminal_ ? Clock::duration(kTerminalInterval) : Clock::duration(kPlainInterval)))
    Show(now);
}

void Progress::Show(Clock::time_point now) {
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = static_cast<double>(done_) / elapsed;
  std::string line = total_ ? fmt::format("{}: {}/{} {}", what_, done_, *total_, unit_)
                            : fmt::format("{}: {} {}", what_, done_, unit_);
  line += fmt::format(", {}/s", SignificantText(rate, 3));
  if (!note_.empty()) line += ", " + note_;
  if (total_ && *total_ > done_)
    line += fmt::format(", {} left", FormatDuration(static_cast<double>(*total_ - done_) / rate));
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\x1b[K" : "", line, terminal_ ? "" : "\n");
  std::fflush(stderr);
  last_shown_ = now;
  shown_ = true;
}

}  // namespace lake
