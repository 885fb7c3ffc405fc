// A motion recorded in space: its markers are seen where they are in space, and the truth is what the plane shows.
#include "lake/synth/motion_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "lake/synth/scene.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kRateHz = 50;

// A person who looks along +x bends the knee; y is up, z to the right. The hip lies deeper than the knee, and the leg
// swings sideways.
Vector3d Place(const std::string& marker, double t) {
  const double bend = 0.5 - 0.5 * std::cos(3 * t), sway = 12 * std::sin(2 * t);
  if (marker == "ANK") return {100, 90, 300 + 0.2 * sway};
  if (marker == "KNE") return {100 + 150 * bend, 500 - 40 * bend, 330 + sway};
  if (marker == "HIP") return {100 - 250 * bend, 920 - 300 * bend, 240 + 0.5 * sway};
  if (marker == "BACK") return {-60 - 250 * bend, 1000 - 300 * bend, 180};
  return {140 - 250 * bend, 1020 - 300 * bend, 200};  // FRONT
}

class MotionFileTest : public testing::Test {
 protected:
  MotionFileTest() {
    exchange::PointRecording points;
    for (int i = 0; i <= 2 * kRateHz; ++i) points.frame.push_back(i), points.time_s.push_back(i / kRateHz);
    for (const char* name : {"ANK", "KNE", "HIP", "BACK", "FRONT"}) {
      exchange::PointTrack& track = points.points.emplace_back(exchange::PointTrack{name, {}});
      for (const double t : points.time_s) track.positions.push_back(Place(name, t));
    }
    points.points[4].positions[90] = exchange::PointTrack::Missing();
    exchange::WritePoints(folder_ / "person.trc", points);
    motion_.file = folder_ / "person.trc";
    motion_.reading.names = {{"ankle", "ANK"}, {"knee", "KNE"}, {"hip", "HIP"}};
    motion_.reading.forward = "+x";
  }

  std::string ErrorOf(double duration_s) const {
    return MessageOf([&] { synth::ReadMotionFile(motion_, duration_s); });
  }

  TemporaryFolder folder_;
  synth::MotionFile motion_;
};

TEST_F(MotionFileTest, IsSeenInSpaceAndItsTruthIsWhatThePlaneShows) {
  motion_.reading.names["waist"] = "FRONT+BACK";
  motion_.extra_markers = {"BACK"};
  motion_.begin_s = 0.4;
  synth::SceneOptions options = synth::CleanScene(1);
  options.duration_s = 1.2;
  options.room = options.body = false;  // before FRONT is missing
  options.frame_rate_hz = kRateHz;
  options.yaw_deg = 11;
  options.pitch_deg = -5;
  for (const bool right : {true, false}) {
    motion_.facing = right ? motion::Facing::kRight : motion::Facing::kLeft;
    options.motion_file = motion_;
    const synth::Scene scene(options);
    EXPECT_EQ(scene.Motion().FacingInImage(), motion_.facing);
    EXPECT_THAT(scene.Motion().Names(), testing::UnorderedElementsAre("ankle", "knee", "hip", "waist", "BACK"));
    double middle = 0;  // of the leg, over the frames that are shown
    for (int frame = 20; frame <= 80; ++frame)
      for (const char* name : {"ANK", "KNE", "HIP"}) middle += Place(name, frame / kRateHz).z() / (3 * 61);
    const camera::CameraProfile& profile = scene.Profile();
    double parallax_mm = 0;
    for (const int frame : {0, 17, 59}) {
      const synth::FrameTruth truth = scene.Truth(frame);
      const double t = motion_.begin_s + frame / kRateHz, turn = right ? 1 : -1;
      std::map<std::string, Vector3d> places = {{"ankle", Place("ANK", t)},
                                                {"knee", Place("KNE", t)},
                                                {"hip", Place("HIP", t)},
                                                {"waist", (Place("FRONT", t) + Place("BACK", t)) / 2},
                                                {"BACK", Place("BACK", t)}};
      for (std::size_t m = 0; m < truth.markers.size(); ++m) {
        const Vector3d& place = places.at(scene.Motion().Names()[m]);
        const Vector2d flat(turn * place.x(), place.y());
        const Vector2d px =
            camera::PixelFromPlane(profile.camera, *profile.camera_from_plane, flat, turn * (place.z() - middle));
        EXPECT_LT((truth.markers[m].px - px).norm(), 1e-3) << scene.Motion().Names()[m];  // the file has 1e-6 m
        const Vector2d shown = camera::PlaneFromPixel(profile.camera, *profile.camera_from_plane, px);
        EXPECT_LT((truth.markers[m].mm - shown).norm(), 2e-3);
        parallax_mm = std::max(parallax_mm, (shown - flat).norm());
      }
      const auto shown = [&](const char* name) { return truth.markers[synth::IndexOfMarker(scene.Motion(), name)].mm; };
      EXPECT_NEAR(truth.knee_deg, synth::KneeAngleDeg(shown("ankle"), shown("knee"), shown("hip"), motion_.facing),
                  1e-9);
    }
    EXPECT_GT(parallax_mm, 10) << "the markers are not off the plane";
  }
}

