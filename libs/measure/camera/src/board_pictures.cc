#include "lake/camera/board_pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "lake/camera/homography.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/core/statistics.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"
#include "lake/video/video_reader.h"

namespace lake::camera {
namespace {

namespace fs = std::filesystem;

// Where nothing says when the pictures were taken, all are looked at.
video::VideoReaderOptions ReaderFor(const fs::path& file, const BoardPicturesOptions& options) {
  video::VideoReaderOptions reader;
  if (!video::HasTimes(file)) reader.capture_rate_hz = options.attempts_per_s;
  return reader;
}

bool IsVideo(const fs::path& path) {
  const auto reader = video::VideoReader::Open(path, {.capture_rate_hz = 1});  // it is only asked for a second frame
  video::VideoFrame first, second;
  return reader->Read(first) && reader->Read(second);
}

void CheckSize(BoardPictures& pictures, int width, int height, const std::string& name, const fs::path& first) {
  if (pictures.width_px == 0) {
    pictures.width_px = width;
    pictures.height_px = height;
  }
  if (pictures.width_px != width || pictures.height_px != height)
    throw Fail("{}: it has {}x{} px, but {} has {}x{}; all pictures must come from one camera in one mode", name, width,
               height, first.string(), pictures.width_px, pictures.height_px);
}

BoardPictures FindInImages(const std::vector<fs::path>& files, const Board& board,
                           const BoardPicturesOptions& options) {
  Progress progress("looking for the board", "images", static_cast<std::int64_t>(files.size()), options.quiet);
  BoardPictures pictures;
  for (const fs::path& file : files) {
    ThrowIfInterrupted();
    const cv::Mat grey = video::ReadImage(file, false);
    CheckSize(pictures, grey.cols, grey.rows, file.string(), files.front());
    ++pictures.attempts;
    if (std::optional<BoardView> view = DetectBoard(grey, board)) {
      view->name = file.filename().string();
      pictures.views.push_back(std::move(*view));
    } else {
      pictures.without_board.push_back(file.filename().string());
    }
    progress.Advance();
  }
  pictures.seen = static_cast<int>(pictures.views.size());
  return pictures;
}

// Small enough to be searched within milliseconds, large enough for a chessboard's squares; the codes of a ChArUco
// board need their pixels.
cv::Mat ForALook(const cv::Mat& grey, const Board& board) {
  constexpr int kWidth = 800;
  if (board.kind == BoardKind::kCharuco || grey.cols <= kWidth) return grey;
  cv::Mat small;
  cv::resize(grey, small, {kWidth, grey.rows * kWidth / grey.cols}, 0, 0, cv::INTER_AREA);
  return small;
}

bool SeenAtALook(const cv::Mat& grey, const Board& board, bool thorough) {
  BoardDetectionOptions options;
  options.thorough = thorough;
  return DetectBoard(ForALook(grey, board), board, options).has_value();
}

// Looks at frames over the whole video, so that one without the board is reported within seconds. How the board has to
// be looked for: nullopt if it is in none of them, else whether it takes the thorough search to see it.
std::optional<bool> LookThrough(const fs::path& file, const Board& board, const video::VideoReaderOptions& reader,
                                int& looked_at) {
  constexpr int kPlaces = 20, kWorthIt = 200;
  const std::vector<double> stamps_s = video::StampsInContainer(file, reader).value_or(std::vector<double>{});
  if (stamps_s.size() < kWorthIt) return true;
  std::optional<bool> thorough;
  for (int place = 0; place < kPlaces; ++place) {
    ThrowIfInterrupted();
    video::VideoReaderOptions at = reader;
    at.seek_s = stamps_s[stamps_s.size() * static_cast<std::size_t>(2 * place + 1) / (2 * kPlaces)];
    video::VideoFrame frame;
    if (!video::VideoReader::Open(file, at)->Read(frame)) continue;
    ++looked_at;
    if (SeenAtALook(frame.luma, board, false)) return false;
    if (!thorough && SeenAtALook(frame.luma, board, true)) thorough = true;
  }
  return thorough;
}

BoardPictures FindInVideo(const fs::path& file, const Board& board, const BoardPicturesOptions& options) {
  BoardPictures pictures;
  const std::optional<bool> thorough = LookThrough(file, board, ReaderFor(file, options), pictures.attempts);
  if (!thorough) return pictures;
  pictures.attempts = 0;
  const auto reader = video::VideoReader::Open(file, ReaderFor(file, options));
  Progress progress("looking for the board", "frames", reader->Info().frames, options.quiet);
  double next_attempt_s = -std::numeric_limits<double>::infinity();
  for (video::VideoFrame frame; reader->Read(frame); progress.Advance()) {
    ThrowIfInterrupted();
    if (frame.time_s < next_attempt_s) continue;
    next_attempt_s =
        frame.time_s + 1 / options.attempts_per_s - 1e-6;  // rounding of stamps must not lose every second one
    CheckSize(pictures, frame.luma.cols, frame.luma.rows, fmt::format("{}: frame {}", file.string(), frame.index),
              file);
    ++pictures.attempts;
    if (!*thorough && !SeenAtALook(frame.luma, board, false)) continue;
    if (std::optional<BoardView> view = DetectBoard(frame.luma, board)) {
      view->name = fmt::format("frame {}", frame.index);
      pictures.views.push_back(std::move(*view));
    }
  }
  pictures.seen = static_cast<int>(pictures.views.size());
  pictures.views = ChooseSpreadViews(board, std::move(pictures.views), options.most_views);
  return pictures;
}

using FourCorners = std::array<Eigen::Vector2d, 4>;

// Where the board's outer corners are in the picture, seen or not.
FourCorners OuterCorners(const Board& board, const BoardView& view) {
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board);
  std::vector<PlaneCorrespondence> swapped;  // from the board to the picture
  for (std::size_t i = 0; i < view.corner.size(); ++i)
    swapped.push_back({corners[static_cast<std::size_t>(view.corner[i])], view.pixel[i]});
  const Eigen::Matrix3d image_from_board = PlaneHomography(swapped).plane_from_image;
  const double right = (board.CornerColumns() - 1) * board.square_mm, top = (board.CornerRows() - 1) * board.square_mm;
  FourCorners outer = {Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0), Eigen::Vector2d(right, top),
                       Eigen::Vector2d(0, top)};
  for (Eigen::Vector2d& p : outer) p = (image_from_board * p.homogeneous()).hnormalized().eval();
  return outer;
}

