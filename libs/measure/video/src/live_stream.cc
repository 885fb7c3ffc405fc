#include "lake/video/live_stream.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <utility>

#include "damage_log.h"
#include "lake/core/counted.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/threads.h"
#include "live_input.h"
#include "lossless_encoder.h"
#include "missing_pictures.h"
#include "orientation.h"
#include "picture.h"
#include "recorder.h"
#include "stamps.h"

namespace lake::video {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kBytesPerMb = 1e6;

bool IsInterrupted() {
  try {
    ThrowIfInterrupted();
  } catch (const Interrupted&) {
    return true;
  }
  return false;
}

AVRational RateOf(const AVStream& stream, double given_hz) {
  if (given_hz > 0) return av_d2q(given_hz, 100000);
  return stream.avg_frame_rate.num > 0 ? stream.avg_frame_rate : stream.r_frame_rate;
}

}  // namespace

void Describe(LiveStreamOptions& o, OptionList& options) {
  options.Add("size", o.size, "Of a device: size of its pictures").Value("WxH").Otherwise("the device's own");
  options
      .Add("rate", o.rate_hz, "Of a device: its frame rate; of a raw stream, which has no time stamps: the rate of it")
      .Unit("Hz")
      .Positive()
      .Otherwise("the device's, or the stream's own times");
  options.Add("format", o.format, "Of a device: how it sends its pictures, coded: mjpeg, h264")
      .Otherwise("the device's own");
  options.Add(
      "replay", o.replay,
      "The input is a file, whose frames come at the pace at which they were taken; with --open from Begin trial on");
  options.Add("patience", o.patience_s, "A stream that has sent nothing for so long has ended").Unit("s").Positive();
  options.Add("least-free", o.least_free_mb, "Stop recording before less than so many MB are free on the disk")
      .Value("MB")
      .NotNegative();
}

// What belongs to one thread stands together.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
struct LiveStream::Impl {
  struct Received {
    libav::Packet packet;
    Clock::time_point arrived;
    bool follows_loss = false;  // what came before it is damaged, and was left out
  };

  // One that was sent to the decoder.
  struct Sent {
    std::int64_t number, ticks;
    Clock::time_point arrived;
  };

  Impl(const std::string& input, const LiveStreamOptions& options, const fs::path& recording);
  ~Impl();

  const AVCodecParameters& Coded() const;
  void OpenDecoder();
  void FillInfo(const AVFrame& first);
  void CheckSpace() const;
  bool GivesUp() const;
  void SetStopped();

  // The receiver's thread.
  void Receive();
  void Take(libav::Packet packet);
  libav::Packet KeepUnstamped(libav::Packet& packet);
  bool TakeTimes(AVPacket& packet);
  bool WaitForPace(const AVPacket& packet);
  bool TakeStamps(AVPacket& packet);
  void NoteGaps(std::int64_t ticks);
  void NoteEnd(StreamEnd::Kind kind, std::string why);

  bool Read(LiveFrame& frame);
  std::optional<Received> Next();
  bool IsKeyNext();
  void Feed();
  void NoteDamage();
  bool IsWhole(const AVFrame& decoded);
  Clock::time_point ArrivalOf(const AVFrame& decoded);
  libav::Packet Code(const AVPacket& raw);
  void Record(const AVPacket& packet);
  void HandOut(const std::shared_ptr<AVFrame>& decoded, LiveFrame& frame);
  void Finish();
  void FinishRecording();

  std::string input_name;
  LiveStreamOptions options;
  fs::path recording;
  std::atomic<Clock::rep> last_came = Clock::now().time_since_epoch().count();
  std::atomic<bool> is_stopped = false, is_held = false;
  std::atomic<std::int64_t> missing = 0;  // the receiver's `gaps`, for others
  DamageLog log;
  LiveInput input;
  std::optional<LosslessEncoder> lossless;  // of raw pictures; all else is recorded as it comes
  libav::Codec codec;
  VideoInfo info;
  std::optional<Stamps> stamps;
  std::optional<PictureConverter> converter;
  Orientation orientation;
  int width = 0, height = 0, format = AV_PIX_FMT_NONE;
  std::unique_ptr<Recorder> recorder;
  bool coding_failed = false, recorder_failed = false;

