// The closed form against the loops, against Newton's method, and against statics, on random linkages.
#include "lake/linkage/linkage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/linkage/loop_equations.h"
#include "linkage/independent_routes.h"
#include "linkage/random_links.h"
#include "places.h"
#include "published_links.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
constexpr int kDesigns = 2000;

// Sine of the sharpest of the two angles that decide how well conditioned a pose is.
double Conditioning(const linkage::Links& links, const linkage::Pose& pose) {
  const linkage::Transmission t = linkage::TransmissionOf(links, pose);
  return std::min(std::sin(t.actuator_rad), std::sin(t.transmission_rad));
}

// Lengths of some 100 mm in double precision: 1e-9 mm is a thousand times rounding.
void ExpectLoopsClose(const linkage::Links& links, const linkage::Pose& pose) {
  EXPECT_NEAR((pose.tip - pose.mount).norm(), pose.stroke_mm, 1e-9);
  EXPECT_NEAR((pose.shank_pin - pose.tip).norm(), links.l1, 1e-9);
  EXPECT_NEAR((pose.tip - pose.thigh_pin).norm(), links.l2, 1e-9);
  EXPECT_NEAR(pose.tip.norm(), pose.l8_mm, 1e-9);
}

TEST(ClosedForm, ClosesTheLoopsOnAllBranches) {
  testing::RandomLinks random;
  for (int i = 0; i < kDesigns; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    const double stroke = random.StrokeFor(links);
    for (const linkage::Branch branch : {linkage::Branch::kAssembled, linkage::Branch::kBarFlipped,
                                         linkage::Branch::kShankFlipped, linkage::Branch::kBothFlipped}) {
      const auto pose = linkage::SolvePose(links, stroke, branch);
      // Flipping the bar moves R, so the other triangle need not close there.
      if (!pose && (branch == linkage::Branch::kBarFlipped || branch == linkage::Branch::kBothFlipped)) continue;
      ASSERT_TRUE(pose);
      ExpectLoopsClose(links, *pose);
      const auto signs = linkage::BranchExpressions(links.Values().data(), pose->phi_rad, pose->theta_rad);
      const bool bar_flipped = branch == linkage::Branch::kBarFlipped || branch == linkage::Branch::kBothFlipped;
      const bool shank_flipped = branch == linkage::Branch::kShankFlipped || branch == linkage::Branch::kBothFlipped;
      EXPECT_GE((bar_flipped ? -1 : 1) * signs[0], -1e-9);
      EXPECT_GE((shank_flipped ? -1 : 1) * signs[1], -1e-9);
    }
  }
}

TEST(ClosedForm, AgreesWithNewtonOnRandomLinkages) {
  testing::RandomLinks random;
  int compared = 0;
  for (int i = 0; i < kDesigns; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    const double stroke = random.StrokeFor(links);
    const linkage::Pose pose = linkage::RequirePose(links, stroke);
    const double conditioning = Conditioning(links, pose);
    if (conditioning < 1e-3) continue;  // there angles lose digits as 1 / sine in any method
    // A start off by a twentieth of the way to the next branch, which is nearer for a long bar on a short coupler.
    const double aside = 0.05 * conditioning * std::min({1.0, links.l1 / links.l2, links.l4 / links.l2});
    const double phi = pose.phi_rad + random.Uniform(-aside, aside),
                 theta = pose.theta_rad + random.Uniform(-aside, aside);
    const NewtonPose newton = SolvePoseNewton(links, stroke, phi, theta);
    ASSERT_TRUE(newton.converged);
    EXPECT_NEAR(newton.phi_rad, pose.phi_rad, 1e-9);
    EXPECT_NEAR(newton.theta_rad, pose.theta_rad, 1e-9);
    ++compared;
  }
  EXPECT_GT(compared, kDesigns * 9 / 10);
}

