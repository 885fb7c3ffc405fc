// Streams that are recorded while they come: files at their own pace, pipes, what breaks off.
#include "lake/video/live_stream.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <functional>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "file_limit.h"
#include "lake/core/file_descriptor.h"
#include "lake/core/interrupt.h"
#include "message_of.h"
#include "video_files.h"

namespace lake::test {
namespace {

using video::LiveStream;
using video::LiveStreamOptions;
using video::StreamEnd;

struct Played {
  std::vector<video::LiveFrame> frames;
  StreamEnd end;
  std::int64_t damaged = 0, missing = 0;
  double first_stamp_s = 0;
};

Played Play(const std::string& input, const LiveStreamOptions& options, const std::filesystem::path& recording) {
  LiveStream stream(input, options, recording);
  Played played;
  for (video::LiveFrame frame; stream.Read(frame);) {
    frame.frame.luma = frame.frame.luma.clone();  // not as many of the decoder's pictures at once
    frame.frame.keep_alive = nullptr;
    played.frames.push_back(frame);
  }
  stream.Finish();
  played.end = stream.End();
  played.damaged = stream.DamagedFrames();
  played.missing = stream.MissingFrames();
  played.first_stamp_s = stream.FirstStampS();
  return played;
}

LiveStreamOptions Replay() {
  LiveStreamOptions options;
  options.replay = true;
  return options;
}

std::string ReasonOf(const std::string& input, const LiveStreamOptions& options,
                     const std::filesystem::path& recording) {
  return MessageOf([&] { LiveStream stream(input, options, recording); });
}

// The recording holds the frames that were handed out, to the bit, at their times: Matroska keeps milliseconds.
void ExpectRecorded(const Played& played, const std::filesystem::path& recording) {
  constexpr double kMatroska_s = 0.5e-3 + 1e-9;
  const Recording recorded = ReadAll(recording);
  ASSERT_EQ(recorded.frames.size(), played.frames.size());
  for (std::size_t i = 0; i < recorded.frames.size(); ++i) {
    EXPECT_EQ(played.frames[i].frame.index, static_cast<std::int64_t>(i));
    EXPECT_NEAR(recorded.frames[i].time_s, played.frames[i].frame.time_s, kMatroska_s);
    ASSERT_EQ(LargestDifference(recorded.frames[i].luma, played.frames[i].frame.luma), 0) << i;
  }
}

TEST(LiveStream, RecordsACodedStreamAsItCame) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=1") + kH264 + Quote(folder / "film.mp4"));
  const Played played = Play((folder / "film.mp4").string(), Replay(), folder / "video.mkv");
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kEnded);
  ASSERT_EQ(played.frames.size(), 30u);
  ExpectRecorded(played, folder / "video.mkv");
  EXPECT_FALSE(std::filesystem::exists(folder / "video.part.mkv"));
  EXPECT_EQ(ReadAll(folder / "video.mkv").info.codec, "h264");
}

TEST(LiveStream, ReplaysAtTheFilesOwnPace) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=20:duration=1") + "-c:v mjpeg " + Quote(folder / "film.avi"));
  const auto began = std::chrono::steady_clock::now();
  const Played played = Play((folder / "film.avi").string(), Replay(), folder / "video.mkv");
  ASSERT_EQ(played.frames.size(), 20u);
  const std::chrono::duration<double> took = played.frames.back().arrived - began;
  EXPECT_GE(took.count(), 0.95 - 1e-6);  // 19 intervals after the first frame, which came after `began`
}

// Each picture's bits, colours too, as the pixels that were sent.
std::string AllPlanes(const std::filesystem::path& film, const std::string& pixels) {
  const auto hashes = film.parent_path() / "hashes.txt";
  Ffmpeg("-i " + Quote(film) + " -pix_fmt " + pixels + " -vsync passthrough -f framehash -hash md5 " + Quote(hashes));
  std::string of_pictures;
  std::istringstream lines(ReadTextFile(hashes));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("0,")) of_pictures += line.substr(line.rfind(',')) + "\n";
  EXPECT_FALSE(of_pictures.empty());
  return of_pictures;
}

