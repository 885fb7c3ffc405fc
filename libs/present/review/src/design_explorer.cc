#include "lake/review/design_explorer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "column.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/numbers.h"
#include "lake/core/provenance.h"
#include "lake/linkage/wear.h"
#include "lake/problem/evaluate.h"
#include "lake/problem/problem_file.h"

namespace lake::review {
namespace {

using Eigen::Vector2d;
using linkage::Links;
using linkage::Pose;

constexpr double kSeatedAngle_deg = 90;  // thigh level, shank upright
constexpr std::size_t kRows = 181;       // of the curves, evenly over the strokes

// The thigh's axes in the picture: it is turned back by the knee angle.
struct ThighAxes {
  explicit ThighAxes(double theta_rad)
      : up(-std::sin(theta_rad), std::cos(theta_rad)), posterior(-std::cos(theta_rad), -std::sin(theta_rad)) {}

  Vector2d ToPicture(const Vector2d& in_thigh) const { return posterior * in_thigh.x() + up * in_thigh.y(); }
  Vector2d FromPicture(const Vector2d& in_picture) const { return {posterior.dot(in_picture), up.dot(in_picture)}; }

  Vector2d up, posterior;
};

// The pins of a pose; a design has the links that its pins are apart.
struct Pins {
  Vector2d thigh_pin, tip, shank_pin, mount;  // P, R, S, M in the thigh frame

  static Pins Of(const Pose& pose) { return {pose.thigh_pin, pose.tip, pose.shank_pin, pose.mount}; }

  Vector2d& Named(const std::string& name) {
    if (name == "thigh_pin") return thigh_pin;
    if (name == "tip") return tip;
    if (name == "shank_pin") return shank_pin;
    if (name == "mount") return mount;
    throw Fail("'{}' is no pin that can be moved", name);
  }
  Links Between() const {
    return {(tip - shank_pin).norm(), (tip - thigh_pin).norm(), thigh_pin.y(), shank_pin.norm(), mount.x(),
            mount.y() - thigh_pin.y()};
  }
  double Stroke() const { return (tip - mount).norm(); }
};

// What the linkage does at one stroke; NaN where there is no pose.
struct At {
  At(const Links& links, double stroke_mm, double knee_torque_nm) : pose(linkage::SolvePose(links, stroke_mm)) {
    if (!pose) return;
    const linkage::Transmission transmission = linkage::TransmissionOf(links, *pose);
    knee_deg = DegreesFromRadians(pose->theta_rad);
    arm_mm = transmission.moment_arm_mm;
    force_n = linkage::ActuatorForce(transmission, knee_torque_nm);
    transmission_deg = DegreesFromRadians(transmission.transmission_rad);
  }

