#include "lake/dynamics/path_smoother.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

namespace lake::dynamics {
namespace {

constexpr MotionPrior kPersonPrior = {.speed = 1000, .acceleration = 10000, .reach = 500};

// x and y at uneven times with a gap.
SeenPath UnevenPath(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  std::normal_distribution<double> normal;
  SeenPath seen{2, {}, {}, {}};
  double t = 3;
  for (int i = 0; i < 24; ++i, t += 0.02 * uniform(random)) {
    seen.time_s.push_back(t);
    seen.place.emplace_back(100 * std::sin(4 * t) + normal(random), 80 * t + normal(random), 0);
    seen.sigma.push_back(i > 9 && i < 14 ? NAN : uniform(random));
  }
  return seen;
}

PathModel UnevenModel(const SeenPath& seen) {
  PathModel model{std::vector(seen.time_s.size(), 2e6), 0.8, 0, 0.5, 0.05};
  for (std::size_t i = 13; i < seen.time_s.size(); ++i) model.density[i] = 3e7;
  model.memory_length = 20;
  for (std::size_t i = 0; i < seen.time_s.size(); ++i)
    model.speed2.push_back(std::pow(40.0 * static_cast<double>(i % 7), 2));
  return model;
}

// The path's and the lasting noise's joint Gaussian as one dense matrix: states of all frames, of one axis.
struct Dense {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

Dense PriorOf(const SeenPath& seen, const PathModel& model, double first_place) {
  const auto n = static_cast<Eigen::Index>(seen.time_s.size());
  Dense dense{Eigen::VectorXd::Zero(4 * n), Eigen::MatrixXd::Zero(4 * n, 4 * n)};
  Eigen::Vector4d mean(first_place, 0, 0, 0);
  Eigen::Matrix4d covariance = Eigen::Vector4d(500 * 500, 1e6, 1e8, model.lasting).asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i > 0) {
      const double h = seen.time_s[static_cast<std::size_t>(i)] - seen.time_s[static_cast<std::size_t>(i) - 1],
                   kept = model.Kept(static_cast<std::size_t>(i), h), q = model.density[static_cast<std::size_t>(i)];
      Eigen::Matrix4d by, added;
      by << 1, h, h * h / 2, 0, 0, 1, h, 0, 0, 0, 1, 0, 0, 0, 0, kept;
      added << std::pow(h, 5) / 20, std::pow(h, 4) / 8, std::pow(h, 3) / 6, 0, std::pow(h, 4) / 8, std::pow(h, 3) / 3,
          h * h / 2, 0, std::pow(h, 3) / 6, h * h / 2, h, 0, 0, 0, 0, 0;
      added *= q;
      added(3, 3) = model.lasting * (1 - kept * kept);
      const Eigen::MatrixXd cross = by * dense.covariance.block(4 * (i - 1), 0, 4, 4 * i);
      dense.covariance.block(4 * i, 0, 4, 4 * i) = cross;
      dense.covariance.block(0, 4 * i, 4 * i, 4) = cross.transpose();
      mean = by * mean;
      covariance = by * covariance * by.transpose() + added;
    }
    dense.mean.segment<4>(4 * i) = mean;
    dense.covariance.block<4, 4>(4 * i, 4 * i) = covariance;
  }
  return dense;
}

// Conditioned on the measurements of one axis, without those of one frame if that is given.
Dense Conditioned(const SeenPath& seen, const PathModel& model, int axis, std::size_t without = 1000) {
  const Dense prior = PriorOf(seen, model, seen.place.front()[axis]);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < seen.time_s.size(); ++i)
    if (seen.IsSeen(i) && i != without) frames.push_back(i);
  const auto m = static_cast<Eigen::Index>(frames.size());
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(m, prior.mean.size());
  Eigen::VectorXd value(m), noise(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const std::size_t i = frames[static_cast<std::size_t>(k)];
    h(k, 4 * static_cast<Eigen::Index>(i)) = 1;
    h(k, 4 * static_cast<Eigen::Index>(i) + 3) = seen.sigma[i];
    value[k] = seen.place[i][axis];
    noise[k] = (model.white + model.jitter) * seen.sigma[i] * seen.sigma[i];
  }
  const Eigen::MatrixXd s = h * prior.covariance * h.transpose() + Eigen::MatrixXd(noise.asDiagonal());
  const Eigen::MatrixXd gain = s.llt().solve(h * prior.covariance).transpose();
  return {prior.mean + gain * (value - h * prior.mean), prior.covariance - gain * h * prior.covariance};
}

