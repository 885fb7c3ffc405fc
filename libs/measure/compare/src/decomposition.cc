#include "lake/compare/decomposition.h"

#include <ceres/ceres.h>
#include <ceres/cubic_interpolation.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "decomposition_beside_knee.h"
#include "lake/core/angles.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

constexpr int kKnots = Decomposition::kKnots;
constexpr double kKnotStep = 100.0 / (kKnots - 1);

// w in the variables of the solver: its value at 0 and the rise over each step, so that the least slope is a bound.
using Timing = std::array<double, kKnots>;

// w(s), not yet clamped.
template <typename T>
T WarpAt(const T* timing, double percent) {
  T w = timing[0];
  for (int k = 1; k < kKnots; ++k) w += timing[k] * std::clamp(percent / kKnotStep - (k - 1), 0.0, 1.0);
  return w;
}

template <typename T>
T ClampPercent(const T& w) {
  if (w < 0.0) return T(0);
  if (w > 100.0) return T(100);
  return w;
}

// The human's knee and its angle, and the direction of his shank, at any percent: cubic (Catmull–Rom) between the
// samples.
class HumanCurve {
 public:
  explicit HumanCurve(const StsCurve& human)
      : knee_values_(Knees(human)),
        angle_values_(Angles(human)),
        knee_deg_values_(human.knee_deg.empty() ? std::vector<double>{0} : human.knee_deg),
        knee_grid_(knee_values_.data(), 0, kPercentSamples),
        angle_grid_(angle_values_.data(), 0, kPercentSamples),
        knee_deg_grid_(knee_deg_values_.data(), 0, static_cast<int>(knee_deg_values_.size())),
        knee_(knee_grid_),
        angle_(angle_grid_),
        knee_deg_(knee_deg_grid_) {}
  HumanCurve(const HumanCurve&) = delete;
  HumanCurve& operator=(const HumanCurve&) = delete;

  template <typename T>
  Eigen::Matrix<T, 2, 1> Knee(const T& percent) const {
    Eigen::Matrix<T, 2, 1> knee;
    knee_.Evaluate(percent, knee.data());
    return knee;
  }

  template <typename T>
  T KneeDeg(const T& percent) const {
    T angle;
    knee_deg_.Evaluate(percent, &angle);
    return angle;
  }

  // F(w) p
  template <typename T>
  Eigen::Matrix<T, 2, 1> FromShank(const T& percent, const T* in_shank) const {
    using std::cos;
    using std::sin;
    T lean_rad;
    angle_.Evaluate(percent, &lean_rad);
    const T c = cos(lean_rad), s = sin(lean_rad);
    return {c * in_shank[0] + s * in_shank[1], -s * in_shank[0] + c * in_shank[1]};
  }

 private:
  static std::vector<double> Knees(const StsCurve& human) {
    std::vector<double> values;
    for (const Vector2d& knee : human.knee) {
      values.push_back(knee.x());
      values.push_back(knee.y());
    }
    return values;
  }
  static std::vector<double> Angles(const StsCurve& human) {
    std::vector<double> values;
    for (std::size_t i = 0; i < human.knee.size(); ++i) {
      const Vector2d shank = human.knee[i] - human.ankle[i];
      values.push_back(std::atan2(shank.x(), shank.y()));
    }
    return values;
  }

  std::vector<double> knee_values_, angle_values_, knee_deg_values_;
  ceres::Grid1D<double, 2> knee_grid_;
  ceres::Grid1D<double, 1> angle_grid_, knee_deg_grid_;
  ceres::CubicInterpolator<ceres::Grid1D<double, 2>> knee_;
  ceres::CubicInterpolator<ceres::Grid1D<double, 1>> angle_, knee_deg_;
};

// r(s) = e(s) - h(w(s)) - F(w(s)) p over all samples, then sqrt(lambda) (w_{k-1} - 2 w_k + w_{k+1}) over the inner
// knots
struct Residuals {
  static constexpr int kCount = 2 * kPercentSamples + kKnots - 2;

  const HumanCurve& human;
  const StsCurve& exo;
  double roughness_root;

  template <typename T>
  bool operator()(const T* offset, const T* timing, T* residual) const {
    for (int i = 0; i < kPercentSamples; ++i) {
      const T w = ClampPercent(WarpAt(timing, i));
      const Eigen::Matrix<T, 2, 1> model = human.Knee(w) + human.FromShank(w, offset);
      const Vector2d& knee = exo.knee[static_cast<std::size_t>(i)];
      residual[2 * i] = knee.x() - model.x();
      residual[2 * i + 1] = knee.y() - model.y();
    }
    for (int k = 1; k + 1 < kKnots; ++k)
      residual[2 * kPercentSamples + k - 1] = roughness_root * (timing[k + 1] - timing[k]);
    return true;
  }
};

// r(s) = θ_e(s) − θ_h(w(s)) in mm over all samples, then the roughness as above.
struct AngleResiduals {
  static constexpr int kCount = kPercentSamples + kKnots - 2;

  const HumanCurve& human;
  const StsCurve& exo;
  double roughness_root, mm_per_deg;

  template <typename T>
  bool operator()(const T* timing, T* residual) const {
    for (int i = 0; i < kPercentSamples; ++i) {
      const T w = ClampPercent(WarpAt(timing, i));
      residual[i] = mm_per_deg * (exo.knee_deg[static_cast<std::size_t>(i)] - human.KneeDeg(w));
    }
    for (int k = 1; k + 1 < kKnots; ++k)
      residual[kPercentSamples + k - 1] = roughness_root * (timing[k + 1] - timing[k]);
    return true;
  }
};

