#include "lake/camera/board_pictures.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "board_scene.h"
#include "lake/camera/board.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/video/image.h"
#include "lake/video/video_writer.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {
namespace fs = std::filesystem;

class BoardPicturesTest : public testing::Test {
 protected:
  BoardPicturesTest() { options_.quiet = true; }

  cv::Mat1b Board(double x, double tilt_deg) {
    return scene::Render(kSmallCamera, kBoard, scene::PoseAt(kSmallCamera, kBoard, {x, 240}, 260, tilt_deg, 40, 5),
                         random_, {0.6, 1.5, 3});
  }
  fs::path Save(const std::string& name, const cv::Mat& image) {
    video::WriteImage(folder_ / name, image);
    return folder_ / name;
  }
  std::string Complaint(const std::vector<fs::path>& files) {
    return MessageOf([&] { camera::FindBoards(files, kBoard, options_); });
  }

  TemporaryFolder folder_;
  camera::BoardPicturesOptions options_;
  std::mt19937_64 random_{5};
};

TEST_F(BoardPicturesTest, ImagesWithoutABoardAreNamedAndTheRestUsed) {
  const auto a = Save("a.png", Board(250, 10)), b = Save("b.png", cv::Mat1b(480, 640, uchar{90})),
             c = Save("c.png", Board(400, 25));
  const camera::BoardPictures pictures = camera::FindBoards({a, b, c}, kBoard, options_);
  EXPECT_EQ(pictures.width_px, 640);
  ASSERT_EQ(pictures.views.size(), 2u);
  EXPECT_EQ(pictures.views[1].name, "c.png");
  EXPECT_THAT(pictures.without_board, testing::ElementsAre("b.png"));
  const auto d = Save("d.png", cv::Mat1b(480, 640, uchar{90}));
  const auto e = Save("e.png", cv::Mat1b(480, 640, uchar{90}));
  EXPECT_THAT(Complaint({a, b, d, e}), testing::HasSubstr("not seen in 3 of 4 images: b.png, d.png, e.png"));
  EXPECT_THAT(Complaint({b, d}), testing::HasSubstr("seen in none of 2 images"));
}

TEST_F(BoardPicturesTest, MixedSizesAndUnreadableFilesAreErrors) {
  const auto a = Save("a.png", Board(250, 10)), small = Save("small.png", cv::Mat1b(240, 320, uchar{90}));
  EXPECT_THAT(Complaint({a, small}),
              testing::AllOf(testing::HasSubstr("small.png: it has 320x240"), testing::HasSubstr("640x480")));
  WriteTextFile(folder_ / "text.png", "not a picture");
  EXPECT_THAT(Complaint({a, folder_ / "text.png"}), testing::HasSubstr("text.png"));
  EXPECT_THAT(Complaint({a, folder_ / "none.png"}), testing::HasSubstr("none.png"));
}

// A numbered sequence has no times, and needs none here: at 30 Hz only each third picture was looked at.
TEST_F(BoardPicturesTest, OfASequenceEveryPictureIsLookedAt) {
  for (int i = 0; i < 4; ++i) Save(fmt::format("{:02}.png", i), Board(250 + 20 * i, 10));
  EXPECT_EQ(camera::FindBoards({folder_ / "%02d.png"}, kBoard, options_).seen, 4);
}

// A board that moves, is blurred for a while and is out of the picture for a while.
TEST_F(BoardPicturesTest, OfAVideoSharpSpreadFramesAreChosen) {
  video::VideoWriterOptions writer_options;
  writer_options.width = 640;
  writer_options.height = 480;
  writer_options.grey = true;
  writer_options.lossless = true;
  writer_options.frame_rate_hz = 10;
  video::VideoWriter writer(folder_ / "board.mp4", writer_options);
  constexpr int kFrames = 24;
  for (int i = 0; i < kFrames; ++i) {
    cv::Mat1b picture = Board(200 + 10 * i, 2 * i);
    if (i % 4 == 1) cv::GaussianBlur(picture, picture, {}, 2.5);
    if (i >= 20) picture = uchar{100};
    writer.Write(picture, i / 10.0);
  }
  writer.Finish();
  options_.most_views = 6;
  const camera::BoardPictures pictures = camera::FindBoards({folder_ / "board.mp4"}, kBoard, options_);
  EXPECT_EQ(pictures.attempts, kFrames);
  EXPECT_GE(pictures.seen, 14);
  ASSERT_EQ(pictures.views.size(), 6u);
  std::vector<int> frames;
  for (const camera::BoardView& view : pictures.views) frames.push_back(std::stoi(view.name.substr(6)));
  for (const int frame : frames) EXPECT_NE(frame % 4, 1) << "a blurred frame";
  EXPECT_LE(frames.front(), 2);
  EXPECT_GE(frames.back(), 17);
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GE(frames[i] - frames[i - 1], 2);
}