TEST(PathSmoother, IsTheDenseGaussianGivenTheMeasurements) {
  const SeenPath seen = UnevenPath(1);
  const PathModel model = UnevenModel(seen);
  const SmoothedPath path = SmoothPath(seen, model, kPersonPrior);
  for (int axis = 0; axis < 2; ++axis) {
    const Dense dense = Conditioned(seen, model, axis);
    for (std::size_t i = 0; i < seen.time_s.size(); ++i) {
      const auto at = 4 * static_cast<Eigen::Index>(i);
      EXPECT_NEAR(path.point[i].position[axis], dense.mean[at], 1e-5);
      EXPECT_NEAR(path.point[i].velocity[axis], dense.mean[at + 1], 1e-3);
      EXPECT_NEAR(path.point[i].position_covariance(axis, axis) / dense.covariance(at, at), 1, 1e-5);
      EXPECT_NEAR(path.point[i].velocity_variance / dense.covariance(at + 1, at + 1), 1, 1e-5);
    }
  }
}

// Jitter is part of the place, lasting noise is not: what all other frames say, and then this frame's measurement.
TEST(PathSmoother, APlaceWithJitterIsTheDenseGaussianToo) {
  const SeenPath seen = UnevenPath(4);
  PathModel model = UnevenModel(seen);
  model.jitter = 3;
  const SmoothedPath path = SmoothPath(seen, model, kPersonPrior);
  for (const std::size_t i : {3u, 9u, 15u, 20u}) {
    const Dense others = Conditioned(seen, model, 1, i);
    const auto at = 4 * static_cast<Eigen::Index>(i);
    const double sigma = seen.sigma[i], with_lasting = sigma * others.covariance(at, at + 3),
                 variance = others.covariance(at, at) + model.jitter * sigma * sigma,
                 seen_variance =
                     variance + 2 * with_lasting + sigma * sigma * (others.covariance(at + 3, at + 3) + model.white),
                 gain = (variance + with_lasting) / seen_variance;
    EXPECT_NEAR(path.point[i].position.y(),
                others.mean[at] + gain * (seen.place[i].y() - others.mean[at] - sigma * others.mean[at + 3]), 1e-4);
    EXPECT_NEAR(path.point[i].position_covariance(1, 1) / (variance - gain * (variance + with_lasting)), 1, 1e-4);
  }
}

TEST(PathSmoother, ASurpriseIsTheDifferenceFromWhatAllOthersPredict) {
  const SeenPath seen = UnevenPath(2);
  const PathModel model = UnevenModel(seen);
  const SmoothedPath path = SmoothPath(seen, model, kPersonPrior);
  for (const std::size_t i : {3u, 9u, 15u, 20u}) {
    const Dense others = Conditioned(seen, model, 1, i);
    const auto at = 4 * static_cast<Eigen::Index>(i);
    const double sigma = seen.sigma[i],
                 variance = others.covariance(at, at) + 2 * sigma * others.covariance(at, at + 3) +
                            sigma * sigma * others.covariance(at + 3, at + 3) + model.white * sigma * sigma;
    EXPECT_NEAR(path.surprise[i].y(), seen.place[i].y() - others.mean[at] - sigma * others.mean[at + 3], 1e-4);
    EXPECT_NEAR(path.surprise_variance[i] / variance, 1, 1e-4);
  }
}

