#include "lake/commands/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/deviation_text.h"
#include "lake/overlay/check_picture.h"
#include "lake/tracking/track_markers.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"

namespace lake::commands {
namespace {

// Good up to `good`, poor up to `poor`, else unfit; of figures that should be large, with both negative.
Verdict Judge(double value, double good, double poor) {
  return value <= good ? Verdict::kGood : value <= poor ? Verdict::kPoor : Verdict::kUnfit;
}

std::string ToString(Verdict verdict) {
  return verdict == Verdict::kGood ? "good" : verdict == Verdict::kPoor ? "poor" : "unfit";
}

void JudgeMarkers(const tracking::RecordingCheck& c, int markers, std::vector<CheckItem>& items) {
  items.push_back(
      {.name = "all_seen_share",
       .shown = fmt::format("{} markers or more in {:.0f} % of the frames", markers, 100 * c.all_seen_share),
       .verdict = Judge(-c.all_seen_share, -0.95, -0.8),
       .advice = "put a lamp beside the lens, turn the markers to the camera, keep hands and clothes off them"});
  const tracking::MarkerFigures& m = c.markers;
  if (!c.leg_seen && m.samples > 0) {
    items.push_back(
        {"leg_seen",
         "no leg: no three of the brightest spots keep their distances while the angle between them changes",
         Verdict::kUnfit,
         "bright round markers on ankle, knee and hip, all in the picture, from sitting to standing; leave "
         "lamps and reflections out with --crop"});
    return;
  }
  if (m.samples == 0) {
    items.push_back(
        {"radius_px", "no marker to measure", Verdict::kUnfit,
         "use bright round markers of 12 mm or more, with a lamp beside the lens; colours and ArUco squares are "
         "not judged here, lake-track finds them with --detector"});
    return;
  }
  items.push_back({.name = "radius_px",
                   .shown = fmt::format("marker radius {:.1f} px", m.radius_px),
                   .verdict = Judge(-m.radius_px, -3, -2),
                   .advice = "go nearer, zoom in, record at a higher resolution or use larger markers"});
  items.push_back({.name = "contrast_over_noise",
                   .shown = fmt::format("contrast {:.0f} grey levels, {:.0f} times the noise where it is faintest",
                                        m.contrast, m.contrast_over_noise),
                   .verdict = Judge(-m.contrast_over_noise, -20, -8),
                   .advice = "more light on the markers from beside the lens, a darker room behind them, a lower ISO"});
  items.push_back({.name = "saturated_share",
                   .shown = m.saturated_share > 0
                                ? fmt::format("{:.0f} % of the markers are overexposed", 100 * m.saturated_share)
                                : "no marker is overexposed",
                   .verdict = Judge(m.saturated_share, 0.9, 2),
                   .advice = "a shorter shutter or less light on the markers"});
  const std::string shutter = m.shutter_fraction
                                  ? fmt::format("shutter open for {:.0f} % of a frame", 100 * *m.shutter_fraction)
                                  : "shutter not known";
  items.push_back(
      {"blur_px",
       fmt::format("blur {:.1f} px at the fastest, a radius being {:.1f} ({})", m.blur_px, m.radius_px, shutter),
       Judge(m.blur_px / m.radius_px, 1.2, 2.5),
       fmt::format("a shutter of 1/{:.0f} s or shorter, with more light", 4 * std::max(c.video.frame_rate_hz, 25.0))});
}

// In a rise the hip travels by about the length of a thigh.
void JudgeMovement(const tracking::RecordingCheck& c, std::vector<CheckItem>& items) {
  if (c.segment_px <= 0) return;
  const double travel = c.travel_px / c.segment_px;
  items.push_back({.name = "travel_px",
                   .shown = fmt::format("the movement is {:.0f} px, {:.1f} segment lengths", c.travel_px, travel),
                   .verdict = Judge(-travel, -0.4, -0.2),
                   .advice = "record the whole movement: a second of sitting still, the rise, a second of standing"});
}

void JudgePictures(const tracking::RecordingCheck& c, int markers, std::vector<CheckItem>& items) {
  items.push_back(
      {.name = "flicker",
       .shown = fmt::format("brightness flickers by {:.1f} %", 100 * c.flicker),
       .verdict = Judge(c.flicker, 0.02, 0.15),
       .advice = "lamps on direct current, or a shutter of a whole number of the mains' half periods (1/100, 1/50 s; "
                 "1/120, 1/60 s)"});
  items.push_back({.name = "clutter",
                   .shown = fmt::format("{:.0f} other bright spots{}", c.clutter,
                                        c.clutter > 0 ? fmt::format(", the strongest {:.0f} % of the faintest marker",
                                                                    100 * c.strongest_clutter)
                                                      : ""),
                   .verdict = Judge(c.clutter, 3, 25),
                   .advice = fmt::format("cover lamps and reflections, or leave them out with --crop; {} "
                                         "spots were taken for markers",
                                         markers)});
  items.push_back({.name = "compression_px",
                   .shown = fmt::format("compression moves markers by {:.2f} px ({:.3f} bits per pixel)",
                                        c.compression_px, c.bits_per_pixel),
                   .verdict = Judge(c.compression_px, 0.1, 0.5),
                   .advice = "the camera's highest bit rate, and its own file rather than one sent on"});
  if (c.tilt_deg)
    items.push_back({.name = "tilt_deg",
                     .shown = fmt::format("the camera is rolled by {:.1f} degrees", *c.tilt_deg),
                     .verdict = Judge(std::abs(*c.tilt_deg), 2, 45),
                     .advice = "level the camera at knee height, or give lake-track a plumb line (--vertical)"});
}

void JudgeTime(const tracking::RecordingCheck& c, std::vector<CheckItem>& items) {
  items.push_back({.name = "frame_rate_hz",
                   .shown = fmt::format("{:.4g} frames/s", c.video.frame_rate_hz),
                   .verdict = Judge(-c.video.frame_rate_hz, -49, -23),
                   .advice = "60 frames/s or more"});
  const double repeated = c.frames_seen > 0 ? static_cast<double>(c.repeated_frames) / c.frames_seen : 0;
  items.push_back(
      {.name = "repeated_frames",
       .shown = fmt::format("{} of {} frames seen repeat the one before", c.repeated_frames, c.frames_seen),
       .verdict = Judge(repeated, 0.002, 0.01),
       .advice = "more light (phones repeat frames in the dark), a fixed frame rate, the camera's own file"});
  const double dropped =
      c.frames_in_file > 0 ? static_cast<double>(c.dropped_frames) / static_cast<double>(c.frames_in_file) : 0;
  items.push_back(
      {.name = "dropped_frames",
       .shown = fmt::format("{} of {} frames are missing by their time stamps", c.dropped_frames, c.frames_in_file),
       .verdict = Judge(dropped, 0.002, 0.02),
       .advice = "a faster memory card, a fixed frame rate, the camera's own file"});
  if (c.video.interlaced)
    items.push_back({.name = "interlaced",
                     .shown = "interlaced",
                     .verdict = Verdict::kUnfit,
                     .advice = "record progressively (p, not i)"});
}

Json ItemsJson(const std::vector<CheckItem>& items) {
  Json list = Json::array();
  for (const CheckItem& item : items) {
    Json entry = {{"name", item.name}, {"shown", item.shown}, {"verdict", ToString(item.verdict)}};
    if (item.verdict != Verdict::kGood) entry["advice"] = item.advice;
    list.push_back(entry);
  }
  return list;
}

Json ChecksJson(const tracking::RecordingCheck& c) {
  return {{"frames_in_file", c.frames_in_file},
          {"frames_seen", c.frames_seen},
          {"places_seen", c.places_seen},
          {"all_seen_share", c.all_seen_share},
          {"spots", c.spots},
          {"clutter", c.clutter},
          {"strongest_clutter", c.strongest_clutter},
          {"quality", FiguresJson(c.markers)},
          {"compression_px", c.compression_px},
          {"bits_per_pixel", c.bits_per_pixel},
          {"position_sd_px", c.position_sd_px},
          {"segment_px", c.segment_px},
          {"travel_px", c.travel_px},
          {"leg_seen", c.leg_seen},
          {"expected_knee_sd_deg", c.leg_seen ? Json(c.knee_sd_deg) : Json()},
          {"flicker", c.flicker},
          {"repeated_frames", c.repeated_frames},
          {"dropped_frames", c.dropped_frames},
          {"tilt_deg", c.tilt_deg ? Json(*c.tilt_deg) : Json()},
          {"seconds", c.seconds}};
}

overlay::CheckPicture PictureOf(const tracking::RecordingCheck& check, const std::vector<CheckItem>& items,
                                const std::string& title) {
  overlay::CheckPicture picture{.frame = check.frame, .spots = {}, .lines = {}, .title = title};
  for (const tracking::CheckedSpot& spot : check.spots_shown)
    picture.spots.push_back({spot.position, spot.radius_px, spot.is_marker});
  for (const CheckItem& item : items)
    picture.lines.push_back(
        {item.shown, item.verdict == Verdict::kGood ? "" : item.advice, static_cast<int>(item.verdict)});
  return picture;
}

}  // namespace

std::vector<CheckItem> JudgeRecording(const tracking::RecordingCheck& check, int markers) {
  std::vector<CheckItem> items;
  JudgeMarkers(check, markers, items);
  JudgeMovement(check, items);
  JudgePictures(check, markers, items);
  JudgeTime(check, items);
  if (check.leg_seen && check.segment_px > 0)
    items.push_back({.name = "expected_knee_sd_deg",
                     .shown = fmt::format("knee angle of a single frame: marker noise {} (1 SD)",
                                          DeviationText(check.knee_sd_deg, 3, " degrees")),
                     .verdict = Judge(check.knee_sd_deg, 0.2, 1),
                     .advice = "larger markers, more light, a higher bit rate; the camera nearer"});
  return items;
}

Json FiguresJson(const tracking::MarkerFigures& figures) {
  return {{"samples", figures.samples},
          {"radius_px", figures.radius_px},
          {"contrast", figures.contrast},
          {"noise", figures.noise},
          {"contrast_over_noise", figures.contrast_over_noise},
          {"saturated_share", figures.saturated_share},
          {"sigma_px", figures.sigma_px},
          {"fastest_px_per_frame", figures.fastest_px},
          {"shutter_fraction", figures.shutter_fraction ? Json(*figures.shutter_fraction) : Json()},
          {"blur_px", figures.blur_px}};
}

void Describe(CheckRunOptions& o, OptionList& options) {
  options.AddOperand("video", o.video, "Video, or image sequence as frames/%05d.png")
      .Required()
      .IsPath(Option::Path::kVideo);
  options.Add("markers", o.check.markers, "Number of markers that should be seen").Between(1, 40);
  tracking::DescribePolarity(o.check.polarity, options);
  tracking::DescribeCrop(o.check.crop, options);
  video::DescribeCaptureRate(o.check.reader, options);
  video::DescribeRotation(o.check.reader, options);
}

Json RunCheck(const CheckRunOptions& options, Run& run) {
  const tracking::RecordingCheck check = tracking::CheckRecording(options.video, options.check);
  run.AddInput(video::FilesOfVideo(options.video), "video");
  run.Begin({"summary.json", "check.png"});
  const std::vector<CheckItem> items = JudgeRecording(check, options.check.markers);
  const bool fit =
      std::none_of(items.begin(), items.end(), [](const CheckItem& i) { return i.verdict == Verdict::kUnfit; });
  const std::string title = fmt::format("{}: {} (frame at {:.2f} s)", options.video.filename().string(),
                                        fit ? "fit" : "not fit", static_cast<double>(check.shown_frame_ms) / 1000);
  video::WriteImage(run.Result("check.png"), overlay::DrawCheckPicture(PictureOf(check, items, title)));
  return {{"fit", fit},
          {"video",
           {{"width", check.video.width},
            {"height", check.video.height},
            {"frame_rate_hz", check.video.frame_rate_hz},
            {"codec", check.video.codec},
            {"rotation_deg", check.video.rotation_deg}}},
          {"figures", ChecksJson(check)},
          {"checks", ItemsJson(items)}};
}

std::string CheckReport(const Json& summary) {
  std::string text;
  for (const Json& item : summary["checks"]) {
    text += fmt::format("{:<6} {}\n", item["verdict"].get<std::string>(), item["shown"].get<std::string>());
    if (item.contains("advice")) text += fmt::format("       -> {}\n", item["advice"].get<std::string>());
  }
  return text +
         (summary["fit"].get<bool>() ? "fit\n" : "not fit: change what is marked before the subject goes home\n");
}

}  // namespace lake::commands
