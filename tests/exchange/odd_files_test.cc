// Files as other programs write them: what is consistent is read, the rest is named in a warning, and a file that is
// not read is called what it is. Files of shared/data/odd_files, and dialects made here after the programs' documents.
#include <gmock/gmock.h>

#include "exchange/model_output.h"
#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/trial.h"
#include "places.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using exchange::PointRecording;
using exchange::ReadPoints;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> NamesOf(const PointRecording& points) {
  std::vector<std::string> names;
  for (const exchange::PointTrack& point : points.points) names.push_back(point.name);
  return names;
}

class OddFiles : public testing::Test {
 protected:
  static fs::path Shared(const std::string& name) { return SharedData() / "odd_files" / name; }
  fs::path Write(const std::string& name, const std::string& text) const { return WriteFile(folder_ / name, text); }
  PointRecording Read(const std::string& name, const std::string& text,
                      const exchange::ReadOptions& options = {}) const {
    return ReadPoints(Write(name, text), options);
  }
  std::string Refusal(const std::string& name, const std::string& text,
                      const exchange::ReadOptions& options = {}) const {
    return MessageOf([&] { Read(name, text, options); });
  }
  TemporaryFolder folder_;
};

TEST_F(OddFiles, TrcThatWasCroppedOrHasOtherLineEndsOrUnnamedMarkers) {
  if (!fs::exists(Shared("trc-line-ends"))) GTEST_SKIP() << Shared("").string() << " is not here";
  const PointRecording cropped = ReadPoints(Shared("trc-fewer-rows-than-stated/cropped.trc"));
  EXPECT_EQ(cropped.time_s.size(), 20u);
  EXPECT_NEAR(cropped.time_s.front(), 0.10, 1e-9);
  EXPECT_NEAR(cropped.time_s.back(), 0.29, 1e-9);
  EXPECT_EQ(cropped.frame.front(), 10);
  EXPECT_THAT(cropped.warnings, ElementsAre(HasSubstr("the header says 350 frames, but there are 20 frames")));
  const PointRecording ends = ReadPoints(Shared("trc-line-ends/a.trc"));
  EXPECT_EQ(NamesOf(ends), NamesOf(cropped));
  const PointRecording unnamed = ReadPoints(Shared("trc-unnamed-markers-behind/a.trc"));
  EXPECT_EQ(unnamed.points.size(), 4u);
  EXPECT_THAT(unnamed.warnings, ElementsAre(AllOf(HasSubstr(":107: a column of values without a name is left out"),
                                                  HasSubstr("the first of 3"))));
  EXPECT_TRUE(unnamed.points[3].positions[101].allFinite());
}

TEST_F(OddFiles, KinoveasTextDeepLabCutAndAProjectWithoutCalibration) {
  if (!fs::exists(Shared("kinovea-text"))) GTEST_SKIP() << Shared("").string() << " is not here";
  const PointRecording text = ReadPoints(Shared("kinovea-text/a.txt"), {.mm_per_unit = 10});
  EXPECT_EQ(NamesOf(text), (std::vector<std::string>{"ankle", "knee"}));
  EXPECT_EQ(text.time_s, (std::vector<double>{0, 0.008, 0.017}));
  EXPECT_LT((text.Find("ankle")->positions[2] - Eigen::Vector3d(772, -219.4, 0)).norm(), 1e-9);
  EXPECT_THAT(MessageOf([&] { ReadPoints(Shared("foreign-csv/deeplabcut.csv")); }),
              AllOf(HasSubstr("DeepLabCut have no times"), HasSubstr("--rate")));
  const PointRecording tracks = ReadPoints(Shared("foreign-csv/deeplabcut.csv"), {.rate_hz = 50});
  EXPECT_EQ(tracks.space, exchange::PointSpace::kImage);
  EXPECT_EQ(tracks.Find("knee")->positions[1], Eigen::Vector3d(160.2, 485, 0));
  EXPECT_EQ(tracks.time_s, (std::vector<double>{0, 0.02}));
  const PointRecording project = ReadPoints(Shared("trk-never-calibrated/a.trk"));
  EXPECT_EQ(project.space, exchange::PointSpace::kImage);
  EXPECT_FALSE(project.mm_per_px);
  EXPECT_THAT(project.warnings, ElementsAre(HasSubstr("was never calibrated")));
  EXPECT_EQ(exchange::ReadTrial(Shared("trk-never-calibrated/a.trk")).recording.unit, motion::LengthUnit::kPx);
}

constexpr const char* kHead =
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";

