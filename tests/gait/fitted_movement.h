// Recordings as the programs take them: the leg is fitted, and then its movement found.
#pragma once

#include <string>

#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/movement.h"

namespace lake {

// A trial's leg, from markers in space or in a plane that have the recording's own unit.
inline gait::LegFitResult FitTrial(const exchange::Trial& trial, const gait::LegFitOptions& options = {}) {
  return gait::FitLeg(trial.recording, gait::MakeLegView(trial.recording.unit, {}), options, trial.lateral_mm);
}

inline gait::LegFitResult FitMovement(const motion::MarkerRecording& recording, const gait::LateralPlaces& lateral = {},
                                      const gait::MovementOptions& movement = {}) {
  gait::LegFitResult leg = gait::FitLeg(recording, gait::MakeLegView(recording.unit, {}), {}, lateral);
  gait::ChooseMovement(movement, leg);
  return leg;
}

inline gait::LegFitResult FitMovement(const exchange::Trial& trial) {
  return FitMovement(trial.recording, trial.lateral_mm);
}

inline std::string WarningsOf(const gait::LegFitResult& leg) {
  std::string text;
  for (const std::string& warning : leg.warnings) text += warning + "\n";
  return text;
}

}  // namespace lake
