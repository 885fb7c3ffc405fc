#include "lake/certificate/stationary_point.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "lake/certificate/enclosure.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"

namespace lake::certificate {
namespace {

using Box = std::vector<Interval>;

// Which limits are active, and what is unknown.
struct ActiveSystem {
  struct Row {
    int index;
    double limit;
    int side;  // 1: at its lower limit, -1: at its upper, 0: an equation
  };
  std::vector<Row> rows;
  std::vector<int> free;          // variables
  std::vector<int> fixed;         // variables at a bound
  std::vector<std::string> held;  // variables of no effect on the cost and the active rows
  std::vector<int> side;  // of each variable: 1 at its lower bound, -1 at its upper, 0 free, held or of no effect
  Box x;                  // of all variables; the free ones as the solver left them

  std::size_t Size() const { return free.size() + rows.size(); }
};

const Enclosable& EnclosableOf(const nlp::NlpTerm& term) {
  const auto* enclosable = dynamic_cast<const Enclosable*>(term.term.get());
  if (!enclosable) throw Fail("a stationary point cannot be certified: a term of the program cannot be enclosed");
  return *enclosable;
}

// A variable that only rows read that are clear, as the heading in which a part is clear, is held where it is.
std::vector<bool> HasEffect(const nlp::NonlinearProgram& program, const std::vector<ActiveSystem::Row>& rows) {
  std::vector<bool> active(program.Rows().size()), effect(program.Variables().size());
  for (const ActiveSystem::Row& row : rows) active[row.index] = true;
  for (const nlp::NlpTerm& term : program.Terms())
    if (term.row == nlp::NlpTerm::kCost || active[term.row])
      for (const int variable : term.term->Variables()) effect[variable] = true;
  return effect;
}

ActiveSystem ActiveSystemOf(const nlp::NonlinearProgram& program, const std::vector<double>& x) {
  ActiveSystem system;
  const std::vector<double> values = program.RowValues(x);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const nlp::NlpRow& row = program.Rows()[i];
    const int index = static_cast<int>(i);
    if (row.lower == row.upper)
      system.rows.push_back({index, row.lower, 0});
    else if (IsActive(values[i], row.lower))
      system.rows.push_back({index, row.lower, 1});
    else if (IsActive(values[i], row.upper))
      system.rows.push_back({index, row.upper, -1});
  }
  const std::vector<bool> has_effect = HasEffect(program, system.rows);
  for (std::size_t j = 0; j < x.size(); ++j) {
    const nlp::NlpVariable& variable = program.Variables()[j];
    const bool is_held = variable.lower == variable.upper;
    const int side = is_held || !has_effect[j]        ? 0
                     : IsActive(x[j], variable.lower) ? 1
                     : IsActive(x[j], variable.upper) ? -1
                                                      : 0;
    system.side.push_back(side);
    system.x.emplace_back(is_held || side > 0 ? variable.lower : side < 0 ? variable.upper : x[j]);
    if (side != 0)
      system.fixed.push_back(static_cast<int>(j));
    else if (is_held)
      continue;
    else if (has_effect[j])
      system.free.push_back(static_cast<int>(j));
    else
      system.held.push_back(variable.name);
  }
  return system;
}

// grad f - sum m grad c by all variables, the active rows less their limits, and the Jacobian of the system.
struct Conditions {
  Box stationarity, rows;
  std::vector<Box> jacobian;
};

class KktSystem {
 public:
  KktSystem(const nlp::NonlinearProgram& program, const ActiveSystem& active) : program_(program), active_(active) {
    place_.assign(program.Variables().size(), -1);
    for (std::size_t k = 0; k < active.free.size(); ++k) place_[active.free[k]] = static_cast<int>(k);
    active_row_.assign(program.Rows().size(), -1);
    for (std::size_t k = 0; k < active.rows.size(); ++k) active_row_[active.rows[k].index] = static_cast<int>(k);
  }

