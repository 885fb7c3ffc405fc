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

// What the rows of a pose are made of; a length or angle that a row does not read is zero.
template <typename T>
struct PoseValues {
  T links[6]{}, stroke{}, phi{}, theta{};
};

// A pose of the used range; v = l1..l6, stroke, phi, range. A build's links are off by `shift`.
struct OnUsedRange {
  double fraction, standing_rad;
  std::array<double, 6> shift;

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
  template <typename T>
  linkage::LoopVectors<T> Vectors(const T* v) const {
    return linkage::LoopVectorsOf(Links(v).data(), v[7], Theta(v));
  }
  template <typename T>
  PoseValues<T> operator()(const T* v) const {
    const std::array<T, 6> links = Links(v);
    return {{links[0], links[1], links[2], links[3], links[4], links[5]}, v[6], v[7], Theta(v)};
  }
};

OnUsedRange PlaceOf(const PoseVariables& pose) {
  return {pose.fraction, pose.standing_rad, pose.shift};
}

// A pose of a stroke program. There are many of these, so a row takes the variables that it reads and no others:
// v = l2, l5, l6, phi and, for the loop, the strokes of two knots.
template <bool kReadsStroke>
struct ActuatorSide {
  double weight;

  template <typename T>
  PoseValues<T> operator()(const T* v) const {
    PoseValues<T> pose{{T{}, v[0], T{}, T{}, v[1], v[2]}, T{}, v[3], T{}};
    if constexpr (kReadsStroke) pose.stroke = v[4] * (1 - weight) + v[5] * weight;
    return pose;
  }
};

// v = l1 for the loop, l2, l3, l4, phi, theta.
template <bool kReadsCoupler>
struct ShankSide {
  template <typename T>
  PoseValues<T> operator()(const T* v) const {
    const T* w = kReadsCoupler ? v + 1 : v;
    return {{kReadsCoupler ? v[0] : T{}, w[0], w[1], w[2], T{}, T{}}, T{}, w[3], w[4]};
  }
};

struct LoopRow {
  int loop;
  template <typename T>
  T operator()(const PoseValues<T>& pose) const {
    return linkage::LoopResiduals(pose.links, pose.stroke, pose.phi, pose.theta)[loop];
  }
};

struct BranchRow {
  int triangle;
  template <typename T>
  T operator()(const PoseValues<T>& pose) const {
    return linkage::BranchExpressions(pose.links, pose.phi, pose.theta)[triangle];
  }
};

// The variables that a row reads, and the pose that follows from them.
template <std::size_t N, typename Layout>
struct Reading {
  std::array<int, N> variables;
  Layout layout;
};

template <typename Layout, typename Row>
struct PoseTerm {
  Layout layout;
  Row row;
  template <typename T>
  T operator()(const T* v) const {
    return row(layout(v));
  }
};

template <std::size_t N, typename Layout, typename Row>
void AddPoseRow(nlp::NonlinearProgram& program, const std::string& name, double upper,
                const Reading<N, Layout>& reading, Row row) {
  program.AddConstraint(name, 0, upper, reading.variables, PoseTerm<Layout, Row>{reading.layout, row});
}

// The rows that every pose has, each with what it reads.
template <typename ActuatorLoop, typename FourBarLoop, typename ActuatorBranch, typename ShankBranch>
void AddPoseRows(nlp::NonlinearProgram& program, const std::string& name, const ActuatorLoop& actuator_loop,
                 const FourBarLoop& four_bar_loop, const ActuatorBranch& actuator_branch,
                 const ShankBranch& shank_branch) {
  AddPoseRow(program, "actuator loop" + name, 0, actuator_loop, LoopRow{0});
  AddPoseRow(program, "four-bar loop" + name, 0, four_bar_loop, LoopRow{1});
  AddPoseRow(program, "alpha2 ≥ 0" + name, nlp::kUnbounded, actuator_branch, BranchRow{0});
  AddPoseRow(program, "beta2 ≥ 0" + name, nlp::kUnbounded, shank_branch, BranchRow{1});
}

int AddBarAngle(nlp::NonlinearProgram& program, const std::string& name, double start_rad) {
  return program.AddVariable("phi" + name, start_rad, 0, 2 * std::numbers::pi);
}

// The least sine that counts as not turning keeps the multiplied-out families away from 0 >= 0 where P, R and S are in
// line.
struct NoTurningTerm : OnUsedRange {
  template <typename T>
  T operator()(const T* v) const {
    constexpr double kLeastSine = 5e-3;
    const auto vectors = Vectors(v);
    return (linkage::Dot(vectors.coupler, vectors.tip_motion) - v[0] * v[1] * kLeastSine) / kAreaScale_mm2;
  }
};

