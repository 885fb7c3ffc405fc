#include "lake/review/correction_book.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"

namespace lake::review {
namespace {

using motion::MarkerSample;
using motion::SampleStatus;

bool IsSame(const MarkerSample& a, const MarkerSample& b) {
  if (a.IsKnown() != b.IsKnown()) return false;
  return !a.IsKnown() || (a.position == b.position && a.sigma == b.sigma);
}

}  // namespace

CorrectionBook::CorrectionBook(motion::MarkerRecording detected, int width, int height,
                               std::vector<std::int64_t> repeated, const std::vector<motion::Correction>& made)
    : detected_(motion::Measurements(std::move(detected))),
      width_(width),
      height_(height),
      repeated_(std::move(repeated)) {
  for (const motion::Correction& correction : made) {
    const Cell cell{Row(correction.frame), Marker(correction.marker)};
    Set(cell, ChangeTo(cell, correction.sample).after);
  }
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

void CorrectionBook::Do(Step step) {
  std::erase_if(step, [](const Change& change) {
    return change.before.has_value() == change.after.has_value() &&
           (!change.before || IsSame(*change.before, *change.after));
  });
  if (step.empty()) throw Error("that changes nothing");
  for (const Change& change : step) Set(change.cell, change.after);
  steps_.resize(done_);
  steps_.push_back(std::move(step));
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
  Do({ChangeTo(cell, {px, sigma_px, SampleStatus::kDetected})});
}

void CorrectionBook::Hide(std::int64_t frame, const std::string& marker) {
  Do({ChangeTo({Row(frame), Marker(marker)}, {})});
}

void CorrectionBook::Restore(std::int64_t frame, const std::string& marker) {
  const Cell cell{Row(frame), Marker(marker)};
  Do({ChangeTo(cell, detected_.markers[cell.second].samples[cell.first])});
}

void CorrectionBook::SwapFrom(std::int64_t frame, const std::string& one, const std::string& other) {
  const std::size_t a = Marker(one), b = Marker(other);
  if (a == b) throw Fail("'{}' cannot be swapped with itself", one);
  Step step;
  for (std::size_t row = Row(frame); row < detected_.Frames(); ++row) {
    step.push_back(ChangeTo({row, a}, Now({row, b})));
    step.push_back(ChangeTo({row, b}, Now({row, a})));
  }
  Do(std::move(step));
}

void CorrectionBook::Undo() {
  if (!CanUndo()) throw Error("there is nothing to undo");
  for (const Change& change : steps_[--done_]) Set(change.cell, change.before);
}

void CorrectionBook::Redo() {
  if (!CanRedo()) throw Error("there is nothing to redo");
  for (const Change& change : steps_[done_++]) Set(change.cell, change.after);
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
