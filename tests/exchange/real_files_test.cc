// Every file of these kinds among the real recordings, against what their README says.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "lake/exchange/c3d.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"
#include "places.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

struct RealFile {
  const char* path;
  std::size_t frames, markers;
  double rate_hz;
  const char* warning;  // part of the only one; "" for none
};

class RealFiles : public testing::TestWithParam<RealFile> {};

TEST_P(RealFiles, HoldWhatTheyAreKnownToHold) {
  const fs::path path = SharedData() / GetParam().path;
  if (!fs::exists(path)) GTEST_SKIP() << path.string() << " is not here";
  const exchange::PointRecording points = exchange::ReadPoints(path);
  EXPECT_EQ(points.time_s.size(), GetParam().frames);
  EXPECT_EQ(points.points.size(), GetParam().markers);
  // Times in these files are rounded to a millisecond.
  EXPECT_NEAR(exchange::FrameRate(points.time_s), GetParam().rate_hz, 0.01 * GetParam().rate_hz);
  if (*GetParam().warning)
    EXPECT_THAT(points.warnings, testing::ElementsAre(testing::HasSubstr(GetParam().warning)));
  else
    EXPECT_TRUE(points.warnings.empty());
}

// Written in every format that holds them and read again, they are what they were.
TEST_P(RealFiles, RoundTripsLoseNothing) {
  const fs::path path = SharedData() / GetParam().path;
  if (!fs::exists(path)) GTEST_SKIP() << path.string() << " is not here";
  const TemporaryFolder folder;
  exchange::PointRecording points = exchange::ReadPoints(path);
  if (points.space != exchange::PointSpace::kSpace) return;
  points.up_axis = 'y';  // else TRC turns them
  exchange::WritePoints(folder / "a.trc", points);
  ExpectSame(points, exchange::ReadPoints(folder / "a.trc"), 0);
  // The steps' rounding to a millisecond and a shorter last one are no frame rate.
  if (*GetParam().warning) {
    EXPECT_THAT(MessageOf([&] { exchange::WriteC3d(folder / "a.c3d", points); }), testing::HasSubstr("uneven"));
    return;
  }
  const double rate_hz = std::round(exchange::FrameRate(points.time_s));
  for (std::size_t i = 0; i < points.time_s.size(); ++i)
    points.time_s[i] = std::round(points.time_s.front() * rate_hz + static_cast<double>(i)) / rate_hz;
  exchange::WriteC3d(folder / "a.c3d", points);
  // A float of 24 bits holds 4 m to 2.4e-4 mm per axis; times come from the rate, a float too.
  ExpectSame(points, exchange::ReadC3d(folder / "a.c3d"), 5e-4);
}

