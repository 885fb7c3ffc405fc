#include "lake/overlay/overlay_video.h"

#include <algorithm>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/video/frame_queue.h"
#include "lake/video/video_writer.h"
#include "overlay_scene.h"

namespace lake::overlay {
namespace {

video::VideoReaderOptions PreviewOptions(const OverlayOptions& options) {
  video::VideoReaderOptions reader = options.reader;
  reader.colour = false;
  reader.preview_max_width_px = options.max_width_px;
  reader.luma_too = true;
  reader.skip_deblocking = true;
  return reader;
}

// libx264 works in threads of its own, behind Write().
video::VideoWriter MakeWriter(const std::filesystem::path& out, cv::Size size, const video::VideoInfo& video) {
  return video::VideoWriter(out, {.width = size.width,
                                  .height = size.height,
                                  .frame_rate_hz = video.frame_rate_hz > 0 ? std::min(video.frame_rate_hz, 1000.0) : 30,
                                  .crf = 23,
                                  .i420 = true,
                                  .bt709 = video.bt709,
                                  .preset = "ultrafast"});
}

}  // namespace

void WriteOverlayVideo(const std::filesystem::path& video, const OverlayContent& content, const OverlayOptions& options,
                       const std::filesystem::path& out) {
  if (content.tracks.unit != motion::LengthUnit::kPx) throw Fail("{}: an overlay needs tracks in px", out.string());
  const auto reader = video::VideoReader::Open(video, PreviewOptions(options));
  const video::VideoInfo& info = reader->Info();
  std::optional<std::int64_t> total;
  if (!content.tracks.frame.empty()) total = static_cast<std::int64_t>(content.tracks.Frames());
  video::FrameQueue queue(*reader);
  Progress progress("overlay", "frames", total, options.quiet);
  std::optional<OverlayScene> scene;
  std::optional<video::VideoWriter> writer;
  for (video::VideoFrame frame; queue.Pop(frame); progress.Advance()) {
    ThrowIfInterrupted();
    if (!scene) {
      const cv::Size shown(frame.preview.cols, frame.preview.rows / 3 * 2);
      scene.emplace(content, options, info, shown);
      writer.emplace(MakeWriter(out, shown, info));
    }
    if (content.anonymise) content.anonymise->Blur(frame.preview, frame.index, info.width);
    scene->DrawOnto(frame);
    writer->Write(frame.preview, frame.time_s);
  }
  if (!writer) throw Fail("{}: no frame to draw on", video.string());
  writer->Finish();
}

}  // namespace lake::overlay
