// A hidden knee from technical markers on the skin: of real legs against its own marker, of drawn ones against the
// truth, and what is wrong in a sentence.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <string>

#include "draws.h"
#include "fitted_movement.h"
#include "lake/core/error.h"
#include "lake/core/options.h"
#include "lake/core/statistics.h"
#include "lake/exchange/trial.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/movement.h"
#include "message_of.h"
#include "name_map.h"
#include "places.h"
#include "synthetic_leg.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

struct Excerpt {
  motion::MarkerRecording recording;
  gait::LateralPlaces lateral;
};

// The frames from a time to another one, since the first.
Excerpt Cut(const exchange::Trial& trial, double from_s, double to_s, bool in_space) {
  Excerpt part{{trial.recording.unit, {}, {}, trial.recording.markers}, {}};
  for (motion::MarkerTrack& marker : part.recording.markers) marker.samples.clear();
  for (std::size_t i = 0; i < trial.recording.Frames(); ++i) {
    const double time_s = trial.recording.time_s[i] - trial.recording.time_s[0];
    if (time_s < from_s || time_s >= to_s) continue;
    part.recording.frame.push_back(trial.recording.frame[i]);
    part.recording.time_s.push_back(trial.recording.time_s[i]);
    for (std::size_t m = 0; m < part.recording.markers.size(); ++m)
      part.recording.markers[m].samples.push_back(trial.recording.markers[m].samples[i]);
    for (const auto& [name, across] : trial.lateral_mm)
      if (in_space) part.lateral[name].push_back(across[i]);
  }
  return part;
}

std::vector<motion::MarkerSample>& SamplesOf(motion::MarkerRecording& recording, std::string_view name) {
  return std::ranges::find(recording.markers, name, &motion::MarkerTrack::name)->samples;
}

gait::LearntKnee Learn(const Excerpt& part, const gait::TechnicalMarkers& technical, const gait::LegView& view) {
  gait::LegFitResult person = gait::FitLeg(part.recording, view, {}, part.lateral);
  gait::ChooseMovement({}, person);
  gait::LearntKnee learnt = gait::LearnKnee(person, technical, part.lateral);
  learnt.trial = "the human trial";
  return learnt;
}

gait::LegFitResult Rebuild(const Excerpt& part, const gait::LearntKnee& learnt, const gait::LegView& view) {
  gait::LegFitOptions options;
  options.knee_from = std::make_shared<gait::LearntKnee>(learnt);
  return gait::FitLeg(part.recording, view, options, part.lateral);
}

// Rebuilt places against the true ones in the plane, over frames in which both are known.
struct Errors {
  double rms_mm = 0, over_sd = 0;
  std::size_t frames = 0;
};

Errors ErrorsOf(const gait::LegFitResult& worn, const std::function<Eigen::Vector2d(std::size_t)>& truth_mm) {
  std::vector<double> off, ratios;
  for (std::size_t i = 0; i < worn.motion.frame.size(); ++i) {
    const motion::MarkerSample& knee = worn.trajectory.Find("knee")->samples[i];
    const Eigen::Vector2d error = knee.position - truth_mm(i);
    if (!worn.rebuilt_knee->frames[i] || !knee.IsKnown() || !error.allFinite()) continue;
    EXPECT_EQ(knee.status, motion::SampleStatus::kFilled);
    EXPECT_TRUE(std::isnan(worn.motion.samples[i].knee_raw_deg));
    off.push_back(error.norm());
    ratios.push_back(error.norm() / knee.sigma / std::sqrt(2));
  }
  return {RootMeanSquare(off), RootMeanSquare(ratios), off.size()};
}

struct HiddenCase {
  const char *name, *file, *names;  // of the leg and of technical markers
  gait::TechnicalMarkers technical;
  double from_s;  // the knee is hidden from then on
  bool in_space;  // with the places across the plane
  const char* forward = "+x";
  double noise_mm = 0;  // that is added to every coordinate
  double least_over_sd = 0.7;
};

// The same in each run; another one in each part.
void AddNoise(double noise_mm, unsigned seed, Excerpt& part) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  for (motion::MarkerTrack& marker : part.recording.markers)
    for (motion::MarkerSample& sample : marker.samples)
      sample.position += noise_mm * Eigen::Vector2d(normal(random), normal(random));
  for (auto& [name, across] : part.lateral)
    for (double& place : across) place += noise_mm * normal(random);
}