// A ratio of a pose's quantities against the limit v[9].
template <typename RatioOf>
struct LimitTerm : OnUsedRange {
  problem::LimitInfo info;
  double scale;
  RatioOf ratio;
  template <typename T>
  T operator()(const T* v) const {
    using std::sin;
    const problem::PoseQuantities<T> pose(Links(v).data(), v[6], v[7], Theta(v));
    const T limit = info.is_sine ? sin(v[9] / kDegreesPerRadian) : v[9];
    return problem::MarginOf(info, limit, problem::Ratio<T>(ratio(pose)), scale);
  }
};

using linkage::Planar;

// The pins in the thigh frame of the exoskeleton; v = l1..l6, phi.
template <typename T>
Planar<T> PinAt(linkage::Pin pin, const T* l, const T& phi, const T& theta) {
  using std::cos, std::sin;
  switch (pin) {
    case linkage::kPinK:
      return {T{}, T{}};
    case linkage::kPinP:
      return {T{}, l[2]};
    case linkage::kPinR:
      return {l[1] * sin(phi), l[2] + l[1] * cos(phi)};
    case linkage::kPinS:
      return {l[3] * sin(theta), -l[3] * cos(theta)};
    default:
      return {l[4], l[2] + l[5]};
  }
}

// A pin as linkage::PutOnBody and InLimb have it; v = l1..l6, stroke, phi, range, limit, placement x and y.
struct PinOnBody : OnUsedRange {
  linkage::Pin pin;

  // In the axes of the shank the placement is what it is, mirrored.
  template <typename T>
  Planar<T> InShank(const T* v) const {
    using std::cos, std::sin;
    const T theta = Theta(v), sine = sin(theta), cosine = cos(theta);
    const Planar<T> at = PinAt(pin, Links(v).data(), v[7], theta);
    return {at.x * cosine + at.y * sine - v[10], at.x * sine - at.y * cosine - v[11]};
  }
  template <typename T>
  Planar<T> InThigh(const T* v) const {
    using std::cos, std::sin;
    const T theta = Theta(v), sine = sin(theta), cosine = cos(theta);
    const Planar<T> at = PinAt(pin, Links(v).data(), v[7], theta);
    return {at.x - v[10] * cosine - v[11] * sine, at.y - v[10] * sine + v[11] * cosine};
  }
};

// Of lengths: brings rows near one.
constexpr double kClearanceScale_mm = 100;

// v[12] is the separating direction.
struct SeatTerm : PinOnBody {
  double corner_x, corner_y, radius_mm;
  template <typename T>
  T operator()(const T* v) const {
    using std::cos, std::sin;
    const Planar<T> at = InThigh(v);
    return ((at.x - corner_x) * cos(v[12]) + (at.y - corner_y) * sin(v[12]) - radius_mm - v[9]) / kClearanceScale_mm;
  }
};

// v[12] is the separating direction, v[13] the limb's reach in its direction.
struct LimbTerm : PinOnBody {
  linkage::Limb limb;
  double radius_mm;
  template <typename T>
  T operator()(const T* v) const {
    using std::cos, std::sin;
    const Planar<T> at = limb == linkage::Limb::kThigh ? InThigh(v) : InShank(v);
    return (at.x * cos(v[12]) + at.y * sin(v[12]) - v[13] - radius_mm - v[9]) / kClearanceScale_mm;
  }
};

// v = separating direction, reach.
struct CornerTerm {
  double x, y;
  template <typename T>
  T operator()(const T* v) const {
    using std::cos, std::sin;
    return (v[1] - cos(v[0]) * x - sin(v[0]) * y) / kClearanceScale_mm;
  }
};

// l1..l6, stroke, phi, range, limit, placement, and others.
template <std::size_t N>
std::array<int, 12 + N> With(const ClearancePose& at, const std::array<int, N>& others) {
  const auto pose = at.pose.All();
  std::array<int, 12 + N> variables{};
  auto next = std::copy(pose.begin(), pose.end(), variables.begin());
  *next++ = at.limit;
  *next++ = at.placement[0];
  *next++ = at.placement[1];
  std::copy(others.begin(), others.end(), next);
  return variables;
}

// The variables of a pose and one more.
std::array<int, 10> With(const PoseVariables& pose, int variable) {
  const auto pose_variables = pose.All();
  std::array<int, 10> variables{};
  std::copy(pose_variables.begin(), pose_variables.end(), variables.begin());
  variables[9] = variable;
  return variables;
}

struct LinearTerm {
  std::array<double, 6> coefficients;
  template <typename T>
  T operator()(const T* v) const {
    T sum = v[0] * coefficients[0];
    for (int i = 1; i < 6; ++i) sum += v[i] * coefficients[i];
    return sum;
  }
};

