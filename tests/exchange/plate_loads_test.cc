// When a foot is on a force plate: of drawn forces with an offset and noise, and of a recording.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/exchange/ground_forces.h"
#include "lake/gait/walking.h"
#include "places.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::Le;

// An empty plate that reads 35 N, and a foot from `begin_s` on whose force grows by 15 N a ms and falls by 4.
std::vector<double> DrawnPlate(const std::vector<double>& time_s, double begin_s, double noise_n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_n);
  std::vector<double> plate_n;
  for (const double t : time_s) {
    const double on = t - begin_s;
    const double force_n = std::clamp(std::min(15000 * on, 4000 * (0.7 - on)), 0.0, 700.0);
    plate_n.push_back(35 + force_n + noise(random));
  }
  return plate_n;
}

// The drawn force passes 20 N 1.3 ms after its beginning, and 5 ms before its end. What an interpolation over 10 ms
// makes of such a force's corner is in the error, and half a frame in the standard deviation.
TEST(PlateLoads, BeginAndEndWhereTheForcePasses20Newtons) {
  for (const double rate_hz : {1000.0, 100.0}) {
    std::vector<double> time_s, errors_s, sds;
    for (int i = 0; i < 2 * rate_hz; ++i) time_s.push_back(i / rate_hz);
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const double begin_s = 0.5 + 0.00037 * seed;
      const auto loads = gait::LoadsOf(DrawnPlate(time_s, begin_s, 3, seed), time_s);
      ASSERT_EQ(loads.size(), 1u);
      for (const auto& [error_s, sd_s] : {std::pair{loads[0].begin_s - (begin_s + 20. / 15000), loads[0].begin_sd_s},
                                          {loads[0].end_s - (begin_s + 0.7 - 20. / 4000), loads[0].end_sd_s}}) {
        errors_s.push_back(error_s);
        sds.push_back(error_s / sd_s);
      }
    }
    EXPECT_LT(RootMeanSquare(errors_s), 0.5 / rate_hz);
    EXPECT_THAT(RootMeanSquare(sds), AllOf(Ge(0.5), Le(2))) << rate_hz << " Hz";
  }
}

TEST(PlateLoads, OnThePlateAtEitherEndHaveNoTimeThere) {
  std::vector<double> time_s;
  for (int i = 0; i < 400; ++i) time_s.push_back(i / 1000.);
  const auto loads = gait::LoadsOf(DrawnPlate(time_s, 0.1, 0, 1), time_s);
  ASSERT_EQ(loads.size(), 1u);
  EXPECT_TRUE(std::isnan(loads[0].end_s));
  EXPECT_NEAR(loads[0].begin_s, 0.1013, 0.001);
  // Of an empty plate nothing.
  EXPECT_TRUE(gait::LoadsOf(DrawnPlate(time_s, 5, 1, 1), time_s).empty());
}

TEST(PlateLoads, OfARecordingAreThoseOfItsTable) {
  const std::filesystem::path folder = SharedData() / "walking_force_plates";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no recordings";
  const CsvTable table = CsvTable::Read(folder / "plate_events.csv");
  std::size_t found = 0;
  for (const std::string name : {"walking1", "walkingTI1", "walkingTS1"}) {
    const exchange::GroundForceRecording forces = exchange::ReadGroundForces(folder / (name + "_grf.mot"));
    std::vector<double> times;
    for (const exchange::PlateForces& plate : forces.plates) {
      std::vector<double> vertical_n;
      for (const Eigen::Vector3d& force : plate.force_n) vertical_n.push_back(force.y());
      for (const gait::PlateLoad& load : gait::LoadsOf(vertical_n, forces.time_s))
        for (const double time_s : {load.begin_s, load.end_s})
          if (std::isfinite(time_s)) times.push_back(time_s);
    }
    for (std::size_t row = 0; row < table.Rows(); ++row)
      if (table.Text(row, 0) == name) {
        const double time_s = table.RequiredNumber(row, 3);
        const bool is_found = std::ranges::any_of(times, [&](double t) { return std::abs(t - time_s) < 1e-3; });
        EXPECT_TRUE(is_found) << name << " " << time_s;
        found += is_found ? 1 : 0;
      }
  }
  EXPECT_EQ(found, table.Rows());
}

}  // namespace
}  // namespace lake
