// The fit's reports as JSON, for summary.json.
#include <cmath>
#include <map>

#include "lake/gait/leg_fit.h"

namespace lake::gait {
namespace {

// Among the frames whose angle is certain: not where a hidden marker was bridged or extrapolated freely.
Json Extreme(const motion::LegMotion& motion, double motion::LegSample::*value, double sign, const char* key) {
  constexpr double kMostSigmaDeg = 1;
  std::size_t best = motion.samples.size();
  for (std::size_t i = 0; i < motion.samples.size(); ++i)
    if (std::isfinite(motion.samples[i].*value) && motion.samples[i].knee_sigma_deg <= kMostSigmaDeg &&
        (best == motion.samples.size() || sign * (motion.samples[i].*value) > sign * (motion.samples[best].*value)))
      best = i;
  if (best == motion.samples.size()) return nullptr;
  return {{key, motion.samples[best].*value}, {"time_s", motion.time_s[best]}, {"frame", motion.frame[best]}};
}

Json KneeJson(const motion::LegMotion& motion) {
  Json knee = {{"largest", Extreme(motion, &motion::LegSample::knee_deg, 1, "deg")},
               {"smallest", Extreme(motion, &motion::LegSample::knee_deg, -1, "deg")},
               {"fastest_flexion", Extreme(motion, &motion::LegSample::knee_deg_s, 1, "deg_s")},
               {"fastest_extension", Extreme(motion, &motion::LegSample::knee_deg_s, -1, "deg_s")}};
  if (!knee["largest"].is_null())
    knee["range_of_motion_deg"] = knee["largest"]["deg"].get<double>() - knee["smallest"]["deg"].get<double>();
  double squares = 0;
  int count = 0;
  for (const motion::LegSample& sample : motion.samples)
    if (std::isfinite(sample.knee_sigma_deg)) {
      squares += sample.knee_sigma_deg * sample.knee_sigma_deg;
      ++count;
    }
  if (count > 0) knee["rms_sigma_deg"] = std::sqrt(squares / count);
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
                {{"usable", fit.usable},
                 {"message", fit.message},
                 {"known_sigmas", fit.known_sigmas},
                 {"iterations", fit.iterations},
                 {"initial_cost", fit.initial_cost},
                 {"final_cost", fit.final_cost},
                 {"residual_rms_sigmas", fit.residual_rms},
                 {"knot_step_s", fit.knot_step_s},
                 {"cutoff_hz", fit.cutoff_hz}}}};
  if (result.across)
    json["across_plane"] = {{"rms_mm", result.across->rms_mm},
                            {"largest_shank_deg", result.across->largest_shank_deg},
                            {"largest_thigh_deg", result.across->largest_thigh_deg}};
  return json;
}

}  // namespace lake::gait
