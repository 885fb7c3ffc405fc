// The subject's head made unrecognisable, at the position predicted from leg and trunk.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "lake/motion/marker_recording.h"
#include "lake/video/video_reader.h"

namespace lake::overlay {

struct HeadDisc {
  Eigen::Vector2d centre;  // px of the recording
  double radius_px = 0;
};

// The body has the proportions of Drillis & Contini (1966) and the measured legs. The head's centre is 0.825 of the
// leg's length (knee to ankle and to hip) from the hip, along the trunk.
//
// The trunk's direction is that from hip to shoulder where a marker `shoulder` is seen. Else it is taken from the
// waist: the trunk of a subject who stands goes on along the leg, and leans 1.25 times as far from there as the line
// from hip to waist turns, as the lumbar spine bends with the pelvis. So the waist marker may sit anywhere on the
// pelvis, but the subject must stand at some time.
class HeadBlur {
 public:
  // Tracks in px. Throws Error naming what is not among them: ankle, knee, hip, and waist or shoulder.
  explicit HeadBlur(const motion::MarkerRecording& tracks);

  // Whether the head's position is known in any frame: where a shoulder is seen or the subject stands.
  bool IsKnown() const { return radius_px_ > 0; }

  // In a frame of the file. Gaps of up to a second are bridged; nullopt in longer ones and where nothing was tracked.
  std::optional<HeadDisc> Head(std::int64_t frame) const;

  enum class Done { kHead, kHeadBesideLeg, kWhole };

  // Blurs a frame of the file, a picture as VideoFrame::preview of a recording of this width: the head's disc, the
  // whole picture where the head's position is unknown. The shank, the thigh and the surroundings of the markers stay
  // as they are; kHeadBesideLeg says that the head may reach them.
  Done Blur(cv::Mat& i420, std::int64_t frame, int recorded_width) const;

 private:
  void FindLeg();
  void FindHeads();
  std::optional<Eigen::Vector2d> Trunk(std::size_t row) const;
  void BridgeGaps();
  std::optional<std::size_t> Row(std::int64_t frame) const;
  cv::Mat Kept(cv::Size size, double scale, std::optional<std::size_t> row) const;

  motion::MarkerRecording tracks_;
  double leg_px_ = 0, radius_px_ = 0;
  std::optional<double> waist_turn_;                   // of hip to waist against the leg's line, when standing, rad
  Eigen::Vector2d upright_ = {0, -1};                  // the leg's line when standing
  std::vector<std::optional<Eigen::Vector2d>> heads_;  // per row of the tracks
};

// Blurs the whole picture beyond recognition, CV_8UC1.
void BlurWhole(cv::Mat& luma);

struct AnonymisedCopy {
  std::int64_t frames = 0, whole = 0, beside_leg = 0;  // all; with the whole picture blurred; kHeadBesideLeg
  bool is_exact = false;                               // what was not blurred is the recording's to the bit
};

struct AnonymiseOptions {
  std::optional<int> crf;  // H.264 quality, 0 … 51; unset: without loss
  bool quiet = false;
  video::VideoReaderOptions reader = {};
};

// A copy of the recording in H.264, time stamps kept, without sound and without what the file says of camera, place and
// time. Throws Error as VideoReader and VideoWriter do, for sides that are odd, and if the head's place is known in no
// frame; then there is no file.
AnonymisedCopy WriteAnonymisedVideo(const std::filesystem::path& video, const HeadBlur& blur,
                                    const AnonymiseOptions& options, const std::filesystem::path& out);

}  // namespace lake::overlay
