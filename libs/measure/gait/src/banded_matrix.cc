#include "lake/gait/banded_matrix.h"

#include <lapacke.h>

#include <algorithm>
#include <cmath>

namespace lake::gait {

bool Factorize(BandedMatrix& matrix) {
  const auto n = static_cast<lapack_int>(matrix.Size()), band = static_cast<lapack_int>(matrix.HalfBandwidth());
  if (LAPACKE_dpbtrf(LAPACK_COL_MAJOR, 'U', n, band, matrix.Data(), band + 1) != 0) return false;
  for (std::size_t i = 0; i < matrix.Size(); ++i)
    if (!std::isfinite(matrix.Lower(i, i))) return false;
  return true;
}

void Solve(const BandedMatrix& factor, std::span<double> x) {
  const auto n = static_cast<lapack_int>(factor.Size()), band = static_cast<lapack_int>(factor.HalfBandwidth());
  LAPACKE_dpbtrs(LAPACK_COL_MAJOR, 'U', n, band, 1, factor.Data(), band + 1, x.data(), n);
}

// Σ L = L⁻ᵀ, whose strict lower triangle is zero, read from the last column to the first:
//   Σ_ji = −(1/L_ii) Σ_k>i Σ_jk L_ki   (j > i),   Σ_ii = 1/L_ii² − (1/L_ii) Σ_k>i L_ki Σ_ki
// A column of L is read before Σ's takes its place, and none of those before it is needed again.
BandedMatrix SelectedInverse(BandedMatrix factor) {
  const std::size_t n = factor.Size(), band = factor.HalfBandwidth();
  BandedMatrix& inverse = factor;
  std::vector<double> column(band + 1), product(band + 1);
  for (std::size_t i = n; i-- > 0;) {
    const std::size_t below = std::min(band, n - 1 - i);
    const double diagonal = factor.Lower(i, i);
    for (std::size_t k = 0; k < below; ++k) column[k] = factor.Lower(i + 1 + k, i), product[k] = 0;
    for (std::size_t j = 0; j < below; ++j) {
      const double* row = &inverse.Lower(i + 1 + j, i + 1);
      double sum = row[j] * column[j];
      for (std::size_t k = 0; k < j; ++k) {
        sum += row[k] * column[k];
        product[k] += row[k] * column[j];
      }
      product[j] += sum;
    }
    double sum = 0;
    for (std::size_t j = 0; j < below; ++j) {
      inverse.Lower(i + 1 + j, i) = -product[j] / diagonal;
      sum += column[j] * inverse.Lower(i + 1 + j, i);
    }
    inverse.Lower(i, i) = 1 / (diagonal * diagonal) - sum / diagonal;
  }
  return factor;
}

}  // namespace lake::gait
