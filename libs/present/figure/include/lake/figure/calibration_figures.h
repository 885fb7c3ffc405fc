// Pictures of a calibration.
#pragma once

#include <filesystem>

#include "lake/camera/calibration_quality.h"

namespace lake::figure {

// Where corners were seen, with their residuals as arrows (magnified, the factor is in the title; outliers in another
// colour), and the RMS of each view.
void WriteResidualFigure(const std::filesystem::path& path, const std::vector<camera::BoardView>& views,
                         const camera::CalibrationResult& result);

// How the cameras of the odd and of the even views differ, over the picture.
void WriteCrossValidationFigure(const std::filesystem::path& path, const camera::CameraDifference& difference,
                                int width_px, int height_px);

}  // namespace lake::figure
