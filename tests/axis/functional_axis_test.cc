#include "lake/axis/functional_axis.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lake/compare/uncertainty_budget.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/statistics.h"
#include "lake/exchange/formats.h"
#include "places.h"

namespace lake::axis {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// A hinge at (0, 0) of the shank, which stands, in a plane: the thigh turns to and fro about it, and its two markers
// share an error of `sigma` that is correlated over `memory` frames.
exchange::PointRecording Hinge(unsigned seed, double sigma, double memory) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  exchange::PointRecording points;
  points.space = exchange::PointSpace::kPlane;
  points.points = {{"s1", {}}, {"s2", {}}, {"t1", {}}, {"t2", {}}};
  const double keep = std::exp(-1 / memory);
  Vector3d error[4] = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  const Vector3d at[4] = {{-20, -300, 0}, {30, -100, 0}, {0, 300, 0}, {20, 100, 0}};
  for (int i = 0; i < 1000; ++i) {
    const Eigen::AngleAxisd turn(0.8 + 0.8 * std::sin(i * 0.04), Vector3d::UnitZ());
    for (int m = 0; m < 4; ++m) {
      for (int k = 0; k < 2; ++k)
        error[m][k] = keep * error[m][k] + std::sqrt(1 - keep * keep) * sigma * normal(random);
      points.points[static_cast<std::size_t>(m)].positions.push_back((m < 2 ? at[m] : turn * at[m]) + error[m]);
    }
    points.frame.push_back(i);
    points.time_s.push_back(0.01 * i);
  }
  return points;
}

const SegmentMarkers kMarkers{{"s1", "s2"}, {"t1", "t2"}};

TEST(FunctionalAxis, FindsAnExactHinge) {
  const SegmentMotion motion = MotionOf(Hinge(1, 0, 1), kMarkers);
  const MeanAxis axis = MeanAxes(motion, 0, 10).whole;
  EXPECT_LT(axis.in_file.norm(), 1e-6);
  EXPECT_LT(axis.pin_residual_mm, 1e-6);
  EXPECT_NEAR(axis.flexion_deg, 1.6 * 180 / M_PI, 0.1);
}

// Across the shank, where its turning counts in.
TEST(FunctionalAxis, APointFarFromTheMarkersIsAsPreciseAsTheyTell) {
  const SegmentMotion motion = MotionOf(Hinge(1, 1, 0.01), kMarkers);
  const Vector3d joint = motion.shank.poses[0].turn.transpose() * -motion.shank.poses[0].origin;
  std::vector<double> across_mm;
  for (const Pose& pose : motion.shank.poses) across_mm.push_back((pose.turn * joint + pose.origin).x());
  const double sd_mm = StandardDeviation(across_mm);
  EXPECT_GT(sd_mm, 1.5 * motion.shank.PointSdMm(0));
  EXPECT_NEAR(motion.shank.PointSdMm(joint.norm()) / sd_mm, 1, 0.1);
}

constexpr double kEllipse95 = 2.448;  // standard deviations in two dimensions

// Residuals correlated over 15 frames and nothing else, two markers a segment: of 60 draws 54 or more hold the axis.
TEST(FunctionalAxis, ItsIntervalHoldsTheAxis) {
  constexpr unsigned kSeeds = 60;
  int held = 0;
  std::vector<double> off_mm, sd_mm;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const MeanAxis axis = MeanAxes(MotionOf(Hinge(seed, 1, 15), kMarkers), 0, 10).whole;
    held += axis.in_file.norm() < kEllipse95 * axis.sd_mm;
    off_mm.push_back(axis.in_file.norm()), sd_mm.push_back(axis.sd_mm);
  }
  EXPECT_GE(held, 54);
  EXPECT_GT(RootMeanSquare(off_mm), 0.15 * std::sqrt(2) * RootMeanSquare(sd_mm));
}

