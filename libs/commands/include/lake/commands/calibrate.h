// The work of lake-calibrate: a camera from pictures of a board, the sagittal plane from one picture, boards to print.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/camera/board_pictures.h"
#include "lake/camera/calibration.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/motion/corrections.h"

namespace lake::commands {

struct CalibrateRunOptions {
  std::vector<std::filesystem::path> pictures;  // images of the board, or one video of a moving board
  std::string board;                            // as ParseBoard reads it
  camera::CalibrationOptions calibration;
  std::optional<camera::LensFamily> lens;  // chosen by cross-validation
  camera::BoardPicturesOptions find;
};

struct PlaneRunOptions {
  std::filesystem::path picture, camera;
  std::string board, points;                      // one of the two: as ParseBoard, as ParsePlanePoints reads it
  double click_sigma_px = motion::kClickSigmaPx;  // how well a point of `points` is known
};

struct SheetRunOptions {
  std::string board, paper = "a4";
};

void Describe(CalibrateRunOptions& o, OptionList& options);
void Describe(PlaneRunOptions& o, OptionList& options);
void Describe(SheetRunOptions& o, OptionList& options);

std::vector<InputFile> InputsOf(const CalibrateRunOptions& options);
std::vector<InputFile> InputsOf(const PlaneRunOptions& options);

// Writes camera.yaml, residuals.csv, residuals.png and, from enough views, cross_validation.png; returns the results
// for the summary. Throws UsageError without pictures or board, Error for pictures that cannot be used, SolverError.
Json RunCalibrate(const CalibrateRunOptions& options, Run& run);

// Writes the camera with the sagittal plane as camera.yaml; returns the results for the summary. Throws UsageError
// unless either a board or points are given, Error for a picture of another size or without the board.
Json RunPlane(const PlaneRunOptions& options, Run& run);

// Writes board.pdf, 1:1.
Json RunSheet(const SheetRunOptions& options, Run& run);

}  // namespace lake::commands