// Continuation: each solution starts the next, from deep hyperextension back through the fold of the arccos form to
// d_min, two thousandths of a millimetre before the dead point.
TEST(ClosedForm, AgreesWithNewtonContinuationAlongThePublishedDesign) {
  constexpr double kLongest_mm = 378, kShortest_mm = 242;
  constexpr int kSteps = 2720;
  const linkage::Pose first = linkage::RequirePose(kPublishedLinks, kLongest_mm);
  double phi = first.phi_rad, theta = first.theta_rad;
  for (int step = 0; step <= kSteps; ++step) {
    const double stroke = kLongest_mm + (kShortest_mm - kLongest_mm) * step / kSteps;
    const NewtonPose newton = SolvePoseNewton(kPublishedLinks, stroke, phi, theta);
    const linkage::Pose pose = linkage::RequirePose(kPublishedLinks, stroke);
    ASSERT_TRUE(newton.converged) << stroke;
    ASSERT_NEAR(newton.phi_rad, pose.phi_rad, 1e-9) << stroke;
    ASSERT_NEAR(newton.theta_rad, pose.theta_rad, 1e-9) << stroke;
    ExpectLoopsClose(kPublishedLinks, pose);
    phi = newton.phi_rad;
    theta = newton.theta_rad;
  }
}

TEST(ClosedForm, IsContinuousOverTheWholeAssemblyRange) {
  testing::RandomLinks random;
  for (int i = 0; i < 300; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    for (const linkage::StrokeRange& range : linkage::AssemblyRanges(links)) {
      constexpr int kSteps = 4000;
      std::optional<double> last;
      for (int step = 0; step <= kSteps; ++step) {
        const linkage::Pose pose = linkage::RequirePose(links, range.lower_mm + range.Travel() * step / kSteps);
        // A wrong turn would jump by 2 pi; what the linkage itself moves in a 4000th of its range stays far below pi.
        if (last) {
          ASSERT_LT(std::abs(pose.theta_rad - *last), 3) << pose.stroke_mm;
        }
        last = pose.theta_rad;
      }
    }
  }
}

// A rhombus: theta = pi - phi up to where the bar tip arrives at the knee pivot (there l8 vanishes and the shank is
// free).
TEST(ClosedForm, HoldsWhereTheTipMeetsTheKnee) {
  const linkage::Links rhombus{70, 70, 70, 70, 70, 70};
  const double tip_at_knee = 70 * std::sqrt(5);  // |K - M|
  for (const double stroke : {70.0, 120.0, 156.0, tip_at_knee - 1e-6, tip_at_knee - 1e-11}) {
    const linkage::Pose pose = linkage::RequirePose(rhombus, stroke);
    EXPECT_NEAR(pose.theta_rad, std::numbers::pi - pose.phi_rad, 1e-9) << stroke;
  }
}

TEST(Assembly, RangesAreWhereThePoseExists) {
  testing::RandomLinks random;
  for (int i = 0; i < 300; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    const auto ranges = linkage::AssemblyRanges(links);
    for (int step = 0; step < 500; ++step) {
      const double stroke = random.Uniform(0.001, links.L7() + links.l2 + 20);
      const bool inside = std::any_of(ranges.begin(), ranges.end(), [&](const auto& r) { return r.Contains(stroke); });
      ASSERT_EQ(linkage::SolvePose(links, stroke).has_value(), inside) << stroke;
      ASSERT_EQ(linkage::FindAssemblyGap(links, stroke).has_value(), !inside) << stroke;
    }
    for (const linkage::StrokeRange& range : ranges)
      ExpectLoopsClose(links, linkage::RequirePose(links, range.lower_mm));
    for (const linkage::StrokeRange& range : ranges)
      ExpectLoopsClose(links, linkage::RequirePose(links, range.upper_mm));
  }
}