// As cameras send them: in one plane (YUYV, UYVY), in several, grey, in colours.
TEST(LiveStream, RawPicturesAreRecordedWithoutLoss) {
  for (const char* pixels : {"yuyv422", "uyvy422", "yuv420p", "nv12", "gray", "bgr24"}) {
    SCOPED_TRACE(pixels);
    const TemporaryFolder folder;
    Ffmpeg(TestPicture("size=162x121:rate=50:duration=0.5") + "-c:v rawvideo -pix_fmt " + pixels + " " +
           Quote(folder / "film.nut"));
    const Played played = Play((folder / "film.nut").string(), Replay(), folder / "video.mkv");
    EXPECT_EQ(played.end.kind, StreamEnd::Kind::kEnded);
    ASSERT_EQ(played.frames.size(), 25u);
    ExpectRecorded(played, folder / "video.mkv");
    EXPECT_EQ(ReadAll(folder / "video.mkv").info.codec, "ffv1");
    ExpectRecorded(played, folder / "film.nut");
    EXPECT_EQ(AllPlanes(folder / "video.mkv", pixels), AllPlanes(folder / "film.nut", pixels));
  }
}

TEST(LiveStream, RawPicturesKeepTheShapeOfTheirPixelsAndTheirRange) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=25:duration=0.2") +
         "-vf setsar=4/3 -color_range pc -c:v rawvideo -pix_fmt yuv420p " + Quote(folder / "film.nut"));
  Play((folder / "film.nut").string(), Replay(), folder / "video.mkv");
  const video::VideoInfo info = ReadAll(folder / "video.mkv").info, film = ReadAll(folder / "film.nut").info;
  EXPECT_NEAR(info.pixel_aspect, 4 / 3.0, 1e-9);
  EXPECT_EQ(info.pixel_aspect, film.pixel_aspect);
  EXPECT_EQ(AllPlanes(folder / "video.mkv", "yuv420p"), AllPlanes(folder / "film.nut", "yuv420p"));
}

TEST(LiveStream, ASensorsColourMosaicIsRefused) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=25:duration=1") + "-pix_fmt gray -f rawvideo " + Quote(folder / "film.raw"));
  Ffmpeg("-f rawvideo -pix_fmt bayer_rggb8 -video_size 160x120 -i " + Quote(folder / "film.raw") + " -c copy " +
         Quote(folder / "film.nut"));
  EXPECT_THAT(ReasonOf((folder / "film.nut").string(), Replay(), folder / "video.mkv"),
              testing::HasSubstr("--format mjpeg"));
}

// Writes a file into the pipe or the connection that `open` makes.
std::jthread SendingTo(std::function<int()> open, const std::filesystem::path& file) {
  return std::jthread([open = std::move(open), bytes = ReadTextFile(file)] {
    const FileDescriptor end(open());
    ASSERT_EQ(write(end, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  });
}

Played PlayOverPipe(const std::filesystem::path& file, const std::filesystem::path& recording) {
  const auto pipe = file.parent_path() / "camera";
  if (mkfifo(pipe.c_str(), 0600) != 0) throw Fail("{}: cannot be made", pipe.string());
  const std::jthread sending = SendingTo([&] { return open(pipe.c_str(), O_WRONLY); }, file);
  return Play(pipe.string(), {}, recording);
}

Played PlayOverTcp(const std::filesystem::path& file, const std::filesystem::path& recording) {
  const FileDescriptor server(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const named = reinterpret_cast<sockaddr*>(&address);
  if (::bind(server, named, size) != 0 || ::listen(server, 1) != 0) throw Fail("no port is free");
  ::getsockname(server, named, &size);
  const std::jthread sending = SendingTo([&] { return ::accept(server, nullptr, nullptr); }, file);
  return Play(fmt::format("tcp://127.0.0.1:{}", ntohs(address.sin_port)), {}, recording);
}

// 30 pictures at 30 Hz, unevenly, then 12 at 12 Hz.
void ExpectStampsOfBothRates(const Played& played, const std::filesystem::path& recording) {
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kEnded);
  ASSERT_EQ(played.frames.size(), 30u + 12u);
  ExpectRecorded(played, recording);
  const auto interval_s = [&](std::size_t i) {
    return played.frames[i].frame.time_s - played.frames[i - 1].frame.time_s;
  };
  constexpr double kTick_s = 1 / 90000.0;
  for (std::size_t i = 31; i < 42; ++i) EXPECT_NEAR(interval_s(i), 1 / 12.0, kTick_s);
  std::set<int> jittered_ms;
  for (std::size_t i = 1; i < 30; ++i) jittered_ms.insert(static_cast<int>(std::lround(1000 * interval_s(i))));
  EXPECT_GT(jittered_ms.size(), 5u);
  EXPECT_EQ(played.missing, 0) << "another rate, and no gaps";
}

// A camera that needs longer in the dark, and a network that brings pictures unevenly: over a pipe, over a connection,
// and from a file at its own pace.
TEST(LiveStream, ARateThatChangesAndJitterKeepTheirStamps) {
  const TemporaryFolder folder;
  const std::string coded = "-c:v libx264 -g 5 -bf 0 -vsync passthrough ";
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=1") +
         "-vf 'settb=1/90000,setpts=PTS+1080*random(1)' -enc_time_base 1:90000 " + coded + Quote(folder / "light.ts"));
  Ffmpeg(TestPicture("size=160x120:rate=12:duration=1") + coded + "-output_ts_offset 1.1 " + Quote(folder / "dark.ts"));
  WriteTextFile(folder / "film.ts", ReadTextFile(folder / "light.ts") + ReadTextFile(folder / "dark.ts"));
  for (const char* way : {"pipe", "tcp", "file"}) {
    SCOPED_TRACE(way);
    const auto recording = folder / way / "video.mkv";
    std::filesystem::create_directory(folder / way);
    const Played played = way == std::string("pipe")  ? PlayOverPipe(folder / "film.ts", recording)
                          : way == std::string("tcp") ? PlayOverTcp(folder / "film.ts", recording)
                                                      : Play((folder / "film.ts").string(), Replay(), recording);
    ExpectStampsOfBothRates(played, recording);
  }
}

// As a camera leaves pictures out that nobody fetched in time: only their stamps are missing.
TEST(LiveStream, PicturesThatNeverCameAreCounted) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=2") +
         "-vf \"select='not(eq(n,20)+between(n,31,33)+eq(n,50))'\" -vsync vfr -c:v rawvideo " +
         Quote(folder / "film.nut"));
  const Played played = Play((folder / "film.nut").string(), Replay(), folder / "video.mkv");
  EXPECT_EQ(played.frames.size(), 55u);
  EXPECT_EQ(played.missing, 5);
  EXPECT_THAT(played.end.why, testing::HasSubstr("5 pictures missing in 3 gaps of the time stamps, of up to 0.13 s"));
  ExpectRecorded(played, folder / "video.mkv");
}

