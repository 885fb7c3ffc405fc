#include "lake/synthesis/synthesis_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/linkage/loop_equations.h"
#include "lake/linkage/wear.h"
#include "lake/problem/assistance.h"
#include "lake/problem/evaluate.h"

namespace lake::synthesis {
namespace {

// A pose is (stroke d, bar angle phi, knee angle theta) with the loop equations |R - M| = d, |R - S| = l1 as equality
// rows and alpha2 >= 0, beta2 >= 0 as branch rows. Where theta is not a variable of its own it is
//   theta = standing + fraction (range - standing),
// so a fixed set of fractions follows the used range while the range is optimised.

// Indices of a pose's variables, and where in the used range it is.
struct PoseVariables {
  LinkVariables links;
  int stroke, phi, range;
  double fraction = 1, standing_rad = 0;
  std::string place;              // as its rows are named: " at 0.25"
  std::array<double, 6> shift{};  // of a build whose links are off by this

  // l1..l6, stroke, phi, range: what the terms of a pose take.
  std::array<int, 9> All() const {
    return {links[0], links[1], links[2], links[3], links[4], links[5], stroke, phi, range};
  }
};

// What clears what at one pose: the variables of the pose, the limit and the placement of the exoskeleton's knee, and
// the pose where the program starts, on the body.
struct ClearancePose {
  PoseVariables pose;
  int limit;
  std::array<int, 2> placement;
  linkage::Pose start;
};

// Of products of three lengths divided by a length: brings rows near one.
constexpr double kAreaScale_mm2 = 1e4;

// A pose of the used range; v = l1..l6, stroke, phi, range. A build's links are off by `shift`.
struct OnUsedRange {
  double fraction, standing_rad;
  std::array<double, 6> shift;

  explicit OnUsedRange(const PoseVariables& pose)
      : fraction(pose.fraction), standing_rad(pose.standing_rad), shift(pose.shift) {}

