#include "lake/sync/align.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "offsets.h"

namespace lake::sync {
namespace {

using Eigen::Index;

// x's clock from y's: t + offset + drift (t − from), s and s/s.
struct Warp {
  double offset_s = 0, drift = 0, from_s = 0;
  double At(double time_s) const { return time_s + offset_s + drift * (time_s - from_s); }
};

// One part at the times at which both are known, a row each.
struct Rows {
  std::vector<double> time_s;  // y's
  std::vector<Index> row;      // of y
  Eigen::MatrixXd y, x, slope;

  Index Count() const { return y.rows(); }
};

Rows RowsOf(const Part& part, const Warp& warp) {
  Rows rows;
  const Index all = part.y.Rows();
  rows.y.resize(all, part.y.value.cols());
  rows.x.resize(all, part.x.value.cols());
  rows.slope.resize(all, part.x.value.cols());
  Eigen::RowVectorXd value, slope;
  Index n = 0;
  for (Index i = 0; i < all; ++i) {
    const double t = part.y.TimeAt(i);
    if (!part.y.known[static_cast<std::size_t>(i)] || !ValuesAt(part.x, warp.At(t), value, slope)) continue;
    rows.time_s.push_back(t);
    rows.row.push_back(i);
    rows.y.row(n) = part.y.value.row(i);
    rows.x.row(n) = value;
    rows.slope.row(n) = slope;
    ++n;
  }
  rows.y.conservativeResize(n, Eigen::NoChange);
  rows.x.conservativeResize(n, Eigen::NoChange);
  rows.slope.conservativeResize(n, Eigen::NoChange);
  return rows;
}

// What a signal's past tells of it, by least squares; rows that do not follow one another are left out.
constexpr Index kOrder = 4;

Eigen::VectorXd Autoregression(const Eigen::VectorXd& residual, const std::vector<Index>& row) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(kOrder, kOrder);
  Eigen::VectorXd product = Eigen::VectorXd::Zero(kOrder);
  for (Index i = kOrder; i < residual.size(); ++i) {
    if (row[static_cast<std::size_t>(i)] - row[static_cast<std::size_t>(i - kOrder)] != kOrder) continue;
    const Eigen::VectorXd past = residual.segment(i - kOrder, kOrder).reverse();
    square += past * past.transpose();
    product += residual[i] * past;
  }
  square.diagonal() *= 1 + 1e-9;
  return square.trace() > 0 ? Eigen::VectorXd(square.ldlt().solve(product)) : Eigen::VectorXd::Zero(kOrder);
}

// Each row less what its past tells; the first rows of a stretch go.
Eigen::MatrixXd Innovations(const Eigen::MatrixXd& signals, const Eigen::VectorXd& past, const std::vector<Index>& row,
                            std::vector<Index>* kept = nullptr) {
  Eigen::MatrixXd innovations(signals.rows(), signals.cols());
  Index n = 0;
  for (Index i = kOrder; i < signals.rows(); ++i) {
    if (row[static_cast<std::size_t>(i)] - row[static_cast<std::size_t>(i - kOrder)] != kOrder) continue;
    innovations.row(n) = signals.row(i);
    for (Index k = 0; k < kOrder; ++k) innovations.row(n) -= past[k] * signals.row(i - 1 - k);
    if (kept) kept->push_back(i);
    ++n;
  }
  innovations.conservativeResize(n, Eigen::NoChange);
  return innovations;
}

// What one column of one part says of offset and drift, by the innovations' time: how they change with both, beside
// what the map takes, and what is left; in units of their standard deviation.
struct Evidence {
  std::vector<double> time_s = {};
  Eigen::MatrixX2d change = {};
  Eigen::VectorXd left = {};
  // Of which column of which part, its map with the constant, and what its residual's past tells.
  std::size_t part = 0;
  Index column = 0;
  Eigen::VectorXd map = {}, past = {};
  double sigma = 1;
};

struct Fit {
  std::vector<Evidence> evidence;
  double unexplained = 1, first_s = 0, last_s = 0;
};

// So many rows for each unknown at least.
bool IsEnough(Index rows, Index unknowns) {
  constexpr Index kRows = 4;
  return rows >= kRows * (unknowns + kOrder);
}

// One column of y from x and the constant, by generalised least squares: the map and its residual's autoregression in
// turns.
struct ColumnFit {
  Eigen::VectorXd map, past;
  Eigen::MatrixXd known_now;  // the innovations of x and the constant
  double all = 0, left = 0;   // sums of squares: of y about its mean, and of what the map leaves
};

ColumnFit FitColumn(const Eigen::VectorXd& y, const Eigen::MatrixXd& known, const std::vector<Index>& row) {
  ColumnFit fit;
  fit.map = known.colPivHouseholderQr().solve(y);
  constexpr int kTurns = 3;
  for (int turn = 0; turn < kTurns; ++turn) {
    fit.past = Autoregression(y - known * fit.map, row);
    fit.known_now = Innovations(known, fit.past, row);
    if (!IsEnough(fit.known_now.rows(), known.cols())) break;
    fit.map = fit.known_now.colPivHouseholderQr().solve(Innovations(y, fit.past, row));
  }
  const Eigen::VectorXd residual = y - known * fit.map;
  fit.all = (y.array() - y.mean()).square().sum();
  fit.left = (residual.array() - residual.mean()).square().sum();
  return fit;
}

Evidence EvidenceOf(const Rows& rows, Index column, const Eigen::MatrixXd& known, const ColumnFit& fit,
                    const Warp& warp) {
  const Index n = rows.Count();
  Eigen::MatrixXd change(n, 2);
  change.col(0) = rows.slope * fit.map.head(rows.x.cols());
  for (Index i = 0; i < n; ++i) change(i, 1) = change(i, 0) * (rows.time_s[static_cast<std::size_t>(i)] - warp.from_s);
  std::vector<Index> kept;
  const Eigen::MatrixXd change_now = Innovations(change, fit.past, rows.row, &kept);
  const Eigen::MatrixXd residual = rows.y.col(column) - known * fit.map;
  const Eigen::VectorXd left_now = Innovations(residual, fit.past, rows.row);
  const auto qr = fit.known_now.colPivHouseholderQr();
  const double sigma = std::sqrt(left_now.squaredNorm() / static_cast<double>(left_now.size() - known.cols()));
  Evidence evidence{.column = column, .map = fit.map, .past = fit.past, .sigma = sigma};
  for (const Index i : kept) evidence.time_s.push_back(rows.time_s[static_cast<std::size_t>(i)]);
  evidence.change = (change_now - fit.known_now * qr.solve(change_now)) / sigma;
  evidence.left = left_now / sigma;
  return evidence;
}

Fit FitMaps(const Pairing& pairing, const Warp& warp) {
  Fit fit;
  double all = 0, left = 0;
  fit.first_s = kInfinity;
  fit.last_s = -kInfinity;
  for (std::size_t k = 0; k < pairing.parts.size(); ++k) {
    const Rows rows = RowsOf(pairing.parts[k], warp);
    const Index n = rows.Count();
    if (!IsEnough(n, rows.x.cols() + 1)) continue;
    fit.first_s = std::min(fit.first_s, rows.time_s.front());
    fit.last_s = std::max(fit.last_s, rows.time_s.back());
    Eigen::MatrixXd known(n, rows.x.cols() + 1);
    known << rows.x, Eigen::VectorXd::Ones(n);
    const double rounding = 1e-12 * rows.y.squaredNorm();
    for (Index j = 0; j < rows.y.cols(); ++j) {
      const ColumnFit column = FitColumn(rows.y.col(j), known, rows.row);
      all += column.all;
      left += column.left;
      if (!(column.all > rounding) || !IsEnough(column.known_now.rows(), known.cols())) continue;
      fit.evidence.push_back(EvidenceOf(rows, j, known, column, warp));
      fit.evidence.back().part = k;
    }
  }
  fit.unexplained = all > 0 ? left / all : 1;
  return fit;
}

struct Step {
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

// The step to the most likely offset and drift, and their covariance: the likelihood's where the innovations are
// independent, in time and among the signals, and wider where they are not (the sandwich; Newey & West 1987 with 1 s).
Step Solve(const Fit& fit, const Warp& warp, double drift_sd) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d score = Eigen::Vector2d::Zero();
  std::vector<std::pair<double, Eigen::Vector2d>> scores;
  for (const Evidence& evidence : fit.evidence) {
    information += evidence.change.transpose() * evidence.change;
    score += evidence.change.transpose() * evidence.left;
    for (std::size_t i = 0; i < evidence.time_s.size(); ++i)
      scores.emplace_back(evidence.time_s[i], evidence.change.row(static_cast<Index>(i)).transpose() *
                                                  evidence.left[static_cast<Index>(i)]);
  }
  Eigen::Matrix2d whole = information;
  if (drift_sd > 0) {
    whole(1, 1) += 1 / (drift_sd * drift_sd);
    score[1] -= warp.drift / (drift_sd * drift_sd);
  } else {
    whole(1, 1) = 1;
    whole(0, 1) = whole(1, 0) = 0;
    score[1] = 0;
  }
  Step result;
  const Eigen::Matrix2d inverse = whole.inverse();
  result.step = inverse * score;
  std::ranges::sort(scores, {}, [](const auto& s) { return s.first; });
  constexpr double kMemory_s = 1;
  Eigen::Matrix2d meat = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < scores.size(); ++i)
    for (std::size_t k = i; k < scores.size() && scores[k].first - scores[i].first < kMemory_s; ++k) {
      const double weight = 1 - (scores[k].first - scores[i].first) / kMemory_s;
      const Eigen::Matrix2d product = scores[i].second * scores[k].second.transpose();
      meat += k == i ? product : Eigen::Matrix2d(weight * (product + product.transpose()));
    }
  const Eigen::Matrix2d sandwich = inverse * meat * inverse;
  result.covariance = inverse;
  for (Index k = 0; k < 2; ++k) {
    const double wider = std::max(1.0, std::sqrt(sandwich(k, k) / inverse(k, k)));
    result.covariance.row(k) *= wider;
    result.covariance.col(k) *= wider;
  }
  if (!(drift_sd > 0)) {
    result.covariance.row(1).setZero();
    result.covariance.col(1).setZero();
  }
  return result;
}