class RebuiltKneeOf : public testing::TestWithParam<HiddenCase> {};

TEST_P(RebuiltKneeOf, RealLegIsWhereItsMarkerWas) {
  const HiddenCase& c = GetParam();
  const fs::path file = SharedData() / c.file;
  if (!fs::exists(file)) GTEST_SKIP() << file.string() << " is not here";
  const exchange::Trial trial = exchange::ReadTrial(file, {NameMap(c.names), {}, c.forward});
  const gait::LegView view = gait::MakeLegView(motion::LengthUnit::kMm, std::nullopt);
  Excerpt before = Cut(trial, 0, c.from_s, c.in_space), after = Cut(trial, c.from_s, INFINITY, c.in_space);
  const std::vector<motion::MarkerSample> truth = SamplesOf(after.recording, "knee");
  AddNoise(c.noise_mm, 1, before);
  AddNoise(c.noise_mm, 2, after);
  // Worn, no marker has this name.
  std::erase_if(after.recording.markers, [](const motion::MarkerTrack& marker) { return marker.name == "knee"; });
  after.lateral.erase("knee");
  const gait::LearntKnee learnt = Learn(before, c.technical, view);
  EXPECT_EQ(learnt.shape_mm.cols(), std::ssize(learnt.markers));
  const gait::LegFitResult worn = Rebuild(after, learnt, view);
  const Errors errors = ErrorsOf(worn, [&](std::size_t i) -> Eigen::Vector2d {
    return truth[i].IsKnown() ? truth[i].position : Eigen::Vector2d::Constant(NAN);
  });
  RecordProperty("rms_mm", std::to_string(errors.rms_mm));
  RecordProperty("over_sd", std::to_string(errors.over_sd));
  EXPECT_GT(errors.frames, 0.95 * static_cast<double>(std::ranges::count_if(truth, &motion::MarkerSample::IsKnown)));
  EXPECT_LT(errors.rms_mm, 3);  // asked: 4
  EXPECT_GT(errors.over_sd, c.least_over_sd);
  EXPECT_LT(errors.over_sd, 1.4);
}

constexpr const char* kOptical = "opencap_sts/sts_default_markers.trc";
constexpr const char* kPlates = "sts_force_plates/STS1.trc";
constexpr const char* kSquats = "real_motions/subject4_squats1.trc";
constexpr const char* kRight = "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=R_Shoulder,a=r_sh2,b=r_sh3";
constexpr const char* kLeft = "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L_Shoulder,a=L_sh2,b=L_sh3";
constexpr const char* kWalkRight = "ankle=RLMAL,knee=RLFC,hip=RHJC,a=RTB1,b=RTB2,c=RTB3,d=RTH1,e=RTH2,f=RTH3";
constexpr const char* kWalkLeft = "ankle=LLMAL,knee=LLFC,hip=LHJC,a=LTB1,b=LTB2,c=LTB3,d=LTH1,e=LTH2,f=LTH3";
// There the markers' skin moves less in the second half than in the first.
constexpr double kOfUnlikeHalves = 0.6;
const gait::TechnicalMarkers kShank = {{"shank", {"a", "b"}}},
                             kBoth = {{"shank", {"a", "b", "c"}}, {"thigh", {"d", "e", "f"}}};

