#include "lake/drawing/linkage_animation.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <opencv2/core/mat.hpp>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
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
  for (int pose = 0; pose < poses; ++pose) {
    if (pose > 0) figure.NextPage();
    DrawPosePage(figure, look, linkage::RequirePose(look.links, range.lower_mm + range.Travel() * pose / (poses - 1)));
  }
  return figure;
}

// Adds the way back; the ends appear once, so that an endless loop does not halt there.
void AddWayBack(const fs::path& folder, int poses) {
  for (int pose = poses - 2, frame = poses; pose > 0; --pose, ++frame)
    fs::copy_file(folder / fmt::format("{:05}.png", pose), folder / fmt::format("{:05}.png", frame));
}

void WriteMp4(const fs::path& path, const LinkageLook& look) {
  constexpr double kFrameRate_hz = 20;
  constexpr int kPoses = 40;
  const ScratchFolder frames(path);
  PagesOut(look, kPoses).WritePages(frames.Path());
  AddWayBack(frames.Path(), kPoses);
  video::VideoReaderOptions reading;
  reading.colour = true;
  reading.sequence_rate_hz = kFrameRate_hz;
  const auto reader = video::VideoReader::Open(frames.Path() / "%05d.png", reading);
  video::VideoWriterOptions writing;
  writing.width = kPosePageWidth_px, writing.height = kPosePageHeight_px, writing.frame_rate_hz = kFrameRate_hz;
  video::VideoWriter writer(path, writing);
  for (video::VideoFrame frame; reader->Read(frame);) {
    ThrowIfInterrupted();
    writer.Write(frame.bgr, frame.time_s);
  }
  writer.Finish();
}

}  // namespace

void WriteLinkageAnimation(const fs::path& mp4, const fs::path& gif, const LinkageLook& look) {
  WriteMp4(mp4, look);
  constexpr int kGifPoses = 25;
  constexpr double kPosesPerSecond = 10;
  PagesOut(look, kGifPoses).WriteGif(gif, kPosesPerSecond);
}

}  // namespace lake::drawing