  // The receiver's.
  std::int64_t packets = 0, first_ticks = AV_NOPTS_VALUE, last_dts = AV_NOPTS_VALUE;
  std::int64_t interval = 0, set_back = 0;  // ticks between the last two packets; by how much the clock was set back
  int times_set_back = 0, left_out = 0, torn = 0;
  bool is_loss_before = false;
  libav::Packet unstamped;  // the first, until the second comes
  MissingPictures gaps;
  Clock::time_point began, space_checked = Clock::now();
  std::int64_t pace_from = AV_NOPTS_VALUE;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Received> queue;
  std::size_t queued_bytes = 0;
  std::optional<StreamEnd> end;

  // The reader's.
  bool is_read = false;
  std::deque<Sent> sent;  // whose frames have not come out
  std::int64_t sent_packets = 0;
  Clock::time_point last_arrived;  // of the one sent last
  std::set<std::int64_t> broken;   // packets since the last whole key frame that were damaged
  std::int64_t index = 0, damaged = 0;
  bool is_flushed = false, is_next_torn = false;

  std::thread thread;
};

LiveStream::Impl::Impl(const std::string& input_text, const LiveStreamOptions& o, const fs::path& recording_path)
    : input_name(input_text), options(o), recording(recording_path), is_held(o.is_held), input(input_text, o, [this] {
        return GivesUp();
      }) {
  const AVStream& stream = input.Stream();
  if (!input.HasTimes() && options.rate_hz <= 0)
    throw Fail("{}: a raw stream has no time stamps; say how many pictures a second it has, --rate HZ", input_name);
  for (const fs::path& file : {recording, UnfinishedRecording(recording)})
    if (fs::exists(file)) throw Fail("{}: is there already, and no recording is written over", file.string());
  CheckSpace();
  if (stream.codecpar->codec_id == AV_CODEC_ID_RAWVIDEO)
    lossless.emplace(input_name, *stream.codecpar, input.TimeBase());
  OpenDecoder();
  recorder = std::make_unique<Recorder>(UnfinishedRecording(recording), Coded(), input.TimeBase(),
                                        RateOf(stream, options.rate_hz));
  orientation = Orientation{}.TurnedOn(options.rotate_deg / 90);
  stamps.emplace(input.TimeBase(), 0);
  thread = std::thread([this] { Receive(); });
}

LiveStream::Impl::~Impl() {
  SetStopped();
  if (thread.joinable()) thread.join();
  if (is_read) return;  // what was recorded is kept, however it ends
  recorder.reset();
  std::error_code ignored;
  fs::remove(UnfinishedRecording(recording), ignored);
}

void LiveStream::Impl::SetStopped() {
  const std::lock_guard lock(mutex);
  is_stopped = true;
  changed.notify_all();
}

bool LiveStream::Impl::GivesUp() const {
  const std::chrono::duration<double> silent = Clock::now().time_since_epoch() - Clock::duration(last_came);
  return is_stopped || silent.count() > options.patience_s || IsInterrupted();
}

void LiveStream::Impl::CheckSpace() const {
  std::error_code error;
  const fs::space_info space = fs::space(recording.parent_path().empty() ? "." : recording.parent_path(), error);
  if (!error && static_cast<double>(space.available) < options.least_free_mb * kBytesPerMb)
    throw Fail("{}: the disk is full: less than {:.0f} MB are free", recording.string(), options.least_free_mb);
}

// What is recorded and looked at.
const AVCodecParameters& LiveStream::Impl::Coded() const {
  return lossless ? lossless->Parameters() : *input.Stream().codecpar;
}

