// Symmetric positive definite banded systems: what least squares over B-splines in time come down to.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lake::gait {

// A symmetric matrix of which the lower triangle within `half_bandwidth` of the diagonal is kept, row by row: LAPACK's
// band storage of the upper triangle, column by column.
class BandedMatrix {
 public:
  BandedMatrix(std::size_t size, std::size_t half_bandwidth)
      : size_(size), band_(half_bandwidth), values_(size * (half_bandwidth + 1), 0.0) {}

  std::size_t Size() const { return size_; }
  std::size_t HalfBandwidth() const { return band_; }

  // Row ≥ column, and both within the band of each other.
  double& Lower(std::size_t row, std::size_t column) { return values_[row * band_ + column + band_]; }
  double Lower(std::size_t row, std::size_t column) const { return values_[row * band_ + column + band_]; }

  // Either triangle.
  double At(std::size_t row, std::size_t column) const {
    return row >= column ? Lower(row, column) : Lower(column, row);
  }

  double* Data() { return values_.data(); }
  const double* Data() const { return values_.data(); }

 private:
  std::size_t size_, band_;
  std::vector<double> values_;  // (row, column) at row · (band + 1) + column − (row − band)
};

// Replaces A by L of A = L Lᵀ (LAPACK's dpbtrf). Returns false if A is not positive definite or not finite.
[[nodiscard]] bool Factorize(BandedMatrix& matrix);

// Of a matrix that is factorised piece by piece: replaces the rows of A from `begin` to `end` by those of L, where the
// `band` rows before them are L's already. LAPACK's routine wants the whole matrix. begin ≥ half bandwidth.
[[nodiscard]] bool FactorizeRows(BandedMatrix& matrix, std::size_t begin, std::size_t end);

// Replaces b by x of L Lᵀ x = b.
void Solve(const BandedMatrix& factor, std::span<double> right_hand_side);

// The elements of (L Lᵀ)⁻¹ within the band, exactly, in size · bandwidth² operations (Takahashi, Fagan & Chin 1973).
// In the factor's own memory.
BandedMatrix SelectedInverse(BandedMatrix factor);

// The same of the columns from `begin` to `end`, where those of the inverse after them stand in their places already.
void SelectedInverseOfRows(BandedMatrix& factor, std::size_t begin, std::size_t end);

}  // namespace lake::gait