// Twenty looks over the whole of it: searching every picture thoroughly took minutes.
TEST_F(BoardPicturesTest, AVideoWithoutTheBoardIsToldOfAfterAFewLooks) {
  video::VideoWriterOptions writer_options;
  writer_options.grey = true;
  writer_options.frame_rate_hz = 60;
  const auto write = [&](const char* name, const cv::Mat1b& early, const cv::Mat1b& late) {
    writer_options.width = early.cols;
    writer_options.height = early.rows;
    video::VideoWriter writer(folder_ / name, writer_options);
    for (int i = 0; i < 240; ++i) writer.Write(i < 180 ? early : late, i / 60.0);
    writer.Finish();
    return folder_ / name;
  };
  cv::Mat1b room(480, 640, uchar{90}), small;
  cv::rectangle(room, {200, 100, 150, 250}, 190, cv::FILLED);
  cv::resize(room, small, {}, 0.5, 0.5);
  EXPECT_THAT(Complaint({write("without.mp4", small, small)}), testing::HasSubstr("seen in none of 20 frames"));
  options_.attempts_per_s = 5;
  const camera::BoardPictures late = camera::FindBoards({write("late.mp4", room, Board(300, 20))}, kBoard, options_);
  EXPECT_EQ(late.attempts, 20);
  EXPECT_GE(late.seen, 4);  // of 5; the frame at the cut is coded from the room
}

TEST(ChooseSpreadViews, OfNoneOrFewGivesThemAll) {
  EXPECT_TRUE(camera::ChooseSpreadViews(kBoard, {}, 5).empty());
  std::mt19937_64 random(1);
  std::vector<camera::BoardView> views(
      3, scene::NoisyView(kSmallCamera, kBoard, scene::PoseAt(kSmallCamera, kBoard, {300, 240}, 260, 10, 0, 0), 0.1,
                          random));
  EXPECT_EQ(camera::ChooseSpreadViews(kBoard, views, 5).size(), 3u);
}

using BoardSheetTest = BoardPicturesTest;

// The printed sheet, rasterised: it has the right size, the detector finds it, and its squares are exact.
TEST_F(BoardSheetTest, PdfIsOneToOneAndItsBoardIsFound) {
  if (std::system("pdftoppm -v 2>/dev/null") != 0) GTEST_SKIP() << "pdftoppm is not installed";
  constexpr double kDpi = 254;  // 10 px per mm
  const std::pair<const char*, const char*> sheets[] = {{"chessboard:9x6:25", "a4"},
                                                        {"charuco:9x7:25:18:4X4_50", "a4"},
                                                        {"charuco:11x7:35:26:5X5_100", "a3"},
                                                        {"chessboard:8x5:24", "letter"}};
  for (const auto& [text, paper_name] : sheets) {
    const lake::camera::Board board = camera::ParseBoard(text);
    const camera::Paper paper = camera::ParsePaper(paper_name);
    camera::WriteBoardSheet(folder_ / "board.pdf", board, paper);
    const std::string command = fmt::format("pdftoppm -r {} -gray -png {}/board.pdf {}/page", kDpi,
                                            folder_.Path().string(), folder_.Path().string());
    ASSERT_EQ(std::system(command.c_str()), 0);
    const cv::Mat page = video::ReadImage(folder_ / "page-1.png", false);
    EXPECT_NEAR(page.cols, paper.width_mm * 10, 1.5) << text;
    EXPECT_NEAR(page.rows, paper.height_mm * 10, 1.5) << text;
    const auto view = camera::DetectBoard(page, board);
    ASSERT_TRUE(view) << text;
    ASSERT_EQ(static_cast<int>(view->corner.size()), board.CornerColumns() * board.CornerRows());
    const auto corners = camera::BoardCorners(board);
    const Eigen::Vector2d across = view->pixel.back() - view->pixel.front(), truth = corners.back() - corners.front();
    EXPECT_NEAR(across.norm() / 10, truth.norm(), 0.03) << text;  // mm; a third of a pixel of the raster
  }
}

TEST_F(BoardSheetTest, ABoardThatIsTooLargeIsAnErrorWithTheWayOut) {
  const auto write = [&] {
    camera::WriteBoardSheet(folder_ / "board.pdf", camera::ParseBoard("chessboard:9x6:30"), camera::ParsePaper("a4"));
  };
  EXPECT_THAT(MessageOf(write),
              testing::AllOf(testing::HasSubstr("does not fit on a4"), testing::HasSubstr("can be 25.5 mm")));
  EXPECT_FALSE(fs::exists(folder_ / "board.pdf"));
  EXPECT_THROW(camera::ParsePaper("b5"), UsageError);
}

}  // namespace
}  // namespace lake
