#include "lake/exchange/trial.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>

#include "exchange/recordings.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/convert.h"
#include "lake/exchange/formats.h"
#include "name_map.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// A leg that bends in the vertical plane at `heading_deg` from x towards the third axis; up is y or z.
exchange::PointRecording BendingLeg(double heading_deg, char up) {
  const double heading_rad = heading_deg / 57.29577951308232;
  exchange::PointRecording points;
  points.up_axis = up;
  points.points = {{"RANK", {}}, {"RKNE", {}}, {"RHIP", {}}, {"RHIP2", {}}};
  for (int i = 0; i < 60; ++i) {
    points.frame.push_back(i);
    points.time_s.push_back(i / 60.0);
    const double bend = 0.02 * i;
    const auto place = [&](double forward, double height, double side) {
      const double a = forward * std::cos(heading_rad) - side * std::sin(heading_rad);
      const double b = forward * std::sin(heading_rad) + side * std::cos(heading_rad);
      return up == 'y' ? Eigen::Vector3d(a, height, b) : Eigen::Vector3d(a, b, height);
    };
    points.points[0].positions.push_back(place(0, 90, 10));
    points.points[1].positions.push_back(place(430 * std::sin(bend / 3), 90 + 430 * std::cos(bend / 3), 25));
    const Eigen::Vector3d hip = place(430 * std::sin(bend / 3) - 410 * std::sin(bend),
                                      90 + 430 * std::cos(bend / 3) + 410 * std::cos(bend), 40);
    points.points[2].positions.push_back(hip);
    points.points[3].positions.push_back(hip + place(0, 20, 0));
  }
  return points;
}

TEST(Trial, TheSagittalPlaneIsFittedToTheLegsMovement) {
  const TemporaryFolder folder;
  for (const char up : {'y', 'z'})
    for (const double heading_deg : {0.0, 35.0, -60.0, 90.0, 170.0}) {
      const exchange::PointRecording points = BendingLeg(heading_deg, up);
      const fs::path file = folder / (up == 'y' ? "a.trc" : "a.c3d");
      exchange::WritePoints(file, points);
      const exchange::Trial trial = exchange::ReadTrial(file, {NameMap("ankle=RANK, knee=RKNE, hip=RHIP"), {}, ""});
      ASSERT_EQ(trial.recording.unit, motion::LengthUnit::kMm);
      const auto vector = [&](const char* from, const char* to, std::size_t i) {
        return Eigen::Vector2d(trial.recording.Find(to)->samples[i].position -
                               trial.recording.Find(from)->samples[i].position);
      };
      for (const std::size_t i : {0u, 30u, 59u}) {
        EXPECT_NEAR(vector("ankle", "knee", i).norm(), 430, 1e-3) << heading_deg;
        EXPECT_NEAR(vector("knee", "hip", i).norm(), 410, 1e-3) << heading_deg;
      }
      EXPECT_LT(trial.out_of_plane_mm, 1e-3);
    }
}

// A conversion to a format of a plane projects as a program that reads the trial does.
TEST(Trial, ConversionTakesThePlaneAcrossTheKneesAxisToo) {
  const TemporaryFolder folder;
  exchange::PointRecording points = BendingLeg(0, 'y');
  constexpr double kYaw_rad = 0.2;
  points.points.push_back({"RKNE_med", points.points[1].positions});
  for (Eigen::Vector3d& p : points.points.back().positions)
    p += 100 * Eigen::Vector3d(std::sin(kYaw_rad), 0, -std::cos(kYaw_rad));
  exchange::WritePoints(folder / "a.trc", points);
  exchange::ConvertOptions options;
  options.reading.names = NameMap("ankle=RANK,knee=RKNE+RKNE_med,hip=RHIP");
  EXPECT_THAT(exchange::ConvertFile(folder / "a.trc", folder / "a.csv", options),
              testing::ElementsAre(testing::HasSubstr("across the knee's axis")));
  const exchange::Trial read = exchange::ReadTrial(folder / "a.trc", options.reading),
                        converted = exchange::ReadTrial(folder / "a.csv");
  const auto thigh = [](const exchange::Trial& trial, std::size_t i) {
    return Eigen::Vector2d(trial.recording.Find("hip")->samples[i].position -
                           trial.recording.Find("knee")->samples[i].position);
  };
  for (const std::size_t i : {0u, 30u, 59u}) EXPECT_LT((thigh(read, i) - thigh(converted, i)).norm(), 1e-3) << i;
  // Seen across the axis the thigh is shorter forward, by the yaw's cosine but for the knee's own offset.
  EXPECT_LT(thigh(read, 59).norm(), 409);
}

