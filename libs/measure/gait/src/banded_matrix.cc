#include "lake/gait/banded_matrix.h"

#include <lapacke.h>

#include <Eigen/Core>
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

// Row by row, by products of rows: L_ij = (A_ij − Σ_k<j L_ik L_jk) / L_jj.
bool FactorizeRows(BandedMatrix& matrix, std::size_t begin, std::size_t end) {
  const std::size_t band = matrix.HalfBandwidth();
  const auto product = [](const double* a, const double* b, std::size_t count) {
    using Part = Eigen::Map<const Eigen::VectorXd>;
    const auto n = static_cast<Eigen::Index>(count);
    return Part(a, n).dot(Part(b, n));
  };
  for (std::size_t i = begin; i < end; ++i) {
    double* row = &matrix.Lower(i, i - band);
    for (std::size_t k = 0; k < band; ++k) {
      const double* other = &matrix.Lower(i - band + k, i - band);
      row[k] = (row[k] - product(row, other, k)) / other[k];
    }
    const double square = row[band] - product(row, row, band);
    if (!(square > 0) || !std::isfinite(square)) return false;
    row[band] = std::sqrt(square);
  }
  return true;
}

void Solve(const BandedMatrix& factor, std::span<double> x) {
  const auto n = static_cast<lapack_int>(factor.Size()), band = static_cast<lapack_int>(factor.HalfBandwidth());
  LAPACKE_dpbtrs(LAPACK_COL_MAJOR, 'U', n, band, 1, factor.Data(), band + 1, x.data(), n);
}

// Σ L = L⁻ᵀ, whose strict lower triangle is zero, read from the last column to the first:
//   Σ_ji = −(1/L_ii) Σ_k>i Σ_jk L_ki   (j > i),   Σ_ii = 1/L_ii² − (1/L_ii) Σ_k>i L_ki Σ_ki
// A column of L is read before Σ's takes its place, and none of those before it is needed again.
void SelectedInverseOfRows(BandedMatrix& factor, std::size_t begin, std::size_t end) {
  const std::size_t band = factor.HalfBandwidth();
  BandedMatrix& inverse = factor;
  std::vector<double> column(band + 1), product(band + 1);
  for (std::size_t i = end; i-- > begin;) {
    const std::size_t below = std::min(band, factor.Size() - 1 - i);
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
}

BandedMatrix SelectedInverse(BandedMatrix factor) {
  SelectedInverseOfRows(factor, 0, factor.Size());
  return factor;
}

}  // namespace lake::gait
