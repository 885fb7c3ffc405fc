#include "lake/synth/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "body.h"
#include "extras.h"
#include "lake/core/error.h"
#include "marker_sprite.h"
#include "random.h"
#include "room.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr const char* kJoint = "exo_knee";
constexpr double kTicksPerSecond = 90000;  // time stamps are whole ticks, so that a video keeps them exactly

MotionTable TableOf(const SceneOptions& options) {
  if (!options.motion_table.empty()) return ReadMotionTable(options.motion_table);
  if (!options.motion_file) return DrawnWalkTable(*options.walk, options.motion.facing);
  if (!options.walk || options.walk->stride_s == 0) return ReadMotionFile(*options.motion_file, options.duration_s);
  constexpr double kAfter_s = 0.05;  // and what is around, for the next stride to go on
  return RepeatStride(ReadMotionFile(*options.motion_file, options.walk->stride_s + kAfter_s), *options.walk);
}

std::shared_ptr<const MarkerMotion> MakeMotion(const SceneOptions& options) {
  if (options.motion_table.empty() && !options.motion_file && !options.walk)
    return std::make_shared<StsMotion>(options.motion);
  MotionTable table = TableOf(options);
  if (options.motion.exo_knee_mm) AddExoKnee(table, *options.motion.exo_knee_mm);
  if (options.walk) return MakeWalk(std::move(table), *options.walk);
  return MakeTableMotion(std::move(table), options.mirror_table);
}

// The middle of the box around all markers' paths, with more room above than below; that is where the camera looks.
Vector2d MiddleOf(const MarkerMotion& motion) {
  Vector2d low = motion.At(0).front(), high = low;
  for (double t = 0; t <= motion.DurationS(); t += 0.05)
    for (const Vector2d& marker : motion.At(t)) {
      low = low.cwiseMin(marker);
      high = high.cwiseMax(marker);
    }
  return 0.5 * (low + high) + Vector2d(0, 20);
}

camera::CameraProfile ProfileFor(const SceneOptions& options, const MarkerMotion& motion) {
  if (!options.camera) return MakeCameraProfile(options, MiddleOf(motion));
  if (!options.camera->camera_from_plane) throw UsageError("the camera has no sagittal plane; a scene needs one");
  return *options.camera;
}

// Middles of `count` equal parts of the shutter, in the motion's time.
std::vector<double> Instants(double middle_s, double open_s, int count) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(middle_s + open_s * ((i + 0.5) / count - 0.5));
  return times;
}

cv::Mat Spread(const cv::Mat& image, double psf_sigma_px) {
  const cv::Mat kernel = PixelKernel(psf_sigma_px);
  cv::Mat out;
  cv::sepFilter2D(image, out, CV_32F, kernel, kernel, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  return out;
}

// Everything about a frame that its picture and its truth are made of.
struct FrameState {
  double time_s = 0;                           // of the motion
  std::vector<double> fine_s;                  // instants of the shutter for markers
  std::vector<std::vector<Vector3d>> fine_mm;  // [instant][marker]
  std::vector<SeenLayer> hands;                // of all that are near, at the fine instants
  std::vector<SeenLayer> near_leg;             // likewise; what is before the other leg's markers
  std::vector<SeenLayer> hub;                  // likewise; what is before all markers but the joint's
};

}  // namespace

struct Scene::Impl {
  SceneOptions options;
  std::shared_ptr<const MarkerMotion> motion;
  camera::CameraProfile profile;
  View view;
  std::unique_ptr<Wardrobe> wardrobe;  // with a body only
  MarkerSprites sprites;
  Sensor sensor;
  double forward;
  int frames = 0;
  Canvas room;          // sharp, with reflections
  cv::Mat room_spread;  // the same after the point-spread
  std::unique_ptr<Glint> glint;
  std::vector<Hand> hands;
  // Of a person with markers at both legs: the far one's names begin with this, the near one's with the other.
  std::optional<std::string> far_leg, near_leg;

