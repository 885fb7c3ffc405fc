// The Gauss–Newton matrix of the leg's fit, inverted with one piece of the time in memory at a time. The whole matrix
// takes 2 kB per knot within its band. Of each piece only the few rows of the factor are kept that the next one starts
// from; on the way back the pieces are assembled and factorised a second time. Not part of the interface.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "leg_problem.h"

namespace lake::gait {

class LegNormal {
 public:
  LegNormal(const LegModel& model, const std::vector<double>& coefficients);  // linearised there

  // Those of the state and of its rate in each frame, by A⁻¹; nullopt if A is not positive definite.
  std::optional<LegCovariances> Covariances();

 private:
  struct Piece {
    std::size_t begin, end;      // knots
    std::vector<double> before;  // the factor's rows before its own
  };
  std::size_t RowsOf(const Piece& piece) const { return (piece.end - piece.begin) * states_; }
  std::size_t Local(const Piece& piece, std::size_t row) const { return row + band_ - piece.begin * states_; }
  void Assemble(const Piece& piece);
  bool Factorize(const Piece& piece);
  bool GoForward();
  bool GoBack(const std::function<void(const Piece&)>& visit);
  StateMatrix CovarianceAt(const Piece& piece, std::size_t first, const std::array<double, 4>& weights) const;

  const LegModel& model_;
  const std::vector<double>& coefficients_;
  std::size_t states_, band_;
  std::vector<Piece> pieces_;
  BandedMatrix rows_;  // of the piece at work: `band_` rows before its own, its own, `band_` rows after them
};

}  // namespace lake::gait