std::string Trc(const std::string& values, const std::string& names, const std::string& rows) {
  return kHead + values + "\nFrame#\tTime\t" + names + "\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n" + rows;
}

std::string Utf16(const std::string& text, bool high_first) {
  std::string wide;
  for (const char c : text) wide += high_first ? std::string{'\0', c} : std::string{c, '\0'};
  return wide;
}

TEST_F(OddFiles, TrcInUtf16WithoutAMarkAndWithOddUnits) {
  const std::string rows = "1\t0\t1\t2\t3\n2\t0.01\t1\t2\t3\n";
  const auto trc = [&](const std::string& unit) { return Trc("100\t100\t2\t1\t" + unit + "\t100\t1\t2", "a", rows); };
  for (const bool high_first : {false, true})
    EXPECT_EQ(Read("a.trc", Utf16(trc("mm"), high_first)).points.at(0).positions[1], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(Read("a.trc", trc("mm.")).points[0].positions[1], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(Read("a.trc", trc("[Meters].")).points[0].positions[1], Eigen::Vector3d(1000, 2000, 3000));
  // Values that do not stand below their keys: none of them is a unit.
  EXPECT_THAT(Read("a.trc", trc("460")).warnings, ElementsAre(HasSubstr("no unit (Units); mm is assumed")));
}

TEST_F(OddFiles, NameTheAxisThatIsMissing) {
  EXPECT_THAT(Refusal("a.csv", "scorer,S,S\nbodyparts,knee,knee\ncoords,x,likelihood\n0,100.5,0.99\n", {.rate_hz = 50}),
              HasSubstr("no y follows the x of knee"));
  EXPECT_THAT(Refusal("b.csv",
                      "Format Version,1.23,Length Units,Meters\n\n,Type,Marker,Marker\n,Name,a,a\n,ID,1,1\n"
                      ",,Position,Position\nFrame,Time (Seconds),X,Y\n0,0.000,0.1,0.2\n"),
              HasSubstr("no y and z follow the x of a"));
}

TEST_F(OddFiles, TrcWithABlemishThatNobodyNeeds) {
  const std::string names = "a\t\t\tb\t\t", rows = "1\t0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t4\t5\t6\n";
  const auto read = [&](const std::string& values, const std::string& with_names, const std::string& with_rows) {
    return Read("a.trc", Trc(values, with_names, with_rows));
  };
  const std::string values = "100\t100\t2\t2\tmm\t100\t1\t2";
  EXPECT_TRUE(read(values, names, rows).warnings.empty());
  // Cortex: the count of a template above the names of all; fewer names than counted; no count.
  for (const char* count : {"1", "7", ""}) {
    const PointRecording points = read(std::string("100\t100\t2\t") + count + "\tmm\t100\t1\t2", names, rows);
    EXPECT_EQ(NamesOf(points), (std::vector<std::string>{"a", "b"})) << count;
    EXPECT_EQ(points.warnings.size(), 1u) << count;
    EXPECT_EQ(points.points[1].positions[1], Eigen::Vector3d(4, 5, 6));
  }
  // A marker without a name between two that have one.
  const PointRecording gap = read(values, "a\t\t\t\t\t\tc\t\t", "1\t0\t1\t2\t3\t4\t5\t6\t7\t8\t9\n");
  EXPECT_EQ(gap.Find("c")->positions[0], Eigen::Vector3d(7, 8, 9));
  // A word among the numbers, a row without a time, one that goes back, one that is cut off.
  const PointRecording odd =
      read(values, names,
           rows + "3\t\t1\t2\t3\t4\t5\t6\n4\t0.03\tx\t2\t3\t4\t5\t6\n5\t0.02\t1\t2\t3\t4\t5\t6\n6\t0.05\t1\t2\t3\t4");
  EXPECT_EQ(odd.time_s, (std::vector<double>{0, 0.01, 0.02, 0.03}));  // the third row's time follows from the rate
  EXPECT_FALSE(odd.points[0].positions[3].allFinite());
  EXPECT_TRUE(odd.points[1].positions[3].allFinite());
  EXPECT_THAT(odd.warnings,
              testing::IsSupersetOf({HasSubstr("a.trc:9: 'x': a cell that is not a finite number is left out"),
                                     HasSubstr("a.trc:10: a row whose time does not follow the one before is left out"),
                                     HasSubstr("a.trc:11: the last row, which is cut off, is left out")}));
  EXPECT_THAT(Refusal("a.trc", Trc(values, names, "")), HasSubstr("no row with a time"));
  EXPECT_THAT(Refusal("a.trc", Trc("100\t100\t2\t2\tfurlong\t100\t1\t2", names, rows)),
              AllOf(HasSubstr("a.trc:3"), HasSubstr("'furlong'"), HasSubstr("write mm, cm or m")));
}

TEST_F(OddFiles, UnitsInAnyCaseAndNumber) {
  for (const auto& [unit, mm] : {std::pair{"m", 1000.0},
                                 {"M", 1000.0},
                                 {"meters", 1000.0},
                                 {"Metres", 1000.0},
                                 {"MM", 1.0},
                                 {"Millimeters", 1.0},
                                 {"Cm", 10.0},
                                 {"centimetre", 10.0},
                                 {"in", 25.4}})
    EXPECT_EQ(exchange::FindMmPerUnit(unit), mm) << unit;
  EXPECT_FALSE(exchange::FindMmPerUnit("deg"));
  EXPECT_FALSE(exchange::FindMmPerUnit(""));
}

TEST_F(OddFiles, MotiveReadsMeasuredMarkersAndNamesWhatItLeavesOut) {
  const std::string head =
      "Format Version,1.23,Take Name,Take 1,Capture Frame Rate,120.000000,Length Units,Meters,Coordinate Space,Global\n"
      "\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker,Marker,Marker,Marker\n"
      ",Name,Shank,Shank,Shank,Leg:ankle,Leg:ankle,Leg:ankle,\"Leg:knee\",\"Leg:knee\",\"Leg:knee\"\n"
      ",ID,1,1,1,2,2,2,3,3,3\n"
      ",,Position,Position,Position,Position,Position,Position,Position,Position,Position\n"
      "Frame,Time (Seconds),X,Y,Z,X,Y,Z,X,Y,Z\n";
  const PointRecording points =
      Read("a.csv", head + "0,0.000000,9,9,9,0.1,0.2,0.3,0.4,0.5,0.6\n1,0.008333,9,9,9,,,,0.4,0.5,0.7\n");
  EXPECT_EQ(NamesOf(points), (std::vector<std::string>{"Leg:ankle", "Leg:knee"}));
  EXPECT_EQ(points.space, exchange::PointSpace::kSpace);
  EXPECT_EQ(points.up_axis, 'y');
  EXPECT_LT((points.points[0].positions[0] - Eigen::Vector3d(100, 200, 300)).norm(), 1e-9);
  EXPECT_FALSE(points.points[0].positions[1].allFinite());
  EXPECT_LT((points.points[1].positions[1] - Eigen::Vector3d(400, 500, 700)).norm(), 1e-9);
  EXPECT_EQ(points.time_s[1], 0.008333);
  EXPECT_THAT(points.warnings, ElementsAre(HasSubstr("columns of Rigid Body are left out")));
  EXPECT_THAT(Refusal("a.csv", "Format Version,1.23,Length Units,Meters\n"), HasSubstr("export it with its header"));
}

TEST_F(OddFiles, SleapAndDeepLabCutOfSeveralAnimals) {
  const PointRecording one = Read("a.csv",
                                  "track,frame_idx,instance.score,knee.x,knee.y,knee.score\n"
                                  ",0,0.9,10.5,20,0.8\n,2,0.9,11,21,0.7\n",
                                  {.rate_hz = 10});
  EXPECT_EQ(NamesOf(one), (std::vector<std::string>{"knee"}));
  EXPECT_EQ(one.time_s, (std::vector<double>{0, 0.1, 0.2}));
  EXPECT_FALSE(one.points[0].positions[1].allFinite());
  EXPECT_EQ(one.points[0].positions[2], Eigen::Vector3d(11, 21, 0));
  const PointRecording animals = Read("b.csv",
                                      "scorer,S,S,S,S,S,S\nindividuals,A,A,A,B,B,B\n"
                                      "bodyparts,knee,knee,knee,knee,knee,knee\n"
                                      "coords,x,y,likelihood,x,y,likelihood\n0,1,2,0.99,3,4,0.1\n",
                                      {.rate_hz = 10});
  EXPECT_EQ(animals.Find("A_knee")->positions[0], Eigen::Vector3d(1, 2, 0));
  EXPECT_FALSE(animals.Find("B_knee")->positions[0].allFinite());
  EXPECT_THAT(animals.warnings, ElementsAre(HasSubstr("likelihood is below 0.6 is left out")));
}

// SLEAP's score is a likelihood; who is labelled by hand has none.
TEST_F(OddFiles, SleapsPointOfALowScoreIsAGap) {
  const PointRecording points = Read("a.csv",
                                     "track,frame_idx,instance.score,knee.x,knee.y,knee.score\n"
                                     "A,0,0.9,1,2,0.8\nA,1,0.9,3,4,0.02\nA,2,,5,6,\n",
                                     {.rate_hz = 10});
  EXPECT_TRUE(points.points[0].positions[0].allFinite());
  EXPECT_FALSE(points.points[0].positions[1].allFinite());
  EXPECT_EQ(points.points[0].positions[2], Eigen::Vector3d(5, 6, 0));
  EXPECT_THAT(points.warnings, ElementsAre(HasSubstr("a.csv:3: a point whose likelihood is below 0.2 is left out")));
}

// Triangulated points are not positions in a picture.
TEST_F(OddFiles, DeepLabCutInSpaceIsNoPicture) {
  EXPECT_THAT(Refusal("a.csv", "scorer,S,S,S\nbodyparts,knee,knee,knee\ncoords,x,y,z\n0,1,2,3\n", {.rate_hz = 10}),
              AllOf(HasSubstr("points in space"), HasSubstr("TRC")));
}

TEST_F(OddFiles, DltdvsSparseTableAndOneOfItsCameras) {
  // Rows, columns and values; a row of zero says how large the whole is.
  const PointRecording sparse = Read(
      "axypts.tsv", "row\tcolumn\tvalue\n5\t4\t0\n1\t1\t11\n1\t2\t21\n3\t1\t12\n3\t2\t22\n3\t3\t31\n", {.rate_hz = 10});
  EXPECT_EQ(sparse.Find("pt1")->positions[0], Eigen::Vector3d(10, 20, 0));
  EXPECT_EQ(sparse.Find("pt1")->positions[2], Eigen::Vector3d(11, 21, 0));
  EXPECT_FALSE(sparse.Find("pt1")->positions[1].allFinite());
  EXPECT_EQ(sparse.time_s.size(), 3u);
  EXPECT_THAT(Refusal("axypts.tsv", "row\tcolumn\tvalue\n1\t1\t11\n1\t2\t21\n", {.rate_hz = 10, .view = "cam2"}),
              AllOf(HasSubstr("--view cam2"), HasSubstr("--map")));
  const std::string two = "pt1_cam1_X,pt1_cam1_Y,pt1_cam2_X,pt1_cam2_Y\n1,2,3,4\n";
  EXPECT_THAT(Read("xypts.csv", two, {.rate_hz = 10}).warnings, testing::Contains(HasSubstr("2 cameras (cam1, cam2)")));
  const PointRecording second = Read("xypts.csv", two, {.rate_hz = 10, .view = "cam2"});
  EXPECT_EQ(NamesOf(second), (std::vector<std::string>{"pt1"}));
  EXPECT_EQ(second.points[0].positions[0], Eigen::Vector3d(2, 3, 0));
  EXPECT_THAT(Refusal("xypts.csv", two, {.rate_hz = 10, .view = "cam3"}), HasSubstr("has the cameras cam1, cam2"));
}

TEST_F(OddFiles, KinoveasTextWithTimecodes) {
  const PointRecording text = Read("a.txt",
                                   "#Kinovea Trajectory data export\n#T X Y\n0:00:01:00 866.00 320.00 \n"
                                   "0:00:01:04 847.00 321.00 \n0:00:01:08 840.00 322.00\nbad\n\n\n");
  EXPECT_EQ(NamesOf(text), (std::vector<std::string>{"track1"}));
  EXPECT_THAT(text.time_s, ElementsAre(1, testing::DoubleNear(1.04, 1e-12), testing::DoubleNear(1.08, 1e-12)));
  EXPECT_THAT(text.warnings, ElementsAre(HasSubstr("a.txt:6: a row with fewer numbers than columns is left out")));
}

TEST_F(OddFiles, KinoveasTextInMilliseconds) {
  const PointRecording text = Read("a.txt", "#Kinovea Trajectory data export\n#T X Y\n0 8 3\n20 9 4\n40 9 5\n");
  EXPECT_THAT(text.time_s, ElementsAre(0, testing::DoubleNear(0.02, 1e-12), testing::DoubleNear(0.04, 1e-12)));
  const PointRecording fine = Read("a.txt", "#Kinovea Trajectory data export\n#T X Y\n0 8 3\n20000 9 4\n40000 9 5\n");
  EXPECT_EQ(fine.time_s, text.time_s);  // microseconds
  EXPECT_TRUE(fine.warnings.empty());
  EXPECT_THAT(Read("a.txt", "#Kinovea Trajectory data export\n#T X Y\n0 8 3\n1 9 4\n2 9 5\n").warnings,
              ElementsAre(HasSubstr("1000 Hz")));  // or frames
}

// A row per animal and frame, one of which is not there.
TEST_F(OddFiles, SleapOfTwoAnimals) {
  WriteFile(folder_ / "a.csv",
            "track,frame_idx,instance.score,l.ankle.x,l.ankle.y,l.ankle.score\n"
            "b,0,0.9,1,2,0.8\na,0,0.9,5,6,0.8\na,1,0.9,,,0\nb,2,0.9,3,4,0.8\n");
  const PointRecording two = ReadPoints(folder_ / "a.csv", {.rate_hz = 50});
  EXPECT_EQ(NamesOf(two), (std::vector<std::string>{"a_l.ankle", "b_l.ankle"}));
  EXPECT_THAT(two.time_s, ElementsAre(0, 0.02, 0.04));
  EXPECT_EQ(two.points[1].positions[2], Eigen::Vector3d(3, 4, 0));
  EXPECT_FALSE(two.points[0].positions[1].allFinite());
  EXPECT_FALSE(two.points[1].positions[1].allFinite());
}

TEST_F(OddFiles, OfOtherProgramsAreCalledWhatTheyAre) {
  EXPECT_THAT(Refusal("a.csv", "alpha,beta\n1,2\n"),
              AllOf(HasSubstr("its first line is 'alpha,beta'"), HasSubstr("DeepLabCut"), HasSubstr("frame,time_s,")));
  EXPECT_THAT(Refusal("a.slp", "x"), AllOf(HasSubstr("a project of SLEAP"), HasSubstr("analysis CSV")));
  EXPECT_THAT(Refusal("a.xyz", "x"), AllOf(HasSubstr("unknown kind of file"), HasSubstr(".trc, .c3d")));
}

TEST_F(OddFiles, MotWhoseCountsAreWrong) {
  const exchange::MotTable table = exchange::ReadMot(Write(
      "a.mot", "q\nversion=1\nnRows=9\nnColumns=5\ninDegrees=yes\nendheader\ntime\tk\n0\t1\n0.1\tx\n0.2\t3\n0.3"));
  EXPECT_EQ(table.time_s, (std::vector<double>{0, 0.1, 0.2}));
  EXPECT_THAT(
      table.warnings,
      ElementsAre(HasSubstr("2 columns, but the header says 5"), HasSubstr("3 rows, but the header says 9"),
                  HasSubstr("a.mot:9: 'x': a cell that is not a finite number"), HasSubstr("a.mot:11: the last row")));
}

TEST_F(OddFiles, C3dThatIsCutOffGivesTheFramesThatAreThere) {
  exchange::WriteC3d(folder_ / "a.c3d", MakePoints(exchange::PointSpace::kSpace, 100, 4, 3));
  const PointRecording whole = ReadPoints(folder_ / "a.c3d");
  const std::string bytes = ReadTextFile(folder_ / "a.c3d");
  const PointRecording part = Read("b.c3d", bytes.substr(0, bytes.size() - 3000));
  EXPECT_THAT(part.warnings, ElementsAre(HasSubstr("is cut off")));
  ASSERT_LT(part.time_s.size(), 100u);
  ASSERT_GT(part.time_s.size(), 40u);
  for (std::size_t p = 0; p < 4; ++p)
    for (std::size_t i = 0; i < part.time_s.size(); ++i)
      EXPECT_TRUE(part.points[p].positions[i] == whole.points[p].positions[i] ||
                  (!part.points[p].positions[i].allFinite() && !whole.points[p].positions[i].allFinite()));
}

// What a model worked out is neither a marker nor in millimetres.
TEST_F(OddFiles, ModelOutputsOfAC3dAreNoMarkers) {
  PointRecording points = MakePoints(exchange::PointSpace::kSpace, 30, 3, 3);
  points.points[1].name = "LKneeAngles";
  points.events.clear();
  exchange::WriteC3d(folder_ / "a.c3d", points);
  const std::string bytes = WithModelOutput(ReadTextFile(folder_ / "a.c3d"), "ANGLES", "LKneeAngles", "deg");
  const PointRecording read = Read("b.c3d", bytes);
  EXPECT_EQ(NamesOf(read), (std::vector<std::string>{"marker 1", "marker 3"}));
  ASSERT_EQ(read.outputs.size(), 1u);
  EXPECT_EQ(read.outputs[0].name, "LKneeAngles");
  EXPECT_EQ(read.outputs[0].kind, "angle");
  EXPECT_EQ(read.outputs[0].unit, "deg");
  EXPECT_LT((read.outputs[0].positions[4] - points.points[1].positions[4]).norm(), 1e-3);
}

}  // namespace
}  // namespace lake
