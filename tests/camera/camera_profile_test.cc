#include <gmock/gmock.h>

#include <filesystem>

#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "message_of.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {
namespace fs = std::filesystem;

class CameraProfileTest : public testing::Test {
 protected:
  fs::path File(const std::string& text) {
    WriteTextFile(folder_ / "camera.yaml", text);
    return folder_ / "camera.yaml";
  }

  // What ReadCameraProfile says of a text.
  std::string Complaint(const std::string& text) {
    return MessageOf([&] { camera::ReadCameraProfile(File(text)); });
  }

  TemporaryFolder folder_;
};

std::string Matrix(const std::string& key, int rows, int columns, const std::string& data) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", key, rows, columns,
                     data);
}

const std::string kHead = "%YAML:1.0\n---\n";
const std::string kSize = "image_width: 1280\nimage_height: 720\n";
const std::string kMatrix = Matrix("camera_matrix", 3, 3, "1100., 0., 640., 0., 1090., 352., 0., 0., 1.");
const std::string kDistortion = Matrix("distortion_coefficients", 1, 5, "-0.28, 0.09, 6e-4, -4e-4, -0.012");

TEST_F(CameraProfileTest, EveryValueComesBackToTheLastBit) {
  camera::CameraProfile profile;
  profile.camera = {
      1920, 1080, 1234.5678901234567, 1.0 / 3 * 1e4, 959.5, 539.25, {-0.1, 1.0 / 7, 1e-17, -3e-4, 2e5 / 3}};
  profile.camera_from_plane = camera::PlanePose::Identity();
  profile.camera_from_plane->linear() =
      Eigen::AngleAxisd(3.1, Eigen::Vector3d(0.9, 0.3, -0.2).normalized()).toRotationMatrix();
  profile.camera_from_plane->translation() = Eigen::Vector3d(-12.345678901234567, 800, 3210.1);
  profile.uncertainty = {0.1234, {1, 2, 3, 4}, {5, 6, 7, 8, 9}};
  profile.plane_uncertainty = {0.2, {1e-3, 2e-3, 3e-3}, {0.1, 0.2, 3}};
  camera::WriteCameraProfile(folder_ / "camera.yaml", profile);
  const camera::CameraProfile read = camera::ReadCameraProfile(folder_ / "camera.yaml");
  EXPECT_EQ(read.camera.image_width, 1920);
  EXPECT_EQ(read.camera.image_height, 1080);
  EXPECT_EQ(read.camera.fx, profile.camera.fx);
  EXPECT_EQ(read.camera.fy, profile.camera.fy);
  EXPECT_EQ(read.camera.cx, profile.camera.cx);
  EXPECT_EQ(read.camera.cy, profile.camera.cy);
  EXPECT_EQ(read.camera.distortion, profile.camera.distortion);
  ASSERT_TRUE(read.camera_from_plane && read.uncertainty && read.plane_uncertainty);
  EXPECT_EQ(read.camera_from_plane->translation(), profile.camera_from_plane->translation());
  EXPECT_LT((read.camera_from_plane->linear() - profile.camera_from_plane->linear()).norm(),
            1e-14);  // through an angle-axis
  EXPECT_EQ(read.uncertainty->rms_px, 0.1234);
  EXPECT_EQ(read.uncertainty->intrinsics_sd, profile.uncertainty->intrinsics_sd);
  EXPECT_EQ(read.uncertainty->distortion_sd, profile.uncertainty->distortion_sd);
  EXPECT_EQ(read.plane_uncertainty->rotation_sd_rad, profile.plane_uncertainty->rotation_sd_rad);
  EXPECT_EQ(read.plane_uncertainty->translation_sd_mm, profile.plane_uncertainty->translation_sd_mm);
}

TEST_F(CameraProfileTest, FourCoefficientsAndTrailingZerosOfLargerModelsLoad) {
  EXPECT_EQ(camera::ReadCameraProfile(
                File(kHead + kSize + kMatrix + Matrix("distortion_coefficients", 4, 1, "1., 2., 3., 4.")))
                .camera.distortion,
            (std::array<double, 5>{1, 2, 3, 4, 0}));
  EXPECT_NO_THROW(camera::ReadCameraProfile(
      File(kHead + kSize + kMatrix + Matrix("distortion_coefficients", 8, 1, "1., 2., 3., 4., 5., 0., 0., 0."))));
}

