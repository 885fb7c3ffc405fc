// Figures of how far two sit-to-stand curves are apart.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/compare/registration.h"

namespace lake::compare {

// y = slope x + intercept by least squares; the linear-fit method (Iosa et al., BioMed Res. Int. 2014, 214156): for
// equal curves slope 1, intercept 0, r2 1.
struct LinearFit {
  double slope = 0, intercept = 0, r2 = 0;
};

// At the samples in use. NaN where a figure is not defined.
struct MisalignmentMetrics {
  double rms_mm = 0, mean_mm = 0, max_mm = 0, p95_mm = 0;
  double relative_rms = 0, relative_max = 0, relative_p95 = 0;  // of the shank's length, 0..1
  double relative_paper_rms = 0, relative_paper_max = 0;
  double closest_point_rms_mm = 0;  // from each sample of the exoskeleton's path to the human's path
  double hausdorff_mm = 0;
  double frechet_mm = 0;  // discrete (Eiter & Mannila 1994)
  double knee_rmse_deg = 0;
  double cmc = 0;        // of the knee angles (Kadaba et al., J. Orthop. Res. 7, 1989)
  LinearFit linear_fit;  // of the exoskeleton's knee angle on the human's
  int samples = 0;
};

// |e.y − h.y| / |h.y| in the leg frame: probably what the paper plots. It depends on the origin and grows without bound
// near y = 0.
double PaperMisalignment(const Eigen::Vector2d& exo_knee, const Eigen::Vector2d& human_knee);

// Over the samples that `use` marks.
MisalignmentMetrics ComputeMetrics(const StsCurve& human, const StsCurve& exo, const std::vector<bool>& use);

// From a point to the nearest point of a polyline.
double DistanceToPath(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& path);

// The larger of both directed distances, from vertices to the other polyline.
double HausdorffDistance(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b);

double DiscreteFrechetDistance(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b);

// Of curves of equal length; NaN where the formula has no real root (curves that agree less than their own variation).
double CoefficientOfMultipleCorrelation(const std::vector<std::vector<double>>& curves);

LinearFit FitLine(const std::vector<double>& x, const std::vector<double>& y);

struct SpikeOptions {
  int half_window = 7;    // of the smoothing, in samples
  double deviations = 5;  // in MAD of the residual
  double least_mm = 1.0;  // a smaller residual is none: on clean curves the MAD is nearly 0
};

// Samples at which e − h leaves its own smooth course: the residual after robust local quadratic smoothing (Cleveland
// 1979) of dx or dy lies outside median ± 5 MAD.
std::vector<bool> FindSpikes(const StsCurve& human, const StsCurve& exo, const SpikeOptions& options = {});

}  // namespace lake::compare
