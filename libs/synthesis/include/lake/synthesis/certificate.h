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
// What is not proved is enclosed as an interval.
#pragma once

#include <cstdint>
#include <optional>

#include "lake/synthesis/problem.h"

namespace lake {

struct CertificateOptions {
  double gap_deg = 0.1;  // stop once bound - range is no larger
  double max_seconds = 60;
  std::int64_t max_boxes = 4000000;  // open boxes kept, some 100 bytes each
  int threads = 2;
  bool quiet = true;  // no progress

  void Check() const;  // throws Error
};

struct Certificate {
  double upper_bound_deg = 0;  // rigorous, also when the gap was not reached
  double gap_deg = 0;          // upper bound - range
  bool reached = false;        // gap <= the one asked for
  std::int64_t boxes = 0;      // examined
  double seconds = 0;
  bool feasible_set_empty = false;  // proved: no X satisfies the constraints at all; the bound is then -infinity
};

// `range_deg`: the best range known; only decides when to stop, so the bound is valid whatever it is. Throws
// Interrupted on a signal.
Certificate CertifyRange(const SynthesisProblem& problem, double range_deg, const CertificateOptions& options = {});

}  // namespace lake