TEST_F(MotionFileTest, GoesOnBeforeAndAfterThePartThatIsShown) {
  motion_.begin_s = 0.4;
  const synth::MotionTable table = synth::ReadMotionFile(motion_, 1.2);
  const auto part = synth::MakeTableMotion(table);
  motion_.begin_s = 0;
  const auto whole = synth::MakeTableMotion(synth::ReadMotionFile(motion_, 0));
  EXPECT_NEAR(part->DurationS(), 1.2, 1e-9);
  const std::size_t knee = static_cast<std::size_t>(synth::IndexOfMarker(*part, "knee"));
  for (const double t : {-0.04, -0.011, 0.0, 0.6, 1.2, 1.213, 1.24}) {
    const Vector2d here = part->At(t)[knee], there = whole->At(0.4 + t)[knee];
    EXPECT_LT((here - there).norm(), 0.05) << t;  // the spline's ends are elsewhere
  }
  EXPECT_GT((part->At(-0.04)[knee] - part->At(0)[knee]).norm(), 1) << "the knee is held where the part begins";
}

TEST_F(MotionFileTest, DrawsAMarkerThatIsNearerLargerAndWhereItsTruthIs) {
  synth::SceneOptions options = synth::CleanScene(1);
  options.duration_s = 0;
  options.room = options.body = false;
  options.frame_rate_hz = kRateHz;
  options.motion_file = motion_;
  const synth::Scene scene(options);
  const synth::FrameTruth truth = scene.Truth(30);
  std::map<std::string, double> light;
  for (std::size_t m = 0; m < truth.markers.size(); ++m) {
    const std::string& name = scene.Motion().Names()[m];
    const synth::ImagePatch patch = scene.RenderMarker(30, name, Vector2d::Zero());
    Vector2d centre = Vector2d::Zero();
    for (int y = 0; y < patch.image.rows; ++y)
      for (int x = 0; x < patch.image.cols; ++x) {
        const double value = patch.image.at<float>(y, x);
        light[name] += value;
        centre += value * Vector2d(patch.corner.x + x, patch.corner.y + y);
      }
    // A disc seen in perspective and blurred by its acceleration: both are below a hundredth of a px here.
    EXPECT_LT((centre / light[name] - truth.markers[m].px).norm(), 0.02) << name;
  }
  const double nearer = Place("KNE", 30 / kRateHz).z() - Place("HIP", 30 / kRateHz).z();
  EXPECT_NEAR(light["knee"] / light["hip"], std::pow(1 + nearer / options.distance_mm, 2), 0.004);
}

TEST_F(MotionFileTest, SaysWhatCannotBeShown) {
  EXPECT_EQ(ErrorOf(0), "");
  motion_.extra_markers = {"FRONT"};
  EXPECT_EQ(ErrorOf(1.7), "");
  EXPECT_THAT(ErrorOf(0), HasSubstr("marker 'FRONT' is missing at 1.80 s"));
  motion_.extra_markers = {"TOE"};
  EXPECT_THAT(ErrorOf(0), HasSubstr("no marker 'TOE'"));
  motion_.extra_markers = {};
  motion_.begin_s = 1.99;
  EXPECT_THAT(ErrorOf(0), HasSubstr("too little is left to show from 1.99 s on: it lasts 2.00 s"));
}

}  // namespace
}  // namespace lake