// Datagrams from one socket to another on this machine. Nothing is sent until somebody listens.
class Sender {
 public:
  Sender() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)), reserved_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    if (::bind(reserved_, Address(), size) != 0) throw Fail("no port is free");
    ::getsockname(reserved_, Address(), &size);
    // Kept for who asks for reuse. Being its own peer, the socket gets none of the datagrams itself.
    const int reuse = 1;
    ::setsockopt(reserved_, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
    if (::connect(reserved_, Address(), size) != 0 || ::connect(socket_, Address(), size) != 0)
      throw Fail("no connection");
  }

  std::string Url() const { return fmt::format("udp://127.0.0.1:{}?reuse=1", ntohs(address_.sin_port)); }

  // A refused datagram was sent to a port that nobody listens on. False: `stop` came first.
  bool WaitForListener(const std::stop_token& stop) const {
    for (const char nothing = 0; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
      const bool is_sent = ::send(socket_, &nothing, 0, 0) == 0;
      int error = 0;
      socklen_t size = sizeof error;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ::getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size);
      if (is_sent && error == 0) return true;
    }
    return false;
  }

  void Send(std::string_view datagram) const { ::send(socket_, datagram.data(), datagram.size(), 0); }

 private:
  sockaddr* Address() { return reinterpret_cast<sockaddr*>(&address_); }

  FileDescriptor socket_, reserved_;
  sockaddr_in address_ = {};
};

