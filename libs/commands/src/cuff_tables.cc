#include "cuff_tables.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"

namespace lake::commands {
namespace {

using Eigen::Vector2d;

constexpr double kNormal95 = 1.959964;

struct Force {
  const char* name;
  const char* label;
  std::vector<CuffForce> CuffCase::*values;
  double cuffs::LegLoad::*load;
};
constexpr Force kForces[] = {
    {"thigh_cuff", "thigh cuff", &CuffCase::thigh_n, &cuffs::LegLoad::largest_thigh_n},
    {"shank_cuff", "shank cuff", &CuffCase::shank_n, &cuffs::LegLoad::largest_shank_n},
    {"knee_shear", "shear at the knee", &CuffCase::knee_shear_n, &cuffs::LegLoad::knee_shear_n},
};

double LeanDeg(const Vector2d& up) {
  return DegreesFromRadians(std::atan2(up.x(), up.y()));
}

CuffCase CaseOf(const std::string& name, const std::vector<double>& thigh_deg, const std::vector<double>& shank_deg,
                const Vector2d& place_shank_mm, const Vector2d& place_thigh_mm, double misfit_share,
                const cuffs::CuffOptions& options) {
  const double soft = options.softest_n_mm, stiff = options.stiffest_n_mm, middle = std::sqrt(soft * stiff);
  CuffCase result{name, {}, {}, {}};
  for (std::size_t i = 0; i < thigh_deg.size(); ++i) {
    const cuffs::LegState leg{thigh_deg[i], shank_deg[i],
                              cuffs::MisfitOf(place_shank_mm, place_thigh_mm, thigh_deg[i], shank_deg[i]), 0, 0};
    const auto loads = [&](double n_mm) { return cuffs::LoadOnLeg(leg, options, {n_mm, n_mm}); };
    const cuffs::LegLoad least = loads(soft), expected = loads(middle), most = loads(stiff);
    // The actuator holds the hinge at the knee's angle; without its moment and the weight every force is in proportion
    // to the misfit.
    for (const Force& force : kForces)
      (result.*force.values)
          .push_back({expected.*force.load, least.*force.load * std::max(0.0, 1 - kNormal95 * misfit_share),
                      most.*force.load * (1 + kNormal95 * misfit_share)});
  }
  return result;
}

CuffForce Largest(const std::vector<CuffForce>& forces) {
  return *std::ranges::max_element(forces, {}, &CuffForce::force_n);
}

}  // namespace

std::vector<CuffCase> CuffCases(const compare::StsCurve& leg, const compare::JointMisalignment& joint,
                                double misfit_share, const cuffs::CuffOptions& options) {
  std::vector<double> thigh_deg, shank_deg;
  for (std::size_t i = 0; i < leg.leg_knee.size(); ++i) {
    shank_deg.push_back(LeanDeg(leg.leg_knee[i] - leg.ankle[i]));
    thigh_deg.push_back(LeanDeg(leg.hip[i] - leg.leg_knee[i]));
  }
  // The joint's place at standing, in both segments' frames; moved, by the mean that best_placement takes away.
  const Vector2d shank_mm = joint.shank_mm.back(), thigh_mm = joint.thigh_mm.back();
  const Eigen::Matrix2d thigh_from_shank = compare::AxesAlong(leg.hip.back() - leg.leg_knee.back()).transpose() *
                                           compare::AxesAlong(leg.leg_knee.back() - leg.ankle.back());
  return {CaseOf("worn", thigh_deg, shank_deg, shank_mm, thigh_mm, misfit_share, options),
          CaseOf("moved", thigh_deg, shank_deg, shank_mm - joint.mean_mm, thigh_mm - thigh_from_shank * joint.mean_mm,
                 misfit_share * joint.rms_mm / std::max((shank_mm - joint.mean_mm).norm(), 1e-9), options)};
}

void WriteCuffTable(const std::filesystem::path& path, const std::vector<CuffCase>& cases) {
  std::vector<std::string> header{"case", "percent"};
  for (const Force& force : kForces)
    for (const char* value : {"_n", "_low_n", "_high_n"}) header.push_back(std::string(force.name) + value);
  CsvWriter csv(header);
  for (const CuffCase& one : cases)
    for (std::size_t i = 0; i < one.thigh_n.size(); ++i) {
      csv.Add(one.name).Add(static_cast<int>(i));
      for (const Force& force : kForces) {
        const CuffForce& at = (one.*force.values)[i];
        csv.Add(at.force_n).Add(at.low_n).Add(at.high_n);
      }
      csv.EndRow();
    }
  csv.Write(path);
}

Json CuffsJson(const std::vector<CuffCase>& cases) {
  Json json = Json::object();
  for (const CuffCase& one : cases)
    for (const Force& force : kForces) {
      const CuffForce largest = Largest(one.*force.values);
      json[one.name][std::string(force.name) + "_n"] = largest.force_n;
      json[one.name][std::string(force.name) + "_interval_n"] = {largest.low_n, largest.high_n};
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
      const CuffForce largest = Largest(one.*force.values);
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
