#include "lake/review/review.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "lake/core/error.h"
#include "lake/review/background_job.h"
#include "lake/review/frame_store.h"
#include "page_server.h"
#include "whole_number.h"

namespace lake::review {
namespace {

class ReviewServer {
 public:
  ReviewServer(const ReviewOptions& options, std::optional<ReviewedTrial> trial,
               const std::optional<NamingWork>& naming)
      : naming_(naming), frames_(options.video, options.reader), page_(options.page, [this] { return State(); }) {
    if (trial) Open(*std::move(trial));
    AddFrames();
    AddTrial();
    AddNaming();
  }

  void Serve() {
    page_.Serve([this] { return tracking_.IsRunning(); });
  }

 private:
  void AddFrames() {
    page_.GetOther("frame/", [this](const LocalRequest& request) {
      const StoredFrame frame = frames_.Frame(FrameNumber(request.rest));
      return LocalReply{.type = "image/jpeg", .body = *frame.jpeg, .may_keep = true};
    });
    page_.Post("snap", [this](const Json& said) {
      return Snap(WholeNumber(said.at("frame")), {said.at("x").get<double>(), said.at("y").get<double>()},
                  said.at("reach"), said.at("marker"));
    });
  }

  void AddTrial() {
    page_.GetOther("trial", [this](const LocalRequest&) { return LocalReply{"application/json", Session()->Trial()}; });
    page_.Post("edit", [this](const Json& edit) {
      if (tracking_.IsRunning()) throw Error("the corrections are being applied: wait until that has ended");
      return Session()->Edit(edit);
    });
    page_.Post("measure", [this](const Json& asked) { return Session()->Measure(asked.at("measures")); });
    page_.Post("apply", [this](const Json&) {
      StartApplying();
      return page_.State();
    });
    page_.Post("stop", [this](const Json&) {
      tracking_.Stop();
      return page_.State();
    });
  }

  void AddNaming() {
    page_.Post("naming", [this](const Json& options) { return Naming().find(options); });
    page_.Post("command", [this](const Json& choices) { return Json{{"command", Naming().said(choices)}}; });
    page_.Post("track", [this](const Json& choices) {
      StartTracking(choices);
      return page_.State();
    });
  }

  Json State() const {
    const bool is_tracking = tracking_.IsRunning();
    const std::lock_guard lock(mutex_);
    Json state = session_ ? session_->State() : Json::object();
    state["mode"] = session_ ? "trial" : is_tracking ? "tracking" : "naming";
    state["job"] = tracking_.State();
    return state;
  }

  Json Snap(std::int64_t frame, const Eigen::Vector2d& place, double reach_px, const std::string& marker) {
    constexpr double kFarthest = 100;
    if (!place.allFinite() || !(reach_px > 0 && reach_px <= kFarthest)) return Json();
    const Snapping snapping = SnapTo(marker, frame);
    if (!snapping.detector) return Json();
    const StoredFrame stored = frames_.Frame(frame);
    video::VideoFrame picture;
    picture.index = frame;
    picture.luma = stored.luma;
    const auto colours = [&stored] { return ColoursOf(stored); };
    const auto found = SnapToMarker(picture, place, reach_px, snapping.detector, colours);
    if (!found) return Json();
    // Compression displaces what it does not show in a single frame.
    const double sigma =
        std::max(std::hypot(found->sigma_px, snapping.sigma_px), marker.empty() ? 0 : Session()->UsualSigma(marker));
    return {{"x", found->position.x()}, {"y", found->position.y()}, {"sigma", sigma}};
  }

  std::shared_ptr<TrialSession> Session() const {
    const std::lock_guard lock(mutex_);
    if (!session_) throw Error("nothing has been tracked yet");
    return session_;
  }

  // What measures a marker in a frame; `sigma_px`: how well the patch that it is compared with is known to be centred.
  struct Snapping {
    tracking::DetectorMaker detector;
    double sigma_px = 0;
  };

  Snapping SnapTo(const std::string& marker, std::int64_t frame) {
    {
      const std::lock_guard lock(mutex_);
      if (snap_to_) return {snap_to_};
    }
    const auto measured = marker.empty() ? std::nullopt : Session()->NearestMeasured(marker, frame);
    if (!measured) return {};
    return {DetectorOfPatch(frames_.Frame(measured->frame).luma, measured->sample.position), measured->sample.sigma};
  }

  const NamingWork& Naming() const {
    if (!naming_) throw Error("the markers of this trial have their names");
    return *naming_;
  }

  void Open(ReviewedTrial trial) {
    auto session = std::make_shared<TrialSession>(std::move(trial.book), std::move(trial.repeated),
                                                  std::move(trial.work), std::move(trial.about));
    const std::lock_guard lock(mutex_);
    std::swap(session_, session);
    apply_ = std::move(trial.apply);
    snap_to_ = trial.snap_to;
  }

  void StartTracking(const Json& choices) {
    Naming().said(choices);  // says what cannot be
    {
      const std::lock_guard lock(mutex_);
      if (session_) throw Error("the video has been tracked");
    }
    tracking_.Start([this, choices](const BackgroundJob::Control& control) { Open(Naming().track(choices, control)); });
  }

  void StartApplying() {
    const std::lock_guard lock(mutex_);
    if (!apply_) throw Error("these results are not of lake track alone: run what made them");
    tracking_.Start([this, apply = apply_](const BackgroundJob::Control& control) { Open(apply(control)); });
  }

  const std::optional<NamingWork>& naming_;
  FrameStore frames_;
  mutable std::mutex mutex_;
  std::shared_ptr<TrialSession> session_;
  std::function<ReviewedTrial(const BackgroundJob::Control&)> apply_;  // of the session's trial
  tracking::DetectorMaker snap_to_;
  BackgroundJob tracking_;
  PageServer page_;
};

}  // namespace

void ServeReview(const ReviewOptions& options, std::optional<ReviewedTrial> trial,
                 const std::optional<NamingWork>& naming) {
  ReviewServer(options, std::move(trial), naming).Serve();
}

}  // namespace lake::review
