#include "lake/gait/picture_scale.h"

#include "lake/core/error.h"

namespace lake::gait {
namespace {

// A camera of another picture gives lengths that nobody sees to be wrong.
void CheckInPicture(const camera::Camera& camera, const std::filesystem::path& file,
                    const motion::MarkerRecording& recording) {
  for (const motion::MarkerTrack& marker : recording.markers)
    for (std::size_t i = 0; i < recording.Frames(); ++i) {
      const motion::MarkerSample& sample = marker.samples[i];
      if (!sample.IsKnown()) continue;
      const Eigen::Vector2d corner = sample.position + Eigen::Vector2d::Constant(0.5);
      if (corner.x() < 0 || corner.y() < 0 || corner.x() > camera.image_width || corner.y() > camera.image_height)
        throw Fail(
            "{}: calibrated with pictures of {}x{} px, but marker '{}' is at ({:.1f}, {:.1f}) px in frame {}: give the "
            "file of this camera and video mode",
            file.string(), camera.image_width, camera.image_height, marker.name, sample.position.x(),
            sample.position.y(), recording.frame[i]);
    }
}

}  // namespace

void Describe(PictureScale& o, OptionList& options) {
  options.Add("camera", o.camera, "camera.yaml: intrinsics and, if it has one, the sagittal plane");
  options.Add("scale", o.scale, "A scale bar, ends in px, where no plane is calibrated").Value("X1,Y1,X2,Y2,LENGTH_MM");
}

std::optional<double> MmPerPx(const PictureScale& picture, const std::optional<camera::CameraProfile>& profile,
                              const Warn& warn) {
  if (!picture.scale) return std::nullopt;
  if (profile && profile->camera_from_plane) {
    warn("--scale is not used: the camera file has a calibrated plane");
    return std::nullopt;
  }
  const auto [x1, y1, x2, y2, length_mm] = *picture.scale;
  const LegView unscaled = MakeLegView(motion::LengthUnit::kPx, profile);
  const double length_px = (PlaneFromRecorded(unscaled, {x1, y1}, 0) - PlaneFromRecorded(unscaled, {x2, y2}, 0)).norm();
  constexpr double kShortest_mm = 5;  // longer ones in m are longer than a room
  if (!(length_px >= 1) || !(length_mm >= kShortest_mm))
    throw UsageError(
        fmt::format("--scale: the bar must be at least 1 px and {:g} mm long; is {:g} in m?", kShortest_mm, length_mm));
  return length_mm / length_px;
}

LegView ViewOf(const PictureScale& picture, const motion::MarkerRecording& recording, std::optional<double> mm_per_px,
               const Warn& warn) {
  std::optional<camera::CameraProfile> profile;
  if (picture.camera) {
    profile = camera::ReadCameraProfile(*picture.camera);
    CheckInPicture(profile->camera, *picture.camera, recording);
  }
  if (picture.scale) mm_per_px = MmPerPx(picture, profile, warn);
  return MakeLegView(motion::LengthUnit::kPx, profile, mm_per_px);
}

}  // namespace lake::gait
