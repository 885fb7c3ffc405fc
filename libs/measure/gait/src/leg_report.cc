// The fit's reports as JSON, for summary.json, and as text.
#include "lake/gait/leg_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "lake/core/deviation_text.h"
#include "lake/core/uncertain_text.h"

namespace lake::gait {
namespace {

// The frame with the largest value, or with sign −1 the smallest, among those whose angle is certain: not where a
// hidden marker was bridged or extrapolated freely. nullopt where no angle is.
std::optional<std::size_t> FrameOfExtreme(const motion::LegMotion& motion, double motion::LegSample::*value,
                                          double sign) {
  constexpr double kMostSigmaDeg = 1;
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < motion.samples.size(); ++i)
    if (std::isfinite(motion.samples[i].*value) && motion.samples[i].knee_sigma_deg <= kMostSigmaDeg &&
        (!best || sign * (motion.samples[i].*value) > sign * (motion.samples[*best].*value)))
      best = i;
  return best;
}

Json ExtremeJson(const motion::LegMotion& motion, double motion::LegSample::*value, double sign, const char* key) {
  const std::optional<std::size_t> frame = FrameOfExtreme(motion, value, sign);
  if (!frame) return nullptr;
  return {{key, motion.samples[*frame].*value}, {"time_s", motion.time_s[*frame]}, {"frame", motion.frame[*frame]}};
}

struct KneeRange {
  double smallest_deg, largest_deg;
};
std::optional<KneeRange> RangeOf(const motion::LegMotion& motion) {
  const auto smallest = FrameOfExtreme(motion, &motion::LegSample::knee_deg, -1),
             largest = FrameOfExtreme(motion, &motion::LegSample::knee_deg, 1);
  if (!largest) return std::nullopt;
  return KneeRange{motion.samples[*smallest].knee_deg, motion.samples[*largest].knee_deg};
}

// RMS over the frames; NaN where no standard deviation is known.
double RmsSigmaDeg(const motion::LegMotion& motion) {
  double squares = 0;
  int count = 0;
  for (const motion::LegSample& sample : motion.samples)
    if (std::isfinite(sample.knee_sigma_deg)) {
      squares += sample.knee_sigma_deg * sample.knee_sigma_deg;
      ++count;
    }
  return std::sqrt(squares / count);
}

Json KneeJson(const motion::LegMotion& motion) {
  Json knee = {{"largest", ExtremeJson(motion, &motion::LegSample::knee_deg, 1, "deg")},
               {"smallest", ExtremeJson(motion, &motion::LegSample::knee_deg, -1, "deg")},
               {"fastest_flexion", ExtremeJson(motion, &motion::LegSample::knee_deg_s, 1, "deg_s")},
               {"fastest_extension", ExtremeJson(motion, &motion::LegSample::knee_deg_s, -1, "deg_s")}};
  if (const auto range = RangeOf(motion)) knee["range_of_motion_deg"] = range->largest_deg - range->smallest_deg;
  if (const double rms_deg = RmsSigmaDeg(motion); std::isfinite(rms_deg)) knee["rms_sigma_deg"] = rms_deg;
  return knee;
}

Json RepetitionsJson(const std::vector<motion::StsEvent>& events) {
  std::map<int, std::map<motion::StsEventKind, double>> repetitions;
  for (const motion::StsEvent& event : events) repetitions[event.repetition][event.kind] = event.time_s;
  Json list = Json::array();
  for (const auto& [number, times] : repetitions) {
    Json repetition = {{"repetition", number}};
    for (const auto& [kind, time_s] : times) repetition[std::string(ToString(kind)) + "_s"] = time_s;
    if (times.contains(motion::StsEventKind::kOnset) && times.contains(motion::StsEventKind::kStanding))
      repetition["duration_s"] = times.at(motion::StsEventKind::kStanding) - times.at(motion::StsEventKind::kOnset);
    list.push_back(repetition);
  }
  return list;
}

Json MarkersJson(const LegFitResult& result) {
  const std::string unit(ToString(result.tracks.unit));
  Json list = Json::array();
  for (const MarkerReport& m : result.markers) {
    Json marker = {{"name", m.name},           {"detected", m.detected},       {"filled", m.filled},
                   {"missing", m.missing},     {"outliers", m.outliers},       {"residual_rms_" + unit, m.rms},
                   {"worst_" + unit, m.worst}, {"worst_frame", m.worst_frame}, {"noise_scale", m.noise_scale}};
    if (m.parallax_per_depth > 0) marker["error_mm_per_mm_depth"] = m.parallax_per_depth;
    list.push_back(marker);
  }
  return list;
}

Json RebuiltKneeJson(const RebuiltKnee& rebuilt) {
  const auto seen = [&](double value) { return rebuilt.seen_frames > 0 ? Json(value) : Json(); };
  return {{"learnt_in", rebuilt.trial},
          {"frames", std::ranges::count(rebuilt.frames, 1)},
          {"sd_mm", rebuilt.sd_mm},
          {"seen_frames", rebuilt.seen_frames},
          {"difference_x_mm", seen(rebuilt.difference_mm.x())},
          {"difference_y_mm", seen(rebuilt.difference_mm.y())},
          {"difference_rms_mm", seen(rebuilt.difference_rms_mm)}};
}

// How often, how well, and what the frames that show the marker say of it.
std::string RebuiltKneeText(const RebuiltKnee& rebuilt) {
  const double frames = static_cast<double>(rebuilt.frames.size());
  std::string text =
      fmt::format("knee rebuilt from technical markers in {:.0f} % of the frames, ± {:.1f} mm (1 SD per axis)",
                  100 * static_cast<double>(std::ranges::count(rebuilt.frames, 1)) / frames, rebuilt.sd_mm);
  if (rebuilt.seen_frames == 0) return text + "; no frame shows its marker to compare\n";
  return text + fmt::format(
                    "; in the {} frames that show its marker, that is {:.1f} mm RMS from where it would be rebuilt, "
                    "{} mm to the front and {} mm up the shank on average\n",
                    rebuilt.seen_frames, rebuilt.difference_rms_mm, WithSign(RoundedText(rebuilt.difference_mm.x(), 1)),
                    WithSign(RoundedText(rebuilt.difference_mm.y(), 1)));
}

}  // namespace

