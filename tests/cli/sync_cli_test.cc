// lake-sync on two tables of one movement, and on a person's markers and force plates.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "lake/sync/clock.h"

namespace lake {
namespace {

constexpr double kOffset_s = 2.5;

// Two markers that swing without repeating themselves; a lamp that comes on at 9 s of the movement.
void WriteTable(const std::filesystem::path& path, double rate_hz, double from_s, double until_s, double offset_s,
                double slower) {
  std::ofstream csv(path);
  csv << "frame,time_s,knee_x_mm,knee_y_mm,hip_x_mm,hip_y_mm,lamp_x_mm,lamp_y_mm\n";
  csv.precision(10);
  for (int i = 0; from_s + i / rate_hz < until_s; ++i) {
    const double t = from_s + i / rate_hz, s = slower * t;
    const double knee = 100 * std::sin(2 * s + 3 * std::sin(0.37 * s)),
                 hip = 150 * std::sin(1.3 * s + std::sin(0.9 * s));
    csv << i << "," << t - offset_s << "," << knee << "," << 430 - 0.3 * knee << "," << hip << "," << 800 + hip / 2;
    csv << (t > 9 ? ",0,0\n" : ",,\n");
  }
}

class SyncProgram : public testing::Test {
 protected:
  SyncProgram() {
    WriteTable(folder_ / "a.csv", 100, 0, 20, 0, 1);
    WriteTable(folder_ / "b.csv", 60, 3, 22, kOffset_s, 1);
    WriteTable(folder_ / "other.csv", 60, 3, 22, kOffset_s, 1.3);
  }
  TemporaryFolder folder_;
};

TEST_F(SyncProgram, WritesTheClockThatLakeLoadsReads) {
  const Json summary = DoneJson(folder_, "lake-sync a.csv b.csv --quiet --json -o S");
  EXPECT_NEAR(summary["offset_s"], kOffset_s, 0.002);
  EXPECT_EQ(summary["method"], "motion");
  const sync::Clock clock = sync::ReadClockOf(folder_ / "S/sync.yaml", "b.csv");
  EXPECT_NEAR(clock.FromB(10), 10 + kOffset_s, 0.002);
  EXPECT_LT(clock.sd_s, 0.002);
  for (const char* name : {"S/sync.png", "S/sync.svg"}) EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
}

TEST_F(SyncProgram, TakesASignal) {
  const Json summary = DoneJson(folder_, "lake-sync a.csv b.csv --signal-a lamp --signal-b lamp --quiet --json -o S");
  EXPECT_EQ(summary["method"], "signal");
  EXPECT_NEAR(summary["offset_s"], kOffset_s, 0.5 / 60 + 0.5 / 100) << "half a frame of each";
}

TEST_F(SyncProgram, RefusesWhatCannotBeAligned) {
  const auto refused = [&](const std::string& words, int exit_code, const std::string& message) {
    ExpectRefused(folder_, "lake-sync " + words + " -o S", exit_code, message);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "S/sync.yaml"));
  };
  refused("a.csv other.csv", 1, "cannot be aligned");
  refused("a.csv none.csv", 1, "none.csv: no such file");
  refused("a.csv b.csv --signal-a lamp", 2, "give both");
  refused("a.csv b.csv --clap-a film.mp4", 2, "--clap-a");
  refused("a.csv b.csv --signal-a led --signal-b lamp", 1, "no signal 'led'");
}

}  // namespace
}  // namespace lake