  // All variables where the unknowns are `z`.
  Box VariablesAt(const Box& z) const {
    Box x = active_.x;
    for (std::size_t k = 0; k < active_.free.size(); ++k) x[active_.free[k]] = z[k];
    return x;
  }

  Conditions At(const Box& z) const {
    const std::size_t free = active_.free.size(), size = active_.Size();
    const Box x = VariablesAt(z);
    Conditions at{Box(x.size()), Box(active_.rows.size()), std::vector<Box>(size, Box(size))};
    for (std::size_t k = 0; k < active_.rows.size(); ++k) at.rows[k] = -active_.rows[k].limit;
    for (const nlp::NlpTerm& term : program_.Terms()) {
      const bool is_cost = term.row == nlp::NlpTerm::kCost;
      const int row = is_cost ? -1 : active_row_[term.row];
      if (!is_cost && row < 0) continue;
      const Enclosure f = EnclosableOf(term).Enclose(x);
      const Interval weight = is_cost ? Interval(1) : -z[free + row];
      if (row >= 0) at.rows[row] = at.rows[row] + f.value;
      const auto variables = term.term->Variables();
      for (int i = 0; i < f.count; ++i) {
        const int place = place_[variables[i]];
        at.stationarity[variables[i]] = at.stationarity[variables[i]] + weight * f.first[i];
        if (place < 0) continue;
        if (row >= 0) {
          Interval& down = at.jacobian[free + row][place];
          down = down + f.first[i];
          at.jacobian[place][free + row] = -down;
        }
        for (int j = 0; j < f.count; ++j)
          if (const int other = place_[variables[j]]; other >= 0)
            at.jacobian[place][other] = at.jacobian[place][other] + weight * f.Second(i, j);
      }
    }
    return at;
  }

  // The system's residuals.
  Box ResidualsOf(const Conditions& at) const {
    Box residuals;
    residuals.reserve(active_.Size());
    for (const int variable : active_.free) residuals.push_back(at.stationarity[variable]);
    residuals.insert(residuals.end(), at.rows.begin(), at.rows.end());
    return residuals;
  }

 private:
  const nlp::NonlinearProgram& program_;
  const ActiveSystem& active_;
  std::vector<int> place_, active_row_;  // -1: not free, not active
};

Eigen::MatrixXd MiddleOf(const std::vector<Box>& matrix) {
  const auto size = static_cast<Eigen::Index>(matrix.size());
  Eigen::MatrixXd middle(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j) middle(i, j) = matrix[i][j].Middle();
  return middle;
}

// The gradients of the active rows, each scaled to length one, do not span as many directions as they are.
bool HasDependentLimits(const Eigen::MatrixXd& jacobian, const ActiveSystem& active) {
  const auto rows = static_cast<Eigen::Index>(active.rows.size()), free = static_cast<Eigen::Index>(active.free.size());
  if (rows > free) return true;
  const Eigen::MatrixXd gradients = jacobian.bottomLeftCorner(rows, free).rowwise().normalized();
  return rows > 0 && Eigen::JacobiSVD<Eigen::MatrixXd>(gradients).singularValues().tail<1>()[0] < kIndependent;
}

Box PointsAt(const Eigen::VectorXd& z) {
  return {z.data(), z.data() + z.size()};
}

// Newton's method in plain floating point, to the last digits; nullopt where the Jacobian is singular to rounding.
struct Centre {
  Eigen::VectorXd z;
  Eigen::MatrixXd inverse;
  Box residuals;  // at z
};
std::optional<Centre> FindCentre(const KktSystem& system, Eigen::VectorXd z) {
  constexpr int kSteps = 6;
  constexpr double kSingular = 1e-14;
  for (int step = 0;; ++step) {
    const Conditions at = system.At(PointsAt(z));
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(MiddleOf(at.jacobian));
    if (!(lu.rcond() > kSingular)) return std::nullopt;
    const Box enclosed = system.ResidualsOf(at);
    if (step == kSteps) return Centre{z, lu.inverse(), enclosed};
    Eigen::VectorXd residuals(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) residuals[i] = enclosed[i].Middle();
    z -= lu.solve(residuals);
    if (!z.allFinite()) return std::nullopt;
  }
}

// z - Y F(z) + (I - Y F'(Z)) (Z - z) less z, for the box Z of these radii about z.
Box KrawczykAbout(const KktSystem& system, const Centre& centre, const std::vector<double>& radii) {
  const std::size_t size = radii.size();
  Box box(size), moved(size);
  for (std::size_t i = 0; i < size; ++i) box[i] = Interval(centre.z[i]) + Interval(-radii[i], radii[i]);
  const std::vector<Box> jacobian = system.At(box).jacobian;
  std::vector<std::vector<std::size_t>> entries(size);  // of each column, those that are not zero throughout
  for (std::size_t j = 0; j < size; ++j)
    for (std::size_t k = 0; k < size; ++k)
      if (jacobian[k][j].lower != 0 || jacobian[k][j].upper != 0) entries[j].push_back(k);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < size; ++k) moved[i] = moved[i] - Interval(centre.inverse(i, k)) * centre.residuals[k];
    for (std::size_t j = 0; j < size; ++j) {
      Interval left = i == j ? 1 : 0;
      for (const std::size_t k : entries[j]) left = left - Interval(centre.inverse(i, k)) * jacobian[k][j];
      moved[i] = moved[i] + left * Interval(-radii[j], radii[j]);
    }
  }
  return moved;
}

