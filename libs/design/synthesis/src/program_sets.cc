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

// A point on the used range; v = l1..l6, stroke, phi, range.
struct AtPose {
  double fraction, standing_rad;

  template <typename T>
  T Theta(const T* v) const {
    return v[8] * fraction + standing_rad * (1 - fraction);
  }
  template <typename T>
  linkage::LoopVectors<T> Vectors(const T* v) const {
    return linkage::LoopVectorsOf(v, v[7], Theta(v));
  }
};

struct LoopTerm : AtPose {
  int loop;
  template <typename T>
  T operator()(const T* v) const {
    return linkage::LoopResiduals(v, v[6], v[7], Theta(v))[loop];
  }
};

struct BranchTerm : AtPose {
  int triangle;
  template <typename T>
  T operator()(const T* v) const {
    return linkage::BranchExpressions(v, v[7], Theta(v))[triangle];
  }
};

// v = l2, l5, l6, phi, and the strokes of two knots.
struct ProgramActuatorLoop {
  double weight;
  template <typename T>
  T operator()(const T* v) const {
    const T links[6] = {T{}, v[0], T{}, T{}, v[1], v[2]};
    return linkage::LoopResiduals(links, v[4] * (1 - weight) + v[5] * weight, v[3], T{})[0];
  }
};

// v = l1, l2, l3, l4, phi, theta.
struct ProgramFourBarLoop {
  template <typename T>
  T operator()(const T* v) const {
    const T links[6] = {v[0], v[1], v[2], v[3], T{}, T{}};
    return linkage::LoopResiduals(links, T{}, v[4], v[5])[1];
  }
};

// v = l2, l5, l6, phi.
struct ProgramActuatorBranch {
  template <typename T>
  T operator()(const T* v) const {
    const T links[6] = {T{}, v[0], T{}, T{}, v[1], v[2]};
    return linkage::BranchExpressions(links, v[3], T{})[0];
  }
};

// v = l2, l3, l4, phi, theta.
struct ProgramShankBranch {
  template <typename T>
  T operator()(const T* v) const {
    const T links[6] = {T{}, v[0], v[1], v[2], T{}, T{}};
    return linkage::BranchExpressions(links, v[3], v[4])[1];
  }
};

// The least sine that counts as not turning keeps the multiplied-out families away from 0 >= 0 where P, R and S are in
// line.
struct NoTurningTerm : AtPose {
  template <typename T>
  T operator()(const T* v) const {
    constexpr double kLeastSine = 5e-3;
    const auto vectors = Vectors(v);
    return (linkage::Dot(vectors.coupler, vectors.tip_motion) - v[0] * v[1] * kLeastSine) / kAreaScale_mm2;
  }
};

// v[9] is the limit.
struct MomentArmTerm : AtPose {
  template <typename T>
  T operator()(const T* v) const {
    const auto vectors = Vectors(v);
    const T numerator =
        linkage::Dot(vectors.coupler, vectors.shank_motion) * linkage::Dot(vectors.actuator, vectors.tip_motion) / v[6];
    return (numerator - v[9] * linkage::Dot(vectors.coupler, vectors.tip_motion)) / kAreaScale_mm2;
  }
};

// As the moment arm at torque / force, in units of the force limit so that its multiplier is of that order too.
struct ForceTerm : AtPose {
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

struct TransmissionTerm : AtPose {
  template <typename T>
  T operator()(const T* v) const {
    using std::sin;
    return linkage::SinCosTransmission(v, v[7], Theta(v))[0] - sin(v[9] / kDegreesPerRadian);
  }
};

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

std::array<int, 9> PoseVariables::All() const {
  return {links[0], links[1], links[2], links[3], links[4], links[5], stroke, phi, range};
}

PoseVariables AddPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links, int stroke,
                      int range, double fraction, double standing_rad, double phi_start_rad) {
  constexpr double kTwoPi = 2 * std::numbers::pi;
  const int phi = program.AddVariable("phi" + name, phi_start_rad, 0, kTwoPi);
  const PoseVariables pose{links, stroke, phi, range, fraction, standing_rad};
  const AtPose at{fraction, standing_rad};
  program.AddConstraint("actuator loop" + name, 0, 0, pose.All(), LoopTerm{at, 0});
  program.AddConstraint("four-bar loop" + name, 0, 0, pose.All(), LoopTerm{at, 1});
  program.AddConstraint("alpha2 >= 0" + name, 0, nlp::kUnbounded, pose.All(), BranchTerm{at, 0});
  program.AddConstraint("beta2 >= 0" + name, 0, nlp::kUnbounded, pose.All(), BranchTerm{at, 1});
  return pose;
}

ProgramPose AddProgramPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links,
                           int from, int to, double weight, int theta, double phi_start_rad) {
  const auto& [l1, l2, l3, l4, l5, l6] = links;
  const int phi = program.AddVariable("phi" + name, phi_start_rad, 0, 2 * std::numbers::pi);
  program.AddConstraint("actuator loop" + name, 0, 0, std::array{l2, l5, l6, phi, from, to},
                        ProgramActuatorLoop{weight});
  program.AddConstraint("four-bar loop" + name, 0, 0, std::array{l1, l2, l3, l4, phi, theta}, ProgramFourBarLoop{});
  program.AddConstraint("alpha2 >= 0" + name, 0, nlp::kUnbounded, std::array{l2, l5, l6, phi}, ProgramActuatorBranch{});
  program.AddConstraint("beta2 >= 0" + name, 0, nlp::kUnbounded, std::array{l2, l3, l4, phi, theta},
                        ProgramShankBranch{});
  return {from, to, weight, theta, phi};
}

void AddNoTurningRow(nlp::NonlinearProgram& program, const PoseVariables& pose) {
  const AtPose at{pose.fraction, pose.standing_rad};
  program.AddConstraint(fmt::format("no turning at {:.4g}", pose.fraction), 0, nlp::kUnbounded, pose.All(),
                        NoTurningTerm{at});
}

void AddFamilyRow(nlp::NonlinearProgram& program, const problem::Requirement& requirement, const PoseVariables& pose,
                  int limit, double knee_torque_nm) {
  constexpr double kMillimetresPerMetre = 1000;
  const AtPose at{pose.fraction, pose.standing_rad};
  const std::string name = fmt::format("{} at {:.4g}", requirement.name, pose.fraction);
  const auto pose_variables = pose.All();
  std::array<int, 10> variables{};
  std::copy(pose_variables.begin(), pose_variables.end(), variables.begin());
  variables[9] = limit;
  if (requirement.kind == problem::Requirement::Kind::kTransmission) {
    program.AddConstraint(name, 0, nlp::kUnbounded, variables, TransmissionTerm{at});
    return;
  }
  if (requirement.kind == problem::Requirement::Kind::kMomentArm)
    program.AddConstraint(name, 0, nlp::kUnbounded, variables, MomentArmTerm{at});
  else
    program.AddConstraint(name, 0, nlp::kUnbounded, variables,
                          ForceTerm{at, knee_torque_nm * kMillimetresPerMetre, requirement.limit});
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
