// Frames decoded ahead by a thread, so that decoding and processing overlap. The queue is long enough to bridge the
// slowest frames (the first ones of a tracker), within a limit on memory.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "lake/video/video_reader.h"

namespace lake::video {

class FrameQueue {
 public:
  explicit FrameQueue(VideoReader& reader) : reader_(reader), thread_([this] { Fill(); }) {}
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;
  ~FrameQueue() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  // False after the last frame; throws what the reader threw.
  bool Pop(VideoFrame& frame) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !frames_.empty() || done_; });
    if (frames_.empty()) {
      if (error_) std::rethrow_exception(error_);
      return false;
    }
    frame = std::move(frames_.front());
    frames_.pop_front();
    changed_.notify_all();
    return true;
  }

 private:
  static constexpr std::size_t kFewest = 4, kMost = 64, kBytes = 96 << 20;

  static std::size_t BytesOf(const VideoFrame& frame) {
    const auto bytes = [](const cv::Mat& picture) { return picture.total() * picture.elemSize(); };
    return 3 * bytes(frame.luma) / 2 + bytes(frame.bgr) + bytes(frame.preview);  // the decoder keeps the chroma too
  }

  void Fill() {
    try {
      for (VideoFrame frame; reader_.Read(frame);) {
        const std::size_t capacity = std::clamp(kBytes / std::max<std::size_t>(BytesOf(frame), 1), kFewest, kMost);
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return frames_.size() < capacity || stop_; });
        if (stop_) return;
        frames_.push_back(std::move(frame));
        frame = {};
        changed_.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  VideoReader& reader_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<VideoFrame> frames_;
  std::exception_ptr error_;
  bool done_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace lake::video