double Distance(const FourCorners& a, const FourCorners& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum);
}

}  // namespace

std::vector<BoardView> ChooseSpreadViews(const Board& board, std::vector<BoardView> views, int most) {
  if (views.empty()) return views;
  constexpr double kMostBlur = 1.5;
  std::vector<double> widths;
  for (const BoardView& view : views) widths.push_back(view.edge_width_px);
  const double limit = kMostBlur * Quantile(widths, 0.25);
  std::erase_if(views, [&](const BoardView& view) { return view.edge_width_px > limit; });

  std::vector<FourCorners> outer;
  for (const BoardView& view : views) outer.push_back(OuterCorners(board, view));
  const auto sharpest = std::min_element(views.begin(), views.end(), [](const BoardView& a, const BoardView& b) {
    return a.edge_width_px < b.edge_width_px;
  });
  std::vector<double> farness(views.size(), std::numeric_limits<double>::infinity());  // 0 once chosen
  std::vector<std::size_t> chosen;
  auto next = static_cast<std::size_t>(sharpest - views.begin());
  while (chosen.size() < std::min(views.size(), static_cast<std::size_t>(most))) {
    chosen.push_back(next);
    for (std::size_t i = 0; i < views.size(); ++i) farness[i] = std::min(farness[i], Distance(outer[i], outer[next]));
    next = static_cast<std::size_t>(std::max_element(farness.begin(), farness.end()) - farness.begin());
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<BoardView> result;
  for (const std::size_t i : chosen) result.push_back(std::move(views[i]));
  return result;
}

BoardPictures FindBoards(const std::vector<fs::path>& files, const Board& board, const BoardPicturesOptions& options) {
  const bool video = files.size() == 1 && IsVideo(files.front());
  BoardPictures pictures = video ? FindInVideo(files.front(), board, options) : FindInImages(files, board, options);
  if (pictures.views.empty())
    throw Fail(
        "{}: the board {} was seen in none of {} {}; is it the board that was printed, with these columns and rows, "
        "whole in the picture and lit evenly?",
        files.front().string(), ToString(board), pictures.attempts, video ? "frames spread over it" : "images");
  const double missing = static_cast<double>(pictures.without_board.size()) / pictures.attempts;
  if (missing > options.most_missing)
    throw Fail("the board {} was not seen in {} of {} images: {}; take them anew or name only those that show it",
               ToString(board), pictures.without_board.size(), pictures.attempts,
               fmt::join(pictures.without_board, ", "));
  return pictures;
}

}  // namespace lake::camera
