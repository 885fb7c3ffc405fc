#include "lossless_encoder.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <new>

#include "lake/core/error.h"
#include "lake/core/threads.h"

namespace lake::video {

namespace {

// Of the same bits, else AV_PIX_FMT_NONE. (A sensor's colour mosaic becomes a picture by interpolation.)
AVPixelFormat PlanesOf(AVPixelFormat raw, const AVCodec& encoder) {
  if (av_pix_fmt_desc_get(raw)->flags & AV_PIX_FMT_FLAG_BAYER) return AV_PIX_FMT_NONE;
  int loss = 0;
  const AVPixelFormat best = avcodec_find_best_pix_fmt_of_list(encoder.pix_fmts, raw, 0, &loss);
  return loss == 0 ? best : AV_PIX_FMT_NONE;
}

}  // namespace

LosslessEncoder::LosslessEncoder(const std::string& input, const AVCodecParameters& raw, AVRational time_base)
    : input_(input) {
  if (!parameters_) throw std::bad_alloc();
  OpenDecoder(raw);
  OpenEncoder(time_base);
  if (avcodec_parameters_from_context(parameters_.get(), encoder_.get()) < 0) throw std::bad_alloc();
}

void LosslessEncoder::OpenDecoder(const AVCodecParameters& raw) {
  const AVCodec* decoder = avcodec_find_decoder(raw.codec_id);
  decoder_ = libav::NewCodec(decoder);
  avcodec_parameters_to_context(decoder_.get(), &raw);
  decoder_->max_pixels = libav::kMaxPixels;
  const int result = avcodec_open2(decoder_.get(), decoder, nullptr);
  if (result < 0) throw Fail("{}: its raw pictures cannot be read ({})", input_, libav::ErrorText(result));
}

void LosslessEncoder::OpenEncoder(AVRational time_base) {
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_FFV1);
  if (!encoder) throw Fail("{}: libavcodec has no FFV1 encoder, by which raw pictures are recorded", input_);
  encoder_ = libav::NewCodec(encoder);
  encoder_->pix_fmt = PlanesOf(decoder_->pix_fmt, *encoder);
  if (encoder_->pix_fmt == AV_PIX_FMT_NONE)
    throw Fail(
        "{}: its raw pictures ({}) cannot be recorded without loss; ask the camera for coded ones, --format mjpeg",
        input_, av_get_pix_fmt_name(decoder_->pix_fmt));
  encoder_->width = decoder_->width;
  encoder_->height = decoder_->height;
  encoder_->sample_aspect_ratio = decoder_->sample_aspect_ratio;
  encoder_->color_range = decoder_->color_range;
  encoder_->colorspace = decoder_->colorspace;
  encoder_->color_primaries = decoder_->color_primaries;
  encoder_->color_trc = decoder_->color_trc;
  encoder_->chroma_sample_location = decoder_->chroma_sample_location;
  encoder_->time_base = time_base;
  encoder_->gop_size = 1;
  encoder_->level = 3;  // pictures in slices, which several threads code at once
  encoder_->slices = 4;
  encoder_->thread_count = Threads();
  encoder_->thread_type = FF_THREAD_SLICE;  // frame threads would hold pictures back
  const int result = avcodec_open2(encoder_.get(), encoder, nullptr);
  if (result < 0) throw Fail("{}: FFV1 does not take its raw pictures ({})", input_, libav::ErrorText(result));
  raw_format_ = decoder_->pix_fmt;
  if (encoder_->pix_fmt == raw_format_) return;
  repack_.reset(sws_getContext(encoder_->width, encoder_->height, decoder_->pix_fmt, encoder_->width, encoder_->height,
                               encoder_->pix_fmt, SWS_POINT, nullptr, nullptr, nullptr));
  planes_->format = encoder_->pix_fmt;
  planes_->width = encoder_->width;
  planes_->height = encoder_->height;
  if (!repack_ || av_frame_get_buffer(planes_.get(), 0) < 0) throw std::bad_alloc();
}

libav::Packet LosslessEncoder::Encode(const AVPacket& raw) {
  if (avcodec_send_packet(decoder_.get(), &raw) < 0) return nullptr;
  if (avcodec_receive_frame(decoder_.get(), picture_.get()) < 0) return nullptr;
  if (picture_->width != encoder_->width || picture_->height != encoder_->height || picture_->format != raw_format_)
    throw Fail("{}: its pictures changed their size or format", input_);
  libav::Packet coded = libav::NewPacket();
  int result = avcodec_send_frame(encoder_.get(), &InEncodersFormat());
  if (result >= 0) result = avcodec_receive_packet(encoder_.get(), coded.get());
  if (result < 0) throw Fail("{}: a raw picture cannot be coded ({})", input_, libav::ErrorText(result));
  coded->pts = raw.pts;
  coded->dts = raw.dts;
  coded->duration = raw.duration;
  return coded;
}

const AVFrame& LosslessEncoder::InEncodersFormat() {
  if (!repack_) return *picture_;
  if (av_frame_make_writable(planes_.get()) < 0) throw std::bad_alloc();
  sws_scale(repack_.get(), picture_->data, picture_->linesize, 0, picture_->height, planes_->data, planes_->linesize);
  planes_->pts = picture_->pts;
  planes_->color_range = picture_->color_range;
  planes_->colorspace = picture_->colorspace;
  return *planes_;
}

}  // namespace lake::video