TEST(FunctionalAxis, RefusesMarkersItCannotUse) {
  EXPECT_THROW(MotionOf(Hinge(1, 0, 1), {{"s1"}, {"t1", "t2"}}), UsageError);
  EXPECT_THAT(
      [] {
        MotionOf(Hinge(1, 0, 1), {{"s1", "none"}, {"t1", "t2"}});
      },
      testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("'none'"), HasSubstr("s1, s2, t1, t2"))));
  EXPECT_THROW(MotionOf(Hinge(1, 0, 1), {{"s1", "t1"}, {"t1", "t2"}}), UsageError);
}

// Markers of the leg that lake itself names are on the segment that they are named for.
TEST(FunctionalAxis, RefusesMarkersOfAnotherSegment) {
  exchange::PointRecording points = Hinge(1, 0, 1);
  for (const char* name : {"ankle", "knee", "hip", "waist"}) {
    points.points.push_back(points.points[points.points.size() == 4 || points.points.size() == 5 ? 0 : 2]);
    points.points.back().name = name;
  }
  const auto refused = [&](const SegmentMarkers& markers, const char* text) {
    EXPECT_THAT([&] { MotionOf(points, markers); }, testing::ThrowsMessage<UsageError>(HasSubstr(text)));
  };
  refused({{"ankle", "knee"}, {"hip", "waist"}}, "--segment thigh: the marker 'waist' is on the trunk");
  refused({{"ankle", "hip"}, {"t1", "t2"}}, "--segment shank: the marker 'hip' is on the thigh");
  EXPECT_NO_THROW(MotionOf(points, {{"ankle", "s2"}, {"hip", "t2"}}));
}

TEST(FunctionalAxis, RefusesAnAxisThatIsFartherThanASegmentIsLong) {
  exchange::PointRecording points = Hinge(1, 0.1, 1);
  for (std::size_t m : {0, 1})
    for (Vector3d& position : points.points[m].positions) position.y() -= 1200;
  EXPECT_THAT([&] { MeanAxes(MotionOf(points, kMarkers), 0, 10); },
              testing::ThrowsMessage<Error>(
                  testing::AllOf(HasSubstr("from the markers of the shank"), HasSubstr("a knee is within 1000 mm"))));
}

TEST(FunctionalAxis, TellsTheWindowsThatTurnTooLittle) {
  exchange::PointRecording points = Hinge(1, 0.1, 1);
  for (exchange::PointTrack& point : points.points)  // the second window stands still
    for (std::size_t i = 300; i < 600; ++i) point.positions[i] = point.positions[299];
  const MeanAxesResult result = MeanAxes(MotionOf(points, kMarkers), 300, 10);
  ASSERT_EQ(result.windows.size(), 2);
  EXPECT_EQ(result.windows[0].window, 1);
  EXPECT_EQ(result.windows[1].window, 3);
  EXPECT_THAT(result.warnings, testing::ElementsAre(HasSubstr("window 2 is left out")));
}

