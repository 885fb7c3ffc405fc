#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "lake/core/error.h"
#include "lake/gait/banded_matrix.h"
#include "lake/gait/leg_view.h"
#include "lake/gait/smoothing_spline.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

TEST(BandedMatrix, SolvesAndInvertsLikeADenseMatrix) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const auto& [size, band] : {std::pair{1, 0}, {7, 2}, {40, 3}, {60, 31}, {5, 9}}) {
    const auto n = static_cast<std::size_t>(size), b = static_cast<std::size_t>(band);
    gait::BandedMatrix banded(n, b);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i > b ? i - b : 0; j <= i; ++j) {
        const double value = i == j ? 2.0 * static_cast<double>(b) + 2 + uniform(random) : uniform(random);
        banded.Lower(i, j) = value;
        dense(static_cast<int>(i), static_cast<int>(j)) = dense(static_cast<int>(j), static_cast<int>(i)) = value;
      }
    std::vector<double> x(n);
    for (double& v : x) v = uniform(random);
    const Eigen::VectorXd expected = dense.ldlt().solve(Eigen::Map<Eigen::VectorXd>(x.data(), size));
    ASSERT_TRUE(gait::Factorize(banded));
    gait::Solve(banded, x);
    EXPECT_LT((expected - Eigen::Map<Eigen::VectorXd>(x.data(), size)).norm(), 1e-12 * (1 + expected.norm()));
    const gait::BandedMatrix inverse = gait::SelectedInverse(banded);
    const Eigen::MatrixXd dense_inverse = dense.inverse();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i > b ? i - b : 0; j <= i; ++j)
        EXPECT_NEAR(inverse.At(i, j), dense_inverse(static_cast<int>(i), static_cast<int>(j)), 1e-13);
  }
}

// A factor made in two pieces, its inverse from the last to the first, with rows of the identity before the first row.
TEST(BandedMatrix, IsFactorisedAndInvertedInPieces) {
  constexpr std::size_t kSize = 60, kBand = 7, kSecond = kBand + 33;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  gait::BandedMatrix whole(kSize, kBand), pieces(kBand + kSize, kBand);
  for (std::size_t i = 0; i < kBand; ++i) pieces.Lower(i, i) = 1;
  for (std::size_t i = 0; i < kSize; ++i)
    for (std::size_t j = i > kBand ? i - kBand : 0; j <= i; ++j)
      whole.Lower(i, j) = pieces.Lower(kBand + i, kBand + j) =
          i == j ? 2 * kBand + 2 + uniform(random) : uniform(random);
  ASSERT_TRUE(gait::Factorize(whole));
  ASSERT_TRUE(gait::FactorizeRows(pieces, kBand, kSecond));
  ASSERT_TRUE(gait::FactorizeRows(pieces, kSecond, kBand + kSize));
  const auto expect_the_same = [&] {
    for (std::size_t i = 0; i < kSize; ++i)
      for (std::size_t j = i > kBand ? i - kBand : 0; j <= i; ++j)
        EXPECT_NEAR(pieces.Lower(kBand + i, kBand + j), whole.Lower(i, j), 1e-13) << i << ' ' << j;
  };
  expect_the_same();
  whole = gait::SelectedInverse(whole);
  gait::SelectedInverseOfRows(pieces, kSecond, kBand + kSize);
  gait::SelectedInverseOfRows(pieces, kBand, kSecond);
  expect_the_same();
}

TEST(BandedMatrix, RefusesWhatIsNotPositiveDefinite) {
  gait::BandedMatrix matrix(3, 1);
  for (std::size_t i = 0; i < 3; ++i) matrix.Lower(i, i) = i == 1 ? -1 : 1;
  gait::BandedMatrix rows = matrix;
  EXPECT_FALSE(gait::Factorize(matrix));
  EXPECT_TRUE(gait::FactorizeRows(rows, 1, 1));
  EXPECT_FALSE(gait::FactorizeRows(rows, 1, 3));
}

