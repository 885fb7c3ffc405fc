// The clock of the forces against the motion, on motions with known answers.
#include "lake/loads/clock_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lake/gait/butterworth.h"

namespace lake {
namespace {

constexpr double kCutoff_hz = 6;

// A sum of sines of up to 3 Hz, as the force of a body that rises and sits down.
class Motion {
 public:
  explicit Motion(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 6.28), size(20, 60);
    for (Wave& wave : waves_) wave = {size(random), phase(random)};
  }
  double At(double time_s) const {
    double force_n = 300;
    for (std::size_t k = 0; k < std::size(waves_); ++k)
      force_n += waves_[k].size_n * std::sin(6.28 * 0.5 * static_cast<double>(k + 1) * time_s + waves_[k].phase);
    return force_n;
  }

 private:
  struct Wave {
    double size_n = 0, phase = 0;
  };
  Wave waves_[6];
};

struct Recorded {
  std::vector<double> time_s, needed_n, measured_n;
  std::vector<loads::Window> windows;

  std::optional<loads::ClockOffset> Offset() const {
    return loads::FindClockOffset(time_s, needed_n, measured_n, windows);
  }
};

// The foot bears 0.4 of the force and 30 N more, and `noise_n` that the motion does not explain.
Recorded Record(unsigned seed, double add_s, double noise_n, double rate_hz = 100) {
  Recorded recorded;
  const Motion motion(seed);
  std::mt19937 random(seed + 1000);
  std::normal_distribution<double> normal;
  std::vector<double> noise;
  for (int i = 0; i < 15 * rate_hz; ++i) {
    recorded.time_s.push_back(3 + i / rate_hz);
    noise.push_back(normal(random));
  }
  noise = gait::ZeroPhaseButterworthAtTimes(noise, recorded.time_s, kCutoff_hz);
  double sum = 0;
  for (const double value : noise) sum += value * value;
  const double to_sd = noise_n / std::sqrt(sum / static_cast<double>(noise.size()));
  for (std::size_t i = 0; i < noise.size(); ++i) {
    recorded.needed_n.push_back(motion.At(recorded.time_s[i]));
    recorded.measured_n.push_back(30 + 0.4 * motion.At(recorded.time_s[i] + add_s) + to_sd * noise[i]);
  }
  const auto frame = [&](double at_s) { return static_cast<std::size_t>((at_s - 3) * rate_hz); };
  for (const double begin_s : {4.2, 8.0, 12.0, 15.0})
    recorded.windows.push_back({frame(begin_s), frame(begin_s + 1.5)});
  return recorded;
}

TEST(ClockOffset, IsFoundAsWellAsItSays) {
  int count = 0, within = 0;
  for (unsigned seed = 0; seed < 40; ++seed)
    for (const double add_s : {-0.9, -0.15, 0.0, 0.031, 0.3}) {
      const auto offset = Record(seed, add_s, 10).Offset();
      ASSERT_TRUE(offset) << seed << " " << add_s;
      EXPECT_LT(offset->sd_s, 0.02);
      EXPECT_GE(offset->sd_s, 0.01);  // what the body's model takes for granted
      ++count, within += std::abs(offset->add_s - add_s) < 2 * offset->sd_s;
    }
  EXPECT_GE(within, 0.95 * count);
}

// Between frames of a slow camera, too.
TEST(ClockOffset, IsFoundBetweenFrames) {
  for (const double rate_hz : {25.0, 50.0, 240.0}) {
    const auto offset = Record(7, 0.1234, 0, rate_hz).Offset();
    ASSERT_TRUE(offset) << rate_hz;
    EXPECT_NEAR(offset->add_s, 0.1234, 0.004) << rate_hz;  // straight lines between 25 frames/s of up to 3 Hz
  }
}

TEST(ClockOffset, OfForcesThatDoNotFollowTheMotionIsNotTold) {
  Recorded recorded = Record(1, 0, 5);
  recorded.measured_n = Record(2, 0, 5).measured_n;
  EXPECT_FALSE(recorded.Offset());
  recorded.measured_n.assign(recorded.time_s.size(), 250);
  EXPECT_FALSE(recorded.Offset());
  recorded.measured_n.assign(recorded.time_s.size(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(recorded.Offset());
  recorded.windows.clear();
  EXPECT_FALSE(recorded.Offset());
}

// Forces that begin late and end early: the windows that they have tell it.
TEST(ClockOffset, NeedsNoForcesOutsideTheWindows) {
  Recorded recorded = Record(3, 0.15, 0);
  for (std::size_t i = 0; i < recorded.time_s.size(); ++i)
    if (recorded.time_s[i] < 7.8 || recorded.time_s[i] > 14) recorded.measured_n[i] = std::nan("");
  recorded.windows = {recorded.windows[1], recorded.windows[2]};
  const auto offset = recorded.Offset();
  ASSERT_TRUE(offset);
  EXPECT_NEAR(offset->add_s, 0.15, 0.002);
}

}  // namespace
}  // namespace lake
