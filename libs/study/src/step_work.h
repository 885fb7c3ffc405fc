// The work of each of a study's steps, by the function of the program whose work it is; nullopt where the study has no
// such step. `out` is the study's folder of results, in which each has a folder of its own.
#pragma once

#include <filesystem>
#include <optional>

#include "lake/steps/study_steps.h"
#include "lake/study/study_file.h"

namespace lake::study {

// Of the study's simulation: what `simulate` does not say is as in the problem of the design that is simulated.
commands::SimulationOptions SimulationOf(const StudyFile& study);

using OptionalStep = std::optional<steps::StudyStep>;

OptionalStep CalibrationStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep PlaneStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep HumanStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep ExoStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep ComparisonStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep LoadsStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep OptimumStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep RedesignStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep AssistanceStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep SimulationStep(const StudyFile& study, const std::filesystem::path& out);
OptionalStep StrokeStep(const StudyFile& study, const std::filesystem::path& out);

}  // namespace lake::study