  template <typename T>
  T Theta(const T* v) const {
    return v[8] * fraction + standing_rad * (1 - fraction);
  }
  template <typename T>
  std::array<T, 6> Links(const T* v) const {
    std::array<T, 6> links;
    for (std::size_t i = 0; i < links.size(); ++i) links[i] = v[i] + shift[i];
    return links;
  }
};

// What the rows of a pose are made of; a length or angle that a row does not read is zero.
template <typename T>
struct PoseValues {
  std::array<T, 6> links;
  T stroke, phi, theta;
};
template <typename T>
PoseValues(std::array<T, 6>, T, T, T) -> PoseValues<T>;

// The rows that every pose has: two loops and two branches. `read(v)` gives the pose's values from these variables.
template <int kRow, std::size_t N, typename Read>
void AddPoseRow(nlp::NonlinearProgram& program, const std::string& name, const std::array<int, N>& variables,
                Read read) {
  constexpr const char* kNames[] = {"actuator loop", "four-bar loop", "alpha2 ≥ 0", "beta2 ≥ 0"};
  program.AddConstraint(kNames[kRow] + name, 0, kRow < 2 ? 0 : nlp::kUnbounded, variables, [read](const auto* v) {
    const auto [links, stroke, phi, theta] = read(v);
    if constexpr (kRow < 2)
      return linkage::LoopResiduals(links.data(), stroke, phi, theta)[kRow];
    else
      return linkage::BranchExpressions(links.data(), phi, theta)[kRow - 2];
  });
}

int AddBarAngle(nlp::NonlinearProgram& program, const std::string& name, double start_rad) {
  return program.AddVariable("phi" + name, start_rad, 0, 2 * std::numbers::pi);
}

using linkage::Planar;

// A pin on the body, as linkage::PutOnBody and InLimb have it; v = l1..l6, stroke, phi, range, limit, placement x and
// y. In the axes of the shank the placement is what it is, mirrored.
template <typename T>
Planar<T> PinOnLimb(linkage::Limb limb, linkage::Pin pin, const OnUsedRange& pose, const T* v) {
  using std::cos, std::sin;
  const T theta = pose.Theta(v), sine = sin(theta), cosine = cos(theta);
  const auto l = pose.Links(v);
  const Planar<T> at =
      problem::PinAt<T>(pin, l.data(), {l[1] * sin(v[7]), l[1] * cos(v[7])}, {l[3] * sine, -l[3] * cosine});
  if (limb == linkage::Limb::kThigh)
    return {at.x - v[10] * cosine - v[11] * sine, at.y - v[10] * sine + v[11] * cosine};
  return {at.x * cosine + at.y * sine - v[10], at.x * sine - at.y * cosine - v[11]};
}

// Of lengths: brings rows near one.
constexpr double kClearanceScale_mm = 100;

template <std::size_t N, std::size_t M>
std::array<int, N + M> Joined(const std::array<int, N>& variables, const std::array<int, M>& others) {
  std::array<int, N + M> joined{};
  std::ranges::copy(others, std::ranges::copy(variables, joined.begin()).out);
  return joined;
}

// l1..l6, stroke, phi, range, limit, placement x and y.
std::array<int, 12> VariablesOf(const ClearancePose& at) {
  return Joined(at.pose.All(), std::array{at.limit, at.placement[0], at.placement[1]});
}

LinkVariables AddLinks(nlp::NonlinearProgram& program, const std::array<problem::Bounds, 6>& bounds,
                       const linkage::Links& start) {
  LinkVariables links{};
  for (std::size_t i = 0; i < links.size(); ++i)
    links[i] = program.AddVariable(problem::LinkName(i), start.Values()[i], bounds[i].lower, bounds[i].upper);
  return links;
}

// Adds phi and the rows of a pose; stroke and range are there already.
PoseVariables AddPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links, int stroke,
                      int range, double fraction, double standing_rad, double phi_start_rad,
                      const std::array<double, 6>& shift = {}) {
  const int phi = AddBarAngle(program, name, phi_start_rad);
  PoseVariables pose{.links = links,
                     .stroke = stroke,
                     .phi = phi,
                     .range = range,
                     .fraction = fraction,
                     .standing_rad = standing_rad,
                     .place = name,
                     .shift = shift};
  const auto read = [at = OnUsedRange(pose)](const auto* v) {
    return PoseValues{at.Links(v), v[6], v[7], at.Theta(v)};
  };
  AddPoseRow<0>(program, name, pose.All(), read);
  AddPoseRow<1>(program, name, pose.All(), read);
  AddPoseRow<2>(program, name, pose.All(), read);
  AddPoseRow<3>(program, name, pose.All(), read);
  return pose;
}

// u.R' > 0: bar and coupler are not in line, where the knee angle turns back and poses of two branches meet. The least
// sine that counts as not turning keeps the multiplied-out families away from 0 >= 0 where P, R and S are in line.
void AddNoTurningRow(nlp::NonlinearProgram& program, const PoseVariables& pose) {
  program.AddConstraint(
      "no turning" + pose.place, 0, nlp::kUnbounded, pose.All(), [at = OnUsedRange(pose)](const auto* v) {
        constexpr double kLeastSine = 5e-3;
        const auto vectors = linkage::LoopVectorsOf(at.Links(v).data(), v[7], at.Theta(v));
        return (linkage::Dot(vectors.coupler, vectors.tip_motion) - v[0] * v[1] * kLeastSine) / kAreaScale_mm2;
      });
}

// The ratios of the requirement at one pose, each as a row, against the variable `limit`; multiplied out (limits.h), so
// smooth also where the moment arm is infinite.
void AddRatioRows(nlp::NonlinearProgram& program, const problem::Requirement& requirement, const PoseVariables& pose,
                  int limit, const problem::PoseLoad& load) {
  const double scale = requirement.Info().is_relative ? program.Variables()[limit].start : 1;
  const auto add = [&](const char* part, auto ratio) {
    program.AddConstraint(fmt::format("{} of the {}{}", requirement.name, part, pose.place), 0, nlp::kUnbounded,
                          Joined(pose.All(), std::array{limit}),
                          [at = OnUsedRange(pose), info = requirement.Info(), scale, ratio]<typename T>(const T* v) {
                            using std::sin;
                            const problem::PoseQuantities<T> quantities(at.Links(v).data(), v[6], v[7], at.Theta(v));
                            const T value = info.is_sine ? T(sin(v[9] / kDegreesPerRadian)) : v[9];
                            return problem::MarginOf(info, value, problem::Ratio<T>(ratio(quantities)), scale);
                          });
  };
  problem::VisitLimit(requirement.row, [&](const auto& row) { row.parts(load, add); });
}

// Two convex outlines are `limit` apart if in some direction u = (cos, sin) they are; that separating direction is a
// variable, so that the rows are smooth and hold exactly where the distance does (linkage/wear.h).
//   u . (pin - corner) - radius >= limit                        for both pins of each part
void AddSeatRows(nlp::NonlinearProgram& program, const ClearancePose& at, const linkage::Seat& seat,
                 const linkage::WearOptions& wear) {
  const OnUsedRange pose(at.pose);
  for (const linkage::WornPart& part : linkage::WornPartsOf(wear)) {
    const linkage::Separation start = linkage::SeparationFrom(seat, part, at.start);
    const int direction =
        program.AddVariable("direction from the seat", start.direction_rad, std::numbers::pi, 1.5 * std::numbers::pi);
    for (const linkage::Pin pin : {part.from, part.to})
      program.AddConstraint("seat clearance", 0, nlp::kUnbounded, Joined(VariablesOf(at), std::array{direction}),
                            [=, radius_mm = part.radius_mm](const auto* v) {
                              using std::cos, std::sin;
                              const auto place = PinOnLimb(linkage::Limb::kThigh, pin, pose, v);
                              return ((place.x - seat.surface_mm) * cos(v[12]) + (place.y - seat.edge_mm) * sin(v[12]) -
                                      radius_mm - v[9]) /
                                     kClearanceScale_mm;
                            });
  }
}

//   u . pin - h - radius >= limit,  h >= u . corner             for the actuator's pins and the limb's corners
void AddLimbRows(nlp::NonlinearProgram& program, const ClearancePose& at, linkage::Limb limb, const person::Body& body,
                 const linkage::WearOptions& wear) {
  const std::string name = (limb == linkage::Limb::kThigh ? "thigh clearance" : "shank clearance") + at.pose.place;
  const linkage::WornPart actuator = linkage::WornPartsOf(wear)[0];
  const linkage::Separation start = linkage::LimbSeparation(limb, at.start, body, wear);
  const auto corners = linkage::OutlineOf(limb, body);
  double reach_mm = -nlp::kUnbounded;
  for (const Eigen::Vector2d& corner : corners)
    reach_mm =
        std::max(reach_mm, std::cos(start.direction_rad) * corner.x() + std::sin(start.direction_rad) * corner.y());
  const int direction =
      program.AddVariable("direction" + name, start.direction_rad, start.direction_rad - std::numbers::pi,
                          start.direction_rad + std::numbers::pi);
  const int reach = program.AddVariable("reach" + name, reach_mm, -nlp::kUnbounded, nlp::kUnbounded);
  const OnUsedRange pose(at.pose);
  for (const linkage::Pin pin : {actuator.from, actuator.to})
    program.AddConstraint(
        name, 0, nlp::kUnbounded, Joined(VariablesOf(at), std::array{direction, reach}), [=](const auto* v) {
          using std::cos, std::sin;
          const auto place = PinOnLimb(limb, pin, pose, v);
          return (place.x * cos(v[12]) + place.y * sin(v[12]) - v[13] - actuator.radius_mm - v[9]) / kClearanceScale_mm;
        });
  for (const Eigen::Vector2d& corner : corners)
    program.AddConstraint("reach for " + name, 0, nlp::kUnbounded, std::array{direction, reach},
                          [x = corner.x(), y = corner.y()](const auto* v) {
                            using std::cos, std::sin;
                            return (v[1] - cos(v[0]) * x - sin(v[0]) * y) / kClearanceScale_mm;
                          });
}

// l2 + d - l7, as a term of `row`; of the build for which it is least, if each length may be off by `off_mm`.
void AddSingularityTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links, int stroke,
                        double off_mm) {
  program.AddTerm(row, std::array{links[1], links[4], links[5], stroke}, [off_mm]<typename T>(const T* v) {
    using std::sqrt;
    const T l5 = v[1] + off_mm, l6 = v[2] + off_mm;
    return T(v[0] + v[3] - 2 * off_mm - sqrt(l5 * l5 + l6 * l6));
  });
}

