// What `lake convert` does, through every option.
#include "lake/exchange/convert.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/mot.h"
#include "name_map.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// z up: a laboratory's axes.
exchange::PointRecording Laboratory() {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 60, 4, 21);
  points.up_axis = 'z';
  points.events.clear();
  const char* names[] = {"RANK", "RKNE", "RHIP", "RASI"};
  for (std::size_t i = 0; i < 4; ++i) points.points[i].name = names[i];
  return points;
}

TEST(Convert, AZUpC3dBecomesAYUpTrc) {
  const TemporaryFolder folder;
  const exchange::PointRecording lab = Laboratory();
  exchange::WriteC3d(folder / "a.C3D", lab);  // laboratories write endings in capitals
  WriteTextFile(folder / "cut.c3d", ReadTextFile(folder / "a.C3D").substr(0, 300));
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(folder / "cut.c3d"); }), testing::HasSubstr("cut off"));
  EXPECT_TRUE(exchange::ConvertFile(folder / "a.C3D", folder / "a.trc", {}).empty());
  const exchange::PointRecording trc = exchange::ReadPoints(folder / "a.trc");
  for (std::size_t i = 0; i < lab.time_s.size(); ++i) {
    const Eigen::Vector3d &from = lab.points[1].positions[i], &to = trc.points[1].positions[i];
    EXPECT_LT((Eigen::Vector3d(from.x(), from.z(), -from.y()) - to).norm(), 1e-3);
  }
}

TEST(Convert, TurningUpIsARotation) {
  for (const char from : {'x', 'y', 'z'})
    for (const char to : {'x', 'y', 'z'}) {
      exchange::PointRecording axes;
      axes.up_axis = from;
      axes.points.push_back({"p", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
      const auto p = exchange::PointsTurnedUp(axes, to).points[0].positions;
      EXPECT_NEAR(p[0].cross(p[1]).dot(p[2]), 1, 1e-12) << from << to;
      EXPECT_EQ(p[static_cast<std::size_t>(from - 'x')], Eigen::Vector3d::Unit(to - 'x')) << from << to;
    }
}

TEST(Convert, ForwardGivesTheAxesOfAModel) {
  const TemporaryFolder folder;
  const exchange::PointRecording lab = Laboratory();
  exchange::WriteC3d(folder / "a.c3d", lab);
  exchange::ConvertOptions options;
  options.reading.forward = "-y";
  options.reading.names = NameMap("knee=RKNE,pelvis=RHIP+RASI");
  options.unit = "m";
  exchange::ConvertFile(folder / "a.c3d", folder / "a.trc", options);
  EXPECT_THAT(ReadTextFile(folder / "a.trc"), testing::HasSubstr("\tm\t"));
  const exchange::PointRecording trc = exchange::ReadPoints(folder / "a.trc");
  ASSERT_EQ(trc.points.size(), 2u);
  const Eigen::Vector3d &from = lab.points[1].positions[0], &to = trc.Find("knee")->positions[0];
  // x forward (−y), y up (z), z to the right of someone who looks along −y with z up: −x.
  EXPECT_LT((Eigen::Vector3d(-from.y(), from.z(), -from.x()) - to).norm(), 1e-3);
}

TEST(Convert, FormatsOfAPlaneGetAProjectionThatIsToldOf) {
  const TemporaryFolder folder;
  exchange::WriteC3d(folder / "a.c3d", Laboratory());
  exchange::ConvertOptions options;
  options.reading.forward = "+x";
  const auto warnings = exchange::ConvertFile(folder / "a.c3d", folder / "a.csv", options);
  EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("projected")));
  EXPECT_NEAR(exchange::ReadPoints(folder / "a.csv").points[1].positions[0].y(),
              Laboratory().points[1].positions[0].z(), 1e-3);
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "a.c3d", folder / "b.csv", {}); }),
              testing::HasSubstr("--map"));
  EXPECT_FALSE(fs::exists(folder / "b.csv"));
}