// The overlap in parts that hold equally much of what there is to tell of the offset: their ends, on y's clock.
constexpr std::size_t kParts = 5;

std::vector<double> PartEnds(const Fit& fit) {
  std::vector<std::pair<double, double>> told;
  double all = 0;
  for (const Evidence& evidence : fit.evidence)
    for (std::size_t i = 0; i < evidence.time_s.size(); ++i) {
      told.emplace_back(evidence.time_s[i], std::pow(evidence.change(static_cast<Index>(i), 0), 2));
      all += told.back().second;
    }
  std::ranges::sort(told);
  std::vector<double> ends;
  double sum = 0;
  for (const auto& [time_s, square] : told)
    if (sum += square; ends.size() + 1 < kParts && sum > all * static_cast<double>(ends.size() + 1) / kParts)
      ends.push_back(time_s);
  ends.push_back(kInfinity);
  return ends;
}

// Each part's own offset: where, with the maps of the whole, its innovations are least within half a second.
std::vector<PartOffset> OffsetsOfParts(const Pairing& pairing, const Fit& fit, const Warp& warp) {
  constexpr double kReach_s = 0.5, kStep_s = 0.01;
  const std::vector<double> ends = PartEnds(fit);
  const int reach = static_cast<int>(kReach_s / kStep_s);
  const auto tried = static_cast<std::size_t>(2 * reach + 1);
  std::vector<std::vector<double>> cost(ends.size(), std::vector<double>(tried, 0)), count = cost;
  const auto part_of = [&](double t) {
    return static_cast<std::size_t>(std::ranges::lower_bound(ends, t) - ends.begin());
  };
  for (std::size_t s = 0; s < tried; ++s) {
    Warp moved = warp;
    moved.offset_s += (static_cast<double>(s) - reach) * kStep_s;
    for (std::size_t k = 0; k < pairing.parts.size(); ++k) {
      const Rows rows = RowsOf(pairing.parts[k], moved);
      for (const Evidence& evidence : fit.evidence) {
        if (evidence.part != k || rows.Count() <= kOrder) continue;
        const Eigen::VectorXd residual =
            (rows.y.col(evidence.column) - rows.x * evidence.map.head(rows.x.cols())).array() -
            evidence.map[rows.x.cols()];
        std::vector<Index> kept;
        const Eigen::VectorXd left =
            Innovations(Eigen::MatrixXd(residual), evidence.past, rows.row, &kept) / evidence.sigma;
        for (std::size_t i = 0; i < kept.size(); ++i) {
          const std::size_t part = part_of(rows.time_s[static_cast<std::size_t>(kept[i])]);
          cost[part][s] += left[static_cast<Index>(i)] * left[static_cast<Index>(i)];
          ++count[part][s];
        }
      }
    }
  }
  std::vector<PartOffset> parts;
  double from_s = fit.first_s;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    std::vector<double> mean;
    for (std::size_t s = 0; s < tried; ++s) mean.push_back(count[k][s] > 0 ? cost[k][s] / count[k][s] : kInfinity);
    const auto least = static_cast<std::size_t>(std::ranges::min_element(mean) - mean.begin());
    const double to_s = std::min(ends[k], fit.last_s);
    PartOffset& part = parts.emplace_back(PartOffset{.time_s = (from_s + to_s) / 2});
    from_s = to_s;
    part.departure_s = (static_cast<double>(least) - reach) * kStep_s;
    part.sd_s = kInfinity;
    if (least == 0 || least + 1 == tried) continue;
    const double bend = (mean[least - 1] - 2 * mean[least] + mean[least + 1]) / (kStep_s * kStep_s);
    part.departure_s -= (mean[least + 1] - mean[least - 1]) / (2 * kStep_s * bend);
    part.sd_s = std::sqrt(2 / (bend * count[k][least]));
  }
  return parts;
}

