#include "lake/gait/picture_scale.h"

#include <fmt/format.h>

#include "lake/camera/plane_fit.h"
#include "lake/core/error.h"
#include "lake/motion/corrections.h"

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

double MmPerPx(const PictureScale& picture, const std::optional<camera::CameraProfile>& profile) {
  const auto [x1, y1, x2, y2, length_mm] = *picture.scale;
  LegView unscaled = MakeLegView(motion::LengthUnit::kPx, profile);
  unscaled.pixel_aspect = picture.pixel_aspect;
  const double length_px = (PlaneFromRecorded(unscaled, {x1, y1}, 0) - PlaneFromRecorded(unscaled, {x2, y2}, 0)).norm();
  constexpr double kShortest_mm = 5;  // longer ones in m are longer than a room
  if (!(length_px >= 1) || !(length_mm >= kShortest_mm))
    throw UsageError("--scale: the bar must be at least 1 px and {:g} mm long; is {:g} in m?", kShortest_mm, length_mm);
  return length_mm / length_px;
}

// The camera with the plane of the known points.
camera::CameraProfile WithPlane(camera::CameraProfile profile, const std::vector<camera::PlaneCorrespondence>& points,
                                const Warn& warn) {
  const camera::PlaneFit fit = camera::FitPlane(profile.camera, points, {.least_sigma_px = motion::kClickSigmaPx});
  for (const std::string& warning : fit.warnings) warn(warning);
  profile.camera_from_plane = fit.camera_from_plane;
  profile.plane_uncertainty = fit.uncertainty;
  return profile;
}

}  // namespace

void Describe(PictureScale& o, OptionList& options) {
  options.Add("camera", o.camera, "camera.yaml: intrinsics and, if it has one, the sagittal plane");
  options.Add("scale", o.scale, "A scale bar, ends in px, where no plane is calibrated").Value("X1,Y1,X2,Y2,LENGTH_MM");
  options
      .Add("plane-points", o.plane_points,
           "Four or more known points of the sagittal plane, in px and mm, where no plane is calibrated")
      .Value("X,Y=XMM,YMM;...");
}

void DescribeOther(const std::string& prefix, const std::string& whose, PictureScale& o, OptionList& options) {
  const std::string otherwise = fmt::format("as --camera, --scale and --plane-points if no --{}-… is given", prefix);
  options.Add(prefix + "-camera", o.camera, "--camera of " + whose).Otherwise(otherwise);
  options.Add(prefix + "-scale", o.scale, "--scale of " + whose).Value("X1,Y1,X2,Y2,LENGTH_MM").Otherwise("likewise");
  options.Add(prefix + "-plane-points", o.plane_points, "--plane-points of " + whose)
      .Value("X,Y=XMM,YMM;...")
      .Otherwise("likewise");
}

LegView MakeView(const PictureScale& picture, const std::optional<camera::CameraProfile>& profile,
                 std::optional<double> mm_per_px, const Warn& warn) {
  constexpr auto kPx = motion::LengthUnit::kPx;
  if (picture.scale && !picture.plane_points.empty())
    throw UsageError("--scale and --plane-points both give lengths: leave one out");
  if (profile && profile->camera_from_plane) {
    if (picture.scale || !picture.plane_points.empty())
      warn(fmt::format("{} is not used: the camera file has a calibrated plane",
                       picture.scale ? "--scale" : "--plane-points"));
    return MakeLegView(kPx, profile, {}, picture.depths);
  }
  if (picture.plane_points.empty()) {
    LegView view = MakeLegView(kPx, profile, picture.scale ? MmPerPx(picture, profile) : mm_per_px, picture.depths);
    view.pixel_aspect = picture.pixel_aspect;
    return view;
  }
  const std::vector<camera::PlaneCorrespondence> points = camera::ParsePlanePoints(picture.plane_points);
  if (profile) return MakeLegView(kPx, WithPlane(*profile, points, warn), {}, picture.depths);
  LegView view = MakeLegView(kPx, {}, {}, picture.depths);
  view.homography = camera::PlaneHomography(points);
  return view;
}

LegView ViewOf(const PictureScale& picture, const motion::MarkerRecording& recording, std::optional<double> mm_per_px,
               const Warn& warn) {
  std::optional<camera::CameraProfile> profile;
  if (picture.camera) {
    profile = camera::ReadCameraProfile(*picture.camera);
    for (const std::string& warning : profile->warnings) warn(warning);
    CheckInPicture(profile->camera, *picture.camera, recording);
  }
  return MakeView(picture, profile, mm_per_px, warn);
}

}  // namespace lake::gait