// The radii of a box that is mapped into its interior; empty if none is found. Those of the variables are as large as
// asked for, or smaller by powers of ten; those of the multipliers follow.
std::vector<double> RadiiMappedInside(const KktSystem& system, const Centre& centre, std::size_t variables) {
  constexpr double kRelative = 5e-9;  // of angles near one it is 1e-6 mm at the end of a link
  for (const double share : {1.0, 0.1, 0.01}) {
    std::vector<double> radii(centre.z.size());
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const double size = std::max(1.0, std::abs(centre.z[i]));
      radii[i] = i < variables ? share * std::min(kStationaryRadius, kRelative * size) : kRelative * size;
    }
    constexpr int kWidenings = 12;
    for (int widening = 0; widening < kWidenings; ++widening) {
      ThrowIfInterrupted();
      const Box moved = KrawczykAbout(system, centre, radii);
      bool is_inside = true, may_be = true;
      for (std::size_t i = 0; i < radii.size(); ++i) {
        if (-moved[i].lower < radii[i] && moved[i].upper < radii[i]) continue;  // false for what is not a number
        is_inside = false;
        may_be = may_be && i >= variables && std::isfinite(moved[i].lower) && std::isfinite(moved[i].upper);
        radii[i] = 2 * std::max(-moved[i].lower, moved[i].upper);
      }
      if (is_inside) return radii;
      if (!may_be) break;
    }
  }
  return {};
}

