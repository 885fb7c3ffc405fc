// A proof that a solver's optimum is an isolated stationary point of its nonlinear program, in verified arithmetic.
//
// With the rows and bounds that are active as equations the Karush-Kuhn-Tucker conditions are a square system
//   grad f - sum m_i grad c_i = 0 on the free variables,   c_i = limit_i on the active rows.
// Krawczyk's operator maps a small box about the solution into its interior, so the box holds exactly one solution
// (Krawczyk, Computing 4, 1969; Neumaier, Interval Methods for Systems of Equations, 1990, ch. 5). In the box the
// multipliers of active limits have their sign strictly and all other limits are clear, so it is a stationary point of
// the program, and the only one there.
#pragma once

#include <string>
#include <vector>

#include "lake/nlp/solve.h"

namespace lake::certificate {

struct StationaryPoint {
  bool is_certified = false;
  std::string reason;         // why not, one clause
  double largest_radius = 0;  // of the box, half its width in any variable of the program, in that variable's unit
  double distance = 0;        // of the solution from the middle of the box, the largest of any variable
  int unknowns = 0;           // of the system
};

// Of half the box's width: 1e-6 mm in all.
inline constexpr double kStationaryRadius = 5e-7;
// How far from the box's middle a solution may lie: an interior point stays this far from limits of low price.
inline constexpr double kStationaryDistance = 1e-4;

// `solution` of the program. All its terms must be Enclosable.
StationaryPoint CertifyStationaryPoint(const nlp::NonlinearProgram& program, const nlp::NlpSolution& solution);

}  // namespace lake::certificate