TEST(Assembly, SaysWhichTriangleMissesByHowMuch) {
  const double shortest = kPublishedLinks.L7() - kPublishedLinks.l2;
  const auto actuator = linkage::FindAssemblyGap(kPublishedLinks, shortest - 0.5);
  ASSERT_TRUE(actuator);
  EXPECT_EQ(actuator->triangle, linkage::AssemblyGap::Triangle::kActuator);
  EXPECT_NEAR(actuator->gap_mm, 0.5, 1e-9);
  // Ends of solves are flat to some 1e-9 mm, and are assembled; a hair is too much.
  EXPECT_TRUE(linkage::SolvePose(kPublishedLinks, shortest - 2e-9));
  EXPECT_FALSE(linkage::FindAssemblyGap(kPublishedLinks, shortest - 2e-9));
  EXPECT_FALSE(linkage::SolvePose(kPublishedLinks, shortest - 1e-6));
  linkage::Links short_coupler = kPublishedLinks;
  short_coupler.l1 = 5;
  const auto shank = linkage::FindAssemblyGap(short_coupler, 300);
  ASSERT_TRUE(shank);
  EXPECT_EQ(shank->triangle, linkage::AssemblyGap::Triangle::kShank);
  EXPECT_THAT(
      [] {
        linkage::RequirePose({1, 1, 1, 1, 1, 1}, 242);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("cannot be assembled at a stroke of 242 mm"),
                                 HasSubstr("the actuator is too long for l2, l5 and l6 by 240 mm"))));
  EXPECT_FALSE(linkage::SolvePose(kPublishedLinks, std::nan("")));
  EXPECT_TRUE(linkage::FindAssemblyGap(kPublishedLinks, std::nan("")));
  EXPECT_FALSE(linkage::SolvePose(kPublishedLinks, -242));
}

TEST(Assembly, BadLinksAreNamed) {
  const auto with_l3 = [](double value) {
    linkage::Links links = kPublishedLinks;
    links.l3 = value;
    return links;
  };
  for (const double bad : {0.0, -1.0, std::nan(""), 1e9, HUGE_VAL})
    EXPECT_THAT([&] { linkage::CheckLinks(with_l3(bad), "here"); },
                ThrowsMessage<Error>(HasSubstr("here: link l3 is")));
  linkage::CheckLinks(kPublishedLinks, "here");
}

// Free-body statics, an independent route to the force: the bar turns about P under actuator and coupler, the shank
// about K.
TEST(Force, AgreesWithStatics) {
  testing::RandomLinks random;
  int compared = 0;
  for (int i = 0; i < kDesigns; ++i) {
    const linkage::Links links = random.Next();
    const linkage::Pose pose = linkage::RequirePose(links, random.StrokeFor(links));
    if (Conditioning(links, pose) < 1e-3) continue;
    const auto moment = [](const Eigen::Vector2d& arm, const Eigen::Vector2d& force) {
      return arm.x() * force.y() - arm.y() * force.x();
    };
    const Eigen::Vector2d push = (pose.tip - pose.mount).normalized(),
                          coupler = (pose.shank_pin - pose.tip).normalized();
    const Eigen::Vector2d bar = pose.tip - pose.thigh_pin;
    // Moments on the bar about P give the coupler's force, that on the shank about K its moment: flexion, as it is
    // counted from x (posterior) to y (up) and theta grows that way.
    const double coupler_per_push = moment(bar, push) / moment(bar, coupler);
    const double flexion_nmm = moment(pose.shank_pin, coupler * coupler_per_push);
    const double force = linkage::ActuatorForce(linkage::TransmissionOf(links, pose), 40);
    EXPECT_NEAR(-flexion_nmm * force / 40000, 1, 1e-6) << testing::TextOf(links) << " at " << pose.stroke_mm;
    ++compared;
  }
  EXPECT_GT(compared, kDesigns * 9 / 10);
}

TEST(Transmission, AnglesAreThoseOfTheTriangles) {
  testing::RandomLinks random;
  for (int i = 0; i < kDesigns; ++i) {
    const linkage::Links links = random.Next();
    const linkage::Pose pose = linkage::RequirePose(links, random.StrokeFor(links));
    const linkage::Transmission t = linkage::TransmissionOf(links, pose);
    const auto between = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return std::atan2(std::abs(a.x() * b.y() - a.y() * b.x()), a.dot(b));
    };
    EXPECT_NEAR(t.transmission_rad, between(pose.tip - pose.shank_pin, pose.knee - pose.shank_pin), 1e-9);
    EXPECT_NEAR(t.actuator_rad, between(pose.thigh_pin - pose.tip, pose.mount - pose.tip), 1e-9);
  }
}