  std::optional<Pose> pose;
  double knee_deg = kNaN, arm_mm = kNaN, force_n = kNaN, transmission_deg = kNaN;
};

// Until the knee stands as the problem has it.
std::optional<linkage::UsedRange> RangeOf(const Links& links, const problem::SynthesisProblem& problem) {
  if (!linkage::SolvePose(links, problem.d_min_mm)) return std::nullopt;
  return linkage::FindUsedRange(links, problem.d_min_mm, std::nullopt, RadiansFromDegrees(problem.standing_deg));
}

Json PlaceJson(const Vector2d& place) {
  return {Rounded(place.x()), Rounded(place.y())};
}

// What is drawn of a pose; null where there is none.
Json PoseJson(const std::optional<Pose>& pose) {
  if (!pose) return {};
  const ThighAxes thigh(pose->theta_rad);
  return {{"thigh_pin", PlaceJson(thigh.ToPicture(pose->thigh_pin))},
          {"tip", PlaceJson(thigh.ToPicture(pose->tip))},
          {"shank_pin", PlaceJson(thigh.ToPicture(pose->shank_pin))},
          {"mount", PlaceJson(thigh.ToPicture(pose->mount))},
          {"thigh", PlaceJson(thigh.up)}};
}

// The link lengths that a dragged pin gives, and the stroke at which the other pins are where they were.
std::pair<Links, double> Dragged(const Links& links, const Json& drag) {
  const double stroke_mm = drag.at("stroke");
  const std::optional<Pose> pose = linkage::SolvePose(links, stroke_mm);
  if (!pose) throw Fail("there is no pose at a stroke of {:.2f} mm", stroke_mm);
  const ThighAxes thigh(pose->theta_rad);
  Pins pins = Pins::Of(*pose);
  const std::string name = drag.at("pin");
  Vector2d place{drag.at("x").get<double>(), drag.at("y").get<double>()};
  if (name == "shank_pin") place.x() = 0;
  place = thigh.FromPicture(place);
  if (name == "thigh_pin") place.x() = 0;
  pins.Named(name) = place;
  const Links dragged = pins.Between();
  linkage::CheckLinks(dragged, "there the linkage ends");
  // The same four places must be those of the closed form, not of another way to close the loops.
  const std::optional<Pose> now = linkage::SolvePose(dragged, pins.Stroke());
  constexpr double kSame_mm = 1e-3, kSame_rad = 1e-5;
  if (!now || (now->tip - pins.tip).norm() > kSame_mm || std::abs(now->theta_rad - pose->theta_rad) > kSame_rad)
    throw Error("there the linkage would fold over");
  return {dragged, pins.Stroke()};
}

// Where a family of requirements is worst.
Json WorstJson(const problem::RequirementCheck& check, const problem::SynthesisProblem& problem, double range_deg) {
  if (!check.requirement.IsFamily() || std::isnan(check.value)) return {};
  if (check.requirement.along_profile) return {{"percent", Rounded(100 * check.fraction)}};
  return {{"knee_deg", Rounded(std::lerp(problem.standing_deg, range_deg, check.fraction))}};
}

// The paper's form of Grashof's law, l3 + l4 <= l1 + l2, is the law where the order of the links holds. Links in
// another order are held to the law itself.
void HoldToLaw(const Links& links, problem::RequirementCheck& check) {
  if (check.requirement.name != problem::Requirement::kGrashof) return;
  check.value = std::min(check.value, linkage::GrashofOf(links).slack_mm);
  check.slack = check.requirement.Slack(check.value);
}

Json CheckJson(const problem::RequirementCheck& check, const problem::SynthesisProblem& problem, double range_deg) {
  const problem::Requirement& requirement = check.requirement;
  return {{"name", requirement.name},
          {"unit", requirement.unit},
          {"is_lower_limit", requirement.is_lower_limit},
          {"limit", Rounded(requirement.limit)},
          {"value", Rounded(check.value)},
          {"slack", Rounded(check.slack)},
          {"holds", check.Holds()},
          {"asked", true},
          {"worst", WorstJson(check, problem, range_deg)}};
}

// What a person needs of a design and the problem does not ask. `limit`: what it would be held to.
Json NotAskedJson(const char* name, const char* unit, double value, double limit, Json worst = nullptr) {
  return {{"name", name},
          {"unit", unit},
          {"is_lower_limit", true},
          {"limit", limit},
          {"value", Rounded(value)},
          {"slack", Rounded(value - limit)},
          {"holds", value >= limit},
          {"asked", false},
          {"worst", std::move(worst)}};
}

// On the problem's body, with its parts: whether one can sit down in it, and what is where leg and seat are.
Json WearJson(const Links& links, const problem::SynthesisProblem& problem) {
  Json checks = Json::array();
  const auto range = RangeOf(links, problem);
  if (!range) return checks;
  const double range_deg = DegreesFromRadians(range->theta_at_lower_rad);
  checks.push_back(NotAskedJson("seated angle", "deg", std::min(range_deg, kSeatedAngle_deg), kSeatedAngle_deg));
  linkage::WearOptions wear = problem.Wear();
  wear.placement_mm = problem.clearances.placement_mm;
  const linkage::WearCheck check = linkage::CheckWear(links, *range, person::BodyOf(problem.clearances.body), wear);
  const auto at = [](double knee_deg) { return Json{{"knee_deg", Rounded(knee_deg)}}; };
  const problem::Clearances& asked = problem.clearances;
  if (!asked.seat_mm && check.meets_seat)
    checks.push_back(NotAskedJson("clearance to the seat", "mm", check.seat_clearance_mm, 0, at(check.seated_deg)));
  if (!asked.thigh_mm && check.meets_limbs)
    checks.push_back(NotAskedJson("actuator's clearance to the thigh", "mm", check.thigh_clearance_mm, 0,
                                  at(check.thigh_clearance_deg)));
  if (!asked.shank_mm && check.meets_limbs)
    checks.push_back(NotAskedJson("actuator's clearance to the shank", "mm", check.shank_clearance_mm, 0,
                                  at(check.shank_clearance_deg)));
  checks.push_back(NotAskedJson("mount to hip", "mm", check.mount_below_hip_mm, 0));
  return checks;
}

// Where a person's motion is known.
Json MotionJson(const Links& links, const ExploredDesign& explored) {
  Json checks = Json::array();
  if (!explored.in_motion) return checks;
  const std::optional<InMotion> motion = explored.in_motion(links);
  const auto upper = [](const char* name, const char* unit, double value, std::optional<double> most) -> Json {
    constexpr double kRounding = 1e-3;
    const double limit = most.value_or(kNaN);
    return {{"name", name},
            {"unit", unit},
            {"is_lower_limit", false},
            {"limit", Rounded(limit)},
            {"value", Rounded(value)},
            {"slack", Rounded(limit - value)},
            {"holds", std::isfinite(value) && !(value > limit * (1 + kRounding))},
            {"asked", false},
            {"worst", Json()}};
  };
  checks.push_back(upper("misalignment at the saved knee angles", "%", motion ? motion->misalignment_percent : kNaN,
                         explored.max_misalignment_percent));
  checks.push_back(upper("rise at the saved knee angles", "s", motion ? motion->rise_s : kNaN, explored.max_rise_s));
  return checks;
}

Json BoundJson(std::size_t link, double value, double limit, bool is_lower_limit) {
  return {{"name", problem::LinkName(link)},
          {"unit", "mm"},
          {"is_lower_limit", is_lower_limit},
          {"limit", limit},
          {"value", Rounded(value)},
          {"slack", Rounded(is_lower_limit ? value - limit : limit - value)},
          {"holds", false},
          {"asked", true},
          {"worst", Json()}};
}

}  // namespace

namespace {

Links AnyLinksFrom(const Json& json) {
  if (!json.is_array() || json.size() != 6) throw Error("six links are asked for, l1 to l6");
  const auto values = json.get<std::array<double, 6>>();
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(std::isfinite(values[i]) && values[i] > 0))
      throw Fail("{} is {} mm: a length must be above 0", problem::LinkName(i), values[i]);
  return Links::FromValues(values);
}

}  // namespace