// What comes of a stream of which datagrams are lost is as it was sent, at its own time, and the rest is told of. How
// much more is lost on a busy machine is not the test's.
TEST(LiveStream, OverUdpLossIsSaidAndNoPictureIsMadeUp) {
  constexpr int kKeyEvery = 15;
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=6") +
         fmt::format("-c:v libx264 -preset veryfast -crf 20 -g {} -sc_threshold 0 -bf 0 -f mpegts ", kKeyEvery) +
         Quote(folder / "film.ts"));
  const Recording sent = ReadAll(folder / "film.ts");
  const std::string bytes = ReadTextFile(folder / "film.ts");
  const Sender sender;
  std::jthread sending([&](const std::stop_token& stop) {
    if (!sender.WaitForListener(stop)) return;
    constexpr std::size_t kDatagram = 7 * 188, kBegin = 60'000;  // nothing is lost before the stream is known
    std::mt19937 random(38);
    for (std::size_t at = 0; at < bytes.size() && !stop.stop_requested(); at += kDatagram) {
      if (at < kBegin || random() % 12 != 0) sender.Send(std::string_view(bytes).substr(at, kDatagram));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // a camera does not send all at once
    }
  });
  LiveStreamOptions options;
  options.patience_s = 5;
  const Played played = Play(sender.Url(), options, folder / "video.mkv");
  sending.join();
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kLost);
  EXPECT_THAT(played.end.why, testing::HasSubstr("nothing has come for 5 s"));
  EXPECT_GT(played.damaged + played.missing, 0);
  ASSERT_FALSE(played.frames.empty());
  EXPECT_LT(played.frames.size(), sent.frames.size());
  std::vector<const video::VideoFrame*> as_sent;
  for (const video::LiveFrame& live : played.frames) {
    const double time_s = live.frame.time_s + played.first_stamp_s;
    const auto same = std::ranges::find_if(
        sent.frames, [&](const video::VideoFrame& frame) { return std::abs(frame.time_s - time_s) < 1e-4; });
    ASSERT_NE(same, sent.frames.end()) << time_s;
    as_sent.push_back(&*same);
  }
  // Of the last picture before a key frame the decoder alone can tell, which overlooks one damage of eight.
  for (std::size_t i = 0; i + 1 < as_sent.size(); ++i) {
    if (as_sent[i + 1]->index % kKeyEvery == 0) continue;
    EXPECT_EQ(cv::norm(played.frames[i].frame.luma, as_sent[i]->luma, cv::NORM_INF), 0) << as_sent[i]->index;
  }
}

TEST(LiveStream, ARawStreamTakesItsTimesFromTheRate) {
  for (const std::string form : {"mjpeg", "mpjpeg"}) {  // the second as web cameras send it
    SCOPED_TRACE(form);
    const TemporaryFolder folder;
    const auto film = folder / ("film." + form), recording = folder / "video.mkv";
    Ffmpeg(TestPicture("size=160x120:rate=25:duration=1") + "-c:v mjpeg -f " + form + " " + Quote(film));
    EXPECT_THAT(ReasonOf(film.string(), Replay(), recording), testing::HasSubstr("--rate"));
    LiveStreamOptions options = Replay();
    options.rate_hz = 60;
    const Played played = Play(film.string(), options, recording);
    ASSERT_EQ(played.frames.size(), 25u);
    for (std::size_t i = 0; i < played.frames.size(); ++i)
      EXPECT_NEAR(played.frames[i].frame.time_s, static_cast<double>(i) / 60, 1e-6);
    ExpectRecorded(played, recording);
  }
}

TEST(LiveStream, SilenceEndsIt) {
  const TemporaryFolder folder;
  const auto pipe = folder / "pipe", film = folder / "film.ts";
  Ffmpeg(TestPicture("size=160x120:rate=25:duration=1") + "-c:v libx264 -g 5 -bf 0 " + Quote(film));
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::atomic<bool> is_done = false;
  std::thread writer([&] {  // keeps the pipe open, as a camera that has frozen
    const std::string bytes = ReadTextFile(film);
    const FileDescriptor end(open(pipe.c_str(), O_WRONLY));
    ASSERT_EQ(write(end, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    while (!is_done) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  });
  LiveStreamOptions options;
  options.patience_s = 1;
  const Played played = Play(pipe.string(), options, folder / "video.mkv");
  is_done = true;
  writer.join();
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kLost);
  EXPECT_GE(played.frames.size(), 24u);  // the last of a transport stream is known to be whole by the next
  ExpectRecorded(played, folder / "video.mkv");
}

TEST(LiveStream, AFullDiskLeavesWholeClusters) {
  const TemporaryFolder folder;
  // 2 MB/s of noise, so that the limit is met in the middle of a cluster.
  Ffmpeg("-f lavfi -i 'nullsrc=size=320x240:rate=30:duration=3,geq=random(1)*255:128:128' -c:v mjpeg -q:v 4 " +
         Quote(folder / "film.avi"));
  const auto bytes = std::filesystem::file_size(folder / "film.avi");
  Played played;
  {
    const FileLimit limit(bytes / 2);
    played = Play((folder / "film.avi").string(), Replay(), folder / "video.mkv");
  }
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kDiskFull);
  EXPECT_THAT(played.end.why, testing::HasSubstr("video.part.mkv: cannot be written further"));
  const Recording recorded = ReadAll(folder / "video.mkv");
  EXPECT_GT(recorded.frames.size(), 20u);
  EXPECT_LE(recorded.frames.size(), played.frames.size());
}

