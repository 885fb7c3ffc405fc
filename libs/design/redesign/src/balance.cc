#include "lake/redesign/balance.h"

#include "lake/core/error.h"

namespace lake::redesign {
namespace {

double At(const std::vector<double>& lean_rad, std::size_t sample) {
  return lean_rad.empty() ? 0 : lean_rad[sample];
}

}  // namespace

std::size_t FirstOnFeet(const HumanMotion& human, const loads::BodyPath& body) {
  std::size_t first = 0;
  while (first + 1 < human.size() && PercentOf(first, human) < body.feet_from_percent) ++first;
  return first;
}

BalanceCourse FindBalance(const HumanMotion& human, const loads::BodyPath& body, const std::vector<double>& theta_rad,
                          const Lean& lean, double duration_s) {
  if (human.size() != body.trunk.size())
    throw Fail("the human's motion has {} samples, and the body {}", human.size(), body.trunk.size());
  const std::size_t reach = BalanceReach(human), last = human.size() - 1;
  const double step_s = duration_s * static_cast<double>(reach) / static_cast<double>(last);
  const auto pose = [&](std::size_t i) {
    return PoseOf(human[i], body.trunk[i], body.body, theta_rad[i], At(lean.leg_rad, i), At(lean.trunk_rad, i));
  };
  BalanceCourse course{.samples = {}, .duration_s = duration_s, .margin_mm = 0, .at_percent = 0, .peak_knee_nm = 0};
  for (std::size_t i = FirstOnFeet(human, body); i <= last; ++i) {
    const std::array poses = {pose(i - std::min(i, reach)), pose(i), pose(std::min(i + reach, last))};
    const loads::Support<double> ground = loads::FindGroundSupport(poses, step_s, body);
    const double shank_m = human[i].shank_mm / kMmPerM, tilt = poses[1][0].tilt_rad;
    const loads::Support<double> above =
        loads::FindSupport(poses, step_s, body, 1, shank_m * std::sin(tilt), shank_m * std::cos(tilt));
    BalanceSample sample{.percent = PercentOf(i, human),
                         .pressure_mm = kMmPerM * ground.moment_nm / ground.force_n,
                         .margin_mm = 0,
                         .knee_nm = -above.moment_nm};
    sample.margin_mm = std::min(sample.pressure_mm + kMmPerM * body.body.sole.heel_m,
                                kMmPerM * body.body.sole.toe_m - sample.pressure_mm);
    if (course.samples.empty() || sample.margin_mm < course.margin_mm) {
      course.margin_mm = sample.margin_mm;
      course.at_percent = sample.percent;
    }
    if (course.samples.empty() || sample.knee_nm > course.peak_knee_nm) course.peak_knee_nm = sample.knee_nm;
    course.samples.push_back(sample);
  }
  return course;
}

}  // namespace lake::redesign
