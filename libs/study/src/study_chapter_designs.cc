#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

std::vector<Cell> LinkRow(const std::string& link, const Json& summary, const problem::SynthesisProblem& problem,
                          std::size_t index) {
  return {link, problem.start.Values()[index], problem.bounds[index].lower, problem.bounds[index].upper,
          NumberAt(summary, "links/" + link)};
}

Table OptimumTable(const problem::SynthesisProblem& problem, const Json& summary) {
  Table table{"Benchmark optimum: the largest range, with no person in the problem",
              {{"Link (mm)"}, {"Start", 2}, {"At least", 1}, {"At most", 1}, {"Optimum", 2}}};
  for (std::size_t i = 0; i < problem.bounds.size(); ++i)
    table.rows.push_back(LinkRow(problem::LinkName(i), summary, problem, i));
  table.rows.push_back({"range of rotation (°)", Number{NumberAt(summary, "start/range_deg"), 1}, std::nan(""),
                        std::nan(""), Number{NumberAt(summary, "range_deg"), 1}});
  return table;
}

std::string OptimumText(const Json& summary) {
  std::string text =
      fmt::format("The largest range of rotation within the links' bounds is {}.", QuantityAt(summary, "range_deg"));
  if (const double bound = NumberAt(summary, "certified_upper_bound_deg"); std::isfinite(bound))
    text += fmt::format(" No design within the bounds has more than {:.2f}°: that is proved by interval arithmetic.",
                        bound);
  std::vector<std::string> limits;
  for (const Json& limit : summary.at("active")) limits.push_back(limit.at("limit").get<std::string>());
  if (!limits.empty()) text += fmt::format(" Active constraints: {}.", fmt::join(limits, ", "));
  return text;
}

// Negative: they overlap, seen from the side. Seat and limbs stand there where the linkage meets them.
Table FitTable(const Json& body) {
  Table table{
      fmt::format(
          "Clearances on a body of {:.0f} cm and {:.0f} kg with a thigh of {:.0f} and a shank of {:.0f} mm, the "
          "linkage {} the leg; negative: parts overlap, seen from the side",
          NumberAt(body, "height_mm") / 10, NumberAt(body, "mass_kg"), NumberAt(body, "thigh_mm"),
          NumberAt(body, "shank_mm"), body.at("mount").get<std::string>()),
      {{"Quantity"}, {"mm", 1}, {"Overlap (mm)", 1}, {"at knee angle (°)", 1}},
      {}};
  const auto add = [&](const char* what, const char* key, double at_deg) {
    const double clearance = NumberAt(body, key);
    table.rows.push_back({what, clearance, clearance < 0 ? -clearance : std::nan(""), at_deg});
  };
  add("mount to hip, along the thigh", "mount_below_hip_mm", std::nan(""));
  if (!body.at("clears_seat").is_null()) add("linkage to seat", "seat_clearance_mm", NumberAt(body, "seated_deg"));
  if (!body.at("clears_limb").is_null()) {
    add("actuator to thigh", "actuator_to_thigh_mm", NumberAt(body, "actuator_to_thigh_at_deg"));
    add("actuator to shank", "actuator_to_shank_mm", NumberAt(body, "actuator_to_shank_at_deg"));
  }
  return table;
}

bool IsPose(const std::string& name) {
  return name.starts_with("pose_") && name.ends_with(".svg");
}

}  // namespace

Section OptimumChapter(const StudyFile& study, const StudyResults& results) {
  const Json summary = results.Summary("optimum");
  Section section{"Benchmark optimum", {Paragraph{OptimumText(summary)}, OptimumTable(study.design.problem, summary)}};
  results.AddPicture(
      "optimum/sensitivity.svg", "Range of rotation against a change of each link",
      "Range of rotation when one link is changed and the others are kept; shaded where the linkage cannot be "
      "assembled.",
      Width::kFull, section);
  results.AddPicture("optimum/margin.svg", "Range of rotation against the margin from the singularities",
                     "Largest range of rotation for each margin that is kept from both singularities.", Width::kFull,
                     section);
  return section;
}

Section SimulationChapter(const StudyFile&, const StudyResults& results) {
  const Json summary = results.Summary("simulation");
  Table table{
      fmt::format("Poses; the force balances {} at the knee", QuantityAt(summary, "knee_torque_nm")),
      {{"Knee (°)", 1}, {"Stroke (mm)", 2}, {"Moment arm (mm)", 1}, {"Force (N)", 0}, {"Transmission angle (°)", 1}},
      {}};
  for (const Json& pose : summary.at("poses"))
    table.rows.push_back({NumberAt(pose, "knee_deg"), NumberAt(pose, "stroke_mm"), NumberAt(pose, "moment_arm_mm"),
                          NumberAt(pose, "force_n"), NumberAt(pose, "transmission_deg")});
  Section section{"Fit on the body, and motion", {FitTable(summary.at("mannequin"))}};
  results.AddPicture("simulation/mannequin.svg", "The design on a body, standing and seated",
                     "The design on a body with this person's leg, standing and seated.", Width::kFull, section);
  section.blocks.push_back(std::move(table));
  std::vector<fs::path> poses;
  for (const std::string& name : ResultsIn(results.Folder() / "simulation"))
    if (IsPose(name)) poses.push_back(fs::path("simulation") / name);
  std::sort(poses.begin(), poses.end(), [](const fs::path& a, const fs::path& b) {
    return std::stod(a.stem().string().substr(5)) < std::stod(b.stem().string().substr(5));
  });
  for (const fs::path& pose : poses)
    results.AddPicture(pose, "The linkage on the leg", fmt::format("Knee at {}°.", pose.stem().string().substr(5)),
                       Width::kFull, section);
  results.AddPicture("simulation/angle_vs_stroke.svg", "Knee angle, moment arm, force and transmission over the stroke",
                     "Knee angle, moment arm, actuator force and transmission angles over the stroke.", Width::kFull,
                     section);
  return section;
}

}  // namespace lake::study
