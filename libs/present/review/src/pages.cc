#include "lake/review/pages.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "column.h"
#include "jpeg_encoder.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/review/frame_store.h"
#include "page_server.h"

namespace lake::review {
namespace {

void AddOthers(const OtherPages& pages, PageServer& page) {
  page.Post("open", [&pages](const Json& message) { return Json{{"address", pages.open(message.at("path"))}}; });
}

// The marker's place in each frame of the motion.
Json MarkerJson(const motion::MarkerRecording& tracks, const motion::MarkerTrack& track,
                const std::vector<std::int64_t>& frames) {
  const auto axis = [&](int i) {
    return Column(frames.size(), [&](std::size_t row) {
      const auto found = std::lower_bound(tracks.frame.begin(), tracks.frame.end(), frames[row]);
      if (found == tracks.frame.end() || *found != frames[row]) return std::numeric_limits<double>::quiet_NaN();
      const motion::MarkerSample& sample = track.samples[static_cast<std::size_t>(found - tracks.frame.begin())];
      return sample.IsKnown() ? sample.position[i] : std::numeric_limits<double>::quiet_NaN();
    });
  };
  return {{"name", track.name}, {"x", axis(0)}, {"y", axis(1)}};
}

Json TrialJson(const ComparedVideo& trial, const video::VideoInfo& info) {
  const motion::LegMotion& motion = trial.motion;
  Json repetition = Json::array(), markers = Json::array();
  for (const motion::LegSample& sample : motion.samples) repetition.push_back(ValueOrNull(sample.repetition));
  for (const motion::MarkerTrack& track : trial.tracks.markers)
    markers.push_back(MarkerJson(trial.tracks, track, motion.frame));
  return {{"name", trial.name},
          {"marker", trial.marker},
          {"width", info.width},
          {"height", info.height},
          {"frame", motion.frame},
          {"repetition", repetition},
          {"percent", Column(motion.samples.size(), [&](std::size_t row) { return motion.samples[row].percent; })},
          {"markers", markers},
          {"rises", trial.rises}};
}

FrameStoreOptions HalfTheMemory() {
  FrameStoreOptions options;
  options.most_bytes /= 2;
  return options;
}

void AddFrames(const std::string& path, FrameStore& frames, PageServer& page) {
  page.GetOther(path, [&frames](const LocalRequest& request) {
    return LocalReply{.type = "image/jpeg", .body = *frames.Frame(FrameNumber(request.rest)).jpeg, .may_keep = true};
  });
}

}  // namespace

void ServeStart(const PageOptions& options, const StartWork& work) {
  BackgroundJob making;
  PageServer page(options, [&making] { return Json{{"mode", "start"}, {"job", making.State()}}; });
  page.Get("start", [&work] { return Json{{"folder", work.folder}, {"found", work.found()}}; });
  AddOthers(work.pages, page);
  page.Post("make", [&](const Json& asked) {
    making.Start([&work, asked](const BackgroundJob::Control& control) { work.make(asked, control); });
    return page.State();
  });
  page.Post("stop", [&](const Json&) {
    making.Stop();
    return page.State();
  });
  page.Serve([&] { return making.IsRunning() || work.pages.are_open(); });
}

void ServeStudy(const PageOptions& options, const StudyWork& work) {
  PageServer page(options, [] { return Json{{"mode", "study"}}; });
  page.Get("study", [&work] {
    return Json{{"name", work.name},
                {"command", work.command},
                {"report", work.report.string()},
                {"has_report", std::filesystem::exists(work.report)},
                {"parts", work.parts}};
  });
  page.GetOther("report", [&work](const LocalRequest&) {
    return LocalReply{.type = "text/html; charset=utf-8", .body = ReadTextFile(work.report), .is_framed = true};
  });
  AddOthers(work.pages, page);
  page.Serve(work.pages.are_open);
}

void ServeComparison(const PageOptions& options, const ComparedPair& pair) {
  FrameStore human(pair.human.video, pair.human.reader, HalfTheMemory()),
      exo(pair.exo.video, pair.exo.reader, HalfTheMemory());
  PageServer page(options, [] { return Json{{"mode", "comparison"}}; });
  page.Get("comparison", [&] {
    return Json{{"name", pair.name},
                {"human", TrialJson(pair.human, human.Info())},
                {"exo", TrialJson(pair.exo, exo.Info())},
                {"curves", pair.curves}};
  });
  AddFrames("human/", human, page);
  AddFrames("exo/", exo, page);
  page.Serve([] { return false; });
}

void ServeLive(const PageOptions& options, const LiveWork& work) {
  constexpr int kQuality = 80;
  PageServer page(options, [&work] {
    Json message = work.state();
    message["mode"] = "live";
    return message;
  });
  page.Get("live", work.about);
  page.Post("view", [&work](const Json& message) {
    const Json& after = message.at("after");
    const bool fits = after.is_number_integer() &&
                      (!after.is_number_unsigned() || std::in_range<std::int64_t>(after.get<std::uint64_t>()));
    if (!fits) throw Fail("{} is not the number of a frame", after.dump());
    return work.view(after.get<std::int64_t>());
  });
  page.GetOther("picture/", [&work](const LocalRequest& request) {
    return LocalReply{.type = "image/jpeg",
                      .body = JpegEncoder(kQuality).Encode(work.picture(FrameNumber(request.rest)))};
  });
  page.Post("act", [&work, &page](const Json& act) {
    work.act(act);
    return page.State();
  });
  page.ServeUntil(work.is_over);
}

}  // namespace lake::review
