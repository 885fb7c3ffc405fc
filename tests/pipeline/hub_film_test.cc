// An exoskeleton whose joint stands proud of the leg, and whose hub hides the knee: where the joint is said to be, by
// lake compare and live, and whether its interval holds. Some draws are filmed; for many the tracks are drawn, which
// tell the same to a tenth of a millimetre in a twentieth of the time.
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "lake/commands/compare.h"
#include "lake/compare/uncertainty_budget.h"
#include "lake/gait/learnt_knee.h"
#include "lake/live/joint_place.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

using Eigen::Vector2d;

// A person anywhere in the picture, before a camera that looks askance.
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

// Both signs of all that is drawn come equally often, so that a mean error is no luck.
struct Lot {
  explicit Lot(int draw) : random(static_cast<unsigned>(draw) / 2), sign(draw % 2 == 0 ? 1 : -1) {}
  double Uniform(double most) { return sign * std::uniform_real_distribution<double>(-most, most)(random); }
  double Normal(double sd) { return sign * std::normal_distribution<double>(0, sd)(random); }
  std::mt19937_64 random;
  double sign;
};

// A person without and with the exoskeleton, and where its joint is against the knee.
struct Pair {
  synth::SceneOptions human, worn;
  std::vector<std::string> human_names = {"ankle", "knee", "hip", "waist"}, worn_names;
  gait::TechnicalMarkers technical = {};  // where they are, the hub hides the knee
  Vector2d place_mm;
};

// 40 mm proud, anywhere in the picture.
Pair ProudJoint(int draw) {
  Lot lot(draw);
  synth::StsMotionOptions motion;
  Pair pair{.human = Standing({0, 0, 0}, motion), .worn = {}, .worn_names = {}, .place_mm = {18, 32}};
  motion.exo_knee_mm = pair.place_mm;
  motion.seed = static_cast<std::uint64_t>(draw) + 2;
  const double aside_mm = lot.Uniform(650), up_mm = lot.Uniform(80);
  pair.worn = Standing({aside_mm, up_mm, lot.Uniform(10)}, motion);
  pair.worn.marker_depth_mm["exo_knee"] = 40;
  pair.worn_names = {"ankle", "knee", "hip", "waist", "exo_knee"};
  return pair;
}

// The hub hides the knee in every frame; it is 20 to 60 mm proud, nobody says how far, and the knee's marker is off the
// knee by skin and placement. The joint is somewhere on a circle about the knee, which is near the middle of the
// picture: a hub's depth that nobody said is off to one side beside it.
Pair Hub(int draw, int draws, double away_mm) {
  Lot lot(draw);
  const double aside_mm = -205 + lot.Uniform(300), up_mm = 110 + lot.Uniform(40);
  const Stance stance{aside_mm, up_mm, lot.Uniform(6)};
  const double direction = M_PI * (2 * draw + 1) / draws, off_x_mm = lot.Normal(std::hypot(7, 3));
  const Vector2d off_mm(off_x_mm, lot.Normal(std::hypot(7, 3)));
  synth::StsMotionOptions motion;
  motion.seed = static_cast<std::uint64_t>(draw / 2) + 2;
  motion.skin_mm = 2;
  motion.extra_markers = {"shank1", "shank2"};
  Pair pair{.human = Standing(stance, motion),
            .worn = {},
            .worn_names = {"ankle", "hip", "waist", "exo_knee", "shank1", "shank2"},
            .technical = {{"shank", motion.extra_markers}},
            .place_mm = away_mm * Vector2d(std::cos(direction), std::sin(direction))};
  pair.human_names.insert(pair.human_names.end(), motion.extra_markers.begin(), motion.extra_markers.end());
  motion.exo_knee_mm = pair.place_mm - off_mm;
  motion.pace = 1.2;
  pair.worn = Standing(stance, motion);
  pair.worn.hub_mm = std::max(40.0, motion.exo_knee_mm->norm() + 15);
  pair.worn.marker_depth_mm["exo_knee"] = 40 + (draw % 2 == 0 ? 20 : -20) * lot.Uniform(1);
  return pair;
}

