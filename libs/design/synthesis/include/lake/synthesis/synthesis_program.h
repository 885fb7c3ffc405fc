// The nonlinear program of a synthesis problem, in standard form:
//
//   min   -(180 / pi) theta                                       cost, deg
//    x
//   s.t.  |R - M|^2 = d_min^2,  |R - S|^2 = l1^2                  loops, as equations: smooth on the singular surfaces
//         alpha2 >= 0, beta2 >= 0                                 the assembled branch
//         coefficients . X >= limit                               Grashof, order
//         l2 + d_min - l7 >= m                                    singularity; left out at m = 0, where the loop
//         implies it family(X, pose_k) >= limit          k = 1..K            at fractions of the used range, each with
//         its own loops no turning between coupler and bar at these poses lower <= X <= upper
//   x = (l1..l6, theta, d, phi; d_k, phi_k)
//
// Elastic: every limit may be moved by a slack >= 0, and the cost is the sum of the slacks in mm, deg or 1 % of a force
// limit (an l1 penalty: few limits move).
#pragma once

#include <string>
#include <vector>

#include "lake/nlp/solve.h"
#include "lake/problem/problem.h"
#include "lake/synthesis/program_sets.h"

namespace lake::synthesis {

enum class Elasticity {
  kNone,          // maximise the range
  kRequirements,  // requirements give way; bounds and d_min do not
  kEverything     // bounds and d_min too
};

// What may be at a limit, with where the program keeps it.
struct LimitRow {
  problem::Requirement requirement;
  int row = -1;    // its limit; -1: left out (singularity at m = 0)
  int slack = -1;  // variable, if elastic
};

// A link bound or d_min that gives way (Elasticity::kEverything).
struct ElasticBound {
  std::string text;  // "l1 >= 50 mm"
  double limit;
  bool is_lower_limit;
  int slack;
  int row;
};

// A variable or row beyond those of the requirements whose limit is reported when it is active.
struct PublishedVariable {
  int variable;
  std::string unit;
};
struct PublishedRow {
  int row;  // its name says the limit
  std::string unit;
  double rows_per_unit;  // d (the row's limit) / d (the limit as reported)
};

struct SynthesisProgram {
  nlp::NonlinearProgram program;
  LinkVariables links{};
  std::vector<PoseVariables> poses;  // at d_min first
  std::vector<LimitRow> limits;
  std::vector<ElasticBound> elastic_bounds;
  std::vector<PublishedVariable> published;  // of what extends the program
  std::vector<PublishedRow> published_rows;

  linkage::Links LinksAt(const std::vector<double>& x) const;
};

// `fractions` of the used range at which families are collocated, besides d_min itself; standing (0) is added where it
// is needed. `range_weight`: of -range in the cost, unless it is elastic.
SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const std::vector<double>& fractions, Elasticity elasticity = Elasticity::kNone,
                              double range_weight = 1);

// The size of slack that costs 1: a millimetre, a degree, 1 % of a force.
double SlackUnit(const problem::Requirement& requirement);

}  // namespace lake::synthesis
