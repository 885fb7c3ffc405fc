// Views of one camera and of two.
#include <gmock/gmock.h>

#include <filesystem>

#include "board_scene.h"
#include "lake/camera/calibration_quality.h"
#include "places.h"

namespace lake {
namespace {

using camera::BoardView;
using testing::AllOf;
using testing::HasSubstr;

std::optional<camera::TwoCameras> Find(const std::vector<BoardView>& views) {
  const camera::CalibrationResult one = camera::CalibrateCamera(kBoard, views, 640, 480);
  return camera::FindTwoCameras(kBoard, views, one, {});
}

// Names by this letter and a number.
std::vector<BoardView> Views(const camera::Camera& camera, char letter, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<BoardView> views;
  while (std::ssize(views) < count) {
    const auto pose = scene::PoseWellInside(camera, kBoard, random, 25);
    views.push_back(scene::NoisyView(camera, kBoard, pose, 0.1, random));
    views.back().name = fmt::format("{}{:02}.png", letter, views.size());
  }
  return views;
}

std::vector<BoardView> operator+(std::vector<BoardView> a, const std::vector<BoardView>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(TwoCameras, AreToldFromOne) {
  camera::Camera other = kSmallCamera;
  other.fx *= 1.02;
  other.fy *= 1.02;
  other.cx -= 30;
  other.cy += 30;
  const auto own = Views(kSmallCamera, 'a', 8, 1), others = Views(other, 'b', 6, 11);
  EXPECT_FALSE(Find(own));
  const auto both = own + others;
  const auto found = Find(both);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_certain);
  EXPECT_THAT(found->first, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(camera::Describe(*found, both), AllOf(HasSubstr("a01.png, a02.png"), HasSubstr("b06.png as views")));
}

class OpenCvSides : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << folder_ << " is absent";
    left_ = scene::OpenCvViews("left");
    right_ = scene::OpenCvViews("right");
  }

  const std::filesystem::path folder_ = SharedData() / "opencv_leftright";
  std::vector<BoardView> left_, right_;
};

// One model, 5 px of fx and 15 px of cx apart: together fx ± 0.33 px, as if all were well.
TEST_F(OpenCvSides, AreTwoCamerasTogetherAndOneEach) {
  std::mt19937_64 random(3);
  for (auto views : {left_, right_}) {
    EXPECT_FALSE(Find(views));
    std::shuffle(views.begin(), views.end(), random);
    const auto few = Find({views.begin(), views.begin() + 6});
    EXPECT_FALSE(few && few->is_certain);
  }
  const std::vector<BoardView> five_left(left_.begin() + 4, left_.begin() + 9),
      five_right(right_.begin(), right_.begin() + 5);
  std::vector<BoardView> alternating;
  for (std::size_t i = 0; i < five_left.size(); ++i) {
    alternating.push_back(five_left[i]);
    alternating.push_back(five_right[i]);
  }
  for (const auto& views : {left_ + right_, five_left + five_right, alternating}) {
    const auto found = Find(views);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->is_certain);
    for (std::size_t i = 0; i < views.size(); ++i)
      EXPECT_EQ(std::ranges::count(found->first, i), views[i].name.starts_with("left")) << views[i].name;
  }
}

}  // namespace
}  // namespace lake