INSTANTIATE_TEST_SUITE_P(
    , RebuiltKneeOf,
    testing::Values(HiddenCase{"OpticalRight", kOptical, kRight, kShank, 4.3, true},
                    HiddenCase{"OpticalLeft", kOptical, kLeft, kShank, 4.3, true},
                    HiddenCase{"OpticalRightInPlane", kOptical, kRight, kShank, 4.3, false},
                    HiddenCase{"OpticalLeftMirrored", kOptical, kLeft, kShank, 4.3, false, "-x"},
                    HiddenCase{"PlatesRight", kPlates, kRight, kShank, 7, true},
                    HiddenCase{"PlatesLeft", kPlates, kLeft, kShank, 7, true},
                    HiddenCase{"PlatesRightInPlane", kPlates, kRight, kShank, 7, false},
                    HiddenCase{"PlatesLeftFromOneRise", kPlates, kLeft, kShank, 2.7, true},
                    HiddenCase{"PlatesRightNoisy", kPlates, kRight, kShank, 7, true, "+x", 1},
                    HiddenCase{"OpticalRightNoisy", kOptical, kRight, kShank, 4.3, false, "+x", 1},
                    HiddenCase{"SquatsRight", kSquats, kRight, kShank, 6.7, true, ""},
                    HiddenCase{"Walking2Right", "opensim_walk/walking2.c3d", kWalkRight, kBoth, 2.6, true, ""},
                    HiddenCase{"Walking2Left", "opensim_walk/walking2.c3d", kWalkLeft, kBoth, 2.6, true, ""},
                    HiddenCase{"Walking5Right", "opensim_walk/walking5.c3d", kWalkRight, kBoth, 2.6, true, "", 0,
                               kOfUnlikeHalves},
                    HiddenCase{"Walking5Left", "opensim_walk/walking5.c3d", kWalkLeft, kBoth, 2.6, true, ""}),
    [](const auto& info) { return info.param.name; });

// Drawn rises through a calibrated camera, with two markers on the shank. The knee's skin slides by up to 20 mm with
// the flexion, not quite alike in each repetition.
struct Drawn {
  Excerpt part;
  std::vector<Eigen::Vector2d> knee_mm;
};

Drawn Draw(unsigned seed, Eigen::Vector2d pressed_mm = {0, 0}, SyntheticLegOptions leg_options = {.repetitions = 4}) {
  const SyntheticLeg leg = MakeSyntheticLeg(leg_options, seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Drawn drawn;
  std::vector<gait::LegPoints> points = leg.points_mm, beside = leg.points_mm;
  const double side = leg_options.facing == motion::Facing::kRight ? 1 : -1;
  double slip_mm = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    slip_mm += -slip_mm / 30 + 0.5 * normal(random);  // memory of half a second, SD 2 mm
    const double bent = leg.truth[i].knee_deg / 90;
    const Eigen::Vector2d up = (*points[i].knee - *points[i].ankle).normalized(), front(side * up.y(), -side * up.x());
    const Eigen::Vector2d ankle = *points[i].ankle;
    points[i].knee =
        *points[i].knee + (20 * bent + slip_mm + pressed_mm.x()) * front + (8 * bent * bent + pressed_mm.y()) * up;
    drawn.knee_mm.push_back(*points[i].knee);
    beside[i] = {ankle + 300 * up + 40 * front, ankle + 160 * up + 30 * front, *points[i].hip, {}};
    beside[i].waist = beside[i].hip;
  }
  drawn.part.recording = MakeTracks(leg.time_s, points, CalibratedView(), {0.03}, seed);
  motion::MarkerRecording more = MakeTracks(leg.time_s, beside, CalibratedView(), {0.03}, seed + 100);
  for (std::size_t m = 0; m < 2; ++m) {
    more.markers[m].name = m == 0 ? "shank1" : "shank2";
    drawn.part.recording.markers.push_back(more.markers[m]);
  }
  return drawn;
}

const gait::TechnicalMarkers kTwo = {{"shank", {"shank1", "shank2"}}};

// Hides the knee where its angle is in this range.
void HideBetween(double from_deg, double to_deg, const Drawn& drawn, motion::MarkerRecording& recording) {
  const gait::LegFitResult seen = gait::FitLeg(drawn.part.recording, CalibratedView());
  for (std::size_t i = 0; i < recording.Frames(); ++i)
    if (seen.motion.samples[i].knee_deg >= from_deg && seen.motion.samples[i].knee_deg < to_deg)
      SamplesOf(recording, "knee")[i] = {};
}