  Impl(const SceneOptions& o, std::shared_ptr<const MarkerMotion> m)
      : options(o),
        motion(std::move(m)),
        profile(ProfileFor(o, *motion)),
        view(profile),
        wardrobe(o.body ? std::make_unique<Wardrobe>(o.seed) : nullptr),
        sprites(options, view, *motion),
        sensor(o.noise, o.seed),
        forward(motion->FacingInImage() == motion::Facing::kRight ? 1 : -1) {
    const double duration = o.duration_s > 0 ? o.duration_s : motion->DurationS();
    frames = std::max(1, static_cast<int>(std::floor(duration * o.frame_rate_hz + 1e-9)));
    for (std::size_t i = 0; i < o.occlusions.size(); ++i)
      hands.emplace_back(options, i, *motion, 0.4 * sprites.RadiusPx());
    if (o.walk) CheckPasses();
    if (o.hub_mm > 0 && IndexOfMarker(*motion, kJoint) < 0)
      throw UsageError("--hub: is at the exoskeleton's joint; add its marker, --exo X,Y");
    const int own = IndexOfMarker(*motion, "ankle"), other = IndexOfMarker(*motion, "other_ankle");
    const bool is_one_person = IndexOfMarker(*motion, "other_waist") < 0;
    if (o.body && is_one_person && own >= 0 && other >= 0 && IndexOfMarker(*motion, "other_knee") >= 0) {
      const std::vector<double> depths = motion->DepthsAt(0);
      near_leg = depths[own] >= depths[other] ? "" : "other_";
      far_leg = near_leg->empty() ? "other_" : "";
    }
    PaintBackground();
  }

  // The person goes from where a pass ends to where the next begins unseen.
  void CheckPasses() const {
    constexpr double kBody_mm = 300;  // around its markers
    const double around_px = kBody_mm * sprites.RadiusPx() / options.marker_radius_mm;
    for (const double time_s : PassEnds(*motion, *options.walk))
      for (const Vector2d& px : sprites.Centres(motion->InSpace(time_s)))
        if (px.x() > -around_px && px.x() < view.Size().width + around_px)
          throw UsageError(
              "--passes: the person is seen at {:.2f} s, where a pass ends or the next begins; more --repetitions make "
              "a longer way",
              time_s);
  }

  void PaintBackground() {
    room = PaintRoom(options, view, *motion);
    room.image *= options.brightness;
    room_spread = Spread(room.image, options.psf_sigma_px);
    const MarkerPaths paths = Paths();
    for (const Sprite& sprite : Reflections(options, view.Size(), paths)) {
      const SpriteCoverage coverage = CoverageOf(sprite, view.Size(), options.psf_sigma_px, {});
      room_spread(coverage.region) += LightOf(sprite, coverage, room, options.psf_sigma_px);
      PaintUnder(sprite, coverage, room);
    }
    if (options.glint) glint = std::make_unique<Glint>(options, view.Size(), paths);
  }

  MarkerPaths Paths() const {
    MarkerPaths paths{{}, sprites.RadiusPx(), 6 * sprites.RadiusPx() + sprites.ArucoReachPx()};
    for (double t = 0; t <= frames / options.frame_rate_hz; t += 0.04)
      paths.px.push_back(sprites.Centres(motion->InSpace(t)));
    return paths;
  }

  double TimeS(int frame) const {
    Random random(options.seed, "time stamp", static_cast<std::uint64_t>(frame));
    const double jitter = frame > 0 ? options.time_jitter * random.Uniform(-1, 1) : 0;
    const double exact = options.start_s + (frame + jitter) / options.frame_rate_hz;
    return std::round(exact * kTicksPerSecond) / kTicksPerSecond;
  }

  double OpenS() const { return options.shutter / options.frame_rate_hz; }

  // The longest way that a marker goes while the shutter is open.
  double LongestBlurPx(double time_s) const {
    const auto from = sprites.Centres(motion->InSpace(time_s - 0.5 * OpenS())),
               to = sprites.Centres(motion->InSpace(time_s + 0.5 * OpenS()));
    double longest = 0;
    for (std::size_t i = 0; i < from.size(); ++i) longest = std::max(longest, (to[i] - from[i]).norm());
    return longest;
  }

