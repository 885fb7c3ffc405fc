// A camera for tests, as there is none where they run: preloaded, it makes of one character device a V4L2 capture
// device that sends the files of a folder as Motion JPEG. Everything else goes to the kernel.
//
// LAKE_CAMERA_DEVICE: which device; LAKE_CAMERA_PICTURES: the folder (00001.jpg, 00002.jpg, …; an empty file is a
// picture that did not arrive whole); LAKE_CAMERA_SIZE, LAKE_CAMERA_RATE: "1280x720", "30", the only ones that it has;
// LAKE_CAMERA_END: the errno with which it answers after the last picture (19: it was unplugged), 0: it is frozen.
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <iterator>
#include <string>

namespace {

constexpr std::uint32_t kBuffers = 8, kBufferBytes = 1 << 20;  // whole pages; larger than any picture of the tests

std::string Setting(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

struct Camera {
  int fd = -1;
  std::uint32_t width = 0, height = 0, rate = 0, next = 1;
  std::deque<std::uint32_t> queued;

  int Open() {
    fd = memfd_create("camera", 0);  // its buffers, which are mapped
    if (fd < 0 || ftruncate(fd, static_cast<off_t>(kBuffers) * kBufferBytes) != 0) return -1;
    std::sscanf(Setting("LAKE_CAMERA_SIZE").c_str(), "%ux%u", &width, &height);
    std::sscanf(Setting("LAKE_CAMERA_RATE").c_str(), "%u", &rate);
    return fd;
  }

  static int Fail(int error) {
    errno = error;
    return -1;
  }

  int Capability(v4l2_capability& what) {
    what = {};
    what.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    return 0;
  }

  // As drivers do: what it does not have becomes what it has.
  int Format(v4l2_format& what) const {
    what.fmt.pix = {};
    what.fmt.pix.width = width;
    what.fmt.pix.height = height;
    what.fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
    what.fmt.pix.field = V4L2_FIELD_NONE;
    what.fmt.pix.sizeimage = kBufferBytes;
    return 0;
  }

  int Parameters(v4l2_streamparm& what) const {
    what.parm.capture = {};
    what.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
    what.parm.capture.timeperframe = {1, rate};
    return 0;
  }

  int Describe(v4l2_buffer& what) {
    if (what.index >= kBuffers) return Fail(EINVAL);
    what.length = kBufferBytes;
    what.m.offset = what.index * kBufferBytes;
    return 0;
  }

  int Queue(const v4l2_buffer& what) {
    queued.push_back(what.index);
    return 0;
  }

  int Take(v4l2_buffer& what) {
    char name[16];
    std::snprintf(name, sizeof name, "/%05u.jpg", next);
    std::ifstream file(Setting("LAKE_CAMERA_PICTURES") + name, std::ios::binary);
    if (!file) {
      const int end = std::atoi(Setting("LAKE_CAMERA_END").c_str());
      return Fail(end ? end : EAGAIN);
    }
    if (queued.empty()) return Fail(EAGAIN);
    const std::string picture(std::istreambuf_iterator<char>(file), {});
    what.index = queued.front();
    queued.pop_front();
    Describe(what);
    what.flags = picture.empty() ? V4L2_BUF_FLAG_ERROR : 0;
    what.bytesused = static_cast<std::uint32_t>(picture.size());
    const auto place = static_cast<off_t>(what.m.offset);
    if (pwrite(fd, picture.data(), picture.size(), place) != static_cast<ssize_t>(picture.size())) return Fail(EIO);
    constexpr std::int64_t kStart_us = 3'600'000'000, kSecond_us = 1'000'000;  // the computer was started an hour ago
    const std::int64_t time_us = kStart_us + (next - 1) * kSecond_us / rate;
    what.timestamp.tv_sec = time_us / kSecond_us;
    what.timestamp.tv_usec = time_us % kSecond_us;
    what.sequence = next++;
    return 0;
  }

  int Control(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        return Capability(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_G_INPUT:
        *static_cast<int*>(argument) = 0;
        return 0;
      case VIDIOC_ENUMINPUT:
        return static_cast<v4l2_input*>(argument)->index == 0 ? 0 : Fail(EINVAL);
      case VIDIOC_ENUM_FMT:
        if (static_cast<v4l2_fmtdesc*>(argument)->index > 0) return Fail(EINVAL);
        static_cast<v4l2_fmtdesc*>(argument)->pixelformat = V4L2_PIX_FMT_MJPEG;
        return 0;
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT:
        return Format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM:
        return Parameters(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = kBuffers;
        return 0;
      case VIDIOC_QUERYBUF:
        return Describe(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        return Queue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_DQBUF:
        return Take(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        return 0;
      default:
        return Fail(ENOTTY);
    }
  }
};

Camera camera;

}  // namespace

// As libavdevice calls them. What an application may open or control otherwise is the kernel's.
extern "C" int open64(const char* path, int flags, ...) {
  if (path == Setting("LAKE_CAMERA_DEVICE")) return camera.Open();
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags | O_LARGEFILE, mode));
}

extern "C" int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list more;
  va_start(more, request);
  void* const argument = va_arg(more, void*);
  va_end(more);
  if (fd >= 0 && fd == camera.fd) return camera.Control(request, argument);
  return static_cast<int>(syscall(SYS_ioctl, fd, request, argument));
}
