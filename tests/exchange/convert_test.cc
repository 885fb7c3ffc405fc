// What `lake convert` does, through every option.
#include "lake/exchange/convert.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/tracker.h"
#include "lake/exchange/trc.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// z up: a laboratory's axes.
PointRecording Laboratory() {
  PointRecording points = MakePoints(PointSpace::kSpace, 60, 4, 21);
  points.up_axis = 'z';
  points.events.clear();
  const char* names[] = {"RANK", "RKNE", "RHIP", "RASI"};
  for (std::size_t i = 0; i < 4; ++i) points.points[i].name = names[i];
  return points;
}

TEST(Convert, AZUpC3dBecomesAYUpTrc) {
  const TemporaryFolder folder;
  const PointRecording lab = Laboratory();
  WriteC3d(folder / "a.C3D", lab);  // laboratories write endings in capitals
  EXPECT_TRUE(ConvertFile(folder / "a.C3D", folder / "a.trc", {}).empty());
  const PointRecording trc = ReadTrc(folder / "a.trc");
  for (std::size_t i = 0; i < lab.time_s.size(); ++i) {
    const Eigen::Vector3d &from = lab.points[1].positions[i], &to = trc.points[1].positions[i];
    EXPECT_LT((Eigen::Vector3d(from.x(), from.z(), -from.y()) - to).norm(), 1e-3);
  }
}

TEST(Convert, TurningUpIsARotation) {
  for (const char from : {'x', 'y', 'z'})
    for (const char to : {'x', 'y', 'z'}) {
      PointRecording axes;
      axes.up_axis = from;
      axes.points.push_back({"p", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
      const auto p = PointsTurnedUp(axes, to).points[0].positions;
      EXPECT_NEAR(p[0].cross(p[1]).dot(p[2]), 1, 1e-12) << from << to;
      EXPECT_EQ(p[static_cast<std::size_t>(from - 'x')], Eigen::Vector3d::Unit(to - 'x')) << from << to;
    }
}

TEST(Convert, ForwardGivesTheAxesOfAModel) {
  const TemporaryFolder folder;
  const PointRecording lab = Laboratory();
  WriteC3d(folder / "a.c3d", lab);
  ConvertOptions options;
  options.reading.forward = "-y";
  options.reading.names = ParseNameMap("knee=RKNE,pelvis=RHIP+RASI");
  options.unit = "m";
  ConvertFile(folder / "a.c3d", folder / "a.trc", options);
  EXPECT_THAT(ReadTextFile(folder / "a.trc"), testing::HasSubstr("\tm\t"));
  const PointRecording trc = ReadTrc(folder / "a.trc");
  ASSERT_EQ(trc.points.size(), 2u);
  const Eigen::Vector3d &from = lab.points[1].positions[0], &to = trc.Find("knee")->positions[0];
  // x forward (−y), y up (z), z to the right of someone who looks along −y with z up: −x.
  EXPECT_LT((Eigen::Vector3d(-from.y(), from.z(), -from.x()) - to).norm(), 1e-3);
}

TEST(Convert, FormatsOfAPlaneGetAProjectionThatIsToldOf) {
  const TemporaryFolder folder;
  WriteC3d(folder / "a.c3d", Laboratory());
  ConvertOptions options;
  options.reading.forward = "+x";
  const auto warnings = ConvertFile(folder / "a.c3d", folder / "a.csv", options);
  EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("projected")));
  EXPECT_NEAR(ReadPoints(folder / "a.csv").points[1].positions[0].y(), Laboratory().points[1].positions[0].z(), 1e-3);
  EXPECT_THAT(MessageOf([&] { ConvertFile(folder / "a.c3d", folder / "b.csv", {}); }), testing::HasSubstr("--map"));
  EXPECT_FALSE(fs::exists(folder / "b.csv"));
}

TEST(Convert, PixelsWithAScaleBecomeMillimetresWhereNeeded) {
  const TemporaryFolder folder;
  PointRecording image = MakePoints(PointSpace::kImage, 20, 2, 3);
  WriteTrk(folder / "no_scale.trk", image);
  image.mm_per_px = 2;
  WriteTrk(folder / "a.trk", image);
  ConvertFile(folder / "a.trk", folder / "a.trc", {});
  const Eigen::Vector3d &px = image.points[0].positions[0], mm = ReadTrc(folder / "a.trc").points[0].positions[0];
  EXPECT_LT((Eigen::Vector3d(2 * px.x(), -2 * px.y(), 0) - mm).norm(), 1e-6);
  ConvertFile(folder / "a.trk", folder / "a.kva", {});  // stays px
  EXPECT_LT((ReadPoints(folder / "a.kva").points[0].positions[0] - px).norm(), 1e-9);
  EXPECT_THAT(MessageOf([&] { ConvertFile(folder / "no_scale.trk", folder / "b.trc", {}); }),
              testing::HasSubstr("scale"));
}

