// The axis under skin that moves alike at each pass of an angle, against the plain symmetrical estimate.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "lake/axis/functional_axis.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::axis {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr unsigned kDraws = 20;
constexpr double kHalfOf95 = 2.4477;  // standard deviations of a plane

struct Skin {
  double range_deg;
  double repeated_mm;  // root mean square along each axis: three harmonics of the angle
  double slow_mm = 0;  // correlated over 0.3 s
  double noise_mm = 0.05;
  double across_mm = 30;    // how far the markers are off the segment's line
  std::size_t markers = 4;  // on each segment
  bool in_steps = false;    // each marker steps about an angle of its own instead, as over a muscle's belly
};

// A marker's place against the segment, mm, at a part of the range of flexion.
using Movement = std::function<Vector3d(double part)>;

Movement Harmonics(const std::function<Vector3d(double sd)>& draw, double sd_mm) {
  std::array<Vector3d, 6> harmonics;
  for (Vector3d& harmonic : harmonics) harmonic = draw(sd_mm / std::sqrt(3));
  return [harmonics](double part) {
    Vector3d place = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      place +=
          std::sin((k + 1) * M_PI * part) * harmonics[2 * k] + std::cos((k + 1) * M_PI * part) * harmonics[2 * k + 1];
    return place;
  };
}

Movement Step(const std::function<Vector3d(double sd)>& draw, double sd_mm, std::mt19937& random) {
  const Vector3d size = draw(sd_mm);
  const double middle = std::uniform_real_distribution(0.2, 0.8)(random);
  const double width = std::uniform_real_distribution(0.1, 0.3)(random);
  return [=](double part) -> Vector3d { return std::tanh((part - middle) / width) * size; };
}

// The shank stands with the hinge at (0, 0); the thigh turns five times to and fro. The shank's markers come first.
exchange::PointRecording Record(const Skin& skin, unsigned seed, exchange::PointSpace space) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sd) {
    const double x = normal(random), y = normal(random);
    return Vector3d(sd * x, sd * y, 0);
  };
  const double range_rad = skin.range_deg * M_PI / 180;
  exchange::PointRecording points;
  points.space = space;
  for (int i = 0; i < 500; ++i) {
    points.frame.push_back(i);
    points.time_s.push_back(0.02 * i);
  }
  for (std::size_t m = 0; m < 2 * skin.markers; ++m) {
    const bool is_thigh = m >= skin.markers;
    const double along = 100 + 250 * static_cast<double>(m % skin.markers) / static_cast<double>(skin.markers - 1);
    const Vector3d at = draw(skin.across_mm) + Vector3d(0, is_thigh ? along : -along, 0);
    const Movement repeated = skin.in_steps ? Step(draw, skin.repeated_mm, random) : Harmonics(draw, skin.repeated_mm);
    Vector3d slow = draw(skin.slow_mm);
    const double keep = std::exp(-1 / 15.0);
    exchange::PointTrack track{(is_thigh ? "t" : "s") + std::to_string(m % skin.markers), {}};
    for (int i = 0; i < 500; ++i) {
      const double part = 0.5 * (1 - std::cos(2 * M_PI * i / 100.0));
      slow = keep * slow + std::sqrt(1 - keep * keep) * draw(skin.slow_mm);
      const Vector3d place = at + repeated(part) + slow + draw(skin.noise_mm);
      track.positions.push_back(is_thigh ? Vector3d(Eigen::AngleAxisd(range_rad * part, Vector3d::UnitZ()) * place)
                                         : place);
    }
    points.points.push_back(track);
  }
  return points;
}

SegmentMarkers AllMarkers(const Skin& skin) {
  SegmentMarkers markers;
  for (std::size_t m = 0; m < skin.markers; ++m) {
    markers.shank.push_back("s" + std::to_string(m));
    markers.thigh.push_back("t" + std::to_string(m));
  }
  return markers;
}

// A segment's pose by its markers of the first frame, in the plane.
Eigen::Isometry2d PoseOf(const exchange::PointRecording& points, std::size_t first, std::size_t frame) {
  const std::size_t markers = points.points.size() / 2;
  Eigen::Matrix2Xd from(2, markers), to(2, markers);
  for (std::size_t m = 0; m < markers; ++m) {
    const auto& positions = points.points[first + m].positions;
    from.col(static_cast<Eigen::Index>(m)) = positions.front().head<2>();
    to.col(static_cast<Eigen::Index>(m)) = positions[frame].head<2>();
  }
  return Eigen::Isometry2d(Eigen::umeyama(from, to, false));
}

