#include "lake/drawing/linkage_animation.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/threads.h"
#include "lake/video/video_reader.h"
#include "lake/video/video_writer.h"
#include "linkage_page.h"

namespace lake::drawing {
namespace {

namespace fs = std::filesystem;

// A folder beside the result that vanishes with the scope. It is named as AtomicFile's files are, so that the next run
// takes away what a killed process left, and no other process writes into it.
class ScratchFolder {
 public:
  explicit ScratchFolder(const fs::path& result) {
    std::string name = (result.parent_path() / fmt::format(".{}.lake-XXXXXX", result.stem().string())).string();
    if (!mkdtemp(name.data()))
      throw Fail("{}: no folder for its pictures can be made: {}", result.string(), std::strerror(errno));
    path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;  // nothing more can be done about a folder that cannot be removed
    fs::remove_all(path_, ignored);
  }
  const fs::path& Path() const { return path_; }

 private:
  fs::path path_;
};

// Evenly spaced strokes from the shortest to the longest.
figure::GnuplotFigure PagesOut(const LinkageLook& look, int poses) {
  figure::GnuplotFigure figure(kPosePageWidth_px, kPosePageHeight_px);
  const linkage::StrokeRange& range = look.range.stroke;
  LabelPlaces labels;
  for (int pose = 0; pose < poses; ++pose) {
    if (pose > 0) figure.NextPage();
    DrawPosePage(figure, look, linkage::RequirePose(look.links, range.lower_mm + range.Travel() * pose / (poses - 1)),
                 labels);
  }
  return figure;
}

std::vector<cv::Mat> ReadPages(const fs::path& folder) {
  video::VideoReaderOptions options;
  options.colour = true;
  options.capture_rate_hz = 1;  // their times do not matter
  const auto reader = video::VideoReader::Open(folder / "%05d.png", options);
  std::vector<cv::Mat> pages;
  for (video::VideoFrame frame; reader->Read(frame);) pages.push_back(frame.bgr);
  return pages;
}

// Out and back; the ends appear once, so that an endless loop does not halt there.
void WriteMp4(const fs::path& path, const LinkageLook& look) {
  constexpr double kFrameRate_hz = 20;
  constexpr int kPoses = 40;
  const ScratchFolder folder(path);
  PagesOut(look, kPoses).WritePages(folder.Path());
  std::vector<cv::Mat> pages = ReadPages(folder.Path());
  for (std::size_t back = pages.size() - 2; back > 0; --back) pages.push_back(pages[back]);
  video::VideoWriterOptions options{
      .width = kPosePageWidth_px, .height = kPosePageHeight_px, .frame_rate_hz = kFrameRate_hz};
  video::VideoWriter writer(path, options);
  for (std::size_t i = 0; i < pages.size(); ++i) {
    ThrowIfInterrupted();
    writer.Write(pages[i], static_cast<double>(i) / kFrameRate_hz);
  }
  writer.Finish();
}

void WriteGif(const fs::path& path, const LinkageLook& look) {
  constexpr int kPoses = 25;
  constexpr double kPosesPerSecond = 10;
  PagesOut(look, kPoses).WriteGif(path, kPosesPerSecond);
}

}  // namespace

void WriteLinkageAnimation(const fs::path& mp4, const fs::path& gif, const LinkageLook& look) {
  // Each has a gnuplot of its own, which takes most of the time.
  ForEachInThreads(2, Threads(), [&](std::size_t i) {
    if (i == 0)
      WriteMp4(mp4, look);
    else
      WriteGif(gif, look);
  });
}

}  // namespace lake::drawing