TEST(Convert, PixelsWithAScaleBecomeMillimetresWhereNeeded) {
  const TemporaryFolder folder;
  exchange::PointRecording image = MakePoints(exchange::PointSpace::kImage, 20, 2, 3);
  exchange::WritePoints(folder / "no_scale.trk", image);
  image.mm_per_px = 2;
  exchange::WritePoints(folder / "a.trk", image);
  exchange::ConvertFile(folder / "a.trk", folder / "a.trc", {});
  const Eigen::Vector3d &px = image.points[0].positions[0],
                        mm = exchange::ReadPoints(folder / "a.trc").points[0].positions[0];
  EXPECT_LT((Eigen::Vector3d(2 * px.x(), -2 * px.y(), 0) - mm).norm(), 1e-6);
  exchange::ConvertFile(folder / "a.trk", folder / "a.kva", {});  // stays px
  EXPECT_LT((exchange::ReadPoints(folder / "a.kva").points[0].positions[0] - px).norm(), 1e-9);
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "no_scale.trk", folder / "b.trc", {}); }),
              testing::HasSubstr("scale"));
}

// As lake track has them: a bar's scale, or a camera with its plane.
TEST(Convert, PixelsAreScaledByABarOrACamera) {
  const TemporaryFolder folder;
  exchange::PointRecording image = MakePoints(exchange::PointSpace::kImage, 20, 2, 3);
  for (exchange::PointTrack& point : image.points)
    for (Eigen::Vector3d& p : point.positions) p = Eigen::Vector3d(640, 360, 0) + p / 5;
  exchange::WritePoints(folder / "tracks.csv", image);
  const Eigen::Vector2d px = image.points[0].positions[0].head<2>();
  const auto first = [&](const exchange::ConvertOptions& options) {
    exchange::ConvertFile(folder / "tracks.csv", folder / "a.trc", options);
    return Eigen::Vector2d(exchange::ReadPoints(folder / "a.trc").points[0].positions[0].head<2>());
  };
  exchange::ConvertOptions bar;
  bar.picture.scale = {10, 20, 110, 20, 250};
  EXPECT_LT((first(bar) - 2.5 * Eigen::Vector2d(px.x(), -px.y())).norm(), 1e-4);  // TRC's digits
  exchange::ConvertFile(folder / "tracks.csv", folder / "a.kva", bar);
  EXPECT_NEAR(*exchange::ReadPoints(folder / "a.kva").mm_per_px, 2.5, 1e-6);
  EXPECT_LT((exchange::ReadPoints(folder / "a.kva").points[0].positions[0].head<2>() - px).norm(), 1e-9);

  camera::CameraProfile profile{{1280, 720, 1000, 1000, 640, 360, {}}, camera::PlanePose::Identity(), {}, {}};
  profile.camera_from_plane->linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  profile.camera_from_plane->translation() = Eigen::Vector3d(0, 0, 3000);  // 3 mm for 1 px
  camera::WriteCameraProfile(folder / "camera.yaml", profile);
  exchange::ConvertOptions camera;
  camera.picture.camera = folder / "camera.yaml";
  EXPECT_LT((first(camera) - 3 * Eigen::Vector2d(px.x() - 640, 360 - px.y())).norm(), 1e-4);
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "tracks.csv", folder / "b.kva", camera); }),
              testing::HasSubstr("--camera has no effect"));
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "a.trc", folder / "b.csv", bar); }),
              testing::HasSubstr("--scale has no effect"));
  image.points[1].positions[4].x() = 1300;
  exchange::WritePoints(folder / "tracks.csv", image);
  EXPECT_THAT(MessageOf([&] { first(camera); }), testing::HasSubstr("calibrated with pictures of 1280x720 px"));
}