// The mean over the frames of where two points, constant in shank and thigh, are that are nearest to each other in all
// frames (Ehrig et al. 2007): shank · s = thigh · t by plain least squares.
Vector2d SymmetricalEstimate(const exchange::PointRecording& points) {
  const std::size_t frames = points.frame.size(), thigh_first = points.points.size() / 2;
  Eigen::MatrixXd a(2 * frames, 4);
  Eigen::VectorXd b(2 * frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const Eigen::Isometry2d shank = PoseOf(points, 0, i), thigh = PoseOf(points, thigh_first, i);
    const auto row = static_cast<Eigen::Index>(2 * i);
    a.block<2, 2>(row, 0) = shank.linear();
    a.block<2, 2>(row, 2) = -thigh.linear();
    b.segment<2>(row) = thigh.translation() - shank.translation();
  }
  const Eigen::Vector4d found = a.colPivHouseholderQr().solve(b);
  Vector2d mean = Vector2d::Zero();
  for (std::size_t i = 0; i < frames; ++i)
    mean += (PoseOf(points, 0, i) * Vector2d(found.head<2>()) +
             PoseOf(points, thigh_first, i) * Vector2d(found.tail<2>())) /
            (2.0 * static_cast<double>(frames));
  return mean;
}

struct Errors {
  double off_mm = 0, plain_off_mm = 0;  // root mean square distances from the hinge
  double said_mm = 0;                   // what the standard deviations say of the first
  double held = 0;                      // share of 95 % ellipses
};

Errors ErrorsUnder(const Skin& skin, unsigned draws = kDraws) {
  std::vector<double> off, plain, said;
  Errors errors;
  for (unsigned seed = 1; seed <= draws; ++seed) {
    const exchange::PointRecording points = Record(skin, seed, exchange::PointSpace::kPlane);
    const MeanAxis axis = MeanAxes(MotionOf(points, AllMarkers(skin)), 0, 10).whole;
    off.push_back(axis.in_file.head<2>().norm());
    said.push_back(M_SQRT2 * axis.sd_mm);
    plain.push_back(SymmetricalEstimate(points).norm());
    errors.held += (off.back() < kHalfOf95 * axis.sd_mm) / static_cast<double>(draws);
  }
  errors.off_mm = RootMeanSquare(off);
  errors.plain_off_mm = RootMeanSquare(plain);
  errors.said_mm = RootMeanSquare(said);
  return errors;
}

// Where skin repeats with the angle, the axis is no farther off than the plain estimate, and its ellipse holds the
// hinge.
TEST(PlainEstimate, SkinThatRepeatsWithTheAngleDoesNotDrawTheAxisFartherThanIt) {
  for (const Skin& skin : {Skin{30, 1}, Skin{40, 3, 2}, Skin{90, 3, 2}}) {
    const Errors errors = ErrorsUnder(skin);
    EXPECT_LE(errors.off_mm, 1.1 * errors.plain_off_mm) << skin.range_deg;
    EXPECT_GE(errors.held, 0.85) << skin.range_deg;
  }
}

// Soft tissue of two kinds, few degrees and few markers: 95 % ellipses hold the hinge in 85 % of draws at least.
TEST(PlainEstimate, SkinOfAnyKindLeavesTheHingeInItsEllipse) {
  for (const bool in_steps : {false, true})
    for (const double range_deg : {15.0, 25.0, 60.0, 110.0})
      for (const std::size_t markers : {2u, 3u, 4u}) {
        const Skin skin{.range_deg = range_deg, .repeated_mm = 1, .markers = markers, .in_steps = in_steps};
        const Errors errors = ErrorsUnder(skin, 100);
        const std::string name =
            fmt::format("{}_{}_degrees_{}_markers", in_steps ? "steps" : "harmonics", range_deg, markers);
        EXPECT_GE(errors.held, 0.85) << name;
        RecordProperty(name,
                       fmt::format("{:.2f}, {:.1f} mm off, {:.1f} said", errors.held, errors.off_mm, errors.said_mm));
      }
}

// White noise alone: the standard deviation is within half and twice of the errors.
TEST(PlainEstimate, UnderWhiteNoiseTheStandardDeviationIsThatOfTheErrors) {
  for (const double range_deg : {30.0, 90.0}) {
    const Errors errors = ErrorsUnder({range_deg, 0, 0, 1});
    EXPECT_LE(errors.off_mm, 1.1 * errors.plain_off_mm);
    EXPECT_LE(errors.said_mm, 2 * errors.off_mm);
    EXPECT_GE(errors.said_mm, 0.5 * errors.off_mm);
    EXPECT_GE(errors.held, 0.85);
    RecordProperty(fmt::format("{}_degrees", range_deg),
                   fmt::format("{:.2f}, {:.2f} mm off, {:.2f} said", errors.held, errors.off_mm, errors.said_mm));
  }
}

// Markers near the segments' lines, all in one plane of a file of three dimensions: skin makes the mirror image of a
// pose fit better in some frames, so that the segments turned by up to 360 degrees about an axis in the plane. Right is
// the axis across the plane, or an error that says that the markers lie in one plane.
TEST(PlainEstimate, MarkersOfAPlaneInSpaceTurnAboutTheAxisAcrossIt) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Skin skin{.range_deg = 60, .repeated_mm = 3, .across_mm = 5};
    const exchange::PointRecording points = Record(skin, seed, exchange::PointSpace::kSpace);
    try {
      const MeanAxis axis = MeanAxes(MotionOf(points, AllMarkers(skin)), 0, 10).whole;
      EXPECT_GT(std::abs(axis.direction_file.z()), 0.99) << seed;
      EXPECT_NEAR(axis.flexion_deg, 60, 15) << seed;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("plane"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lake::axis