TEST(Grashof, ClassesWithTheShankAsFrame) {
  const auto type = [](double l1, double l2, double l3, double l4) {
    return linkage::GrashofOf({l1, l2, l3, l4, 100, 250}).type;
  };
  EXPECT_EQ(type(60, 65, 50, 70), linkage::GrashofClass::kCrankRocker);  // shortest beside the frame
  EXPECT_EQ(type(50, 65, 60, 70), linkage::GrashofClass::kCrankRocker);
  EXPECT_EQ(type(60, 50, 65, 70), linkage::GrashofClass::kDoubleRocker);  // shortest opposite the frame
  EXPECT_EQ(type(60, 65, 70, 50), linkage::GrashofClass::kDoubleCrank);   // shortest is the frame
  EXPECT_EQ(type(60, 60, 50, 70), linkage::GrashofClass::kChangePoint);
  EXPECT_EQ(type(60, 60, 50, 80), linkage::GrashofClass::kTripleRocker);
  EXPECT_NEAR(linkage::GrashofOf({60, 60, 50, 80, 100, 250}).slack_mm, -10, 1e-12);
}

// Forces in members and pins against virtual work, against the balance of every body, and by hand.

using Eigen::Vector2d;

double Moment(const Vector2d& at, const Vector2d& force) {
  return at.x() * force.y() - at.y() * force.x();
}

// A square: the actuator hangs plumb on the bar's end, the coupler too. 72 N m at 72 mm are 1000 N in both; the bar,
// across both, is free.
TEST(MemberForces, OfTheCheckPoseByHand) {
  const linkage::Pose pose = linkage::RequirePose({60, 72, 60, 72, 72, 240}, 240);
  const linkage::MemberForces forces = linkage::MemberForcesOf(pose, 72);
  constexpr double kRounding_n = 1e-9;
  EXPECT_NEAR(forces.actuator_n, 1000, kRounding_n);
  EXPECT_NEAR(forces.coupler_n, 1000, kRounding_n);
  EXPECT_NEAR(forces.bar_n, 0, kRounding_n);
  EXPECT_NEAR(forces.KneePin(), 1000, kRounding_n);
  EXPECT_NEAR(forces.TipPin(), 1000, kRounding_n);
}

// Poses a degree and more from both dead points, where forces are finite to many digits.
bool IsClear(const linkage::Transmission& transmission) {
  constexpr double kLeast = 0.02;
  return std::sin(transmission.transmission_rad) > kLeast && std::sin(transmission.actuator_rad) > kLeast &&
         std::isfinite(transmission.radians_per_mm) && transmission.moment_arm_mm > 1;
}

TEST(MemberForces, AgreeWithVirtualWorkAndBalanceEveryBody) {
  testing::RandomLinks random;
  int checked = 0;
  while (checked < 2000) {
    const linkage::Links links = random.Next();
    const linkage::Pose pose = linkage::RequirePose(links, random.StrokeFor(links));
    const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
    if (!IsClear(transmission)) continue;
    ++checked;
    const double torque_nm = random.Uniform(-120, 120);
    const linkage::MemberForces forces = linkage::MemberForcesOf(pose, torque_nm);
    const double rounding_n = 1e-9 * (forces.TipPin() + 1);  // some 50 roundings at least 0.02 from a division by zero
    EXPECT_NEAR(forces.actuator_n, linkage::ActuatorForce(transmission, torque_nm), rounding_n)
        << testing::TextOf(links) << " d " << pose.stroke_mm;

    // What each member does to the pin at its second end; the opposite at its first.
    const Vector2d actuator = forces.actuator_n * (pose.tip - pose.mount) / pose.stroke_mm;
    const Vector2d coupler = forces.coupler_n * (pose.shank_pin - pose.tip) / links.l1;
    const Vector2d bar = forces.bar_n * (pose.tip - pose.thigh_pin) / links.l2;
    EXPECT_NEAR((actuator + bar - coupler).norm(), 0, rounding_n);
    // The shank bears the coupler at S, the knee pin at K and the leg's couple, the torque turned round.
    const Vector2d knee = -coupler;
    EXPECT_NEAR(Moment(pose.shank_pin, coupler), -1000 * torque_nm, 1000 * rounding_n);
    EXPECT_NEAR(knee.norm(), forces.KneePin(), rounding_n);
    // The thigh plate bears the others' ends at K, P and M: no sum, and the torque about any point.
    EXPECT_NEAR((-knee - bar - actuator).norm(), 0, rounding_n);
    EXPECT_NEAR(Moment(pose.thigh_pin, -bar) + Moment(pose.mount, -actuator), 1000 * torque_nm, 1000 * rounding_n);
    EXPECT_NEAR(forces.ThighPin(), bar.norm(), rounding_n);
    EXPECT_NEAR(forces.Mount(), actuator.norm(), rounding_n);
  }
}

