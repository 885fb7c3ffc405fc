// The picture of the first screen: both knees in a frame of the exoskeleton trial.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/run.h"
#include "lake/study/study_file.h"

namespace lake::study {

// Adds knees.png to the run's results: a frame in which both are apart as they usually are. Nothing where the trial is
// no video, its plane has no mm, or it shows no knee beside the joint. `exo`: the trial's results.
void DrawKneesOf(const StudyTrial& trial, const std::filesystem::path& exo, const std::string& joint, Run& run);

}  // namespace lake::study
