#include "film_rates.h"

#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace lake::tracking {
namespace {

// Frames per second: of cinema, television, and cameras in little light.
constexpr std::array kRates_hz = {10.0,        12.5, 15.0, 20.0,        24e3 / 1001, 24.0, 25.0,  30e3 / 1001, 30.0,
                                  48e3 / 1001, 48.0, 50.0, 60e3 / 1001, 60.0,        90.0, 100.0, 120.0,       240.0};

}  // namespace

double Film::Source(double i) const {
  return std::floor(ratio * i + phase);
}

std::vector<Film> SlowerFilms(double shown_hz) {
  constexpr int kLargestDenominator = 12;
  std::map<long, double> odds;  // by the ratio in 1e-9
  const auto add = [&](double film_hz, double its_odds) { odds[std::lround(1e9 * film_hz / shown_hz)] += its_odds; };
  for (const double film_hz : kRates_hz)
    if (film_hz < shown_hz) add(film_hz, 1.0 / kRates_hz.size());
  for (int n = 2; n <= kLargestDenominator; ++n)
    for (int m = 1; m < n; ++m)
      if (std::gcd(m, n) == 1) add(shown_hz * m / n, 1.0 / (n * n));
  std::vector<Film> slower;
  slower.reserve(odds.size());
  for (const auto& [ratio, its_odds] : odds)
    slower.push_back(
        {1e-9 * static_cast<double>(ratio) * shown_hz, 1e-9 * static_cast<double>(ratio), 0.5, std::log(its_odds)});
  return slower;
}

std::vector<Film> FasterFilms(double shown_hz) {
  constexpr double kWhole = 0.02;  // of a frame: evenly, so nearly
  std::vector<Film> faster;
  for (const double film_hz : kRates_hz)
    if (const double ratio = film_hz / shown_hz; ratio > 1 && std::abs(ratio - std::round(ratio)) > kWhole)
      faster.push_back({film_hz, ratio, 0.5, -std::log(kRates_hz.size())});
  return faster;
}

double FindPhase(const std::function<double(const Film&)>& log_likelihood, int phases, Film& film) {
  constexpr double kFinest = 1e-3;  // of a long recording, and a ratio of large numbers, some frames are decided by it
  double most = -INFINITY;
  double width = 1;
  while (width > kFinest) {
    const Film centre = film;
    double first = centre.phase, last = centre.phase;
    bool is_most = false;  // at the phase before
    for (int step = 0; step < phases; ++step) {
      Film tried = centre;
      tried.phase += width * ((step + 0.5) / phases - 0.5);
      const double log = log_likelihood(tried);
      if (log > most) first = tried.phase;
      is_most = log > most || (is_most && log == most);
      if (is_most) last = tried.phase;
      most = std::max(most, log);
    }
    film.phase = (first + last) / 2;
    width *= 2.0 / phases;
  }
  return most;
}

}  // namespace lake::tracking