TEST(MemberForces, HaveNoBoundAtADeadPoint) {
  // The published design's shortest stroke at which it can be assembled: actuator and bar in line.
  const linkage::Links links{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  const double dead_mm = linkage::AssemblyRanges(links).front().lower_mm;
  EXPECT_GT(linkage::MemberForcesOf(linkage::RequirePose(links, dead_mm + 1e-9), 40).Mount(), 1e6);
}

// The published design, worked out from the paper's own equations: every number to its printed digits.

constexpr linkage::Links kInitial{85, 85, 85, 80, 80, 235};
constexpr double kDMin_mm = 242;

double AngleDeg(const linkage::Links& links, double stroke_mm) {
  return DegreesFromRadians(linkage::RequirePose(links, stroke_mm).theta_rad);
}

linkage::Pose PoseAt(double theta_deg) {
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, kDMin_mm, {});
  const auto stroke = linkage::StrokeForAngle(kPublishedLinks, range, RadiansFromDegrees(theta_deg));
  if (!stroke) throw std::runtime_error("no stroke for this angle");
  return linkage::RequirePose(kPublishedLinks, *stroke);
}

// Eqs. (1)-(6) as the paper prints them: unsigned arccos for both beta.
double PaperAngleDeg(const linkage::Links& l, double d) {
  const double alpha1 = std::atan(l.l5 / l.l6), l7 = std::hypot(l.l5, l.l6);
  const double alpha2 = std::acos((l7 * l7 + l.l2 * l.l2 - d * d) / (2 * l7 * l.l2));
  const double l8 = std::sqrt(l.l2 * l.l2 + l.l3 * l.l3 - 2 * l.l2 * l.l3 * std::cos(M_PI - alpha1 - alpha2));
  const double beta1 = std::acos((l8 * l8 + l.l3 * l.l3 - l.l2 * l.l2) / (2 * l8 * l.l3));
  const double beta2 = std::acos((l8 * l8 + l.l4 * l.l4 - l.l1 * l.l1) / (2 * l8 * l.l4));
  return 180 - DegreesFromRadians(beta1 + beta2);
}