TEST_F(CameraProfileTest, SaysWhichKeyIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(Complaint(kHead + kMatrix + kDistortion), HasSubstr("no key 'image_width'"));
  EXPECT_THAT(Complaint(kHead + "image_width: -3\nimage_height: 720\n" + kMatrix + kDistortion),
              HasSubstr("the size of its picture is -3 x 720"));
  EXPECT_THAT(Complaint(kHead + kSize + kDistortion), HasSubstr("no key 'camera_matrix'"));
  EXPECT_THAT(Complaint(kHead + kSize + "camera_matrix: hello\n" + kDistortion),
              HasSubstr("'camera_matrix' holds 'hello', not a finite number"));
  EXPECT_THAT(Complaint(kHead + kSize + Matrix("camera_matrix", 1, 8, "1., 0., 3., 0., 5., 6., 0., 0.") + kDistortion),
              HasSubstr("'camera_matrix' has 8 numbers"));
  EXPECT_THAT(
      Complaint(kHead + kSize + Matrix("camera_matrix", 3, 3, ".Nan, 0., 3., 0., 5., 6., 0., 0., 1.") + kDistortion),
      HasSubstr("'camera_matrix' holds '.Nan', not a finite number"));
  EXPECT_THAT(
      Complaint(kHead + kSize + Matrix("camera_matrix", 3, 3, "-5., 0., 3., 0., 5., 6., 0., 0., 1.") + kDistortion),
      HasSubstr("not positive"));
  EXPECT_THAT(
      Complaint(kHead + kSize + Matrix("camera_matrix", 3, 3, "5., 1., 3., 0., 5., 6., 0., 0., 1.") + kDistortion),
      HasSubstr("skew"));
  EXPECT_THAT(Complaint(kHead + kSize + kMatrix), HasSubstr("no key 'distortion_coefficients'"));
  EXPECT_THAT(Complaint(kHead + kSize + kMatrix + Matrix("distortion_coefficients", 1, 3, "1., 2., 3.")),
              HasSubstr("3 distortion coefficients"));
  EXPECT_THAT(
      Complaint(kHead + kSize + kMatrix + Matrix("distortion_coefficients", 1, 7, "1., 2., 3., 4., 5., 6., 7.")),
      HasSubstr("7 distortion coefficients"));
  const std::string good = kHead + kSize + kMatrix + kDistortion;
  EXPECT_THAT(Complaint(good + Matrix("plane_rvec", 3, 1, "0., 0., 0.")), HasSubstr("no key 'plane_tvec'"));
  EXPECT_THAT(Complaint(good + Matrix("plane_rvec", 1, 3, "0., 0., 0.") + Matrix("plane_tvec", 1, 3, "0., 0., 900.")),
              HasSubstr("behind the plane"));
  EXPECT_THAT(Complaint(good + Matrix("plane_rvec", 1, 3, "3.141592653589793, 0., 0.") +
                        Matrix("plane_tvec", 1, 3, "0.1, 0.5, 3.5")),
              HasSubstr("'plane_tvec' puts the plane 3.54 mm from the camera"));
  EXPECT_THAT(Complaint(good + "rms_px: .Inf\n"), HasSubstr("'rms_px' holds '.Inf', not a finite number"));
}

TEST_F(CameraProfileTest, SaysTheLineOfWhatCannotBeRead) {
  using testing::HasSubstr;
  const auto expect = [&](const std::string& text, const std::string& message) {
    const std::string complaint = Complaint(text);
    EXPECT_THAT(complaint, HasSubstr("camera.yaml" + message)) << text;
    EXPECT_THAT(complaint, testing::Not(HasSubstr("parseValue"))) << text;
  };
  expect(kHead + kSize + "fps: [60\n", ":6: not YAML");
  expect("{\"image_width\": 1280,\n\"image_height\": [}\n", ":2: not YAML");
  expect("hello", ": no camera: there is no key 'camera_matrix' of OpenCV or ROS");
  expect("", ": is empty");
}

