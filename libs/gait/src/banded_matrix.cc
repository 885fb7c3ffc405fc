#include "lake/gait/banded_matrix.h"

#include <algorithm>
#include <cmath>

namespace lake {

bool Factorize(BandedMatrix& matrix) {
  const std::size_t n = matrix.Size(), band = matrix.HalfBandwidth();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = i > band ? i - band : 0;
    const double* row_i = &matrix.Lower(i, first);
    for (std::size_t j = first; j <= i; ++j) {
      const std::size_t from = std::max(first, j > band ? j - band : 0);
      const double* row_j = &matrix.Lower(j, from);
      const double* left = row_i + (from - first);
      double sum = matrix.Lower(i, j);
      for (std::size_t k = 0; k < j - from; ++k) sum -= left[k] * row_j[k];
      if (j < i) {
        matrix.Lower(i, j) = sum / matrix.Lower(j, j);
      } else {
        if (!(sum > 0) || !std::isfinite(sum)) return false;
        matrix.Lower(i, i) = std::sqrt(sum);
      }
    }
  }
  return true;
}

void Solve(const BandedMatrix& factor, std::span<double> x) {
  const std::size_t n = factor.Size(), band = factor.HalfBandwidth();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i > band ? i - band : 0; j < i; ++j) x[i] -= factor.Lower(i, j) * x[j];
    x[i] /= factor.Lower(i, i);
  }
  for (std::size_t i = n; i-- > 0;) {
    x[i] /= factor.Lower(i, i);
    for (std::size_t j = i > band ? i - band : 0; j < i; ++j) x[j] -= factor.Lower(i, j) * x[i];
  }
}

// Σ L = L⁻ᵀ, whose strict lower triangle is zero, read from the last column to the first:
//   Σ_ji = −(1/L_ii) Σ_k>i Σ_jk L_ki   (j > i),   Σ_ii = 1/L_ii² − (1/L_ii) Σ_k>i L_ki Σ_ki
BandedMatrix SelectedInverse(const BandedMatrix& factor) {
  const std::size_t n = factor.Size(), band = factor.HalfBandwidth();
  BandedMatrix inverse(n, band);
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
  return inverse;
}

}  // namespace lake
