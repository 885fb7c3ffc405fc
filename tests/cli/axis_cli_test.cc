// lake-axis on hinges whose axis is known.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;

constexpr int kFrames = 400;

// In mm: to and fro four times, rising by `fast_deg` at most.
double AngleOf(int frame, double range_deg) {
  return range_deg * M_PI / 180 * 0.5 * (1 - std::cos(2 * M_PI * frame / 100));
}

class AxisProgram : public testing::Test {
 protected:
  // A small error that is the same at each run and unlike in each frame.
  static Vector3d Jitter(int frame, int marker) {
    return 0.05 * Vector3d(std::sin(7.3 * frame + marker), std::sin(5.1 * frame + 2 * marker),
                           std::sin(3.7 * frame + 3 * marker));
  }

  // A trajectory.csv's plane: the shank stands and moves to the right, the thigh turns about (10, 20) of it.
  void WritePlane(double range_deg) const {
    std::ofstream csv(folder_ / "plane.csv");
    csv << "frame,time_s";
    for (const char* name : {"s1", "s2", "t1", "t2"}) csv << "," << name << "_x_mm," << name << "_y_mm";
    csv << "\n";
    const Vector3d at[] = {{-20, -300, 0}, {30, -100, 0}, {10, 320, 0}, {30, 120, 0}}, axis(10, 20, 0);
    for (int i = 0; i < kFrames; ++i) {
      csv << i << "," << 0.01 * i;
      for (int m = 0; m < 4; ++m) {
        const Eigen::AngleAxisd turn(AngleOf(i, range_deg), Vector3d::UnitZ());
        const Vector3d p = (m < 2 ? at[m] : axis + turn * (at[m] - axis)) + Vector3d(0.2 * i, 0, 0) + Jitter(i, m);
        csv << "," << p.x() << "," << p.y();
      }
      csv << "\n";
    }
  }

  // A .trc: the thigh turns about a line through (10, 20, 30) along (1, 2, 3).
  void WriteSpace() const {
    std::ofstream trc(folder_ / "space.trc");
    trc << "PathFileType\t4\t(X/Y/Z)\tspace.trc\n"
           "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
        << "100\t100\t" << kFrames << "\t6\tmm\t100\t1\t" << kFrames << "\nFrame#\tTime";
    for (const char* name : {"s1", "s2", "s3", "t1", "t2", "t3"}) trc << "\t" << name << "\t\t";
    trc << "\n\t";
    for (int m = 1; m <= 6; ++m) trc << "\tX" << m << "\tY" << m << "\tZ" << m;
    trc << "\n\n";
    const Vector3d at[] = {{-20, -300, 0}, {30, -100, 40}, {-50, -150, -60},
                           {10, 320, 20},  {30, 120, -50}, {60, 200, 70}};
    const Vector3d axis(10, 20, 30), direction = Vector3d(1, 2, 3).normalized();
    for (int i = 0; i < kFrames; ++i) {
      trc << i + 1 << "\t" << 0.01 * i;
      const Eigen::AngleAxisd turn(AngleOf(i, 80), direction);
      for (int m = 0; m < 6; ++m) {
        const Vector3d p = (m < 3 ? at[m] : axis + turn * (at[m] - axis)) + Jitter(i, m);
        trc << "\t" << p.x() << "\t" << p.y() << "\t" << p.z();
      }
      trc << "\n";
    }
  }

  Json Find(const std::string& words) const { return DoneJson(folder_, "lake-axis " + words + " --quiet --json -o A"); }

  void Refused(const std::string& words, int exit_code, const std::string& message) const {
    ExpectRefused(folder_, "lake-axis " + words + " -o A", exit_code, message);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "A/axis.csv"));
  }

  TemporaryFolder folder_;
};

const std::string kPlane = "plane.csv --segment shank=s1,s2 --segment thigh=t1,t2";
const std::string kSpace = "space.trc --segment shank=s1,s2,s3 --segment thigh=t1,t2,t3";

// The errors of 0.05 mm stand at markers 200 mm apart and average out over 400 frames: 0.1 mm is ample.
constexpr double kNear_mm = 0.1;

