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

ceres::Solver::Options SolverOptions(std::size_t observations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 50;
  // Relative. The sum is about one per observation: stop at steps worth a thousandth of one.
  options.function_tolerance = 1e-3 / static_cast<double>(std::max<std::size_t>(observations, 1));
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

// Knots [begin, end), and the ones around them whose observations and priors reach them.
struct Piece {
  std::size_t begin, end, first, last;
};

// A movement forgets its ends within a second or so; the pieces' margins are given up.
std::vector<Piece> Pieces(const LegModel& model) {
  const std::size_t count = model.grid.count,
                    margin = static_cast<std::size_t>(std::ceil(model.piece_margin_s / model.grid.step_s)) + 4,
                    length = std::max<std::size_t>(model.knots_per_piece, 1);
  std::vector<Piece> pieces;
  for (std::size_t begin = 0; begin < count; begin += length) {
    const std::size_t end = begin + 2 * length > count ? count : begin + length;
    pieces.push_back({begin, end, begin - std::min(begin, margin), std::min(count, end + margin)});
    if (end == count) break;
  }
  return pieces;
}

// By Ceres, over the piece and its margins.
LegSolveSummary SolvePiece(const LegModel& model, const Piece& piece, std::vector<double>& coefficients) {
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);
  const auto block = [&](std::size_t k) { return coefficients.data() + k * static_cast<std::size_t>(model.states); };
  std::deque<MarkerCost> costs;
  std::deque<ceres::TukeyLoss> losses;
  auto observation =
      std::partition_point(model.observations.begin(), model.observations.end(),
                           [&](const LegObservation& o) { return model.At(o.frame).first < piece.first; });
  for (; observation != model.observations.end(); ++observation) {
    const SplineGrid::Place place = model.At(observation->frame);
    const std::size_t k = place.first;
    if (k + 4 > piece.last) break;
    costs.emplace_back(model, *observation, place.value);
    losses.emplace_back(model.OutlierLimit(*observation));
    problem.AddResidualBlock(&costs.back(), &losses.back(), block(k), block(k + 1), block(k + 2), block(k + 3));
  }
  std::deque<PriorCost> priors;
  for (std::size_t k = piece.first; k + 4 <= piece.last; ++k) {
    priors.emplace_back(model, k);
    problem.AddResidualBlock(&priors.back(), nullptr, block(k), block(k + 1), block(k + 2), block(k + 3));
  }
  ceres::Solver::Options options = SolverOptions(costs.size());
  InterruptCallback interrupt;
  options.callbacks.push_back(&interrupt);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  ThrowIfInterrupted();
  return {.usable = summary.IsSolutionUsable(),
          .iterations = static_cast<int>(summary.iterations.size()),
          .message = summary.message};
}

}  // namespace

LegSolveSummary SolveLegProblem(const LegModel& model, std::vector<double>& coefficients) {
  LegSolveSummary whole{.usable = true, .initial_cost = CostOf(model, coefficients), .message = ""};
  const std::vector<double> start = coefficients;
  for (const Piece& piece : Pieces(model)) {
    std::vector<double> solved = start;
    const LegSolveSummary summary = SolvePiece(model, piece, solved);
    const auto at = [&](std::size_t knot) {
      return static_cast<std::ptrdiff_t>(knot * static_cast<std::size_t>(model.states));
    };
    std::copy(solved.begin() + at(piece.begin), solved.begin() + at(piece.end), coefficients.begin() + at(piece.begin));
    whole.usable &= summary.usable;
    whole.iterations = std::max(whole.iterations, summary.iterations);
    whole.message = summary.message;
    if (!summary.usable) break;
  }
  whole.final_cost = CostOf(model, coefficients);
  return whole;
}

double RobustWeight(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual) {
  const double u = residual.norm() / (model.Scatter(observation) * model.OutlierLimit(observation));
  return u < 1 ? std::pow(1 - u * u, 2) : 0;
}

bool IsOrdinary(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual) {
  return residual.norm() < model.OutlierLimit(observation) * model.Scatter(observation);
}

LegCovariances CovariancesOf(const LegModel& model, const std::vector<double>& coefficients) {
  std::optional<LegCovariances> covariances = LegNormal(model, coefficients).Covariances();
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
