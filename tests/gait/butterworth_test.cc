#include "lake/gait/butterworth.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include "lake/core/error.h"

namespace lake {
namespace {

std::vector<double> Sine(const std::vector<double>& time_s, double frequency_hz) {
  std::vector<double> values;
  for (const double t : time_s) values.push_back(std::sin(2 * std::numbers::pi * frequency_hz * t));
  return values;
}

std::vector<double> Times(int count, double rate_hz) {
  std::vector<double> time_s;
  for (int i = 0; i < count; ++i) time_s.push_back(i / rate_hz);
  return time_s;
}

// The amplitude that is left of a sine, by projection on it over the middle; anything out of phase shows in `rest`.
double Gain(const std::vector<double>& in, const std::vector<double>& out, double* rest) {
  double product = 0, square = 0, remainder = 0;
  const std::size_t n = in.size();
  for (std::size_t i = n / 4; i < 3 * n / 4; ++i) product += in[i] * out[i], square += in[i] * in[i];
  const double gain = product / square;
  for (std::size_t i = n / 4; i < 3 * n / 4; ++i) remainder = std::max(remainder, std::abs(out[i] - gain * in[i]));
  *rest = remainder;
  return gain;
}

// The gain of both passes is |H|² of one, 1 / (1 + (f/f1)⁴) in warped frequencies, and √½ at the cutoff.
TEST(Butterworth, GainFollowsTheClosedFormWithoutPhase) {
  const double rate_hz = 100, cutoff_hz = 6;
  const auto warp = [&](double f) { return std::tan(std::numbers::pi * f / rate_hz); };
  const std::vector<double> time_s = Times(2000, rate_hz);
  for (const double frequency_hz : {0.5, 2.0, 6.0, 10.0, 20.0}) {
    const std::vector<double> sine = Sine(time_s, frequency_hz);
    double rest = 0;
    const double gain = Gain(sine, gait::ZeroPhaseButterworth(sine, rate_hz, cutoff_hz), &rest);
    EXPECT_NEAR(gain, 1 / (1 + (std::sqrt(2.0) - 1) * std::pow(warp(frequency_hz) / warp(cutoff_hz), 4)), 1e-6)
        << frequency_hz;
    EXPECT_LT(rest, 1e-6) << frequency_hz;
  }
}

TEST(Butterworth, KeepsStraightLinesToTheEnds) {
  std::vector<double> line;
  for (int i = 0; i < 200; ++i) line.push_back(3 - 0.25 * i);
  const std::vector<double> filtered = gait::ZeroPhaseButterworth(line, 60, 6);
  for (std::size_t i = 0; i < line.size(); ++i)
    EXPECT_NEAR(filtered[i], line[i], 0.02) << i;  // start-up of a pass on a slope
}

TEST(Butterworth, UnevenTimesGiveTheSameCurve) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  std::vector<double> time_s = Times(600, 60);
  for (double& t : time_s) t += jitter(random) / 60;
  const std::vector<double> sine = Sine(time_s, 1.5);
  const std::vector<double> filtered = gait::ZeroPhaseButterworthAtTimes(sine, time_s, 6);
  double rest = 0;
  EXPECT_NEAR(Gain(sine, filtered, &rest), 1 / (1 + std::pow(1.5 / (6 / 0.8022), 4)), 2e-3);
  EXPECT_LT(rest, 2e-3);
}

TEST(Butterworth, RefusesWhatItCannotDo) {
  const std::vector<double> ok(50, 1.0), bad = {1, std::nan(""), 2, 3};
  EXPECT_THROW(gait::ZeroPhaseButterworth(ok, 60, 0), Error);
  EXPECT_THROW(gait::ZeroPhaseButterworth(ok, 60, 30), Error);
  EXPECT_THROW(gait::ZeroPhaseButterworth(ok, 0, 6), Error);
  EXPECT_THROW(gait::ZeroPhaseButterworth(bad, 60, 6), Error);
  const std::vector<double> hole = {0, 0.01, 0.02, 1e9}, four = {1, 2, 3, 4};
  EXPECT_THROW(gait::ZeroPhaseButterworthAtTimes(four, hole, 6), Error);
  EXPECT_THAT([] { gait::CheckCutoff(6, 0.1); },  // 100 Hz in ms
              testing::ThrowsMessage<Error>(testing::HasSubstr("10 s apart: times are in seconds, are these in ms?")));
  EXPECT_THAT([] { gait::CheckCutoff(6, 10); },
              testing::ThrowsMessage<Error>(testing::Not(testing::HasSubstr("in ms"))));
}

}  // namespace
}  // namespace lake
