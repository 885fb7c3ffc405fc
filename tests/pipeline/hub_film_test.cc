// Films of an exoskeleton whose joint stands proud of the leg, and whose hub hides the knee: where the joint is said to
// be, and whether its interval holds.
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "lake/commands/compare.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

using Eigen::Vector2d;

// A person anywhere in the picture, before a camera that looks askance; the same for both trials.
struct Stance {
  double aside_mm, up_mm, yaw_deg;
};

synth::SceneOptions Standing(const Stance& stance, const synth::StsMotionOptions& motion) {
  synth::SceneOptions scene = synth::CleanScene(1);
  scene.duration_s = 0;
  scene.frame_rate_hz = 30;
  scene.room = scene.body = false;
  scene.yaw_deg = stance.yaw_deg;
  scene.motion = motion;
  scene.motion.repetitions = 1;
  scene.motion.max_rest_s = scene.motion.min_rest_s = 0.7;
  camera::CameraProfile camera = synth::Scene(scene).Profile();
  camera.camera_from_plane->translate(Eigen::Vector3d(stance.aside_mm, stance.up_mm, 0));
  scene.camera = camera;
  return scene;
}

// Rendered, tracked with what is said of it, each marker pointed at.
Json TrackFilm(RenderedTrial& film, const std::vector<std::string>& names,
               const std::function<void(commands::TrackRunOptions&)>& change = {}) {
  return film.Track("trial", [&](commands::TrackRunOptions& options) {
    options.track.names = names;
    for (const std::string& name : names) {
      const int marker = synth::IndexOfMarker(film.scene.Motion(), name);
      options.track.seeds.push_back({.name = name, .position = film.Truth(0).markers[marker].px, .frame = 0});
    }
    if (change) change(options);
  });
}

Json Compare(const RenderedTrial& human, const RenderedTrial& exo, const gait::MarkerDepths& depths = {}) {
  commands::CompareRunOptions options;
  options.human = human.folder / "trial";
  options.exo = exo.folder / "trial";
  options.human_picture.depths = options.exo_picture.depths = depths;
  Run run({"lake-compare", "test", Json::object(), exo.folder / "comparison", true});
  return commands::RunCompare(options, run);
}

// How often intervals hold the joint's place, by how much it is missed, and by how much the intervals claim.
struct Draws {
  int films = 0, held[3] = {};  // of the RMS, x and y
  std::vector<double> error_mm[2], half_width_mm[2];

  void Add(const Json& comparison, const char* interval, const Vector2d& truth_mm) {
    ++films;
    const Json& of = comparison.at("uncertainty");
    const auto holds = [&](const char* quantity, double truth) {
      const Json& range = of.at(quantity).at(interval);
      return range.at(0).get<double>() <= truth && truth <= range.at(1).get<double>();
    };
    held[0] += holds("joint_rms_mm", truth_mm.norm());
    for (int axis = 0; axis < 2; ++axis) {
      const char* quantity = axis == 0 ? "joint_offset_x_mm" : "joint_offset_y_mm";
      held[axis + 1] += holds(quantity, truth_mm[axis]);
      error_mm[axis].push_back(of.at(quantity).at("value").get<double>() - truth_mm[axis]);
      const Json& range = of.at(quantity).at(interval);
      half_width_mm[axis].push_back((range.at(1).get<double>() - range.at(0).get<double>()) / 2);
    }
  }
  double BiasMm() const { return std::max(std::abs(Mean(error_mm[0])), std::abs(Mean(error_mm[1]))); }
  int LeastHeld() const { return *std::ranges::min_element(held); }
  // Of the interval against that of the draws' own scatter, the wider axis.
  double TooWide() const {
    double most = 0;
    for (const int axis : {0, 1})
      most = std::max(most, Mean(half_width_mm[axis]) / (1.96 * StandardDeviation(error_mm[axis])));
    return most;
  }
  void Print(const std::string& what) const {
    fmt::print(
        "{}: of {} held RMS {}, x {}, y {}; bias {:.2f}, {:.2f} mm; scatter {:.2f}, {:.2f} mm; half width {:.1f}, "
        "{:.1f} mm\n",
        what, films, held[0], held[1], held[2], Mean(error_mm[0]), Mean(error_mm[1]), StandardDeviation(error_mm[0]),
        StandardDeviation(error_mm[1]), Mean(half_width_mm[0]), Mean(half_width_mm[1]));
  }
};

// Both signs of all that is drawn come equally often, so that a mean error is no luck.
struct Lot {
  explicit Lot(unsigned film) : random(film / 2), sign(film % 2 == 0 ? 1 : -1) {}
  double Uniform(double most) { return sign * std::uniform_real_distribution<double>(-most, most)(random); }
  double Normal(double sd) { return sign * std::normal_distribution<double>(0, sd)(random); }
  Stance Draw() { return {Uniform(650), Uniform(80), Uniform(10)}; }
  std::mt19937_64 random;
  double sign;
};

class ProudJoint : public testing::TestWithParam<int> {};  // films

