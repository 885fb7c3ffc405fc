// Every format: what is written reads back, dialects are understood, hostile files give one clear error.
#include "lake/exchange/formats.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/mot.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

class Formats : public testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

TEST_F(Formats, TrcReadsBack) {
  for (const exchange::PointSpace space : {exchange::PointSpace::kSpace, exchange::PointSpace::kPlane})
    for (const auto& [frames, points] : {std::pair{50, 4}, {3, 1}, {1, 60}}) {
      const exchange::PointRecording written =
          MakePoints(space, static_cast<std::size_t>(frames), static_cast<std::size_t>(points), 1);
      exchange::WritePoints(folder_ / "a.trc", written);
      ExpectSame(written, exchange::ReadPoints(folder_ / "a.trc"), 0);
    }
}

TEST_F(Formats, TrcKeepsTheCustomsOfItsReaders) {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 4, 2, 1);
  points.points[1].positions[3] = exchange::PointTrack::Missing();
  exchange::WritePoints(folder_ / "a.trc", points);
  std::vector<std::string> lines;
  std::ifstream file(folder_ / "a.trc");
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  EXPECT_EQ(lines[0], "PathFileType\t4\t(X/Y/Z)\ta.trc");
  EXPECT_EQ(lines[3], "Frame#\tTime\tmarker 1\t\t\tmarker 2");
  EXPECT_EQ(lines[4], "\t\tX1\tY1\tZ1\tX2\tY2\tZ2");
  EXPECT_THAT(lines[5], testing::StartsWith("1\t0\t"));
  EXPECT_THAT(lines[5], testing::Not(testing::EndsWith("\t")));
  EXPECT_THAT(lines[8],
              testing::EndsWith("\t\t\t\t"));  // three empty cells and the tab that OpenSim wants behind the last
}

const char* kTrcHead =
    "PathFileType\t4\t(X/Y/"
    "Z)\tx.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";

TEST_F(Formats, TrcOfCortexHasMoreMarkersThanItsHeaderSays) {
  const std::string head = std::string(kTrcHead) + "100\t100\t1\t1\tmm\t100\t1\t1\n";
  // Labels of the measured markers only; the virtual one is missing at the first row's end.
  const exchange::PointRecording unlabelled = exchange::ReadPoints(Write(
      "u.trc", std::string(kTrcHead) + "100\t100\t2\t1\tmm\t100\t1\t2\nFrame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\n\n"
                                       "1\t0\t1\t2\t3\t\t\t\n2\t0.01\t1\t2\t3\t4\t5\t6\n"));
  EXPECT_FALSE(unlabelled.Find("B")->positions[0].allFinite());
  EXPECT_EQ(unlabelled.Find("B")->positions[1], Eigen::Vector3d(4, 5, 6));
  // A name without columns is a marker that is never seen.
  EXPECT_THAT(SaidOf([&] {
                return exchange::ReadPoints(
                           Write("d.trc", head + "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\n\n1\t0\t1\t2\t3\n"))
                    .warnings;
              }),
              testing::HasSubstr("says 1 markers, but there are 2"));
}

TEST_F(Formats, TrcZerosAreAMissingMarker) {
  const exchange::PointRecording points = exchange::ReadPoints(
      Write("z.trc", std::string(kTrcHead) + "100\t100\t2\t1\tmm\t100\t1\t2\nFrame#\tTime\tA\n\t\tX1\tY1\tZ1\n\n"
                                             "1\t0\t0\t2\t0\n2\t0.01\t0\t0.000\t0\n"));
  EXPECT_EQ(points.points[0].positions[0], Eigen::Vector3d(0, 2, 0));
  EXPECT_FALSE(points.points[0].positions[1].allFinite());
}

TEST_F(Formats, TrcWithAPaddedHeaderIsRead) {
  const std::string keys = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n",
                    rest = "Frame#\tTime\tA\t\t\n\t\tX1\tY1\tZ1\t\n\n1\t0\t1\t2\t3\n";
  const exchange::PointRecording points = exchange::ReadPoints(
      Write("p.trc", "PathFileType  4\t(X/Y/Z) x\n" + keys + "  100.0\t\t  100.0\t\t    1\t\t   1\t\t cm\n" + rest));
  EXPECT_EQ(points.points[0].positions[0], Eigen::Vector3d(10, 20, 30));
  // A value that is not there leaves its place empty.
  EXPECT_NO_THROW(exchange::ReadPoints(Write("e.trc", "PathFileType\t4\n" + keys + "100\t\t1\t1\tmm\n" + rest)));
}