// coefficients . X, as a term of `row`.
void AddLinearTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links,
                   const std::array<double, 6>& coefficients) {
  program.AddTerm(row, links, [coefficients]<typename T>(const T* v) {
    T sum = v[0] * coefficients[0];
    for (int i = 1; i < 6; ++i) sum += v[i] * coefficients[i];
    return sum;
  });
}

}  // namespace

linkage::Links LinksAt(const LinkVariables& links, const std::vector<double>& x) {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = x.at(links[i]);
  return linkage::Links::FromValues(values);
}

// There are many of these poses, so a row takes the variables that it reads and no others.
void AddProgramPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links,
                    const StrokeBetween& stroke, int theta, double phi_start_rad) {
  const auto& [l1, l2, l3, l4, l5, l6] = links;
  const int phi = AddBarAngle(program, name, phi_start_rad);
  AddPoseRow<0>(
      program, name, std::array{l2, l5, l6, phi, stroke.from, stroke.to},
      [weight = stroke.weight]<typename T>(const T* v) {
        return PoseValues<T>{{T{}, v[0], T{}, T{}, v[1], v[2]}, v[4] * (1 - weight) + v[5] * weight, v[3], T{}};
      });
  AddPoseRow<1>(program, name, std::array{l1, l2, l3, l4, phi, theta}, []<typename T>(const T* v) {
    return PoseValues<T>{{v[0], v[1], v[2], v[3]}, T{}, v[4], v[5]};
  });
  AddPoseRow<2>(program, name, std::array{l2, l5, l6, phi}, []<typename T>(const T* v) {
    return PoseValues<T>{{T{}, v[0], T{}, T{}, v[1], v[2]}, T{}, v[3], T{}};
  });
  AddPoseRow<3>(program, name, std::array{l2, l3, l4, phi, theta}, []<typename T>(const T* v) {
    return PoseValues<T>{{T{}, v[0], v[1], v[2]}, T{}, v[3], v[4]};
  });
}

