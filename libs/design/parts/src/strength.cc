#include "lake/parts/strength.h"

#include <cmath>
#include <functional>
#include <numbers>

#include "lake/core/angles.h"

namespace lake::parts {
namespace {

// A check by the load that a pose brings, the stress per load, and the load that is allowed there.
struct Rule {
  Body part;
  std::string check;
  std::function<double(const LoadedPose&)> load;
  std::optional<double> stress_per_load;  // MPa per N or N m
  std::function<double(const LoadedPose&)> allowed;
};

class Rules {
 public:
  explicit Rules(const Mechanism& mechanism) : options_(mechanism.options) {
    const auto coupler = [](const LoadedPose& at) { return std::abs(at.forces.coupler_n); };
    const auto bar = [](const LoadedPose& at) { return std::abs(at.forces.bar_n); };
    const auto actuator = [](const LoadedPose& at) { return std::abs(at.forces.actuator_n); };
    AddStress(Body::kCoupler, "bearing at R and S", coupler, 1 / BearingArea());
    AddStress(Body::kCoupler, "net section", coupler, 1 / NetArea());
    AddStress(Body::kBar, "bearing at P and R", bar, 1 / BearingArea());
    AddStress(Body::kBar, "net section", bar, 1 / NetArea());
    AddStress(Body::kShank, "bearing at K and S", coupler, 1 / BearingArea());
    AddStress(
        Body::kShank, "bending at S", [](const LoadedPose& at) { return std::abs(at.knee_torque_nm); },
        BendingStressPerTorque());
    AddStress(Body::kThigh, "bearing at K", coupler, 1 / BearingArea());
    AddStress(Body::kThigh, "bearing at P", bar, 1 / BearingArea());
    AddStress(Body::kThigh, "bearing at M", actuator, 1 / BearingArea());
    rules_.push_back({Body::kActuator, "buckling of the rod",
                      [](const LoadedPose& at) { return std::max(0.0, at.forces.actuator_n); }, std::nullopt,
                      [this](const LoadedPose& at) { return EulerLoad_n(at.pose.stroke_mm); }});
  }
  Rules(const Rules&) = delete;

  const std::vector<Rule>& All() const { return rules_; }

 private:
  void AddStress(Body part, std::string check, std::function<double(const LoadedPose&)> load, double stress_per_load) {
    const double allowed = MaterialOf(options_.material).yield_mpa / stress_per_load;
    rules_.push_back(
        {part, std::move(check), std::move(load), stress_per_load, [allowed](const LoadedPose&) { return allowed; }});
  }

  double Hole() const { return options_.pin_diameter_mm + options_.bore_clearance_mm; }
  double BearingArea() const { return options_.pin_diameter_mm * options_.thickness_mm; }
  double NetArea() const { return (options_.bar_width_mm - Hole()) * options_.thickness_mm; }

  double BendingStressPerTorque() const {
    constexpr double kMillimetresPerMetre = 1000;
    const double second_moment =
        options_.thickness_mm * (std::pow(options_.bar_width_mm, 3) - std::pow(Hole(), 3)) / 12;
    return kMillimetresPerMetre * options_.bar_width_mm / 2 / second_moment;
  }

  double EulerLoad_n(double length_mm) const {
    const double second_moment = std::numbers::pi * std::pow(options_.rod_diameter_mm, 4) / 64;
    return std::pow(std::numbers::pi / length_mm, 2) * kSteelModulus_mpa * second_moment;
  }

  PartOptions options_;
  std::vector<Rule> rules_;
};

}  // namespace

std::vector<StrengthCheck> CheckStrength(const Mechanism& mechanism, std::span<const LoadedPose> poses) {
  const Rules rules(mechanism);
  std::vector<StrengthCheck> checks;
  for (const Rule& rule : rules.All()) {
    std::optional<StrengthCheck> worst;
    for (const LoadedPose& pose : poses) {
      const double load = rule.load(pose);
      if (!std::isfinite(load) || load == 0) continue;
      StrengthCheck check{std::string(NameOf(rule.part)),
                          rule.check,
                          DegreesFromRadians(pose.pose.theta_rad),
                          load,
                          std::nullopt,
                          rule.allowed(pose)};
      if (rule.stress_per_load) check.stress_mpa = load * *rule.stress_per_load;
      if (!worst || check.Safety() < worst->Safety()) worst = check;
    }
    if (worst) checks.push_back(*worst);
  }
  return checks;
}

}  // namespace lake::parts
