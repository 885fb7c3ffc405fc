#include "picture.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cassert>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "lake/core/error.h"
#include "lake/video/halve.h"

namespace lake::video {
namespace {

bool IsFullRange(const AVFrame& frame) {
  switch (frame.format) {
    case AV_PIX_FMT_YUVJ411P:
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ444P:
      return true;
  }
  if (frame.color_range != AVCOL_RANGE_UNSPECIFIED) return frame.color_range == AVCOL_RANGE_JPEG;
  return av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format))->nb_components < 3;  // grey pictures
}

// What players assume when the stream does not say.
const int* YuvMatrix(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
    case AVCOL_SPC_FCC:
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
    case AVCOL_SPC_SMPTE240M:
    case AVCOL_SPC_BT2020_NCL:
      return sws_getCoefficients(frame.colorspace);
    default: {
      const bool high_definition = frame.width >= 1280 || frame.height > 576;
      return sws_getCoefficients(high_definition && !IsFullRange(frame) ? SWS_CS_ITU709 : SWS_CS_ITU601);
    }
  }
}

const AVPixFmtDescriptor& Describe(const AVFrame& frame) {
  return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

// Shares the frame's memory, unless the plane is stored bottom up (raw AVI).
cv::Mat Plane(const AVFrame& frame, int plane, const cv::Size& size, int type) {
  const int stride = frame.linesize[plane];
  if (stride >= 0) return cv::Mat(size, type, frame.data[plane], static_cast<std::size_t>(stride));
  std::uint8_t* lowest_address = frame.data[plane] + std::ptrdiff_t{size.height - 1} * stride;
  cv::Mat upright;
  cv::flip(cv::Mat(size, type, lowest_address, static_cast<std::size_t>(-stride)), upright, 0);
  return upright;
}

cv::Mat FirstPlane(const AVFrame& frame, int type) {
  return Plane(frame, 0, {frame.width, frame.height}, type);
}

cv::Mat ShrinkDepth(const AVFrame& frame) {
  const AVComponentDescriptor& luma = Describe(frame).comp[0];
  const double bits_to_8 =
      IsFullRange(frame) ? 255.0 / (std::ldexp(1.0, luma.depth) - 1) : std::ldexp(1.0, 8 - luma.depth);
  cv::Mat shrunk;
  FirstPlane(frame, CV_16UC1).convertTo(shrunk, CV_8U, std::ldexp(bits_to_8, -luma.shift));
  return shrunk;
}

// swscale's quick conversion is six times as fast as its exact one and within 2 levels of it, but leaves out columns of
// some widths.
int ConversionFlags(const AVFrame& like) {
  constexpr int kExact = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT;
  return like.width % 16 == 0 ? SWS_BILINEAR : kExact;
}

libav::Scaler MakeBgrScaler(const AVFrame& like) {
  const auto format = static_cast<AVPixelFormat>(like.format);
  libav::Scaler scaler(sws_getContext(like.width, like.height, format, like.width, like.height, AV_PIX_FMT_BGR24,
                                      ConversionFlags(like), nullptr, nullptr, nullptr));
  if (!scaler) throw Fail("pixel format {} cannot be converted to BGR", av_get_pix_fmt_name(format));
  sws_setColorspaceDetails(scaler.get(), YuvMatrix(like), IsFullRange(like), sws_getCoefficients(SWS_CS_DEFAULT), 1, 0,
                           1 << 16, 1 << 16);
  return scaler;
}

// Without SWS_ACCURATE_RND: errors of a level, half the time.
libav::Scaler MakePreviewScaler(const AVFrame& like, int width, int height) {
  const auto format = static_cast<AVPixelFormat>(like.format);
  libav::Scaler scaler(sws_getContext(like.width, like.height, format, width, height, AV_PIX_FMT_YUV420P, SWS_BILINEAR,
                                      nullptr, nullptr, nullptr));
  if (!scaler) throw Fail("pixel format {} cannot be converted to YUV 4:2:0", av_get_pix_fmt_name(format));
  const bool is_rgb = Describe(like).flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL);
  sws_setColorspaceDetails(scaler.get(), is_rgb ? sws_getCoefficients(SWS_CS_DEFAULT) : YuvMatrix(like),
                           is_rgb || IsFullRange(like),
                           sws_getCoefficients(IsBt709(like) ? SWS_CS_ITU709 : SWS_CS_ITU601), 0, 0, 1 << 16, 1 << 16);
  return scaler;
}