// The pairing that tells most, and its search.
struct Best {
  Pairing pairing;
  OffsetSearch search;
  std::size_t at = 0;  // the most likely offset
};

Best FindBest(const Movement& a, const Movement& b) {
  std::optional<Best> best;
  for (Pairing& pairing : PairingsOf(a, b)) {
    OffsetSearch search = SearchOffsets(pairing);
    const auto at =
        static_cast<std::size_t>(std::ranges::max_element(search.log_likelihood) - search.log_likelihood.begin());
    if (!search.offset_s.empty() && (!best || search.log_likelihood[at] > best->search.log_likelihood[best->at]))
      best = Best{std::move(pairing), std::move(search), at};
  }
  if (!best || !(best->search.log_likelihood[best->at] > 0))
    throw Fail("{} and {}: at no offset do both show a common movement for long enough", a.file.string(),
               b.file.string());
  return std::move(*best);
}

// Another offset that is nearly as likely, as of steps that repeat.
void CheckIsOne(const Best& best, const std::string& both) {
  constexpr double kApart_s = 0.3, kLeastOdds = 5;
  const OffsetSearch& search = best.search;
  for (std::size_t i = 0; i < search.offset_s.size(); ++i)
    if (std::abs(search.offset_s[i] - search.offset_s[best.at]) > kApart_s &&
        search.log_likelihood[best.at] - search.log_likelihood[i] < kLeastOdds)
      throw Fail(
          "{}: cannot be aligned: offsets of {:.2f} and {:.2f} s are about as likely; record a movement that does not "
          "repeat itself, or give a signal that both have (--signal-a, --signal-b)",
          both, search.offset_s[best.at], search.offset_s[i]);
}

