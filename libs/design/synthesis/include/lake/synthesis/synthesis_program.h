// The nonlinear program of a synthesis problem, in standard form:
//
//   min   -(180 / pi) theta                                       cost, deg; or the duration, s
//    x
//   s.t.  |R - M|^2 = d_min^2,  |R - S|^2 = l1^2                  loops, as equations: smooth on the singular surfaces
//         alpha2 >= 0, beta2 >= 0                                 the assembled branch
//         coefficients . X >= limit                               Grashof, order
//         l2 + d_min - l7 >= m                                    singularity; left out at m = 0: the loop implies it
//         family(X, pose_k) >= limit          k = 1..K   at fractions of the used range and samples of the load profile
//         loops, and no turning between coupler and bar, at each of these poses
//         lower <= X <= upper
//         all but that again for builds X + e of the tolerance, |e_i| <= t; then the cost is that of the worst
//   x = (l1..l6, theta, d, phi; d_k, phi_k)
//
// Elastic: every limit may be moved by a slack >= 0, and the cost is the sum of the slacks in mm, deg or 1 % of a
// force or duration limit (an l1 penalty: few limits move).
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "lake/nlp/solve.h"
#include "lake/problem/problem.h"

namespace lake::synthesis {

// Indices of the variables l1..l6 in the program.
using LinkVariables = std::array<int, 6>;
linkage::Links LinksAt(const LinkVariables& links, const std::vector<double>& x);

enum class Elasticity {
  kNone,          // maximise the range
  kRequirements,  // requirements give way; bounds and d_min do not
  kEverything     // bounds and d_min too
};

// The poses, besides d_min itself, that carry rows: fractions of the used range, and samples of the load profile.
struct Collocation {
  std::vector<double> fractions;
  std::vector<int> samples;
  std::vector<problem::BuildError> builds;  // with a tolerance: those that stand at each of these poses too

  Collocation() = default;
  Collocation(std::initializer_list<double> fractions) : fractions(fractions) {}
  std::size_t Size() const { return fractions.size() + samples.size() + builds.size(); }
};

// A requirement, and where the program keeps it.
struct RequirementRow {
  problem::Requirement requirement;
  int row = -1;           // its limit; -1: left out (singularity at m = 0)
  int slack = -1;         // variable, if elastic; -1: does not give way
  int family_limit = -1;  // variable, of a limit on poses: the limit that all of these refer to

  double SlackAt(const std::vector<double>& x) const { return slack < 0 ? 0 : x[slack]; }
};

// A link bound or d_min that gives way (Elasticity::kEverything).
struct ElasticBound {
  std::string text;  // "l1 ≥ 50 mm"
  double limit;
  bool is_lower_limit;
  int slack;
  int row;
};

// What a limit is on: a requirement, a link's bounds, d_min, or a quantity of what extends the program.
struct LimitId {
  static constexpr std::string_view kLink = "link", kShortestStroke = "d_min";
  std::string_view name;  // of static storage
  int index = 0;          // of the link, or of the person
  bool operator==(const LimitId&) const = default;
};

// A limit that is reported with its multiplier: a row, named after the limit, or the bounds of a variable.
struct Limit {
  LimitId id;
  std::string unit;
  int row = -1, variable = -1;  // one of the two
  double scale = 1;             // d (limit of the row or variable) / d (limit as reported)
};

struct SynthesisProgram {
  nlp::NonlinearProgram program;
  LinkVariables links{};
  int shortest_stroke = -1, range = -1;  // variables: d_min, theta at d_min
  int worst_range = -1;                  // variable, with a tolerance: no more than that of any build
  std::array<int, 2> placement{-1, -1};  // variables, x and y; with clearances only
  std::vector<RequirementRow> requirements;
  std::vector<ElasticBound> elastic_bounds;
  std::vector<Limit> limits;

  // nullptr where the program has no such limit.
  const Limit* Find(const LimitId& id) const;
};

// Families are collocated at `poses`; standing (0) is added where it is needed. `range_weight`: of -range in the cost,
// unless it is elastic; where the duration is what is sought, it only decides between equals.
SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const Collocation& poses, Elasticity elasticity = Elasticity::kNone,
                              double range_weight = 1);

// The problem with the exoskeleton's knee where a solution x has it.
problem::SynthesisProblem Placed(problem::SynthesisProblem problem, const SynthesisProgram& program,
                                 const std::vector<double>& x);

// The size of slack that costs 1: a millimetre, a degree, 1 % of a force or a duration.
double SlackUnit(const problem::Requirement& requirement);

// What extends the program (redesign_program.h) adds by these.

// A stroke between those of two knots: (1 - weight) from + weight to.
struct StrokeBetween {
  int from, to;
  double weight;
};

// A pose on the way of a stroke program, with a knee angle of its own; adds phi and the rows of any
// pose: its loops and branches.
void AddProgramPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links,
                    const StrokeBetween& stroke, int theta, double phi_start_rad);

// factor x variable, as a term of `row` (NlpTerm::kCost: of the cost).
void AddScaledTerm(nlp::NonlinearProgram& program, int row, int variable, double factor);

// lower <= sum of factor x variable <= upper.
struct ScaledVariable {
  int variable;
  double factor;
};
int AddLinearRow(nlp::NonlinearProgram& program, const std::string& name, double lower, double upper,
                 std::initializer_list<ScaledVariable> terms);

}  // namespace lake::synthesis