struct SingularityTerm {
  double off_mm;
  template <typename T>
  T operator()(const T* v) const {  // l2, l5, l6, d
    using std::sqrt;
    const T l5 = v[1] + off_mm, l6 = v[2] + off_mm;
    return v[0] + v[3] - 2 * off_mm - sqrt(l5 * l5 + l6 * l6);
  }
};

struct ScaledTerm {
  double factor;
  template <typename T>
  T operator()(const T* v) const {
    return v[0] * factor;
  }
};

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
  const Reading<9, OnUsedRange> all{pose.All(), PlaceOf(pose)};
  AddPoseRows(program, name, all, all, all, all);
  return pose;
}

void AddProgramPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links,
                    const StrokeBetween& stroke, int theta, double phi_start_rad) {
  const auto& [l1, l2, l3, l4, l5, l6] = links;
  const int phi = AddBarAngle(program, name, phi_start_rad);
  AddPoseRows(program, name, Reading<6, ActuatorSide<true>>{{l2, l5, l6, phi, stroke.from, stroke.to}, {stroke.weight}},
              Reading<6, ShankSide<true>>{{l1, l2, l3, l4, phi, theta}, {}},
              Reading<4, ActuatorSide<false>>{{l2, l5, l6, phi}, {stroke.weight}},
              Reading<5, ShankSide<false>>{{l2, l3, l4, phi, theta}, {}});
}

void AddNoTurningRow(nlp::NonlinearProgram& program, const PoseVariables& pose) {
  const OnUsedRange at = PlaceOf(pose);
  program.AddConstraint("no turning" + pose.place, 0, nlp::kUnbounded, pose.All(), NoTurningTerm{at});
}

void AddRatioRows(nlp::NonlinearProgram& program, const problem::Requirement& requirement, const PoseVariables& pose,
                  int limit, const problem::PoseLoad& load) {
  const double scale = requirement.Info().is_relative ? program.Variables()[limit].start : 1;
  problem::VisitLimit(static_cast<std::size_t>(requirement.row), [&](const auto& row) {
    row.parts(load, [&](const char* part, auto ratio) {
      program.AddConstraint(fmt::format("{} of the {}{}", requirement.name, part, pose.place), 0, nlp::kUnbounded,
                            With(pose, limit), LimitTerm<decltype(ratio)>{PlaceOf(pose), row.info, scale, ratio});
    });
  });
}

void AddSeatRows(nlp::NonlinearProgram& program, const ClearancePose& at, const linkage::Seat& seat,
                 const linkage::WearOptions& wear) {
  const OnUsedRange place = PlaceOf(at.pose);
  for (const linkage::WornPart& part : linkage::WornPartsOf(wear)) {
    const linkage::Separation start = linkage::SeparationFrom(seat, part, at.start);
    const int direction =
        program.AddVariable("direction from the seat", start.direction_rad, std::numbers::pi, 1.5 * std::numbers::pi);
    for (const linkage::Pin pin : {part.from, part.to})
      program.AddConstraint("seat clearance", 0, nlp::kUnbounded, With(at, std::array{direction}),
                            SeatTerm{{place, pin}, seat.surface_mm, seat.edge_mm, part.radius_mm});
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
  const OnUsedRange place = PlaceOf(at.pose);
  for (const linkage::Pin pin : {actuator.from, actuator.to})
    program.AddConstraint(name, 0, nlp::kUnbounded, With(at, std::array{direction, reach}),
                          LimbTerm{{place, pin}, limb, actuator.radius_mm});
  for (const Eigen::Vector2d& corner : corners)
    program.AddConstraint("reach for " + name, 0, nlp::kUnbounded, std::array{direction, reach},
                          CornerTerm{corner.x(), corner.y()});
}

void AddLinearTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links,
                   const std::array<double, 6>& coefficients) {
  program.AddTerm(row, links, LinearTerm{coefficients});
}

void AddSingularityTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links, int stroke,
                        double off_mm) {
  program.AddTerm(row, std::array{links[1], links[4], links[5], stroke}, SingularityTerm{off_mm});
}

void AddScaledTerm(nlp::NonlinearProgram& program, int row, int variable, double factor) {
  program.AddTerm(row, std::array{variable}, ScaledTerm{factor});
}

int AddLinearRow(nlp::NonlinearProgram& program, const std::string& name, double lower, double upper,
                 std::initializer_list<ScaledVariable> terms) {
  const int row = program.AddRow(name, lower, upper);
  for (const auto& [variable, factor] : terms) AddScaledTerm(program, row, variable, factor);
  return row;
}

}  // namespace lake::synthesis