TEST_F(AxisProgram, FindsAHingeInAPlane) {
  WritePlane(80);
  const Json summary = Find(kPlane + " --window 1");
  // The shank's origin is the mean of its markers, (5, -200) at first.
  EXPECT_NEAR(summary["axis_point_mm"][0], 10 - 5, kNear_mm);
  EXPECT_NEAR(summary["axis_point_mm"][1], 20 + 200, kNear_mm);
  EXPECT_EQ(summary["axis_direction"], Json({0, 0, 1}));
  EXPECT_NEAR(summary["flexion_deg"], 80, 0.1);
  EXPECT_LT(summary["axis_sd_mm"],
            0.5);  // wider than the error: markers may move with the angle by as much as they err
  EXPECT_LT(summary["pin_residual_mm"], 0.2);
  const CsvTable axes = CsvTable::Read(folder_ / "A/axis.csv"), table = CsvTable::Read(folder_ / "A/centre.csv");
  EXPECT_THAT(axes.Header(), ElementsAre("window", "first_frame", "last_frame", "flexion_deg", "x_mm", "y_mm", "sd_mm",
                                         "x_mm_file", "y_mm_file"));
  ASSERT_EQ(axes.Rows(), 5u) << "the whole and four windows";
  EXPECT_EQ(axes.RequiredNumber(0, axes.Column("last_frame")), 399);
  EXPECT_EQ(axes.RequiredNumber(4, axes.Column("first_frame")), 300);
  ASSERT_EQ(table.Rows(), static_cast<std::size_t>(kFrames));
  EXPECT_THAT(table.Header(), ElementsAre("frame", "time_s", "knee_deg", "x_mm", "y_mm", "sd_x_mm", "sd_y_mm",
                                          "x_mm_file", "y_mm_file"));
  for (const std::size_t row : {0u, 150u, 399u}) {
    EXPECT_NEAR(table.RequiredNumber(row, table.Column("x_mm")), 5, 0.5);  // a slope is less certain than a mean
    EXPECT_NEAR(table.RequiredNumber(row, table.Column("x_mm_file")), 10 + 0.2 * static_cast<double>(row), 0.5)
        << "the shank moves by 0.2 mm each frame";
  }
}

TEST_F(AxisProgram, FindsAHingeInSpace) {
  WriteSpace();
  const Json summary = Find(kSpace);
  const auto vector = [&](const char* key) { return Vector3d(summary[key][0], summary[key][1], summary[key][2]); };
  const Vector3d direction = Vector3d(1, 2, 3).normalized();
  EXPECT_LT(vector("axis_direction").cross(direction).norm(), 0.001);
  EXPECT_LT((vector("axis_point_mm_file") - Vector3d(10, 20, 30)).cross(direction).norm(), kNear_mm);
  EXPECT_THAT(CsvTable::Read(folder_ / "A/axis.csv").Header(),
              ElementsAre("window", "first_frame", "last_frame", "flexion_deg", "x_mm", "y_mm", "z_mm", "nx", "ny",
                          "nz", "sd_mm", "x_mm_file", "y_mm_file", "z_mm_file", "nx_file", "ny_file", "nz_file"));
}

TEST_F(AxisProgram, RefusesWhatGivesNoAxis) {
  WritePlane(80);
  WriteSpace();
  Refused("plane.csv --segment shank=s1,none --segment thigh=t1,t2", 1, "no marker 'none'");
  Refused("plane.csv --segment shank=s1 --segment thigh=t1,t2", 2, "--segment shank=s1: give two markers or more");
  Refused("space.trc --segment shank=s1,s2 --segment thigh=t1,t2,t3", 2, "needs at least 3");
  Refused("plane.csv --segment shank=s1,s2", 2, "add --segment thigh=");
  Refused("plane.csv --segment shank=s1,s2 --segment foot=t1,t2", 2, "--segment foot");
  Refused(kPlane + " --unit m", 2, "--unit has no effect");
  Refused(kPlane + " --window 5", 1, "shorter window");
  WritePlane(0);
  Refused(kPlane, 1, "degrees only");
}

}  // namespace
}  // namespace lake