// Of both trials' films, each marker pointed at.
class Films {
 public:
  explicit Films(const Pair& pair)
      : human_(synth::Scene(pair.human), kQuickly), worn_(synth::Scene(pair.worn), kQuickly) {
    Track(human_, pair.human_names,
          [&](commands::TrackRunOptions& options) { options.fit.technical = pair.technical; });
    const Json worn = Track(worn_, pair.worn_names, [&](commands::TrackRunOptions& options) {
      options.fit.technical = pair.technical;
      if (!pair.technical.empty()) options.fit.knee_trial = human_.folder / "trial";
    });
    if (pair.technical.empty()) return;
    EXPECT_FALSE(worn_.Truth(0).markers[1].visible) << "the hub hides the knee";
    EXPECT_EQ(worn["rebuilt_knee"]["frames"], worn_.scene.Frames());
  }

  Json Compare(const gait::MarkerDepths& depths) const {
    commands::CompareRunOptions options;
    options.human = human_.folder / "trial";
    options.exo = worn_.folder / "trial";
    options.human_picture.depths = options.exo_picture.depths = depths;
    Run run({"lake-compare", "test", Json::object(), worn_.folder / "comparison", true});
    return commands::RunCompare(options, run).at("uncertainty");
  }

 private:
  static Json Track(RenderedTrial& film, const std::vector<std::string>& names,
                    const std::function<void(commands::TrackRunOptions&)>& change) {
    return film.Track("trial", [&](commands::TrackRunOptions& options) {
      options.track.names = names;
      for (const std::string& name : names) {
        const int marker = synth::IndexOfMarker(film.scene.Motion(), name);
        options.track.seeds.push_back({.name = name, .position = film.Truth(0).markers[marker].px, .frame = 0});
      }
      change(options);
    });
  }

  RenderedTrial human_, worn_;
};

// Where the markers of a scene are seen, with the noise of such films.
motion::MarkerRecording DrawnTracks(const synth::Scene& scene, const std::vector<std::string>& names, unsigned seed) {
  constexpr double kNoise_px = 0.03;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kNoise_px);
  motion::MarkerRecording tracks{motion::LengthUnit::kPx, {}, {}, {}};
  for (const std::string& name : names) tracks.markers.push_back({name, {}});
  for (int frame = 0; frame < scene.Frames(); ++frame) {
    const synth::FrameTruth truth = scene.Truth(frame);
    tracks.frame.push_back(frame);
    tracks.time_s.push_back(truth.time_s);
    for (motion::MarkerTrack& track : tracks.markers) {
      const synth::MarkerTruth& marker =
          truth.markers[static_cast<std::size_t>(synth::IndexOfMarker(scene.Motion(), track.name))];
      motion::MarkerSample& sample = track.samples.emplace_back();
      if (!marker.visible) continue;
      sample = {.position = marker.px, .sigma = kNoise_px, .status = motion::SampleStatus::kDetected};
      sample.position += Vector2d(noise(random), noise(random));
    }
  }
  return tracks;
}

class Tracks {
 public:
  Tracks(const Pair& pair, int draw) : worn_scene_(pair.worn) {
    const synth::Scene human(pair.human);
    const auto seed = static_cast<unsigned>(2 * draw);
    human_ = Fit(DrawnTracks(human, pair.human_names, seed), View(human, {}), nullptr);
    if (!pair.technical.empty()) learnt_ = std::make_shared<gait::LearntKnee>(gait::LearnKnee(human_, pair.technical));
    worn_ = DrawnTracks(worn_scene_, pair.worn_names, seed + 1);
  }