Links LinksFrom(const Json& json) {
  const Links links = AnyLinksFrom(json);
  linkage::CheckLinks(links, "the page");
  return links;
}

DesignExplorer::DesignExplorer(ExploredDesign explored) : explored_(std::move(explored)) {
  explored_.problem.clearances.placement_mm = explored_.design.placement_mm;
}

Json DesignExplorer::About() const {
  const problem::Clearances& clearances = explored_.problem.clearances;
  const person::Body body = person::BodyOf(clearances.body);
  const auto& [joint_x_mm, joint_y_mm] = clearances.placement_mm;
  const auto segment = [](const person::LimbSegment& limb) -> Json {
    return {{"length", limb.length_mm},
            {"proximal_radius", limb.proximal_radius_mm},
            {"distal_radius", limb.distal_radius_mm}};
  };
  Json bounds = Json::array();
  for (const problem::Bounds& bound : explored_.problem.bounds) bounds.push_back({bound.lower, bound.upper});
  return {{"name", explored_.name},
          {"links", explored_.design.links.Values()},
          {"bounds", bounds},
          {"d_min", explored_.problem.d_min_mm},
          {"standing_deg", explored_.problem.standing_deg},
          {"torque_nm", explored_.problem.knee_torque_nm},
          {"tolerance_mm", ValueOrNull(explored_.problem.robust_mm)},
          {"limits", explored_.limits},
          {"notes", explored_.notes},
          {"body",
           {{"knee", PlaceJson({-joint_x_mm, -joint_y_mm})},
            {"thigh", segment(body.thigh)},
            {"shank", segment(body.shank)}}}};
}

