#include "lake/review/frame_store.h"

#include <turbojpeg.h>

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "jpeg_encoder.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/video/video_files.h"

namespace lake::review {
namespace {

std::size_t BytesOf(const StoredFrame& frame) {
  return frame.jpeg->size() + frame.luma.total();
}

// A reader that can be put before any frame, and knows which frames it hands out.
class FrameSeeker {
 public:
  FrameSeeker(std::filesystem::path video, const video::VideoReaderOptions& reader) : video_(std::move(video)) {
    options_.rotate_deg = reader.rotate_deg;
    options_.capture_rate_hz = reader.capture_rate_hz;
    options_.colour = true;
    OpenAtStart();
    info_ = reader_->Info();
  }

  const video::VideoInfo& Info() const { return info_; }
  std::string Name() const { return video_.string(); }

  // False behind the last frame. Frames come in order, from one at or before `target` on: the one after the last that
  // was read, unless another place is nearer.
  bool ReadTowards(std::int64_t target, video::VideoFrame& frame) {
    if ((!reader_ || target < next_ || target > next_ + kWorthSeeking) && !Approach(target)) return false;
    if (held_) {
      frame = *std::exchange(held_, std::nullopt);
    } else if (!Read(frame)) {
      reader_.reset();
      return false;
    }
    next_ = frame.index + 1;
    return true;
  }

  std::int64_t Next() const { return reader_ ? next_ : std::numeric_limits<std::int64_t>::max(); }
  void Close() {
    reader_.reset();
    held_.reset();
  }

 private:
  static constexpr std::int64_t kWorthSeeking = 200;  // frames; a key frame is rarely farther away

  void OpenAtStart() {
    held_.reset();
    options_.seek_s.reset();
    reader_ = video::VideoReader::Open(video_, options_);
    next_ = 0;
    counts_from_start_ = true;
  }

  bool Read(video::VideoFrame& frame) {
    if (!reader_->Read(frame)) return false;
    if (counts_from_start_) return true;
    frame.index = IndexOf(frame.time_s);
    if (frame.index >= 0) return true;
    stamps_->clear();  // the container's stamps are not the frames' own
    OpenAtStart();
    return reader_->Read(frame);
  }

  // False where the container knows that there is no such frame.
  bool Approach(std::int64_t target) {
    if (!stamps_) FindStamps();
    if (!stamps_->empty() && target >= static_cast<std::int64_t>(stamps_->size())) return false;
    for (const double back_s : {0.0, 2.0, 10.0}) {
      if (target < kWorthSeeking || stamps_->empty()) break;
      if (SeekTo((*stamps_)[static_cast<std::size_t>(target)] - back_s, target)) return true;
    }
    if (!reader_ || target < next_) OpenAtStart();
    return true;
  }

  // Whether the reader now stands at or before the frame.
  bool SeekTo(double time_s, std::int64_t target) {
    video::VideoReaderOptions options = options_;
    options.seek_s = time_s;
    auto reader = video::VideoReader::Open(video_, options);
    video::VideoFrame first;
    if (!reader->Read(first)) return false;
    first.index = IndexOf(first.time_s);
    if (first.index < 0 || first.index > target) return false;
    reader_ = std::move(reader);
    next_ = first.index;
    counts_from_start_ = false;
    held_ = std::move(first);
    return true;
  }

  // -1 if no frame has this time stamp.
  std::int64_t IndexOf(double time_s) const {
    constexpr double kRounding_s = 1e-6;
    const auto found = std::lower_bound(stamps_->begin(), stamps_->end(), time_s - kRounding_s);
    if (found == stamps_->end() || *found > time_s + kRounding_s) return -1;
    return found - stamps_->begin();
  }

  // Those of the frames that are handed out: what stands before the first one cannot be decoded.
  void FindStamps() {
    const double capture_rate_hz = std::exchange(options_.capture_rate_hz, 0);  // where the stream has no stamps
    options_.seek_s.reset();
    stamps_ = video::StampsInContainer(video_, options_).value_or(std::vector<double>());
    if (stamps_->empty()) options_.capture_rate_hz = capture_rate_hz;
    video::VideoFrame first;
    if (stamps_->empty() || !video::VideoReader::Open(video_, options_)->Read(first)) return;
    const std::int64_t index = IndexOf(first.time_s);
    if (index < 0)
      stamps_->clear();
    else
      stamps_->erase(stamps_->begin(), stamps_->begin() + index);
  }

  std::filesystem::path video_;
  video::VideoReaderOptions options_;
  video::VideoInfo info_;
  std::unique_ptr<video::VideoReader> reader_;
  std::optional<video::VideoFrame> held_;  // read to see where the reader stands
  std::int64_t next_ = 0;
  bool counts_from_start_ = true;
  std::optional<std::vector<double>> stamps_;  // by frame; empty where the container does not tell them
};

}  // namespace

class FrameStore::Impl {
 public:
  Impl(const std::filesystem::path& video, const video::VideoReaderOptions& reader, const FrameStoreOptions& options)
      : options_(options), encoder_(options.quality), seeker_(video, reader), thread_([this] { Work(); }) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  const video::VideoInfo& Info() const { return seeker_.Info(); }

