// Whether a person keeps the balance all along a stroke program, and what their knee needs at its pace.
#pragma once

#include <vector>

namespace lake::redesign {

// How much farther forward than in the human trial leg (ankle to hip) and trunk lean, one value per sample of the
// motion; empty: not at all.
struct Lean {
  std::vector<double> leg_rad, trunk_rad;
};

// At one percent from where the feet alone bear the body.
struct BalanceSample {
  double percent = 0;
  double pressure_mm = 0;  // centre of pressure on the ground, before the ankle
  double margin_mm = 0;    // how far that is inside the foot; negative outside: nobody keeps the balance
  double knee_nm = 0;      // of one leg, extension positive
};

struct BalanceCourse {
  std::vector<BalanceSample> samples;
  double duration_s = 0;  // of the rise
  double margin_mm = 0;   // the least …
  double at_percent = 0;  // … and where it is
  double peak_knee_nm = 0;
};

}  // namespace lake::redesign
