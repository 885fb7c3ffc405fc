#include "lake/synth/motion_file.h"

#include <algorithm>

#include "lake/core/error.h"

namespace lake::synth {
namespace {

using exchange::Trial;
using motion::MarkerTrack;

struct Rows {
  std::size_t first = 0, end = 0;
};

Rows RowsOf(const MotionFile& motion, const std::vector<double>& time_s, double duration_s) {
  constexpr double kRounding_s = 1e-9;
  const double begin = time_s.empty() ? 0 : time_s.front() + motion.begin_s;
  const auto first = std::ranges::lower_bound(time_s, begin - kRounding_s);
  auto last = std::ranges::lower_bound(time_s, begin + duration_s - kRounding_s);
  if (duration_s == 0 || last == time_s.end()) last = time_s.end() - !time_s.empty();
  if (last - first < 2)
    throw Fail("{}: too little is left to show from {:g} s on: it lasts {:.2f} s", motion.file.string(), motion.begin_s,
               time_s.empty() ? 0 : time_s.back() - time_s.front());
  return {static_cast<std::size_t>(first - time_s.begin()), static_cast<std::size_t>(last - time_s.begin()) + 1};
}

bool AllAreKnown(const Trial& trial, std::size_t row) {
  return std::ranges::all_of(trial.recording.markers,
                             [&](const MarkerTrack& marker) { return marker.samples[row].IsKnown(); });
}

// With what the file has before and after, as the first and the last exposure reach beyond the frames' times.
Rows WithWhatIsAround(const Rows& rows, const Trial& trial) {
  constexpr double kReach_s = 0.1;  // and to the row beyond
  const std::vector<double>& time_s = trial.recording.time_s;
  Rows around = rows;
  while (around.first > 0 && time_s[around.first] > time_s[rows.first] - kReach_s &&
         AllAreKnown(trial, around.first - 1))
    --around.first;
  while (around.end < time_s.size() && time_s[around.end - 1] < time_s[rows.end - 1] + kReach_s &&
         AllAreKnown(trial, around.end))
    ++around.end;
  return around;
}

// Of a 3-D file, how far the marker is to the right of the middle of the leg; of a plane, 0.
double Across(const Trial& trial, const std::string& marker, std::size_t row) {
  const auto lateral = trial.lateral_mm.find(marker);
  return lateral == trial.lateral_mm.end() ? 0 : lateral->second[row];
}

double MiddleOfLeg(const Trial& trial, const Rows& rows) {
  double sum = 0;
  int count = 0;
  for (const char* name : {"ankle", "knee", "hip"})
    for (std::size_t row = rows.first; trial.recording.Find(name) && row < rows.end; ++row, ++count)
      sum += Across(trial, name, row);
  return count > 0 ? sum / count : 0;
}

// The camera goes to the other side.
void TurnAround(MotionTable& table) {
  for (auto& path : table.positions)
    for (Eigen::Vector2d& place : path) place.x() = -place.x();
  for (auto& path : table.depth_mm)
    for (double& depth : path) depth = -depth;
}

}  // namespace

MotionTable ReadMotionFile(const MotionFile& motion, double duration_s) {
  exchange::TrialOptions reading = motion.reading;
  for (const std::string& extra : motion.extra_markers) reading.names.emplace(extra, extra);
  exchange::CheckNoneIsUnused(motion.file, exchange::UnusedOptions(motion.file, reading));
  const Trial trial = exchange::ReadTrial(motion.file, reading);
  if (trial.recording.unit != motion::LengthUnit::kMm)
    throw Fail("{}: is in px; a motion to show is in mm", trial.file.string());
  const Rows rows = RowsOf(motion, trial.recording.time_s, duration_s);
  const double middle = MiddleOfLeg(trial, rows);
  const auto& times = trial.recording.time_s;
  for (const MarkerTrack& marker : trial.recording.markers)
    for (std::size_t row = rows.first; row < rows.end; ++row)
      if (!marker.samples[row].IsKnown())
        throw Fail("{}: marker '{}' is missing at {:.2f} s; show another part, or go without it", trial.file.string(),
                   marker.name, times[row]);
  const Rows around = WithWhatIsAround(rows, trial);
  MotionTable table;
  table.time_s.assign(times.begin() + static_cast<std::ptrdiff_t>(around.first),
                      times.begin() + static_cast<std::ptrdiff_t>(around.end));
  table.before_s = times[rows.first] - times[around.first];
  table.after_s = times[around.end - 1] - times[rows.end - 1];
  for (const MarkerTrack& marker : trial.recording.markers) {
    table.names.push_back(marker.name);
    auto& places = table.positions.emplace_back();
    auto& depths = table.depth_mm.emplace_back();
    for (std::size_t row = around.first; row < around.end; ++row) {
      places.push_back(marker.samples[row].position);
      depths.push_back(Across(trial, marker.name, row) - middle);
    }
  }
  const bool faces_right = trial.faces_right ? *trial.faces_right : FacingOf(table) == motion::Facing::kRight;
  if (faces_right != (motion.facing == motion::Facing::kRight)) TurnAround(table);
  return table;
}

}  // namespace lake::synth