  Json Compare(const gait::MarkerDepths& depths) const {
    const gait::LegFitResult worn = Fit(worn_, View(worn_scene_, depths), learnt_);
    compare::RegistrationOptions joint;
    joint.knee = "exo_knee";
    const compare::MisalignmentOptions compared;
    const compare::Misalignment misalignment = compare::CompareTrials(
        compare::RegisterTrial(TablesOf(human_)), compare::RegisterTrial(TablesOf(worn), joint), compared);
    return compare::BudgetsJson(compare::BudgetsOf(misalignment, compared.replacement_sd_mm, {}));
  }

  live::JointPlace PlaceLive(const gait::MarkerDepths& depths) const {
    live::RiseFinding finding{.view = View(worn_scene_, depths), .shutter = {}, .video = {}, .knee_from = learnt_};
    finding.video.width = worn_scene_.Options().width_px;
    finding.video.height = worn_scene_.Options().height_px;
    finding.video.frame_rate_hz = worn_scene_.Options().frame_rate_hz;
    return live::PlaceOf(live::FindRiseOffsets(worn_, finding).rises);
  }

 private:
  static gait::LegView View(const synth::Scene& scene, const gait::MarkerDepths& depths) {
    return gait::MakeLegView(motion::LengthUnit::kPx, scene.Profile(), {}, depths);
  }
  static gait::LegFitResult Fit(const motion::MarkerRecording& tracks, const gait::LegView& view,
                                std::shared_ptr<const gait::LearntKnee> learnt) {
    gait::LegFitOptions options;
    options.knee_from = std::move(learnt);
    gait::LegFitResult fit = gait::FitLeg(tracks, view, options);
    gait::ChooseMovement({}, fit);
    return fit;
  }
  static compare::TrialTables TablesOf(const gait::LegFitResult& fit) {
    return {"drawn", fit.trajectory, fit.motion, fit.events, fit.sight};
  }

  synth::Scene worn_scene_;
  gait::LegFitResult human_;
  std::shared_ptr<const gait::LearntKnee> learnt_;
  motion::MarkerRecording worn_;
};

// How often intervals hold the joint's place, by how much it is missed, and by how much the intervals claim.
struct Draws {
  int draws = 0, held[3] = {};  // of the distance, x and y
  std::vector<double> error_mm[2], half_width_mm[2];

  // What lake compare says.
  void Add(const Json& uncertainty, const char* interval, const Vector2d& truth_mm) {
    ++draws;
    const auto take = [&](int at, const char* quantity, double truth) {
      const Json &of = uncertainty.at(quantity), &range = of.at(interval);
      Take(at, of.at("value"), range.at(0), range.at(1), truth);
    };
    take(0, "joint_rms_mm", truth_mm.norm());
    take(1, "joint_offset_x_mm", truth_mm.x());
    take(2, "joint_offset_y_mm", truth_mm.y());
  }
  void Add(const live::JointPlace& place, bool anatomical, const Vector2d& truth_mm) {
    ++draws;
    const Vector2d half = anatomical ? place.anatomical_half_width_mm : place.half_width_mm;
    ++held[0];  // of the distance beneath the skin the session says no interval
    for (const int axis : {0, 1}) {
      const double value = place.offset_mm[axis];
      Take(axis + 1, value, value - half[axis], value + half[axis], truth_mm[axis]);
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
        "{}: of {} held distance {}, x {}, y {}; bias {:.2f}, {:.2f} mm; scatter {:.2f}, {:.2f} mm; half width {:.1f}, "
        "{:.1f} mm\n",
        what, draws, held[0], held[1], held[2], Mean(error_mm[0]), Mean(error_mm[1]), StandardDeviation(error_mm[0]),
        StandardDeviation(error_mm[1]), Mean(half_width_mm[0]), Mean(half_width_mm[1]));
  }

 private:
  void Take(int at, double value, double low, double high, double truth) {
    held[at] += low <= truth && truth <= high;
    if (at == 0) return;
    error_mm[at - 1].push_back(value - truth);
    half_width_mm[at - 1].push_back((high - low) / 2);
  }
};

constexpr const char *kMarkers = "marker_interval", *kAnatomical = "anatomical_interval";