TEST_F(Formats, ANameThatStandsTwiceIsNumberedWithAWarningInEveryFormat) {
  const auto expect = [&](const exchange::PointRecording& points, const std::string& format) {
    ASSERT_EQ(points.points.size(), 3u) << format;
    EXPECT_EQ(points.points[0].name, "knee") << format;
    EXPECT_EQ(points.points[1].name, "knee_3") << format;  // as there is a knee_2
    EXPECT_EQ(points.points[2].name, "knee_2") << format;
    EXPECT_EQ(points.points[1].positions[0].x(), 3) << format;
    ASSERT_EQ(points.warnings.size(), 1u) << format;
    EXPECT_THAT(points.warnings[0], testing::HasSubstr("stand twice; the later ones are called knee_3")) << format;
  };
  expect(exchange::ReadPoints(Write("n.trc", std::string(kTrcHead) +
                                                 "100\t100\t1\t3\tmm\t100\t1\t1\nFrame#\tTime\tknee\t\t\tknee\t\t\t"
                                                 "knee_2\n\t\tX1\n\n1\t0\t1\t2\t0\t3\t4\t0\t5\t6\t0\n")),
         "TRC");
  expect(exchange::ReadPoints(Write(
             "n.txt", "\tknee\t\tknee\t\tknee_2\t\nt\tx\ty\tx\ty\tx\ty\n0\t1\t2\t3\t4\t5\t6\n1\t1\t2\t3\t4\t5\t6\n")),
         "Tracker");
  expect(exchange::ReadPoints(Write("n.csv",
                                    "Time,knee/0/X,knee/0/Y,knee/0/X,knee/0/Y,knee_2/0/X,knee_2/0/Y\n"
                                    "0,1,2,3,4,5,6\n33,1,2,3,4,5,6\n")),
         "Kinovea");
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 3, 3, 1);
  points.points[0].name = points.points[1].name = "knee";
  points.points[2].name = "knee_2";
  points.points[1].positions[0].x() = 3;
  exchange::WriteC3d(folder_ / "n.c3d", points);
  expect(exchange::ReadC3d(folder_ / "n.c3d"), "C3D");
  EXPECT_THAT(exchange::ReadPoints(Write("x.csv", "Time,knee/0/X,hip/0/X,hip/0/Y\n0,1,2,3\n33,1,2,3\n")).warnings,
              testing::Contains(testing::HasSubstr("follows the x of knee")));
}

TEST_F(Formats, NamesInLatin1AreReadByEveryFormat) {
  const std::string knee = "Kn\xC3\xA9\xC3\xA9", latin = "Kn\xE9\xE9";
  for (const std::string& name : {knee, latin}) {
    EXPECT_EQ(
        exchange::ReadPoints(Write("n.trc", std::string(kTrcHead) + "100\t100\t1\t1\tmm\t100\t1\t1\nFrame#\tTime\t" +
                                                name + "\t\t\n\t\tX1\tY1\tZ1\n\n1\t0\t1\t2\t3\n"))
            .points[0]
            .name,
        knee);
    EXPECT_EQ(exchange::ReadPoints(Write("n.txt", name + "\nt\tx\ty\n0\t1\t2\n1\t3\t4\n")).points[0].name, knee);
    EXPECT_EQ(exchange::ReadPoints(Write("n.csv", "\"Time\";\"" + name + "/0/X\";\"" + name +
                                                      "/0/Y\"\n\"0\";\"1,5\";\"2\"\n\"33\";\"3\";\"4\"\n"))
                  .points[0]
                  .name,
              knee);
    exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 3, 1, 1);
    points.points[0].name = name;
    exchange::WriteC3d(folder_ / "n.c3d", points);
    EXPECT_EQ(exchange::ReadC3d(folder_ / "n.c3d").points[0].name, knee);
  }
  EXPECT_EQ(exchange::ReadPoints(Write("x.txt", "a\x92s\nt\tx\ty\n0\t1\t2\n")).points[0].name, "a’s");  // Windows
}

TEST_F(Formats, NamesThatWouldBreakATableAreRefused) {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kPlane, 3, 1, 1);
  for (const char* name : {"", "a\tb", "a\nb"}) {
    points.points[0].name = name;
    EXPECT_THAT(MessageOf([&] { exchange::WritePoints(folder_ / "n.trc", points); }), testing::HasSubstr("--map"));
    EXPECT_THAT(MessageOf([&] { exchange::WritePoints(folder_ / "n.txt", points); }), testing::HasSubstr("--map"));
  }
  EXPECT_FALSE(fs::exists(folder_ / "n.trc"));
}