// A hinge at (0, 0, 0) of the shank, along z, which a person's skin hides: `count` markers on each segment, whose
// errors are functions of the angle (smooth: the k-th harmonic has an amplitude of skin / k) and a slow process beside
// them. Five movements of `range_deg`, no two alike, at 100 Hz.
exchange::PointRecording HingeUnderSkin(unsigned seed, double skin_mm, double range_deg, std::size_t count,
                                        exchange::PointSpace space) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const int dimensions = space == exchange::PointSpace::kPlane ? 2 : 3;
  constexpr int kHarmonics = 3;
  struct Marker {
    Vector3d at = Vector3d::Zero(), slow = Vector3d::Zero();
    std::array<Vector3d, 2 * kHarmonics> harmonics;
  };
  const auto draw = [&](double sd_mm) {
    Vector3d v = Vector3d::Zero();
    for (int k = 0; k < dimensions; ++k) v[k] = sd_mm * normal(random);
    return v;
  };
  std::vector<Marker> markers(2 * count);
  exchange::PointRecording points;
  points.space = space;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const bool is_shank = m < count;
    markers[m].at =
        draw(30) + Vector3d(0, (is_shank ? -1 : 1) * (100 + 250 * static_cast<double>(m % count) / (count - 1.0)), 0);
    for (std::size_t k = 0; k < markers[m].harmonics.size(); ++k)
      markers[m].harmonics[k] = draw(skin_mm / static_cast<double>(1 + k / 2) / std::sqrt(2));
    points.points.push_back({(is_shank ? "s" : "t") + std::to_string(m % count), {}});
  }
  std::uniform_real_distribution<double> share(0.8, 1);
  const double keep = std::exp(-1 / 30.0);
  double tops[5];
  for (double& top : tops) top = range_deg * M_PI / 180 * share(random);
  for (int i = 0; i < 1000; ++i) {
    const double angle = tops[i / 200] * 0.5 * (1 - std::cos(2 * M_PI * i / 200));
    const Eigen::AngleAxisd turn(angle, Vector3d::UnitZ());
    for (std::size_t m = 0; m < markers.size(); ++m) {
      Marker& marker = markers[m];
      marker.slow = keep * marker.slow + std::sqrt(1 - keep * keep) * draw(0.3 * skin_mm);
      Vector3d place = marker.at + marker.slow + draw(0.05);
      for (std::size_t k = 0; k < marker.harmonics.size(); ++k)
        place += marker.harmonics[k] * (k % 2 ? std::sin(static_cast<double>(k / 2 + 1) * angle)
                                              : std::cos(static_cast<double>(k / 2 + 1) * angle) - 1);
      points.points[m].positions.push_back(m < count ? place : Vector3d(turn * place));
    }
    points.frame.push_back(i);
    points.time_s.push_back(0.01 * i);
  }
  return points;
}

SegmentMarkers AllMarkers(std::size_t count) {
  SegmentMarkers markers;
  for (std::size_t m = 0; m < count; ++m) {
    markers.shank.push_back("s" + std::to_string(m));
    markers.thigh.push_back("t" + std::to_string(m));
  }
  return markers;
}

struct Held {
  double whole = 0, windows = 0, centres = 0;  // of so many
  double recordings = 0, all_windows = 0, all_centres = 0;
  // Sums of squares: how far off, and what the standard deviations say of that.
  double whole_off = 0, whole_said = 0, windows_off = 0, windows_said = 0, centres_off = 0, centres_said = 0;

  void Add(const exchange::PointRecording& points, const SegmentMarkers& markers) {
    const SegmentMotion motion = MotionOf(points, markers);
    const MeanAxesResult axes = MeanAxes(motion, 200, 10);
    const auto distance = [](const Vector3d& place) { return place.head<2>().norm(); };
    const auto add = [](double off_mm, double sd_mm, double& off, double& said) {
      off += off_mm * off_mm, said += 2 * sd_mm * sd_mm;
    };
    add(distance(axes.whole.in_file), axes.whole.sd_mm, whole_off, whole_said);
    for (const MeanAxis& axis : axes.windows) add(distance(axis.in_file), axis.sd_mm, windows_off, windows_said);
    for (const InstantaneousCentre& c : InstantaneousCentres(motion, axes))
      add(distance(c.in_file), c.sd_mm.norm() / std::sqrt(2), centres_off, centres_said);
    whole += distance(axes.whole.in_file) < kEllipse95 * axes.whole.sd_mm, ++recordings;
    for (const MeanAxis& axis : axes.windows)
      windows += distance(axis.in_file) < kEllipse95 * axis.sd_mm, ++all_windows;
    for (const InstantaneousCentre& c : InstantaneousCentres(motion, axes))
      centres += distance(c.in_file) < kEllipse95 * c.sd_mm.norm() / std::sqrt(2), ++all_centres;
  }
};