  // Each marker where it is when its row is read. A row's time depends on where the marker is then; it moves by less
  // than a hundredth of the picture in the meantime, so this settles at once.
  std::vector<Vector3d> AsRead(double time_s) const {
    std::vector<Vector3d> mm = motion->InSpace(time_s);
    if (options.readout_s == 0) return mm;
    constexpr int kRounds = 4;
    for (std::size_t m = 0; m < mm.size(); ++m)
      for (int round = 0; round < kRounds; ++round) {
        const double row = sprites.Centres(mm)[m].y();
        mm[m] = motion->InSpace(time_s + (row / view.Size().height - 0.5) * options.readout_s)[m];
      }
    return mm;
  }

  FrameState StateOf(int frame) const {
    FrameState state;
    state.time_s = TimeS(frame) - options.start_s;
    const double blur = LongestBlurPx(state.time_s);
    const int count = OpenS() == 0 ? 1 : std::min(64, 4 + static_cast<int>(std::ceil(3 * blur)));
    state.fine_s = Instants(state.time_s, OpenS(), count);
    for (const double t : state.fine_s) state.fine_mm.push_back(AsRead(t));
    for (const Hand& hand : hands)
      for (SeenLayer& layer : Seen(hand.At(state.fine_s))) state.hands.push_back(std::move(layer));
    state.hub = Seen(Hub(state.fine_s));
    if (near_leg)
      state.near_leg = Seen(LegLayers(PosesAt(state.fine_s, *near_leg), *wardrobe, options.bright_room, forward));
    return state;
  }

  bool IsFar(const std::string& name) const {
    return far_leg && name != "waist" && name.starts_with("other_") == !far_leg->empty();
  }

  // Of what is before a marker, or with "" before everything.
  Cover CoverOf(const FrameState& state, const std::string& marker = "") const {
    std::vector<const SeenLayer*> before;
    for (const SeenLayer& layer : state.hands) before.push_back(&layer);
    if (!marker.empty() && marker != kJoint)
      for (const SeenLayer& layer : state.hub) before.push_back(&layer);
    if (IsFar(marker))
      for (const SeenLayer& layer : state.near_leg) before.push_back(&layer);
    if (before.empty()) return {};
    return [before](const cv::Rect& region, std::size_t instant) {
      cv::Mat covered;
      for (const SeenLayer* layer : before) {
        if ((layer->Region() & region).empty()) continue;
        const cv::Mat one = layer->Coverage(region, instant, instant);
        covered = covered.empty() ? one.clone() : cv::Mat(covered + one - covered.mul(one));
      }
      return covered;
    };
  }

  std::vector<Layer> Hub(const std::vector<double>& times_s) const {
    if (options.hub_mm == 0) return {};
    const auto depth = options.marker_depth_mm.find(kJoint);
    const double depth_mm = depth == options.marker_depth_mm.end() ? 0 : depth->second;
    return HubLayers(PosesAt(times_s, ""), options.hub_mm,
                     [&](const Vector2d& mm) { return view.Plane(view.Pixel(mm, depth_mm)); });
  }

  // In the room's light.
  std::vector<SeenLayer> Seen(std::vector<Layer> layers) const {
    std::vector<SeenLayer> seen;
    seen.reserve(layers.size());
    for (Layer& layer : layers) {
      layer.surface.bgr *= options.brightness;
      seen.emplace_back(view, std::move(layer));
    }
    return seen;
  }

  std::vector<SeenLayer> MovingLayers(const FrameState& state) const {
    if (!options.body && !options.exoskeleton && options.hub_mm == 0) return {};
    const int count = std::clamp(static_cast<int>(std::ceil(LongestBlurPx(state.time_s))), 1, 12);
    const std::vector<double> instants = Instants(state.time_s, OpenS(), count);
    const std::vector<BodyPose> poses = PosesAt(instants, near_leg.value_or(""));
    std::vector<Layer> layers;
    if (far_leg) layers = LegLayers(PosesAt(instants, *far_leg), *wardrobe, options.bright_room, forward);
    if (options.body)
      for (Layer& layer : BodyLayers(poses, *wardrobe, forward, options.bright_room))
        layers.push_back(std::move(layer));
    if (options.exoskeleton)
      for (Layer& layer : ExoskeletonLayers(poses, forward)) layers.push_back(std::move(layer));
    for (Layer& layer : Hub(instants)) layers.push_back(std::move(layer));
    return Seen(std::move(layers));
  }

