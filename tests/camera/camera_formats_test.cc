// Camera files of other programs: one camera in each dialect, read as the same camera; models that have no counterpart.
#include <gmock/gmock.h>

#include <random>

#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "message_of.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using camera::CameraProfile;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kFocal_px = 1931.0344827586207;

class CameraFormats : public testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& text) const {
    WriteTextFile(folder_ / name, text);
    return folder_ / name;
  }
  std::string Refusal(const std::string& name, const std::string& text) const {
    return MessageOf([&] { camera::ReadCameraProfile(Write(name, text)); });
  }
  static void ExpectTheCamera(const CameraProfile& profile, double p1 = 0.0004, double p2 = -0.0003) {
    const camera::Camera& camera = profile.camera;
    EXPECT_EQ(camera.image_width, 1280);
    EXPECT_EQ(camera.image_height, 720);
    EXPECT_NEAR(camera.fx, kFocal_px, 1e-6);
    EXPECT_NEAR(camera.fy, kFocal_px, 1e-6);
    EXPECT_NEAR(camera.cx, 639.5, 1e-6);
    EXPECT_NEAR(camera.cy, 359.5, 1e-6);
    EXPECT_EQ(camera.model, camera::LensModel::kBrownConrady);
    EXPECT_EQ(camera.distortion, (std::array<double, 5>{-0.13, 0.03, p1, p2, 0}));
  }
  TemporaryFolder folder_;
};

constexpr const char* kRos =
    "image_width: 1280\nimage_height: 720\ncamera_name: lab\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [1931.0344827586207, 0.0, 639.5, 0.0, 1931.0344827586207, 359.5, 0.0, 0.0, 1.0]\n"
    "distortion_model: {}\ndistortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n";
constexpr const char* kKalibr =
    "cam0:\n  camera_model: {}\n  distortion_coeffs: [-0.13, 0.03, 0.0004, -0.0003]\n  distortion_model: {}\n"
    "  intrinsics: [1931.0344827586207, 1931.0344827586207, 639.5, 359.5]\n  resolution: [1280, 720]\n"
    "  rostopic: /cam0/image_raw\n";
constexpr const char* kToml =
    "[{}]\nname = \"lab\"\nsize = [1280.0, 720.0]\n"
    "matrix = [[1931.0344827586207, 0.0, 639.5], [0.0, 1931.0344827586207, 359.5], [0.0, 0.0, 1.0]]\n"
    "distortions = [-0.13, 0.03, 0.0004, -0.0003]\nrotation = [0.1, 0.2, 0.3]\ntranslation = [1.0, 2.0, 3.0]\n"
    "fisheye = {}\n";

std::string Ros(const char* model, int count, const char* coefficients) {
  return fmt::format(fmt::runtime(kRos), model, count, coefficients);
}

TEST_F(CameraFormats, OfSharedData) {
  const fs::path folder = SharedData() / "odd_files/camera-files";
  if (!fs::exists(folder)) GTEST_SKIP() << folder.string() << " is not here";
  ExpectTheCamera(camera::ReadCameraProfile(folder / "ros.yaml"));
  ExpectTheCamera(camera::ReadCameraProfile(folder / "kalibr.yaml"));
}

TEST_F(CameraFormats, OfRos) {
  const auto read = [&](const char* model, int count, const char* coefficients) {
    return camera::ReadCameraProfile(Write("a.yaml", Ros(model, count, coefficients)));
  };
  for (const char* model : {"plumb_bob", "Plumb Bob"})
    ExpectTheCamera(read(model, 5, "-0.13, 0.03, 0.0004, -0.0003, 0.0"));
  EXPECT_EQ(read("plumb_bob", 0, "").camera.distortion, (std::array<double, 5>{})) << "rectified";
  EXPECT_EQ(read("rational_polynomial", 8, "1, 2, 3, 4, 5, 6, 7, 8").camera.more[2], 8);
  const camera::Camera fisheye = read("equidistant", 4, "0.1, 0.2, 0.3, 0.4").camera;
  EXPECT_EQ(fisheye.model, camera::LensModel::kFisheye);
  EXPECT_EQ(fisheye.distortion[3], 0.4);
  EXPECT_THAT(Refusal("a.yaml", Ros("division", 1, "0.1")),
              AllOf(HasSubstr("'division' has no counterpart"), HasSubstr("lake calibrate")));
  for (const char* keys : {"KD", "kd"})  // messages of ROS 1 and 2
    ExpectTheCamera(camera::ReadCameraProfile(
        Write("a.yaml", fmt::format("header:\n  frame_id: lab\nheight: 720\nwidth: 1280\ndistortion_model: plumb_bob\n"
                                    "{}: [-0.13, 0.03, 0.0004, -0.0003, 0.0]\n"
                                    "{}: [1931.0344827586207, 0, 639.5, 0, 1931.0344827586207, 359.5, 0, 0, 1]\n",
                                    keys[1], keys[0]))));
}

