// Videos made on the fly by the ffmpeg program, and what that program makes of them, as truth for the reader.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/video/video_reader.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake::test {

inline std::ptrdiff_t FilesIn(const TemporaryFolder& folder) {
  return std::distance(std::filesystem::directory_iterator(folder.Path()), std::filesystem::directory_iterator());
}

inline void Shell(const std::string& command) {
  const int status = std::system(command.c_str());
  if (status != 0) throw Fail("command ended with {}: {}", status, command);
}

inline void Ffmpeg(const std::string& arguments) {
  Shell(fmt::format("ffmpeg -y -v error -nostdin {}", arguments));
}

// The usual moving test picture, 320×240, 30 Hz, 2 s, unless said otherwise.
inline std::string TestPicture(const std::string& more = "size=320x240:rate=30:duration=2") {
  return fmt::format("-f lavfi -i testsrc2={} ", more);
}

inline constexpr const char* kH264 = "-c:v libx264 -preset veryfast -crf 20 -bf 3 -g 30 -pix_fmt yuv420p ";

inline std::string Quote(const std::filesystem::path& path) {
  return fmt::format("'{}'", path.string());
}

// What the ffmpeg program shows, frame by frame, as raw bytes of the pixel format, turned as it turns.
inline std::vector<std::uint8_t> RawFrames(const std::filesystem::path& video, const std::string& format,
                                           const std::string& filter = "") {
  const TemporaryFolder folder;
  const auto raw = folder / "raw";
  const std::string filters = filter.empty() ? "" : fmt::format("-vf {} ", filter);
  Ffmpeg(
      fmt::format("-i {} {}-vsync passthrough -f rawvideo -pix_fmt {} {}", Quote(video), filters, format, Quote(raw)));
  const std::string text = ReadTextFile(raw);
  return {text.begin(), text.end()};
}

// The stored luma, unconverted.
inline std::vector<std::uint8_t> RawLuma(const std::filesystem::path& video) {
  return RawFrames(video, "gray", "extractplanes=y");
}

// Time stamps as ffprobe gives them.
inline std::vector<double> ProbeStamps(const std::filesystem::path& video) {
  const TemporaryFolder folder;
  const auto out = folder / "stamps";
  Shell(fmt::format(
      "ffprobe -v error -select_streams v:0 -show_entries frame=best_effort_timestamp_time -of csv=p=0 {} > {}",
      Quote(video), Quote(out)));
  std::vector<double> stamps;
  std::istringstream lines(ReadTextFile(out));
  for (std::string line; std::getline(lines, line);)  // a line for a frame; side data adds empty ones
    if (!line.empty()) stamps.push_back(std::strtod(line.c_str(), nullptr));
  return stamps;
}

// The stamps of frames at a constant rate.
inline std::vector<double> Regular(double start_s, double rate_hz, std::size_t frames) {
  std::vector<double> stamps(frames);
  for (std::size_t i = 0; i < frames; ++i) stamps[i] = start_s + static_cast<double>(i) / rate_hz;
  return stamps;
}

struct Recording {
  video::VideoInfo info;
  std::vector<video::VideoFrame> frames;

  std::vector<double> Stamps() const {
    std::vector<double> stamps;
    for (const video::VideoFrame& frame : frames) stamps.push_back(frame.time_s);
    return stamps;
  }
};

inline Recording ReadAll(const std::filesystem::path& path, const video::VideoReaderOptions& options = {}) {
  const auto reader = video::VideoReader::Open(path, options);
  Recording recording;
  for (video::VideoFrame frame; reader->Read(frame);) recording.frames.push_back(frame);
  recording.info = reader->Info();
  return recording;
}

// The message of the Error that reading the whole file ends with; empty if it does not. The frames before are kept.
inline std::string ErrorOf(const std::filesystem::path& path, const video::VideoReaderOptions& options = {},
                           std::vector<video::VideoFrame>* frames = nullptr) {
  return MessageOf([&] {
    const auto reader = video::VideoReader::Open(path, options);
    for (video::VideoFrame frame; reader->Read(frame);)
      if (frames) frames->push_back(frame);
  });
}

// The frame of `raw` frames of the picture's size and type that a picture must equal.
inline cv::Mat RawFrame(const std::vector<std::uint8_t>& raw, std::size_t index, cv::Size size, int type) {
  const std::size_t bytes = static_cast<std::size_t>(size.area()) * CV_ELEM_SIZE(type);
  if ((index + 1) * bytes > raw.size()) throw Fail("ffmpeg gave fewer frames than {}", index + 1);
  return cv::Mat(size, type, const_cast<std::uint8_t*>(raw.data() + index * bytes));
}

inline double LargestDifference(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) throw Fail("the pictures are of different kinds");
  return cv::norm(a, b, cv::NORM_INF);
}

}  // namespace lake::test