  // With the leg whose markers' names begin with this; the legs meet at one hip where only one is marked.
  std::vector<BodyPose> PosesAt(const std::vector<double>& times_s, const std::string& leg) const {
    std::vector<BodyPose> poses;
    for (const double time_s : times_s) {
      const std::vector<Vector2d> markers = motion->At(time_s);
      const auto get = [&](const std::string& name) -> std::optional<Vector2d> {
        const int index = IndexOfMarker(*motion, name);
        return index < 0 ? std::nullopt : std::optional(markers[index]);
      };
      const auto hip = get(leg + "hip"), heel = get(leg + "heel"), toe = get(leg + "toe");
      BodyPose& pose = poses.emplace_back(
          BodyPose{get(leg + "ankle"), get(leg + "knee"), hip ? hip : get("hip"), get("waist"), get("exo_knee"), {}});
      if (heel && toe) pose.foot_rad = std::atan2(toe->y() - heel->y(), std::abs(toe->x() - heel->x()));
      if (options.walk && !pose.foot_rad && pose.ankle && pose.knee) pose.foot_rad = FootOf(*pose.knee - *pose.ankle);
    }
    return poses;
  }

  // As flat as a shank that leans forward lets it be.
  double FootOf(const Vector2d& shank) const {
    constexpr double kMostDorsiflexion_rad = 0.35;
    return std::min(0.0, kMostDorsiflexion_rad - std::atan2(forward * shank.x(), shank.y()));
  }

  double Brightness(int frame) const {
    Random constant(options.seed, "flicker"), lot(options.seed, "flicker", static_cast<std::uint64_t>(frame) + 1);
    const double hz = constant.Uniform(3, 9), phase = constant.Uniform(0, 2 * std::numbers::pi);
    const double wave = std::sin(2 * std::numbers::pi * hz * (TimeS(frame) - options.start_s) + phase);
    return options.exposure * (1 + options.flicker * (wave + 0.25 * lot.Normal()));
  }

  struct Composition {
    Canvas under;     // sharp, everything but hands and small bright objects
    cv::Mat picture;  // whole, after the point-spread, before exposure and flicker
  };

  // All but the sprites.
  Composition Compose(const FrameState& state, const std::vector<Sprite>& sprites_of_frame) const {
    const std::vector<SeenLayer> layers = MovingLayers(state);
    cv::Rect region;
    for (const SeenLayer& layer : layers) region |= layer.Region();
    for (const SeenLayer& hand : state.hands) region |= hand.Region();
    for (const Sprite& sprite : sprites_of_frame) region |= SpriteRegion(sprite, view.Size(), options.psf_sigma_px);
    Composition out;
    out.picture = room_spread.clone();
    if (region.empty()) return out;
    const int reach = PixelKernel(options.psf_sigma_px).cols / 2;
    const cv::Rect all({}, view.Size());
    const cv::Rect touched = Grown(region, reach) & all, needed = Grown(touched, reach) & all;
    out.under = {room.image(needed).clone(), needed.tl()};
    for (const SeenLayer& layer : layers) layer.PaintOn(out.under);
    Canvas with_hands{state.hands.empty() ? out.under.image : out.under.image.clone(), out.under.corner};
    for (const SeenLayer& hand : state.hands) hand.PaintOn(with_hands);
    Spread(with_hands.image, options.psf_sigma_px)(touched - needed.tl()).copyTo(out.picture(touched));
    return out;
  }

  static cv::Rect Grown(const cv::Rect& r, int by) { return {r.x - by, r.y - by, r.width + 2 * by, r.height + 2 * by}; }

  std::vector<Sprite> SpritesOf(const FrameState& state) const {
    std::vector<Sprite> all;
    if (glint) all.push_back(glint->At(state.fine_s));
    for (std::size_t m = 0; m < motion->Names().size(); ++m) all.push_back(sprites.At(m, state.fine_mm));
    return all;
  }

