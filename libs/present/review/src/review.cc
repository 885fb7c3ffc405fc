#include "lake/review/review.h"

#include <charconv>
#include <mutex>
#include <thread>
#include <utility>

#include "lake/core/error.h"
#include "lake/review/frame_store.h"
#include "lake/review/local_server.h"
#include "page_files.h"
#include "snap.h"
#include "whole_number.h"
#include "windows.h"

namespace lake::review {
namespace {

constexpr const char* kJson = "application/json";

LocalReply JsonReply(const Json& message) {
  return {kJson, message.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

std::int64_t FrameNumber(std::string text) {
  constexpr std::string_view kEnding = ".jpg";
  std::int64_t number = -1;
  if (text.ends_with(kEnding)) text.resize(text.size() - kEnding.size());
  const char* end = text.data() + text.size();
  const auto [last, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || last != end || number < 0) throw Fail("'{}' is not the number of a frame", text);
  return number;
}

class ReviewServer {
 public:
  ReviewServer(const ReviewOptions& options, std::optional<ReviewedTrial> trial,
               const std::optional<NamingWork>& naming)
      : options_(options), naming_(naming), frames_(options.video, options.reader), server_(options.port) {
    if (trial) Open(*std::move(trial));
    AddPage();
    AddFrames();
    AddTrial();
  }
  ~ReviewServer() {
    if (tracking_.joinable()) tracking_.join();
  }

  void Serve() {
    if (options_.ready) options_.ready(server_.Address());
    server_.Serve([this] { return windows_.AllClosed() && !IsTracking(); });
  }

 private:
  void AddFile(const std::string& path, const std::string& type, std::string_view text) {
    server_.Get(path, [type, text](const LocalRequest&) { return LocalReply{type, std::string(text)}; });
  }

  void AddPage() {
    AddFile("", "text/html; charset=utf-8", PageHtml());
    AddFile("review.css", "text/css; charset=utf-8", PageStyle());
    AddFile("review.js", "text/javascript; charset=utf-8", PageScript());
    server_.Get("state", [this](const LocalRequest& request) {
      if (const auto window = request.query.find("window"); window != request.query.end())
        windows_.Opened(window->second);
      return JsonReply(State());
    });
    server_.Post("closed", [this](const LocalRequest& request) {
      windows_.Closed(Json::parse(request.body).at("window"));
      return JsonReply({});
    });
  }

  void AddFrames() {
    server_.Get("frame/", [this](const LocalRequest& request) {
      const StoredFrame frame = frames_.Frame(FrameNumber(request.rest));
      return LocalReply{.type = "image/jpeg", .body = *frame.jpeg, .may_keep = true};
    });
    server_.Post("snap", [this](const LocalRequest& request) {
      const Json said = Json::parse(request.body);
      return JsonReply(Snap(WholeNumber(said.at("frame")), {said.at("x").get<double>(), said.at("y").get<double>()},
                            said.at("reach"), said.at("marker")));
    });
  }

  void AddTrial() {
    server_.Get("trial", [this](const LocalRequest&) { return LocalReply{kJson, Session().Trial()}; });
    server_.Post("edit",
                 [this](const LocalRequest& request) { return JsonReply(Session().Edit(Json::parse(request.body))); });
    server_.Post("naming",
                 [this](const LocalRequest& request) { return JsonReply(Naming().find(Json::parse(request.body))); });
    server_.Post("command", [this](const LocalRequest& request) {
      return JsonReply({{"command", Naming().said(Json::parse(request.body))}});
    });
    server_.Post("track", [this](const LocalRequest& request) {
      StartTracking(Json::parse(request.body));
      return JsonReply(State());
    });
  }

  Json State() const {
    const std::lock_guard lock(mutex_);
    Json state = session_ ? session_->State() : Json::object();
    state["mode"] = session_ ? "trial" : is_tracking_ ? "tracking" : "naming";
    state["progress"] = progress_;
    state["failed"] = failed_;
    return state;
  }

  Json Snap(std::int64_t frame, const Eigen::Vector2d& place, double reach_px, const std::string& marker) {
    constexpr double kFarthest = 100;
    const std::optional<tracking::Polarity> snap_to = SnapTo();
    if (!snap_to || !place.allFinite() || !(reach_px > 0 && reach_px <= kFarthest)) return Json();
    const auto found = SnapToMarker(frames_.Frame(frame).luma, place, reach_px, *snap_to);
    if (!found) return Json();
    // Compression displaces what it does not show in a single frame.
    const double sigma = std::max(found->sigma_px, marker.empty() ? 0 : Session().UsualSigma(marker));
    return {{"x", found->position.x()}, {"y", found->position.y()}, {"sigma", sigma}};
  }

  TrialSession& Session() const {
    const std::lock_guard lock(mutex_);
    if (!session_) throw Error("nothing has been tracked yet");
    return *session_;
  }

  std::optional<tracking::Polarity> SnapTo() const {
    const std::lock_guard lock(mutex_);
    return snap_to_;
  }

  const NamingWork& Naming() const {
    if (!naming_) throw Error("the markers of this trial have their names");
    return *naming_;
  }

  void Open(ReviewedTrial trial) {
    auto session = std::make_unique<TrialSession>(std::move(trial.book), std::move(trial.repeated),
                                                  std::move(trial.work), std::move(trial.about));
    const std::lock_guard lock(mutex_);
    session_ = std::move(session), snap_to_ = trial.snap_to;
  }

  bool IsTracking() const {
    const std::lock_guard lock(mutex_);
    return is_tracking_;
  }

  void StartTracking(const Json& choices) {
    Naming().said(choices);  // says what cannot be
    const std::lock_guard lock(mutex_);
    if (session_) throw Error("the video has been tracked");
    if (is_tracking_) throw Error("the video is being tracked");
    if (tracking_.joinable()) tracking_.join();
    is_tracking_ = true, progress_.clear(), failed_.clear();
    tracking_ = std::thread([this, choices] { Track(choices); });
  }

  void Track(const Json& choices) {
    std::string failure;
    try {
      Open(naming_->track(choices, [this](const std::string& line) {
        const std::lock_guard lock(mutex_);
        progress_ = line;
      }));
    } catch (const std::exception& error) {
      failure = error.what();
    }
    const std::lock_guard lock(mutex_);
    is_tracking_ = false, failed_ = failure;
  }

  const ReviewOptions& options_;
  const std::optional<NamingWork>& naming_;
  FrameStore frames_;
  Windows windows_;
  mutable std::mutex mutex_;
  std::unique_ptr<TrialSession> session_;  // never replaced once it is there
  std::optional<tracking::Polarity> snap_to_;
  bool is_tracking_ = false;
  std::string progress_, failed_;
  std::thread tracking_;
  LocalServer server_;
};

}  // namespace

void ServeReview(const ReviewOptions& options, std::optional<ReviewedTrial> trial,
                 const std::optional<NamingWork>& naming) {
  ReviewServer(options, std::move(trial), naming).Serve();
}

}  // namespace lake::review