TEST(Trial, ForwardAndUpAreTakenAsGiven) {
  const TemporaryFolder folder;
  exchange::PointRecording points = BendingLeg(0, 'z');
  points.up_axis = 'y';  // TRC is y up by custom, this one is not and does not know it
  exchange::WritePoints(folder / "a.trc", points);
  const auto names = NameMap("ankle=RANK,knee=RKNE,hip=RHIP");
  const exchange::Trial right = exchange::ReadTrial(folder / "a.trc", {names, 'z', "+x"}),
                        left = exchange::ReadTrial(folder / "a.trc", {names, 'z', "-x"});
  EXPECT_NEAR(right.recording.Find("ankle")->samples[0].position.y(), 90, 1e-9);
  EXPECT_NEAR(right.recording.Find("knee")->samples[50].position.x(),
              -left.recording.Find("knee")->samples[50].position.x(), 1e-9);
  EXPECT_EQ(right.faces_right, true);
  EXPECT_THROW(exchange::ReadTrial(folder / "a.trc", {names, 'z', "+z"}), UsageError);
  EXPECT_THROW(exchange::ReadTrial(folder / "a.trc", {names, 'z', "north"}), UsageError);
  EXPECT_THROW(exchange::ReadTrial(folder / "a.trc", {names, 'w', ""}), UsageError);
}

TEST(Trial, NamesAreMappedAndMiddlesTaken) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "a.trc", BendingLeg(0, 'y'));
  const exchange::Trial trial =
      exchange::ReadTrial(folder / "a.trc", {NameMap("ankle=RANK,knee=RKNE,hip=RHIP+RHIP2"), {}, "x"});
  ASSERT_EQ(trial.recording.markers.size(), 3u);
  EXPECT_NEAR(trial.recording.Find("hip")->samples[0].position.y(), 90 + 430 + 410 + 10, 1e-9);
  EXPECT_EQ(trial.leg, motion::Side::kRight);
  EXPECT_THAT(MessageOf([&] {
                exchange::ReadTrial(folder / "a.trc", {NameMap("ankle=LANK"), {}, "x"});
              }),
              testing::AllOf(testing::HasSubstr("'LANK' (for ankle)"), testing::HasSubstr("RANK, RKNE, RHIP")));
  EXPECT_THROW(NameMap("ankle"), UsageError);
  EXPECT_THROW(NameMap("ankle=A,ankle=B"), UsageError);
}

TEST(Trial, OwnTablesKeepSigmasAndFoldersAreUnderstood) {
  const TemporaryFolder folder;
  motion::MarkerRecording markers{motion::LengthUnit::kMm, {0, 1}, {0, 0.02}, {}};
  markers.markers = {
      {"k", {{{1, 2}, 0.3, motion::SampleStatus::kDetected}, {{4, 5}, 0.6, motion::SampleStatus::kFilled}}}};
  fs::create_directory(folder / "trial");
  motion::WriteMarkerCsv(folder / "trial" / "trajectory.csv", markers);
  const exchange::Trial trial = exchange::ReadTrial(folder / "trial", {NameMap("knee=k"), {}, ""});
  EXPECT_EQ(trial.file.filename(), "trajectory.csv");
  EXPECT_EQ(trial.recording.Find("knee")->samples[1].status, motion::SampleStatus::kFilled);
  EXPECT_EQ(trial.recording.Find("knee")->samples[0].sigma, 0.3);
  EXPECT_THROW(exchange::ReadTrial(folder.Path()), Error);
}

TEST(Trial, MarkersOfOwnTablesAreExchangedReplacedAndHalvedByTheirNames) {
  const TemporaryFolder folder;
  motion::MarkerRecording markers{motion::LengthUnit::kMm, {0, 1}, {0, 0.02}, {}};
  const auto seen = motion::SampleStatus::kDetected;
  markers.markers = {{"knee", {{{1, 2}, 0.3, seen}, {{1, 2}, 0.3, seen}}},
                     {"hip", {{{5, 8}, 0.4, seen}, {}}},
                     {"exo_knee", {{{7, 7}, 0.1, seen}, {{7, 7}, 0.1, seen}}}};
  motion::WriteMarkerCsv(folder / "t.csv", markers);
  const auto read = [&](const char* map) {
    return exchange::ReadTrial(folder / "t.csv", {NameMap(map), {}, ""}).recording;
  };
  const motion::MarkerRecording swapped = read("knee=hip,hip=knee");
  EXPECT_EQ(swapped.Find("knee")->samples[0].position.x(), 5);
  EXPECT_EQ(swapped.Find("hip")->samples[0].position.x(), 1);
  EXPECT_EQ(swapped.Find("exo_knee")->samples[0].position.x(), 7);

  const motion::MarkerRecording replaced = read("knee=exo_knee");
  EXPECT_EQ(replaced.Find("knee")->samples[0].position.x(), 7);
  EXPECT_EQ(replaced.markers.size(), 2u);

  const motion::MarkerRecording halved = read("waist=knee+hip");
  EXPECT_EQ(halved.Find("waist")->samples[0].position, Eigen::Vector2d(3, 5));
  EXPECT_DOUBLE_EQ(halved.Find("waist")->samples[0].sigma, 0.25);
  EXPECT_FALSE(halved.Find("waist")->samples[1].IsKnown()) << "the hip is not seen";
  EXPECT_TRUE(halved.Find("knee") && halved.Find("hip"));
}