struct Variables {
  Vector2d offset = Vector2d::Zero();
  Timing timing;

  Variables() {
    timing.fill(kKnotStep);
    timing[0] = 0;
  }
};

struct Fit {
  Variables variables;
  double cost = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
};

class Decomposer {
 public:
  Decomposer(const StsCurve& human, const StsCurve& exo, const DecompositionOptions& options)
      : human_(human), exo_(exo), options_(options), curve_(human) {}

  Fit Solve(const Variables& start, bool free_offset = true) const {
    Fit fit;
    fit.variables = start;
    double* const offset = fit.variables.offset.data();
    double* const timing = fit.variables.timing.data();
    ceres::Problem problem;
    auto* residuals = new Residuals{curve_, exo_, std::sqrt(options_.roughness_weight)};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Residuals, Residuals::kCount, 2, kKnots>(residuals),
                             nullptr, offset, timing);
    if (!free_offset) problem.SetParameterBlockConstant(offset);
    Minimize(problem, fit);
    return fit;
  }

  // With the offset as it is: the pace is that of the knee angles.
  Fit SolveBesideKnee(const Variables& start) const {
    Fit fit;
    fit.variables = start;
    const double mm_per_deg = RadiansFromDegrees((human_.knee.front() - human_.ankle.front()).norm());
    ceres::Problem problem;
    auto* residuals = new AngleResiduals{curve_, exo_, std::sqrt(options_.roughness_weight), mm_per_deg};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AngleResiduals, AngleResiduals::kCount, kKnots>(residuals),
                             nullptr, fit.variables.timing.data());
    Minimize(problem, fit);
    return fit;
  }

  // p alone, w(s) = s: linear.
  Variables PlacementOnly() const {
    Variables start;
    for (std::size_t i = 0; i < kPercentSamples; ++i)
      start.offset += ShankAxes(human_, i).transpose() * (exo_.knee[i] - human_.knee[i]) / kPercentSamples;
    return start;
  }

  Decomposition MakeResult(const Fit& fit, const char* start) const {
    Decomposition result;
    result.offset_mm = fit.variables.offset;
    result.converged = fit.converged;
    result.iterations = fit.iterations;
    result.cost = fit.cost;
    result.start = start;
    for (int k = 0; k < kKnots; ++k)
      result.knots_percent[static_cast<std::size_t>(k)] =
          ClampPercent(WarpAt(fit.variables.timing.data(), k * kKnotStep));
    double total = 0;
    Eigen::Vector3d parts = Eigen::Vector3d::Zero();
    for (int i = 0; i < kPercentSamples; ++i) {
      const double w = ClampPercent(WarpAt(fit.variables.timing.data(), i));
      const auto sample = static_cast<std::size_t>(i);
      const Vector2d difference = exo_.knee[sample] - human_.knee[sample];
      const Vector2d placement = curve_.FromShank(w, fit.variables.offset.data()),
                     timing = curve_.Knee(w) - human_.knee[sample];
      const Vector2d shape = difference - placement - timing;
      result.timing_percent.push_back(w - i);
      result.placement_mm.push_back(placement);
      result.timing_mm.push_back(timing);
      result.shape_mm.push_back(shape);
      parts += Eigen::Vector3d(placement.dot(difference), timing.dot(difference), shape.dot(difference));
      total += difference.squaredNorm();
    }
    parts = total > 0 ? Eigen::Vector3d(parts / total)
                      : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    result.placement = parts[0];
    result.timing = parts[1];
    result.shape = parts[2];
    return result;
  }

 private:
  void Minimize(ceres::Problem& problem, Fit& fit) const {
    double* const timing = fit.variables.timing.data();
    for (int k = 1; k < kKnots; ++k) problem.SetParameterLowerBound(timing, k, options_.least_slope * kKnotStep);
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_QR;
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = options_.tolerance;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    fit.cost = 2 * summary.final_cost;
    fit.iterations = static_cast<int>(summary.iterations.size());
    fit.converged = summary.termination_type == ceres::CONVERGENCE;
  }

  const StsCurve& human_;
  const StsCurve& exo_;
  const DecompositionOptions& options_;
  HumanCurve curve_;
};

}  // namespace

std::string PartNames() {
  std::string names = kParts.front().name;
  for (std::size_t k = 1; k < kParts.size(); ++k)
    names += fmt::format("{}{}", k + 1 < kParts.size() ? ", " : " and ", kParts[k].name);
  return names;
}

Decomposition Decompose(const StsCurve& human, const StsCurve& exo, const DecompositionOptions& options) {
  const Decomposer decomposer(human, exo, options);
  const std::pair<const char*, Variables> starts[] = {{"placement", decomposer.PlacementOnly()},
                                                      {"timing", decomposer.Solve(Variables(), false).variables},
                                                      {"zero", Variables()}};
  Fit best;
  const char* best_start = "";
  for (const auto& [name, start] : starts) {
    const Fit fit = decomposer.Solve(start);
    if (fit.cost < best.cost) {
      best = fit;
      best_start = name;
    }
  }
  return decomposer.MakeResult(best, best_start);
}

Decomposition DecomposeBesideKnee(const StsCurve& human, const StsCurve& exo, const Vector2d& joint_mm,
                                  const DecompositionOptions& options) {
  const Decomposer decomposer(human, exo, options);
  Variables variables;
  variables.offset = joint_mm;
  return decomposer.MakeResult(decomposer.SolveBesideKnee(variables), "joint");
}

}  // namespace lake::compare
