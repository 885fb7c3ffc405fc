#include <cmath>

#include "comparison_tables.h"
#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/csv.h"

namespace lake::commands {
namespace {

using Eigen::Vector2d;

struct Force {
  const char* name;
  const char* label;
  std::vector<cuffs::CuffForce> cuffs::CuffCourse::*course;
};
constexpr Force kForces[] = {
    {"thigh_cuff", "thigh cuff", &cuffs::CuffCourse::thigh_n},
    {"shank_cuff", "shank cuff", &cuffs::CuffCourse::shank_n},
    {"knee_shear", "shear at the knee", &cuffs::CuffCourse::knee_shear_n},
};

}  // namespace

std::vector<CuffCase> CuffCases(const compare::StsCurve& leg, const compare::JointMisalignment& joint,
                                double place_sd_mm, const cuffs::CuffOptions& options) {
  std::vector<double> flexion_deg;
  for (std::size_t i = 0; i < leg.leg_knee.size(); ++i) {
    const Vector2d shank = leg.leg_knee[i] - leg.ankle[i], thigh = leg.hip[i] - leg.leg_knee[i];
    flexion_deg.push_back(DegreesFromRadians(std::atan2(Cross(shank, thigh), shank.dot(thigh))));
  }
  // Moved: by the mean that best_placement takes away.
  const Vector2d worn_mm = joint.shank_mm.back();
  return {{"worn", cuffs::CourseOf(flexion_deg, {worn_mm, place_sd_mm}, options)},
          {"moved", cuffs::CourseOf(flexion_deg, {worn_mm - joint.mean_mm, place_sd_mm}, options)}};
}

void WriteCuffTable(const std::filesystem::path& path, const std::vector<CuffCase>& cases) {
  std::vector<std::string> header{"case", "percent"};
  for (const Force& force : kForces)
    for (const char* value : {"_n", "_low_n", "_high_n"}) header.push_back(std::string(force.name) + value);
  CsvWriter csv(header);
  for (const CuffCase& one : cases)
    for (std::size_t i = 0; i < one.course.thigh_n.size(); ++i) {
      csv.Add(one.name).Add(i);
      for (const Force& force : kForces) {
        const cuffs::CuffForce& at = (one.course.*force.course)[i];
        csv.Add(at.force_n).Add(at.low_n).Add(at.high_n);
      }
      csv.EndRow();
    }
  csv.Write(path);
}

Json CuffsJson(const cuffs::CuffCourse& course) {
  Json json = Json::object();
  for (const Force& force : kForces) {
    const cuffs::CuffForce largest = cuffs::Largest(course.*force.course);
    json[std::string(force.name) + "_n"] = largest.force_n;
    json[std::string(force.name) + "_interval_n"] = {largest.low_n, largest.high_n};
  }
  return json;
}

report::Section CuffSection(const std::vector<CuffCase>& cases, const cuffs::CuffOptions& options) {
  report::Table table{.caption = "Largest forces over the rise, N, with what stiffness and misfit leave open (95 %)"};
  table.columns.push_back({.heading = "joint"});
  for (const Force& force : kForces) table.columns.push_back({.heading = force.label});
  for (const CuffCase& one : cases) {
    std::vector<report::Cell> row{one.name == "worn" ? "as worn" : "moved onto the knee"};
    for (const Force& force : kForces) {
      const cuffs::CuffForce largest = cuffs::Largest(one.course.*force.course);
      row.emplace_back(fmt::format("{:.1f} ({:.1f} to {:.1f})", largest.force_n, largest.low_n, largest.high_n));
    }
    table.rows.push_back(std::move(row));
  }
  return {"Forces at the cuffs",
          {report::Paragraph{fmt::format(
               "A joint beside the knee moves the cuffs along the leg as the knee bends; they and the flesh yield by "
               "{:g} to {:g} N/mm, and are free of stress at standing. The forces come from the misfit alone: the "
               "actuator holds the hinge at the knee's angle, and its moment and the device's weight are not in them.",
               options.softest_n_mm, options.stiffest_n_mm)},
           table}};
}

}  // namespace lake::commands