TEST(Convert, OptionsWithoutAnEffectAreRefused) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "a.txt", MakePoints(exchange::PointSpace::kPlane, 20, 2, 3));
  const auto converted = [&](const auto& change, const char* out = "b.csv") {
    exchange::ConvertOptions options;
    change(options.reading);
    exchange::ConvertFile(folder / "a.txt", folder / out, options);
  };
  EXPECT_THROW(converted([](auto& reading) { reading.rate_hz = 60; }), UsageError);
  EXPECT_THROW(converted([](auto& reading) { reading.up = 'z'; }), UsageError);
  EXPECT_THROW(converted([](auto& reading) { reading.forward = "+x"; }), UsageError) << "there is nothing to turn";
  EXPECT_FALSE(fs::exists(folder / "b.csv"));
  EXPECT_NO_THROW(converted([](auto& reading) { reading.mm_per_unit = 10; }));

  exchange::MotTable angles;
  angles.time_s = {0, 1};
  angles.columns = {"knee"};
  angles.rows = {{1}, {2}};
  exchange::WriteMot(folder / "a.mot", angles);
  exchange::ConvertOptions options;
  options.reading.mm_per_unit = 10;
  EXPECT_THROW(exchange::ConvertFile(folder / "a.mot", folder / "b.mot", options), UsageError);
}

TEST(Convert, CropKeepsTheTimesAskedFor) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "a.trc", MakePoints(exchange::PointSpace::kPlane, 120, 2, 3));  // 120 Hz
  exchange::ConvertOptions options;
  options.crop_s = {0.25, 0.5};
  options.reading.forward = "+x";
  exchange::ConvertFile(folder / "a.trc", folder / "b.csv", options);
  const exchange::PointRecording cropped = exchange::ReadPoints(folder / "b.csv");
  EXPECT_EQ(cropped.time_s.front(), 0.25);
  EXPECT_EQ(cropped.time_s.back(), 0.5);
  EXPECT_EQ(cropped.frame.front(), 30);  // numbers of the whole recording
  EXPECT_EQ(cropped.points[1].positions.size(), 31u);
  options.reading.forward = "";
  exchange::ConvertFile(folder / "a.trc", folder / "b.c3d", options);
  EXPECT_NEAR(exchange::ReadC3d(folder / "b.c3d").time_s.front(), 0.25, 1e-9);  // by the number of its first frame
  // Events are cropped too, and lost, with a warning, where the format has none.
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kSpace, 120, 2, 3);
  points.events = {{0.2, "", "early"}, {0.3, "", "within"}, {0.6, "", "late"}};
  exchange::WriteC3d(folder / "events.c3d", points);
  EXPECT_THAT(exchange::ConvertFile(folder / "events.c3d", folder / "d.c3d", options), testing::IsEmpty());
  const std::vector<exchange::PointEvent> events = exchange::ReadC3d(folder / "d.c3d").events;
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].label, "within");
  EXPECT_NEAR(events[0].time_s, 0.3, 1e-6);
  EXPECT_THAT(exchange::ConvertFile(folder / "events.c3d", folder / "d.trc", options),
              testing::ElementsAre(testing::HasSubstr("events are left out")));
  options.crop_s = {7, 8};
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "a.trc", folder / "c.csv", options); }),
              testing::HasSubstr("lasts from 0"));
}

TEST(Convert, PixelsAreToldFromLengths) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "tracks.csv", MakePoints(exchange::PointSpace::kImage, 5, 2, 3));
  EXPECT_THAT(exchange::ConvertFile(folder / "tracks.csv", folder / "a.txt", {}),
              testing::ElementsAre(testing::HasSubstr("a.txt: in px from the picture's top-left corner, y up")));
  EXPECT_THAT(exchange::ConvertFile(folder / "tracks.csv", folder / "a.kva", {}), testing::IsEmpty());
  // A project over a video needs the positions in its frames.
  std::filesystem::create_directory(folder / "trial");
  exchange::WritePoints(folder / "trial/trajectory.csv", MakePoints(exchange::PointSpace::kPlane, 5, 2, 3));
  EXPECT_THAT(MessageOf([&] { exchange::ConvertFile(folder / "trial", folder / "b.trk", {}); }),
              testing::HasSubstr("has no tracks.csv, and b.trk holds positions in px"));
}