// Without frame threads, which hold back as many frames as they are.
void LiveStream::Impl::OpenDecoder() {
  const AVStream& stream = input.Stream();
  const AVCodecParameters& coded = Coded();
  const AVCodec* decoder = avcodec_find_decoder(coded.codec_id);
  if (!decoder) throw Fail("{}: no decoder for {}", input_name, avcodec_get_name(coded.codec_id));
  codec = libav::NewCodec(decoder);
  avcodec_parameters_to_context(codec.get(), &coded);
  log.Attach(*codec);
  codec->pkt_timebase = input.TimeBase();
  codec->thread_count = Threads();
  codec->thread_type = FF_THREAD_SLICE;
  codec->flags |= AV_CODEC_FLAG_UNALIGNED;
  codec->max_pixels = libav::kMaxPixels;
  const int result = avcodec_open2(codec.get(), decoder, nullptr);
  if (result < 0)
    throw Fail("{}: the {} decoder cannot be started ({})", input_name, decoder->name, libav::ErrorText(result));
  width = coded.width;
  height = coded.height;
  if (width <= 0 || height <= 0) throw Fail("{}: its picture size cannot be found", input_name);
  const bool turns = options.rotate_deg % 180 != 0;
  info.width = turns ? height : width;
  info.height = turns ? width : height;
  info.rotation_deg = options.rotate_deg;
  info.codec = avcodec_get_name(coded.codec_id);
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(coded.codec_id);
  info.coded_frame_by_frame = descriptor && (descriptor->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
  const AVRational rate = RateOf(stream, options.rate_hz);
  if (rate.num > 0 && rate.den > 0) info.frame_rate_hz = av_q2d(rate);
}

void LiveStream::Impl::FillInfo(const AVFrame& first) {
  const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(first.format));
  format = first.format;
  info.pixel_format = name ? name : "unknown";
  info.bt709 = IsBt709(first);
  info.white_level = WhiteLevel(first);
  info.interlaced = first.interlaced_frame;
}

void LiveStream::Impl::NoteEnd(StreamEnd::Kind kind, std::string why) {
  const std::lock_guard lock(mutex);
  if (!end) end = {kind, std::move(why)};
  changed.notify_all();
}

void LiveStream::Impl::Receive() {
  while (true) {
    libav::Packet packet = libav::NewPacket();
    last_came = Clock::now().time_since_epoch().count();  // silence counts from here
    const int result = input.Read(*packet);
    if (is_stopped || IsInterrupted()) return NoteEnd(StreamEnd::Kind::kStopped, "it was stopped");
    if (result == AVERROR_EOF) return NoteEnd(StreamEnd::Kind::kEnded, "the stream ended");
    if (result == AVERROR_EXIT)
      return NoteEnd(StreamEnd::Kind::kLost, fmt::format("nothing has come for {} s", options.patience_s));
    if (result < 0)
      return NoteEnd(StreamEnd::Kind::kLost, fmt::format("nothing comes any more ({})", libav::ErrorText(result)));
    try {
      Take(std::move(packet));
    } catch (const Error& error) {
      const bool is_disk = !coding_failed && (!recorder_failed || recorder->IsDiskFailing());
      return NoteEnd(is_disk ? StreamEnd::Kind::kDiskFull : StreamEnd::Kind::kUnrecorded, error.what());
    } catch (const std::exception& error) {  // no memory
      return NoteEnd(StreamEnd::Kind::kUnrecorded, fmt::format("{}: {}", input_name, error.what()));
    }
  }
}

