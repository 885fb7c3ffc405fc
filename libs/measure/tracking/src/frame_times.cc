#include "lake/tracking/frame_times.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/statistics.h"
#include "local_path.h"
#include "repeated_frames.h"
#include "time_jumps.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kBeside = 3;  // new frames on either side that a path goes through

// How late (negative: early) a new frame's time is, by the paths of all markers through its neighbours.
struct Lateness {
  double late_s = 0, explained_px2 = 0, off_px2 = 0;  // of what the markers are off their paths, squares
};

// nullopt where less than two markers are seen or all are slow.
std::optional<Lateness> LatenessOf(const motion::MarkerRecording& recording, const std::vector<std::size_t>& fresh,
                                   std::size_t at, double fresh_s) {
  constexpr int kDegree = 3;
  constexpr double kLeastPx = 3;  // root mean square way to the next frame
  const std::size_t i = fresh[at];
  double along = 0, speeds = 0;
  Lateness found;
  int seen = 0;
  for (const motion::MarkerTrack& marker : recording.markers) {
    LocalPath path(kDegree, recording.time_s[i]);
    std::size_t beside = 0;
    for (std::size_t k = at - kBeside; k <= at + kBeside; ++k) {
      if (k == at || !marker.samples[fresh[k]].IsKnown()) continue;
      path.Add(recording.time_s[fresh[k]], marker.samples[fresh[k]].position), ++beside;
    }
    if (!marker.samples[i].IsKnown() || beside + 1 < 2 * kBeside) continue;
    const PathPoint smooth = path.Fit();
    const Eigen::Vector2d off = marker.samples[i].position - smooth.position;
    along += off.dot(smooth.velocity), speeds += smooth.velocity.squaredNorm(), found.off_px2 += off.squaredNorm();
    ++seen;
  }
  if (seen < 2 || std::sqrt(speeds / seen) * fresh_s < kLeastPx) return std::nullopt;
  found.late_s = -along / speeds, found.explained_px2 = along * along / speeds;
  return found;
}

// Times that neither repetitions nor jumps explain: of frames taken at one rate, some left out and some repeated to
// make a second one, and a third. Then all markers are off their paths at once, by a common time.
void CheckTimes(const motion::MarkerRecording& recording, const std::vector<std::size_t>& fresh) {
  constexpr std::size_t kFewest = 20;  // frames in which the leg moves
  constexpr double kCommon = 0.6;      // of the squares; noise of four markers has 1/8 in common
  constexpr double kMost = 0.08;       // of the time between frames
  const double fresh_s = UsualInterval(recording, fresh);
  std::vector<double> late_s;
  double explained = 0, off = 0, most_s = 0;
  std::size_t worst = 0;
  for (std::size_t k = kBeside; k + kBeside < fresh.size(); ++k) {
    const double span_s = recording.time_s[fresh[k + kBeside]] - recording.time_s[fresh[k - kBeside]];
    if (span_s > 4 * kBeside * fresh_s) continue;
    const auto found = LatenessOf(recording, fresh, k, fresh_s);
    if (!found) continue;
    late_s.push_back(std::abs(found->late_s));
    explained += found->explained_px2, off += found->off_px2;
    if (late_s.back() > most_s) most_s = late_s.back(), worst = fresh[k];
  }
  if (late_s.size() < kFewest || explained < kCommon * off) return;
  const double typical_s = Median(std::move(late_s));
  if (typical_s < kMost * fresh_s) return;
  throw Fail(
      "the frames' times are not those at which they were taken: all markers are off their paths at once, as if by "
      "{:.1f} ms (median; {:.1f} ms in frame {}); record at a fixed frame rate, and track the camera's own file",
      1e3 * typical_s, 1e3 * most_s, recording.frame[worst]);
}

}  // namespace

FrameTimes CorrectFrameTimes(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording) {
  RepeatedFrames frames(known, recording);
  frames.FindStandstills();
  FrameTimes times;
  times.captured_hz = frames.TakeLowerRate();
  times.jumps = TakeTimeJumps(times.captured_hz > 0, frames, recording);
  CheckTimes(recording, frames.Fresh());
  times.repeated = frames.Remove();
  return times;
}

std::vector<std::string> Warnings(const FrameTimes& times, const std::vector<std::int64_t>& frame) {
  constexpr int kShown = 12;  // runs of frames
  const auto is_repeated = [&](std::size_t i) {
    return std::binary_search(times.repeated.begin(), times.repeated.end(), frame[i]);
  };
  std::vector<std::string> warnings;
  if (!times.repeated.empty())
    warnings.push_back(
        fmt::format("repeated frames ({} in all, the picture before them once more, no measurements): {}{}",
                    times.repeated.size(), FramesWhere(frame, is_repeated, kShown),
                    times.captured_hz > 0 ? fmt::format("; the recording was made with {:.4g} frames per second, at "
                                                        "whose times the motion is smooth: these times are used",
                                                        times.captured_hz)
                                          : "; more light or a fixed frame rate avoids them"));
  for (const TimeJump& jump : times.jumps)
    warnings.push_back(
        fmt::format("between frames {} and {} the motion took {:.4f} ± {:.4f} s where the time stamps say {:.4f} s: "
                    "{}; the times of all later frames are set {:.4f} s {}",
                    jump.before, jump.after, jump.moved_s, jump.sigma_s, jump.stamped_s,
                    jump.moved_s > jump.stamped_s ? "frames are missing" : "time stands still",
                    std::abs(jump.moved_s - jump.stamped_s), jump.moved_s > jump.stamped_s ? "later" : "earlier"));
  return warnings;
}

}  // namespace lake::tracking
