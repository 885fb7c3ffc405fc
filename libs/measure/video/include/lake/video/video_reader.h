// Frames of a video or an image sequence, in order, each with its own presentation time stamp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "lake/core/options.h"

namespace lake::video {

struct VideoInfo {
  int width = 0;                       // px, as a player shows it (after the stream's rotation)
  int height = 0;                      // px
  double frame_rate_hz = 0;            // the stream's average rate, or the capture rate that was given
  std::optional<std::int64_t> frames;  // approximate number, if the container states it; for progress only
  std::string codec;
  bool coded_frame_by_frame = false;  // without prediction from other frames, as Motion JPEG, PNG or FFV1
  bool is_lossless = false;           // of a codec that always is, as PNG or FFV1
  std::string pixel_format;           // as stored, in libav's name, e.g. "yuv420p"
  int rotation_deg = 0;               // clockwise, applied by the reader: the file's own and what was asked for
  bool mirrored = false;              // left and right exchanged after the rotation, applied by the reader
  double pixel_aspect = 1;            // width / height of a pixel as shown; frames are handed out unstretched
  bool bt709 = false;                 // colours of previews: BT.709, else BT.601; the stream's own if it is one of them
  bool full_range = false;            // levels of previews given as stored: 0..255, else 16..235
  int white_level = 255;              // of the luma, what the stream calls white: 255, or 235; some cameras go beyond
  bool interlaced = false;            // the first frame consists of two fields taken at different times

  // Of the frames decoded so far; final once Read() has returned false.
  double shortest_interval_s = 0;  // between neighbouring frames
  double longest_interval_s = 0;
  bool irregular_stamps =
      false;  // the two differ by more than a tenth of the mean interval (and the stamps' own rounding)
  std::optional<double> bits_per_pixel;  // of the coded pictures; not of a live stream
  std::int64_t repaired_stamps = 0;  // frames without a stamp, which got the previous stamp plus one frame's duration

  // Whether the pixels are not square, by more than what rounding makes of it.
  bool HasWidePixels() const { return pixel_aspect < 0.99 || pixel_aspect > 1.01; }
};

struct VideoFrame {
  std::int64_t index = 0;  // from 0, counting all frames of the file
  double time_s = 0;       // presentation time stamp
  cv::Mat luma;            // CV_8UC1; may share memory with the decoder: valid as long as this object, never written to
  cv::Mat bgr;             // CV_8UC3; empty unless asked for

  // Empty unless asked for: CV_8UC1 in OpenCV's I420 layout (h rows of Y, then h/2 of U and V), even sides, 16..235,
  // the matrix as VideoInfo::bt709 says.
  cv::Mat preview;
  std::shared_ptr<const void> keep_alive;
};

struct VideoReaderOptions {
  bool colour = false;             // also give bgr
  int preview_max_width_px = 0;    // if set: give `preview`, at most this wide, and neither luma nor bgr …
  bool luma_too = false;           // … but luma if this is set
  bool preview_as_stored = false;  // 8-bit 4:2:0 video that is not made smaller keeps its samples: for a copy
  bool skip_deblocking = false;    // leave out the decoder's loop filter: quicker, but block edges show and errors
                                   // grow until the next key frame. For display, never for measurement
  int rotate_deg = 0;              // turn the pictures clockwise by 90, 180 or 270, beyond what the file says of itself
  // If set: time = (first time) + index / rate. For slow-motion files, and for what has no times of its own: image
  // sequences and streams without a container, which are not opened without it.
  double capture_rate_hz = 0;
  std::int64_t first = 0;                          // first frame to hand out
  std::optional<std::int64_t> last = {};           // last frame to hand out
  std::optional<double> start_s = {}, end_s = {};  // only frames with time stamps from … to …, both included
  // Begins at the key frame at or before this time without decoding earlier frames; frames count from there. For
  // samples of long files. A file without an index begins at its start.
  std::optional<double> seek_s = {};
};

void Describe(VideoReaderOptions& o, OptionList& options);
Option& DescribeCaptureRate(VideoReaderOptions& o, OptionList& options);
Option& DescribeRotation(VideoReaderOptions& o, OptionList& options);

class VideoReader {
 public:
  virtual ~VideoReader() = default;

  // A video, one picture, or an image sequence given as a printf pattern (frames/%05d.png), which begins at its lowest
  // number. Throws Error: absent, a folder, not a video, no video stream, no frame, larger than 16384 px a side or 200
  // Mpx, turned by an angle that is no multiple of 90°, a `rotate_deg` that is none of 0, 90, 180, 270 (UsageError), a
  // gap in the numbers of a sequence, no times of its own and no `capture_rate_hz`.
  static std::unique_ptr<VideoReader> Open(const std::filesystem::path& path, const VideoReaderOptions& options = {});

  virtual const VideoInfo& Info() const = 0;

  // False after the last frame. Throws Error naming the frame: the stream is damaged or ends before the container says,
  // the picture's size changes, a time stamp is missing or does not increase (not with capture_rate_hz), `first` is
  // behind the end, or no frame lies between `start_s` and `end_s`.
  virtual bool Read(VideoFrame& frame) = 0;
};

// The luma of one frame. Throws Error as VideoReader does, or where there is no such frame.
cv::Mat ReadLuma(const std::filesystem::path& path, std::int64_t frame, VideoReaderOptions options = {});

}  // namespace lake::video
