// A tracked trial while a person corrects it: each change is saved at once, and the leg is fitted anew in the
// background.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lake/core/json.h"
#include "lake/gait/leg_fit.h"
#include "lake/review/correction_book.h"

namespace lake::review {

// What the page shows of a fit.
struct TrialFit {
  std::optional<gait::LegFitResult> leg;  // nullopt where the markers are no leg's; its events are those found
  motion::MarkerRecording tracks;         // px, gaps filled
  motion::MarkerRecording estimates;      // px, the fit's own; empty without a leg
  motion::MarkerRecording in_plane;       // what was measured, in the sagittal plane
  std::vector<std::string> warnings;
};

struct TrialWork {
  std::function<TrialFit(const motion::MarkerRecording& corrected)> fit;  // throws Error where there is no leg in it
  std::function<void(const CorrectionBook& book)> save;                   // throws Error; nothing is half written then
  std::function<bool()> is_applied;  // whether the results that are there were made with what is saved
};

// May be asked by several threads.
class TrialSession {
 public:
  // Begins with a fit of what is there; `about` is put into each answer as it is.
  TrialSession(CorrectionBook book, std::vector<std::int64_t> repeated, TrialWork work, Json about);
  TrialSession(const TrialSession&) = delete;
  TrialSession& operator=(const TrialSession&) = delete;
  ~TrialSession();

  // Tracks, curves, events and problems as of now; TrialMessage in page/messages.ts.
  std::string Trial() const;
  // Which change is the last, and which the curves are of; StateMessage there.
  Json State() const;

  // As CorrectionBook::Make(). Throws Error where it cannot be done or cannot be saved: then nothing has changed.
  Json Edit(const Json& edit);

  // Angles, distances and speeds of any markers; CoursesMessage in page/messages.ts. Throws Error where there is no
  // fit, UsageError for what cannot be measured.
  Json Measure(const Json& asked) const;

  // The nearest frame but this one in which the marker is measured, and where; nullopt if there is none.
  struct Measured {
    std::int64_t frame = 0;
    motion::MarkerSample sample;
  };
  std::optional<Measured> NearestMeasured(const std::string& marker, std::int64_t frame) const;

  // The standard deviation that this marker's measurements usually have, px; 0 if it was never seen.
  double UsualSigma(const std::string& marker) const;

 private:
  void FitAgain();
  Json StateNow() const;
  void CheckEvents(const CorrectionBook& changed) const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  CorrectionBook book_;
  std::vector<std::int64_t> repeated_;
  TrialWork work_;
  Json about_;
  std::int64_t revision_ = 0, fitted_ = -1;
  std::optional<TrialFit> fit_;  // of the revision `fitted_`
  std::string fit_error_;
  bool is_applied_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace lake::review
