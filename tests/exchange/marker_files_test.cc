// A folder with one file per marker, as Tracker exports single tracks.
#include <gmock/gmock.h>

#include <algorithm>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/exchange/convert.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/trial.h"
#include "temporary_folder.h"

namespace lake::exchange {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class MarkerFiles : public testing::Test {
 protected:
  // A track as Tracker's table, from `first` on, `frames` of them at 50 Hz, shifted in time.
  void Write(const std::string& name, int first, int frames, double x, double shift_s = 0) {
    std::string text = "\t" + name + "\t\nt\tx\ty\n";
    for (int i = first; i < first + frames; ++i)
      text += fmt::format("{:.4f}\t{}\t{}\n", 0.02 * i + shift_s, x + i, 10 * i);
    std::filesystem::create_directories(folder_ / "markers");
    WriteTextFile(folder_ / ("markers/" + name + ".txt"), text);
  }

  PointRecording Read(double mm_per_unit = 1) { return ReadPoints(folder_ / "markers", {.mm_per_unit = mm_per_unit}); }

  TemporaryFolder folder_;
};

TEST_F(MarkerFiles, AreJoinedByTheirTimes) {
  Write("knee", 0, 5, 100);
  Write("ankle", 2, 5, 200);  // begins and ends two frames later
  const PointRecording points = Read(10);
  ASSERT_EQ(points.time_s.size(), 7u);
  ASSERT_EQ(points.points.size(), 2u);
  const PointTrack &ankle = *points.Find("ankle"), &knee = *points.Find("knee");
  EXPECT_FALSE(ankle.positions[1].allFinite());
  EXPECT_EQ(ankle.positions[2], Eigen::Vector3d(2020, 200, 0)) << "in the unit that was given";
  EXPECT_EQ(knee.positions[4], Eigen::Vector3d(1040, 400, 0));
  EXPECT_FALSE(knee.positions[5].allFinite());
}

TEST_F(MarkerFiles, AreOneFrameWhereTimesAreRounded) {
  Write("knee", 0, 5, 100);
  Write("ankle", 0, 5, 200, 0.0004);
  EXPECT_EQ(Read().time_s.size(), 5u);
}

// As Tracker writes them where the language has it so.
TEST_F(MarkerFiles, MayHaveADecimalComma) {
  Write("knee", 0, 5, 100.5);
  const PointRecording with_points = Read();
  const std::filesystem::path file = folder_ / "markers/knee.txt";
  std::string text = ReadTextFile(file);
  std::ranges::replace(text, '.', ',');
  WriteTextFile(file, text);
  const PointRecording with_commas = Read();
  EXPECT_EQ(with_commas.time_s, with_points.time_s);
  EXPECT_EQ(with_commas.points[0].positions, with_points.points[0].positions);
  EXPECT_EQ(with_commas.points[0].positions[1], Eigen::Vector3d(101.5, 10, 0));
}

TEST_F(MarkerFiles, OfOtherTimesAreRefused) {
  Write("knee", 0, 5, 100);
  Write("ankle", 0, 5, 200, 0.008);
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("0.4 of a frame apart")));
}

TEST_F(MarkerFiles, WithSeveralMarkersAreNamed) {
  Write("knee", 0, 5, 100);
  WriteTextFile(folder_ / "markers/both.csv", "time_s,a_x_mm,a_y_mm,b_x_mm,b_y_mm\n0,1,2,3,4\n");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("both.csv: 2 markers, not one")));
}

TEST_F(MarkerFiles, BecomeATrialAndATable) {
  for (const auto& [name, x] : {std::pair{"ankle", 0.0}, {"knee", 1.0}, {"hip", 2.0}}) Write(name, 0, 5, x);
  TrialOptions reading;
  reading.mm_per_unit = 1000;
  const Trial trial = ReadTrial(folder_ / "markers", reading);
  EXPECT_EQ(trial.recording.markers.size(), 3u);
  EXPECT_EQ(trial.recording.Find("hip")->samples[1].position, Eigen::Vector2d(3000, 10000));
  ConvertOptions options;
  options.reading = reading;
  ConvertFile(folder_ / "markers", folder_ / "trial.csv", options);
  EXPECT_EQ(ReadTrial(folder_ / "trial.csv", {}).recording.Find("hip")->samples[1].position,
            Eigen::Vector2d(3000, 10000));
}

TEST_F(MarkerFiles, AnEmptyFolderSaysWhatItShouldHold) {
  std::filesystem::create_directories(folder_ / "markers");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("nor one .txt or .csv per marker")));
}

}  // namespace
}  // namespace lake::exchange