TEST(LiveStream, ARecordingThatWasCutIsCompleted) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=2") + "-c:v libx264 -g 10 -bf 2 " + Quote(folder / "film.mkv"));
  const std::string bytes = ReadTextFile(folder / "film.mkv");
  WriteTextFile(folder / "video.part.mkv", bytes.substr(0, bytes.size() * 2 / 3));
  EXPECT_NE(ErrorOf(folder / "video.part.mkv"), "");
  video::CompleteRecording(folder / "video.mkv");
  EXPECT_GT(ReadAll(folder / "video.mkv").frames.size(), 10u);
  EXPECT_FALSE(std::filesystem::exists(folder / "video.part.mkv"));
}

// How many packets end before so many bytes of the file.
std::size_t PacketsBefore(const std::filesystem::path& video, std::size_t bytes) {
  const TemporaryFolder folder;
  Shell(fmt::format("ffprobe -v error -show_entries packet=pos,size -of csv=p=0 {} > {}", Quote(video),
                    Quote(folder / "packets")));
  std::istringstream lines(ReadTextFile(folder / "packets"));
  std::size_t packets = 0, size = 0, at = 0;
  constexpr std::size_t kHeader = 16;  // of a Matroska block, at most
  for (char comma = 0; lines >> size >> comma >> at;)
    if (at + kHeader + size <= bytes) ++packets;
  return packets;
}

// Killed at any byte: what stands before it is kept, and the file's torn end is no damage.
TEST(LiveStream, ARecordingIsCompletedWhereverItWasCut) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=96x64:rate=30:duration=1") + "-c:v mjpeg -f matroska -cluster_time_limit 300 " +
         Quote(folder / "film.mkv"));
  const std::string bytes = ReadTextFile(folder / "film.mkv");
  for (std::size_t percent = 31; percent < 100; percent += 7) {
    SCOPED_TRACE(percent);
    const std::size_t cut = bytes.size() * percent / 100;
    std::filesystem::remove(folder / "video.mkv");
    WriteTextFile(folder / "video.part.mkv", bytes.substr(0, cut));
    video::CompleteRecording(folder / "video.mkv");
    const std::size_t whole = PacketsBefore(folder / "film.mkv", cut);
    EXPECT_GT(whole, 5u);
    EXPECT_GE(ReadAll(folder / "video.mkv").frames.size(), whole);
  }
}

// A hole, which the packets' counters show.
TEST(LiveStream, ARecordingDamagedInItsMiddleIsLeftAsItIs) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=2") + kH264 + Quote(folder / "film.ts"));
  std::string bytes = ReadTextFile(folder / "film.ts");
  constexpr std::size_t kPacket = 188;
  bytes.erase(bytes.size() / kPacket / 2 * kPacket, 3 * kPacket);
  WriteTextFile(folder / "video.part.mkv", bytes);
  EXPECT_THROW(video::CompleteRecording(folder / "video.mkv"), Error);
  EXPECT_EQ(ReadTextFile(folder / "video.part.mkv"), bytes);
  EXPECT_FALSE(std::filesystem::exists(folder / "video.mkv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "video.whole.mkv"));
}

// 0 if the interrupt in the middle of the file was thrown, and what was left is still there.
int CompleteUntilInterrupted() {
  const TemporaryFolder folder;
  const auto part = folder / "video.part.mkv";
  Ffmpeg("-f lavfi -i 'nullsrc=size=320x240:rate=30:duration=2,geq=random(1)*255:128:128' -c:v mjpeg -q:v 4 " +
         Quote(folder / "film.mkv"));
  const std::string bytes = ReadTextFile(folder / "film.mkv");
  if (mkfifo(part.c_str(), 0600) != 0) return 1;
  CatchInterrupts();
  std::thread writer([&] {  // all but what the pipe holds has been read when the signal comes
    const FileDescriptor end(open(part.c_str(), O_WRONLY));
    const auto most = static_cast<ssize_t>(bytes.size() * 2 / 3);
    const bool is_written = write(end, bytes.data(), static_cast<std::size_t>(most)) == most;
    std::raise(is_written ? SIGINT : SIGKILL);
  });
  int code = 2;
  try {
    video::CompleteRecording(folder / "video.mkv");
  } catch (const Interrupted&) {
    code = std::filesystem::exists(part) && !std::filesystem::exists(folder / "video.mkv") ? 0 : 3;
  }
  writer.join();
  return code;
}

// In a process of its own, as a signal stays.
TEST(LiveStreamDeathTest, AnInterruptedCompletionLosesNothing) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::_Exit(CompleteUntilInterrupted()), testing::ExitedWithCode(0), "");
}