// Skin that moves by 3 mm, in part slowly, in part as the angle says, first harmonic included, which looks as a hinge
// elsewhere does. Of 95 % ellipses at least 90 % must hold the hinge, over movements of 60 to 120 degrees.
// Nor are they idle: the errors are at least 0.7 of what the standard deviations say; with two markers a segment, whose
// deformation has one coordinate each, at least 0.3.
TEST(FunctionalAxis, ItsIntervalsHoldAHingeUnderSkin) {
  for (const std::size_t count : {2u, 4u, 5u}) {
    Held held;
    for (unsigned seed = 300; seed < 340; ++seed)
      for (const double range_deg : {60.0, 95.0, 120.0})
        held.Add(HingeUnderSkin(seed, 3, range_deg, count,
                                count == 5 ? exchange::PointSpace::kSpace : exchange::PointSpace::kPlane),
                 AllMarkers(count));
    const std::string name = std::to_string(count) + "_markers_";
    const auto check = [&](const char* what, double share, double off, double said) {
      EXPECT_GE(share, 0.9) << name << what;
      EXPECT_GT(std::sqrt(off / said), count == 2 ? 0.3 : 0.7) << name << what;
      RecordProperty(name + what, std::to_string(share) + ", errors " + std::to_string(std::sqrt(off / said)));
    };
    check("whole", held.whole / held.recordings, held.whole_off, held.whole_said);
    check("windows", held.windows / held.all_windows, held.windows_off, held.windows_said);
    check("centres", held.centres / held.all_centres, held.centres_off, held.centres_said);
  }
}

// Without skin the intervals are narrow: they are of what is found in the recording.
TEST(FunctionalAxis, ItsIntervalsAreAsNarrowAsTheMarkersAllow) {
  const SegmentMotion motion = MotionOf(HingeUnderSkin(3, 0.01, 95, 4, exchange::PointSpace::kPlane), AllMarkers(4));
  const MeanAxesResult axes = MeanAxes(motion, 200, 10);
  EXPECT_LT(axes.whole.sd_mm, 0.2);
  for (const InstantaneousCentre& c : InstantaneousCentres(motion, axes)) EXPECT_LT(c.sd_mm.norm(), 0.6);
}

// The pin over a range of angles is the one of its frames.
TEST(FunctionalAxis, PinOverARange) {
  const SegmentMotion motion = MotionOf(HingeUnderSkin(4, 1, 95, 3, exchange::PointSpace::kPlane), AllMarkers(3));
  const MeanAxesResult axes = MeanAxes(motion, 0, 10);
  const std::vector<double> angles = KneeAngles(motion, axes.whole);
  const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
  const MeanAxis all = PinOver(motion, axes, *least, *most);
  EXPECT_NEAR((all.in_shank - axes.whole.in_shank).norm(), 0, 1e-9);
  const MeanAxis half = PinOver(motion, axes, *least, (*least + *most) / 2);
  EXPECT_LT(half.flexion_deg, 0.51 * all.flexion_deg + 1);
  EXPECT_GT(half.sd_mm, all.sd_mm);
  EXPECT_LT((half.in_shank - all.in_shank).norm(), 3 * half.sd_mm);
  EXPECT_THAT([&] { PinOver(motion, axes, *most + 10, *most + 20); },
              testing::ThrowsMessage<Error>(HasSubstr("the recording goes from")));
}