// Of a file: until it would have come.
bool LiveStream::Impl::WaitForPace(const AVPacket& packet) {
  const std::int64_t ticks = packet.dts != AV_NOPTS_VALUE ? packet.dts : packet.pts;
  if (pace_from == AV_NOPTS_VALUE) {
    pace_from = ticks;
    began = Clock::now();
  }
  constexpr std::chrono::milliseconds kLook{50};
  const std::chrono::duration<double> after(libav::Seconds(ticks - pace_from, input.TimeBase()));
  std::unique_lock lock(mutex);
  while (is_held && packets > input.Stream().codecpar->video_delay) {  // so many are needed to decode the first picture
    if (is_stopped || IsInterrupted()) return false;
    changed.wait_for(lock, kLook);
    began = Clock::now() - std::chrono::duration_cast<Clock::duration>(after);
  }
  while (Clock::now() < began + after) {
    if (is_stopped || IsInterrupted()) return false;
    changed.wait_until(lock,
                       std::min(Clock::now() + kLook, began + std::chrono::duration_cast<Clock::duration>(after)));
  }
  return true;
}

// False if the packet has none, or comes before anything can be decoded.
bool LiveStream::Impl::TakeTimes(AVPacket& packet) {
  if (!input.HasTimes()) {
    const double interval_ticks = 1 / options.rate_hz / av_q2d(input.TimeBase());
    packet.pts = packet.dts = std::llround(static_cast<double>(packets) * interval_ticks);
    packet.duration = std::llround(interval_ticks);
  }
  if (packets == 0 && !(packet.flags & AV_PKT_FLAG_KEY)) return false;
  if (packet.pts == AV_NOPTS_VALUE) packet.pts = packet.dts;
  if (packet.pts == AV_NOPTS_VALUE) return false;
  if (options.replay && !WaitForPace(packet)) return false;
  if (first_ticks == AV_NOPTS_VALUE) first_ticks = packet.pts;
  return TakeStamps(packet);
}

// libav's parser loses the stamp of an RTP stream's first picture, on which the next ones build: it is put one interval
// before the second. Returns the first once the second is there, with its stamp. Where pictures do not come in their
// order, or at an unknown rate, it is unknown.
libav::Packet LiveStream::Impl::KeepUnstamped(libav::Packet& packet) {
  const AVStream& stream = input.Stream();
  const AVRational rate = RateOf(stream, options.rate_hz);
  const bool has_stamp = packet->pts != AV_NOPTS_VALUE || packet->dts != AV_NOPTS_VALUE;
  if (packets > 0 || !input.HasTimes() || rate.num <= 0 || stream.codecpar->video_delay > 0) return nullptr;
  if (!has_stamp && !unstamped && (packet->flags & AV_PKT_FLAG_KEY)) {
    unstamped = std::move(packet);
    return nullptr;
  }
  if (!has_stamp || !unstamped) return nullptr;
  unstamped->pts =
      (packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts) - av_rescale_q(1, av_inv_q(rate), input.TimeBase());
  unstamped->dts = unstamped->pts;
  return std::move(unstamped);
}