// What is asked for and has no effect is told, not passed over.
TEST(Trial, OptionsThatSayNothingOfAFileAreNamed) {
  const TemporaryFolder folder;
  const exchange::PointRecording plane = MakePoints(exchange::PointSpace::kPlane, 20, 2, 3);
  fs::create_directory(folder / "own");
  for (const char* name : {"own/trajectory.csv", "a.trc", "a.txt", "a_kinovea.csv"})
    exchange::WritePoints(folder / name, plane);
  std::ofstream(folder / "dltdv.csv") << "pt1_cam1_X,pt1_cam1_Y\n1,2\n3,4\n";
  exchange::TrialOptions all;
  all.up = 'z';
  all.mm_per_unit = 1000;
  all.rate_hz = 60;
  all.values = motion::MarkerValues::kEstimated;
  const auto unused = [&](const char* name) {
    std::vector<std::string> options;
    for (const exchange::UnusedOption& one : exchange::UnusedOptions(folder / name, all)) options.push_back(one.option);
    return options;
  };
  using testing::ElementsAre;
  EXPECT_THAT(unused("own"), ElementsAre("--unit", "--up", "--rate"));
  EXPECT_THAT(unused("own/trajectory.csv"), ElementsAre("--unit", "--up", "--rate"));
  EXPECT_THAT(unused("a.trc"), ElementsAre("--unit", "--rate", "--smoothed"));
  EXPECT_THAT(unused("a.txt"), ElementsAre("--up", "--rate", "--smoothed"));
  EXPECT_THAT(unused("a_kinovea.csv"), ElementsAre("--up", "--rate", "--smoothed"));
  EXPECT_THAT(unused("dltdv.csv"), ElementsAre("--unit", "--up", "--smoothed"));
  EXPECT_THAT(unused("none.csv"), ElementsAre()) << "that it is absent is said by who reads it";
  EXPECT_THAT(exchange::UnusedOptions(folder / "a.trc", {}), ElementsAre());
  const auto refuse = [&] { exchange::CheckNoneIsUnused("own", exchange::UnusedOptions(folder / "own", all)); };
  EXPECT_THAT(MessageOf(refuse), testing::HasSubstr("--unit has no effect on own: it is in mm or px"));
  EXPECT_THROW(refuse(), UsageError);
  EXPECT_NO_THROW(exchange::CheckNoneIsUnused("own", {}));
}

// Any direction would do as well as another.
TEST(Trial, ALegThatStandsStillHasNoSagittalPlane) {
  const TemporaryFolder folder;
  exchange::PointRecording still = BendingLeg(30, 'z');
  for (exchange::PointTrack& point : still.points)
    std::fill(point.positions.begin(), point.positions.end(), Eigen::Vector3d(point.positions[20]));
  exchange::WriteC3d(folder / "still.c3d", still);
  exchange::TrialOptions options;
  options.names = NameMap("ankle=RANK,knee=RKNE,hip=RHIP");
  EXPECT_THAT(MessageOf([&] { exchange::ReadTrial(folder / "still.c3d", options); }),
              testing::HasSubstr("still.c3d: the leg does not move; give the sagittal plane with --forward"));
  options.forward = "+x";
  EXPECT_NO_THROW(exchange::ReadTrial(folder / "still.c3d", options));
}

