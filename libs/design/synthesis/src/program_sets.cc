#include "lake/synthesis/program_sets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/linkage/loop_equations.h"

namespace lake::synthesis {
namespace {

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

}  // namespace

LinkVariables AddLinks(nlp::NonlinearProgram& program, const std::array<problem::Bounds, 6>& bounds,
                       const linkage::Links& start) {
  LinkVariables links{};
  for (std::size_t i = 0; i < links.size(); ++i)
    links[i] = program.AddVariable(problem::LinkName(i), start.Values()[i], bounds[i].lower, bounds[i].upper);
  return links;
}

linkage::Links LinksAt(const LinkVariables& links, const std::vector<double>& x) {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = x.at(links[i]);
  return linkage::Links::FromValues(values);
}

std::array<int, 9> PoseVariables::All() const {
  return {links[0], links[1], links[2], links[3], links[4], links[5], stroke, phi, range};
}

PoseVariables AddPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links, int stroke,
                      int range, double fraction, double standing_rad, double phi_start_rad,
                      const std::array<double, 6>& shift) {
  const int phi = AddBarAngle(program, name, phi_start_rad);
  const PoseVariables pose{.links = links,
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

// The least sine that counts as not turning keeps the multiplied-out families away from 0 >= 0 where P, R and S are in
// line.
void AddNoTurningRow(nlp::NonlinearProgram& program, const PoseVariables& pose) {
  program.AddConstraint(
      "no turning" + pose.place, 0, nlp::kUnbounded, pose.All(), [at = OnUsedRange(pose)](const auto* v) {
        constexpr double kLeastSine = 5e-3;
        const auto vectors = linkage::LoopVectorsOf(at.Links(v).data(), v[7], at.Theta(v));
        return (linkage::Dot(vectors.coupler, vectors.tip_motion) - v[0] * v[1] * kLeastSine) / kAreaScale_mm2;
      });
}

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

void AddLinearTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links,
                   const std::array<double, 6>& coefficients) {
  program.AddTerm(row, links, [coefficients]<typename T>(const T* v) {
    T sum = v[0] * coefficients[0];
    for (int i = 1; i < 6; ++i) sum += v[i] * coefficients[i];
    return sum;
  });
}

void AddSingularityTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links, int stroke,
                        double off_mm) {
  program.AddTerm(row, std::array{links[1], links[4], links[5], stroke}, [off_mm]<typename T>(const T* v) {
    using std::sqrt;
    const T l5 = v[1] + off_mm, l6 = v[2] + off_mm;
    return T(v[0] + v[3] - 2 * off_mm - sqrt(l5 * l5 + l6 * l6));
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

}  // namespace lake::synthesis
