#include "lake/commands/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/overlay/pictures.h"
#include "lake/tracking/track_markers.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"

namespace lake::commands {
namespace {

constexpr const char* kFit = "fit";

Json ItemsJson(const std::vector<tracking::CheckItem>& items) {
  Json list = Json::array();
  for (const tracking::CheckItem& item : items) {
    Json entry = {{"name", item.name}, {"shown", item.shown}, {"verdict", ToString(item.verdict)}};
    if (item.verdict != tracking::Verdict::kGood) entry["advice"] = item.advice;
    list.push_back(entry);
  }
  return list;
}

Json ChecksJson(const tracking::RecordingCheck& c) {
  const auto named = [&](double value) { return c.IsNamed() ? Json(value) : Json(); };
  return {{"frames_in_file", c.frames_in_file},
          {"frames_seen", c.frames_seen},
          {"places_seen", c.places_seen},
          {"all_seen_share", c.all_seen_share},
          {"knee_hidden_share", named(c.knee_hidden_share)},
          {"spots", c.spots},
          {"clutter", c.clutter},
          {"strongest_clutter", c.strongest_clutter},
          {"quality", c.IsNamed() ? FiguresJson(c.markers) : Json()},
          {"compression_px", named(c.compression_px)},
          {"bits_per_pixel", ValueOrNull(c.video.bits_per_pixel)},
          {"position_sd_px", named(c.position_sd_px)},
          {"segment_px", named(c.segment_px)},
          {"travel_px", c.travel_px},
          {"strides", ValueOrNull(c.strides)},
          {"named", c.IsNamed()},
          {"expected_knee_sd_deg", named(c.knee_sd_deg)},
          {"flicker", c.flicker},
          {"repeated_frames", c.repeated_frames},
          {"dropped_frames", c.dropped_frames},
          {"tilt_deg", ValueOrNull(c.tilt_deg)},
          {"seconds", c.seconds}};
}

overlay::CheckPicture PictureOf(const tracking::RecordingCheck& check, const std::vector<tracking::CheckItem>& items,
                                const std::string& title) {
  overlay::CheckPicture picture{.frame = check.frame,
                                .spots = {},
                                .lines = {},
                                .title = title,
                                .legend = check.IsNamed()
                                              ? "named: the markers that lake track uses; dashed: other detections"
                                              : "dashed: detections; none could be named"};
  for (const tracking::CheckedSpot& spot : check.spots_shown)
    picture.spots.push_back({spot.position, spot.radius_px, spot.name});
  for (const tracking::CheckItem& item : items)
    picture.lines.push_back(
        {item.shown, item.verdict == tracking::Verdict::kGood ? "" : item.advice, static_cast<int>(item.verdict)});
  return picture;
}

std::string ReportOf(const std::vector<tracking::CheckItem>& items, const std::string& verdict) {
  std::string text;
  for (const tracking::CheckItem& item : items) {
    text += fmt::format("{:<10} {}\n", ToString(item.verdict), item.shown);
    if (item.verdict != tracking::Verdict::kGood) text += fmt::format("           -> {}\n", item.advice);
  }
  return text + verdict + (verdict == kFit ? "\n" : ": change what is marked before the subject goes home\n");
}

}  // namespace

Json FiguresJson(const tracking::MarkerFigures& figures) {
  return {{"samples", figures.samples},
          {"radius_px", figures.radius_px},
          {"contrast", figures.contrast},
          {"noise", figures.noise},
          {"contrast_over_noise", figures.contrast_over_noise},
          {"saturated_share", figures.saturated_share},
          {"sigma_px", figures.sigma_px},
          {"fastest_px_per_frame", figures.fastest_px},
          {"shutter_fraction", ValueOrNull(figures.shutter_fraction)},
          {"blur_px", figures.blur_px}};
}

void Describe(CheckRunOptions& o, OptionList& options) {
  options.AddOperand("video", o.video, "Video, or image sequence as frames/%05d.png")
      .Required()
      .IsPath(Option::Path::kVideo);
  tracking::DescribeNames(o.check.names, o.check.seeds, options);
  tracking::DescribePolarity(o.check.polarity, options);
  tracking::DescribeCrop(o.check.crop, options);
  video::DescribeCaptureRate(o.check.reader, options);
  video::DescribeRotation(o.check.reader, options);
  options.Check([&o](const OptionList&) {
    tracking::TrackOptions track;
    track.names = o.check.names;
    track.seeds = o.check.seeds;
    track.Check();
    for (const char* name : {"ankle", "hip"})
      if (std::ranges::count(track.names, name) == 0)
        throw UsageError("--markers: '{}' is missing; recordings of a leg are judged", name);
  });
}

Json RunCheck(const CheckRunOptions& options, Run& run) {
  const tracking::RecordingCheck check = tracking::CheckRecording(options.video, options.check);
  run.AddInput(video::FilesOfVideo(options.video), "video");
  run.Begin({"summary.json", "check.png"});
  const std::vector<tracking::CheckItem> items =
      tracking::JudgeRecording(check, static_cast<int>(options.check.names.size()));
  const auto has = [&](tracking::Verdict verdict) {
    return std::ranges::count(items, verdict, &tracking::CheckItem::verdict) > 0;
  };
  const std::string verdict = has(tracking::Verdict::kUnfit)       ? "not fit"
                              : has(tracking::Verdict::kNotJudged) ? ToString(tracking::Verdict::kNotJudged)
                                                                   : kFit;
  const std::string title = fmt::format("{}: {} (frame at {:.2f} s)", options.video.filename().string(), verdict,
                                        static_cast<double>(check.shown_frame_ms) / 1000);
  video::WriteImage(run.Result("check.png"), overlay::DrawCheckPicture(PictureOf(check, items, title)));
  run.Report(ReportOf(items, verdict));
  if (verdict != kFit) run.Reject();
  return {{"fit", verdict == kFit},
          {"verdict", verdict},
          {"video",
           {{"width", check.video.width},
            {"height", check.video.height},
            {"frame_rate_hz", check.video.frame_rate_hz},
            {"codec", check.video.codec},
            {"rotation_deg", check.video.rotation_deg}}},
          {"figures", ChecksJson(check)},
          {"checks", ItemsJson(items)}};
}

}  // namespace lake::commands
