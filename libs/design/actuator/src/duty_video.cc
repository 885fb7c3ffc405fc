#include "lake/actuator/duty_video.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"

namespace lake::actuator {
namespace {

constexpr std::size_t kFewest = 20;  // rows of the log, frames of the film
constexpr double kShiftStep_s = 0.005;
constexpr double kSpeedWindow_s = 0.1;  // to either side, for the film's speed
constexpr double kLeastCorrelation = 0.7;
constexpr double kLongestGap_s = 1;  // between rows of the log, across which a duty is taken to last

// The duty that rows before and after a time share; NaN where they do not, or there is none.
double DutyAt(const DutyCommands& commands, double time_s) {
  const auto after = std::upper_bound(commands.time_s.begin(), commands.time_s.end(), time_s);
  if (after == commands.time_s.begin() || after == commands.time_s.end()) return kNaN;
  const auto i = static_cast<std::size_t>(after - commands.time_s.begin());
  if (commands.time_s[i] - commands.time_s[i - 1] > kLongestGap_s) return kNaN;
  return commands.duty[i] == commands.duty[i - 1] ? commands.duty[i] : kNaN;
}

struct SpeedSample {
  double time_s, speed_mm_s;
};

std::vector<SpeedSample> SpeedsOf(const ActuatorFilm& film) {
  std::vector<SpeedSample> speeds;
  std::size_t before = 0, after = 0;
  for (std::size_t i = 0; i < film.time_s.size(); ++i) {
    while (film.time_s[before] < film.time_s[i] - kSpeedWindow_s) ++before;
    while (after + 1 < film.time_s.size() && film.time_s[after + 1] <= film.time_s[i] + kSpeedWindow_s) ++after;
    const double span = film.time_s[after] - film.time_s[before];
    if (span >= kSpeedWindow_s)
      speeds.push_back({film.time_s[i], (film.length_mm[after] - film.length_mm[before]) / span});
  }
  return speeds;
}

struct Agreement {
  double product = 0, correlation = 0;
};

Agreement AgreementAt(const DutyCommands& commands, const std::vector<SpeedSample>& speeds, double shift_s) {
  double product = 0, duties = 0, squares = 0;
  for (const SpeedSample& sample : speeds) {
    const double duty = DutyAt(commands, sample.time_s + shift_s);
    if (std::isnan(duty)) continue;
    product += duty * sample.speed_mm_s;
    duties += duty * duty;
    squares += sample.speed_mm_s * sample.speed_mm_s;
  }
  return {product, duties > 0 && squares > 0 ? product / std::sqrt(duties * squares) : 0};
}

void Check(const DutyCommands& commands, const ActuatorFilm& film, const std::vector<SpeedSample>& speeds) {
  if (commands.time_s.size() < kFewest)
    throw Fail("{}: {} rows are too few to be aligned with a video", commands.name, commands.time_s.size());
  if (film.time_s.size() < kFewest || speeds.size() < kFewest)
    throw Fail("{} frames with the actuator's two markers are too few to be aligned with a log", film.time_s.size());
}

}  // namespace

AlignedLog AlignWithFilm(const DutyCommands& commands, const ActuatorFilm& film) {
  const std::vector<SpeedSample> speeds = film.time_s.empty() ? std::vector<SpeedSample>{} : SpeedsOf(film);
  Check(commands, film, speeds);
  AlignedLog aligned;
  double most = -1;
  const double low = commands.time_s.front() - film.time_s.back(), high = commands.time_s.back() - film.time_s.front();
  for (double shift = low; shift <= high; shift += kShiftStep_s) {
    ThrowIfInterrupted();
    const Agreement agreement = AgreementAt(commands, speeds, shift);
    if (std::abs(agreement.product) <= most) continue;
    most = std::abs(agreement.product);
    aligned.shift_s = shift;
    aligned.correlation = agreement.correlation;
  }
  if (std::abs(aligned.correlation) < kLeastCorrelation)
    throw Fail("{}: its duties and the speeds of the video agree nowhere (correlation {:.2f}); are they of one run?",
               commands.name, aligned.correlation);
  aligned.log.name = commands.name;
  for (std::size_t i = 0; i < film.time_s.size(); ++i) {
    const double time = film.time_s[i] + aligned.shift_s, duty = DutyAt(commands, time);
    if (std::isnan(duty)) continue;
    aligned.log.time_s.push_back(time);
    aligned.log.duty.push_back(duty);
    aligned.log.stroke_mm.push_back(film.length_mm[i]);
  }
  return aligned;
}

}  // namespace lake::actuator
