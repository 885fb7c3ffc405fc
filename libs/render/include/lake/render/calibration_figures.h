// Pictures of a calibration.
#pragma once

#include <filesystem>

#include "lake/camera/calibration_quality.h"

namespace lake {

// Where corners were seen, with their residuals as arrows (magnified, the factor is in the title; outliers in another
// colour), and the RMS of each view.
void WriteResidualFigure(const std::filesystem::path& path, const std::vector<BoardView>& views,
                         const CalibrationResult& result);

// How the cameras of the odd and of the even views differ, over the picture.
void WriteCrossValidationFigure(const std::filesystem::path& path, const CameraDifference& difference, int width_px,
                                int height_px);

}  // namespace lake