bool IsPlanar420(const AVFrame& frame) {
  return frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P;
}

bool HasEvenSides(const AVFrame& frame) {
  return frame.width % 2 == 0 && frame.height % 2 == 0;
}

// Usual video that becomes half as wide and high: the mean of four samples, several times as quick as swscale.
bool CanBeHalved(const AVFrame& frame, int width, int height) {
  const int* matrix = sws_getCoefficients(IsBt709(frame) ? SWS_CS_ITU709 : SWS_CS_ITU601);
  return IsPlanar420(frame) && frame.width == 2 * width && frame.height == 2 * height &&
         std::equal(matrix, matrix + 4, YuvMatrix(frame));
}

// From either range to 16..235 (chroma: 16..240).
void HalvePlane(const AVFrame& frame, int plane, cv::Mat half) {
  const cv::Mat whole = Plane(frame, plane, half.size() * 2, CV_8UC1);
  if (IsFullRange(frame))
    HalveToLimitedRange(whole, plane == 0 ? Sample::kLuma : Sample::kChroma, half);
  else
    Halve(whole, half);
}

}  // namespace

LumaAccess LumaAccessOf(AVPixelFormat format) {
  const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(format);
  if (!description || (description->flags & AV_PIX_FMT_FLAG_HWACCEL))
    throw Fail("unknown pixel format {}", description ? description->name : "(none)");
  constexpr unsigned kNoPlainLuma = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                    AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  const AVComponentDescriptor& luma = description->comp[0];
  if ((description->flags & kNoPlainLuma) || luma.plane != 0) return LumaAccess::kFromRgb;
  if (luma.depth == 8 && luma.shift == 0) {
    if (luma.step == 1 && luma.offset == 0) return LumaAccess::kPlane;
    if (luma.step <= 4) return LumaAccess::kInterleaved;
  }
  if (luma.depth > 8 && luma.step == 2 && luma.offset == 0) return LumaAccess::kDeepPlane;
  return LumaAccess::kFromRgb;
}

PictureConverter::PictureConverter(const AVFrame& like)
    : access_(LumaAccessOf(static_cast<AVPixelFormat>(like.format))) {}

cv::Mat PictureConverter::Luma(const AVFrame& frame) {
  switch (access_) {
    case LumaAccess::kPlane:
      return FirstPlane(frame, CV_8UC1);
    case LumaAccess::kInterleaved: {
      const AVComponentDescriptor& luma = Describe(frame).comp[0];
      cv::Mat extracted;
      cv::extractChannel(FirstPlane(frame, CV_8UC(luma.step)), extracted, luma.offset);
      return extracted;
    }
    case LumaAccess::kDeepPlane:
      return ShrinkDepth(frame);
    case LumaAccess::kFromRgb: {
      cv::Mat grey;
      cv::transform(Bgr(frame), grey, cv::Matx13f(0.114f, 0.587f, 0.299f));
      return grey;
    }
  }
  assert(false);
  return {};
}

cv::Mat I420Plane(const cv::Mat& i420, int plane) {
  const int width = i420.cols, height = i420.rows / 3 * 2;
  if (plane == 0) return i420.rowRange(0, height);
  const std::size_t offset = static_cast<std::size_t>(width) * height * (plane == 1 ? 4 : 5) / 4;
  return cv::Mat(height / 2, width / 2, CV_8UC1, i420.data + offset);
}