void LiveStream::Impl::Take(libav::Packet packet) {
  if (libav::Packet first = KeepUnstamped(packet)) Take(std::move(first));
  if (!packet) return;  // kept
  if (!TakeTimes(*packet)) {
    is_loss_before |= (packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
    return;
  }
  if (lossless) packet = Code(*packet);
  if (!packet) {
    ++torn;
    return;
  }
  ++packets;
  if (packet->dts != AV_NOPTS_VALUE)
    NoteGaps(packet->dts);
  else if (input.Stream().codecpar->video_delay == 0)  // else pictures do not come in their order
    NoteGaps(packet->pts);
  constexpr std::chrono::milliseconds kLook{500};
  const Clock::time_point now = Clock::now();
  if (now - space_checked > kLook) {
    CheckSpace();
    space_checked = now;
  }
  if (recorder) Record(*packet);
  std::unique_lock lock(mutex);
  constexpr std::size_t kMostBytes = 256 << 20;  // then a pipe's writer waits, and a device leaves frames out
  changed.wait(lock, [&] { return queued_bytes < kMostBytes || is_stopped; });
  queued_bytes += static_cast<std::size_t>(packet->size);
  queue.push_back({std::move(packet), now, std::exchange(is_loss_before, false)});
  changed.notify_all();
}

void LiveStream::Impl::NoteGaps(std::int64_t ticks) {
  gaps.Add(ticks);
  missing = gaps.Missing();
}

// Moves them to the recording's, which begins at 0 and never steps back. False if the packet has no place in it.
bool LiveStream::Impl::TakeStamps(AVPacket& packet) {
  // Less is a packet that the network brought twice or too late.
  constexpr double kLeastSetBack_s = 0.1;
  const AVRational time_base = input.TimeBase();
  const bool has_dts = packet.dts != AV_NOPTS_VALUE;
  const std::int64_t behind =
      has_dts && last_dts != AV_NOPTS_VALUE ? last_dts - (packet.dts - first_ticks + set_back) : -1;
  if (behind >= 0 && libav::Seconds(behind, time_base) < kLeastSetBack_s) {
    ++left_out;
    return false;
  }
  if (behind >= 0) {
    set_back += behind + std::max<std::int64_t>(interval, 1);
    ++times_set_back;
  }
  packet.pts += set_back - first_ticks;
  if (packet.pts < 0) return false;  // builds on what came before the first key frame
  if (!has_dts) return true;
  packet.dts = std::min(packet.dts + set_back - first_ticks, packet.pts);  // not shown before it is decoded
  if (last_dts != AV_NOPTS_VALUE) {
    if (packet.dts < last_dts) {
      ++left_out;
      return false;
    }
    interval = packet.dts - last_dts;
  }
  last_dts = packet.dts;
  return true;
}

libav::Packet LiveStream::Impl::Code(const AVPacket& raw) {
  try {
    return lossless->Encode(raw);
  } catch (...) {
    coding_failed = true;
    throw;
  }
}

void LiveStream::Impl::Record(const AVPacket& packet) {
  try {
    recorder->Write(packet);
  } catch (...) {
    recorder_failed = true;
    throw;
  }
}

std::optional<LiveStream::Impl::Received> LiveStream::Impl::Next() {
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return !queue.empty() || end; });
  if (queue.empty()) return std::nullopt;
  Received received = std::move(queue.front());
  queue.pop_front();
  queued_bytes -= static_cast<std::size_t>(received.packet->size);
  changed.notify_all();
  return received;
}

// Waits for it. Where nothing follows, nothing is built on what was lost.
bool LiveStream::Impl::IsKeyNext() {
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return !queue.empty() || end; });
  return queue.empty() || (queue.front().packet->flags & AV_PKT_FLAG_KEY) != 0;
}

// The next packet to the decoder, or that nothing follows.
void LiveStream::Impl::Feed() {
  std::optional<Received> received = Next();
  is_flushed = !received;
  if (!received) {
    avcodec_send_packet(codec.get(), nullptr);
    return;
  }
  AVPacket& packet = *received->packet;
  last_arrived = received->arrived;
  sent.push_back({sent_packets, packet.pts, received->arrived});
  log.SetPacket(*codec, packet, sent_packets++);
  const int result = avcodec_send_packet(codec.get(), &packet);
  NoteDamage();
  // A transport stream's packets are numbered: of this picture some were lost, or of those between it and the next, of
  // which a decoder says nothing. libav says so one picture too early, as it holds back the one that it cuts out.
  const bool is_torn = is_next_torn && !IsKeyNext();
  if (is_torn || (received->follows_loss && !(packet.flags & AV_PKT_FLAG_KEY))) broken.insert(sent.back().number);
  is_next_torn = (packet.flags & AV_PKT_FLAG_CORRUPT) != 0;
  if (result >= 0) return;
  broken.insert(sent.back().number);  // the recording has it, but no frame of it will come
  ++damaged;
  ++index;
}

// Without frame threads libav reports damage while it works on the packet.
void LiveStream::Impl::NoteDamage() {
  if (const std::optional<std::int64_t> packet = log.TakeDamage()) broken.insert(*packet);
}