void AddScaledTerm(nlp::NonlinearProgram& program, int row, int variable, double factor) {
  program.AddTerm(row, std::array{variable}, [factor](const auto* v) { return v[0] * factor; });
}

int AddLinearRow(nlp::NonlinearProgram& program, const std::string& name, double lower, double upper,
                 std::initializer_list<ScaledVariable> terms) {
  const int row = program.AddRow(name, lower, upper);
  for (const auto& [variable, factor] : terms) AddScaledTerm(program, row, variable, factor);
  return row;
}

namespace {

using problem::Place;
constexpr double kShortest_mm = 1, kLongest_mm = 1e4;  // bounds that give way, and strokes, stay within

// Where the variables of a pose start: on the linkage where it can be assembled, else at a plausible place.
struct PoseStart {
  double stroke_mm, phi_rad, theta_rad;
};

PoseStart StartAtRange(const problem::SynthesisProblem& problem, const linkage::Links& start) {
  if (const auto pose = linkage::SolvePose(start, problem.d_min_mm))
    return {problem.d_min_mm, pose->phi_rad, pose->theta_rad};
  constexpr double kPlausiblePhi_rad = 0.6, kPlausibleTheta_rad = 1.5;
  return {problem.d_min_mm, kPlausiblePhi_rad, kPlausibleTheta_rad};
}

class Builder {
 public:
  Builder(const problem::SynthesisProblem& problem, const linkage::Links& start, Elasticity elasticity,
          double range_weight)
      : problem_(problem),
        start_(start),
        elasticity_(elasticity),
        range_weight_(range_weight),
        at_range_(StartAtRange(problem, start)) {
    current_.links = start;
  }

