// A live session at work: frames come, are tracked and shown; beside it another thread names the markers and measures
// the rises; the page asks and acts.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "lake/camera/camera.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/leg_angles.h"
#include "lake/gait/leg_view.h"
#include "lake/live/joint_place.h"
#include "lake/live/run_live.h"
#include "lake/review/pages.h"
#include "lake/tracking/live_tracker.h"
#include "lake/video/live_stream.h"
#include "trial.h"

namespace lake::live {

// A table that grows while the program works, so that nothing of it is lost if that ends.
class AppendedTable {
 public:
  AppendedTable(std::filesystem::path path, const std::vector<std::string>& header)
      : path_(std::move(path)), file_(path_, std::ios::binary | std::ios::trunc) {
    Row(header);
    Flush();
  }

  void Row(const std::vector<std::string>& cells) { file_ << fmt::format("{}\n", fmt::join(cells, ",")); }

  // Throws Error where the disk takes no more.
  void Flush() {
    if (!file_.flush()) throw Fail("{}: cannot be written further; is the disk full?", path_.string());
  }

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

// When to look for a rise: the knee was bent, is straighter by far, and keeps still. What a rise is, the leg fit says.
class RiseWatch {
 public:
  // Frame by frame. True each time it is worth looking.
  bool Add(double time_s, double knee_deg);

 private:
  std::deque<std::pair<double, double>> last_;  // time and angle
  double most_deg_ = 0, least_deg_ = 0;
  double looked_s_ = 0;
  int looks_ = 0;
};

// What a person wants to read of a session once it is over.
struct LiveFigures {
  struct Told {
    int rises = 0;
    std::string where, move;
  };
  std::int64_t frames = 0;
  double recorded_s = 0;
  std::string ended;
  std::optional<Told> place;
  std::optional<double> difference_px;  // RMS
};

// There is one: its members stand by what they are for, not by size.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class Session {
 public:
  // Opens the input and begins to record. Throws Error as LiveStream, and where there is no plane in mm.
  Session(const LiveRunOptions& options, std::filesystem::path programs, Run& run);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  void Start();

  // As a person ends the trial.
  void Stop() { stream_->Stop(); }
  // What is still to be done is left undone, but the recording is completed.
  void Abandon();
  bool IsOver() const { return is_over_; }

  // Waits until all is done; throws what made it fail.
  void Finish();

  review::LiveWork PageWork();
  Json LiveJson() const;
  LiveFigures Figures() const;

 private:
  enum class Phase { kWatching, kTrial, kFinishing, kDone, kFailed };

  // What is shown of a frame beside the markers.
  struct Sample {
    double time_s = 0;
    double knee_deg = motion::LegSample::kUnknown;
    std::optional<Eigen::Vector2d> joint_mm = {};             // joint less knee, shank's frame
    std::optional<Eigen::Vector2d> from_px = {}, to_px = {};  // the move, in the picture
  };

  void ReadPlane();
  void WarnOfTolerance();
  // A film that is replayed before a person's eyes begins with the trial.
  bool IsHeld() const { return options_.stream.replay && options_.page.open && phase_ == Phase::kWatching; }
  Eigen::Vector2d MarkerAt() const { return {options_.joint_at_mm[0], options_.joint_at_mm[1]}; }
  void CheckMarkers() const;
  // Of a place that the camera's model puts into the plane.
  std::optional<Eigen::Vector2d> InPlane(std::string_view marker, const Eigen::Vector2d& px) const;

  // The tracker's thread.
  void Work();
  void TrackAll();
  [[noreturn]] void BreakOff(const std::string& why);
  void AddFrame(const video::LiveFrame& live);
  Sample MeasureFrame() const;
  std::optional<gait::CarriedKnee> CarriedKnee(const motion::MarkerRecording& frames) const;  // in the last one
  void WriteTrackRow();
  void FinishTrial();

  // The analyst's.
  void Analyse();
  void FindTheNames();
  void FindTheRises();
  void FindFacing();
  void JudgePictures();

  // Under the mutex.
  int MovesBefore(double time_s) const;
  std::vector<RiseOffset> RisesAfterMoves(int moves) const;
  std::optional<JointPlace> Place() const;
  motion::MarkerRecording Window() const;
  std::vector<std::string> SeedsFrom(double start_s) const;
  TrialPart Trial() const;
  std::vector<std::string> Arguments() const;
  void SaveLive();
  std::string PhaseText() const;

  // The page's.
  Json About() const;
  Json State() const;
  Json View(std::int64_t after) const;
  cv::Mat Picture(std::int64_t frame) const;
  void Act(const Json& act);
  Json PlaceJson() const;
  Json LiveJsonLocked() const;

  LiveRunOptions options_;
  std::filesystem::path programs_;
  Run& run_;
  gait::LegView view_;
  video::VideoInfo video_;  // under the mutex once the session has started: the stream's own is its reader's
  double readout_s_ = 0;
  std::unique_ptr<video::LiveStream> stream_;
  tracking::LiveTrackOptions track_;
  std::optional<AppendedTable> tracks_table_, rises_table_, moves_table_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::optional<tracking::LiveTracker> tracker_;
  std::vector<Sample> samples_;            // one per frame
  std::deque<video::LiveFrame> pictures_;  // the last ones
  std::vector<double> latencies_ms_;
  std::optional<motion::Facing> facing_;
  RiseWatch watch_;
  bool is_rise_due_ = false;
  std::vector<RiseOffset> rises_;
  std::vector<double> moves_s_;
  std::vector<tracking::MarkerSeed> by_hand_;  // what was given and clicked
  std::optional<double> begin_s_, end_s_;
  std::string why_not_named_, why_no_rise_, progress_, failure_text_;
  Json checks_ = Json::array();
  Phase phase_ = Phase::kWatching;
  std::optional<video::StreamEnd> end_;
  std::optional<LiveDifference> difference_;
  bool has_ended_ = false;  // no more frames: the analyst ends

  std::chrono::steady_clock::time_point flushed_;
  std::atomic<bool> is_over_ = false, is_abandoned_ = false;
  std::exception_ptr failure_;
  std::thread tracker_thread_, analyst_thread_;
};

}  // namespace lake::live
