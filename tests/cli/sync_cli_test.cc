// lake-sync on two tables of one movement, and on a person's markers and force plates.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "lake/sync/clock.h"

namespace lake {
namespace {

using testing::HasSubstr;

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
  Outcome Go(const std::string& words) const { return Shell(folder_, "lake-sync " + words + " -o S"); }

  TemporaryFolder folder_;
};

TEST_F(SyncProgram, WritesTheClockThatLakeLoadsReads) {
  const Outcome outcome = Go("a.csv b.csv --quiet --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_NEAR(summary["offset_s"], kOffset_s, 0.002);
  EXPECT_EQ(summary["method"], "motion");
  const sync::Clock clock = sync::ReadClockOf(folder_ / "S/sync.yaml", "b.csv");
  EXPECT_NEAR(clock.FromB(10), 10 + kOffset_s, 0.002);
  EXPECT_LT(clock.sd_s, 0.002);
  for (const char* name : {"S/sync.png", "S/sync.svg"}) EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
}

TEST_F(SyncProgram, TakesASignal) {
  const Outcome outcome = Go("a.csv b.csv --signal-a lamp --signal-b lamp --quiet --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary["method"], "signal");
  EXPECT_NEAR(summary["offset_s"], kOffset_s, 0.5 / 60 + 0.5 / 100) << "half a frame of each";
}

// A film with a clap at this time: a click of 5 ms in silence.
void WriteClappedFilm(const std::filesystem::path& film, double clap_s) {
  const std::string sound =
      fmt::format("aevalsrc='if(between(t,{},{}),0.5*sin(20000*t)*exp(-500*(t-{})),0)':s=48000:d=12", clap_s,
                  clap_s + 0.05, clap_s);
  const std::string command = fmt::format(
      "ffmpeg -y -v error -nostdin -f lavfi -i color=black:size=64x48:rate=10:duration=12 -f lavfi -i \"{}\" -c:v "
      "mjpeg "
      "-c:a pcm_s16le '{}'",
      sound, film.string());
  ASSERT_EQ(std::system(command.c_str()), 0);
}

TEST_F(SyncProgram, TakesAClapAndALamp) {
  WriteClappedFilm(folder_ / "a.mkv", 9.005);  // in the middle of the lamp's sampling interval at 100 Hz
  const Outcome outcome =
      Go("a.csv b.csv --clap-a a.mkv --clap-distance-a 0 --signal-b lamp --drift-sd 0 --quiet --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_NEAR(summary["offset_s"], kOffset_s, 0.5 / 60 + 0.006) << "half a frame of B, and the clap's place in A's";
  EXPECT_NEAR(summary["sd_s"], 1 / 60. / std::sqrt(12), 0.0005);
  EXPECT_EQ(summary["compared"], "claps: 1");
  // A trial whose times are not the stamps' cannot be aligned by its film's sound.
  std::filesystem::create_directories(folder_ / "trial");
  std::filesystem::copy(folder_ / "a.csv", folder_ / "trial/trajectory.csv");
  for (const auto& [said, text] :
       {std::pair{R"({"options": {"capture-rate": "240"}})", "its times are those of --capture-rate 240"},
        {R"({"video": {"time_jumps": [{"after_frame": 7, "applied": true}]}})", "its times after frame 7"}}) {
    WriteTextFile(folder_ / "trial/summary.json", said);
    const Outcome refused = Go("trial b.csv --clap-a a.mkv --signal-b lamp --quiet");
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, HasSubstr(text));
  }
}

TEST_F(SyncProgram, RefusesWhatCannotBeAligned) {
  const auto refused = [&](const std::string& words, int exit_code, const std::string& message) {
    const Outcome outcome = Go(words);
    EXPECT_EQ(outcome.exit_code, exit_code) << words;
    EXPECT_THAT(outcome.err, HasSubstr(message));
    EXPECT_EQ(outcome.ErrorLines(), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "S/sync.yaml"));
  };
  refused("a.csv other.csv", 1, "cannot be aligned");
  refused("a.csv none.csv", 1, "none.csv: no such file");
  refused("a.csv b.csv --signal-a lamp", 2, "give both");
  refused("a.csv b.csv --clap-a a.mkv", 2, "give both");
  refused("a.csv b.csv --clap-a a.mkv --signal-a lamp --signal-b lamp", 2, "--signal-a and --clap-a: one of them");
  refused("a.csv b.csv --clap-distance-a 2 --signal-a lamp --signal-b lamp", 2, "--clap-distance-a");
  refused("a.csv b.csv --clap-a none.mkv --signal-b lamp", 1, "none.mkv: no such file");
  refused("a.csv b.csv --signal-a led --signal-b lamp", 1, "no signal 'led'");
}

}  // namespace
}  // namespace lake
