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
          NumberOrNaN(summary.at("links").at(link))};
}

Table OptimumTable(const problem::SynthesisProblem& problem, const Json& summary) {
  Table table{"The design problem's optimum",
              {{"Link (mm)"}, {"Start", 3}, {"At least", 1}, {"At most", 1}, {"Optimum", 3}},
              {}};
  for (std::size_t i = 0; i < problem.bounds.size(); ++i)
    table.rows.push_back(LinkRow(problem::LinkName(i), summary, problem, i));
  table.rows.push_back({"range of rotation (°)", NumberOrNaN(summary.at("start").at("range_deg")), std::nan(""),
                        std::nan(""), NumberOrNaN(summary.at("range_deg"))});
  return table;
}

std::string OptimumText(const Json& summary) {
  std::string text = fmt::format("The largest range of rotation is {:.2f}°.", NumberOrNaN(summary.at("range_deg")));
  if (const double bound = NumberOrNaN(summary.at("certified_upper_bound_deg")); std::isfinite(bound))
    text += fmt::format(" No design within the bounds has more than {:.2f}°: that is proved by interval arithmetic.",
                        bound);
  std::vector<std::string> limits;
  for (const Json& limit : summary.at("active")) limits.push_back(limit.at("limit").get<std::string>());
  if (!limits.empty()) text += fmt::format(" At their limits are: {}.", fmt::join(limits, ", "));
  return text;
}

bool IsPose(const std::string& name) {
  return name.starts_with("pose_") && name.ends_with(".png");
}

}  // namespace

Section OptimumChapter(const StudyFile& study, const StudyResults& results) {
  const Json summary = results.Summary("optimum");
  Section section{"The design problem by itself",
                  {Paragraph{OptimumText(summary)}, OptimumTable(study.design.problem, summary)}};
  results.AddPicture("optimum/sensitivity.png", "Range of rotation against a change of each link",
                     "Range against the change of each link; shaded where the linkage cannot be assembled.",
                     Width::kFull, section);
  results.AddPicture("optimum/margin.png", "Range of rotation against the margin from the singularities",
                     "What a margin from both singularities costs.", Width::kFull, section);
  return section;
}

Section SimulationChapter(const StudyResults& results) {
  const Json summary = results.Summary("simulation");
  Table table{"The design in its poses; the force balances the stated knee torque",
              {{"Knee (°)", 1},
               {"Stroke (mm)", 2},
               {"Moment arm (mm/rad)", 1},
               {"Force (N)", 0},
               {"Transmission angle (°)", 1}},
              {}};
  for (const Json& pose : summary.at("poses"))
    table.rows.push_back({NumberOrNaN(pose.at("knee_deg")), NumberOrNaN(pose.at("stroke_mm")),
                          NumberOrNaN(pose.at("moment_arm_mm")), NumberOrNaN(pose.at("force_n")),
                          NumberOrNaN(pose.at("transmission_deg"))});
  Section section{"The design in motion", {std::move(table)}};
  std::vector<fs::path> poses;
  for (const std::string& name : ResultsIn(results.Folder() / "simulation"))
    if (IsPose(name)) poses.push_back(fs::path("simulation") / name);
  std::sort(poses.begin(), poses.end(), [](const fs::path& a, const fs::path& b) {
    return std::stod(a.stem().string().substr(5)) < std::stod(b.stem().string().substr(5));
  });
  for (const fs::path& pose : poses)
    results.AddPicture(pose, "The linkage on the leg", fmt::format("Knee at {}°.", pose.stem().string().substr(5)),
                       Width::kFull, section);
  results.AddPicture("simulation/angle_vs_stroke.png", "Knee angle, moment arm, force and transmission over the stroke",
                     "What the linkage does over the stroke.", Width::kFull, section);
  results.AddPicture("simulation/mannequin.png", "The design on a body, standing and seated",
                     "The design on a body of average size.", Width::kFull, section);
  return section;
}

}  // namespace lake::study
