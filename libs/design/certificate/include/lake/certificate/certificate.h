// A proof that no design is better: a rigorous upper bound on theta(X, d_min) over all X within the bounds that satisfy
// the order constraints, Grashof's law and the singularity constraint (with their margins), by best-first branch and
// bound in interval arithmetic. Requirements over the used range are not used: the bound holds with them too, though it
// may then not be tight. The cap is.
//
// How a box is bounded, with phi the angle of the slewing bar, kappa = pi - theta and q the unit vector from S to R:
//   dkappa/dx = N_x / (l4 l8 sin beta2), the denominator positive on the assembled branch, and
//   N_l1 = l1,  N_l3 = -l1 q.y,  N_l4 = l1 q.s,  N_phi = l2 (l3 sin phi + l4 sin(kappa - phi)),  s = S / l4.
// l1 is eliminated: theta falls with l1, so the best l1 is max(lower bound, l3 + l4 + g - l2). A link whose derivative
// has one sign on the box, proved by interval evaluation, is moved to the end that raises theta; the moves keep every
// constraint, and under Grashof's law with this order the four-bar closes at every phi, so no move leaves the assembled
// branch. phi enters by its smallest value, where dkappa/dphi > 0 is proved, and that falls with l6, likewise proved.
// What is not proved is enclosed as an interval. A box that no split makes smaller, as where all links are fixed, is
// kept as it is.
#pragma once

#include <cstdint>
#include <optional>

#include "lake/core/threads.h"
#include "lake/problem/problem.h"

namespace lake::certificate {

struct CertificateOptions {
  double gap_deg = 0.1;             // stop once bound - range is no larger
  std::int64_t max_boxes = 200000;  // examined at most; some 20 s on two cores
  int threads = Threads();          // the result is the same for any number
  bool quiet = true;                // no progress

  void Check() const;  // throws Error
};

struct Certificate {
  double upper_bound_deg = 0;       // rigorous, also when the gap was not reached
  double gap_deg = 0;               // upper bound - range; NaN if no range is known
  bool reached = false;             // gap <= the one asked for
  std::int64_t boxes = 0;           // examined, the whole one included
  bool feasible_set_empty = false;  // proved: no X satisfies the constraints at all; the bound is then -infinity
};

// How far a known range may lie above a bound, deg: its design keeps the limits within what a solver leaves, 1e-6 mm,
// and a limit costs less than 1000 deg per mm.
inline constexpr double kKnownRangeTolerance_deg = 1e-3;

// `range_deg`: the best range known, of a design that meets the link requirements. It decides when to stop (without
// one, when the boxes are used up), so the bound is valid whatever it is. Throws Error if the bound is below it: one of
// the two is wrong; Interrupted on a signal.
Certificate CertifyRange(const problem::SynthesisProblem& problem, std::optional<double> range_deg,
                         const CertificateOptions& options = {});

}  // namespace lake::certificate