TEST(PaperTables, HoldTheLinksUsedHere) {
  const CsvTable table = CsvTable::Read(SourceDir() / "data/paper/table1.csv");
  ASSERT_EQ(table.Rows(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(table.RequiredNumber(i, table.Column("initial_mm")), kInitial.Values()[i]);
    EXPECT_EQ(table.RequiredNumber(i, table.Column("optimum_mm")), kPublishedLinks.Values()[i]);
  }
}

// A parallelogram on a square: every quantity can be seen without a calculator (libs/design/linkage/README.md).
TEST(CheckPose, ParallelogramAtARightAngle) {
  const linkage::Links links{60, 72, 60, 72, 72, 240};
  const linkage::Pose pose = linkage::RequirePose(links, 240);
  const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(DegreesFromRadians(pose.theta_rad), 90, kRounding * 90);
  EXPECT_NEAR(DegreesFromRadians(pose.phi_rad), 90, kRounding * 90);
  EXPECT_NEAR((pose.tip - Eigen::Vector2d(72, 60)).norm(), 0, kRounding * 72);
  EXPECT_NEAR((pose.shank_pin - Eigen::Vector2d(72, 0)).norm(), 0, kRounding * 72);
  EXPECT_NEAR(transmission.moment_arm_mm, 72, kRounding * 72);
  EXPECT_NEAR(DegreesFromRadians(transmission.transmission_rad), 90, kRounding * 90);
  EXPECT_NEAR(DegreesFromRadians(transmission.actuator_rad), 90, kRounding * 90);
  EXPECT_NEAR(linkage::ActuatorForce(transmission, 72), 1000, 1e-9);
}

// Half a unit of the last printed digit.
TEST(PublishedDesign, RangeOfRotation) {
  EXPECT_NEAR(AngleDeg(kPublishedLinks, kDMin_mm), 148.5715, 5e-5);
}

TEST(PublishedDesign, InitialPointAndItsViolation) {
  EXPECT_NEAR(AngleDeg(kInitial, kDMin_mm), 85.119, 5e-4);
  EXPECT_DOUBLE_EQ(kInitial.l1 - kInitial.l4, 5);
}

TEST(PublishedDesign, GrashofAndSingularitySlack) {
  const linkage::Grashof grashof = linkage::GrashofOf(kPublishedLinks);
  EXPECT_EQ(grashof.type, linkage::GrashofClass::kCrankRocker);
  EXPECT_NEAR(grashof.slack_mm, 0.108, 5e-4);
  EXPECT_NEAR(linkage::DistancesToSingularities(kPublishedLinks, linkage::RequirePose(kPublishedLinks, kDMin_mm))
                  .actuator_folded_mm,
              0.00224, 5e-6);
}

TEST(PublishedDesign, StrokesAndTravel) {
  EXPECT_NEAR(PoseAt(2).stroke_mm, 373.962, 5e-4);
  EXPECT_NEAR(PoseAt(0).stroke_mm, 374.5205, 5e-5);
  EXPECT_NEAR(PoseAt(2).stroke_mm - kDMin_mm, 131.96, 5e-3);
  EXPECT_NEAR((PoseAt(2).stroke_mm - kDMin_mm) / 5, 26.4, 0.05);  // s at 5 mm/s
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, kDMin_mm, {});
  EXPECT_NEAR(range.stroke.Travel(), 132.52, 5e-3);
  EXPECT_EQ(range.end, linkage::UsedRange::End::kStanding);
}

TEST(PublishedDesign, ContinuesWhereTheArccosFormFoldsBack) {
  // phi passes 180 degrees where the slewing bar points straight down: |(0, l3 - l2) - M| by Pythagoras.
  const double fold_mm = std::hypot(kPublishedLinks.l5, kPublishedLinks.l6 + kPublishedLinks.l2);
  EXPECT_NEAR(fold_mm, 375.3877, 5e-5);
  EXPECT_NEAR(AngleDeg(kPublishedLinks, 377), -44.84, 5e-3);
  EXPECT_NEAR(PaperAngleDeg(kPublishedLinks, 377), 3.57, 5e-3);
  for (double d = kDMin_mm; d < fold_mm; d += 0.37)
    EXPECT_NEAR(AngleDeg(kPublishedLinks, d), PaperAngleDeg(kPublishedLinks, d), 1e-6) << d;
}

TEST(PublishedDesign, ActuatorForceForFortyNewtonMetres) {
  const auto force = [](double theta_deg) {
    return linkage::ActuatorForce(linkage::TransmissionOf(kPublishedLinks, PoseAt(theta_deg)), 40);
  };
  EXPECT_NEAR(force(90), 571, 0.5);
  EXPECT_NEAR(force(100), 604, 0.5);
  EXPECT_NEAR(force(140), 2060, 5);
  EXPECT_NEAR(force(148.5), 41000, 500);
  EXPECT_NEAR(force(2), 2160, 5);
}

TEST(PublishedDesign, TransmissionAngle) {
  const auto transmission = [](double theta_deg) {
    return DegreesFromRadians(linkage::TransmissionOf(kPublishedLinks, PoseAt(theta_deg)).transmission_rad);
  };
  EXPECT_NEAR(transmission(90), 87.0, 0.05);
  EXPECT_NEAR(transmission(2), 3.6, 0.05);
}

}  // namespace
}  // namespace lake
