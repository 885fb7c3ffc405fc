#include "leg_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "leg_normal.h"

namespace lake::gait {
namespace {

using StateJet = ceres::Jet<double, kLegStates>;

LegResidual EvaluateAt(const LegModel& model, const LegObservation& observation, const StateVector& state) {
  std::array<StateJet, kLegStates> jets;
  for (int s = 0; s < kLegStates; ++s) jets[static_cast<std::size_t>(s)] = StateJet(state[s], s);
  const Eigen::Matrix<StateJet, 2, 1> in_leg = MarkerInLeg(observation.marker, jets.data());
  Eigen::Matrix<StateJet, 2, 1> in_plane;
  for (int i = 0; i < 2; ++i)
    in_plane[i] = in_leg[0] * model.plane_from_leg(i, 0) + in_leg[1] * model.plane_from_leg(i, 1);
  const Eigen::Matrix<StateJet, 2, 1> predicted =
      RecordedFromPlane<StateJet>(model.view, in_plane, model.depth_mm[observation.marker]);
  LegResidual residual;
  for (int i = 0; i < 2; ++i) {
    residual.value[i] = predicted[i].a - observation.seen[i];
    residual.by_state.row(i) = predicted[i].v.transpose();
  }
  return residual;
}

// r = (π(marker(Σ B_k c_k)) − seen) / σ over the four coefficient vectors c_k that reach the observation's time. The
// derivative by the state is automatic (Jets), that by the coefficients its product with the basis.
class MarkerCost : public ceres::CostFunction {
 public:
  MarkerCost(const LegModel& model, const LegObservation& observation, const std::array<double, 4>& weights)
      : model_(model), observation_(observation), weights_(weights) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->assign(4, model.states);
  }

  bool Evaluate(const double* const* coefficients, double* residuals, double** jacobians) const override {
    StateVector state = StateVector::Zero();
    for (std::size_t k = 0; k < 4; ++k)
      for (int s = 0; s < model_.states; ++s) state[s] += weights_[k] * coefficients[k][s];
    const LegResidual residual = EvaluateAt(model_, observation_, state);
    for (int i = 0; i < 2; ++i) residuals[i] = residual.value[i] / model_.Scatter(observation_);
    if (!jacobians) return true;
    for (std::size_t k = 0; k < 4; ++k)
      for (int i = 0; jacobians[k] && i < 2; ++i)
        for (int s = 0; s < model_.states; ++s)
          jacobians[k][i * model_.states + s] = weights_[k] / model_.Scatter(observation_) * residual.by_state(i, s);
    return true;
  }

 private:
  const LegModel& model_;
  const LegObservation& observation_;
  std::array<double, 4> weights_;
};

// r_j = row_j · (c_k, …, c_k+3) for all terms of the prior.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(const LegModel& model, std::size_t k) : terms_(PriorTerms(model, k)), states_(model.states) {
    set_num_residuals(static_cast<int>(terms_.size()));
    mutable_parameter_block_sizes()->assign(4, model.states);
  }

  bool Evaluate(const double* const* coefficients, double* residuals, double** jacobians) const override {
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      residuals[j] = 0;
      for (std::size_t k = 0; k < 4; ++k) residuals[j] += terms_[j].row[k] * coefficients[k][terms_[j].state];
    }
    if (!jacobians) return true;
    const auto states = static_cast<std::size_t>(states_);
    for (std::size_t k = 0; k < 4; ++k) {
      if (!jacobians[k]) continue;
      std::fill_n(jacobians[k], terms_.size() * states, 0.0);
      for (std::size_t j = 0; j < terms_.size(); ++j)
        jacobians[k][j * states + static_cast<std::size_t>(terms_[j].state)] = terms_[j].row[k];
    }
    return true;
  }

 private:
  std::vector<PriorTerm> terms_;
  int states_;
};

class InterruptCallback : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    try {
      ThrowIfInterrupted();  // not through Ceres, which would not free what it holds
    } catch (const Interrupted&) {
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }
};

constexpr int kMostIterations = 50;

// Relative. The sum is about one per observation: stop at steps worth a hundredth of one.
double CostTolerance(std::size_t observations) {
  return 0.01 / static_cast<double>(std::max<std::size_t>(observations, 1));
}