TEST(RebuiltKnee, OfDrawnLegsIsAsFarOffAsItSays) {
  std::vector<double> ratios, pressed_ratios;
  for (unsigned seed = 1; seed <= Draws(2, 5); ++seed) {
    const gait::LearntKnee learnt = Learn(Draw(seed).part, kTwo, CalibratedView());
    Drawn hidden = Draw(seed + 20);
    std::ranges::fill(SamplesOf(hidden.part.recording, "knee"), motion::MarkerSample());
    const gait::LegFitResult worn = Rebuild(hidden.part, learnt, CalibratedView());
    const Errors errors = ErrorsOf(worn, [&](std::size_t i) { return hidden.knee_mm[i]; });
    EXPECT_EQ(errors.frames, hidden.knee_mm.size());
    EXPECT_LT(errors.rms_mm, 3.5);
    ratios.push_back(errors.over_sd);
    EXPECT_EQ(worn.rebuilt_knee->seen_frames, 0u);
    EXPECT_EQ(worn.motion.facing, motion::Facing::kRight);
    // A cuff presses the skin aside by 10 mm; the marker is seen where the leg is nearly straight.
    const Drawn pressed = Draw(seed + 40, {-8, 6});
    Excerpt part = pressed.part;
    HideBetween(15, 180, pressed, part.recording);
    const gait::LegFitResult shown = Rebuild(part, learnt, CalibratedView());
    const Errors rest = ErrorsOf(shown, [&](std::size_t i) { return pressed.knee_mm[i]; });
    EXPECT_LT(rest.rms_mm, 4.5) << "10 mm without the frames that show it";
    EXPECT_NEAR(shown.rebuilt_knee->difference_mm.x(), -8, 2.5);
    EXPECT_NEAR(shown.rebuilt_knee->difference_mm.y(), 6, 1);
    pressed_ratios.push_back(rest.over_sd);
  }
  EXPECT_GT(RootMeanSquare(ratios), 0.7);
  EXPECT_LT(RootMeanSquare(ratios), 1.4);
  EXPECT_GT(RootMeanSquare(pressed_ratios), 0.4);  // a quarter of the shift is taken to differ with the flexion
  EXPECT_LT(RootMeanSquare(pressed_ratios), 1.4);
}

// Learnt where the leg bends by 40° at most: farther on the standard deviation grows, and holds what the knee is off
// by.
TEST(RebuiltKnee, IsLessCertainBeyondWhatWasLearnt) {
  const Drawn person = Draw(3);
  Excerpt straight = person.part;
  HideBetween(50, 180, person, straight.recording);
  gait::LearntKnee learnt = Learn(straight, kTwo, CalibratedView());
  EXPECT_NEAR(learnt.to_deg, 50, 3);
  Drawn hidden = Draw(4);
  std::ranges::fill(SamplesOf(hidden.part.recording, "knee"), motion::MarkerSample());
  const gait::LegFitResult worn = Rebuild(hidden.part, learnt, CalibratedView());
  double bent_sd = 0, straight_sd = 0;
  for (std::size_t i = 0; i < hidden.knee_mm.size(); ++i) {
    const double sd = worn.tracks.Find("knee")->samples[i].sigma;
    if (worn.motion.samples[i].knee_deg > 85) bent_sd = sd;
    if (worn.motion.samples[i].knee_deg < 40) straight_sd = sd;
  }
  EXPECT_GT(bent_sd, 2 * straight_sd);
  EXPECT_LT(ErrorsOf(worn, [&](std::size_t i) { return hidden.knee_mm[i]; }).over_sd, 1.4);
}

TEST(RebuiltKnee, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const gait::LearntKnee learnt = Learn(Draw(1).part, kTwo, CalibratedView());
  WriteJsonFile(folder.Path() / "summary.json", {{gait::kLearntKnee, gait::LearntKneeJson(learnt)}});
  const gait::LearntKnee read = gait::ReadLearntKnee(folder.Path());
  EXPECT_EQ(gait::LearntKneeJson(read), gait::LearntKneeJson(learnt));
  EXPECT_EQ(read.trial, folder.Path().string());
  WriteJsonFile(folder.Path() / "summary.json", {{gait::kLearntKnee, {{"flexion_deg", {0, "x"}}}}});
  EXPECT_THROW(gait::ReadLearntKnee(folder.Path()), Error);
  WriteJsonFile(folder.Path() / "summary.json", Json::object());
  EXPECT_THAT(MessageOf([&] { gait::ReadLearntKnee(folder.Path()); }),
              testing::HasSubstr("no knee was learnt there; track or fit that trial with --technical"));
}

