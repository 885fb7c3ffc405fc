#include "trial_json.h"

#include <functional>
#include <limits>

#include "column.h"
#include "lake/core/error.h"
#include "lake/gait/marker_measures.h"
#include "lake/review/problems.h"

namespace lake::review {
namespace {

using motion::MarkerSample;
using motion::SampleStatus;

// What is measured now, else what the last fit filled in.
const MarkerSample& Shown(const MarkerSample& measured, const MarkerSample* fitted) {
  const bool is_filled = fitted && fitted->status == SampleStatus::kFilled;
  return !measured.IsKnown() && is_filled ? *fitted : measured;
}

char StatusLetter(const MarkerSample& sample) {
  return sample.status == SampleStatus::kDetected ? 'd' : sample.status == SampleStatus::kFilled ? 'f' : 'm';
}

Json MarkerJson(const CorrectionBook& book, const motion::MarkerRecording& measured, std::size_t marker,
                const TrialFit* fit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const motion::MarkerTrack& track = measured.markers[marker];
  const motion::MarkerTrack* fitted = fit ? fit->tracks.Find(track.name) : nullptr;
  const motion::MarkerTrack* estimated = fit ? fit->estimates.Find(track.name) : nullptr;
  const auto shown = [&](std::size_t row) -> const MarkerSample& {
    return Shown(track.samples[row], fitted ? &fitted->samples[row] : nullptr);
  };
  const auto of_known = [&](const std::function<double(const MarkerSample&)>& value) {
    return Column(measured.Frames(), [&](std::size_t row) { return shown(row).IsKnown() ? value(shown(row)) : kNone; });
  };
  std::string status;
  Json corrected = Json::array();
  for (std::size_t row = 0; row < measured.Frames(); ++row) {
    status += StatusLetter(shown(row));
    if (book.IsCorrected(row, marker)) corrected.push_back(row);
  }
  const auto residual = [&](std::size_t row) {
    const MarkerSample& sample = track.samples[row];
    if (!sample.IsKnown() || !estimated || !estimated->samples[row].IsKnown()) return kNone;
    return (sample.position - estimated->samples[row].position).norm();
  };
  return {{"name", track.name},
          {"x", of_known([](const MarkerSample& sample) { return sample.position.x(); })},
          {"y", of_known([](const MarkerSample& sample) { return sample.position.y(); })},
          {"sigma", of_known([](const MarkerSample& sample) { return sample.sigma; })},
          {"status", status},
          {"corrected", corrected},
          {"residual", Column(measured.Frames(), residual)}};
}

// With those that a person moved in their places; where these do not suit what is found now, as found, and `warnings`
// say why, as they do of events that are uncertain.
Json EventsJson(const CorrectionBook& book, const gait::LegFitResult& leg, Json& warnings) {
  std::vector<motion::StsEvent> events = leg.events;
  try {
    events = motion::ApplyEventCorrections(book.Events(), leg.motion.frame, leg.motion.time_s, leg.events);
  } catch (const Error& error) {
    warnings.push_back(fmt::format("the moved events do not suit those found: {}", error.what()));
  }
  for (const std::string& sentence : gait::UncertainEvents(events)) warnings.push_back(sentence);
  Json list = Json::array();
  for (const motion::StsEvent& event : events)
    list.push_back({{"repetition", event.repetition},
                    {"event", ToString(event.kind)},
                    {"frame", event.frame},
                    {"moved", book.IsMoved(event.repetition, event.kind)}});
  return list;
}

Json LegJson(const CorrectionBook& book, const gait::LegFitResult& leg, Json& warnings) {
  const std::vector<motion::LegSample>& samples = leg.motion.samples;
  const auto column = [&](const std::function<double(const motion::LegSample&)>& value) {
    return Column(samples.size(), [&](std::size_t row) { return value(samples[row]); });
  };
  return {{"knee", column([](const motion::LegSample& s) { return s.knee_deg; })},
          {"knee_sigma", column([](const motion::LegSample& s) { return s.knee_sigma_deg; })},
          {"events", EventsJson(book, leg, warnings)}};
}

}  // namespace

Json TrialJson(const CorrectionBook& book, const TrialFit* fit, const std::vector<std::int64_t>& repeated) {
  const motion::MarkerRecording measured = book.Corrected();
  const gait::LegFitResult* leg = fit && fit->leg ? &*fit->leg : nullptr;
  Json markers = Json::array(), problems = Json::array(), warnings = fit ? Json(fit->warnings) : Json::array();
  for (std::size_t m = 0; m < measured.markers.size(); ++m) markers.push_back(MarkerJson(book, measured, m, fit));
  for (const Problem& problem : FindProblems(measured, leg, repeated))
    problems.push_back({{"kind", ToString(problem.kind)},
                        {"marker", problem.marker},
                        {"first", problem.first},
                        {"last", problem.last},
                        {"value", Rounded(problem.value)}});
  const Json leg_json = leg ? LegJson(book, *leg, warnings) : Json();
  return {{"frame", measured.frame},
          {"time_s", Column(measured.Frames(), [&](std::size_t row) { return measured.time_s[row]; })},
          {"markers", markers},
          {"leg", leg_json},
          {"warnings", warnings},
          {"problems", problems}};
}

Json CoursesJson(const motion::MarkerRecording& in_plane, const Json& asked) {
  std::vector<gait::MarkerMeasure> measures;
  measures.reserve(asked.size());
  for (const Json& one : asked) measures.push_back(gait::MeasureFrom(one));
  gait::CheckMarkers(measures, gait::MarkerNames(in_plane));
  Json courses = Json::array();
  for (const gait::MeasuredCourse& course : gait::MeasureMarkers(in_plane, measures))
    courses.push_back({{"measure", gait::MeasureJson(course.measure)},
                       {"unit", gait::UnitOf(course, in_plane.unit)},
                       {"value", Column(course.value.size(), [&](std::size_t row) { return course.value[row]; })},
                       {"sd", Column(course.sd.size(), [&](std::size_t row) { return course.sd[row]; })}});
  return courses;
}

}  // namespace lake::review
