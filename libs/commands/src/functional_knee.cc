#include "lake/commands/functional_knee.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "lake/gait/learnt_knee.h"

namespace lake::commands {
namespace {

void SetSegments(const OptionTexts& texts, const std::string& said, axis::SegmentMarkers& segments) {
  gait::TechnicalMarkers markers = gait::ParseSegmentMarkers(texts, said);
  segments = {markers["shank"], markers["thigh"]};
}

// Under the names that they have in the file, mm.
exchange::PointRecording PointsOf(const exchange::TrialOptions& reading, const exchange::Trial& trial) {
  if (trial.recording.unit != motion::LengthUnit::kMm)
    throw Fail(
        "{}: its lengths are in px; --knee functional needs mm: give the folder that lake gait with --camera (with a "
        "plane) or --scale writes of it",
        trial.file.string());
  const exchange::PointRecording points = reading.names.empty() && !trial.plane_from_space
                                              ? exchange::PointsFromMarkers(trial.recording)
                                              : exchange::ReadPoints(trial.file, reading.Reading());
  return exchange::PointsInPlane(points);
}

bool HasAny(const exchange::PointRecording& points, const axis::SegmentMarkers& segments) {
  const auto has = [&](const std::string& name) { return points.Find(name) != nullptr; };
  return std::ranges::any_of(segments.shank, has) || std::ranges::any_of(segments.thigh, has);
}

// How precisely the middle of where both segments carry the axis is known in a frame, mm, by what the shapes show.
double FrameSigma(const axis::SegmentMotion& motion, const axis::MeanAxis& mean) {
  return std::hypot(motion.shank.PointSdMm(mean.in_shank.norm()), motion.thigh.PointSdMm(mean.in_thigh.norm())) / 2;
}

}  // namespace

Option& DescribeSegments(const std::string& name, axis::SegmentMarkers& segments, const std::string& help,
                         OptionList& options) {
  return options
      .AddCustom(
          name, help,
          [&segments](const OptionTexts& texts, const std::string& said) { SetSegments(texts, said, segments); },
          [&segments] {
            return segments.shank.empty() ? std::string()
                                          : fmt::format("shank={} thigh={}", fmt::join(segments.shank, ","),
                                                        fmt::join(segments.thigh, ","));
          })
      .Value("shank=A,B or thigh=C,D")
      .Repeats();
}

void Describe(KneeOptions& o, OptionList& options) {
  options.AddChoice(
      "knee", o.knee,
      OptionList::Choices<KneeFrom>{{"marker", KneeFrom::kMarker}, {"functional", KneeFrom::kFunctional}},
      "The knee's marker, or the centre about which the markers of --segment turn, in each trial that shows them");
  DescribeSegments("segment", o.segments,
                   "With --knee functional: markers of the shank, and of the thigh, by their names in the files; two "
                   "or more of each, of 3-D files three or more",
                   options)
      .Otherwise("none");
  DescribeSegments("exo-segment", o.exo_segments,
                   "With --knee functional: markers on the exoskeleton's parts at shank and thigh, likewise, for its "
                   "joint",
                   options)
      .Otherwise("its joint's marker");
  Describe(o.movement, options);
  options.Check([&o](const OptionList&) {
    for (const auto& [segments, name] :
         {std::pair{&o.segments, "--segment"}, std::pair{&o.exo_segments, "--exo-segment"}}) {
      if (segments->shank.empty() != segments->thigh.empty())
        throw UsageError("{0}: no marker of the {1} is given: add {0} {1}=MARKER,MARKER", name,
                         segments->shank.empty() ? "shank" : "thigh");
      if (o.knee == KneeFrom::kMarker && !segments->shank.empty())
        throw UsageError("{} is for --knee functional: give that too, or omit it", name);
    }
  });
}

std::optional<double> PutAxis(const axis::SegmentMarkers& segments, const std::string& marker,
                              const exchange::TrialOptions& reading, exchange::Trial& trial, Run& run) {
  if (segments.shank.empty())
    throw UsageError(
        "--knee functional: say which markers are on shank and thigh, --segment shank=A,B --segment thigh=C,D");
  const exchange::PointRecording points = PointsOf(reading, trial);
  if (!HasAny(points, segments)) {
    run.Warn("{}: it has none of the markers {}, {}: its marker {} is taken", trial.file.string(),
             fmt::join(segments.shank, ", "), fmt::join(segments.thigh, ", "), marker);
    return std::nullopt;
  }
  const auto found = std::ranges::find(trial.recording.markers, marker, &motion::MarkerTrack::name);
  motion::MarkerTrack& track = found != trial.recording.markers.end()
                                   ? *found
                                   : trial.recording.markers.emplace_back(motion::MarkerTrack{marker, {}});
  track.samples.assign(trial.recording.Frames(), {});
  constexpr double kLeastTurn_deg = 10;
  const auto fit = [&]() -> std::pair<axis::SegmentMotion, axis::MeanAxis> {
    try {
      axis::SegmentMotion motion = axis::MotionOf(points, segments);
      axis::MeanAxis mean = axis::MeanAxes(motion, 0, kLeastTurn_deg).whole;
      return {std::move(motion), mean};
    } catch (const UsageError&) {
      throw;
    } catch (const Error& error) {
      throw Fail("{}: {}", trial.file.string(), error.what());
    }
  };
  const auto [motion, mean] = fit();
  const double sigma_mm = trial.known_sigmas ? FrameSigma(motion, mean) : 0;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const axis::Pose &shank = motion.shank.poses[i], &thigh = motion.thigh.poses[i];
    if (!shank.IsSeen() || !thigh.IsSeen()) continue;
    const Eigen::Vector3d in_file =
        (shank.turn * mean.in_shank + shank.origin + thigh.turn * mean.in_thigh + thigh.origin) / 2;
    const Eigen::Vector3d in_plane = trial.plane_from_space ? *trial.plane_from_space * in_file : in_file;
    track.samples[i] = {in_plane.head<2>(), sigma_mm, motion::SampleStatus::kDetected};
  }
  return mean.sd_mm;
}

}  // namespace lake::commands