// OpenCV takes the first of two, other readers the last.
TEST_F(CameraProfileTest, AKeyThatStandsTwiceIsRefused) {
  using testing::HasSubstr;
  EXPECT_THAT(Complaint(kHead + kSize + kMatrix + kDistortion + "image_width: 1920\n"),
              HasSubstr("camera.yaml:15: key 'image_width' stands twice"));
  EXPECT_THAT(Complaint(kHead + kSize + kMatrix + kMatrix + kDistortion), HasSubstr("'camera_matrix' stands twice"));
  EXPECT_THAT(Complaint("{\n  \"image_width\": 1280,\n  \"image_width\": 1920\n}\n"),
              HasSubstr("camera.yaml:3: key 'image_width' stands twice"));
  EXPECT_THAT(Complaint("<?xml version=\"1.0\"?>\n<opencv_storage><image_width>1280</image_width>"
                        "<image_width>1920</image_width><image_height>720</image_height><camera_matrix><data>9 0 3 0 "
                        "5 6 0 0 1</data></camera_matrix><distortion_coefficients><data>0 0 0 "
                        "0</data></distortion_coefficients></opencv_storage>\n"),
              HasSubstr("the size of its picture is 1280 x 1920 x 720, not two"));
  EXPECT_THAT(Complaint(kHead + kSize +
                        "camera_matrix: !!opencv-matrix\n   rows: 3\n   rows: 4\n   cols: 3\n   dt: d\n"
                        "   data: [ 1., 0., 3., 0., 5., 6., 0., 0., 1. ]\n" +
                        kDistortion),
              HasSubstr("'rows' stands twice"));
}

TEST_F(CameraProfileTest, HostileFilesAreErrorsNotCrashes) {
  for (const std::string& text :
       {std::string(), std::string("\0\0\0", 3), std::string("%YAML:1.0\n---\n"), std::string("hello"),
        std::string("{"), std::string("<?xml"),
        kHead + kSize +
            "camera_matrix: !!opencv-matrix\n   rows: 1000000000\n   cols: 1000000000\n   dt: d\n   data: [ 1. ]\n",
        kHead + kSize + "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: zz\n   data: [ 1. ]\n",
        std::string("%YAML:1.0\n---\na: !!b\n   rows: 3\n   : 7\n"),  // std::length_error in OpenCV
        kHead + kSize + Matrix("camera_matrix", 3, 3, "1., 2.")})
    EXPECT_NE(Complaint(text), "") << text;
  const std::string good = kHead + kSize + kMatrix + kDistortion;
  for (std::size_t length = 0; length + 30 < good.size(); ++length)
    EXPECT_NE(Complaint(good.substr(0, length)), "") << length;
  EXPECT_THROW(camera::ReadCameraProfile(folder_ / "none.yaml"), Error);
}

TEST_F(CameraProfileTest, FilesOfManyLevelsAreErrorsNotCrashes) {
  using testing::HasSubstr;
  const auto repeated = [](const std::string& text) {
    std::string all;
    for (int i = 0; i < 100'000; ++i) all += text;
    return all;
  };
  for (const char* opening : {"[", "{b: ", "\n- - - - ", "- ", "b: ", "b:\n ", "? ", "-\n"})
    EXPECT_NE(Complaint("%YAML:1.0\n---\na: " + repeated(opening)), "") << opening;
  EXPECT_NE(Complaint("%YAML:1.0\n---\na:\n" + repeated(" ") + "b: 1\n"), "");
  EXPECT_NE(Complaint("{\"a\": " + repeated("[")), "");
  EXPECT_THAT(Complaint("<?xml version=\"1.0\"?><a>" + repeated("<a>") + repeated("</a>") + "</a>"),
              HasSubstr("more than 100 deep"));
}

TEST(CameraProfile, LoadsTheFilesOfOpenCvsOwnSamples) {
  const fs::path folder = SharedData() / "opencv_leftright";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const camera::Camera left = camera::ReadCameraProfile(folder / "left_intrinsics.yml").camera;
  EXPECT_EQ(left.image_width, 640);
  EXPECT_EQ(left.fx, 535.91573396163199);
  EXPECT_EQ(left.distortion[1], -3.8588898922304653e-02);
  const camera::CameraProfile charuco = camera::ReadCameraProfile(folder / "tutorial_camera_charuco.yml");
  EXPECT_EQ(charuco.camera.cy, 277.75155919135995);
  EXPECT_EQ(charuco.camera.distortion[4], 2.9542589406810080);
  EXPECT_FALSE(charuco.camera_from_plane);
}

}  // namespace
}  // namespace lake
