#include "lake/parts/strength.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "lake/core/angles.h"

namespace lake::parts {
namespace {

using Kind = StrengthCheck::Kind;

// A check by the load that a pose brings, the stress per load, and the load that is allowed there.
struct Rule {
  Kind kind;
  Body part;
  std::string check;
  std::function<double(const LoadedPose&)> load;
  std::optional<double> stress_per_load;  // MPa per N or N m
  std::function<double(const LoadedPose&)> allowed;
};

double HoleOf(const PartOptions& options) {
  return options.pin_diameter_mm + options.bore_clearance_mm;
}
double BearingAreaOf(const PartOptions& options) {
  return options.pin_diameter_mm * options.thickness_mm;
}
double NetAreaOf(const PartOptions& options) {
  return (options.bar_width_mm - HoleOf(options)) * options.thickness_mm;
}

// MPa per N m.
double BendingStressPerTorqueOf(const PartOptions& options) {
  constexpr double kMillimetresPerMetre = 1000;
  const double second_moment =
      options.thickness_mm * (std::pow(options.bar_width_mm, 3) - std::pow(HoleOf(options), 3)) / 12;
  return kMillimetresPerMetre * options.bar_width_mm / 2 / second_moment;
}

// Euler's load times the square of the length, N mm^2.
double RodStrengthOf(const PartOptions& options) {
  const double second_moment = std::numbers::pi * std::pow(options.rod_diameter_mm, 4) / 64;
  return std::pow(std::numbers::pi, 2) * kSteelModulus_mpa * second_moment;
}

class Rules {
 public:
  explicit Rules(const Mechanism& mechanism) : options_(mechanism.options) {
    const auto coupler = [](const LoadedPose& at) { return std::abs(at.forces.coupler_n); };
    const auto bar = [](const LoadedPose& at) { return std::abs(at.forces.bar_n); };
    const auto actuator = [](const LoadedPose& at) { return std::abs(at.forces.actuator_n); };
    const auto torque = [](const LoadedPose& at) { return std::abs(at.knee_torque_nm); };
    AddStress(Kind::kBearing, Body::kCoupler, "bearing at R and S", coupler);
    AddStress(Kind::kNetSection, Body::kCoupler, "net section", coupler);
    AddStress(Kind::kBearing, Body::kBar, "bearing at P and R", bar);
    AddStress(Kind::kNetSection, Body::kBar, "net section", bar);
    AddStress(Kind::kBearing, Body::kShank, "bearing at K and S", coupler);
    AddStress(Kind::kBending, Body::kShank, "bending at S", torque);
    AddStress(Kind::kBearing, Body::kThigh, "bearing at K", coupler);
    AddStress(Kind::kBearing, Body::kThigh, "bearing at P", bar);
    AddStress(Kind::kBearing, Body::kThigh, "bearing at M", actuator);
    rules_.push_back(
        {.kind = Kind::kBuckling,
         .part = Body::kActuator,
         .check = "buckling of the rod",
         .load = [](const LoadedPose& at) { return std::max(0.0, at.forces.actuator_n); },
         .stress_per_load = std::nullopt,
         .allowed = [strength = RodStrengthOf(options_)](
                        const LoadedPose& at) { return strength / (at.pose.stroke_mm * at.pose.stroke_mm); }});
  }

  const std::vector<Rule>& All() const { return rules_; }

 private:
  void AddStress(Kind kind, Body part, std::string check, std::function<double(const LoadedPose&)> load) {
    const double stress_per_load = kind == Kind::kBending      ? BendingStressPerTorqueOf(options_)
                                   : kind == Kind::kNetSection ? 1 / NetAreaOf(options_)
                                                               : 1 / BearingAreaOf(options_);
    const double allowed = MaterialOf(options_.material).yield_mpa / stress_per_load;
    rules_.push_back({.kind = kind,
                      .part = part,
                      .check = std::move(check),
                      .load = std::move(load),
                      .stress_per_load = stress_per_load,
                      .allowed = [allowed](const LoadedPose&) { return allowed; }});
  }

  PartOptions options_;
  std::vector<Rule> rules_;
};

}  // namespace

double StrengthCheck::KneeAngle_deg() const {
  return DegreesFromRadians(at.pose.theta_rad);
}

Capacity CapacityOf(const PartOptions& options) {
  const double yield_mpa = MaterialOf(options.material).yield_mpa;
  const double bearing_n = yield_mpa * BearingAreaOf(options), net_n = yield_mpa * NetAreaOf(options);
  return {.coupler_n = std::min(bearing_n, net_n),
          .bar_n = std::min(bearing_n, net_n),
          .actuator_n = bearing_n,
          .rod_nmm2 = RodStrengthOf(options),
          .knee_torque_nm = yield_mpa / BendingStressPerTorqueOf(options)};
}

std::vector<StrengthCheck> CheckStrength(const Mechanism& mechanism, std::span<const LoadedPose> poses) {
  const Rules rules(mechanism);
  std::vector<StrengthCheck> checks;
  for (const Rule& rule : rules.All()) {
    std::optional<StrengthCheck> worst;
    for (const LoadedPose& pose : poses) {
      const double load = rule.load(pose);
      if (!std::isfinite(load) || load == 0) continue;
      StrengthCheck check{.kind = rule.kind,
                          .part = std::string(NameOf(rule.part)),
                          .check = rule.check,
                          .at = pose,
                          .load = load,
                          .stress_mpa = std::nullopt,
                          .allowed = rule.allowed(pose)};
      if (rule.stress_per_load) check.stress_mpa = load * *rule.stress_per_load;
      if (!worst || check.Safety() < worst->Safety()) worst = check;
    }
    if (worst) checks.push_back(*worst);
  }
  return checks;
}

}  // namespace lake::parts
