// A whole 1080p H.264 file: the ffmpeg program decoding it to nothing, and VideoReader handing out luma, or luma and
// BGR. A third measures the writer. LAKE_BENCHMARK_VIDEO=FILE takes another video than the one made here.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "lake/video/video_reader.h"
#include "lake/video/video_writer.h"

namespace {

void Shell(const std::string& command) {
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
}

// 10 s of a moving picture with a little sensor noise at CRF 23.
const std::filesystem::path& Video() {
  struct Made {
    std::filesystem::path path;
    bool temporary = false;
    Made() {
      if (const char* given = std::getenv("LAKE_BENCHMARK_VIDEO")) {
        path = given;
        return;
      }
      temporary = true;
      path = std::filesystem::temp_directory_path() / fmt::format("lake_decode_benchmark_{}.mp4", ::getpid());
      Shell(fmt::format(
          "ffmpeg -y -v error -nostdin -f lavfi -i testsrc2=size=1920x1080:rate=60:duration=10,noise=alls=3:allf=t "
          "-c:v libx264 -preset veryfast -crf 23 -pix_fmt yuv420p '{}'",
          path.string()));
    }
    ~Made() {
      std::error_code ignored;
      if (temporary) std::filesystem::remove(path, ignored);
    }
  };
  static const Made made;
  return made.path;
}

std::int64_t ReadAll(const lake::video::VideoReaderOptions& options) {
  const auto reader = lake::video::VideoReader::Open(Video(), options);
  lake::video::VideoFrame frame;
  std::int64_t frames = 0;
  while (reader->Read(frame)) ++frames;
  return frames;
}

void ShowRate(benchmark::State& state, std::int64_t frames_each) {
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(frames_each * state.iterations()), benchmark::Counter::kIsRate);
}

void FfmpegProgram(benchmark::State& state) {
  const std::int64_t frames = ReadAll({});
  const std::string command = fmt::format("ffmpeg -v error -nostdin -i '{}' -f null -", Video().string());
  for (auto _ : state) Shell(command);
  ShowRate(state, frames);
}

void ReaderLuma(benchmark::State& state) {
  std::int64_t frames = 0;
  for (auto _ : state) frames = ReadAll({});
  ShowRate(state, frames);
}

void ReaderColour(benchmark::State& state) {
  std::int64_t frames = 0;
  for (auto _ : state) frames = ReadAll({.colour = true});
  ShowRate(state, frames);
}

// One second of the same pictures, again and again.
void Writer(benchmark::State& state) {
  const bool grey = state.range(0) != 0;
  const auto reader = lake::video::VideoReader::Open(Video(), {.colour = true, .last = 59});
  std::vector<cv::Mat> pictures;
  for (lake::video::VideoFrame frame; reader->Read(frame);) pictures.push_back(grey ? frame.luma.clone() : frame.bgr);
  const auto path = std::filesystem::temp_directory_path() / fmt::format("lake_write_benchmark_{}.mp4", ::getpid());
  for (auto _ : state) {
    lake::video::VideoWriter writer(
        path, {.width = reader->Info().width, .height = reader->Info().height, .frame_rate_hz = 60, .grey = grey});
    for (int i = 0; i < 240; ++i) writer.Write(pictures[i % pictures.size()], i / 60.0);
    writer.Finish();
  }
  ShowRate(state, 240);
  std::filesystem::remove(path);
}

// Run with --benchmark_enable_random_interleaving=true, so that what else the machine does meets all of them alike.
BENCHMARK(FfmpegProgram)->UseRealTime()->Unit(benchmark::kMillisecond)->Repetitions(3);
BENCHMARK(ReaderLuma)->UseRealTime()->Unit(benchmark::kMillisecond)->Repetitions(3);
BENCHMARK(ReaderColour)->UseRealTime()->Unit(benchmark::kMillisecond)->Repetitions(3);
BENCHMARK(Writer)->ArgName("grey")->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