// Without distances a bridge is the smoother; a known distance to a known point puts a hidden marker on its circle.
TEST(PathSmoother, ABridgeKeepsItsDistance) {
  const SeenPath seen = UnevenPath(3);
  const PathModel model = UnevenModel(seen);
  const SmoothedPath free = SmoothPath(seen, model, kPersonPrior);
  const std::size_t n = seen.time_s.size();
  std::vector<PathPoint> near = free.point;
  const SmoothedPath same = BridgePath(seen, model, kPersonPrior, {}, near, 0, n);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_LT((same.point[i].position - free.point[i].position).norm(), 1e-4);
    EXPECT_NEAR(same.point[i].position_covariance(0, 0) / free.point[i].position_covariance(0, 0), 1, 1e-4);
  }
  DistancePrior distance{std::vector<Eigen::Vector3d>(n, Eigen::Vector3d(0, -200, 0)),
                         std::vector<Eigen::Matrix3d>(n, Eigen::Matrix3d::Zero()),
                         std::vector<double>(n, 0.0),
                         std::vector<double>(n, 0.01),
                         410,
                         0.1,
                         0.3};
  for (int iteration = 0; iteration < 5; ++iteration) {
    const SmoothedPath path = BridgePath(seen, model, kPersonPrior, {&distance, 1}, near, 0, n);
    for (std::size_t i = 0; i < n; ++i) near[i] = path.point[i];
  }
  for (std::size_t i = 10; i < 14; ++i) EXPECT_NEAR((near[i].position - distance.other[i]).norm(), 410, 0.3) << i;
}

TEST(PathSmoother, ACutoffIsWhereTheGainIsHalfThePower) {
  constexpr double kCutoffHz = 4, kSigma = 0.01;
  for (const double frequency_hz : {2.0, 4.0, 8.0}) {
    SeenPath seen{1, {}, {}, std::vector(1500, kSigma)};
    for (int i = 0; i < 1500; ++i) {
      seen.time_s.push_back(i / 100.0);
      seen.place.emplace_back(std::sin(2 * std::numbers::pi * frequency_hz * seen.time_s.back()), 0, 0);
    }
    const PathModel model{std::vector(1500, DensityOfCutoff(kCutoffHz, kSigma, 0.01))};
    EXPECT_NEAR(CutoffOfDensity(model.density[5], kSigma, 0.01), kCutoffHz, 1e-9);
    const SmoothedPath path = SmoothPath(seen, model, kPersonPrior);
    double product = 0, square = 0;
    for (std::size_t i = 300; i < 1200; ++i) {
      product += seen.place[i].x() * path.point[i].position.x();
      square += seen.place[i].x() * seen.place[i].x();
    }
    EXPECT_NEAR(product / square, 1 / (1 + (std::numbers::sqrt2 - 1) * std::pow(frequency_hz / kCutoffHz, 6)), 0.01)
        << frequency_hz;
  }
}

// Paths that the model itself draws, with white noise and with noise that lasts.
class LearnPathsTest : public testing::TestWithParam<double> {};

TEST_P(LearnPathsTest, FindsWhatThePathsWereDrawnFrom) {
  constexpr double kDensity = 1e7, kRate_hz = 100, kWhite_mm = 0.5;
  const double lasting_mm = GetParam(), kept = std::exp(-0.01 / 0.12);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<SeenPath> paths;
  std::vector<std::vector<Eigen::Vector3d>> truth;
  for (int marker = 0; marker < 3; ++marker) {
    SeenPath& seen = paths.emplace_back(SeenPath{2, {}, {}, std::vector(1500, kWhite_mm)});
    truth.emplace_back();
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), v = x, a = x, lasting = x;
    const auto draw = [&] { return Eigen::Vector3d(normal(random), normal(random), 0); };
    lasting = lasting_mm * draw();
    for (int i = 0; i < 1500; ++i) {
      const double h = 1 / kRate_hz;
      seen.time_s.push_back(i * h);
      truth.back().push_back(x);
      seen.place.push_back(x + kWhite_mm * draw() + lasting);
      x += h * v + h * h / 2 * a;
      v += h * a - 0.5 * h * v;  // and it does not run away
      a += std::sqrt(kDensity * h) * draw() - 2 * h * a - 1.5 * h * v;
      lasting = kept * lasting + std::sqrt(1 - kept * kept) * lasting_mm * draw();
    }
  }
  const std::vector<PathModel> models = LearnPaths(paths, kPersonPrior, {});
  EXPECT_NEAR(models[0].white, 1, 0.15);
  EXPECT_NEAR(std::sqrt(models[0].lasting) * kWhite_mm, lasting_mm, lasting_mm > 0 ? 0.25 * lasting_mm : 0.25);
  double square = 0, count = 0;
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const SmoothedPath path = SmoothPath(paths[p], models[p], kPersonPrior);
    for (std::size_t i = 0; i < truth[p].size(); ++i, ++count)
      square += (path.point[i].position - truth[p][i]).squaredNorm() / 2 / path.point[i].position_covariance(0, 0);
  }
  EXPECT_NEAR(std::sqrt(square / count), 1, 0.2);
}

