#include "lake/review/correction_book.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "whole_number.h"

namespace lake::review {
namespace {

using motion::MarkerSample;
using motion::SampleStatus;

bool IsSame(const MarkerSample& a, const MarkerSample& b) {
  if (a.IsKnown() != b.IsKnown()) return false;
  return !a.IsKnown() || (a.position == b.position && a.sigma == b.sigma);
}

bool IsSame(const motion::EventCorrection& a, const motion::EventCorrection& b) {
  return a.frame == b.frame && a.time_s == b.time_s;
}

template <typename T>
bool IsSame(const std::optional<T>& a, const std::optional<T>& b) {
  return a.has_value() == b.has_value() && (!a || IsSame(*a, *b));
}

// Of two maps: the same keys, and the same under each.
template <typename Map>
bool AreSame(const Map& a, const Map& b) {
  return std::ranges::equal(a, b, [](const auto& one, const auto& other) {
    return one.first == other.first && IsSame(one.second, other.second);
  });
}

motion::StsEventKind EventKind(const std::string& name) {
  const std::optional<motion::StsEventKind> kind = motion::FindEventKind(name);
  if (!kind) throw Fail("'{}' is not an event", name);
  return *kind;
}

Json EventJson(const motion::EventCorrection& event) {
  return {{"repetition", event.repetition},
          {"event", motion::ToString(event.kind)},
          {"frame", ValueOrNull(event.frame)},
          {"time_s", ValueOrNull(event.time_s)}};
}

motion::EventCorrection EventFrom(const Json& json) {
  const auto repetition = static_cast<int>(WholeNumber(json.at("repetition")));
  motion::EventCorrection event{repetition, EventKind(json.at("event")), {}, {}, {}, motion::LegSample::kUnknown, true};
  if (!json.at("frame").is_null()) event.frame = WholeNumber(json.at("frame"));
  if (!json.at("time_s").is_null()) event.time_s = json.at("time_s").get<double>();
  return event;
}

}  // namespace

CorrectionBook::CorrectionBook(motion::MarkerRecording detected, int width, int height,
                               std::vector<std::int64_t> repeated, const std::vector<motion::Correction>& made,
                               const std::vector<motion::EventCorrection>& events)
    : detected_(motion::Measurements(std::move(detected))),
      width_(width),
      height_(height),
      repeated_(std::move(repeated)) {
  for (const motion::Correction& correction : made) {
    const Cell cell{Row(correction.frame), Marker(correction.marker)};
    Set(cell, ChangeTo(cell, correction.sample).after);
  }
  motion::CheckAreInside(events, detected_.frame, detected_.time_s);
  for (const motion::EventCorrection& event : events) events_[{event.repetition, event.kind}] = event;
  base_ = Corrections();
  base_events_ = Events();
}

std::size_t CorrectionBook::Row(std::int64_t frame) const {
  const auto found = std::lower_bound(detected_.frame.begin(), detected_.frame.end(), frame);
  if (found == detected_.frame.end() || *found != frame)
    throw Fail("frame {} is not among those that were tracked, {} to {}", frame, detected_.frame.front(),
               detected_.frame.back());
  return static_cast<std::size_t>(found - detected_.frame.begin());
}

std::size_t CorrectionBook::Marker(const std::string& name) const {
  const motion::MarkerTrack* marker = detected_.Find(name);
  if (!marker) throw Fail("there is no marker '{}'", name);
  return static_cast<std::size_t>(marker - detected_.markers.data());
}

const MarkerSample& CorrectionBook::Now(Cell cell) const {
  const auto made = made_.find(cell);
  return made != made_.end() ? made->second : detected_.markers[cell.second].samples[cell.first];
}

CorrectionBook::Change CorrectionBook::ChangeTo(Cell cell, const MarkerSample& sample) const {
  const auto made = made_.find(cell);
  Change change{cell, {}, {}};
  if (made != made_.end()) change.before = made->second;
  if (!IsSame(sample, detected_.markers[cell.second].samples[cell.first])) change.after = sample;
  return change;
}

void CorrectionBook::Set(Cell cell, const std::optional<MarkerSample>& sample) {
  if (sample)
    made_[cell] = *sample;
  else
    made_.erase(cell);
}

void CorrectionBook::SetEvent(EventKey key, const std::optional<motion::EventCorrection>& event) {
  if (event)
    events_[key] = *event;
  else
    events_.erase(key);
}

void CorrectionBook::Do(std::vector<Change> cells, Json edit) {
  std::erase_if(cells, [](const Change& change) { return IsSame(change.before, change.after); });
  if (cells.empty()) throw Error("that changes nothing");
  for (const Change& change : cells) Set(change.cell, change.after);
  Append({std::move(cells), {}}, std::move(edit));
}

void CorrectionBook::DoEvent(EventKey key, const std::optional<motion::EventCorrection>& after, Json edit) {
  const auto made = events_.find(key);
  EventChange change{key, {}, after};
  if (made != events_.end()) change.before = made->second;
  if (IsSame(change.before, change.after)) throw Error("that changes nothing");
  SetEvent(key, after);
  Append({{}, std::move(change)}, std::move(edit));
}

void CorrectionBook::Append(Step step, Json edit) {
  steps_.resize(done_);
  steps_.push_back(std::move(step));
  edits_.erase(edits_.begin() + static_cast<std::ptrdiff_t>(done_), edits_.end());
  edits_.push_back(std::move(edit));
  ++done_;
}

void CorrectionBook::Place(std::int64_t frame, const std::string& marker, const Eigen::Vector2d& px, double sigma_px) {
  const Cell cell{Row(frame), Marker(marker)};
  if (std::binary_search(repeated_.begin(), repeated_.end(), frame))
    throw Fail("frame {} repeats the picture before it and is no measurement; correct that one instead", frame);
  if (!px.allFinite() || !(sigma_px > 0) || !std::isfinite(sigma_px))
    throw Fail("marker '{}', frame {}: that is no place", marker, frame);
  if (px.x() < 0 || px.y() < 0 || px.x() > width_ - 1 || px.y() > height_ - 1)
    throw Fail("marker '{}', frame {}: ({:.1f}, {:.1f}) is outside the picture of {}x{} px", marker, frame, px.x(),
               px.y(), width_, height_);
  Do({ChangeTo(cell, {px, sigma_px, SampleStatus::kDetected})},
     {{"op", "place"}, {"frame", frame}, {"marker", marker}, {"x", px.x()}, {"y", px.y()}, {"sigma", sigma_px}});
}

void CorrectionBook::Hide(std::int64_t frame, const std::string& marker) {
  Do({ChangeTo({Row(frame), Marker(marker)}, {})}, {{"op", "hide"}, {"frame", frame}, {"marker", marker}});
}

void CorrectionBook::Restore(std::int64_t frame, const std::string& marker) {
  const Cell cell{Row(frame), Marker(marker)};
  Do({ChangeTo(cell, detected_.markers[cell.second].samples[cell.first])},
     {{"op", "restore"}, {"frame", frame}, {"marker", marker}});
}

void CorrectionBook::SwapFrom(std::int64_t frame, const std::string& one, const std::string& other) {
  const std::size_t a = Marker(one), b = Marker(other);
  if (a == b) throw Fail("'{}' cannot be swapped with itself", one);
  std::vector<Change> step;
  for (std::size_t row = Row(frame); row < detected_.Frames(); ++row) {
    step.push_back(ChangeTo({row, a}, Now({row, b})));
    step.push_back(ChangeTo({row, b}, Now({row, a})));
  }
  Do(std::move(step), {{"op", "swap"}, {"frame", frame}, {"marker", one}, {"other", other}});
}

void CorrectionBook::MoveEvent(int repetition, motion::StsEventKind kind, std::int64_t frame) {
  if (repetition < 1 && kind < motion::StsEventKind::kHeelStrike)
    throw Fail("repetition {} is none: they are counted from 1", repetition);
  const double time_s = detected_.time_s[Row(frame)];
  DoEvent({repetition, kind},
          motion::EventCorrection{repetition, kind, frame, time_s, "the new place", motion::LegSample::kUnknown, true},
          {{"op", "move_event"}, {"repetition", repetition}, {"event", motion::ToString(kind)}, {"frame", frame}});
}

void CorrectionBook::RestoreEvent(int repetition, motion::StsEventKind kind) {
  DoEvent({repetition, kind}, {},
          {{"op", "restore_event"}, {"repetition", repetition}, {"event", motion::ToString(kind)}});
}

void CorrectionBook::Undo() {
  if (!CanUndo()) throw Error("there is nothing to undo");
  const Step& step = steps_[--done_];
  for (const Change& change : step.cells) Set(change.cell, change.before);
  if (step.event) SetEvent(step.event->key, step.event->before);
}

void CorrectionBook::Redo() {
  if (!CanRedo()) throw Error("there is nothing to redo");
  const Step& step = steps_[done_++];
  for (const Change& change : step.cells) Set(change.cell, change.after);
  if (step.event) SetEvent(step.event->key, step.event->after);
}

void CorrectionBook::Make(const Json& edit) {
  const std::string op = edit.at("op");
  if (op == "undo") return Undo();
  if (op == "redo") return Redo();
  if (op == "move_event" || op == "restore_event") return MakeEvent(op, edit);
  const std::int64_t frame = WholeNumber(edit.at("frame"));
  const std::string marker = edit.at("marker");
  if (op == "place")
    return Place(frame, marker, {edit.at("x").get<double>(), edit.at("y").get<double>()},
                 edit.value("sigma", motion::kClickSigmaPx));
  if (op == "hide") return Hide(frame, marker);
  if (op == "restore") return Restore(frame, marker);
  if (op == "swap") return SwapFrom(frame, marker, edit.at("other"));
  throw Fail("'{}' is no change that can be made", op);
}

void CorrectionBook::MakeEvent(const std::string& op, const Json& edit) {
  constexpr std::int64_t kMost = 1'000'000;
  const auto repetition = static_cast<int>(std::clamp<std::int64_t>(WholeNumber(edit.at("repetition")), 0, kMost));
  const motion::StsEventKind kind = EventKind(edit.at("event"));
  if (op == "restore_event") return RestoreEvent(repetition, kind);
  MoveEvent(repetition, kind, WholeNumber(edit.at("frame")));
}

std::size_t CorrectionBook::Swaps() const {
  std::size_t swaps = 0;
  for (std::size_t i = 0; i < done_; ++i) swaps += edits_[i].at("op") == "swap" ? 1 : 0;
  return swaps;
}

Json CorrectionBook::History() const {
  Json base = Json::array(), base_events = Json::array();
  for (const motion::Correction& correction : base_) base.push_back(CorrectionJson(correction));
  for (const motion::EventCorrection& event : base_events_) base_events.push_back(EventJson(event));
  return {{"base", base}, {"base_events", base_events}, {"steps", edits_}, {"done", done_}};
}

void CorrectionBook::TakeHistory(const Json& history) {
  std::vector<motion::Correction> base;
  for (const Json& correction : history.at("base")) base.push_back(CorrectionFrom(correction));
  std::vector<motion::EventCorrection> base_events;
  for (const Json& event : history.value("base_events", Json::array())) base_events.push_back(EventFrom(event));
  CorrectionBook then(detected_, width_, height_, repeated_, base, base_events);
  for (const Json& edit : history.at("steps")) then.Make(edit);
  const std::int64_t done = WholeNumber(history.at("done"));
  while (then.CanUndo() && static_cast<std::int64_t>(then.done_) > done) then.Undo();
  if (!AreSame(then.made_, made_) || !AreSame(then.events_, events_))
    throw Error("the corrections were changed since they were made step by step");
  *this = std::move(then);
}

Json CorrectionJson(const motion::Correction& correction) {
  Json json = {{"frame", correction.frame}, {"marker", correction.marker}};
  const MarkerSample& sample = correction.sample;
  json["x_px"] = sample.IsKnown() ? Json(sample.position.x()) : Json();
  json["y_px"] = sample.IsKnown() ? Json(sample.position.y()) : Json();
  json["sigma_px"] = sample.IsKnown() ? Json(sample.sigma) : Json();
  return json;
}

motion::Correction CorrectionFrom(const Json& json) {
  motion::Correction correction{json.at("frame"), json.at("marker"), {}};
  if (!json.at("x_px").is_null())
    correction.sample = {{json.at("x_px").get<double>(), json.at("y_px").get<double>()},
                         json.at("sigma_px").get<double>(),
                         SampleStatus::kDetected};
  return correction;
}

std::vector<motion::EventCorrection> CorrectionBook::Events() const {
  std::vector<motion::EventCorrection> events;
  for (const auto& [key, event] : events_) events.push_back(event);
  return events;
}

motion::MarkerRecording CorrectionBook::Corrected() const {
  motion::MarkerRecording corrected = detected_;
  for (const auto& [cell, sample] : made_) corrected.markers[cell.second].samples[cell.first] = sample;
  return corrected;
}

std::vector<motion::Correction> CorrectionBook::Corrections() const {
  std::vector<motion::Correction> corrections;
  for (const auto& [cell, sample] : made_)
    corrections.push_back({detected_.frame[cell.first], detected_.markers[cell.second].name, sample});
  return corrections;
}

}  // namespace lake::review