TEST(SplineGrid, ReproducesCubicsAndTheirSlopes) {
  const gait::SplineGrid grid = gait::MakeSplineGrid(std::vector<double>{0.5, 1.0, 2.5}, 0.25);
  // A B-spline's coefficients of t² are (centre² − step²/3).
  std::vector<double> coefficients;
  for (std::size_t k = 0; k < grid.count; ++k) {
    const double centre = grid.start_s + (static_cast<double>(k) - 1) * grid.step_s;
    coefficients.push_back(centre * centre - grid.step_s * grid.step_s / 3);
  }
  for (double t = 0.5; t <= 2.5; t += 0.07) {
    EXPECT_NEAR(gait::ValueAt(grid.At(t), coefficients), t * t, 1e-12);
    EXPECT_NEAR(gait::SlopeAt(grid.At(t), coefficients), 2 * t, 1e-11);
    EXPECT_NEAR(gait::CurveAt(grid.At(t), coefficients), 2, 1e-9);
  }
}

// Sine bursts between rests: the truth inside two standard deviations as often as it should be, and white noise
// averaged away.
TEST(SmoothingSpline, FindsItsSmoothnessAndSaysHowGoodItIs) {
  for (const double sigma : {0.01, 0.1}) {
    std::mt19937 random(static_cast<unsigned>(1000 * sigma));
    std::normal_distribution<double> noise(0, sigma);
    std::vector<double> time_s, truth, values, sigmas;
    for (int i = 0; i < 1200; ++i) {
      time_s.push_back(i / 60.0);
      const double phase = std::fmod(time_s.back(), 5.0);
      truth.push_back(phase < 2 ? MinimumJerk(phase / 2) : phase < 3 ? 1 : phase < 4 ? 1 - MinimumJerk(phase - 3) : 0);
      values.push_back(truth.back() + noise(random)), sigmas.push_back(sigma);
    }
    const gait::SplineGrid grid = gait::MakeSplineGrid(time_s, 1 / 60.0);
    const gait::SmoothSignal signal = gait::FitSmoothingSpline(grid, time_s, values, sigmas);
    EXPECT_TRUE(signal.converged);
    EXPECT_NEAR(signal.noise_scale, 1, 0.06);
    double squares = 0, normalized = 0;
    int covered = 0;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      const gait::SplineGrid::Place place = grid.At(time_s[i]);
      const double error = gait::ValueAt(place, signal.coefficients) - truth[i],
                   variance = gait::VarianceAt(place, signal.covariance);
      squares += error * error, normalized += error * error / variance, covered += error * error < 4 * variance;
    }
    const auto n = static_cast<double>(time_s.size());
    EXPECT_LT(std::sqrt(squares / n), 0.45 * sigma);
    EXPECT_NEAR(std::sqrt(normalized / n), 1, 0.25);
    EXPECT_GT(covered / n, 0.9);
  }
}

TEST(SmoothingSpline, ACutoffIsWhereTheGainIsHalfThePower) {
  std::vector<double> time_s, values, sigmas(1500, 0.1);
  for (const double frequency_hz : {2.0, 4.0, 8.0}) {
    time_s.clear(), values.clear();
    for (int i = 0; i < 1500; ++i) {
      time_s.push_back(i / 100.0);
      values.push_back(std::sin(2 * std::numbers::pi * frequency_hz * time_s.back()));
    }
    gait::SmoothingOptions options;
    options.cutoff_hz = 4;
    const gait::SplineGrid grid = gait::MakeSplineGrid(time_s, 0.01);
    gait::SmoothSignal signal = gait::FitSmoothingSpline(grid, time_s, values, sigmas, options);
    double product = 0, square = 0;
    for (std::size_t i = 300; i < 1200; ++i) {
      product += values[i] * gait::ValueAt(grid.At(time_s[i]), signal.coefficients);
      square += values[i] * values[i];
    }
    // The spline's gain is the continuous one's as long as the cutoff is far below the knots' rate.
    EXPECT_NEAR(product / square, 1 / (1 + (std::numbers::sqrt2 - 1) * std::pow(frequency_hz / 4, 6)), 0.01)
        << frequency_hz;
  }
}

