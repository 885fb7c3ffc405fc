#include "offsets.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

namespace lake::sync {
namespace {

using Eigen::Index;
using Spectrum = std::vector<std::complex<double>>;

// Sums over all places at once: Σ u(i) v(i + k) for every k, through their spectra.
class Correlator {
 public:
  explicit Correlator(Index size) {
    while (size_ < size) size_ *= 2;
  }
  Index Size() const { return size_; }
  Spectrum Transform(const Eigen::VectorXd& values) {
    std::vector<double> padded(static_cast<std::size_t>(size_), 0);
    std::copy(values.begin(), values.end(), padded.begin());
    Spectrum spectrum;
    fft_.fwd(spectrum, padded);
    return spectrum;
  }
  std::vector<double> Correlate(const Spectrum& u, const Spectrum& v) {
    Spectrum product(u.size());
    for (std::size_t i = 0; i < u.size(); ++i) product[i] = std::conj(u[i]) * v[i];
    std::vector<double> sums;
    fft_.inv(sums, product);
    return sums;
  }

 private:
  Index size_ = 1;
  Eigen::FFT<double> fft_;
};

// The sums of squares of y about its mean and about what x tells of it, at every shift.
struct Squares {
  std::vector<double> all, told;
  std::vector<double> count;  // of times at which both are known
  std::vector<double> x_all;  // of x, the same
  double y_whole = 0, x_whole = 0;
};

Eigen::VectorXd Mask(const Series& series) {
  Eigen::VectorXd mask(series.Rows());
  for (Index i = 0; i < series.Rows(); ++i) mask[i] = series.known[static_cast<std::size_t>(i)] ? 1 : 0;
  return mask;
}

Squares SquaresOf(const Part& part, Correlator& correlator) {
  const Index p = part.x.value.cols(), q = part.y.value.cols();
  const Eigen::VectorXd y_mask = Mask(part.y), x_mask = Mask(part.x);
  const Eigen::MatrixXd y = y_mask.asDiagonal() * part.y.value, x = x_mask.asDiagonal() * part.x.value;
  const Spectrum y_seen = correlator.Transform(y_mask), x_seen = correlator.Transform(x_mask);
  Squares squares;
  squares.count = correlator.Correlate(y_seen, x_seen);
  std::vector<std::vector<double>> sx, sxx, sy, syy, sxy;
  std::vector<Spectrum> x_spectra;
  for (Index i = 0; i < p; ++i) {
    x_spectra.push_back(correlator.Transform(x.col(i)));
    sx.push_back(correlator.Correlate(y_seen, x_spectra.back()));
    for (Index j = 0; j <= i; ++j)
      sxx.push_back(correlator.Correlate(y_seen, correlator.Transform(x.col(i).cwiseProduct(x.col(j)))));
  }
  for (Index j = 0; j < q; ++j) {
    const Spectrum spectrum = correlator.Transform(y.col(j));
    sy.push_back(correlator.Correlate(spectrum, x_seen));
    syy.push_back(correlator.Correlate(correlator.Transform(y.col(j).cwiseAbs2()), x_seen));
    for (Index i = 0; i < p; ++i) sxy.push_back(correlator.Correlate(spectrum, x_spectra[static_cast<std::size_t>(i)]));
  }
  squares.y_whole = y.squaredNorm();
  squares.x_whole = x.squaredNorm();
  const std::size_t shifts = squares.count.size();
  squares.all.assign(shifts, 0);
  squares.told.assign(shifts, 0);
  squares.x_all.assign(shifts, 0);
  for (std::size_t k = 0; k < shifts; ++k) {
    const double n = squares.count[k];
    if (n < static_cast<double>(p) + 3) continue;
    Eigen::MatrixXd xx(p, p), xy(p, q);
    for (Index i = 0; i < p; ++i)
      for (Index j = 0; j <= i; ++j)
        xx(i, j) = xx(j, i) = sxx[static_cast<std::size_t>(i * (i + 1) / 2 + j)][k] -
                              sx[static_cast<std::size_t>(i)][k] * sx[static_cast<std::size_t>(j)][k] / n;
    squares.x_all[k] = xx.trace();
    for (Index j = 0; j < q; ++j) {
      const auto at = static_cast<std::size_t>(j);
      squares.all[k] += syy[at][k] - sy[at][k] * sy[at][k] / n;
      for (Index i = 0; i < p; ++i)
        xy(i, j) = sxy[static_cast<std::size_t>(j * p + i)][k] - sx[static_cast<std::size_t>(i)][k] * sy[at][k] / n;
    }
    xx.diagonal() *= 1 + 1e-6;
    squares.told[k] = xy.cwiseProduct(xx.ldlt().solve(xy)).sum();
  }
  return squares;
}

}  // namespace

OffsetSearch SearchOffsets(const Pairing& pairing) {
  const Part& first = pairing.parts.front();
  const double step_s = first.y.step_s;
  const auto stride = static_cast<Index>(std::lround(step_s / first.x.step_s));
  const Series x_times = Thinned(first.x, stride);
  const Index y_rows = first.y.Rows(), x_rows = x_times.Rows();
  Correlator correlator(y_rows + x_rows);
  std::vector<Squares> parts;
  for (const Part& part : pairing.parts)
    parts.push_back(SquaresOf({part.name, part.y, Thinned(part.x, stride)}, correlator));
  OffsetSearch search;
  // A movement below 2 Hz has 4 independent values in a second.
  constexpr double kIndependentRate_hz = 4, kLeastShare = 0.2, kLeastOverlap_s = 2;
  for (Index shift = -y_rows + 1; shift < x_rows; ++shift) {
    const auto k = static_cast<std::size_t>(shift < 0 ? shift + correlator.Size() : shift);
    double all = 0, told = 0, x_all = 0, y_whole = 0, x_whole = 0, overlap_s = 0;
    for (const Squares& s : parts) {
      all += s.all[k];
      told += s.told[k];
      x_all += s.x_all[k];
      y_whole += s.y_whole;
      x_whole += s.x_whole;
      overlap_s = std::max(overlap_s, s.count[k] * step_s);
    }
    const bool has_share = all >= kLeastShare * y_whole || x_all >= kLeastShare * x_whole;
    const bool is_enough = has_share && overlap_s >= kLeastOverlap_s && all > 0;
    const double unexplained = is_enough ? std::clamp(1 - told / all, 1e-6, 1.0) : 1;
    search.offset_s.push_back(x_times.start_s - first.y.start_s + static_cast<double>(shift) * step_s);
    search.unexplained.push_back(unexplained);
    search.log_likelihood.push_back(-kIndependentRate_hz * overlap_s / 2 * std::log(unexplained));
  }
  return search;
}

}  // namespace lake::sync