// Neither damaged nor built on what is.
bool LiveStream::Impl::IsWhole(const AVFrame& decoded) {
  const std::int64_t packet = DamageLog::PacketOf(decoded);
  if ((decoded.flags & AV_FRAME_FLAG_CORRUPT) || decoded.decode_error_flags != 0) broken.insert(packet);
#ifdef AV_FRAME_FLAG_KEY
  const bool is_key_frame = (decoded.flags & AV_FRAME_FLAG_KEY) != 0;
#else
  const bool is_key_frame = decoded.key_frame != 0;
#endif
  if (!is_key_frame) return broken.empty() || packet < *broken.begin();
  if (broken.contains(packet)) return false;
  broken.erase(broken.begin(), broken.lower_bound(packet));
  return true;
}

bool LiveStream::Impl::Read(LiveFrame& frame) {
  is_read = true;
  while (true) {
    const std::shared_ptr<AVFrame> decoded = libav::NewFrame();
    const int result = avcodec_receive_frame(codec.get(), decoded.get());
    NoteDamage();
    if (result == AVERROR_EOF) return false;
    if (result == AVERROR(EAGAIN)) {
      if (is_flushed) return false;
      Feed();
      continue;
    }
    if (result < 0) {  // of the packet sent last; libav ends draining after some of these
      broken.insert(sent_packets - 1);
      ++damaged;
      ++index;
      continue;
    }
    if (format == AV_PIX_FMT_NONE) FillInfo(*decoded);
    if (decoded->width != width || decoded->height != height || decoded->format != format) {
      NoteEnd(StreamEnd::Kind::kLost, "its pictures changed their size or format");
      SetStopped();
      return false;
    }
    if (IsWhole(*decoded) && stamps->Add(decoded->best_effort_timestamp, 0)) {
      HandOut(decoded, frame);
      return true;
    }
    ++damaged;
    ++index;
  }
}

void LiveStream::Impl::HandOut(const std::shared_ptr<AVFrame>& decoded, LiveFrame& live) {
  if (!converter) converter.emplace(*decoded);
  stamps->Describe(info);
  live.frame.index = index++;
  live.frame.time_s = stamps->Last();
  live.frame.luma = orientation.Apply(converter->Luma(*decoded));
  const AVBufferRef* memory = decoded->buf[0];
  const bool shares = live.frame.luma.data >= memory->data && live.frame.luma.data < memory->data + memory->size;
  live.frame.keep_alive = shares ? decoded : nullptr;
  live.arrived = ArrivalOf(*decoded);
}

// By its stamp, as a frame that is shown again has a later packet's. A stamp that the decoder made up is no packet's;
// then by the number of the packet that it was decoded from, or that it came out upon.
Clock::time_point LiveStream::Impl::ArrivalOf(const AVFrame& decoded) {
  const std::int64_t ticks = decoded.best_effort_timestamp;
  auto packet = std::ranges::find(sent, ticks, &Sent::ticks);
  if (packet == sent.end()) packet = std::ranges::find(sent, DamageLog::PacketOf(decoded), &Sent::number);
  const Clock::time_point arrived = packet == sent.end() ? last_arrived : packet->arrived;
  std::erase_if(sent, [&](const Sent& one) { return one.ticks <= ticks; });
  return arrived;
}

void LiveStream::Impl::Finish() {
  SetStopped();
  if (thread.joinable()) thread.join();
  FinishRecording();
  if (end && times_set_back > 0)
    end->why += fmt::format("; the camera's clock was set back {}", Counted(times_set_back, "time"));
  if (end && left_out > 0)
    end->why += fmt::format("; {} that came twice or too late left out", Counted(left_out, "picture"));
  if (end && torn > 0) end->why += fmt::format("; {} left out", Counted(torn, "torn raw picture"));
  if (end && missing > 0)
    end->why +=
        fmt::format("; {} missing in {} of the time stamps, of up to {:.2f} s", Counted(missing.load(), "picture"),
                    Counted(gaps.Gaps(), "gap"), libav::Seconds(gaps.LongestTicks(), input.TimeBase()));
  const fs::path part = UnfinishedRecording(recording);
  if (!fs::exists(part)) throw Fail("{}: the recording is gone", part.string());
  std::error_code error;
  fs::rename(part, recording, error);
  if (error) throw Fail("{}: cannot be moved to {} ({})", part.string(), recording.string(), error.message());
}