TEST(Trial, MarkersAndDirectionsThatAreNotThereAreTold) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "trajectory.csv", MakePoints(exchange::PointSpace::kPlane, 9, 2, 1));
  const auto message = [&](const exchange::TrialOptions& options) {
    return MessageOf([&] { exchange::ReadTrial(folder / "trajectory.csv", options); });
  };
  exchange::TrialOptions options;
  options.names = {{"knee", "marker 9"}};
  EXPECT_THAT(
      message(options),
      testing::HasSubstr("no marker 'marker 9' (for knee); did you mean 'marker 1'?; it has: marker 1, marker 2"));
  for (const auto& [forward, said] :
       {std::pair{"+y", "in a plane it is +x or -x"}, {"+xy", "x, y or z with a sign"}, {"-w", "axis 'w'"}}) {
    options = {};
    options.forward = forward;
    EXPECT_THAT(message(options), testing::HasSubstr(said));
  }
}

TEST(Trial, FormatsRefuseWhatTheyCannotHold) {
  const TemporaryFolder folder;
  const auto refused = [&](const char* file, exchange::PointRecording points, std::size_t frames = 9) {
    points.frame.resize(frames);
    points.time_s.resize(frames);
    return MessageOf([&] { exchange::WritePoints(folder / file, points); });
  };
  const exchange::PointRecording space = MakePoints(exchange::PointSpace::kSpace, 9, 2, 1),
                                 plane = MakePoints(exchange::PointSpace::kPlane, 9, 2, 1),
                                 image = MakePoints(exchange::PointSpace::kImage, 9, 2, 1);
  EXPECT_THAT(refused("a.csv", space), testing::HasSubstr("holds points of a plane only"));
  EXPECT_THAT(refused("a.c3d", image),
              testing::HasSubstr("in px: give --scale, or a --camera with the sagittal plane"));
  EXPECT_THAT(refused("a.kva", plane), testing::HasSubstr("holds px of a video, not mm"));
  EXPECT_THAT(refused("a.trk", plane), testing::HasSubstr("holds px of a video, not mm"));
  EXPECT_THAT(refused("a.kva", image, 1), testing::HasSubstr("two frames"));
  EXPECT_THAT(refused("a.trk", image, 1), testing::HasSubstr("two frames"));
  exchange::PointRecording none = space;
  none.points.clear();
  EXPECT_THAT(refused("a.c3d", none), testing::HasSubstr("C3D holds 1 to 65535 points, not 0"));
  EXPECT_THAT(MessageOf([] { exchange::CheckExportFormats({"trc"}, false, true); }),
              testing::HasSubstr("--export trc: holds lengths, not px"));

  exchange::WritePoints(folder / "tracks.csv", image);
  EXPECT_THAT(MessageOf([&] { exchange::ReadTable(folder / "tracks.csv", motion::MarkerValues::kEstimated); }),
              testing::HasSubstr("no fit's estimates (--smoothed)"));
}

TEST(Trial, AbsentFilesAreErrors) {
  const TemporaryFolder folder;
  for (const char* name : {"none.trc", "none.csv"}) EXPECT_THROW(exchange::ReadTrial(folder / name), Error) << name;
}

TEST(Trial, ExportsOfEveryFormatReadBack) {
  const TemporaryFolder folder;
  motion::MarkerRecording markers;
  markers.unit = motion::LengthUnit::kMm;
  markers.markers = {{"knee", {}}};
  for (int i = 0; i < 20; ++i) {
    markers.frame.push_back(i);
    markers.time_s.push_back(i / 60.0);
    markers.markers[0].samples.push_back(
        {{100.0 + i, 50.5}, 0.1, i == 7 ? motion::SampleStatus::kMissing : motion::SampleStatus::kDetected});
  }
  motion::LegMotion motion;
  motion.frame = {0};
  motion.time_s = {0};
  motion.samples.resize(1);
  motion.samples[0].knee_deg = 30;
  motion::MarkerRecording image = markers;
  image.unit = motion::LengthUnit::kPx;
  const exchange::ExportedTrial trial{exchange::PointsFromMarkers(markers), exchange::PointsFromMarkers(image),
                                      &motion};
  std::vector<fs::path> files;
  for (const std::string& format : exchange::ExportFormats()) {
    files.push_back(folder / exchange::ExportName(format, "a"));
    exchange::ExportTrial(format, files.back(), trial);
  }
  ASSERT_EQ(files.size(), 7u);
  EXPECT_EQ(files.front().filename(), "a.mot");
  for (std::size_t k = 1; k < 7; ++k) {
    const exchange::PointRecording read = exchange::ReadPoints(files[k]);
    EXPECT_EQ(read.space == exchange::PointSpace::kImage,
              files[k].extension() == ".trk" || files[k].extension() == ".kva");
    EXPECT_NEAR(read.Find("knee")->positions[9].x(), 109, 1e-4) << files[k];
    EXPECT_FALSE(read.Find("knee")->positions[7].allFinite()) << files[k];
    EXPECT_NEAR(read.time_s[9], 9 / 60.0, 1e-6) << files[k];
  }
  EXPECT_THROW(exchange::ExportTrial("fbx", folder / "a.fbx", trial), UsageError);
  EXPECT_THROW(exchange::ExportTrial("mot", folder / "a.mot", {trial.points, trial.image, nullptr}), Error);
}