TEST(SmoothingSpline, RefusesWhatItCannotDo) {
  const std::vector<double> time_s = {0, 1, 2, 3, 4}, sigmas(5, 1.0);
  const double nan = std::nan("");
  const gait::SplineGrid grid = gait::MakeSplineGrid(time_s, 1);
  EXPECT_THROW(gait::FitSmoothingSpline(grid, time_s, std::vector<double>{1, nan, nan, nan, 2}, sigmas), Error);
  EXPECT_THROW(gait::FitSmoothingSpline(grid, time_s, std::vector<double>(5, 1.0), std::vector<double>(5, 0.0)), Error);
  EXPECT_THROW(gait::MakeSplineGrid(std::vector<double>{0, 1e12}, 1e-3), Error);
}

TEST(SmoothingSpline, NamesTheGapThatItCannotBridge) {
  const auto message = [](double gap_s) {
    std::vector<double> time_s, values;
    for (int i = 0; i < 400; ++i) {
      time_s.push_back(i * 0.01 + (i < 100 ? 0 : gap_s));
      values.push_back(i < 200 ? 0 : 1 - std::cos(0.05 * (i - 200)));  // a rest, and a movement
    }
    try {
      gait::FitSmoothingSpline(gait::MakeSplineGrid(time_s, 0.01), time_s, values, std::vector<double>(400, 1e-3));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(message(150), testing::HasSubstr("0.01 s apart (median), with a gap of 150 s after 0.99 s"));
  EXPECT_THAT(message(500), testing::HasSubstr("the longest of 500 s after 0.99 s"));
}

TEST(LegView, ProjectionAndItsInverseAgree) {
  gait::LegView scaled_lens = CalibratedView();
  scaled_lens.camera_from_plane.reset(), scaled_lens.mm_per_px = 1.7;
  for (const gait::LegView& view : {ScaledView(), CalibratedView(), scaled_lens, gait::LegView{}}) {
    const bool calibrated = view.camera_from_plane.has_value();
    for (const double depth_mm : {0.0, calibrated ? 40.0 : 0.0})
      for (const Eigen::Vector2d& pixel :
           {Eigen::Vector2d(300, 200), Eigen::Vector2d(900, 600), Eigen::Vector2d(640, 360)}) {
        const Eigen::Vector2d point = gait::PlaneFromRecorded(view, pixel, depth_mm);
        EXPECT_LT((gait::RecordedFromPlane<double>(view, point, depth_mm) - pixel).norm(), 1e-8);
        const double scale = gait::PlaneUnitsPerRecorded(view, point, depth_mm);
        const Eigen::Vector2d beside = gait::PlaneFromRecorded(view, pixel + Eigen::Vector2d(0.5, 0.5), depth_mm);
        EXPECT_NEAR((beside - point).norm() / std::sqrt(0.5), scale, 0.1 * scale);
      }
  }
}

TEST(LegView, APlumbLineGivesTheVertical) {
  const Eigen::Vector2d up = gait::UpFromPlumbLine(gait::LegView{}, {100, 500}, {110, 100});
  EXPECT_NEAR(up.x(), 10 / std::hypot(10, 400), 1e-12);
  EXPECT_GT(up.y(), 0.9);
  EXPECT_LT((gait::UpFromPlumbLine(gait::LegView{}, {110, 100}, {100, 500}) - up).norm(), 1e-12);
  EXPECT_THROW(gait::UpFromPlumbLine(gait::LegView{}, {1, 1}, {1, 1}), Error);
}

}  // namespace
}  // namespace lake