// What is not as it must be in the box; empty if nothing is.
std::string Contradiction(const nlp::NonlinearProgram& program, const ActiveSystem& active, const KktSystem& system,
                          const Box& z) {
  const std::size_t free = active.free.size();
  for (std::size_t k = 0; k < active.rows.size(); ++k) {
    const ActiveSystem::Row& row = active.rows[k];
    const Interval multiplier = row.side * z[free + k];
    if (row.side != 0 && !(multiplier.lower > 0))
      return fmt::format("'{}' is at its limit without a price", program.Rows()[row.index].name);
  }
  const Conditions at = system.At(z);
  for (const int j : active.fixed)
    if (!((active.side[j] * at.stationarity[j]).lower > 0))
      return fmt::format("{} is at its bound without a price", program.Variables()[j].name);
  const Box x = system.VariablesAt(z);
  for (const int j : active.free)
    if (!(x[j].lower > program.Variables()[j].lower && x[j].upper < program.Variables()[j].upper))
      return fmt::format("{} is not clear of its bounds", program.Variables()[j].name);
  std::vector<bool> is_active(program.Rows().size());
  for (const ActiveSystem::Row& row : active.rows) is_active[row.index] = true;
  Box values(program.Rows().size());
  for (const nlp::NlpTerm& term : program.Terms())
    if (term.row != nlp::NlpTerm::kCost && !is_active[term.row])
      values[term.row] = values[term.row] + EnclosableOf(term).Enclose(x).value;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_active[i] && !(values[i].lower > program.Rows()[i].lower && values[i].upper < program.Rows()[i].upper))
      return fmt::format("'{}' is not clear of its limit", program.Rows()[i].name);
  return "";
}

}  // namespace

bool IsActive(double value, double limit) {
  constexpr double kTouching = 1e-5;  // far above an interior point's distance to an active limit, mu / price
  return std::isfinite(limit) && std::abs(value - limit) <= kTouching * std::max(1.0, std::abs(limit));
}

double StationaryPoint::Distance(const std::vector<double>& x, std::span<const int> variables) const {
  double distance = 0;
  for (const int j : variables) {
    const Interval away = box[j] - Interval(x[j]);
    distance = std::max({distance, -away.lower, away.upper});
  }
  return distance;
}

double StationaryPoint::SmallestRadius(std::span<const int> variables) const {
  double smallest = kInfinity;
  for (const int j : variables)
    if (radii[j] > 0) smallest = std::min(smallest, radii[j]);
  return smallest;
}

StationaryPoint CertifyStationaryPoint(const nlp::NonlinearProgram& program, const nlp::NlpSolution& solution) {
  const ActiveSystem active = ActiveSystemOf(program, solution.x);
  const KktSystem system(program, active);
  StationaryPoint point;
  point.unknowns = static_cast<int>(active.Size());
  point.held = active.held;
  constexpr int kMostUnknowns = 600;  // the work grows with the third power
  if (point.unknowns > kMostUnknowns) {
    point.reason =
        fmt::format("its program has {} unknowns, more than the {} that are tried", point.unknowns, kMostUnknowns);
    return point;
  }
  Eigen::VectorXd start(active.Size());
  for (std::size_t k = 0; k < active.free.size(); ++k) start[k] = solution.x[active.free[k]];
  for (std::size_t k = 0; k < active.rows.size(); ++k)
    start[active.free.size() + k] = solution.row_marginal_costs[active.rows[k].index];
  const std::optional<Centre> centre = FindCentre(system, start);
  const std::vector<double> radii =
      centre ? RadiiMappedInside(system, *centre, active.free.size()) : std::vector<double>();
  if (radii.empty()) {
    point.reason = HasDependentLimits(MiddleOf(system.At(PointsAt(start)).jacobian), active)
                       ? "the gradients of its active limits are linearly dependent"
                       : "its conditions are too near singular for the proof, or too curved for the box";
    return point;
  }
  Box z(radii.size());
  for (std::size_t i = 0; i < radii.size(); ++i) z[i] = Interval(centre->z[i]) + Interval(-radii[i], radii[i]);
  point.box = system.VariablesAt(z);
  point.radii.assign(point.box.size(), 0);
  for (std::size_t k = 0; k < active.free.size(); ++k) point.radii[active.free[k]] = radii[k];
  std::vector<int> all(point.box.size());
  std::iota(all.begin(), all.end(), 0);
  if (!(point.Distance(solution.x, all) <= kStationaryDistance))
    point.reason = "the nearest stationary point is another";
  if (point.reason.empty()) point.reason = Contradiction(program, active, system, z);
  point.is_certified = point.reason.empty();
  return point;
}

}  // namespace lake::certificate
