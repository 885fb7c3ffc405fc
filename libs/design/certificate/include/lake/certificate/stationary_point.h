// A proof that a solver's optimum is an isolated stationary point of its nonlinear program, in verified arithmetic.
//
// With the rows and bounds that are active as equations the Karush-Kuhn-Tucker conditions are a square system
//   grad f - sum m_i grad c_i = 0 on the free variables,   c_i = limit_i on the active rows.
// Krawczyk's operator maps a small box about the solution into its interior, so the box holds exactly one solution
// (Krawczyk, Computing 4, 1969; Neumaier, Interval Methods for Systems of Equations, 1990, ch. 5). In the box the
// multipliers of active limits have their sign strictly and all other limits are clear, so it is a stationary point of
// the program, and the only one in the box at which the same limits are active: where a limit is off, there may be
// others. Variables that neither the cost nor an active row reads are held where the solver left them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "lake/certificate/interval.h"
#include "lake/nlp/solve.h"

namespace lake::certificate {

struct StationaryPoint {
  bool is_certified = false;
  std::string reason;             // why not, one clause
  std::vector<Interval> box;      // of all variables, each in its unit; the point is in it. Empty: none was found
  std::vector<double> radii;      // half the box's width, likewise; 0: at a bound or held
  std::vector<std::string> held;  // names of variables
  int unknowns = 0;               // of the system

  // Over these variables of the program: how far the point may be from `x`, at most, and the smallest radius but 0;
  // infinity if there is none.
  double Distance(const std::vector<double>& x, std::span<const int> variables) const;
  double SmallestRadius(std::span<const int> variables) const;
};

// Of half the box's width, at most: 1e-6 in all.
inline constexpr double kStationaryRadius = 5e-7;
// How far from the solution a point of the box may be: an interior point stays this far from limits of low price.
inline constexpr double kStationaryDistance = 1e-4;

// Whether a value counts as at a limit, and from which smallest singular value on gradients of length one count as
// independent.
bool IsActive(double value, double limit);
inline constexpr double kIndependent = 1e-6;

// `solution` of the program. All its terms must be Enclosable.
StationaryPoint CertifyStationaryPoint(const nlp::NonlinearProgram& program, const nlp::NlpSolution& solution);

}  // namespace lake::certificate