  cv::Mat RenderIdeal(int frame) const {
    const FrameState state = StateOf(frame);
    const std::vector<Sprite> all = SpritesOf(state);
    Composition composition = Compose(state, all);
    const std::size_t others = all.size() - motion->Names().size();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Sprite& sprite = all[i];
      const Cover cover = CoverOf(state, i < others ? "" : motion->Names()[i - others]);
      const SpriteCoverage coverage = CoverageOf(sprite, view.Size(), options.psf_sigma_px, cover);
      if (coverage.region.empty()) continue;
      composition.picture(coverage.region) += LightOf(sprite, coverage, composition.under, options.psf_sigma_px);
      PaintUnder(sprite, coverage, composition.under);
    }
    composition.picture *= Brightness(frame);
    return composition.picture;
  }

  FrameTruth Truth(int frame) const {
    const FrameState state = StateOf(frame);
    const std::vector<Vector3d> places = motion->InSpace(state.time_s);
    const std::vector<Vector2d> px = sprites.Centres(places);
    std::vector<Vector2d> mm;
    for (std::size_t m = 0; m < places.size(); ++m) mm.push_back(sprites.PlaceShown(m, places[m]));
    FrameTruth truth;
    truth.time_s = TimeS(frame);
    for (std::size_t m = 0; m < mm.size(); ++m) {
      const Cover cover = CoverOf(state, motion->Names()[m]);
      const double covered = CoverageOf(sprites.At(m, state.fine_mm), view.Size(), options.psf_sigma_px, cover).covered;
      truth.markers.push_back({px[m], mm[m], covered, covered < kVisibleLimit});
    }
    const int ankle = IndexOfMarker(*motion, "ankle"), knee = IndexOfMarker(*motion, "knee"),
              hip = IndexOfMarker(*motion, "hip");
    truth.knee_deg = ankle < 0 || knee < 0 || hip < 0
                         ? std::numeric_limits<double>::quiet_NaN()
                         : KneeAngleDeg(mm[ankle], mm[knee], mm[hip], motion->FacingInImage());
    return truth;
  }

  ImagePatch RenderMarker(int frame, const std::string& name, const Vector2d& shift_px) const {
    const int wanted = IndexOfMarker(*motion, name);
    if (wanted < 0) throw UsageError("no marker '{}'", name);
    const FrameState state = StateOf(frame);
    const Cover cover = CoverOf(state, name);
    Composition composition = Compose(state, SpritesOf(state));
    Sprite sprite = sprites.At(static_cast<std::size_t>(wanted), state.fine_mm);
    for (SpriteInstant& instant : sprite.instants) {
      for (Vector2d& corner : instant.outline) corner += shift_px;
      for (Polygon& polygon : instant.dark)
        for (Vector2d& corner : polygon) corner += shift_px;
    }
    const SpriteCoverage coverage = CoverageOf(sprite, view.Size(), options.psf_sigma_px, cover);
    if (coverage.region.empty()) throw Fail("frame {}: marker '{}' is outside the picture", frame, name);
    const cv::Mat light = LightOf(sprite, coverage, composition.under, options.psf_sigma_px);
    return {coverage.region.tl(), light * Brightness(frame)};
  }
};

Scene::Scene(const SceneOptions& options) {
  options.Check();
  impl_ = std::make_unique<Impl>(options, MakeMotion(options));
}
Scene::Scene(const SceneOptions& options, std::shared_ptr<const MarkerMotion> motion) {
  options.Check();
  impl_ = std::make_unique<Impl>(options, std::move(motion));
}
Scene::Scene(Scene&&) noexcept = default;
Scene::~Scene() = default;

const SceneOptions& Scene::Options() const {
  return impl_->options;
}
const MarkerMotion& Scene::Motion() const {
  return *impl_->motion;
}
const camera::CameraProfile& Scene::Profile() const {
  return impl_->profile;
}
int Scene::Frames() const {
  return impl_->frames;
}
double Scene::TimeS(int frame) const {
  return impl_->TimeS(frame);
}
FrameTruth Scene::Truth(int frame) const {
  return impl_->Truth(frame);
}
cv::Mat Scene::RenderIdeal(int frame) const {
  return impl_->RenderIdeal(frame);
}
cv::Mat Scene::Render(int frame) const {
  return impl_->sensor.Record(impl_->RenderIdeal(frame), frame);
}
ImagePatch Scene::RenderMarker(int frame, const std::string& marker, const Vector2d& shift_px) const {
  return impl_->RenderMarker(frame, marker, shift_px);
}

}  // namespace lake::synth