TEST(Convert, CropKeepsTheTimesAskedFor) {
  const TemporaryFolder folder;
  WritePoints(folder / "a.trc", MakePoints(PointSpace::kPlane, 120, 2, 3));  // 120 Hz
  ConvertOptions options;
  options.crop_s = {0.25, 0.5};
  options.reading.forward = "+x";
  ConvertFile(folder / "a.trc", folder / "b.csv", options);
  const PointRecording cropped = ReadPoints(folder / "b.csv");
  EXPECT_EQ(cropped.time_s.front(), 0.25);
  EXPECT_EQ(cropped.time_s.back(), 0.5);
  EXPECT_EQ(cropped.frame.front(), 30);  // numbers of the whole recording
  EXPECT_EQ(cropped.points[1].positions.size(), 31u);
  options.reading.forward = "";
  ConvertFile(folder / "a.trc", folder / "b.c3d", options);
  EXPECT_NEAR(ReadC3d(folder / "b.c3d").time_s.front(), 0.25, 1e-9);  // by the number of its first frame
  // Events are cropped too, and lost, with a warning, where the format has none.
  PointRecording points = MakePoints(PointSpace::kSpace, 120, 2, 3);
  points.events = {{0.2, "", "early"}, {0.3, "", "within"}, {0.6, "", "late"}};
  WriteC3d(folder / "events.c3d", points);
  EXPECT_THAT(ConvertFile(folder / "events.c3d", folder / "d.c3d", options), testing::IsEmpty());
  const std::vector<PointEvent> events = ReadC3d(folder / "d.c3d").events;
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].label, "within");
  EXPECT_NEAR(events[0].time_s, 0.3, 1e-6);
  EXPECT_THAT(ConvertFile(folder / "events.c3d", folder / "d.trc", options),
              testing::ElementsAre(testing::HasSubstr("events are left out")));
  options.crop_s = {7, 8};
  EXPECT_THAT(MessageOf([&] { ConvertFile(folder / "a.trc", folder / "c.csv", options); }),
              testing::HasSubstr("lasts from 0"));
}

TEST(Convert, AnglesGoToMotAndNowhereElse) {
  const TemporaryFolder folder;
  LegMotion motion;
  for (int i = 0; i < 5; ++i) {
    motion.frame.push_back(i), motion.time_s.push_back(0.1 * i), motion.samples.emplace_back();
    motion.samples.back().knee_deg = 10 + i;
  }
  WriteKinematicsCsv(folder / "kinematics.csv", motion);
  ConvertOptions options;
  options.flexion_negative = true;
  ConvertFile(folder.Path(), folder / "a.mot", options);
  EXPECT_EQ(ReadMot(folder / "a.mot").rows[2][0], -12);
  ConvertOptions crop;
  crop.crop_s = {0.15, 1};
  ConvertFile(folder / "a.mot", folder / "b.sto", crop);
  EXPECT_EQ(ReadMot(folder / "b.sto").time_s.front(), 0.2);
  WritePoints(folder / "p.trc", MakePoints(PointSpace::kPlane, 5, 1, 3));
  const auto message = [&](const char* in, const char* out, const ConvertOptions& given) {
    return MessageOf([&] { ConvertFile(folder / in, folder / out, given); });
  };
  EXPECT_THAT(message("a.mot", "c.mot", options), testing::HasSubstr("--flexion-negative"));
  EXPECT_THAT(message("a.mot", "c.trc", {}), testing::HasSubstr("angles"));
  EXPECT_THAT(message("p.trc", "c.mot", {}), testing::HasSubstr("lake gait"));
  EXPECT_THAT(message("p.trc", "c.csv", options), testing::HasSubstr("--flexion-negative"));
  EXPECT_THAT(message("p.trc", "p.trc", {}), testing::HasSubstr("itself"));
  EXPECT_THAT(message("p.trc", "c.fbx", {}), testing::HasSubstr(".kva"));
  EXPECT_THAT(message("none.trc", "c.csv", {}), testing::HasSubstr("no such file"));
  ConvertOptions metres;
  metres.unit = "m";
  EXPECT_THAT(message("p.trc", "c.c3d", metres), testing::HasSubstr("always in mm"));
}

}  // namespace
}  // namespace lake