INSTANTIATE_TEST_SUITE_P(
    , RealFiles,
    testing::Values(RealFile{"opencap_sts/sts_default_markers.trc", 861, 51, 100, ""},
                    RealFile{"opensim_walk/std_walking2_markers.trc", 126, 44, 25, "250 Hz, but the rows are 0.04 s"},
                    RealFile{"opensim_walk/std_walking5_markers.trc", 112, 40, 25, "250 Hz, but the rows are 0.04 s"},
                    RealFile{"opensim_walk/subject01_synthetic_marker_data.trc", 73, 31, 60, ""},
                    RealFile{"opensim_walk/subject01_walk1.trc", 151, 41, 60, ""},
                    RealFile{"real_motions/standing_static.trc", 460, 57, 100, ""},
                    RealFile{"real_motions/tabs_squat2.trc", 460, 61, 100, ""},
                    RealFile{"real_motions/tabs_stairs3.trc", 440, 61, 100, ""},
                    RealFile{"real_motions/gait_200hz.trc", 185, 29, 200, ""},
                    RealFile{"opensim_walk/walking2.c3d", 1249, 44, 250, ""},
                    RealFile{"opensim_walk/walking5.c3d", 1103, 40, 250, ""},
                    RealFile{"tracker_balltoss/BallToss_BallToss.trk", 13, 1, 1 / 0.066, ""}),
    [](const auto& info) {
      std::string name = fs::path(info.param.path).filename().string();
      std::replace_if(
          name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
      return name;
    });

// The laboratory's exporter thinned the C3D files out tenfold: equal times hold equal places.
TEST(OpensimWalk, TrcFilesAreEveryTenthFrameOfTheC3dFiles) {
  const fs::path folder = SharedData() / "opensim_walk";
  if (!fs::exists(folder)) GTEST_SKIP() << folder.string() << " is not here";
  for (const auto& [trc_name, c3d_name] :
       {std::pair{"std_walking2_markers.trc", "walking2.c3d"}, {"std_walking5_markers.trc", "walking5.c3d"}}) {
    const exchange::PointRecording trc = exchange::ReadPoints(folder / trc_name),
                                   c3d = exchange::ReadC3d(folder / c3d_name);
    EXPECT_EQ(c3d.up_axis, 'z');
    int compared = 0;
    for (std::size_t i = 0; i + 1 < trc.time_s.size(); ++i) {
      ASSERT_NEAR(c3d.time_s.at(10 * i), trc.time_s[i], 1e-9);
      for (const exchange::PointTrack& point : trc.points) {
        const exchange::PointTrack* other = c3d.Find(point.name);
        ASSERT_TRUE(other) << point.name;
        const Eigen::Vector3d &a = point.positions[i], &b = other->positions[10 * i];
        if (!a.allFinite() || !b.allFinite()) continue;
        EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 0.06)
            << point.name << " at " << trc.time_s[i];  // written with 5 digits
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000);
  }
}

TEST(OpensimWalk, InverseKinematicsTablesReadBack) {
  const fs::path folder = SharedData() / "opensim_walk";
  if (!fs::exists(folder)) GTEST_SKIP() << folder.string() << " is not here";
  const TemporaryFolder written;
  for (const char* name : {"subject01_walk1_ik.mot", "std_subject01_walk1_ik.mot"}) {
    const exchange::MotTable table = exchange::ReadMot(folder / name);
    EXPECT_TRUE(table.in_degrees);
    EXPECT_TRUE(table.warnings.empty());
    exchange::WriteMot(written / name, table);
    const exchange::MotTable read = exchange::ReadMot(written / name);
    EXPECT_EQ(read.columns, table.columns);
    EXPECT_EQ(read.rows, table.rows);
    EXPECT_EQ(read.time_s, table.time_s);
  }
  const exchange::MotTable table = exchange::ReadMot(folder / "subject01_walk1_ik.mot");
  std::vector<double> knee_deg;
  for (const std::vector<double>& row : table.rows) knee_deg.push_back(row[table.Column("knee_angle_r")]);
  EXPECT_NEAR(std::ranges::min(knee_deg), -69.7, 0.05);  // flexion negative
  EXPECT_NEAR(std::ranges::max(knee_deg), 1.05, 0.05);
}

// Tracker's project through our own writer: positions, times, axes and scale stay.
TEST(TrackerBalltoss, ProjectReadsBack) {
  const fs::path file = SharedData() / "tracker_balltoss/BallToss_BallToss.trk";
  if (!fs::exists(file)) GTEST_SKIP() << file.string() << " is not here";
  const TemporaryFolder folder;
  const exchange::PointRecording ball = exchange::ReadPoints(file);
  EXPECT_NEAR(ball.axes->angle_deg, 0.04401895816986783, 1e-12);
  // The origin of its axes lies on the ball's first place.
  EXPECT_NEAR(exchange::PointsInPlane(ball).points[0].positions[2].norm(), 0, 1e-9);
  exchange::WritePoints(folder / "a.trk", ball);
  const exchange::PointRecording read = exchange::ReadPoints(folder / "a.trk");
  ExpectSame(ball, read, 1e-9);
  EXPECT_NEAR(*read.mm_per_px, *ball.mm_per_px, 1e-12);
}

}  // namespace
}  // namespace lake
