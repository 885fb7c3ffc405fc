// Force plates beside the markers of a trial in three dimensions.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "lake/core/run.h"
#include "lake/exchange/ground_forces.h"
#include "lake/exchange/trial.h"

namespace lake::commands {

// The vertical that the plates' file and the trial share, a unit vector in the file's axes; of a trial in a plane,
// whose axes say nothing of the laboratory's, that of the file. `path`: the file of the forces. Throws Error where the
// trial's is another.
Eigen::Vector3d VerticalOf(const exchange::GroundForceRecording& forces, const exchange::Trial& trial,
                           const std::filesystem::path& path);

// Warns of plates that were named the wrong way round: another plate's force acts nearer to this leg's ankle than that
// of `plate`, one of `forces`. `reading` as the trial was read; `way_out`: which options say it, a sentence's end. Says
// nothing of a trial in a plane.
void WarnOfSwappedPlates(const exchange::GroundForceRecording& forces, const exchange::PlateForces& plate,
                         const std::string& leg, const exchange::Trial& trial, const exchange::TrialOptions& reading,
                         const std::string& way_out, Run& run);

}  // namespace lake::commands