TEST_F(CameraFormats, OfKalibr) {
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.yaml", fmt::format(fmt::runtime(kKalibr), "pinhole", "radtan"))));
  EXPECT_EQ(
      camera::ReadCameraProfile(Write("a.yaml", fmt::format(fmt::runtime(kKalibr), "pinhole", "equi"))).camera.model,
      camera::LensModel::kFisheye);
  EXPECT_THAT(Refusal("a.yaml", fmt::format(fmt::runtime(kKalibr), "pinhole", "fov")),
              HasSubstr("'fov' has no counter"));
  EXPECT_THAT(Refusal("a.yaml", fmt::format(fmt::runtime(kKalibr), "omni", "radtan")), HasSubstr("'omni' has no"));
}

TEST_F(CameraFormats, OfPose2SimAndCaliscope) {
  for (const char* table : {"cam_01", "cameras.0"})
    ExpectTheCamera(camera::ReadCameraProfile(
        Write("Calib.toml", fmt::format(fmt::runtime(kToml), table, "false") + "[metadata]\nadjusted = false\n")));
  EXPECT_EQ(camera::ReadCameraProfile(Write("Calib.toml", fmt::format(fmt::runtime(kToml), "a", "true"))).camera.model,
            camera::LensModel::kFisheye);
  const std::string two =
      fmt::format(fmt::runtime(kToml), "cam_01", "false") + fmt::format(fmt::runtime(kToml), "cam_02", "true");
  EXPECT_THAT(Refusal("Calib.toml", two), AllOf(HasSubstr("cam_01, cam_02"), HasSubstr("--view cam_01")));
  EXPECT_EQ(camera::ReadCameraProfile(Write("Calib.toml", two), "cam_02").camera.model, camera::LensModel::kFisheye);
  EXPECT_THAT(Refusal("Calib.toml", "[a\n"), HasSubstr("Calib.toml:1: not TOML"));
}

TEST_F(CameraFormats, OfOpenCvsOlderSamplesAndWithRosModels) {
  const std::string text =
      "%YAML:1.0\nimage_Width: 1280\nimage_Height: 720\nCamera_Matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: "
      "d\n"
      "   data: [1931.0344827586207, 0., 639.5, 0., 1931.0344827586207, 359.5, 0., 0., 1.]\n"
      "Distortion_Coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
      "   data: [-0.13, 0.03, 0.0004, -0.0003, 0.]\n";
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.yaml", text)));
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.yaml", text + "distortion_model: plumb_bob\n")));
}

std::string Qualisys(const std::string& picture, double left, double top, double unit = 64, double last = 1) {
  return fmt::format(
      "<calibration><cameras><camera serial=\"26580\" viewrotation=\"0\">{3}"
      "<intrinsic focallength=\"9\" sensorMinU=\"0\" sensorMaxU=\"{4}\" sensorMinV=\"0\" "
      "sensorMaxV=\"{5}\" focalLengthU=\"{0}\" focalLengthV=\"{0}\" centerPointU=\"{1}\" "
      "centerPointV=\"{2}\" skew=\"0\" radialDistortion1=\"-0.13\" radialDistortion2=\"0.03\" "
      "radialDistortion3=\"0\" tangentalDistortion1=\"0.0004\" tangentalDistortion2=\"-0.0003\"/>"
      "</camera></cameras></calibration>",
      unit * kFocal_px, unit * (left + 639.5), unit * (top + 359.5), picture, unit * 1280 - last, unit * 720 - last);
}

TEST_F(CameraFormats, OfQualisys) {
  const std::string text = Qualisys("<fov_video left=\"10\" top=\"20\" right=\"1289\" bottom=\"739\"/>", 10, 20);
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.qca.txt", text)));
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.qca.txt", Qualisys("", 0, 0))));  // the whole sensor
  for (const double unit : {64.0, 1.0})  // as Pose2Sim writes it, and Theia, which has px
    ExpectTheCamera(camera::ReadCameraProfile(Write("a.xml", Qualisys("", 0, 0, unit, 0))));
  std::string wide = "\xFF\xFE";
  for (const char c : text) wide += {c, '\0'};
  ExpectTheCamera(camera::ReadCameraProfile(Write("a.xml", wide)));
}

