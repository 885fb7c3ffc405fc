#include "leg_normal.h"

#include <algorithm>
#include <cmath>

#include "lake/core/interrupt.h"

namespace lake::gait {
namespace {

constexpr std::size_t kKnotsPerPiece = 128;  // a piece's factor takes 270 kB, what is kept of it 8 kB

}  // namespace

LegNormal::LegNormal(const LegModel& model, const std::vector<double>& coefficients)
    : model_(model),
      coefficients_(coefficients),
      states_(static_cast<std::size_t>(model.states)),
      band_(4 * states_ - 1),
      rows_(0, band_) {
  const std::size_t knots = model.grid.count, count = std::max<std::size_t>(1, knots / kKnotsPerPiece);
  for (std::size_t p = 0; p < count; ++p)
    pieces_.push_back({p * kKnotsPerPiece, p + 1 == count ? knots : (p + 1) * kKnotsPerPiece, {}});
  // Before the first row, rows of the identity change nothing.
  std::vector<double>& first = pieces_.front().before;
  first.assign(band_ * (band_ + 1), 0.0);
  for (std::size_t row = 0; row < band_; ++row) first[row * (band_ + 1) + band_] = 1;
}

// The rows of the piece's own knots.
void LegNormal::Assemble(const Piece& piece) {
  rows_ = BandedMatrix(RowsOf(piece) + 2 * band_, band_);
  std::copy(piece.before.begin(), piece.before.end(), rows_.Data());
  const auto is_own = [&](std::size_t knot) { return knot >= piece.begin && knot < piece.end; };
  auto observation =
      std::partition_point(model_.observations.begin(), model_.observations.end(),
                           [&](const LegObservation& o) { return model_.At(o.frame).first + 4 <= piece.begin; });
  for (; observation != model_.observations.end(); ++observation) {
    const LegObservation& o = *observation;
    const SplineGrid::Place place = model_.At(o.frame);
    if (place.first >= piece.end) break;
    const LegResidual residual = EvaluateObservation(model_, o, coefficients_);
    const double weight = RobustWeight(model_, o, residual.value) / std::pow(model_.Scatter(o), 2);
    const StateMatrix square = weight * residual.by_state.transpose() * residual.by_state;
    for (std::size_t a = 0; a < 4; ++a) {
      if (!is_own(place.first + a)) continue;
      const std::size_t row = (place.first + a) * states_;
      for (std::size_t b = 0; b <= a; ++b)
        for (std::size_t i = 0; i < states_; ++i)
          for (std::size_t j = 0; j < (a == b ? i + 1 : states_); ++j)
            rows_.Lower(Local(piece, row + i), Local(piece, (place.first + b) * states_ + j)) +=
                place.value[a] * place.value[b] * square(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  for (std::size_t k = std::max<std::size_t>(piece.begin, 3) - 3; k < piece.end && k + 3 < model_.grid.count; ++k)
    for (const PriorTerm& term : PriorTerms(model_, k)) {
      const auto row_of = [&](std::size_t a) { return (k + a) * states_ + static_cast<std::size_t>(term.state); };
      for (std::size_t a = 0; a < 4; ++a) {
        if (!is_own(k + a)) continue;
        for (std::size_t b = 0; b <= a; ++b)
          rows_.Lower(Local(piece, row_of(a)), Local(piece, row_of(b))) += term.row[a] * term.row[b];
      }
    }
}

bool LegNormal::Factorize(const Piece& piece) {
  ThrowIfInterrupted();
  Assemble(piece);
  return FactorizeRows(rows_, band_, band_ + RowsOf(piece));
}

// Leaves the last piece's factor, and what each piece starts from.
bool LegNormal::GoForward() {
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    if (!Factorize(piece)) return false;
    if (p + 1 == pieces_.size()) break;
    const double* end = rows_.Data() + (band_ + RowsOf(piece)) * (band_ + 1);
    pieces_[p + 1].before.assign(end - band_ * (band_ + 1), end);
  }
  return true;
}

// Visits the pieces' factors from the last to the first; the rows after a piece's own are those that the visit of the
// one after it left.
bool LegNormal::GoBack(const std::function<void(const Piece&)>& visit) {
  visit(pieces_.back());
  for (std::size_t p = pieces_.size() - 1; p-- > 0;) {
    const Piece& piece = pieces_[p];
    const double* own = rows_.Data() + band_ * (band_ + 1);
    const std::vector<double> after(own, own + band_ * (band_ + 1));
    if (!Factorize(piece)) return false;
    std::copy(after.begin(), after.end(), rows_.Data() + (band_ + RowsOf(piece)) * (band_ + 1));
    visit(piece);
  }
  return true;
}

StateMatrix LegNormal::CovarianceAt(const Piece& piece, std::size_t first, const std::array<double, 4>& weights) const {
  StateMatrix result = StateMatrix::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b)
      for (std::size_t i = 0; i < states_; ++i)
        for (std::size_t j = 0; j < states_; ++j)
          result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) +=
              weights[a] * weights[b] *
              rows_.At(Local(piece, (first + a) * states_ + i), Local(piece, (first + b) * states_ + j));
  return result;
}

std::optional<LegCovariances> LegNormal::Covariances() {
  std::size_t frame = model_.time_s.size();
  LegCovariances covariances = {StateCovariances(frame), StateCovariances(frame)};
  const auto invert = [&](const Piece& piece) {
    SelectedInverseOfRows(rows_, band_, band_ + RowsOf(piece));
    for (; frame > 0; --frame) {
      const SplineGrid::Place place = model_.At(frame - 1);
      if (place.first < piece.begin) break;
      covariances.state.Set(frame - 1, CovarianceAt(piece, place.first, place.value));
      covariances.rate.Set(frame - 1, CovarianceAt(piece, place.first, place.slope));
    }
  };
  if (!GoForward() || !GoBack(invert)) return std::nullopt;
  return covariances;
}

}  // namespace lake::gait