void ExpectAlike(const Json& filmed, const Json& drawn) {
  for (const char* quantity : {"joint_offset_x_mm", "joint_offset_y_mm"})
    EXPECT_NEAR(filmed.at(quantity).at("value").get<double>(), drawn.at(quantity).at("value").get<double>(), 0.3);
}

TEST(ProudJointFilm, IsHeldWithoutItsDepthAndRightWithIt) {
  constexpr int kFilms = 2;
  Draws unknown, known;
  for (int film = 0; film < kFilms; ++film) {
    const Pair pair = ProudJoint(film);
    const Films films(pair);
    const Json of_films = films.Compare({});
    ExpectAlike(of_films, Tracks(pair, film).Compare({}));
    unknown.Add(of_films, kMarkers, pair.place_mm);
    known.Add(films.Compare({{"exo_knee", {40, 3}}}), kMarkers, pair.place_mm);
  }
  EXPECT_EQ(unknown.LeastHeld(), kFilms);
  EXPECT_EQ(known.LeastHeld(), kFilms);
  EXPECT_LE(known.BiasMm(), 0.5);
}

TEST(HubFilm, TheJointIsFoundBesideAKneeThatItHides) {
  constexpr int kFilms = 2;
  Draws films;
  for (int film = 0; film < kFilms; ++film) {
    const Pair pair = Hub(film, kFilms, 3);
    const Json of_films = Films(pair).Compare({});
    ExpectAlike(of_films, Tracks(pair, film).Compare({}));
    films.Add(of_films, kAnatomical, pair.place_mm);
  }
  EXPECT_EQ(films.LeastHeld(), kFilms);
}

constexpr int kMany = 60;

TEST(ManyProudJoints, AreHeldWithoutTheirDepthAndRightWithIt) {
  Draws unknown[2], known[2];  // lake compare, lake live
  for (int draw = 0; draw < kMany; ++draw) {
    const Pair pair = ProudJoint(draw);
    const Tracks tracks(pair, draw);
    const gait::MarkerDepths depths{{"exo_knee", {40, 3}}};
    unknown[0].Add(tracks.Compare({}), kMarkers, pair.place_mm);
    unknown[1].Add(tracks.PlaceLive({}), false, pair.place_mm);
    known[0].Add(tracks.Compare(depths), kMarkers, pair.place_mm);
    known[1].Add(tracks.PlaceLive(depths), false, pair.place_mm);
  }
  for (const int i : {0, 1}) {
    unknown[i].Print(i == 0 ? "depth not known" : "depth not known, live");
    known[i].Print(i == 0 ? "depth 40±3" : "depth 40±3, live");
    EXPECT_GE(unknown[i].LeastHeld(), 0.9 * kMany);
    EXPECT_GE(known[i].LeastHeld(), 0.9 * kMany);
    EXPECT_LE(known[i].BiasMm(), 0.5);
  }
}

class ManyHubs : public testing::TestWithParam<double> {};  // how far the joint is from the knee, mm

TEST_P(ManyHubs, TheJointIsFoundBesideAKneeThatTheyHide) {
  Draws compared, live;
  for (int draw = 0; draw < kMany; ++draw) {
    const Pair pair = Hub(draw, kMany, GetParam());
    const Tracks tracks(pair, draw);
    compared.Add(tracks.Compare({}), kAnatomical, pair.place_mm);
    live.Add(tracks.PlaceLive({}), true, pair.place_mm);
  }
  compared.Print(fmt::format("joint {:g} mm away", GetParam()));
  live.Print("the same live");
  for (const Draws* draws : {&compared, &live}) {
    EXPECT_GE(draws->LeastHeld(), 0.9 * kMany);
    EXPECT_LE(draws->BiasMm(), 1);
    EXPECT_LE(draws->TooWide(), 2);
  }
}

INSTANTIATE_TEST_SUITE_P(, ManyHubs, testing::Values(0, 3, 10, 25));

}  // namespace
}  // namespace lake