ceres::Solver::Options SolverOptions(std::size_t observations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kMostIterations;
  options.function_tolerance = CostTolerance(observations);
  options.initial_trust_region_radius = 1e8;  // the start is good and the problem nearly linear: full steps
  options.num_threads = 1;  // more add up the cost in the order in which they end: other last digits from run to run
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

std::vector<PriorTerm> PriorTerms(const LegModel& model, std::size_t k) {
  std::vector<PriorTerm> terms;
  for (int s = 0; s < model.states; ++s) {
    const LegPrior& prior = model.priors[static_cast<std::size_t>(s)];
    const double rough = 1 / std::sqrt(prior.roughness[k]);
    terms.push_back({s, {-rough, 3 * rough, -3 * rough, rough}});
    if (prior.slope_variance <= 0) continue;
    const double slope = 1 / std::sqrt(prior.slope_variance);
    terms.push_back({s, {-slope, slope, 0, 0}});
  }
  return terms;
}

double PriorResidual(const LegModel& model, const PriorTerm& term, std::size_t k,
                     const std::vector<double>& coefficients) {
  const auto states = static_cast<std::size_t>(model.states);
  double residual = 0;
  for (std::size_t a = 0; a < 4; ++a)
    residual += term.row[a] * coefficients[(k + a) * states + static_cast<std::size_t>(term.state)];
  return residual;
}

LegResidual EvaluateObservation(const LegModel& model, const LegObservation& observation,
                                const std::vector<double>& coefficients) {
  const SplineGrid::Place place = model.At(observation.frame);
  return EvaluateAt(model, observation, StateAt(model, coefficients, place.value, place.first));
}

namespace {

// Half the sum.
double CostOf(const LegModel& model, const std::vector<double>& coefficients) {
  double sum = 0;
  for (const LegObservation& observation : model.observations) {
    const double limit2 = std::pow(model.OutlierLimit(observation), 2);
    const double deviations =
        EvaluateObservation(model, observation, coefficients).value.norm() / model.Scatter(observation);
    const double left = 1 - std::min(1.0, deviations * deviations / limit2);
    sum += limit2 / 3 * (1 - left * left * left);
  }
  for (std::size_t k = 0; k + 3 < model.grid.count; ++k)
    for (const PriorTerm& term : PriorTerms(model, k)) sum += std::pow(PriorResidual(model, term, k, coefficients), 2);
  return sum / 2;
}

// Levenberg and Marquardt's steps, almost Gauss and Newton's as long as they lead downhill.
LegSolveSummary SolveInBands(const LegModel& model, std::vector<double>& coefficients) {
  constexpr double kLeastDamping = 1e-8, kMostDamping = 1e8, kFactor = 10;
  const double tolerance = CostTolerance(model.observations.size());
  LegSolveSummary summary;
  summary.initial_cost = summary.final_cost = CostOf(model, coefficients);
  summary.message = "too many steps";
  for (double damping = kLeastDamping; damping < kMostDamping && summary.iterations < kMostIterations;) {
    ++summary.iterations;
    const std::optional<std::vector<double>> step = LegNormal(model, coefficients, damping).Step();
    if (!step) {
      summary.message = "the markers do not determine the leg";
      return summary;
    }
    std::vector<double> next = coefficients;
    for (std::size_t i = 0; i < next.size(); ++i) next[i] -= (*step)[i];
    const double cost = CostOf(model, next), gain = summary.final_cost - cost;
    const bool has_converged = std::abs(gain) <= tolerance * summary.final_cost;
    if (gain > 0) coefficients = std::move(next), summary.final_cost = cost;
    if (has_converged) {
      summary.message = "converged";
      break;
    }
    damping = gain > 0 ? std::max(damping / kFactor, kLeastDamping) : damping * kFactor * kFactor;
  }
  summary.usable = std::isfinite(summary.final_cost);
  return summary;
}

}  // namespace

LegSolveSummary SolveLegProblem(const LegModel& model, std::vector<double>& coefficients) {
  if (model.in_bands) return SolveInBands(model, coefficients);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);

  const auto block = [&](std::size_t k) { return coefficients.data() + k * static_cast<std::size_t>(model.states); };
  std::deque<MarkerCost> costs;
  std::deque<ceres::TukeyLoss> losses;
  for (const LegObservation& observation : model.observations) {
    const SplineGrid::Place place = model.At(observation.frame);
    const std::size_t k = place.first;
    costs.emplace_back(model, observation, place.value);
    losses.emplace_back(model.OutlierLimit(observation));
    problem.AddResidualBlock(&costs.back(), &losses.back(), block(k), block(k + 1), block(k + 2), block(k + 3));
  }
  std::deque<PriorCost> priors;
  for (std::size_t k = 0; k + 3 < model.grid.count; ++k) {
    priors.emplace_back(model, k);
    problem.AddResidualBlock(&priors.back(), nullptr, block(k), block(k + 1), block(k + 2), block(k + 3));
  }

  ceres::Solver::Options options = SolverOptions(model.observations.size());
  InterruptCallback interrupt;
  options.callbacks.push_back(&interrupt);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  ThrowIfInterrupted();
  return {summary.IsSolutionUsable(), static_cast<int>(summary.iterations.size()), summary.initial_cost,
          summary.final_cost, summary.message};
}

double RobustWeight(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual) {
  const double u = residual.norm() / (model.Scatter(observation) * model.OutlierLimit(observation));
  return u < 1 ? std::pow(1 - u * u, 2) : 0;
}

bool IsOrdinary(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual) {
  return residual.norm() < model.OutlierLimit(observation) * model.Scatter(observation);
}

StateCovariances CovariancesOf(const LegModel& model, const std::vector<double>& coefficients) {
  std::optional<StateCovariances> covariances = LegNormal(model, coefficients, 0).Covariances();
  if (!covariances)
    throw SolverError(
        "leg fit: the markers do not determine the leg; is one of ankle, knee, hip missing in most frames?");
  return *std::move(covariances);
}

void StateCovariances::Set(std::size_t frame, const StateMatrix& covariance) {
  auto value = lower_[frame].begin();
  for (int i = 0; i < kLegStates; ++i)
    for (int j = 0; j <= i; ++j) *value++ = covariance(i, j);
}

StateMatrix StateCovariances::At(std::size_t frame) const {
  StateMatrix covariance;
  auto value = lower_[frame].begin();
  for (int i = 0; i < kLegStates; ++i)
    for (int j = 0; j <= i; ++j) covariance(i, j) = covariance(j, i) = *value++;
  return covariance;
}

StateVector StateAt(const LegModel& model, const std::vector<double>& coefficients,
                    const std::array<double, 4>& weights, std::size_t first) {
  const auto states = static_cast<std::size_t>(model.states);
  StateVector state = StateVector::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t s = 0; s < states; ++s)
      state[static_cast<Eigen::Index>(s)] += weights[k] * coefficients[(first + k) * states + s];
  return state;
}

}  // namespace lake::gait