  StoredFrame Frame(std::int64_t frame) {
    std::unique_lock lock(mutex_);
    focus_ = frame;
    changed_.notify_all();
    if (const auto found = kept_.find(frame); found != kept_.end()) return found->second;
    const auto request = requests_.insert(requests_.end(), {frame, {}, {}});
    changed_.wait(lock, [&] { return stop_ || request->result || !request->error.empty(); });
    const Request done = std::move(*request);
    requests_.erase(request);
    if (done.result) return *done.result;
    throw Error(done.error.empty() ? "the program is ending" : done.error);
  }

  std::size_t BytesKept() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }

 private:
  struct Request {
    std::int64_t frame;
    std::optional<StoredFrame> result;
    std::string error;

    bool IsOpen() const { return !result && error.empty(); }
  };

  void Work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stop_ || Target(); });
      if (stop_) return;
      const std::int64_t target = *Target();
      lock.unlock();
      std::optional<video::VideoFrame> frame;
      std::optional<StoredFrame> stored;
      std::string error;
      try {
        frame.emplace();
        if (!seeker_.ReadTowards(target, *frame)) frame.reset();
        if (frame && frame->index >= target - options_.behind) stored = Store(*frame);
      } catch (const std::exception& failure) {
        frame.reset();
        error = FaultText(failure);
        seeker_.Close();
      }
      lock.lock();
      if (!frame)
        FailFrom(target, error);
      else if (stored)
        Keep(frame->index, *std::move(stored));
      else if (frame->index > target)
        FailFrom(target, fmt::format("{}: frame {} cannot be found", seeker_.Name(), target));
    }
  }

  // The frame to read next: the one asked for last; else one that is soon wanted and needs no way back.
  std::optional<std::int64_t> Target() const {
    for (auto request = requests_.rbegin(); request != requests_.rend(); ++request)
      if (request->IsOpen()) return request->frame;
    const std::int64_t next = seeker_.Next();
    if (next <= focus_ || next - focus_ > options_.ahead || (end_ && next >= *end_)) return std::nullopt;
    return next;
  }

  StoredFrame Store(const video::VideoFrame& frame) {
    return {std::make_shared<const std::string>(encoder_.Encode(frame.bgr)), frame.luma.clone()};
  }

  void Keep(std::int64_t index, StoredFrame frame) {
    for (Request& request : requests_)
      if (request.frame == index && request.IsOpen()) request.result = frame;
    if (const auto [place, is_new] = kept_.try_emplace(index, std::move(frame)); is_new)
      bytes_ += BytesOf(place->second);
    while (bytes_ > options_.most_bytes && kept_.size() > 1) {
      const auto first = kept_.begin(), last = std::prev(kept_.end());
      const auto farther = focus_ - first->first > last->first - focus_ ? first : last;
      bytes_ -= BytesOf(farther->second);
      kept_.erase(farther);
    }
    changed_.notify_all();
  }

  // Nothing can be read from the target on; without an error the recording ends before it.
  void FailFrom(std::int64_t target, const std::string& error) {
    if (!end_ || target < *end_) end_ = target;
    const std::string said = error.empty() ? fmt::format("{}: has no frame {}", seeker_.Name(), target) : error;
    for (Request& request : requests_)
      if (request.frame == target && request.IsOpen()) request.error = said;
    changed_.notify_all();
  }

  FrameStoreOptions options_;
  JpegEncoder encoder_;
  FrameSeeker seeker_;  // the thread's, but for Info()
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::int64_t, StoredFrame> kept_;
  std::size_t bytes_ = 0;
  std::list<Request> requests_;
  std::int64_t focus_ = 0;
  std::optional<std::int64_t> end_;  // nothing is read ahead from here on
  bool stop_ = false;
  std::thread thread_;
};

FrameStore::FrameStore(const std::filesystem::path& video, const video::VideoReaderOptions& reader,
                       const FrameStoreOptions& options)
    : impl_(std::make_unique<Impl>(video, reader, options)) {}

FrameStore::~FrameStore() = default;

const video::VideoInfo& FrameStore::Info() const {
  return impl_->Info();
}

StoredFrame FrameStore::Frame(std::int64_t frame) {
  if (frame < 0) throw Fail("frame {}: frames are counted from 0", frame);
  return impl_->Frame(frame);
}

std::size_t FrameStore::BytesKept() const {
  return impl_->BytesKept();
}

cv::Mat ColoursOf(const StoredFrame& frame) {
  cv::Mat bgr(frame.luma.size(), CV_8UC3);
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  const auto* bytes = reinterpret_cast<const unsigned char*>(frame.jpeg->data());
  if (!decoder || tjDecompress2(decoder.get(), bytes, frame.jpeg->size(), bgr.data, bgr.cols,
                                static_cast<int>(bgr.step), bgr.rows, TJPF_BGR, TJFLAG_ACCURATEDCT) != 0)
    throw Fail("a frame cannot be read back: {}", tjGetErrorStr2(decoder.get()));
  return bgr;
}

}  // namespace lake::review