Json DesignExplorer::CurvesJson(const Links& links) const {
  const double d_min_mm = explored_.problem.d_min_mm;
  const auto range = RangeOf(links, explored_.problem),
             saved_range = RangeOf(explored_.design.links, explored_.problem);
  if (!range) return {};
  // As long as the longer of both, so that they can be compared.
  const double last_mm = std::max(range->stroke.upper_mm, saved_range ? saved_range->stroke.upper_mm : 0);
  const auto stroke = [&](std::size_t row) { return std::lerp(d_min_mm, last_mm, row / (kRows - 1.0)); };
  std::vector<At> now, saved;
  for (std::size_t row = 0; row < kRows; ++row) {
    const auto at = [&](const Links& of, const std::optional<linkage::UsedRange>& within) {
      const bool is_within = within && within->stroke.Contains(stroke(row));
      return At(of, is_within ? std::min(stroke(row), within->stroke.upper_mm) : kNaN,
                explored_.problem.knee_torque_nm);
    };
    now.push_back(at(links, range));
    saved.push_back(at(explored_.design.links, saved_range));
  }
  const auto columns = [&](const std::vector<At>& rows) -> Json {
    const auto column = [&](double At::*value) {
      return Column(kRows, [&](std::size_t row) { return rows[row].*value; });
    };
    return {{"knee", column(&At::knee_deg)},
            {"arm", column(&At::arm_mm)},
            {"force", column(&At::force_n)},
            {"transmission", column(&At::transmission_deg)}};
  };
  Json poses = Json::array();
  for (const At& at : now) poses.push_back(PoseJson(at.pose));
  return {{"stroke", Column(kRows, stroke)}, {"now", columns(now)}, {"saved", columns(saved)}, {"poses", poses}};
}

Json DesignExplorer::ChecksJson(const Links& links, bool of_builds) const {
  problem::SynthesisProblem problem = explored_.problem;
  if (!of_builds) problem.robust_mm.reset();
  const problem::DesignEvaluation evaluation = problem::Evaluate(links, problem);
  Json checks = Json::array();
  for (problem::RequirementCheck check : evaluation.checks) {
    HoldToLaw(links, check);
    checks.push_back(CheckJson(check, problem, evaluation.range_deg));
  }
  const auto values = links.Values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const problem::Bounds& bound = explored_.problem.bounds[i];
    if (values[i] < bound.lower - problem::kHoldsTo) checks.push_back(BoundJson(i, values[i], bound.lower, true));
    if (values[i] > bound.upper + problem::kHoldsTo) checks.push_back(BoundJson(i, values[i], bound.upper, false));
  }
  for (const Json& more : {WearJson(links, explored_.problem), MotionJson(links, explored_)})
    checks.insert(checks.end(), more.begin(), more.end());
  return {{"range_deg", Rounded(evaluation.range_deg)},
          {"stands", evaluation.stands_mm ? Rounded(*evaluation.stands_mm) : Json()},
          {"gap", evaluation.gap},
          {"checks", checks},
          {"of_builds", problem.robust_mm.has_value()}};
}

Json DesignExplorer::Explore(const Json& question) const {
  Links links = AnyLinksFrom(question.at("links"));  // also of a linkage that cannot be, which fails its limits
  Json stroke, pose;
  if (const auto drag = question.find("drag"); drag != question.end() && !drag->is_null()) {
    double stroke_mm = 0;
    std::tie(links, stroke_mm) = Dragged(links, *drag);
    stroke = stroke_mm;
    pose = PoseJson(linkage::SolvePose(links, stroke_mm));
  }
  Json message = ChecksJson(links, question.value("builds", false));
  message["links"] = links.Values();
  message["stroke"] = stroke;
  message["pose"] = pose;
  message["curves"] = CurvesJson(links);
  return message;
}

linkage::Design DesignExplorer::With(const Links& links) const {
  const problem::DesignEvaluation evaluation = problem::Evaluate(links, explored_.problem);
  if (!evaluation.pose) throw Fail("cannot be saved: {}", evaluation.gap);
  linkage::Design design = explored_.design;
  design.links = links;
  design.d_min_mm = explored_.problem.d_min_mm;
  design.mount = explored_.problem.mount;
  design.d_max_mm.reset();
  problem::TakeRange(evaluation, design);
  if (design.program && design.program->kind == linkage::StrokeProgram::Kind::kFree) design.program.reset();
  const bool is_feasible = evaluation.IsFeasible();
  design.made_by = fmt::format("lake-review {}{}", Version(), is_feasible ? "" : ": does not meet all requirements");
  return design;
}

}  // namespace lake::review