TEST(Trial, TrackerProjectsHoldPixelsAndAScale) {
  const fs::path file = SharedData() / "tracker_balltoss/BallToss_BallToss.trk";
  if (!fs::exists(file)) GTEST_SKIP() << file.string() << " is not here";
  const exchange::PointRecording points = exchange::ReadPoints(file);
  ASSERT_EQ(points.points.size(), 1u);
  const auto& ball = points.points[0].positions;
  ASSERT_EQ(ball.size(), 13u);
  EXPECT_FALSE(ball[1].allFinite());
  EXPECT_NEAR(ball[2].x(), 131.2767 - 0.5, 1e-3);  // Tracker's pixel centres are at 0.5
  EXPECT_NEAR(points.time_s[2], 0.132, 1e-9);
  ASSERT_TRUE(points.mm_per_px);
  // Free fall: a parabola through the height gives the acceleration of ../shared/data/README.md.
  // The axes are tilted by 0.044° only.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < ball.size(); ++i) {
    const Eigen::Vector3d row(1, points.time_s[i], points.time_s[i] * points.time_s[i]);
    normal += row * row.transpose();
    right += row * ball[i].y();
  }
  EXPECT_NEAR(2 * normal.inverse().row(2).dot(right) * *points.mm_per_px / 1000, 10.27, 0.1);
}

TEST(Trial, TrackerProjectsThatAreDamagedAreErrors) {
  const TemporaryFolder folder;
  for (const char* text : {"", "<object", "<object class='x'/>", "<object class='TrackerPanel'/>",
                           "<object class='TrackerPanel'><property name='clipcontrol'><object><property "
                           "name='delta_t'>x</property></object>"
                           "</property></object>"}) {
    std::ofstream(folder / "a.trk") << text;
    EXPECT_THROW(exchange::ReadPoints(folder / "a.trk"), Error) << text;
  }
}

TEST(Trial, ASummaryWhoseVerticalIsNoUnitVectorIsNamed) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "trajectory.csv", MakePoints(exchange::PointSpace::kPlane, 9, 3, 1));
  for (const char* up : {"[0, 1]", "[0, 2]", "[0]", "[\"0\", 1]", "5", "{}", "null"}) {
    WriteTextFile(folder / "summary.json", fmt::format("{{\"up_in_plane\": {}}}", up));
    const auto read = [&] { exchange::ReadTrial(folder / "trajectory.csv"); };
    if (up == std::string("[0, 1]"))
      EXPECT_NO_THROW(read());
    else
      EXPECT_THAT(read, testing::ThrowsMessage<Error>(testing::HasSubstr("summary.json: 'up_in_plane' is no unit")));
  }
}

TEST(Trial, ASummarySaysWhatIsKnownOfMeasuredSigmas) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "trajectory.csv", MakePoints(exchange::PointSpace::kPlane, 9, 3, 1));
  const auto read = [&](const char* fit, motion::MarkerValues values) {
    WriteTextFile(folder / "summary.json", fmt::format("{{\"fit\": {}}}", fit));
    exchange::TrialOptions options;
    options.values = values;
    return exchange::ReadTrial(folder / "trajectory.csv", options);
  };
  constexpr const char* kBoth = R"({"known_sigmas": true, "lasting_share": 0.7})";
  const exchange::Trial measured = read(kBoth, motion::MarkerValues::kMeasured);
  EXPECT_TRUE(measured.known_sigmas);
  EXPECT_EQ(measured.lasting_share, 0.7);
  const exchange::Trial estimated = read(kBoth, motion::MarkerValues::kEstimated);
  EXPECT_FALSE(estimated.known_sigmas);
  EXPECT_EQ(estimated.lasting_share, 0);
  EXPECT_EQ(read(R"({"known_sigmas": true})", motion::MarkerValues::kMeasured).lasting_share, 0);
  for (const char* share : {"-0.1", "1.1", "\"0.7\"", "null"})
    EXPECT_THAT([&] { read(fmt::format("{{\"lasting_share\": {}}}", share).c_str(), motion::MarkerValues::kMeasured); },
                testing::ThrowsMessage<Error>(testing::HasSubstr("summary.json: 'lasting_share' is not 0 to 1")));
}

}  // namespace
}  // namespace lake