// A joint 40 mm proud, anywhere in the picture: without its depth the interval holds what parallax makes, with it the
// place is right.
TEST_P(ProudJoint, IsHeldWithoutItsDepthAndRightWithIt) {
  const Vector2d place_mm(18, 32);
  Draws unknown, known;
  synth::StsMotionOptions motion;
  RenderedTrial human(synth::Scene(Standing({0, 0, 0}, motion)), {.preset = kQuickEncoder});
  TrackFilm(human, {"ankle", "knee", "hip", "waist"});
  for (int film = 0; film < GetParam(); ++film) {
    Lot lot(static_cast<unsigned>(film));
    motion.exo_knee_mm = place_mm;
    motion.seed = static_cast<std::uint64_t>(film) + 2;
    synth::SceneOptions scene = Standing(lot.Draw(), motion);
    scene.marker_depth_mm["exo_knee"] = 40;
    RenderedTrial exo(synth::Scene(scene), {.preset = kQuickEncoder});
    TrackFilm(exo, {"ankle", "knee", "hip", "waist", "exo_knee"});
    unknown.Add(Compare(human, exo), "marker_interval", place_mm);
    known.Add(Compare(human, exo, {{"exo_knee", {40, 3}}}), "marker_interval", place_mm);
  }
  unknown.Print("depth not known");
  known.Print("depth 40±3");
  EXPECT_GE(unknown.LeastHeld(), 0.9 * GetParam());
  EXPECT_GE(known.LeastHeld(), 0.9 * GetParam());
  EXPECT_LE(known.BiasMm(), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Few, ProudJoint, testing::Values(4));
INSTANTIATE_TEST_SUITE_P(Many, ProudJoint, testing::Values(60));

struct HubCase {
  double away_mm;
  int films;
};
class Hub : public testing::TestWithParam<HubCase> {};

// The hub hides the knee in every frame; it is 20 to 60 mm proud, nobody says how far, and the knee's marker is off the
// knee by skin and placement. The place is that of the knee rebuilt from two markers on the shank.
TEST_P(Hub, TheJointIsFoundBesideAKneeThatItHides) {
  Draws draws;
  for (int film = 0; film < GetParam().films; ++film) {
    Lot lot(static_cast<unsigned>(film));
    // The knee is in the middle of the picture on average: a hub's depth that nobody said is off to one side beside it.
    const Stance stance{-235 + lot.Uniform(300), 60 + lot.Uniform(40), lot.Uniform(6)};
    const double direction = M_PI * (2 * film + 1) / GetParam().films;
    const Vector2d place_mm = GetParam().away_mm * Vector2d(std::cos(direction), std::sin(direction));
    const Vector2d off_mm(lot.Normal(std::hypot(7, 3)), lot.Normal(std::hypot(7, 3)));
    synth::StsMotionOptions motion;
    motion.seed = static_cast<std::uint64_t>(film / 2) + 2;
    motion.skin_mm = 2;
    motion.extra_markers = {"shank1", "shank2"};
    const std::vector<std::string> technical = motion.extra_markers;
    RenderedTrial human(synth::Scene(Standing(stance, motion)), {.preset = kQuickEncoder});
    TrackFilm(human, {"ankle", "knee", "hip", "waist", "shank1", "shank2"},
              [&](commands::TrackRunOptions& options) { options.fit.technical["shank"] = technical; });
    motion.exo_knee_mm = place_mm - off_mm;
    motion.pace = 1.2;
    synth::SceneOptions scene = Standing(stance, motion);
    scene.hub_mm = std::max(40.0, motion.exo_knee_mm->norm() + 15);
    scene.marker_depth_mm["exo_knee"] = 40 + (film % 2 == 0 ? 20 : -20) * lot.Uniform(1);
    RenderedTrial exo(synth::Scene(scene), {.preset = kQuickEncoder});
    EXPECT_FALSE(exo.Truth(0).markers[1].visible) << "the hub hides the knee";
    const Json worn = TrackFilm(exo, {"ankle", "hip", "waist", "exo_knee", "shank1", "shank2"},
                                [&](commands::TrackRunOptions& options) {
                                  options.fit.technical["shank"] = technical;
                                  options.fit.knee_trial = human.folder / "trial";
                                });
    EXPECT_EQ(worn["rebuilt_knee"]["frames"], exo.scene.Frames());
    draws.Add(Compare(human, exo), "anatomical_interval", place_mm);
  }
  draws.Print(fmt::format("joint {:g} mm away", GetParam().away_mm));
  EXPECT_GE(draws.LeastHeld(), 0.9 * GetParam().films);
  if (GetParam().films < 10) return;
  EXPECT_LE(draws.BiasMm(), 1);
  EXPECT_LE(draws.TooWide(), 2);
}

INSTANTIATE_TEST_SUITE_P(Few, Hub, testing::Values(HubCase{3, 2}));
INSTANTIATE_TEST_SUITE_P(Many, Hub, testing::Values(HubCase{0, 60}, HubCase{3, 60}, HubCase{10, 60}, HubCase{25, 60}));

}  // namespace
}  // namespace lake
