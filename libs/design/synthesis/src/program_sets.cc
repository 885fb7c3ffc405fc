#include "lake/synthesis/program_sets.h"

#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/linkage/loop_equations.h"

namespace lake::synthesis {
namespace {

// Of products of three lengths divided by a length: brings rows near one.
constexpr double kAreaScale_mm2 = 1e4;
constexpr double kMillimetresPerMetre = 1000;

// What the rows of a pose are made of; a length or angle that a row does not read is zero.
template <typename T>
struct PoseValues {
  T links[6]{}, stroke{}, phi{}, theta{};
};

// A pose of the used range; v = l1..l6, stroke, phi, range.
struct OnUsedRange {
  double fraction, standing_rad;

  template <typename T>
  T Theta(const T* v) const {
    return v[8] * fraction + standing_rad * (1 - fraction);
  }
  template <typename T>
  linkage::LoopVectors<T> Vectors(const T* v) const {
    return linkage::LoopVectorsOf(v, v[7], Theta(v));
  }
  template <typename T>
  PoseValues<T> operator()(const T* v) const {
    return {{v[0], v[1], v[2], v[3], v[4], v[5]}, v[6], v[7], Theta(v)};
  }
};

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
  AddPoseRow(program, "alpha2 >= 0" + name, nlp::kUnbounded, actuator_branch, BranchRow{0});
  AddPoseRow(program, "beta2 >= 0" + name, nlp::kUnbounded, shank_branch, BranchRow{1});
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

// v[9] is the limit.
struct MomentArmTerm : OnUsedRange {
  template <typename T>
  T operator()(const T* v) const {
    const auto vectors = Vectors(v);
    const T numerator =
        linkage::Dot(vectors.coupler, vectors.shank_motion) * linkage::Dot(vectors.actuator, vectors.tip_motion) / v[6];
    return (numerator - v[9] * linkage::Dot(vectors.coupler, vectors.tip_motion)) / kAreaScale_mm2;
  }
};

// As the moment arm at torque / force, in units of the force limit so that its multiplier is of that order too.
struct ForceTerm : OnUsedRange {
  double torque_nmm, force_scale_n;
  template <typename T>
  T operator()(const T* v) const {
    const auto vectors = Vectors(v);
    const T numerator =
        linkage::Dot(vectors.coupler, vectors.shank_motion) * linkage::Dot(vectors.actuator, vectors.tip_motion) / v[6];
    return (v[9] * numerator - linkage::Dot(vectors.coupler, vectors.tip_motion) * torque_nmm) /
           (kAreaScale_mm2 * force_scale_n);
  }
};

// v[9] is the duration; in units in which the row is of order one.
struct DurationTerm : OnUsedRange {
  double at_rest_mm_s, lost_nmm_mm_s, rad_per_rise, scale;
  template <typename T>
  T operator()(const T* v) const {
    const auto vectors = Vectors(v);
    const T numerator =
        linkage::Dot(vectors.coupler, vectors.shank_motion) * linkage::Dot(vectors.actuator, vectors.tip_motion) / v[6];
    const T denominator = linkage::Dot(vectors.coupler, vectors.tip_motion);
    return (v[9] * denominator * (numerator * at_rest_mm_s - denominator * lost_nmm_mm_s) -
            numerator * numerator * rad_per_rise) /
           scale;
  }
};

struct TransmissionTerm : OnUsedRange {
  template <typename T>
  T operator()(const T* v) const {
    using std::sin;
    return linkage::SinCosTransmission(v, v[7], Theta(v))[0] - sin(v[9] / kDegreesPerRadian);
  }
};

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
  template <typename T>
  T operator()(const T* v) const {  // l2, l5, l6, d
    using std::sqrt;
    return v[0] + v[3] - sqrt(v[1] * v[1] + v[2] * v[2]);
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
                      int range, double fraction, double standing_rad, double phi_start_rad) {
  const int phi = AddBarAngle(program, name, phi_start_rad);
  const PoseVariables pose{links, stroke, phi, range, fraction, standing_rad, name};
  const Reading<9, OnUsedRange> all{pose.All(), {fraction, standing_rad}};
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
  const OnUsedRange at{pose.fraction, pose.standing_rad};
  program.AddConstraint("no turning" + pose.place, 0, nlp::kUnbounded, pose.All(), NoTurningTerm{at});
}

void AddFamilyRow(nlp::NonlinearProgram& program, const problem::Requirement& requirement, const PoseVariables& pose,
                  int limit, double knee_torque_nm) {
  const OnUsedRange at{pose.fraction, pose.standing_rad};
  const std::string name = requirement.name + pose.place;
  const std::array<int, 10> variables = With(pose, limit);
  if (requirement.id.kind == problem::Requirement::Kind::kTransmission) {
    program.AddConstraint(name, 0, nlp::kUnbounded, variables, TransmissionTerm{at});
    return;
  }
  if (requirement.id.kind == problem::Requirement::Kind::kMomentArm)
    program.AddConstraint(name, 0, nlp::kUnbounded, variables, MomentArmTerm{at});
  else
    program.AddConstraint(name, 0, nlp::kUnbounded, variables,
                          ForceTerm{at, knee_torque_nm * kMillimetresPerMetre, requirement.limit});
}

void AddDurationRow(nlp::NonlinearProgram& program, const PoseVariables& pose, int duration,
                    const problem::SpeedLine& line, double knee_torque_nm, double rad_per_rise) {
  constexpr double kArm_mm = 50;  // usual
  const double torque_nmm = knee_torque_nm * kMillimetresPerMetre;
  const double scale = kAreaScale_mm2 * kAreaScale_mm2 * kArm_mm * line.at_rest_mm_s;
  program.AddConstraint("duration" + pose.place, 0, nlp::kUnbounded, With(pose, duration),
                        DurationTerm{{pose.fraction, pose.standing_rad},
                                     line.at_rest_mm_s,
                                     line.per_newton_mm_s * torque_nmm,
                                     rad_per_rise,
                                     scale});
}

void AddLinearTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links,
                   const std::array<double, 6>& coefficients) {
  program.AddTerm(row, links, LinearTerm{coefficients});
}

void AddSingularityTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links, int stroke) {
  program.AddTerm(row, std::array{links[1], links[4], links[5], stroke}, SingularityTerm{});
}

void AddScaledTerm(nlp::NonlinearProgram& program, int row, int variable, double factor) {
  program.AddTerm(row, std::array{variable}, ScaledTerm{factor});
}

}  // namespace lake::synthesis