// Five rises in the laboratory, both legs, against the knee's centre of a skeletal model that was fitted to the same
// markers (OpenSim: the tibia's origin). The model's files stand somewhere else than the markers', by a shift that
// nobody wrote down: it is taken from the means, so that what is compared is how the centre moves. Of the 95 % ellipses
// with 7 mm of soft tissue 90 % must hold the model's centre, and the centre strays from it by half of what the knee's
// own marker does.
TEST(FunctionalAxis, KeepsToASkeletalModelsKneeWhereSkinStrays) {
  const std::filesystem::path folder = SharedData() / "opencap_sts";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const exchange::PointRecording points = exchange::ReadPoints(folder / "sts_default_markers.trc");
  const Json bodies = ReadJsonFile(folder / "sts_default_opensim_bodies.json").at("bodies");
  const SegmentMarkers right{{"r_shank_antsup", "r_sh2", "r_sh3", "r_sh4", "r_ankle"},
                             {"r_thigh1", "r_thigh2", "r_thigh3", "r_thigh4", "r_thigh5"}},
      left{{"L_shank_antsup", "L_sh2", "L_sh3", "L_ankle"}, {"L_thigh1", "L_thigh2", "L_thigh3", "L_thigh4"}};
  for (const auto& [markers, knee, tibia] :
       {std::tuple(right, "r_knee", "tibia_r"), std::tuple(left, "L_knee", "tibia_l")}) {
    const SegmentMotion motion = MotionOf(points, markers);
    const MeanAxesResult axes = MeanAxes(motion, 0, 10);
    const Json& places = bodies.at(tibia).at("translation");
    // From the side: x forward, y up.
    std::vector<Eigen::Vector2d> centre_off, marker_off;
    std::vector<double> radius_mm;
    for (const InstantaneousCentre& c : InstantaneousCentres(motion, axes)) {
      const Json& place = places.at(c.frame);
      const Eigen::Vector2d model = 1000 * Eigen::Vector2d(place.at(0).get<double>(), place.at(1).get<double>());
      centre_off.push_back(c.in_file.head<2>() - model);
      marker_off.push_back(points.Find(knee)->positions[c.frame].head<2>() - model);
      constexpr double kSoftTissue_mm = 7;
      radius_mm.push_back(kEllipse95 * std::hypot(c.sd_mm.norm() / std::sqrt(2), kSoftTissue_mm));
    }
    const auto strays = [](const std::vector<Eigen::Vector2d>& off) {
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      for (const Eigen::Vector2d& one : off) mean += one / static_cast<double>(off.size());
      std::vector<double> lengths;
      for (const Eigen::Vector2d& one : off) lengths.push_back((one - mean).norm());
      return lengths;
    };
    const std::vector<double> centre = strays(centre_off), marker = strays(marker_off);
    double held = 0;
    for (std::size_t i = 0; i < centre.size(); ++i) held += centre[i] < radius_mm[i];
    EXPECT_GE(held, 0.9 * static_cast<double>(centre.size())) << knee;
    EXPECT_LT(RootMeanSquare(centre), 0.5 * RootMeanSquare(marker)) << knee;
    RecordProperty(knee, std::to_string(RootMeanSquare(centre)) + " of " + std::to_string(RootMeanSquare(marker)));
  }
}

struct RealLeg {
  const char* file;
  SegmentMarkers segments;
  const char* knee;
};

// Where a leg's model has its knee in a frame: the pin that both segments carry, each rigid on the mean shape of its
// markers, half way between the two.
Vector3d ModelKnee(const SegmentMotion& motion, const MeanAxis& pin, std::size_t frame) {
  const Pose &shank = motion.shank.poses[frame], &thigh = motion.thigh.poses[frame];
  return (shank.turn * pin.in_shank + shank.origin + thigh.turn * pin.in_thigh + thigh.origin) / 2;
}

// How often the ellipse of `sd_mm` holds the knee's marker about the model's knee: across its axis, in the shank's
// frame and about the mean, as where the marker was put, and where a cluster on skin has its knee, is constant.
double SharesHeld(const RealLeg& leg, double sd_mm) {
  const exchange::PointRecording points = exchange::ReadPoints(SharedData() / leg.file);
  const SegmentMotion motion = MotionOf(points, leg.segments);
  const MeanAxis pin = MeanAxes(motion, 0, 10).whole;
  const std::vector<Vector3d>& marker = points.Find(leg.knee)->positions;
  std::vector<Vector3d> off_mm;
  for (std::size_t i = 0; i < marker.size(); ++i) {
    const Pose& shank = motion.shank.poses[i];
    if (!shank.IsSeen() || !motion.thigh.poses[i].IsSeen() || !marker[i].allFinite()) continue;
    const Vector3d off = shank.turn.transpose() * (marker[i] - ModelKnee(motion, pin, i));
    off_mm.push_back(off - off.dot(pin.direction_shank) * pin.direction_shank);
  }
  const double frames = static_cast<double>(off_mm.size());
  EXPECT_GT(frames, 100) << leg.file;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& off : off_mm) mean += off / frames;
  const auto held =
      std::ranges::count_if(off_mm, [&](const Vector3d& off) { return (off - mean).norm() < kEllipse95 * sd_mm; });
  return static_cast<double>(held) / frames;
}

