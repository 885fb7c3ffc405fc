#include "lake/cohort/motion_files.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"
#include "lake/core/statistics.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

struct Channel {
  std::string name, component, type, tracked_point, units, frame;
  std::vector<double> values;
};

std::string Tsv(const std::vector<std::string>& cells) {
  return fmt::format("{}\n", fmt::join(cells, "\t"));
}

std::string CellOf(double value) {
  return std::isfinite(value) ? FormatNumber(value) : "n/a";
}

void AddMarkers(const motion::MarkerRecording& markers, std::vector<Channel>& channels) {
  const std::string unit(motion::ToString(markers.unit));
  const std::string frame = markers.unit == motion::LengthUnit::kMm ? "plane" : "image";
  for (const motion::MarkerTrack& marker : markers.markers)
    for (const int axis : {0, 1}) {
      Channel channel{marker.name + (axis ? "_y" : "_x"), axis ? "y" : "x", "POS", marker.name, unit, frame, {}};
      for (const motion::MarkerSample& sample : marker.samples)
        channel.values.push_back(sample.IsKnown() ? sample.position[axis] : NAN);
      channels.push_back(std::move(channel));
    }
}

std::vector<Channel> ChannelsOf(const fs::path& trial) {
  const motion::LegMotion leg = motion::ReadKinematicsCsv(trial / "kinematics.csv");
  std::vector<Channel> channels = {{"time", "n/a", "LATENCY", "n/a", "s", "n/a", leg.time_s}};
  for (double& time : channels.front().values) time -= leg.time_s.front();
  Channel knee{"knee_angle", "n/a", "JNTANG", "knee", "deg", "n/a", {}};
  for (const motion::LegSample& sample : leg.samples) knee.values.push_back(sample.knee_deg);
  channels.push_back(std::move(knee));
  for (const char* table : {"trajectory.csv", "tracks.csv"}) {
    if (!fs::is_regular_file(trial / table)) continue;
    const motion::MarkerRecording markers = motion::ReadMarkerCsv(trial / table, motion::MarkerValues::kEstimated);
    if (markers.frame != leg.frame)
      throw Fail("{}: its frames are not those of kinematics.csv", (trial / table).string());
    AddMarkers(markers, channels);
    break;
  }
  return channels;
}

std::string MotionTsv(const std::vector<Channel>& channels) {
  std::string text;
  for (std::size_t i = 0; i < channels.front().values.size(); ++i) {
    std::vector<std::string> cells;
    for (const Channel& channel : channels) cells.push_back(CellOf(channel.values[i]));
    text += Tsv(cells);
  }
  return text;
}

std::string ChannelsTsv(const std::vector<Channel>& channels) {
  std::string text = Tsv({"name", "component", "type", "tracked_point", "units", "reference_frame"});
  for (const Channel& c : channels) text += Tsv({c.name, c.component, c.type, c.tracked_point, c.units, c.frame});
  return text;
}

Json ReferenceFrames() {
  return {{"reference_frame",
           {{"Description", "Frame of the positions, which lie in the sagittal plane"},
            {"Levels",
             {{"plane",
               {{"SpatialAxes", "RS_"}, {"Description", "x right in the picture, y up, mm; origin as calibrated"}}},
              {"image",
               {{"SpatialAxes", "RI_"},
                {"Description", "x right, y down, px; origin at the centre of the top left pixel"}}}}}}}};
}

Json Sidecar(const std::vector<Channel>& channels, const std::string& task) {
  const std::vector<double>& time_s = channels.front().values;
  const double duration_s = time_s.back() - time_s.front();
  Json sidecar = {{"TaskName", task},
                  {"TrackingSystemName", "lake"},
                  {"SoftwareVersions", std::string(Version())},
                  {"SamplingFrequency", 1 / MedianInterval(time_s)},
                  {"SamplingFrequencyEffective", static_cast<double>(time_s.size() - 1) / duration_s},
                  {"RecordingDuration", duration_s},
                  {"MissingValues", "n/a"},
                  {"MotionChannelCount", channels.size()}};
  std::size_t points = 0;
  for (const char* type : {"LATENCY", "POS", "JNTANG"}) {
    const auto count =
        std::count_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.type == type; });
    sidecar[fmt::format("{}ChannelCount", type)] = count;
    if (std::string_view(type) == "POS") points = static_cast<std::size_t>(count) / 2;
  }
  sidecar["TrackedPointsCount"] = points;
  return sidecar;
}

std::string EventsTsv(const std::vector<motion::StsEvent>& events, double start_s) {
  std::string text = Tsv({"onset", "duration", "trial_type", "repetition"});
  for (const motion::StsEvent& event : events)
    text += Tsv({FormatNumber(event.time_s - start_s), "0", std::string(motion::ToString(event.kind)),
                 std::to_string(event.repetition)});
  return text;
}

std::string StemOf(const MotionNames& names, const std::string& trial) {
  return fmt::format("{}_task-{}_tracksys-lake_acq-{}{}{}", names.person, names.task, trial,
                     names.run.empty() ? "" : "_", names.run);
}

constexpr std::array kEndings = {"_motion.tsv", "_motion.json", "_channels.tsv", "_channels.json", "_events.tsv"};
constexpr std::array kTrials = {"human", "exo"};

void WriteTrial(const fs::path& trial, const fs::path& stem, const std::string& task) {
  const auto with = [&](const char* ending) { return fs::path(stem.string() + ending); };
  const std::vector<Channel> channels = ChannelsOf(trial);
  if (channels.front().values.size() < 2) throw Fail("{}: fewer than two frames", trial.string());
  WriteTextFile(with("_channels.tsv"), ChannelsTsv(channels));
  WriteJsonFile(with("_channels.json"), ReferenceFrames());
  WriteJsonFile(with("_motion.json"), Sidecar(channels, task));
  const double start_s = motion::ReadKinematicsCsv(trial / "kinematics.csv").time_s.front();
  WriteTextFile(with("_events.tsv"), EventsTsv(motion::ReadEventsCsv(trial / "events.csv"), start_s));
  WriteTextFile(with("_motion.tsv"), MotionTsv(channels));
}

}  // namespace

void WriteMotionFiles(const fs::path& study, const MotionNames& names, const fs::path& motion) {
  fs::create_directories(motion);
  for (const char* trial : kTrials) {
    const fs::path stem = motion / StemOf(names, trial);
    for (const char* ending : kEndings) fs::remove(stem.string() + ending);
    if (fs::is_regular_file(study / trial / "kinematics.csv")) WriteTrial(study / trial, stem, names.task);
  }
}

bool HasMotionFiles(const fs::path& study, const MotionNames& names, const fs::path& motion) {
  return std::ranges::all_of(kTrials, [&](const char* trial) {
    return !fs::is_regular_file(study / trial / "kinematics.csv") ||
           fs::is_regular_file(motion / (StemOf(names, trial) + "_motion.tsv"));  // which is written last
  });
}

}  // namespace lake::cohort