void LiveStream::Impl::FinishRecording() {
  if (recorder && !recorder_failed) {
    try {
      recorder->Finish();
    } catch (const Error& error) {  // worse than why no more frames came
      end = {recorder->IsDiskFailing() ? StreamEnd::Kind::kDiskFull : StreamEnd::Kind::kUnrecorded, error.what()};
    }
  }
  recorder.reset();
}

LiveStream::LiveStream(const std::string& input, const LiveStreamOptions& options, const fs::path& recording)
    : impl_(std::make_unique<Impl>(input, options, recording)) {}

LiveStream::~LiveStream() = default;

const VideoInfo& LiveStream::Info() const {
  return impl_->info;
}

bool LiveStream::Read(LiveFrame& frame) {
  return impl_->Read(frame);
}

void LiveStream::Release() {
  impl_->is_held = false;
}

void LiveStream::Stop() {
  impl_->SetStopped();
}

const StreamEnd& LiveStream::End() const {
  return *impl_->end;
}

std::int64_t LiveStream::DamagedFrames() const {
  return impl_->damaged;
}

std::int64_t LiveStream::MissingFrames() const {
  return impl_->missing;
}

double LiveStream::FirstStampS() const {
  return impl_->first_ticks == AV_NOPTS_VALUE ? 0 : libav::Seconds(impl_->first_ticks, impl_->input.TimeBase());
}

void LiveStream::Finish() {
  impl_->Finish();
}

fs::path UnfinishedRecording(const fs::path& recording) {
  fs::path part = recording;
  return part.replace_extension(".part" + recording.extension().string());
}

namespace {

// Whatever ends it before the file does is thrown. The last packet may be a torn one.
void CopyWholePackets(const fs::path& from, const fs::path& to) {
  LiveStreamOptions file;
  file.replay = true;
  LiveInput input(from.string(), file, [] { return IsInterrupted(); });
  const AVStream& stream = input.Stream();
  Recorder recorder(to, *stream.codecpar, stream.time_base, RateOf(stream, 0));
  const libav::Packet packet = libav::NewPacket();
  std::int64_t packets = 0;
  int result = 0;
  for (; (result = input.Read(*packet)) >= 0; ++packets) {
    ThrowIfInterrupted();
    if (packet->flags & AV_PKT_FLAG_CORRUPT) {
      av_packet_unref(packet.get());
      result = input.Read(*packet);
      if (result >= 0) result = AVERROR_INVALIDDATA;
      break;
    }
    recorder.Write(*packet);
    av_packet_unref(packet.get());
  }
  ThrowIfInterrupted();
  if (result != AVERROR_EOF)
    throw Fail(
        "{}: is damaged after {} frames ({}) and left as it is; what can be saved: ffmpeg -i {} -c copy saved.mkv",
        from.string(), packets, libav::ErrorText(result), from.string());
  if (packets == 0) throw Fail("{}: holds no frame", from.string());
  recorder.Finish();
}

}  // namespace

void CompleteRecording(const fs::path& recording) {
  const fs::path part = UnfinishedRecording(recording);
  fs::path whole = recording;
  whole.replace_extension(".whole" + recording.extension().string());
  const DamageLog quiet;
  fs::remove(whole);  // of an attempt before
  try {
    CopyWholePackets(part, whole);
  } catch (...) {
    std::error_code ignored;  // what was thrown is the one to tell of
    fs::remove(whole, ignored);
    throw;
  }
  fs::rename(whole, recording);
  fs::remove(part);
}

}  // namespace lake::video