bool IsBt709(const AVFrame& frame) {
  const int* matrix = YuvMatrix(frame);
  return !std::equal(matrix, matrix + 4, sws_getCoefficients(SWS_CS_ITU601));
}

bool IsHighDefinition(int width, int height) {
  return width >= 1280 || height > 576;
}

void PictureConverter::ScalePreview(const AVFrame& frame, const cv::Mat& i420) {
  const int width = i420.cols, height = i420.rows / 3 * 2;
  if (!to_preview_) to_preview_ = MakePreviewScaler(frame, width, height);
  std::uint8_t* const planes[] = {I420Plane(i420, 0).data, I420Plane(i420, 1).data, I420Plane(i420, 2).data};
  const int strides[] = {width, width / 2, width / 2};
  if (sws_scale(to_preview_.get(), frame.data, frame.linesize, 0, frame.height, planes, strides) != height)
    throw Fail("a picture of {}×{} px cannot be scaled", frame.width, frame.height);
}

int WhiteLevel(const AVFrame& frame) {
  const bool is_from_rgb = LumaAccessOf(static_cast<AVPixelFormat>(frame.format)) == LumaAccess::kFromRgb;
  return is_from_rgb || IsFullRange(frame) ? 255 : 235;
}

bool KeepsFullRange(const AVFrame& frame) {
  return IsPlanar420(frame) && HasEvenSides(frame) && IsFullRange(frame);
}

cv::Mat PictureConverter::Preview(const AVFrame& frame, int max_width_px, bool as_stored,
                                  const Orientation& orientation) {
  const int shown_width = orientation.transpose ? frame.height : frame.width;
  const double scale = std::min(1.0, static_cast<double>(max_width_px) / shown_width);
  const auto even = [&](int side) { return std::max(2, static_cast<int>(side * scale / 2 + 0.5) * 2); };
  const int width = even(frame.width), height = even(frame.height);  // as stored

  // swscale's vector code writes whole registers, past the end of a row.
  constexpr int kSpareBytes = 128;
  const cv::Mat i420 = cv::Mat(height / 2 * 3 + 1 + kSpareBytes / width, width, CV_8UC1).rowRange(0, height / 2 * 3);
  if (as_stored && IsPlanar420(frame) && width == frame.width && height == frame.height)
    for (const int plane : {0, 1, 2}) {
      const cv::Mat kept = I420Plane(i420, plane);
      Plane(frame, plane, kept.size(), CV_8UC1).copyTo(kept);
    }
  else if (CanBeHalved(frame, width, height))
    for (const int plane : {0, 1, 2}) HalvePlane(frame, plane, I420Plane(i420, plane));
  else
    ScalePreview(frame, i420);
  if (orientation.IsIdentity()) return i420;
  cv::Mat turned = orientation.transpose ? cv::Mat(width / 2 * 3, height, CV_8UC1) : cv::Mat(i420.size(), CV_8UC1);
  for (const int plane : {0, 1, 2}) orientation.Apply(I420Plane(i420, plane)).copyTo(I420Plane(turned, plane));
  return turned;
}

cv::Mat PictureConverter::Bgr(const AVFrame& frame) {
  if (!to_bgr_) to_bgr_ = MakeBgrScaler(frame);
  // swscale's vector code writes whole registers, past the end of a row: spare rows keep that inside the matrix.
  constexpr int kSpareBytes = 128;
  const int spare_rows = 1 + kSpareBytes / (3 * frame.width);
  cv::Mat bgr = cv::Mat(frame.height + spare_rows, frame.width, CV_8UC3).rowRange(0, frame.height);
  std::uint8_t* const planes[] = {bgr.data};
  const int strides[] = {static_cast<int>(bgr.step)};
  if (sws_scale(to_bgr_.get(), frame.data, frame.linesize, 0, frame.height, planes, strides) != frame.height)
    throw Fail("a picture of {}×{} px cannot be converted to BGR", frame.width, frame.height);
  return bgr;
}

}  // namespace lake::video
