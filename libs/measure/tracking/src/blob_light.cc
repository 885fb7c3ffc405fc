#include "blob_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "lake/core/wide_vectors.h"

namespace lake::tracking {
namespace {

// A blob at one moment of the exposure, in single precision.
struct StillBlob {
  float x, y, m11, m12, m22, edge;
};

// The edge's profile is the integrated triweight kernel of the same standard deviation: within 2 % of the normal
// distribution function, and a polynomial, so that whole vectors of pixels are evaluated at once.
LAKE_WIDE_VECTORS void ComputeStillLight(const StillBlob& blob, const Pixels& x, const Pixels& y, float weight,
                                         Light& __restrict light) {
  constexpr float kReach = 3;  // of the triweight kernel in its standard deviations
  constexpr float kPeak = 35.F / 32, kTiny = 1e-6F;
  const auto [x0, y0, m11, m12, m22, edge] = blob;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float u = x.at[i] - x0, v = y.at[i] - y0;
    const float mx = m11 * u + m12 * v, my = m12 * u + m22 * v;
    const float rho = std::max(std::sqrt(mx * mx + my * my), kTiny);
    const float per_rho = 1 / rho;
    const float slope_x = (m11 * mx + m12 * my) * per_rho, slope_y = (m12 * mx + m22 * my) * per_rho;  // of |M u|
    const float slope = std::max(std::sqrt(slope_x * slope_x + slope_y * slope_y), kTiny);
    const float per_width = 1 / (kReach * edge * slope);
    const float t = std::min(std::max((1 - rho) * per_width, -1.F), 1.F);
    const float t2 = t * t;
    light.value.at[i] = weight * (0.5F + kPeak * t * (1 + t2 * (-1 + t2 * (0.6F - t2 / 7))));
    const float by_t = weight * kPeak * ((1 - t2) * (1 - t2) * (1 - t2));
    const float by_rho = -by_t * per_width;  // exact on the edge, where the light changes
    const float by_m = by_rho * per_rho;
    light.gradient[kX].at[i] = -by_rho * slope_x;
    light.gradient[kY].at[i] = -by_rho * slope_y;
    light.gradient[kM11].at[i] = by_m * mx * u;
    light.gradient[kM12].at[i] = by_m * (mx * v + my * u);
    light.gradient[kM22].at[i] = by_m * my * v;
    light.gradient[kEdge].at[i] = -by_t * t / edge;
  }
}

// A path that is longer moves what is at this part of it, from −1/2 to 1/2.
LAKE_WIDE_VECTORS void ComputeByBlur(float part, Light& __restrict light) {
  for (std::size_t axis = 0; axis < light.by_blur.size(); ++axis)
    for (std::size_t i = 0; i < kBlock; ++i) light.by_blur[axis].at[i] = part * light.gradient[kX + axis].at[i];
}

LAKE_WIDE_VECTORS void Add(const Light& more, bool by_blur, Light& __restrict light) {
  for (std::size_t i = 0; i < kBlock; ++i) light.value.at[i] += more.value.at[i];
  for (std::size_t p = 0; p < kAmplitude; ++p)
    for (std::size_t i = 0; i < kBlock; ++i) light.gradient[p].at[i] += more.gradient[p].at[i];
  for (std::size_t axis = 0; axis < light.by_blur.size() && by_blur; ++axis)
    for (std::size_t i = 0; i < kBlock; ++i) light.by_blur[axis].at[i] += more.by_blur[axis].at[i];
}

// Exposure: the midpoint rule; nodes 1.5 edge widths apart leave ripples of 2e-4 of the light.
int ExposureNodes(const Blob& blob) {
  constexpr int kMaxNodes = 24;
  return std::clamp(static_cast<int>(std::ceil(blob.blur_px.norm() / (1.5 * blob.edge_px))), 1, kMaxNodes);
}

inline void AddProducts(const Pixels& a, const Pixels& b, LaneSum& sum) {
  static_assert(kBlock == 4 * kLanes);
  for (std::size_t l = 0; l < kLanes; ++l) {
    const auto product = [&](std::size_t quarter) { return a.at[quarter * kLanes + l] * b.at[quarter * kLanes + l]; };
    sum.lane[l] += (product(0) + product(1)) + (product(2) + product(3));
  }
}

LAKE_WIDE_VECTORS void AddNormal(const Pixels& weight, const Pixels& residual, const Pixels* rows, std::size_t count,
                                 LaneSum* __restrict sum) {
  for (std::size_t p = 0; p < count; ++p) {
    Pixels weighted;
    for (std::size_t i = 0; i < kBlock; ++i) weighted.at[i] = weight.at[i] * rows[p].at[i];
    AddProducts(weighted, residual, *sum++);
    for (std::size_t q = 0; q <= p; ++q) AddProducts(weighted, rows[q], *sum++);
  }
}

}  // namespace

void ComputeLight(const Blob& blob, const Eigen::Vector2d& origin, const Pixels& x, const Pixels& y, bool by_blur,
                  Light& light) {
  const Eigen::Matrix2f m = blob.unit_circle_from_px.cast<float>();
  const int nodes = ExposureNodes(blob);
  const auto at_node = [&](int i, Light& part) {
    const double along = (i + 0.5) / nodes - 0.5;
    const Eigen::Vector2f center = (blob.center - origin + along * blob.blur_px).cast<float>();
    ComputeStillLight({center.x(), center.y(), m(0, 0), m(0, 1), m(1, 1), static_cast<float>(blob.edge_px)}, x, y,
                      1.F / static_cast<float>(nodes), part);
    if (by_blur) ComputeByBlur(static_cast<float>(along), part);
  };
  at_node(0, light);
  for (int i = 1; i < nodes; ++i) {
    Light part;
    at_node(i, part);
    Add(part, by_blur, light);
  }
}

LAKE_WIDE_VECTORS void AddSum(const Pixels& pixels, LaneSum& sum) {
  for (std::size_t l = 0; l < kLanes; ++l)
    sum.lane[l] += (pixels.at[l] + pixels.at[kLanes + l]) + (pixels.at[2 * kLanes + l] + pixels.at[3 * kLanes + l]);
}

void NormalSums::Add(const Pixels& weight, const Pixels& residual, std::span<const Pixels> rows) {
  assert(rows.size() <= kMostRows);
  AddNormal(weight, residual, rows.data(), rows.size(), sums_.data());
}

}  // namespace lake::tracking