const SegmentMarkers kRight{{"r_ankle", "r_shank_antsup", "r_sh2", "r_sh3", "r_sh4"},
                            {"r_thigh1", "r_thigh2", "r_thigh3", "r_thigh4", "r_thigh5"}},
    kLeft{{"L_ankle", "L_shank_antsup", "L_sh2", "L_sh3"}, {"L_thigh1", "L_thigh2", "L_thigh3", "L_thigh4"}},
    kRightTabs{{"RANK", "RTIB", "RTIB2", "RTIB3"}, {"RTHI", "RTHI2", "RTHI3"}},
    kLeftTabs{{"LANK", "LTIB", "LTIB2", "LTIB3"}, {"LTHI", "LTHI2", "LTHI3"}};

// Of subject4_walking1 the left leg alone: nine frames show the right one's clusters.
const RealLeg kLegs[] = {
    {"real_motions/subject4_squats1.trc", kRight, "r_knee"}, {"real_motions/subject4_squats1.trc", kLeft, "L_knee"},
    {"real_motions/subject4_walking1.trc", kLeft, "L_knee"}, {"real_motions/subject4_DJ1.trc", kRight, "r_knee"},
    {"real_motions/subject4_DJ1.trc", kLeft, "L_knee"},      {"real_motions/tabs_squat2.trc", kRightTabs, "RKNE"},
    {"real_motions/tabs_squat2.trc", kLeftTabs, "LKNE"},     {"real_motions/tabs_stairs3.trc", kRightTabs, "RKNE"},
    {"real_motions/tabs_stairs3.trc", kLeftTabs, "LKNE"},    {"sts_force_plates/STS1.trc", kRight, "r_knee"},
    {"sts_force_plates/STS1.trc", kLeft, "L_knee"},          {"opencap_sts/sts_default_markers.trc", kRight, "r_knee"},
    {"opencap_sts/sts_default_markers.trc", kLeft, "L_knee"}};

// Two rigid segments and a pin are fitted to all markers of shank and thigh but the knee's own: a skeletal solution of
// trials that have none. The band of a single frame holds 90 % of the frames in nine legs of ten and of all, which that
// of the rise's mean does not.
TEST(FunctionalAxis, SingleFramesOfTheKneesMarkerAreInItsBand) {
  const std::filesystem::path folder = SharedData() / "real_motions";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const compare::ComparisonBudgetOptions budget;
  double legs = 0, all_held = 0, legs_held = 0, legs_held_by_mean = 0;
  for (const RealLeg& leg : kLegs) {
    const double held = SharesHeld(leg, budget.FrameTissueMm());
    RecordProperty(std::filesystem::path(leg.file).stem().string() + "_" + leg.knee, std::to_string(held));
    legs_held += held >= 0.9;
    legs_held_by_mean += SharesHeld(leg, budget.soft_tissue_mm) >= 0.9;
    all_held += held;
    ++legs;
  }
  EXPECT_GE(legs_held, 0.9 * legs);
  EXPECT_GE(all_held, 0.9 * legs);
  EXPECT_LT(legs_held_by_mean, 0.5 * legs);
}

double FromHinge(const exchange::PointRecording& points, const SegmentMotion& motion, const Vector3d& in_shank,
                 std::size_t frame) {
  const Vector3d a = points.Find("ax1")->positions[frame], b = points.Find("ax2")->positions[frame];
  const Pose& shank = motion.shank.poses[frame];
  return (b - a).normalized().cross(shank.turn * in_shank + shank.origin - a).norm();
}

double FromHinge(const exchange::PointRecording& points, const MeanAxis& axis) {
  Vector3d a = Vector3d::Zero(), b = a;
  for (std::size_t i = axis.first; i <= axis.last; ++i)
    a += points.Find("ax1")->positions[i], b += points.Find("ax2")->positions[i];
  return (b - a).normalized().cross(axis.in_file - a / static_cast<double>(axis.last - axis.first + 1)).norm();
}