TEST_F(Formats, TrcErrorsSayWhere) {
  const std::string head = kTrcHead, values = "100\t100\t1\t1\tmm\t100\t1\t1\n",
                    names = "Frame#\tTime\tA\n\t\tX1\tY1\tZ1\n";
  const auto message = [&](const std::string& text) {
    return SaidOf([&] { return exchange::ReadPoints(Write("e.trc", text)).warnings; });
  };
  EXPECT_THAT(message("hello"), testing::HasSubstr("no row of names"));
  EXPECT_THAT(message(""), testing::HasSubstr("is empty"));
  EXPECT_THAT(message(head + values + names + "1\t0\t1\t2\tthree\n"),
              testing::AllOf(testing::HasSubstr("e.trc:6"), testing::HasSubstr("three")));
  EXPECT_THAT(message(head + values + names + "1\t0\t1\t2\t3\t4\n"), testing::HasSubstr("e.trc:6"));
  EXPECT_THAT(message(head + values + names + "1\tinf\t1\t2\t3\n"), testing::HasSubstr("e.trc:6"));
  EXPECT_THAT(message(head + values + names + "1\t0.000\t1\t2\t3\n2\t0.000\t1\t2\t3\n"),
              testing::HasSubstr("does not follow"));
  EXPECT_THAT(message(head + "100\t100\t1\t99999999999\tmm\t100\t1\t1\n" + names + "1\t0\t1\t2\t3\n"),
              testing::HasSubstr("NumMarkers"));
  EXPECT_THAT(message(head + "100\t100\t1\t2\tmm\t100\t1\t1\n" + names + "1\t0\t1\t2\t3\n"),
              testing::HasSubstr("says 2 markers, but there are 1"));
  EXPECT_THAT(message(std::string("Path\0Type\0\0\0\0", 13)), testing::HasSubstr("not a text file"));
  EXPECT_THAT(
      MessageOf([&] { exchange::WritePoints(folder_ / "x.trc", MakePoints(exchange::PointSpace::kImage, 3, 1, 1)); }),
      testing::HasSubstr("mm"));
  EXPECT_FALSE(fs::exists(folder_ / "x.trc"));
}

TEST_F(Formats, C3dReadsBack) {
  for (const auto& [frames, points] : {std::pair{50, 4}, {2, 1}, {20, 300}}) {
    exchange::PointRecording written =
        MakePoints(exchange::PointSpace::kSpace, static_cast<std::size_t>(frames), static_cast<std::size_t>(points), 2);
    written.up_axis = frames == 2 ? 'z' : 'y';
    exchange::WriteC3d(folder_ / "a.c3d", written);
    const exchange::PointRecording read = exchange::ReadC3d(folder_ / "a.c3d");
    ExpectSame(written, read, 1e-4);  // floats of 24 bits hold 1500 mm to 6e-5 mm per axis
    EXPECT_EQ(read.up_axis, written.up_axis);
  }
}

TEST_F(Formats, C3dCannotHoldUnevenTimes) {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 20, 1, 3);
  points.time_s[10] += 0.004;
  EXPECT_THAT(MessageOf([&] { exchange::WriteC3d(folder_ / "u.c3d", points); }), testing::HasSubstr("uneven"));
  EXPECT_FALSE(fs::exists(folder_ / "u.c3d"));
}

TEST_F(Formats, C3dErrors) {
  exchange::WriteC3d(folder_ / "a.c3d", MakePoints(exchange::PointSpace::kSpace, 20, 3, 5));
  const std::string good = ReadTextFile(folder_ / "a.c3d");
  const auto message = [&](const std::string& bytes) {
    return SaidOf([&] { return exchange::ReadC3d(Write("e.c3d", bytes)).warnings; });
  };
  EXPECT_THAT(message(""), testing::HasSubstr("not a C3D file"));
  EXPECT_THAT(message(std::string(2000, 'x')), testing::HasSubstr("not a C3D file"));
  EXPECT_THAT(message(good.substr(0, good.size() - 512)), testing::HasSubstr("cut off"));
  std::string processor = good;
  processor[512 + 3] = 77;
  EXPECT_EQ(message(processor), "");  // the rate in the header says which it is
  processor.replace(20, 4, 4, '\0');
  EXPECT_THAT(message(processor), testing::HasSubstr("77"));
}

