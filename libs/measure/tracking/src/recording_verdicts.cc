#include "lake/tracking/recording_verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/deviation_text.h"
#include "lake/core/uncertain_text.h"

namespace lake::tracking {
namespace {

// Good up to `good`, poor up to `poor`, else unfit; of figures that should be large, with both negative.
Verdict Judge(double value, double good, double poor) {
  return value <= good ? Verdict::kGood : value <= poor ? Verdict::kPoor : Verdict::kUnfit;
}

constexpr int kNamesWithTechnical = 6;  // the leg's four, and two on the skin of a segment

void JudgeMarkers(const RecordingCheck& c, int markers, std::vector<CheckItem>& items) {
  items.push_back(
      {.name = "all_seen_share",
       .shown = c.IsNamed()
                    ? fmt::format("all markers in {:.0f} % of the frames", 100 * c.all_seen_share)
                    : fmt::format("{} detections or more in {:.0f} % of the frames", markers, 100 * c.all_seen_share),
       // Who walks comes into the picture marker by marker.
       .verdict = !c.IsNamed() ? Verdict::kNotJudged
                               : Judge(-c.all_seen_share, c.strides ? -0.8 : -0.95, c.strides ? -0.6 : -0.8),
       .advice = "put a lamp beside the lens, turn the markers to the camera, keep hands and clothes off them"});
  if (!c.IsNamed()) {
    items.push_back(
        {.name = "markers",
         .shown = "lake track cannot name the markers so, and neither they nor the knee are judged: " + c.why_not_named,
         .verdict = Verdict::kNotJudged,
         .advice = "bright round markers on ankle, knee and hip, all in the picture, from sitting to "
                   "standing; or name them all with --markers and point at them with --seed. Colours and ArUco "
                   "squares are not judged here, lake-track finds them with --detector"});
    return;
  }
  if (c.knee_hidden_share > kOftenHidden)
    items.push_back({.name = "knee_hidden_share",
                     .shown = fmt::format("knee hidden in {:.0f} % of the frames", 100 * c.knee_hidden_share),
                     .verdict = Verdict::kPoor,
                     .advice = markers >= kNamesWithTechnical ? kRebuiltKneeAdvice : kHiddenKneeAdvice});
  const MarkerFigures& m = c.markers;
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
       Judge(m.blur_px / m.radius_px, 1.2, 6),  // walks with streaks of 6 radii are followed at crf 30
       fmt::format("a shutter of 1/{:.0f} s or shorter, with more light", 4 * std::max(c.video.frame_rate_hz, 25.0))});
}

// In a rise the hip travels by about the length of a thigh. Spots without names tell whether anything moves at all: by
// a twentieth of the picture's height, a quarter of what a hip does in a picture that holds a standing person.
void JudgeMovement(const RecordingCheck& c, std::vector<CheckItem>& items) {
  const std::string advice = "record the whole movement: a second of sitting still, the rise, a second of standing";
  if (!c.IsNamed()) {
    if (c.spots > 0 && c.travel_px < 0.05 * c.video.height)
      items.push_back({.name = "travel_px",
                       .shown = fmt::format("nothing bright moves by more than {:.0f} px", std::ceil(c.travel_px)),
                       .verdict = Verdict::kUnfit,
                       .advice = advice});
    return;
  }
  if (c.strides) {
    items.push_back({.name = "strides",
                     .shown = fmt::format("the person walks, {} whole stride{} in view", *c.strides,
                                          *c.strides == 1 ? " is" : "s are"),
                     .verdict = Judge(-*c.strides, -1, -1),
                     .advice = "stand farther away or zoom out, so that two strides (3 m) and more of the path are in "
                               "the picture, or record on a treadmill"});
    return;
  }
  constexpr double kEnough = 0.4;  // of a segment's length
  const double travel = c.travel_px / c.segment_px;
  items.push_back({.name = "travel_px",
                   .shown = travel >= kEnough ? fmt::format("the movement is large enough ({:.0f} px)", c.travel_px)
                                              : fmt::format("the movement is small ({:.0f} px)", c.travel_px),
                   .verdict = Judge(-travel, -kEnough, -0.2),
                   .advice = advice});
}

