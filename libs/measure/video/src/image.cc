#include "lake/video/image.h"

#include <opencv2/core.hpp>

#include "damage_log.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/video/video_reader.h"
#include "libav.h"

namespace lake::video {
namespace {

libav::Frame MakeFrame(const cv::Mat& image) {
  libav::Frame frame = libav::NewFrame();
  frame->format = image.channels() == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_RGB24;
  frame->width = image.cols;
  frame->height = image.rows;
  if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
  cv::Mat target(image.size(), image.type(), frame->data[0], static_cast<std::size_t>(frame->linesize[0]));
  if (image.channels() == 1)
    image.copyTo(target);
  else
    cv::mixChannels(image, target, {0, 2, 1, 1, 2, 0});
  return frame;
}

libav::Packet EncodePng(const AVFrame& frame, const std::string& name) {
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_PNG);
  if (!encoder) throw Fail("{}: libavcodec has no PNG encoder", name);
  libav::Codec codec = libav::NewCodec(encoder);
  codec->width = frame.width;
  codec->height = frame.height;
  codec->pix_fmt = static_cast<AVPixelFormat>(frame.format);
  codec->time_base = {1, 1};
  codec->thread_count = 1;
  libav::Packet packet = libav::NewPacket();
  int result = avcodec_open2(codec.get(), encoder, nullptr);
  if (result >= 0) result = avcodec_send_frame(codec.get(), &frame);
  if (result >= 0) result = avcodec_send_frame(codec.get(), nullptr);
  if (result >= 0) result = avcodec_receive_packet(codec.get(), packet.get());
  if (result < 0) throw Fail("{}: cannot be encoded as PNG ({})", name, libav::ErrorText(result));
  return packet;
}

}  // namespace

cv::Mat ReadImage(const std::filesystem::path& path, bool colour) {
  const auto reader = VideoReader::Open(path, {.colour = colour, .capture_rate_hz = 1});
  VideoFrame frame;
  reader->Read(frame);
  return colour ? frame.bgr : frame.luma.clone();  // the luma may belong to the decoder
}

void WriteImage(const std::filesystem::path& path, const cv::Mat& image) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3))
    throw Fail("{}: a picture of {}×{} px, {}, cannot be written; 8-bit grey or BGR can", path.string(), image.cols,
               image.rows, cv::typeToString(image.type()));
  DamageLog::TakeLibavLog();
  const libav::Packet png = EncodePng(*MakeFrame(image), path.string());
  WriteTextFile(path, {reinterpret_cast<const char*>(png->data), static_cast<std::size_t>(png->size)});
}

}  // namespace lake::video