TEST(Convert, SaysThatAFoldersTablesAreAProjection) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "trial");
  exchange::WritePoints(folder / "trial/trajectory.csv", MakePoints(exchange::PointSpace::kPlane, 5, 2, 3));
  WriteTextFile(folder / "trial/summary.json", "{}");
  EXPECT_THAT(exchange::ConvertFile(folder / "trial", folder / "a.c3d", {}), testing::IsEmpty());
  WriteTextFile(folder / "trial/summary.json", R"({"across_plane": {"rms_mm": 20}})");
  EXPECT_THAT(exchange::ConvertFile(folder / "trial", folder / "a.c3d", {}),
              testing::ElementsAre(testing::HasSubstr("projection")));
}

// By the option, by what the program that wrote the folder found; nobody guesses.
TEST(Convert, TheKneeAngleIsNamedAfterItsLeg) {
  const TemporaryFolder folder;
  motion::LegMotion motion;
  motion.frame = {0};
  motion.time_s = {0};
  motion.samples.resize(1);
  motion.samples[0].knee_deg = 10;
  motion::WriteKinematicsCsv(folder / "kinematics.csv", motion);
  const auto column = [&](const exchange::ConvertOptions& options) {
    exchange::ConvertFile(folder.Path(), folder / "a.mot", options);
    return exchange::ReadMot(folder / "a.mot").columns.front();
  };
  EXPECT_THAT(MessageOf([&] { column({}); }), testing::HasSubstr("left or the right leg: give --leg"));
  WriteTextFile(folder / "summary.json", R"({"leg": "left"})");
  EXPECT_EQ(column({}), "knee_angle_l");
  exchange::ConvertOptions right;
  right.leg = motion::Side::kRight;
  EXPECT_EQ(column(right), "knee_angle_r");
}

TEST(Convert, AnglesGoToMotAndNowhereElse) {
  const TemporaryFolder folder;
  motion::LegMotion motion;
  for (int i = 0; i < 5; ++i) {
    motion.frame.push_back(i);
    motion.time_s.push_back(0.1 * i);
    motion.samples.emplace_back();
    motion.samples.back().knee_deg = 10 + i;
  }
  motion::WriteKinematicsCsv(folder / "kinematics.csv", motion);
  exchange::ConvertOptions options;
  options.flexion_negative = true;
  options.leg = motion::Side::kRight;
  exchange::ConvertFile(folder.Path(), folder / "a.mot", options);
  EXPECT_EQ(exchange::ReadMot(folder / "a.mot").rows[2][0], -12);
  exchange::ConvertOptions crop;
  crop.crop_s = {0.15, 1};
  exchange::ConvertFile(folder / "a.mot", folder / "b.sto", crop);
  EXPECT_EQ(exchange::ReadMot(folder / "b.sto").time_s.front(), 0.2);
  exchange::WritePoints(folder / "p.trc", MakePoints(exchange::PointSpace::kPlane, 5, 1, 3));
  const auto message = [&](const char* in, const char* out, const exchange::ConvertOptions& given) {
    return MessageOf([&] { exchange::ConvertFile(folder / in, folder / out, given); });
  };
  EXPECT_THAT(message("a.mot", "c.mot", options), testing::HasSubstr("--flexion-negative"));
  exchange::ConvertOptions left;
  left.leg = motion::Side::kLeft;
  EXPECT_THAT(message("a.mot", "c.mot", left), testing::HasSubstr("--leg"));
  EXPECT_THAT(message("p.trc", "c.csv", left), testing::HasSubstr("--leg is for a .mot"));
  EXPECT_THAT(message("a.mot", "c.trc", {}), testing::HasSubstr("angles"));
  EXPECT_THAT(message("p.trc", "c.mot", {}), testing::HasSubstr("lake gait"));
  options.leg.reset();
  EXPECT_THAT(message("p.trc", "c.csv", options), testing::HasSubstr("--flexion-negative"));
  EXPECT_THAT(message("p.trc", "p.trc", {}), testing::HasSubstr("itself"));
  EXPECT_THAT(message("p.trc", "c.fbx", {}), testing::HasSubstr(".kva"));
  EXPECT_THAT(message("none.trc", "c.csv", {}), testing::HasSubstr("no such file"));
  exchange::ConvertOptions metres;
  metres.unit = "m";
  EXPECT_THAT(message("p.trc", "c.c3d", metres), testing::HasSubstr("always in mm"));
}

}  // namespace
}  // namespace lake