// What `change` makes of a hidden trial, in the error or the warnings.
std::string SaidOf(const std::function<void(motion::MarkerRecording& recording)>& change, unsigned seed = 30) {
  const gait::LearntKnee learnt = Learn(Draw(1).part, kTwo, CalibratedView());
  Excerpt part = Draw(seed).part;
  std::ranges::fill(SamplesOf(part.recording, "knee"), motion::MarkerSample());
  change(part.recording);
  std::string warnings;
  const std::string refusal = MessageOf([&] { warnings = WarningsOf(Rebuild(part, learnt, CalibratedView())); });
  return refusal + warnings;
}

TEST(RebuiltKnee, SaysWhatIsWrongWithTechnicalMarkers) {
  using testing::HasSubstr;
  EXPECT_EQ(SaidOf([](auto&) {}), "");
  EXPECT_THAT(SaidOf([](motion::MarkerRecording& r) { std::swap(SamplesOf(r, "shank1"), SamplesOf(r, "shank2")); }),
              HasSubstr("the technical markers 'shank1' and 'shank2' of the shank are exchanged"));
  EXPECT_THAT(SaidOf([](motion::MarkerRecording& r) {
                auto& samples = SamplesOf(r, "shank1");
                for (std::size_t i = samples.size() / 2; i < samples.size(); ++i) samples[i].position.y() += 40;
              }),
              HasSubstr("'shank1' is not where it was on the shank in the human trial: has it come off"));
  EXPECT_THAT(SaidOf([](motion::MarkerRecording& r) {
                for (motion::MarkerSample& sample : SamplesOf(r, "shank2")) sample.position.y() += 4;
              }),
              HasSubstr("have moved against each other since the human trial"));
  EXPECT_THAT(SaidOf([](motion::MarkerRecording& r) {
                for (motion::MarkerSample& sample : SamplesOf(r, "shank1")) sample.position += Eigen::Vector2d(50, 20);
                for (motion::MarkerSample& sample : SamplesOf(r, "shank2")) sample.position += Eigen::Vector2d(-10, 60);
              }),
              HasSubstr("are not where they were in the human trial"));
  EXPECT_THAT(SaidOf([](motion::MarkerRecording& r) {
                std::erase_if(r.markers,
                              [](const motion::MarkerTrack& marker) { return marker.name.starts_with("shank"); });
              }),
              HasSubstr("this trial has no 'shank1', 'shank2': mark and name them"));
}

TEST(RebuiltKnee, OfAMovementThatWasNotLearntIsNone) {
  const Drawn person = Draw(3);
  Excerpt bent = person.part;
  HideBetween(-180, 60, person, bent.recording);
  const gait::LearntKnee learnt = Learn(bent, kTwo, CalibratedView());
  Excerpt straight = Draw(4).part;
  for (motion::MarkerTrack& marker : straight.recording.markers) {
    // Standing between two rises.
    const std::vector<motion::MarkerSample> all = marker.samples;
    marker.samples.assign(all.begin() + 175, all.begin() + 220);
  }
  std::ranges::fill(SamplesOf(straight.recording, "knee"), motion::MarkerSample());
  straight.recording.frame.resize(45);
  straight.recording.time_s.resize(45);
  EXPECT_THAT(MessageOf([&] { Rebuild(straight, learnt, CalibratedView()); }),
              testing::HasSubstr("the knee was learnt in the human trial at flexions of 6"));
}

TEST(TechnicalMarkers, AreTwoOrMoreOnShankOrThigh) {
  const auto said = [](const char* text) -> std::string {
    gait::TechnicalMarkers technical;
    OptionList options;
    gait::Describe(technical, options);
    const std::string refusal = MessageOf<UsageError>([&] { options.All().front().SetFromCommandLine({text}); });
    return refusal.empty() ? options.All().front().Text() : refusal;
  };
  EXPECT_EQ(said("shank=a,b"), "shank=a,b");
  EXPECT_THAT(said("shank=a"),
              testing::HasSubstr("give two markers or more; one alone does not show how the shank turns"));
  EXPECT_THAT(said("shank=a,a"), testing::HasSubstr("give two markers or more"));
  EXPECT_THAT(said("foot=a,b"), testing::HasSubstr("shank and thigh"));
}

}  // namespace
}  // namespace lake
