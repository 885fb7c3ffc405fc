#include "lake/gait/marker_measures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/nearest_name.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/dynamics/path_smoother.h"
#include "noise_from_differences.h"

namespace lake::gait {
namespace {

using Eigen::Vector2d;

struct MeasureKind {
  MarkerMeasure::Kind kind;
  const char* option;
  std::size_t markers;
  const char* value;
  const char* help;
};
constexpr MeasureKind kMeasureKinds[] = {
    {MarkerMeasure::Kind::kAngle, "angle", 3, "NAME=A,B,C", "Also measure the angle at marker B between A and C"},
    {MarkerMeasure::Kind::kDistance, "distance", 2, "NAME=A,B", "Also measure the distance of two markers"},
    {MarkerMeasure::Kind::kSpeed, "speed", 1, "NAME=A", "Also measure a marker's speed"}};

void SetMeasures(const OptionTexts& texts, const std::string& said, const MeasureKind& kind,
                 std::vector<MarkerMeasure>& measures) {
  std::erase_if(measures, [&](const MarkerMeasure& measure) { return measure.kind == kind.kind; });
  for (const auto& [name, markers] : NamesAndValues(texts, said)) {
    MarkerMeasure measure{kind.kind, name, SplitText(markers, ',')};
    if (measure.markers.size() != kind.markers || std::ranges::count(measure.markers, ""))
      throw UsageError("{} '{}={}': give {}", said, name, markers, kind.value);
    measures.push_back(std::move(measure));
  }
}

const MeasureKind& RowOf(MarkerMeasure::Kind kind) {
  return *std::ranges::find(kMeasureKinds, kind, &MeasureKind::kind);
}

std::string MeasuresText(const std::vector<MarkerMeasure>& measures, MarkerMeasure::Kind kind) {
  std::string text;
  for (const MarkerMeasure& measure : measures)
    if (measure.kind == kind)
      text += fmt::format("{}{}={}", text.empty() ? "" : " ", measure.name, fmt::join(measure.markers, ","));
  return text;
}

// A marker in one frame: where it is and how fast, each axis with this SD.
struct Moving {
  Vector2d position = Vector2d::Constant(kNaN), velocity = position;
  double sd = kNaN, speed_sd = kNaN;
};

std::vector<Moving> SmoothPathOf(const motion::MarkerRecording& recording, const motion::MarkerTrack& track) {
  const std::size_t n = recording.Frames();
  std::vector<Moving> path(n);
  std::vector<char> seen(n);
  for (std::size_t i = 0; i < n; ++i) seen[i] = track.samples[i].status == motion::SampleStatus::kDetected;
  constexpr std::ptrdiff_t kLeastSamples = 8;
  if (std::ranges::count(seen, 1) < kLeastSamples) return path;
  const double noise = NoiseFromDifferences(track, seen);
  dynamics::SeenPath places = dynamics::UnseenPath(2, recording.time_s);
  for (std::size_t i = 0; i < n; ++i)
    if (const motion::MarkerSample& sample = track.samples[i]; seen[i])
      places.See(i, sample.position, sample.sigma > 0 ? sample.sigma : noise);
  const dynamics::SmoothedPath smooth = dynamics::LearnAndSmooth(places, dynamics::PersonPrior(1), {});
  for (std::size_t i = 0; i < n; ++i) {
    if (!seen[i]) continue;
    const dynamics::PathPoint& point = smooth.point[i];
    path[i] = {point.position.head<2>(), point.velocity.head<2>(), std::sqrt(point.position_covariance(0, 0)),
               std::sqrt(point.velocity_variance)};
  }
  return path;
}

struct MeasuredNow {
  double value = kNaN, sd = kNaN, rate = kNaN, rate_sd = kNaN;
};

// The angle at b, from the directions of the two arms u and v; what turns an arm is what moves its ends across it.
MeasuredNow MeasuredAngle(const Moving& a, const Moving& b, const Moving& c) {
  const Vector2d u = a.position - b.position, v = c.position - b.position;
  const double angle = std::atan2(Cross(u, v), u.dot(v)), sign = angle < 0 ? -1 : 1;
  const Vector2d across_u = Vector2d(-u.y(), u.x()) / u.squaredNorm(),
                 across_v = Vector2d(-v.y(), v.x()) / v.squaredNorm();
  const auto sd = [&](double Moving::*of) {
    return DegreesFromRadians(
        std::hypot(across_u.norm() * a.*of, across_v.norm() * c.*of, (across_v - across_u).norm() * b.*of));
  };
  const double turning = across_v.dot(c.velocity - b.velocity) - across_u.dot(a.velocity - b.velocity);
  return {DegreesFromRadians(std::abs(angle)), sd(&Moving::sd), DegreesFromRadians(sign * turning),
          sd(&Moving::speed_sd)};
}

MeasuredNow MeasuredDistance(const Moving& a, const Moving& b) {
  const Vector2d between = b.position - a.position;
  const double distance = between.norm();
  return {distance, std::hypot(a.sd, b.sd), between.dot(b.velocity - a.velocity) / distance,
          std::hypot(a.speed_sd, b.speed_sd)};
}

MeasuredNow MeasuredSpeed(const Moving& a) {
  return {a.velocity.norm(), a.speed_sd};
}

bool HasRate(const MarkerMeasure& measure) {
  return measure.kind != MarkerMeasure::Kind::kSpeed;
}

}  // namespace

void Describe(std::vector<MarkerMeasure>& measures, OptionList& options) {
  for (const MeasureKind& kind : kMeasureKinds)
    options
        .AddCustom(
            kind.option, kind.help,
            [&measures, &kind](const OptionTexts& texts, const std::string& said) {
              SetMeasures(texts, said, kind, measures);
            },
            [&measures, &kind] { return MeasuresText(measures, kind.kind); })
        .Value(kind.value)
        .Repeats();
  options.Check([&measures](const OptionList&) {
    std::set<std::string> names;
    for (const MarkerMeasure& measure : measures)
      if (!names.insert(measure.name).second)
        throw UsageError("--angle, --distance, --speed: two are called '{}'", measure.name);
  });
}

const char* ToString(MarkerMeasure::Kind kind) {
  return RowOf(kind).option;
}

MarkerMeasure MeasureFrom(const Json& json) {
  const auto said = json.at("kind").get<std::string>();
  const auto* kind = std::ranges::find_if(kMeasureKinds, [&](const MeasureKind& one) { return said == one.option; });
  if (kind == std::end(kMeasureKinds)) throw UsageError("measures are angles, distances and speeds, not '{}'", said);
  MarkerMeasure measure{.kind = kind->kind, .name = json.at("name"), .markers = json.at("markers")};
  if (measure.name.empty()) throw UsageError("the {} has no name", said);
  if (measure.markers.size() != kind->markers)
    throw UsageError("{} '{}' is of {} markers: {}", said, measure.name, kind->markers, kind->value);
  return measure;
}

Json MeasureJson(const MarkerMeasure& measure) {
  return {{"kind", ToString(measure.kind)}, {"name", measure.name}, {"markers", measure.markers}};
}

std::vector<MarkerMeasure> UsualMeasures(const std::vector<std::string>& markers) {
  std::vector<MarkerMeasure> measures;
  for (const MeasureKind& kind : kMeasureKinds)
    for (std::size_t i = 0; i + kind.markers <= markers.size(); ++i) {
      const std::vector<std::string> of(markers.begin() + static_cast<std::ptrdiff_t>(i),
                                        markers.begin() + static_cast<std::ptrdiff_t>(i + kind.markers));
      measures.push_back({kind.kind, fmt::format("{}_{}", kind.option, fmt::join(of, "_")), of});
    }
  return measures;
}

std::vector<std::string> MarkerNames(const motion::MarkerRecording& recording) {
  std::vector<std::string> names;
  for (const motion::MarkerTrack& track : recording.markers) names.push_back(track.name);
  return names;
}

void CheckMarkers(const std::vector<MarkerMeasure>& measures, const std::vector<std::string>& markers) {
  for (const MarkerMeasure& measure : measures)
    for (const std::string& marker : measure.markers)
      if (std::ranges::count(markers, marker) == 0)
        throw UsageError("'{}': there is no marker '{}'{}; there are {}", measure.name, marker,
                         DidYouMean(marker, markers), fmt::join(markers, ", "));
}

motion::MarkerRecording InPlane(const motion::MarkerRecording& recorded, const LegView& view) {
  motion::MarkerRecording in_plane = recorded;
  in_plane.unit = PlaneUnit(view);
  for (motion::MarkerTrack& marker : in_plane.markers)
    for (motion::MarkerSample& sample : marker.samples) {
      if (!sample.IsKnown()) continue;
      const double depth = view.Depth(marker.name);
      sample.position = PlaneFromRecorded(view, sample.position, depth);
      sample.sigma *= PlaneUnitsPerRecorded(view, sample.position, depth);
    }
  return in_plane;
}

std::vector<MeasuredCourse> MeasureMarkers(const motion::MarkerRecording& recording,
                                           const std::vector<MarkerMeasure>& measures) {
  CheckMarkers(measures, MarkerNames(recording));
  std::map<std::string, std::vector<Moving>> paths;
  for (const MarkerMeasure& measure : measures)
    for (const std::string& marker : measure.markers)
      if (!paths.contains(marker)) paths[marker] = SmoothPathOf(recording, *recording.Find(marker));
  std::vector<MeasuredCourse> courses;
  for (const MarkerMeasure& measure : measures) {
    MeasuredCourse& course = courses.emplace_back(MeasuredCourse{.measure = measure});
    for (std::size_t i = 0; i < recording.Frames(); ++i) {
      const auto at = [&](std::size_t k) -> const Moving& { return paths[measure.markers[k]][i]; };
      const MeasuredNow of = measure.kind == MarkerMeasure::Kind::kAngle      ? MeasuredAngle(at(0), at(1), at(2))
                             : measure.kind == MarkerMeasure::Kind::kDistance ? MeasuredDistance(at(0), at(1))
                                                                              : MeasuredSpeed(at(0));
      course.value.push_back(of.value);
      course.sd.push_back(of.sd);
      if (!HasRate(measure)) continue;
      course.rate.push_back(of.rate);
      course.rate_sd.push_back(of.rate_sd);
    }
  }
  return courses;
}

std::string UnitOf(const MeasuredCourse& course, motion::LengthUnit unit) {
  return course.measure.kind == MarkerMeasure::Kind::kAngle
             ? "deg"
             : fmt::format("{}{}", ToString(unit), course.measure.kind == MarkerMeasure::Kind::kSpeed ? "_s" : "");
}

std::string UnitForPeople(const std::string& unit_of_column) {
  if (unit_of_column == "deg") return "°";
  if (!unit_of_column.ends_with("_s")) return unit_of_column;
  return unit_of_column.substr(0, unit_of_column.size() - 2) + "/s";
}

void WriteMeasuresCsv(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::vector<MeasuredCourse>& courses) {
  std::vector<std::string> header{"frame", "time_s"};
  for (const MeasuredCourse& course : courses) {
    const std::string name = course.measure.name, unit = UnitOf(course, recording.unit);
    for (const char* per : {"", "_s"})
      if (*per == 0 || HasRate(course.measure)) {
        header.push_back(fmt::format("{}_{}{}", name, unit, per));
        header.push_back(fmt::format("{}_sd_{}{}", name, unit, per));
      }
  }
  CsvWriter csv(header);
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    csv.Add(recording.frame[i]).Add(recording.time_s[i]);
    for (const MeasuredCourse& course : courses) {
      csv.Add(course.value[i]).Add(course.sd[i]);
      if (HasRate(course.measure)) csv.Add(course.rate[i]).Add(course.rate_sd[i]);
    }
    csv.EndRow();
  }
  csv.Write(path);
}

Json MeasuresJson(const motion::MarkerRecording& recording, const std::vector<MeasuredCourse>& courses) {
  Json json = Json::object();
  for (const MeasuredCourse& course : courses) {
    std::vector<double> known;
    std::size_t least = 0, most = 0;
    for (std::size_t i = 0; i < course.value.size(); ++i) {
      const double value = course.value[i];
      if (!std::isfinite(value)) continue;
      if (known.empty() || value < course.value[least]) least = i;
      if (known.empty() || value > course.value[most]) most = i;
      known.push_back(value);
    }
    if (known.empty()) {
      json[course.measure.name] = nullptr;
      continue;
    }
    const auto extreme = [&](std::size_t i) {
      return Json{{"value", course.value[i]}, {"sd", course.sd[i]}, {"time_s", recording.time_s[i]}};
    };
    json[course.measure.name] = {{"unit", UnitOf(course, recording.unit)},
                                 {"markers", course.measure.markers},
                                 {"frames", known.size()},
                                 {"mean", Mean(known)},
                                 {"smallest", extreme(least)},
                                 {"largest", extreme(most)}};
  }
  return json;
}

}  // namespace lake::gait