// Its recording was smoothed in time, which shortens the lower body by up to 2 % as it swings, so that a pin leaves 1.4
// to 1.7 mm. Where its axis' markers sit beside the axis is not known; their scatter is 0.12 mm. The limits are those
// that plain least squares meets, whichever markers are taken: 0.60 mm over the whole recording, 1.49 mm over windows.
class MeasuredHinge : public testing::TestWithParam<SegmentMarkers> {
 protected:
  void SetUp() override {
    const std::filesystem::path file = SharedData() / "hinge_axis/hinge_a.trc";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
    points_ = exchange::ReadPoints(file);
    motion_ = MotionOf(points_, GetParam());
  }

  exchange::PointRecording points_;
  SegmentMotion motion_;
};

TEST_P(MeasuredHinge, IsFound) {
  const MeanAxesResult axes = MeanAxes(motion_, 300, 10), long_windows = MeanAxes(motion_, 500, 10);
  EXPECT_LT(FromHinge(points_, axes.whole), 0.65);
  EXPECT_LT(FromHinge(points_, axes.whole), kEllipse95 * axes.whole.sd_mm);
  EXPECT_LT(axes.whole.pin_residual_mm, 1.8);
  ASSERT_EQ(axes.windows.size(), 6);
  ASSERT_EQ(long_windows.windows.size(), 4);
  for (const MeanAxesResult& result : {axes, long_windows})
    for (const MeanAxis& axis : result.windows) {
      EXPECT_LT(FromHinge(points_, axis), 1.55) << axis.first;
      EXPECT_LT(FromHinge(points_, axis), kEllipse95 * axis.sd_mm) << axis.first;
    }
  std::vector<double> centre_off_mm;
  double held = 0;
  for (const InstantaneousCentre& c : InstantaneousCentres(motion_, axes)) {
    centre_off_mm.push_back(FromHinge(points_, motion_, c.in_shank, c.frame));
    held += centre_off_mm.back() < kEllipse95 * c.sd_mm.norm() / std::sqrt(2);
  }
  EXPECT_LT(Median(centre_off_mm), 0.7);
  EXPECT_GT(held, 0.9 * static_cast<double>(centre_off_mm.size()));
}

// By frames of 18 degrees of flexion the axis is off by up to 5 mm in the ranges that most frames show: 85 % of the 95
// % ellipses hold it.
TEST_P(MeasuredHinge, IsInTheEllipseOfFewDegrees) {
  const MeanAxesResult axes = MeanAxes(motion_, 0, 10);
  const std::vector<double> angles = KneeAngles(motion_, axes.whole);
  const double most_deg = *std::ranges::max_element(angles);
  double held = 0, ranges = 0;
  for (double from_deg = *std::ranges::min_element(angles); from_deg + 18 <= most_deg; from_deg += 6) {
    const MeanAxis pin = PinOver(motion_, axes, from_deg, from_deg + 18);
    std::vector<double> off_mm;
    for (std::size_t i = 0; i < angles.size(); ++i)
      if (angles[i] >= from_deg && angles[i] <= from_deg + 18)
        off_mm.push_back(FromHinge(points_, motion_, pin.in_shank, i));
    held += Mean(off_mm) < kEllipse95 * pin.sd_mm;
    ++ranges;
  }
  EXPECT_GE(held, 0.85 * ranges);
  RecordProperty("held", fmt::format("{} of {}", held, ranges));
}

INSTANTIATE_TEST_SUITE_P(
    FunctionalAxis, MeasuredHinge,
    testing::Values(SegmentMarkers{{"dw1", "dw2", "dw3", "dw4", "dw5", "cld1", "cld2", "cld3"},
                                   {"up1", "up2", "up3", "up4", "up5", "clu1", "clu2", "clu3"}},
                    SegmentMarkers{{"dw1", "dw2", "dw3", "dw4", "dw5"}, {"up1", "up2", "up3", "up4", "up5"}},
                    SegmentMarkers{{"cld1", "cld2", "cld3"}, {"clu1", "clu2", "clu3"}}),
    [](const auto& markers) { return std::to_string(markers.param.shank.size()) + "MarkersEach"; });

}  // namespace
}  // namespace lake::axis