  SynthesisProgram Build(const Collocation& poses) {
    AddLinksAndStroke();
    if (problem_.clearances.AreAsked()) AddPlacement();
    AddShortestPose();
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) AddRequirement(requirement);
    AddShortestRows();
    AddPoses(poses);
    for (const problem::BuildError& error : poses.builds) AddBuild(error, poses);
    if (!IsElastic()) AddGoal();
    return std::move(result_);
  }

 private:
  // What the poses that are added are of: the design as asked for, or a build.
  struct Current {
    linkage::Links links;  // where the program starts
    double d_min_off_mm = 0;
    std::array<double, 6> shift{};
    int range = -1;
    std::string name;
  };

  void AddPoses(const Collocation& poses) {
    AddUsedRange(poses.fractions);
    AddSeated();
    AddProfile(poses.samples);
  }

  // A build's own shortest stroke and range, and everything that poses have to satisfy.
  void AddBuild(const problem::BuildError& error, const Collocation& poses) {
    const problem::SynthesisProblem of_build = problem::ProblemOf(error, problem_);
    current_ = {.links = problem::LinksOf(error, start_),
                .d_min_off_mm = error.back(),
                .name = fmt::format(" of build {}", ++builds_)};
    std::copy_n(error.begin(), current_.shift.size(), current_.shift.begin());
    at_range_ = StartAtRange(of_build, current_.links);
    const std::string& name = current_.name;
    const int stroke = nlp().AddVariable("d_min" + name, of_build.d_min_mm, kShortest_mm, kLongest_mm);
    AddLinearRow(nlp(), "d_min" + name, error.back(), error.back(), {{stroke, 1}, {result_.shortest_stroke, -1}});
    current_.range = nlp().AddVariable("theta" + name, at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    poses_ = {AddPose(nlp(), name, result_.links, stroke, current_.range, 1, RadiansFromDegrees(problem_.standing_deg),
                      at_range_.phi_rad, current_.shift)};
    AddLinearRow(nlp(), "range" + name, 0, nlp::kUnbounded, {{current_.range, 1}, {result_.worst_range, -1}});
    AddShortestRows();
    AddPoses(poses);
  }

  // What holds at the shortest stroke of the current build.
  void AddShortestRows() {
    AddRows(poses_.front(), problem_.ConstantLoad(),
            [](const problem::Requirement& requirement) { return requirement.Info().place == Place::kShortest; });
  }

  // Of the requirements that hold at a pose.
  template <typename Holds>
  void AddRows(const PoseVariables& pose, problem::PoseLoad load, const Holds& holds) {
    load.closed_error_mm = current_.d_min_off_mm;
    for (const RequirementRow& entry : result_.requirements) {
      if (!holds(entry.requirement)) continue;
      if (entry.requirement.IsClearance())
        AddClearance(entry, pose);
      else
        AddRatioRows(nlp(), entry.requirement, pose, entry.family_limit, load);
    }
  }

  // A pose of the current build on its way, at a fraction of the range from `standing_rad` on.
  PoseVariables AddPoseAt(const std::string& place, double fraction, double standing_rad) {
    const std::string name = place + current_.name;
    const PoseStart start = StartOf(std::lerp(standing_rad, at_range_.theta_rad, fraction));
    const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
    PoseVariables pose = AddPose(nlp(), name, result_.links, stroke, current_.range, fraction, standing_rad,
                                 start.phi_rad, current_.shift);
    AddNoTurningRow(nlp(), pose);
    return pose;
  }

  nlp::NonlinearProgram& nlp() { return result_.program; }
  bool IsElastic() const { return elasticity_ != Elasticity::kNone; }

  // A slack for a row whose limit may be moved.
  int AddSlack(int row, const std::string& name, bool is_lower_limit, double unit) {
    const int slack = nlp().AddVariable("slack of " + name, 0, 0, nlp::kUnbounded);
    AddScaledTerm(nlp(), row, slack, is_lower_limit ? 1 : -1);
    AddScaledTerm(nlp(), nlp::NlpTerm::kCost, slack, 1 / unit);
    return slack;
  }

  void AddElasticBound(int variable, const std::string& name, double limit, bool is_lower_limit) {
    const std::string text = fmt::format("{} {} {} mm", name, is_lower_limit ? "≥" : "≤", SignificantText(limit, 6));
    const int row = AddLinearRow(nlp(), text, is_lower_limit ? limit : -nlp::kUnbounded,
                                 is_lower_limit ? nlp::kUnbounded : limit, {{variable, 1}});
    result_.elastic_bounds.push_back({text, limit, is_lower_limit, AddSlack(row, text, is_lower_limit, 1), row});
  }

  void AddLinksAndStroke() {
    const bool wide = elasticity_ == Elasticity::kEverything;
    std::array<problem::Bounds, 6> bounds = problem_.bounds;
    if (wide) bounds.fill({kShortest_mm, kLongest_mm});
    result_.links = AddLinks(nlp(), bounds, start_);
    const double d = problem_.d_min_mm;
    result_.shortest_stroke = nlp().AddVariable("d_min", d, wide ? kShortest_mm : d, wide ? kLongest_mm : d);
    for (int i = 0; i < 6; ++i) result_.limits.push_back({{LimitId::kLink, i}, "mm", -1, result_.links[i]});
    result_.limits.push_back({{LimitId::kShortestStroke}, "mm", -1, result_.shortest_stroke});
    if (!wide) return;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].lower, true);
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].upper, false);
    }
    AddElasticBound(result_.shortest_stroke, "d_min", d, true);
    AddElasticBound(result_.shortest_stroke, "d_min", d, false);
  }

  void AddPlacement() {
    const problem::Clearances& clearances = problem_.clearances;
    for (int axis = 0; axis < 2; ++axis) {
      const double start = clearances.placement_mm[axis];
      const double reach = clearances.placement_reach_mm.value_or(0);
      result_.placement[axis] = nlp().AddVariable(axis == 0 ? "placement_x" : "placement_y", start,
                                                  reach > 0 ? -reach : start, reach > 0 ? reach : start);
    }
  }

  void AddShortestPose() {
    result_.range = nlp().AddVariable("theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    current_.range = result_.range;
    if (problem_.robust_mm) AddWorstRange();
    poses_.push_back(AddPose(nlp(), "", result_.links, result_.shortest_stroke, result_.range, 1,
                             RadiansFromDegrees(problem_.standing_deg), at_range_.phi_rad));
  }

  void AddWorstRange() {
    result_.worst_range = nlp().AddVariable("worst theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    AddLinearRow(nlp(), "range as asked for", 0, nlp::kUnbounded, {{result_.range, 1}, {result_.worst_range, -1}});
  }

  // By how much the worst build is worse in a requirement on the links.
  double Loss(const problem::Requirement& requirement) const {
    double sum = 0;
    for (const double coefficient : requirement.Info().coefficients) sum += std::abs(coefficient);
    return sum * problem_.robust_mm.value_or(0);
  }

  void AddRequirement(const problem::Requirement& requirement) {
    const double limit = requirement.limit + (requirement.IsLinear() ? Loss(requirement) : 0);
    RequirementRow& entry = result_.requirements.emplace_back(RequirementRow{requirement});
    const bool is_on_links = requirement.IsOnLinks();
    // The loop implies it; as a row of its own it would have the loop's gradient and multipliers without bound.
    if (is_on_links && !requirement.IsLinear() && limit == 0 && !problem_.robust_mm && !IsElastic()) return;
    // A limit on poses is a variable of the program, so that its row carries the one multiplier of all poses.
    entry.row =
        nlp().AddRow(requirement.Text(), IsSought(requirement) ? 0 : limit, is_on_links ? nlp::kUnbounded : limit);
    result_.limits.push_back({{requirement.name}, requirement.unit, entry.row});
    if (requirement.IsLinear())
      AddLinearTerm(nlp(), entry.row, result_.links, requirement.Info().coefficients);
    else if (is_on_links)
      AddSingularityTerm(nlp(), entry.row, result_.links, result_.shortest_stroke, problem_.robust_mm.value_or(0));
    if (!is_on_links) {
      const double start = IsSought(requirement) ? StartDuration() : limit;
      entry.family_limit =
          nlp().AddVariable("limit of " + std::string(requirement.name), start, -nlp::kUnbounded, nlp::kUnbounded);
      AddScaledTerm(nlp(), entry.row, entry.family_limit, 1);
    }
    // Angles that the linkage does not reach have no force that could be held against a limit.
    const bool is_reach = requirement.Info().place == Place::kShortest && requirement.is_lower_limit;
    if (IsElastic() && !is_reach)
      entry.slack =
          AddSlack(entry.row, std::string(requirement.name), requirement.is_lower_limit, SlackUnit(requirement));
  }

  // It is what is minimised, and its limit no more than a bound.
  bool IsSought(const problem::Requirement& requirement) const { return requirement.is_sought && !IsElastic(); }

  // The links' own, where they can make the motion at all.
  double StartDuration() const {
    constexpr double kPlausible_s = 20, kLeast_s = 0.1, kMost_s = 600;
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) {
      if (!requirement.is_sought) continue;
      const auto worst = problem::UsedPoses(start_, problem_).WorstPoints(requirement);
      if (!worst.empty() && std::isfinite(worst.front().value))
        return std::clamp(worst.front().value, kLeast_s, kMost_s);
    }
    return kPlausible_s;
  }

  void AddGoal() {
    constexpr double kTie = 1e-6;  // s per deg
    const bool is_duration = problem_.SeeksDuration();
    AddScaledTerm(nlp(), nlp::NlpTerm::kCost, problem_.robust_mm ? result_.worst_range : result_.range,
                  -range_weight_ * (is_duration ? kTie : 1) * kDegreesPerRadian);
    for (const RequirementRow& entry : result_.requirements)
      if (IsSought(entry.requirement)) AddScaledTerm(nlp(), nlp::NlpTerm::kCost, entry.family_limit, 1);
  }

  // Poses at samples of the load profile, whose knee angles are given, with the families that hold there.
  void AddProfile(const std::vector<int>& samples) {
    for (const int i : samples) {
      const problem::LoadSample& sample = problem_.profile->samples[i];
      const PoseVariables pose =
          AddPoseAt(fmt::format(" at {} %", SignificantText(sample.percent, 4)), /*fraction=*/0, sample.knee_rad);
      AddRows(pose, problem_.LoadAt(sample), [&](const problem::Requirement& requirement) {
        return requirement.along_profile && HoldsAt(requirement, sample);
      });
    }
  }

  bool HoldsAt(const problem::Requirement& requirement, const problem::LoadSample& sample) const {
    if (requirement.Info().place == Place::kProfile) return true;
    if (problem_.TorqueAt(sample) == 0) return false;
    return requirement.Info().place != Place::kAtRest || problem_.rests_anywhere ||
           &sample == &problem_.profile->samples[problem::SamplesInUse(problem_).back()];
  }

  void AddUsedRange(std::vector<double> fractions) {
    const bool stands = std::ranges::any_of(
        result_.requirements, [](const RequirementRow& entry) { return entry.requirement.NeedsStanding(); });
    if (!stands) return;
    constexpr double kStanding = 0;
    fractions.push_back(kStanding);
    std::sort(fractions.begin(), fractions.end());
    fractions.erase(std::unique(fractions.begin(), fractions.end()), fractions.end());
    AddNoTurningRow(nlp(), poses_.front());
    for (const double fraction : fractions)
      poses_.push_back(AddPoseAt(fmt::format(" at {}", SignificantText(fraction, 4)), fraction,
                                 RadiansFromDegrees(problem_.standing_deg)));
    for (const PoseVariables& pose : poses_)
      AddRows(pose, problem_.ConstantLoad(), [&](const problem::Requirement& requirement) {
        const Place place = requirement.Info().place;
        if (place == Place::kStanding) return pose.fraction == kStanding;
        return requirement.IsFamily() && !requirement.along_profile && place != Place::kSeated;
      });
  }

  // Where the current build is at a knee angle, or else a plausible place.
  PoseStart StartOf(double theta_rad) const {
    const double standing = RadiansFromDegrees(problem_.standing_deg);
    const double d_min_mm = problem_.d_min_mm + current_.d_min_off_mm;
    if (linkage::SolvePose(current_.links, d_min_mm)) {
      const linkage::UsedRange range = linkage::FindUsedRange(current_.links, d_min_mm, std::nullopt, standing);
      const auto stroke = linkage::StrokeForAngle(current_.links, range, theta_rad);
      const auto pose = stroke ? linkage::SolvePose(current_.links, *stroke) : std::nullopt;
      if (pose) return {*stroke, pose->phi_rad, theta_rad};
    }
    constexpr double kPlausibleTravel_mm = 120;
    const double fraction = (theta_rad - standing) / (at_range_.theta_rad - standing);
    return {d_min_mm + (1 - fraction) * kPlausibleTravel_mm, std::lerp(std::numbers::pi, at_range_.phi_rad, fraction),
            theta_rad};
  }

  void AddClearance(const RequirementRow& entry, const PoseVariables& pose) {
    const problem::Obstacle obstacle = entry.requirement.Info().obstacle;
    const person::Body body = person::BodyOf(problem_.clearances.body);
    const linkage::WearOptions wear = problem_.Wear();
    if (obstacle == problem::Obstacle::kSeat)
      AddSeatRows(nlp(), At(pose, entry), linkage::SeatOf(body, wear), wear);
    else
      AddLimbRows(nlp(), At(pose, entry),
                  obstacle == problem::Obstacle::kThigh ? linkage::Limb::kThigh : linkage::Limb::kShank, body, wear);
  }

  // The pose of sitting, with what holds there.
  void AddSeated() {
    const auto is_seated = [](const problem::Requirement& requirement) {
      return requirement.Info().place == Place::kSeated;
    };
    if (std::ranges::none_of(result_.requirements, is_seated, &RequirementRow::requirement)) return;
    AddRows(AddPoseAt(" seated", /*fraction=*/0, problem_.SeatedAngle_rad()), problem_.ConstantLoad(), is_seated);
  }

  // The pose as the program starts, on the body.
  ClearancePose At(const PoseVariables& pose, const RequirementRow& entry) const {
    const auto start_of = [&](int variable) { return result_.program.Variables()[variable].start; };
    const double phi = start_of(pose.phi);
    linkage::Pose start;
    start.theta_rad = std::lerp(pose.standing_rad, start_of(pose.range), pose.fraction);
    start.knee = {0, 0};
    start.thigh_pin = {0, current_.links.l3};
    start.tip = start.thigh_pin + current_.links.l2 * Eigen::Vector2d(std::sin(phi), std::cos(phi));
    start.shank_pin = current_.links.l4 * Eigen::Vector2d(std::sin(start.theta_rad), -std::cos(start.theta_rad));
    start.mount = start.thigh_pin + Eigen::Vector2d(current_.links.l5, current_.links.l6);
    return {pose, entry.family_limit, result_.placement, linkage::PutOnBody(start, problem_.clearances.placement_mm)};
  }

  const problem::SynthesisProblem& problem_;
  const linkage::Links start_;
  const Elasticity elasticity_;
  const double range_weight_;
  PoseStart at_range_;  // of what the current poses are of
  Current current_;
  int builds_ = 0;
  SynthesisProgram result_;
  std::vector<PoseVariables> poses_;
};

}  // namespace

const Limit* SynthesisProgram::Find(const LimitId& id) const {
  const auto found = std::ranges::find(limits, id, &Limit::id);
  return found == limits.end() ? nullptr : &*found;
}

problem::SynthesisProblem Placed(problem::SynthesisProblem problem, const SynthesisProgram& program,
                                 const std::vector<double>& x) {
  if (program.placement[0] < 0) return problem;
  for (int axis = 0; axis < 2; ++axis) problem.clearances.placement_mm[axis] = x[program.placement[axis]];
  return problem;
}

double SlackUnit(const problem::Requirement& requirement) {
  return requirement.Info().is_relative ? requirement.limit / 100 : 1;
}

SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const Collocation& poses, Elasticity elasticity, double range_weight) {
  return Builder(problem, start, elasticity, range_weight).Build(poses);
}

}  // namespace lake::synthesis