Json LegFitJson(const LegFitResult& result) {
  const std::string unit(ToString(result.motion.unit));
  Json segments = Json::array(), outliers = Json::array();
  for (const SegmentReport& s : result.segments)
    segments.push_back({{"name", s.name},
                        {"length_" + unit, s.length},
                        {"length_sigma_" + unit, s.length_sigma},
                        {"variation_" + unit, s.variation}});
  for (const OutlierReport& o : result.outliers)
    outliers.push_back({{"frame", o.frame},
                        {"marker", o.marker},
                        {"residual_" + std::string(ToString(result.tracks.unit)), o.residual},
                        {"deviations", o.deviations}});
  const LegFitSummary& fit = result.summary;
  Json json = {{"facing", result.motion.facing == motion::Facing::kLeft ? "left" : "right"},
               {"up_in_plane", {result.up.x(), result.up.y()}},
               {"markers", MarkersJson(result)},
               {"segments", segments},
               {"outliers", outliers},
               {"knee", KneeJson(result.motion)},
               {"sit_to_stands", RepetitionsJson(result.events)},
               {"fit",
                {{"known_sigmas", fit.known_sigmas},
                 {"lasting_share", fit.lasting_share},
                 {"learnt_lasting_share", fit.learnt_lasting_share},
                 {"noise_memory_s", fit.noise_memory_s},
                 {"residual_rms_sigmas", fit.residual_rms},
                 {"cutoff_hz", fit.cutoff_hz}}}};
  if (const auto& neutral = result.motion.neutral)
    for (const motion::Angle& angle : motion::Angles())
      if (std::isfinite((*neutral).*angle.deg))
        json["neutral"][angle.name] = {{"deg", (*neutral).*angle.deg}, {"sd_deg", (*neutral).*angle.sigma_deg}};
  if (result.lateral)
    json["across_plane"] = {{"rms_mm", result.lateral->rms_mm},
                            {"largest_shank_deg", result.lateral->largest_shank_deg},
                            {"largest_thigh_deg", result.lateral->largest_thigh_deg}};
  if (result.sight) json[kPlaneSight] = PlaneSightJson(*result.sight);
  if (result.rebuilt_knee) json["rebuilt_knee"] = RebuiltKneeJson(*result.rebuilt_knee);
  return json;
}

std::string LegFitText(const LegFitResult& result) {
  const std::string unit(ToString(result.motion.unit));
  std::string text;
  for (const SegmentReport& segment : result.segments) {
    const auto& of = *std::ranges::find(motion::kSegments, segment.name, &motion::Segment::vector_name);
    text += fmt::format("{} ({} to {})  {:.1f} {}, varies by {} (SD)\n", of.angle.name, motion::kMarkerNames[of.lower],
                        motion::kMarkerNames[of.upper], segment.length, unit, DeviationText(segment.variation, 1, ""));
  }
  if (const auto range = RangeOf(result.motion)) {
    text += fmt::format("knee {:.2f}° to {:.2f}°, marker noise {} (1 SD): kinematics.csv\n", range->smallest_deg,
                        range->largest_deg, DeviationText(RmsSigmaDeg(result.motion), 3, "°"));
    if (const auto& neutral = result.motion.neutral)
      text += fmt::format("in quiet standing the knee is at {:.1f}° ± {}: NAME_neutral_deg is relative to that pose\n",
                          neutral->knee_deg, DeviationText(neutral->knee_sigma_deg, 1, "°"));
    else
      text += "0°: ankle, knee and hip markers in line, which need not be how the person stands (--neutral)\n";
  }
  if (result.rebuilt_knee) text += RebuiltKneeText(*result.rebuilt_knee);
  return text;
}

}  // namespace lake::gait
