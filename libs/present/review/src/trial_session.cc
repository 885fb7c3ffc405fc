#include "lake/review/trial_session.h"

#include <algorithm>
#include <cstdlib>
#include <exception>

#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/statistics.h"
#include "trial_json.h"

namespace lake::review {
TrialSession::TrialSession(CorrectionBook book, std::vector<std::int64_t> repeated, TrialWork work, Json about)
    : book_(std::move(book)),
      repeated_(std::move(repeated)),
      work_(std::move(work)),
      about_(std::move(about)),
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
          {"swaps", book_.Swaps()}};
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