void JudgePictures(const RecordingCheck& c, std::vector<CheckItem>& items) {
  items.push_back(
      {.name = "flicker",
       .shown = fmt::format("brightness flickers by {:.1f} %", 100 * c.flicker),
       .verdict = Judge(c.flicker, 0.02, 0.15),
       .advice = "lamps on direct current, or a shutter of a whole number of the mains' half periods (1/100, 1/50 s; "
                 "1/120, 1/60 s)"});
  items.push_back({.name = "clutter",
                   .shown = fmt::format("{:.0f} other detections{}", c.clutter,
                                        c.clutter > 0 ? fmt::format(", the strongest {:.0f} % of the faintest marker",
                                                                    100 * c.strongest_clutter)
                                                      : ""),
                   // Where the markers were named all the same, none of them is unfit for that.
                   .verdict = c.IsNamed() ? std::min(Judge(c.clutter, 3, 25), Verdict::kPoor) : Judge(c.clutter, 3, 25),
                   .advice = "cover lamps and reflections, or leave them out with --crop"});
  if (c.IsNamed())
    items.push_back(
        {.name = "compression_px",
         .shown = fmt::format(
             "compression moves markers by {:.2f} px{}", c.compression_px,
             c.video.bits_per_pixel ? fmt::format(" ({:.3f} bits per pixel)", *c.video.bits_per_pixel) : ""),
         .verdict = Judge(c.compression_px, 0.1, 0.5),
         .advice = "the camera's highest bit rate, and its own file rather than one sent on"});
  if (c.tilt_deg)
    items.push_back({.name = "tilt_deg",
                     .shown = fmt::format("the camera is rolled by {:.1f} degrees", *c.tilt_deg),
                     .verdict = Judge(std::abs(*c.tilt_deg), 2, 45),
                     .advice = "level the camera at knee height, or give lake-track a plumb line (--vertical)"});
}

void JudgeTime(const RecordingCheck& c, std::vector<CheckItem>& items) {
  items.push_back(
      {.name = "frame_rate_hz",
       .shown = fmt::format("{} frames/s", SignificantText(c.video.frame_rate_hz, 4)),
       .verdict = c.strides ? Judge(-c.video.frame_rate_hz, -59, -29) : Judge(-c.video.frame_rate_hz, -49, -23),
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
  if (c.video.HasWidePixels())
    items.push_back(
        {.name = "pixel_aspect",
         .shown = fmt::format("pixels are {} times as wide as high by the file, which lake track allows for",
                              SignificantText(c.video.pixel_aspect, 3)),
         .verdict = Verdict::kGood,
         .advice = ""});
  if (c.video.interlaced)
    items.push_back({.name = "interlaced",
                     .shown = "interlaced",
                     .verdict = Verdict::kUnfit,
                     .advice = "record progressively (p, not i)"});
}

}  // namespace

std::string ToString(Verdict verdict) {
  constexpr std::array kNames = {"good", "poor", "unfit", "not judged"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

std::vector<CheckItem> JudgeRecording(const RecordingCheck& check, int markers) {
  std::vector<CheckItem> items;
  JudgeMarkers(check, markers, items);
  JudgeMovement(check, items);
  JudgePictures(check, items);
  JudgeTime(check, items);
  if (check.IsNamed())
    items.push_back({.name = "expected_knee_sd_deg",
                     .shown = fmt::format("knee angle of a single frame: marker noise {} (1 SD)",
                                          DeviationText(check.knee_sd_deg, 3, " degrees")),
                     .verdict = Judge(check.knee_sd_deg, 0.2, 1),
                     .advice = "larger markers, more light, a higher bit rate; the camera nearer"});
  return items;
}

}  // namespace lake::tracking