struct Refined {
  Warp warp;
  Fit fit = {};
  Eigen::Matrix2d covariance = {};
};

Refined Refine(const Pairing& pairing, double offset_s, double drift_sd) {
  Refined refined{.warp = {.offset_s = offset_s}, .fit = {}, .covariance = {}};
  refined.fit = FitMaps(pairing, refined.warp);
  refined.warp.from_s = (refined.fit.first_s + refined.fit.last_s) / 2;
  constexpr int kMostSteps = 12;
  constexpr double kLongest_s = 0.05, kMostDrift = 1e-3, kSettled_s = 1e-6;  // of one step
  for (int i = 0; i < kMostSteps && !refined.fit.evidence.empty(); ++i) {
    Eigen::Vector2d step = Solve(refined.fit, refined.warp, drift_sd).step;
    step /= std::max({1.0, std::abs(step[0]) / kLongest_s, std::abs(step[1]) / kMostDrift});
    refined.warp.offset_s += step[0];
    refined.warp.drift += step[1];
    refined.fit = FitMaps(pairing, refined.warp);
    if (std::abs(step[0]) < kSettled_s) break;
  }
  refined.covariance = Solve(refined.fit, refined.warp, drift_sd).covariance;
  return refined;
}

// Another movement that is alike fits best where a clock runs as none does.
void CheckDrift(double drift, double drift_sd, const std::string& both) {
  constexpr double kDeviations = 4;
  if (std::abs(drift) > kDeviations * drift_sd)
    throw Fail(
        "{}: cannot be aligned: their clocks would run {:+.0f} ppm apart, where {:.0f} ppm is one standard deviation; "
        "are these recordings of one movement? If a rate is that wrong, say so: --drift-sd",
        both, 1e6 * drift, 1e6 * drift_sd);
}

