// The lag of one signal behind another: whether its error is as large as its standard deviation says.
#include "lake/sync/lag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "recorded_rises.h"

namespace lake {
namespace {

struct Recordings {
  double noise = 0, correlation = 0, duration_s = 0;
};

class LagOfTwoViews : public testing::TestWithParam<Recordings> {};

TEST_P(LagOfTwoViews, IsAsUncertainAsItSays) {
  const auto [noise, correlation, duration_s] = GetParam();
  constexpr unsigned kDraws = 60;
  Eigen::Matrix2d view;
  view << 0.7, 0.1, -0.05, -0.8;  // px, y down, seen from aside
  int count = 0, within = 0;
  double square = 0;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    const Rises rises(seed, duration_s + 4);
    const Camera a{.noise = noise, .correlation = correlation, .to_s = duration_s + 3},
        b{.rate_hz = seed % 2 ? 30.0 : 100.0,
          .noise = noise,
          .correlation = correlation,
          .view = view,
          .from_s = 2,
          .to_s = 2 + duration_s,
          .offset_s = 0.37 * seed - 9,
          .drift_ppm = 8.0 * seed - 240};
    const sync::Movement in_a = Record(rises, a, seed), in_b = Record(rises, b, seed + 100);
    const sync::Band band = sync::BandOf(in_a.time_s, in_b.time_s);
    const auto speeds = [&](const sync::Movement& movement) {
      return sync::Derivative(sync::Sample(movement.time_s, movement.values, band));
    };
    const sync::Lag lag = sync::FindLag(speeds(in_b), speeds(in_a), {.drift_sd = 300e-6});
    if (lag.refusal != sync::LagRefusal::kNone) continue;
    const double error_s = lag.offset_s - b.offset_s - 1e-6 * b.drift_ppm * lag.from_s,
                 sd_s = std::sqrt(lag.covariance(0, 0));
    EXPECT_LT(std::abs(error_s), 0.01) << seed;
    ++count, within += std::abs(error_s) < 1.96 * sd_s ? 1 : 0;
    square += std::pow(error_s / sd_s, 2);
  }
  EXPECT_GE(count, 0.9 * kDraws);
  EXPECT_GE(within, 0.9 * count) << "of " << count;
  EXPECT_LT(std::sqrt(square / count), 1.25) << "root mean square of error/SD";
  EXPECT_GT(std::sqrt(square / count), 0.4) << "root mean square of error/SD";
}

INSTANTIATE_TEST_SUITE_P(, LagOfTwoViews,
                         testing::Values(Recordings{0.3, 0, 30}, Recordings{2, 0.9, 15}, Recordings{2, 0.95, 8},
                                         Recordings{0.3, 0, 6}));

}  // namespace
}  // namespace lake