// Vicon's polynomial leads from the picture to the ideal point, with distances in px.
TEST_F(CameraFormats, OfVicon) {
  const auto xcp = [](const std::string& lens) {
    return fmt::format(
        "<?xml version=\"1.0\"?><Cameras><Camera DEVICEID=\"7\" SENSOR_SIZE=\"1280 720\" PIXEL_ASPECT_RATIO=\"1\">"
        "<KeyFrames><KeyFrame FOCAL_LENGTH=\"{}\" PRINCIPAL_POINT=\"639.5 359.5\" {} ORIENTATION=\"0 0 0 1\"/>"
        "</KeyFrames></Camera></Cameras>",
        kFocal_px, lens);
  };
  const double k1 = 3e-8, k2 = -4e-15;
  const CameraProfile profile = camera::ReadCameraProfile(
      Write("a.xcp", xcp(fmt::format("VICON_RADIAL2=\"ViconRadial2 639.5 359.5 {} {} 0\"", k1, k2))));
  EXPECT_TRUE(profile.warnings.empty());
  for (const Eigen::Vector2d& px : std::vector<Eigen::Vector2d>{{0, 0}, {1279, 100}, {700, 719}, {639.5, 359.5}}) {
    const Eigen::Vector2d d = px - Eigen::Vector2d(639.5, 359.5);
    const double r2 = d.squaredNorm();
    const Eigen::Vector2d ideal = d * (1 + k1 * r2 + k2 * r2 * r2) / kFocal_px;
    EXPECT_LT((camera::Project(profile.camera, {ideal.x(), ideal.y(), 1}) - px).norm(), 0.02);
  }
  const CameraProfile in_focal_lengths = camera::ReadCameraProfile(Write("a.xcp", xcp("VICON_RADIAL=\"-0.13 0.03\"")));
  ExpectTheCamera(in_focal_lengths, 0, 0);
  EXPECT_THAT(in_focal_lengths.warnings, testing::ElementsAre(HasSubstr("are not per px²")));
}

// Changed bytes, absurd numbers, cut anywhere: an answer or one sentence.
TEST_F(CameraFormats, DamagedFilesNeverCrash) {
  std::mt19937 random(5);
  for (const auto& [name, good] :
       {std::pair<std::string, std::string>{"a.yaml", Ros("plumb_bob", 5, "1, 2, 3, 4, 0")},
        {"b.yaml", fmt::format(fmt::runtime(kKalibr), "pinhole", "radtan")},
        {"c.toml", fmt::format(fmt::runtime(kToml), "cam_01", "false")},
        {"d.xcp",
         "<Cameras><Camera DEVICEID=\"7\" SENSOR_SIZE=\"1280 720\"><KeyFrames><KeyFrame FOCAL_LENGTH=\"1900\" "
         "PRINCIPAL_POINT=\"639.5 359.5\" VICON_RADIAL=\"3e-8 0\"/></KeyFrames></Camera></Cameras>"}}) {
    EXPECT_EQ(Refusal(name, good), "");
    for (int round = 0; round < 400; ++round) {
      std::string bad = good;
      for (int i = 0; i < 2; ++i) bad[random() % bad.size()] = static_cast<char>(random());
      if (round % 4 == 0) bad.resize(1 + random() % bad.size());
      for (const char* number : {"1e308", "nan", "-1", "99999999999"})
        if (const std::size_t at = bad.find_first_of("0123456789", random() % bad.size() / 2);
            round % 5 == 0 && at != std::string::npos)
          bad.replace(at, 1, number);
      EXPECT_EQ(Refusal(name, bad).find('\n'), std::string::npos);
    }
  }
}

TEST_F(CameraFormats, OfNoneThatIsKnown) {
  EXPECT_THAT(Refusal("a.cal", "x"), AllOf(HasSubstr("OptiTrack Motive"), HasSubstr("lake calibrate")));
  EXPECT_THAT(Refusal("a.ini", "x"), AllOf(HasSubstr("oST file of ROS"), HasSubstr("camera_calibration_parsers")));
  EXPECT_THAT(Refusal("a.xcp", "<Camera DEVICEID=\"7\" SENSOR_SIZE=\"1280 720\"><KeyFrames/></Camera>"),
              AllOf(HasSubstr("never calibrated"), HasSubstr("camera of Vicon")));
  EXPECT_THAT(Refusal("a.npz", "PK"), AllOf(HasSubstr("archive of numpy"), HasSubstr("--template")));
  EXPECT_THAT(Refusal("a.yaml", "colour: blue\n"), AllOf(HasSubstr("OpenCV"), HasSubstr("kalibr")));
}

// What lake convert writes of each dialect is the same camera.
TEST_F(CameraFormats, AreWrittenAsCameraYaml) {
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>{"a.yaml", Ros("plumb_bob", 4, "-0.13, 0.03, 0.0004, -0.0003")},
        {"b.yaml", fmt::format(fmt::runtime(kKalibr), "pinhole", "radtan")},
        {"c.toml", fmt::format(fmt::runtime(kToml), "cam_01", "false")}}) {
    camera::WriteCameraProfile(folder_ / "camera.yaml", camera::ReadCameraProfile(Write(name, text)));
    ExpectTheCamera(camera::ReadCameraProfile(folder_ / "camera.yaml"));
  }
}

}  // namespace
}  // namespace lake