// Of one movement's parts each says nearly the same by itself; of two movements that are alike they do not.
void CheckPartsAgree(const std::vector<PartOffset>& parts, const std::string& both) {
  constexpr double kDeparture_s = 0.02, kDeviations = 4;
  constexpr std::size_t kMayDepart = 1;  // a short part may fit better elsewhere
  std::size_t departing = 0;
  std::string departures;
  for (const PartOffset& part : parts) {
    departures += fmt::format("{}{:+.3f}", departures.empty() ? "" : ", ", part.departure_s);
    if (std::isfinite(part.sd_s) && std::abs(part.departure_s) <= std::max(kDeparture_s, kDeviations * part.sd_s))
      continue;
    ++departing;
  }
  if (departing > kMayDepart)
    throw Fail(
        "{}: cannot be aligned: parts of the overlap contradict one another, by {} s from the best offset; are these "
        "recordings of one movement?",
        both, departures);
}

// What the models leave out of a time, 1 SD. Of ground forces: the markers' mean height is not the centre of mass
// (-4 ms on a person's plates whose clock is the markers'). Of a sensor: its strap and the skin (two people, halves of
// the recording: 1 to 3 ms). Of markers: nothing that repeats.
double ModelDeviation(const Movement& a, const Movement& b) {
  if (a.kind == MovementKind::kForces || b.kind == MovementKind::kForces) return 0.004;
  return a.kind == b.kind ? 0.0003 : 0.002;
}

