// Finding markers in one frame, whatever they are: discs, colours, any patch, ArUco.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/tracking/blob_fit.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

// What was seen in one frame.
struct MarkerDetection {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px, image frame
  double sigma_px = 0;                                 // one standard deviation per axis, from this frame's fit
  Blob appearance;                                     // its look; for patches and ArUco a disc of their size
  double background = 0;                               // grey level round it, of a blob in the luma
  double quality = 0;                                  // residual over amplitude: 0 is perfect
  std::optional<int> identity;  // which colour, patch or ArUco id it is, if the detector can tell
};

// Where a marker that has been followed so far should be.
struct MarkerPrediction {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_px = Eigen::Vector2d::Zero();  // px per frame
  double velocity_by_place = 0;              // by how much it is faster, px per frame, for each px that it is further
  double gate_px = 0;                        // look no further than this
  std::optional<Eigen::Vector2d> rested_at;  // px: where it is if what looked like repeated frames was a rest
  Blob appearance;                           // running mean of its looks
  double quality = 1;                        // running mean of its detections' quality
  std::optional<int> identity;
  bool was_missed = false;  // in the frame before: what looks otherwise may be it

  // px per frame, of what is found there.
  Eigen::Vector2d VelocityAt(const Eigen::Vector2d& place) const {
    return velocity_px + velocity_by_place * (place - position);
  }
};

// What a detector has learnt of the pictures.
struct ImageFigures {
  NoiseModel noise;
  double saturation_level = 255;           // grey level; infinite of dark markers, which have none
  std::optional<double> shutter_fraction;  // part of the frame time during which the shutter is open, if it showed
};

// Where a detector looks: near what is expected; everywhere; or near it once more in a frame of before, from which
// nothing is learnt again.
enum class Look { kNear, kEverywhere, kNearAgain };

class MarkerDetector {
 public:
  virtual ~MarkerDetector() = default;

  // Detections near the predictions and, everywhere, all others. Each object is reported once.
  virtual std::vector<MarkerDetection> Detect(const video::VideoFrame& frame,
                                              std::span<const MarkerPrediction> predictions, Look look) = 0;

  virtual bool NeedsColour() const { return false; }

  // nullopt of a detector that does not measure blobs in the luma.
  virtual std::optional<ImageFigures> Figures() const { return std::nullopt; }

  // Whether identities tell markers apart, so that association need not.
  virtual bool KnowsIdentities() const { return false; }
};

enum class Polarity { kBright, kDark };

// Limits of the search in px; an empty rectangle is the whole picture.
struct DetectorRegion {
  cv::Rect crop;

  // What of the picture is to be searched.
  cv::Rect Of(const cv::Mat& picture) const {
    const cv::Rect all(0, 0, picture.cols, picture.rows);
    return crop.empty() ? all : crop & all;
  }
};

// Makes the detector for a part of the picture; what it needs of the film has been read from it.
using DetectorMaker = std::function<std::unique_ptr<MarkerDetector>(const DetectorRegion&)>;

// Bright blobs on anything darker (or dark ones on anything brighter), in the luma.
std::unique_ptr<MarkerDetector> MakeReflectiveDetector(Polarity polarity, const DetectorRegion& region);

// A marker's colour as it is given: by its levels, or by a place in a frame where it is to be seen.
struct MarkerColor {
  std::string text;  // as it was written
  std::optional<cv::Vec3b> bgr = {};
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px; where there is no bgr
  std::int64_t frame = 0;
};

// "#RRGGBB" or "@X,Y[@FRAME]". Throws UsageError for another spelling.
MarkerColor ParseMarkerColor(const std::string& text);

// A colour as a direction in the plane of Cr and Cb: its hue, which stays when the light changes.
struct MarkerHue {
  cv::Vec2d direction;  // of (Cr, Cb), unit length
  double gain = 2;      // strength per level of chroma along the direction; 40 are needed to be seen
  double across = 0.5;  // by how much chroma across it weakens it
};

// Of a colour given by its levels, in video of BT.709 or else BT.601. Throws UsageError for a grey.
MarkerHue HueOfColor(const MarkerColor& color, bool bt709);
// Of a colour given by a place, in its frame (luma and preview, unreduced). Throws Error where that is outside or grey.
MarkerHue HueAt(const video::VideoFrame& frame, const MarkerColor& color);

// Discs and lamps of these hues, in frames with luma and an unreduced preview; identity = index of the hue.
std::unique_ptr<MarkerDetector> MakeColorDetector(const std::vector<MarkerHue>& hues, const DetectorRegion& region);

// A place in a frame, to start from.
struct MarkerSeed {
  std::string name;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px
  std::int64_t frame = 0;
  std::optional<int> candidate = {};  // instead of a place: the number of a candidate (candidates.h)
};

// The patches at the given places; identity = index of the seed. `pictures` holds the luma of each seed's frame. Throws
// Error if the picture has no structure there.
std::unique_ptr<MarkerDetector> MakeTemplateDetector(const std::vector<MarkerSeed>& seeds,
                                                     const std::vector<cv::Mat>& pictures,
                                                     const DetectorRegion& region);

// ArUco markers of a dictionary ("4X4_50" or "DICT_4X4_50"); identity = the marker's id. Throws UsageError for an
// unknown dictionary.
std::unique_ptr<MarkerDetector> MakeArucoDetector(const std::string& dictionary, const DetectorRegion& region);

}  // namespace lake::tracking
