// A knee's angle and its speed from noisy samples by lake's path smoother: the time of a recording, and as counters
// the root mean square errors over all samples and seeds. smoothing_scipy.py gives the same curves to scipy. The sigma
// of the samples is known, the smoothness is not.
//
// lake_smoothing_benchmark --curves=FILE   writes the curves instead, for others to smooth
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <string_view>
#include <vector>

#include "lake/dynamics/path_smoother.h"

namespace {

using namespace lake;
constexpr int kSeeds = 20, kFrames = 600;
constexpr double kFrame_s = 1 / 60.0;
constexpr double kNoises_deg[] = {0.1, 0.5, 2};

struct Curve {
  std::vector<double> time_s, angle_deg, speed_deg_s, measured_deg;
};

// A change of the angle by minimum jerk, and on it a bulge in time as a bell: people do not move by formula.
struct Movement {
  double begin_s, length_s, change_deg;
  double bell_s, bell_width_s, bell_deg;

  void AddTo(Curve& curve, std::size_t i) const {
    const double u = std::clamp((curve.time_s[i] - begin_s) / length_s, 0.0, 1.0), rest = u * (1 - u);
    curve.angle_deg[i] += change_deg * u * u * u * (10 + u * (6 * u - 15));
    curve.speed_deg_s[i] += change_deg * 30 * rest * rest / length_s;
    const double z = (curve.time_s[i] - bell_s) / bell_width_s, bell = bell_deg * std::exp(-z * z / 2);
    curve.angle_deg[i] += bell;
    curve.speed_deg_s[i] -= bell * z / bell_width_s;
  }
};

// A person sits, rises, stands, and sits down.
Curve MakeCurve(double noise_deg, unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const auto movement = [&](double earliest_s, double change_deg) {
    const double begin_s = earliest_s + between(0, 1), length_s = between(1.2, 2.2);
    return Movement{begin_s,       length_s, change_deg, begin_s + length_s * between(0.2, 0.8), between(0.08, 0.2),
                    between(-5, 5)};
  };
  const Movement movements[] = {movement(1, -88), movement(5.5, 86)};
  std::normal_distribution<double> noise(0, noise_deg);
  Curve curve{{}, std::vector(kFrames, 92.0), std::vector(kFrames, 0.0), {}};
  for (std::size_t i = 0; i < kFrames; ++i) {
    curve.time_s.push_back(kFrame_s * static_cast<double>(i));
    for (const Movement& each : movements) each.AddTo(curve, i);
    curve.measured_deg.push_back(curve.angle_deg[i] + noise(random));
  }
  return curve;
}

void WriteCurves(const char* file) {
  std::ofstream table(file);
  table << "noise_deg,seed,time_s,angle_deg,speed_deg_s,measured_deg\n";
  for (const double noise_deg : kNoises_deg)
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const Curve curve = MakeCurve(noise_deg, seed);
      for (std::size_t i = 0; i < kFrames; ++i)
        table << fmt::format("{},{},{},{},{},{}\n", noise_deg, seed, curve.time_s[i], curve.angle_deg[i],
                             curve.speed_deg_s[i], curve.measured_deg[i]);
    }
}

void Smooth(benchmark::State& state, double noise_deg) {
  std::vector<Curve> curves;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) curves.push_back(MakeCurve(noise_deg, seed));
  double angle_square = 0, speed_square = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    const Curve& curve = curves[next++ % kSeeds];
    dynamics::SeenPath seen{1, curve.time_s, {}, std::vector(kFrames, noise_deg)};
    for (const double angle_deg : curve.measured_deg) seen.place.emplace_back(angle_deg, 0, 0);
    dynamics::LearningOptions options;
    options.trust = dynamics::SigmaTrust::kFull;
    const dynamics::MotionPrior prior = {.speed = 500, .acceleration = 5000, .reach = 200};  // of a knee, deg
    const dynamics::SmoothedPath path = dynamics::LearnAndSmooth(seen, prior, options);
    for (std::size_t i = 0; i < kFrames; ++i) {
      const double angle = path.point[i].position.x() - curve.angle_deg[i],
                   speed = path.point[i].velocity.x() - curve.speed_deg_s[i];
      angle_square += angle * angle;
      speed_square += speed * speed;
    }
  }
  const double count = static_cast<double>(next) * kFrames;
  state.counters["angle_deg"] = std::sqrt(angle_square / count);
  state.counters["speed_deg_s"] = std::sqrt(speed_square / count);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::string_view kCurves = "--curves=";
  if (argc > 1 && std::string_view(argv[1]).starts_with(kCurves)) {
    WriteCurves(argv[1] + kCurves.size());
    return 0;
  }
  benchmark::Initialize(&argc, argv);
  for (const double noise_deg : kNoises_deg)
    benchmark::RegisterBenchmark(fmt::format("Smooth/lake/{:g}", noise_deg).c_str(), Smooth, noise_deg)
        ->Iterations(5 * kSeeds)
        ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
}
