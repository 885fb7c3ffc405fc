// The light of a blob (lake/tracking/blob_fit.h) in the pixels round it, and sums over pixels for its fit. Pixels come
// in blocks of fixed size: nothing is allocated, all stays in the cache, and wide vectors take eight of them at once.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "lake/tracking/blob_fit.h"

namespace lake::tracking {

// Order of a blob's parameters in its fit; the streak's are the last, as it may be given.
enum BlobParameter { kX, kY, kM11, kM12, kM22, kEdge, kAmplitude, kBlurX, kBlurY, kBlobParameters };

inline constexpr std::size_t kBlock = 32;
struct alignas(32) Pixels {  // one value per pixel of a block; not set at first
  std::array<float, kBlock> at;
};

// A blob's light at unit amplitude, and its derivatives by x, y, m11, m12, m22, edge; by the streak's path, where
// that is asked for.
struct Light {
  Pixels value;
  std::array<Pixels, kAmplitude> gradient;
  std::array<Pixels, 2> by_blur;
};

// At pixels given relative to `origin`, px.
void ComputeLight(const Blob& blob, const Eigen::Vector2d& origin, const Pixels& x, const Pixels& y, bool by_blur,
                  Light& light);

// A sum over pixels, a part in each lane: single precision is enough for some hundred of them.
inline constexpr std::size_t kLanes = 8;
struct alignas(32) LaneSum {
  std::array<float, kLanes> lane;

  double Total() const { return std::accumulate(lane.begin(), lane.end(), 0.0); }
};

void AddSum(const Pixels& pixels, LaneSum& sum);

// Normal equations of residuals with their derivatives, one row for each parameter.
inline constexpr std::size_t kMostRows = 39;
class NormalSums {
 public:
  explicit NormalSums(std::size_t rows) { std::fill_n(sums_.begin(), rows * (rows + 3) / 2, LaneSum{}); }

  // Of a block's pixels: weight · row · residual, and weight · row · row.
  void Add(const Pixels& weight, const Pixels& residual, std::span<const Pixels> rows);

  // To the lower triangle of `normal`, and to `gradient`, of as many rows.
  template <typename Matrix, typename Vector>
  void AddTo(Matrix& normal, Vector& gradient) const {
    const LaneSum* sum = sums_.data();
    for (int p = 0; p < gradient.size(); ++p) {
      gradient[p] += (sum++)->Total();
      for (int q = 0; q <= p; ++q) normal(p, q) += (sum++)->Total();
    }
  }

 private:
  std::array<LaneSum, kMostRows*(kMostRows + 3) / 2> sums_;  // each row's with the residual, then with rows up to it
};

}  // namespace lake::tracking