// Each frame that is handed out is the whole film's of its number, to the bit; returns how many were not.
std::int64_t ExpectWholeFrames(const std::filesystem::path& damaged, const Recording& whole) {
  const TemporaryFolder folder;
  const Played played = Play(damaged.string(), Replay(), folder / "video.mkv");
  EXPECT_EQ(played.frames.size() + static_cast<std::size_t>(played.damaged), whole.frames.size());
  for (const video::LiveFrame& live : played.frames) {
    const auto index = static_cast<std::size_t>(live.frame.index);
    if (index >= whole.frames.size()) return played.damaged;
    EXPECT_EQ(LargestDifference(live.frame.luma, whole.frames[index].luma), 0) << "frame " << index;
  }
  return played.damaged;
}

TEST(LiveStream, DamagedPicturesAreCountedNotHandedOut) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x240:rate=60:duration=0.5,noise=alls=12:allf=t") + "-c:v mjpeg -q:v 3 " +
         Quote(folder / "film.avi"));
  const Recording whole = ReadAll(folder / "film.avi");
  const std::string bytes = ReadTextFile(folder / "film.avi");
  std::size_t chunk = bytes.find("movi");
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    for (int i = 0; i < 3; ++i) chunk = bytes.find("00dc", chunk + 1);
    std::mt19937 random(seed);
    std::string changed = bytes;
    constexpr std::size_t kIntoPicture = 2000;  // of some 20 kB
    for (std::size_t i = 0; i < 400; ++i) changed[chunk + kIntoPicture + i] = static_cast<char>(random());
    WriteTextFile(folder / "damaged.avi", changed);
    EXPECT_EQ(ExpectWholeFrames(folder / "damaged.avi", whole), 1);  // each picture is coded by itself
  }
}

// The same half second twice: all is recorded, with stamps that go on.
TEST(LiveStream, AClockThatIsSetBackEndsNothing) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=0.5") + "-c:v mpeg2video -bf 0 " + Quote(folder / "a.mpg"));
  const std::string bytes = ReadTextFile(folder / "a.mpg");
  WriteTextFile(folder / "twice.mpg", bytes + bytes);
  const Played played = Play((folder / "twice.mpg").string(), Replay(), folder / "video.mkv");
  EXPECT_EQ(played.end.kind, StreamEnd::Kind::kEnded);
  EXPECT_THAT(played.end.why, testing::HasSubstr("the camera's clock was set back 1 time"));
  EXPECT_GE(played.frames.size(), 29u);  // the first half's last packet ends with the next one's beginning
  ExpectRecorded(played, folder / "video.mkv");
}

TEST(LiveStream, WhatNobodyReadIsNoRecording) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=0.2") + kH264 + Quote(folder / "film.mp4"));
  { const LiveStream stream((folder / "film.mp4").string(), Replay(), folder / "video.mkv"); }
  EXPECT_EQ(FilesIn(folder), 1);
  EXPECT_EQ(Play((folder / "film.mp4").string(), Replay(), folder / "video.mkv").frames.size(), 6u);
}

TEST(LiveStream, NothingIsWrittenOver) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=1") + kH264 + Quote(folder / "film.mp4"));
  WriteTextFile(folder / "video.mkv", "a recording");
  EXPECT_THAT(ReasonOf((folder / "film.mp4").string(), Replay(), folder / "video.mkv"),
              testing::HasSubstr("is there already"));
}

TEST(LiveStream, SaysWhatCannotBeOpened) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "text.txt", "no video\n");
  const auto why = [&](const std::string& input, const LiveStreamOptions& options) {
    return ReasonOf(input, options, folder / "video.mkv");
  };
  EXPECT_THAT(why((folder / "absent").string(), {}), testing::HasSubstr("no such device or file"));
  EXPECT_THAT(why((folder / "text.txt").string(), {}), testing::HasSubstr("--replay"));
  EXPECT_THAT(why((folder / "text.txt").string(), Replay()), testing::HasSubstr("no video that can be read"));
}

}  // namespace
}  // namespace lake::test
