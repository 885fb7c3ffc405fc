#include "lake/steps/step_cost.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>

namespace lake::steps {
namespace {

// Sums of roots over a table that does not fit into the nearest caches: arithmetic and memory, as tracking and
// optimising take them.
double FixedWork(std::vector<double>& numbers) {
  for (int round = 0; round < 8; ++round)
    for (std::size_t i = 1; i < numbers.size(); ++i) numbers[i] = std::sqrt(numbers[i] * 1.001 + numbers[i - 1] * 1e-3);
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

double ThreadTimeS() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// In this thread's processor time, which does not depend on what else the machine and the program do at the moment.
double MeasuredPace() {
  constexpr int kTries = 5;
  constexpr double kReference_s = 0.0162;  // of the machine that costs were measured on
  std::vector<double> numbers(1 << 18, 1.5);
  double least_s = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const double start_s = ThreadTimeS();
    volatile double kept = FixedWork(numbers);  // is not left out
    (void)kept;
    least_s = std::min(least_s, ThreadTimeS() - start_s);
  }
  return least_s / kReference_s;
}

}  // namespace

double MachinePace() {
  static const double pace = MeasuredPace();
  return pace;
}

CostsOfRun CostOfAll(const std::vector<StepCost>& steps, const std::vector<std::vector<std::size_t>>& before,
                     int at_a_time) {
  constexpr double kWaiting = std::numeric_limits<double>::infinity();
  std::vector<double> left_s(steps.size(), kWaiting);  // with all the processors that it wants
  std::vector<std::size_t> running;
  CostsOfRun run{.all = {.seconds = 0, .memory_mb = 0}, .seconds = std::vector<double>(steps.size())};
  const auto is_over = [&](std::size_t step) { return left_s[step] <= 0; };
  while (true) {
    for (std::size_t i = 0; i < steps.size() && running.size() < static_cast<std::size_t>(at_a_time); ++i) {
      if (left_s[i] != kWaiting || !std::ranges::all_of(before[i], is_over)) continue;
      left_s[i] = steps[i].seconds;
      running.push_back(i);
    }
    if (running.empty()) return run;
    double memory_mb = 0, processors = 0, next_s = kWaiting;
    for (const std::size_t step : running) {
      memory_mb += steps[step].memory_mb;
      processors += steps[step].processors;
      next_s = std::min(next_s, left_s[step]);
    }
    const double slower = std::max(1.0, processors / at_a_time);
    run.all.memory_mb = std::max(run.all.memory_mb, memory_mb);
    run.all.seconds += slower * next_s;
    for (const std::size_t step : running) {
      left_s[step] -= next_s;
      run.seconds[step] += slower * next_s;
    }
    std::erase_if(running, is_over);
  }
}

}  // namespace lake::steps
