#include <algorithm>
#include <limits>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/overlay/head_blur.h"
#include "lake/video/frame_queue.h"
#include "lake/video/video_writer.h"

namespace lake::overlay {
namespace {

// Whole, and of the usual formats to the bit.
video::VideoReaderOptions CopyOptions(const AnonymiseOptions& options) {
  video::VideoReaderOptions reader = options.reader;
  reader.colour = false;
  reader.preview_max_width_px = std::numeric_limits<int>::max();
  reader.preview_as_stored = true;
  return reader;
}

video::VideoWriterOptions WriterOptions(const video::VideoInfo& video, const AnonymiseOptions& options) {
  return {.width = video.width,
          .height = video.height,
          .frame_rate_hz = video.frame_rate_hz > 0 ? std::min(video.frame_rate_hz, 1000.0) : 30,
          .crf = options.crf.value_or(0),
          .lossless = !options.crf,
          .i420 = true,
          .full_range = video.full_range,
          .bt709 = video.bt709};
}

}  // namespace

AnonymisedCopy WriteAnonymisedVideo(const std::filesystem::path& video, const HeadBlur& blur,
                                    const AnonymiseOptions& options, const std::filesystem::path& out) {
  if (!blur.IsKnown())
    throw Fail(
        "{}: the head's position is unknown in every frame: the subject never stands with ankle, knee, hip and waist "
        "in sight",
        video.string());
  const auto reader = video::VideoReader::Open(video, CopyOptions(options));
  const video::VideoInfo& info = reader->Info();
  if (info.width % 2 != 0 || info.height % 2 != 0)
    throw Fail("{}: {}×{} px; a copy needs even sides: crop or pad it with ffmpeg first", video.string(), info.width,
               info.height);
  video::FrameQueue queue(*reader);
  Progress progress("anonymise", "frames", info.frames, options.quiet);
  video::VideoWriter writer(out, WriterOptions(info, options));
  AnonymisedCopy copy;
  for (video::VideoFrame frame; queue.Pop(frame); progress.Advance()) {
    ThrowIfInterrupted();
    const HeadBlur::Done done = blur.Blur(frame.preview, frame.index, info.width);
    copy.whole += done == HeadBlur::Done::kWhole;
    copy.beside_leg += done == HeadBlur::Done::kHeadBesideLeg;
    ++copy.frames;
    writer.Write(frame.preview, frame.time_s);
  }
  writer.Finish();
  const bool is_420 = info.pixel_format == "yuv420p" || info.pixel_format == "yuvj420p";
  copy.is_exact = is_420 && !options.crf;
  return copy;
}

}  // namespace lake::overlay
