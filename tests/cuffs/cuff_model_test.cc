#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "cuffs/leg_energy.h"
#include "lake/core/error.h"
#include "lake/cuffs/cuff_course.h"

namespace lake::cuffs {
namespace {

using Eigen::Vector2d;

const double k95 = std::sqrt(-2 * std::log(0.05));  // of the distance of a place in two directions: Rayleigh

// A hinge 20 mm off, after 90° of flexion, has moved what it carries by 2 · 20 · sin(45°) = 28.3 mm.
TEST(CuffModel, AHingeBesideTheKneeMovesACuff) {
  for (const double direction : {0.0, 0.7, 2.1, -1.3}) {
    const Vector2d place = 20 * Vector2d(std::cos(direction), std::sin(direction));
    EXPECT_NEAR(MisfitOf(place, place, -60, 30).norm(), 28.28, 0.01);
    EXPECT_NEAR(MisfitOf(place, place, 0, 0).norm(), 0, 1e-12);
  }
}

// What follows holds the reference of the closed form: where only one cuff yields, by shear alone, it takes 28 N at 1
// N/mm and 57 N at 2 N/mm: long cuffs keep the links from turning, and the thigh's holds fast.
TEST(CuffModel, WhatACuffTakesOfAMisfit) {
  CuffOptions options;
  options.thigh = {{200, 1e5}};
  options.shank = {{200, 1e5}};
  const LegState leg{-60, 30, {20, 0}, {20, 0}};
  for (const auto& [stiffness, force_n] : {std::pair(1.0, 28.28 / 2), std::pair(2.0, 28.28)}) {
    const LegLoad load = LoadOnLeg(leg, options, {stiffness, stiffness});
    EXPECT_NEAR(load.largest_shank_n, force_n, 0.01) << "two alike share the misfit";
    EXPECT_NEAR(load.largest_thigh_n, force_n, 0.01);
  }
  options.thigh.resize(1000, options.thigh.front());  // a thousand cuffs against one
  EXPECT_NEAR(LoadOnLeg(leg, options, {1, 1}).largest_shank_n, 28.28, 0.05);
  EXPECT_NEAR(LoadOnLeg(leg, options, {2, 2}).largest_shank_n, 56.57, 0.1);
}

// One cuff carries no couple: 40 N m over 0.25 m are 160 N at the cuff, and the knee passes them on. Two carry it.
TEST(CuffModel, OneCuffLoadsTheKneeTwoDoNot) {
  CuffOptions options;
  options.thigh = {{250, 0}, {100, 0}};
  options.shank = {{250, 0}};
  const LegState leg{.thigh_deg = -40, .shank_deg = 20, .moment_nm = 40};
  const Stiffness stiff{2e5, 2e5};  // so that the links turn by 1e-5 rad, and forces change by 1e-5 of themselves
  const LegLoad one = LoadOnLeg(leg, options, stiff);
  EXPECT_NEAR(std::abs(one.shank[0].force_n.x()), 160, 0.01);
  EXPECT_NEAR(one.knee_shear_n, 160, 0.01);
  // With the thigh's cuffs fast the hinge stays, and two cuffs of the shank share: forces as their distances.
  options.shank = {{250, 0}, {50, 0}};
  options.thigh = {{100, 1e6}};
  const LegLoad two = LoadOnLeg(leg, options, stiff);
  double couple_nm = 0;
  for (std::size_t i = 0; i < 2; ++i) couple_nm += two.shank[i].force_n.x() * options.shank[i].from_knee_mm / 1000;
  EXPECT_NEAR(std::abs(couple_nm), 40, 0.001) << "about the hinge";
}

// A hinge that turns freely gives way to two short cuffs; one that is held at the knee's angle loads them, the
// more the farther it is off.
TEST(CuffModel, AHeldHingeLoadsTheCuffs) {
  const CuffOptions options;
  LegState leg{-80, 15, {18, 32}, {18, 32}};
  EXPECT_LT(LoadOnLeg(leg, options, {}).largest_shank_n, 2);
  leg.held_error_deg = 0;
  const LegLoad held = LoadOnLeg(leg, options, {});
  EXPECT_GT(held.largest_shank_n, 15);
  EXPECT_LT(held.largest_shank_n, 1.5 * MisfitOf({18, 32}, {18, 32}, -80, 15).norm())
      << "a cuff takes no more than all of the misfit";
  leg.hinge_on_thigh_mm /= 2;
  leg.hinge_on_shank_mm /= 2;
  // The levers are the cuffs' distances from the hinge, 37 mm of 200, and the links turn: half is not half to the last
  // digit.
  EXPECT_NEAR(LoadOnLeg(leg, options, {}).largest_shank_n, held.largest_shank_n / 2, 0.1 * held.largest_shank_n);
}

// What the cuffs do to the leg is what the device's weight and the actuator do: forces sum to the weight, moments about
// the knee to nothing but the misfit's lever.
TEST(CuffModel, ForcesBalance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> some(-1, 1);
  for (int k = 0; k < 50; ++k) {
    CuffOptions options;
    options.thigh = {{200 + 40 * some(random), 60}, {90, 40}};
    options.shank = {{220 + 40 * some(random), 80}};
    options.thigh_link_kg = 1.2;
    options.shank_link_kg = 0.8;
    const auto draw = [&](double most) { return most * some(random); };
    const LegState leg{draw(40), draw(30), {draw(15), draw(25)}, {draw(15), draw(25)}, draw(30)};
    const LegLoad load = LoadOnLeg(leg, options, {1.5, 0.7});
    const auto axes = [](double deg) {
      const double a = deg * M_PI / 180;
      Eigen::Matrix2d m;
      m << std::cos(a), std::sin(a), -std::sin(a), std::cos(a);
      return m;
    };
    Vector2d sum = Vector2d::Zero();
    for (const CuffLoad& cuff : load.thigh) sum += axes(leg.thigh_deg) * cuff.force_n;
    for (const CuffLoad& cuff : load.shank) sum += axes(leg.shank_deg) * cuff.force_n;
    EXPECT_NEAR(sum.x(), 0, 1e-9);
    EXPECT_NEAR(sum.y(), -2.0 * 9.80665, 1e-9);
    // Moments of the shank's link about the hinge: cuffs against actuator and weight.
    // Its turn, by what it takes to turn a cuff 80 mm long.
    const double turn_deg = load.shank[0].moment_nm / (1.5 * 80 * 80 / 12 / 1000) * 180 / M_PI;
    const Vector2d from_hinge_m =
        1e-3 * axes(turn_deg) * (Vector2d(0, -options.shank[0].from_knee_mm) - leg.hinge_on_shank_mm);
    const auto forward = [](const Vector2d& from, const Vector2d& force) {
      return from.y() * force.x() - from.x() * force.y();
    };
    const Vector2d weight_n = axes(leg.shank_deg).transpose() * Vector2d(0, -0.8 * 9.80665);
    const CuffLoad& cuff = load.shank[0];
    const double moment =
        -leg.moment_nm + forward(from_hinge_m / 2, weight_n) - forward(from_hinge_m, cuff.force_n) - cuff.moment_nm;
    EXPECT_NEAR(moment, 0, 1e-9) << "seed 7, draw " << k;
  }
}

// The course of a hinge 20 mm off from 90° to standing: 28.3 mm of misfit, of which a cuff that yields alone takes 28 N
// at 1 N/mm and 57 N at 2 N/mm; where the place is known to 5 mm alone, as much less and more.
TEST(CuffCourse, IsThatOfTheMisfitWithAnInterval) {
  CuffOptions options;
  options.thigh.assign(1000, {200, 1e5});
  options.shank = {{200, 1e5}};
  const double per_mm = 2 * std::sin(M_PI / 4);
  for (const double direction : {0.0, 1.1, 2.9, -1.7}) {
    HingePlace place{20 * Vector2d(std::cos(direction), std::sin(direction)), 0};
    const CuffForce shank = Largest(CourseOf({90, 40, 0}, place, options).shank_n);
    EXPECT_NEAR(shank.low_n, 28.28, 0.05);
    EXPECT_NEAR(shank.force_n, 28.28 * std::sqrt(2.0), 0.05);
    EXPECT_NEAR(shank.high_n, 56.57, 0.1);
    place.sd_mm = 5;
    const CuffForce vague = Largest(CourseOf({90, 40, 0}, place, options).shank_n);
    EXPECT_NEAR(vague.low_n, per_mm * (20 - k95 * 5), 0.05);
    EXPECT_NEAR(vague.high_n, 2 * per_mm * (20 + k95 * 5), 0.1);
    EXPECT_EQ(CourseOf({90, 40, 0}, place, options).shank_n.back().force_n, 0) << "free of stress at standing";
  }
  // A joint on the knee makes no force, but its place is not known better for that.
  const CuffForce on_knee = Largest(CourseOf({90, 0}, {Vector2d::Zero(), 5}, options).shank_n);
  EXPECT_EQ(on_knee.force_n, 0);
  EXPECT_NEAR(on_knee.high_n, 2 * per_mm * k95 * 5, 0.1);
}

// Short cuffs resist a joint that is off along the leg more than one that is off across it: where it may be off in any
// direction, the interval holds what the worst of them does.
TEST(CuffCourse, AnUncertainPlaceMayBeOffInAnyDirection) {
  const CuffOptions options;
  const CuffForce on_knee = Largest(CourseOf({80, 5}, {Vector2d::Zero(), 6}, options).shank_n);
  double least_n = 1e9, most_n = 0;
  for (int k = 0; k < 60; ++k) {
    const Vector2d off = k95 * 6 * Vector2d(std::cos(k * M_PI / 60), std::sin(k * M_PI / 60));
    const double stiffest_n = std::sqrt(2.0) * Largest(CourseOf({80, 5}, {off, 0}, options).shank_n).force_n;
    least_n = std::min(least_n, stiffest_n);
    most_n = std::max(most_n, stiffest_n);
  }
  EXPECT_NEAR(on_knee.high_n, most_n, 0.03 * most_n);
  EXPECT_LT(least_n, 0.8 * most_n) << "the direction matters";
}

// The same as the model's wherever the leg leans: forces are in the segments' frames.
TEST(CuffCourse, DoesNotDependOnTheLean) {
  const CuffOptions options;
  const Vector2d place(12, -21);
  const double standing_deg = 4, bent_deg = 71, lean_deg = 17;
  const double angle = standing_deg * M_PI / 180;
  const Vector2d on_thigh(std::cos(angle) * place.x() + std::sin(angle) * place.y(),
                          -std::sin(angle) * place.x() + std::cos(angle) * place.y());
  const LegLoad load =
      LoadOnLeg({lean_deg - bent_deg, lean_deg, on_thigh, place, 0, 0}, options, {std::sqrt(2.0), std::sqrt(2.0)});
  const CuffCourse course = CourseOf({bent_deg, standing_deg}, {place, 0}, options);
  EXPECT_NEAR(course.thigh_n.front().force_n, load.largest_thigh_n, 1e-9);
  EXPECT_NEAR(course.shank_n.front().force_n, load.largest_shank_n, 1e-9);
  EXPECT_NEAR(course.knee_shear_n.front().force_n, load.knee_shear_n, 1e-9);
}

// The closed form for any cuffs is what the least energy gives.
TEST(CuffCourse, TheClosedFormIsTheModel) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> some(0, 1);
  for (int draw = 0; draw < 50; ++draw) {
    CuffOptions options;
    options.thigh = {{150 + 100 * some(random), 120 * some(random)}, {60, 40}};
    options.shank = {{150 + 100 * some(random), 120 * some(random)}};
    if (draw % 2) options.shank.push_back({90, 0});
    const Vector2d place(30 * some(random) - 15, 60 * some(random) - 30);
    const double bent = 2 * some(random), standing = 0.2 * some(random);
    const auto degrees = [](double rad) { return rad * 180 / M_PI; };
    const Vector2d on_thigh = MisfitOf(Vector2d::Zero(), place, degrees(standing), 0);
    const double error = draw % 3 == 0 ? 0.2 * some(random) - 0.1 : 0;
    const LegLoad load = LoadOnLeg({-degrees(bent), 0, on_thigh, place, 0, degrees(error)}, options, {1.7, 1.7});
    const auto slips = SlipsOf(options, bent, standing, place.x(), place.y(), error);
    const std::vector<PlacedCuff> places = CuffsOf(options);
    ASSERT_EQ(slips.size(), places.size());
    for (std::size_t i = 0; i < slips.size(); ++i)
      EXPECT_NEAR(std::hypot(slips[i][0], slips[i][1]),
                  (places[i].on_thigh ? load.thigh : load.shank)[places[i].number].slip_mm.norm(), 1e-9)
          << "seed 5, draw " << draw;
  }
}

TEST(CuffModel, RefusesWhatIsNoCuff) {
  CuffOptions options;
  options.shank.clear();
  EXPECT_THROW(CourseOf({90, 0}, {}, options), UsageError);
  options.shank = {{-1, 80}};
  EXPECT_THROW(CourseOf({90, 0}, {}, options), UsageError);
  options.shank = {{200, 80}};
  options.softest_n_mm = 0;
  EXPECT_THROW(CourseOf({90, 0}, {}, options), UsageError);
  options.softest_n_mm = 3;
  EXPECT_THROW(CourseOf({90, 0}, {}, options), UsageError);
}

TEST(CuffModel, TheSoftestMayNotBeStifferThanTheStiffest) {
  CuffOptions options;
  OptionList list;
  Describe(options, list);
  EXPECT_NO_THROW(list.RunChecks());
  options.softest_n_mm = 3;
  EXPECT_THROW(list.RunChecks(), UsageError) << "the stiffest is 2 N/mm";
}

TEST(CuffModel, AnUnknownMisfitIsNoForceOfZero) {
  const CuffOptions options;
  for (const HingePlace& place : {HingePlace{{NAN, 3}, 5}, HingePlace{{20, 3}, NAN}}) {
    const CuffForce force = Largest(CourseOf({90, 40, 0}, place, options).thigh_n);
    EXPECT_TRUE(std::isnan(force.low_n) && std::isnan(force.high_n));
  }
  EXPECT_TRUE(std::isnan(Largest({{1, 1, 1}, {NAN, NAN, NAN}, {2, 2, 2}}).force_n));
}

}  // namespace
}  // namespace lake::cuffs