INSTANTIATE_TEST_SUITE_P(, LearnPathsTest, testing::Values(0.0, 1.0, 2.0));

// The error of a marker's place in its pixels, as a detector makes it: alike while the marker rests, other ones a pixel
// further.
TEST(LearnPaths, ErrorsOfThePixelsAreAveragedWhereTheMarkerMoves) {
  constexpr double kRate_hz = 240, kError_px = 0.05;
  SeenPath seen = UnseenPath(2, {});
  std::vector<Eigen::Vector2d> truth;
  for (int i = 0; i < 1500; ++i) {
    const double t = i / kRate_hz, moved = std::clamp(t - 2, 0.0, 2.0) / 2;
    const double path_px = 200 * (moved * moved * moved * (10 - 15 * moved + 6 * moved * moved));
    truth.emplace_back(300.3 + path_px, 400.1 - 0.7 * path_px);
    const auto error = [](double at_px) { return std::sqrt(2) * kError_px * std::sin(2 * std::numbers::pi * at_px); };
    seen.time_s.push_back(t);
    seen.place.emplace_back();
    seen.sigma.push_back(NAN);
    seen.See(seen.place.size() - 1, truth.back() + Eigen::Vector2d(error(truth.back().x()), error(truth.back().y())),
             kError_px);
  }
  LearningOptions options;
  options.trust = SigmaTrust::kFull;
  options.unit_mm = 1.5;
  const PathModel model = LearnPaths({&seen, 1}, PersonPrior(options.unit_mm), options).front();
  EXPECT_NEAR(model.memory_length, 1, 0.4);
  const SmoothedPath path = SmoothPath(seen, model, PersonPrior(options.unit_mm));
  for (const PathPoint& point : path.point) EXPECT_GT(point.position_covariance(0, 0), 1e-8);
  double seen2 = 0, square = 0, normalised = 0, speed2 = 0;
  for (std::size_t i = 500; i < 940; ++i) {
    const Eigen::Vector2d error = path.point[i].position.head<2>() - truth[i];
    seen2 += (seen.place[i].head<2>() - truth[i]).squaredNorm() / 880;
    square += error.squaredNorm() / 880;
    normalised += error.squaredNorm() / path.point[i].position_covariance(0, 0) / 880;
    speed2 += (path.point[i].velocity.head<2>() - kRate_hz / 2 * (truth[i + 1] - truth[i - 1])).squaredNorm() / 880;
  }
  EXPECT_LT(std::sqrt(square), 0.6 * std::sqrt(seen2));
  EXPECT_LT(std::sqrt(speed2), 1.5);  // px/s; of 187 px/s at most
  EXPECT_LT(std::sqrt(normalised), 1.2);
}

TEST(LearnPaths, DoesNotDependOnTheUnit) {
  const SeenPath mm = UnevenPath(4);
  SeenPath px = mm;
  for (std::size_t i = 0; i < px.time_s.size(); ++i) {
    px.place[i] /= 2;
    px.sigma[i] /= 2;
  }
  const PathModel in_mm = LearnPaths({&mm, 1}, PersonPrior(1), {}).front(),
                  in_px = LearnPaths({&px, 1}, PersonPrior(2), {}).front();
  EXPECT_NEAR(in_mm.white, in_px.white, 1e-6);
  EXPECT_NEAR(in_mm.density[20] / in_px.density[20], 4, 1e-6);
}

}  // namespace
}  // namespace lake::dynamics