Clock ClockOf(const Warp& warp, bool y_is_a, double from_s) {
  Clock clock{.from_s = from_s, .method = "motion"};
  const double a_s = y_is_a ? (from_s - warp.offset_s + warp.drift * warp.from_s) / (1 + warp.drift) : warp.At(from_s);
  clock.offset_s = a_s - from_s;
  clock.drift_ppm = 1e6 * (y_is_a ? 1 / (1 + warp.drift) - 1 : warp.drift);
  return clock;
}

Comparison Compare(const Pairing& pairing, const Refined& refined) {
  Comparison comparison{.name = pairing.parts.front().name};
  const Rows rows = RowsOf(pairing.parts.front(), refined.warp);
  const Evidence& evidence = refined.fit.evidence.front();
  const Eigen::VectorXd told = (rows.x * evidence.map.head(rows.x.cols())).array() + evidence.map[rows.x.cols()];
  for (Index i = 0; i < rows.Count(); ++i) {
    const double t = rows.time_s[static_cast<std::size_t>(i)];
    // A line ends where the next row is not the next time.
    if (i > 0 && rows.row[static_cast<std::size_t>(i)] != rows.row[static_cast<std::size_t>(i - 1)] + 1) {
      comparison.time_s.push_back(t);
      comparison.measured.push_back(kNaN);
      comparison.told.push_back(kNaN);
    }
    comparison.time_s.push_back(pairing.y_is_a ? t : refined.warp.At(t));
    comparison.measured.push_back(rows.y(i, evidence.column));
    comparison.told.push_back(told[i]);
  }
  return comparison;
}

std::string NamesOf(const Movement& a, const Movement& b) {
  return fmt::format("{} and {}", a.file.string(), b.file.string());
}

}  // namespace

Alignment AlignByMotion(const Movement& a, const Movement& b, const AlignOptions& options) {
  const std::string both = NamesOf(a, b);
  const Best best = FindBest(a, b);
  const Pairing& pairing = best.pairing;
  const double drift_sd = 1e-6 * options.drift_sd_ppm;
  const Refined refined = Refine(pairing, best.search.offset_s[best.at], drift_sd);
  if (refined.fit.evidence.empty() || !refined.covariance.allFinite() ||
      refined.fit.unexplained > pairing.most_unexplained)
    throw Fail(
        "{}: cannot be aligned: at the best offset {:.0f} % of the movement of one ({}) is not explained by that of "
        "the "
        "other, where {:.0f} % may be; are these recordings of one movement?",
        both, 100 * std::min(1.0, std::max(refined.fit.unexplained, best.search.unexplained[best.at])),
        pairing.parts.front().name, 100 * pairing.most_unexplained);
  CheckIsOne(best, both);
  CheckDrift(refined.warp.drift, drift_sd, both);
  Alignment alignment{.clock = ClockOf(refined.warp, pairing.y_is_a, b.time_s.front()),
                      .drift_sd_ppm = 1e6 * std::sqrt(refined.covariance(1, 1)),
                      .unexplained = refined.fit.unexplained,
                      .overlap_s = refined.fit.last_s - refined.fit.first_s,
                      .parts = OffsetsOfParts(pairing, refined.fit, refined.warp),
                      .offset_s = best.search.offset_s,
                      .log_likelihood = best.search.log_likelihood,
                      .comparison = Compare(pairing, refined)};
  CheckPartsAgree(alignment.parts, both);
  const double half_s = alignment.overlap_s / 2, covariance = std::abs(refined.covariance(0, 1));
  alignment.clock.sd_s = std::hypot(ModelDeviation(a, b), std::sqrt(refined.covariance(0, 0) + 2 * half_s * covariance +
                                                                    half_s * half_s * refined.covariance(1, 1)));
  for (PartOffset& part : alignment.parts)
    if (pairing.y_is_a)
      part.departure_s = -part.departure_s;
    else
      part.time_s = refined.warp.At(part.time_s);
  if (pairing.y_is_a)
    for (double& offset_s : alignment.offset_s) offset_s = -offset_s;
  return alignment;
}

}  // namespace lake::sync