TEST_F(Formats, MotReadsBack) {
  exchange::MotTable table{
      "knee", true, {"knee_angle_r", "b"}, {0, 0.1, 0.25}, {{1.5, -2}, {3, std::nan("")}, {1.0 / 3, 4}}};
  exchange::WriteMot(folder_ / "a.mot", table);
  const exchange::MotTable read = exchange::ReadMot(folder_ / "a.mot");
  EXPECT_EQ(read.columns, table.columns);
  EXPECT_EQ(read.time_s, table.time_s);
  EXPECT_EQ(read.rows[2], table.rows[2]);
  EXPECT_TRUE(std::isnan(read.rows[1][1]));
  EXPECT_TRUE(read.in_degrees);
}

TEST_F(Formats, MotOfAMotionHasTheSignThatWasAskedFor) {
  motion::LegMotion motion;
  for (int i = 0; i < 3; ++i) {
    motion.frame.push_back(i);
    motion.time_s.push_back(0.1 * i);
    motion.samples.emplace_back();
    if (i != 1) motion.samples.back().knee_deg = 10 + i;
  }
  const exchange::MotTable left = exchange::MotFromLegMotion(motion, motion::Side::kLeft);
  EXPECT_EQ(left.rows[1][left.Column("knee_angle_l")], 12);
  EXPECT_EQ(left.time_s.size(), 2u);  // without the frame that has no angle
  const exchange::MotTable right = exchange::MotFromLegMotion(motion, motion::Side::kRight, true);
  EXPECT_EQ(right.rows[0][right.Column("knee_angle_r")], -10);
}

TEST_F(Formats, MotSaysTheUnitOfAnglesInSeveralWays) {
  const auto read = [&](const std::string& head) {
    return exchange::ReadMot(Write("u.sto", "q\n" + head + "endheader\ntime\tknee_angle_r\n0\t1\n"));
  };
  for (const char* head :
       {"inDegrees=yes\n", "inDegrees=y\n", "InDegrees = Yes\n", "inDegrees=true\n", "inDegrees yes\n",
        "Angles are in degrees.\n", "Rotations in degrees\n", "# SIMM Motion File Header:\n", "datacolumns 2\n"}) {
    EXPECT_TRUE(read(head).in_degrees) << head;
    EXPECT_TRUE(read(head).warnings.empty()) << head;
  }
  const std::string explanation =
      "If the header above contains a line with 'inDegrees', this indicates whether rotational values are in degrees "
      "(yes) or radians (no).\n";
  EXPECT_TRUE(read("inDegrees=yes\n\n" + explanation).in_degrees);
  EXPECT_FALSE(read("inDegrees=no\n\n" + explanation).in_degrees);
  for (const char* head : {"inDegrees=no\n", "inDegrees=n\n", "inDegrees=False\n", "Angles are in radians.\n"}) {
    EXPECT_FALSE(read(head).in_degrees) << head;
    EXPECT_TRUE(read(head).warnings.empty()) << head;
  }
  for (const std::string& head : {std::string("version=1\n"), explanation}) {
    EXPECT_FALSE(read(head).in_degrees) << "as OpenSim reads it";
    EXPECT_THAT(read(head).warnings, testing::ElementsAre(testing::HasSubstr("does not say the unit of angles")));
  }
  EXPECT_THAT(MessageOf([&] { read("inDegrees=perhaps\n"); }), testing::HasSubstr("u.sto:2: inDegrees is 'perhaps'"));
  EXPECT_THAT(MessageOf([&] { read("inDegrees=\n"); }), testing::HasSubstr("inDegrees is ''"));
  EXPECT_THAT(MessageOf([&] { read("inDegrees=yes\nAngles are in radians.\n"); }),
              testing::HasSubstr("u.sto:3: says that angles are in radians"));
}

TEST_F(Formats, MotErrorsSayWhere) {
  const auto message = [&](const std::string& text) {
    return SaidOf([&] { return exchange::ReadMot(Write("e.mot", text)).warnings; });
  };
  EXPECT_THAT(message("x\ninDegrees=yes\n"), testing::HasSubstr("endheader"));
  EXPECT_THAT(message("x\nendheader\n"), testing::HasSubstr("labels"));
  EXPECT_THAT(message("x\nendheader\nknee\ttime\n"), testing::HasSubstr("not time"));
  EXPECT_THAT(message("x\nnColumns=3\nendheader\ntime\ta\n0\t1\n"), testing::HasSubstr("the header says 3"));
  EXPECT_THAT(message("x\nendheader\ntime\ta\n0\t1\t2\n"), testing::HasSubstr("e.mot:4"));
  EXPECT_THAT(message("x\nnRows=2\nendheader\ntime\ta\n0\t1\n"), testing::HasSubstr("1 rows, but the header says 2"));
}

