// Differential evolution, DE/rand/1/bin (Storn & Price, J. Global Optim. 11, 1997): a global search to hold a solver
// against.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "lake/problem/problem.h"

namespace lake {

struct Evolved {
  std::vector<double> x;
  double value;
};

// The largest value found within the bounds.
inline Evolved Evolve(const std::vector<problem::Bounds>& bounds,
                      const std::function<double(const std::vector<double>&)>& value, int population, int generations,
                      unsigned seed) {
  constexpr double kWeight = 0.6, kCrossover = 0.9;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Evolved> all;
  for (int i = 0; i < population; ++i) {
    std::vector<double> x;
    for (const problem::Bounds& b : bounds) x.push_back(std::lerp(b.lower, b.upper, unit(random)));
    all.push_back({x, value(x)});
  }
  std::uniform_int_distribution<std::size_t> pick(0, all.size() - 1), axis(0, bounds.size() - 1);
  for (int generation = 0; generation < generations; ++generation)
    for (Evolved& target : all) {
      const Evolved &a = all[pick(random)], &b = all[pick(random)], &c = all[pick(random)];
      const std::size_t forced = axis(random);
      std::vector<double> x = target.x;
      for (std::size_t k = 0; k < x.size(); ++k)
        if (k == forced || unit(random) < kCrossover)
          x[k] = std::clamp(a.x[k] + kWeight * (b.x[k] - c.x[k]), bounds[k].lower, bounds[k].upper);
      const double trial = value(x);
      if (trial >= target.value) target = {x, trial};
    }
  return *std::max_element(all.begin(), all.end(),
                           [](const Evolved& a, const Evolved& b) { return a.value < b.value; });
}

}  // namespace lake
