#include "lake/review/trial_session.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <functional>
#include <limits>

#include "column.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/json.h"
#include "lake/core/statistics.h"
#include "lake/gait/marker_measures.h"
#include "lake/review/correction_book.h"
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

// `fit` is nullptr where there is none (yet).
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

// `asked` is a list of gait::MeasureFrom.
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

}  // namespace
TrialSession::TrialSession(CorrectionBook book, std::vector<std::int64_t> repeated, TrialWork work, Json about)
    : book_(std::move(book)),
      repeated_(std::move(repeated)),
      work_(std::move(work)),
      about_(std::move(about)),
      is_applied_(work_.is_applied()),
      thread_([this] { FitAgain(); }) {}

TrialSession::~TrialSession() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void TrialSession::FitAgain() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || fitted_ != revision_; });
    if (stop_) return;
    const std::int64_t revision = revision_;
    const motion::MarkerRecording corrected = book_.Corrected();
    lock.unlock();
    std::optional<TrialFit> fit;
    std::string failure;
    try {
      fit = work_.fit(corrected);
    } catch (const std::exception& error) {
      failure = FaultText(error);
    }
    lock.lock();
    fit_ = std::move(fit);
    fit_error_ = failure;
    fitted_ = revision;
  }
}

Json TrialSession::State() const {
  const std::lock_guard lock(mutex_);
  return StateNow();
}

Json TrialSession::StateNow() const {
  return {{"revision", revision_},       {"fitted", fitted_},           {"fit_error", fit_error_},
          {"can_undo", book_.CanUndo()}, {"can_redo", book_.CanRedo()}, {"corrections", book_.Count()},
          {"swaps", book_.Swaps()},      {"is_applied", is_applied_}};
}

std::string TrialSession::Trial() const {
  Json message;
  {
    const std::lock_guard lock(mutex_);
    message = TrialJson(book_, fit_ ? &*fit_ : nullptr, repeated_);
    message["state"] = StateNow();
  }
  message["about"] = about_;
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json TrialSession::Edit(const Json& edit) {
  const std::lock_guard lock(mutex_);
  CorrectionBook changed = book_;
  changed.Make(edit);
  if (edit.at("op") == "move_event") CheckEvents(changed);
  work_.save(changed);
  is_applied_ = work_.is_applied();
  book_ = std::move(changed);
  ++revision_;
  changed_.notify_all();
  return StateNow();
}

Json TrialSession::Measure(const Json& asked) const {
  motion::MarkerRecording in_plane;
  {
    const std::lock_guard lock(mutex_);
    if (!fit_) throw Error(fit_error_.empty() ? "the leg is being fitted; ask again" : fit_error_);
    in_plane = fit_->in_plane;
  }
  return CoursesJson(in_plane, asked);
}

void TrialSession::CheckEvents(const CorrectionBook& changed) const {
  if (!fit_ || !fit_->leg) throw Error("there is no leg, so there are no events to be moved");
  const motion::LegMotion& motion = fit_->leg->motion;
  motion::ApplyEventCorrections(changed.Events(), motion.frame, motion.time_s, fit_->leg->events);
}

std::optional<TrialSession::Measured> TrialSession::NearestMeasured(const std::string& marker,
                                                                    std::int64_t frame) const {
  const std::lock_guard lock(mutex_);
  const motion::MarkerRecording recording = book_.Corrected();
  const motion::MarkerTrack* track = recording.Find(marker);
  if (!track) throw Fail("there is no marker '{}'", marker);
  std::optional<Measured> nearest;
  for (std::size_t row = 0; row < recording.Frames(); ++row) {
    const std::int64_t there = recording.frame[row];
    if (there == frame || !track->samples[row].IsKnown()) continue;
    if (!nearest || std::abs(there - frame) < std::abs(nearest->frame - frame))
      nearest = Measured{there, track->samples[row]};
  }
  return nearest;
}

double TrialSession::UsualSigma(const std::string& marker) const {
  const std::lock_guard lock(mutex_);
  const motion::MarkerTrack* track = book_.Detected().Find(marker);
  if (!track) throw Fail("there is no marker '{}'", marker);
  std::vector<double> sigmas;
  for (const motion::MarkerSample& sample : track->samples)
    if (sample.IsKnown()) sigmas.push_back(sample.sigma);
  return sigmas.empty() ? 0 : Median(std::move(sigmas));
}

}  // namespace lake::review