TEST_F(Formats, TrackerTextReadsBack) {
  for (const std::size_t count : {1u, 4u}) {
    const exchange::PointRecording written = MakePoints(exchange::PointSpace::kPlane, 30, count, 7);
    exchange::WritePoints(folder_ / "a.txt", written);
    ExpectSame(written, exchange::ReadPoints(folder_ / "a.txt"), 1e-8);
  }
}

TEST_F(Formats, TrackerCountsPixelsFromTheirCorner) {
  const exchange::PointRecording written = MakePoints(exchange::PointSpace::kImage, 5, 2, 7);
  exchange::WritePoints(folder_ / "a.txt", written);
  const exchange::PointRecording read = exchange::ReadPoints(folder_ / "a.txt");
  EXPECT_NEAR(read.points[0].positions[0].x(), written.points[0].positions[0].x() + 0.5, 1e-8);
  EXPECT_NEAR(read.points[0].positions[0].y(), -written.points[0].positions[0].y() - 0.5, 1e-8);
  ExpectSame(written, exchange::ReadPoints(folder_ / "a.txt", {.mm_per_unit = exchange::kInPixels}), 1e-8);
  exchange::WritePoints(folder_ / "a_kinovea.csv", written);
  const exchange::PointRecording again =
      exchange::ReadPoints(folder_ / "a_kinovea.csv", {.mm_per_unit = exchange::kInPixels});
  EXPECT_EQ(again.space, exchange::PointSpace::kImage);
  ExpectSame(written, again, 1e-8);
}

TEST_F(Formats, TrackerTextDialects) {
  const exchange::PointRecording points =
      exchange::ReadPoints(Write("d.txt",
                                 "#multi:\r\n\tknee\t\thip\t\r\nt\tx\ty\tx\ty\r\n0,000000E0\t1,5E-"
                                 "1\t2,0E0\t\t\r\n3,3E-2\t1,6E-1\t2,1E0\t3\t4\r\n"),
                           {.mm_per_unit = 1000});
  EXPECT_NEAR(points.Find("knee")->positions[0].x(), 150, 1e-9);
  EXPECT_FALSE(points.Find("hip")->positions[0].allFinite());
  EXPECT_NEAR(points.Find("hip")->positions[1].y(), 4000, 1e-9);
  EXPECT_EQ(exchange::ReadPoints(Write("s.txt", "mass A\nt\tx\ty\n0\t1\t2\n1\t3\t4\n")).points[0].name, "mass A");
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(Write("e.txt", "a\tb\tc\n")); }), testing::HasSubstr("labels"));
  EXPECT_THAT(SaidOf([&] { return exchange::ReadPoints(Write("e.txt", "t\tx\ty\n0\t1\tz\n")).warnings; }),
              testing::HasSubstr("e.txt:2"));
}

TEST_F(Formats, KinoveaReadsBackInBothLocales) {
  const exchange::PointRecording written = MakePoints(exchange::PointSpace::kPlane, 30, 3, 8);
  exchange::WritePoints(folder_ / "a_kinovea.csv", written);
  ExpectSame(written, exchange::ReadPoints(folder_ / "a_kinovea.csv"), 0);
  const exchange::PointRecording comma =
      exchange::ReadPoints(Write("k.csv",
                                 "\"Time\";\"my \"\"best\"\" knee/0/X\";\"my \"\"best\"\" "
                                 "knee/0/Y\"\r\n\"0,0\";\"1,5\";\"-2\"\r\n\"33,3\";;\r\n"),
                           {.mm_per_unit = 10});
  EXPECT_EQ(comma.points[0].name, "my \"best\" knee");
  EXPECT_EQ(comma.points[0].positions[0], Eigen::Vector3d(15, -20, 0));
  EXPECT_FALSE(comma.points[0].positions[1].allFinite());
  EXPECT_NEAR(comma.time_s[1], 0.0333, 1e-12);  // ms
}

TEST_F(Formats, KinoveaErrorsSayWhere) {
  const auto message = [&](const std::string& text) {
    return MessageOf([&] { exchange::ReadPoints(Write("e.csv", text)); });
  };
  EXPECT_THAT(message(""), testing::HasSubstr("its first line is ''"));
  EXPECT_THAT(message("\"Time\",\"a/0/X\"\n"), testing::HasSubstr("follows the x of a"));
  EXPECT_THAT(message("\"Time\",\"a/0/X\",\"a/0/Y\"\n\"0:00:01\",\"1\",\"2\"\n"), testing::HasSubstr("0:00:01"));
}

}  // namespace
}  // namespace lake
