#include "lake/cuffs/leg_statics.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "cuffs/leg_energy.h"
#include "lake/core/error.h"

namespace lake::cuffs {
namespace {

using Eigen::Vector2d;

constexpr double kMoment_nm = 40;

CuffOptions Alike(const std::vector<Cuff>& cuffs) {
  CuffOptions options;
  options.thigh = options.shank = cuffs;
  return options;
}

Posture Bent(double knee_deg) {
  return {.thigh_deg = -knee_deg, .shank_deg = 0};
}

double HalfSine(double knee_deg) {
  return std::sin(knee_deg / 2 * M_PI / 180);
}

// One cuff without length: 40 N m over 0.25 m are 160 N across each segment, all of it shear at the knee. The hinge
// bears none, so that the cuffs also drag along the leg, and pull the knee apart.
TEST(LegStatics, OneCuffPushesAcrossAndTheKneeShears) {
  for (const double knee_deg : {20.0, 60.0, 90.0, 130.0}) {
    const LegStatics leg = StaticsOf(Bent(knee_deg), kMoment_nm, Alike({{250, 0}}));
    EXPECT_NEAR(leg.thigh[0].force_n.x(), 160, 1e-9) << "forward: the thigh's link turns so";
    EXPECT_NEAR(leg.shank[0].force_n.x(), 160, 1e-9) << "forward: it is below the knee, and the link turns back";
    EXPECT_NEAR(leg.knee_shear_n, 160, 1e-9);
    const double along_n = 160 / std::tan(knee_deg / 2 * M_PI / 180);
    EXPECT_NEAR(leg.knee_compression_n, -along_n, 1e-9);
    EXPECT_NEAR(leg.largest_thigh_n, std::hypot(160, along_n), 1e-9);
    EXPECT_NEAR(leg.largest_shank_n, std::hypot(160, along_n), 1e-9);
  }
}

// Two push forward, and nothing leans against them.
TEST(LegStatics, CuffsWithoutLengthDoNotBearAMomentAtAStraightKnee) {
  EXPECT_TRUE(std::isnan(StaticsOf(Bent(0), kMoment_nm, Alike({{250, 0}})).largest_thigh_n));
  CuffOptions hangs = Alike({{250, 0}});
  hangs.thigh_link_kg = 2;
  const LegStatics leg = StaticsOf(Bent(0), 0, hangs);
  EXPECT_NEAR(leg.thigh[0].force_n.y() + leg.shank[0].force_n.y(), -2 * 9.80665, 1e-9) << "they do bear a weight";
}

// Two at each segment of a straight knee: a couple of M/(a2 − a1), and no shear.
TEST(LegStatics, TwoCuffsCarryACouple) {
  const LegStatics leg = StaticsOf(Bent(0), kMoment_nm, Alike({{100, 0}, {250, 0}}));
  const double couple_n = 40 / 0.150;
  EXPECT_NEAR(leg.thigh[0].force_n.x(), -couple_n, 1e-9);
  EXPECT_NEAR(leg.thigh[1].force_n.x(), couple_n, 1e-9);
  EXPECT_NEAR(leg.shank[0].force_n.x(), -couple_n, 1e-9);
  EXPECT_NEAR(leg.shank[1].force_n.x(), couple_n, 1e-9);
  EXPECT_NEAR(leg.knee_shear_n, 0, 1e-9);
  EXPECT_NEAR(leg.knee_compression_n, 0, 1e-9);
}

// Of a bent one the hinge gives way along the bisector, by a mean of cos²(θ/2) of the cuffs' turn, and the forces are
// in proportion to a_i − cos²(θ/2) a_mean.
TEST(LegStatics, TwoCuffsAtABentKnee) {
  for (const double knee_deg : {30.0, 90.0, 120.0}) {
    const LegStatics leg = StaticsOf(Bent(knee_deg), kMoment_nm, Alike({{100, 0}, {250, 0}}));
    const double gives = 1 - std::pow(HalfSine(knee_deg), 2), mean = 0.175;
    const double turn = kMoment_nm / (0.1 * 0.1 + 0.25 * 0.25 - 2 * gives * mean * mean);
    EXPECT_NEAR(leg.shank[0].force_n.x(), turn * (0.1 - gives * mean), 1e-9);
    EXPECT_NEAR(leg.shank[1].force_n.x(), turn * (0.25 - gives * mean), 1e-9);
    EXPECT_NEAR(leg.knee_shear_n, turn * 2 * mean * (1 - gives), 1e-9);
  }
}

// A long one carries a part as a couple, the more the straighter the knee: (L²/12)/(a² sin²(θ/2) + L²/12) of it.
TEST(LegStatics, ALongCuffCarriesAPartAsACouple) {
  for (const double knee_deg : {0.0, 5.0, 40.0, 90.0, 150.0}) {
    const LegStatics leg = StaticsOf(Bent(knee_deg), kMoment_nm, Alike({{200, 80}}));
    const double by_place = std::pow(200 * HalfSine(knee_deg), 2), by_length = 80 * 80 / 12.0;
    EXPECT_NEAR(leg.thigh[0].moment_nm, kMoment_nm * by_length / (by_place + by_length), 1e-9);
    EXPECT_NEAR(leg.thigh[0].force_n.x(), kMoment_nm / 0.2 * by_place / (by_place + by_length), 1e-9);
    EXPECT_NEAR(leg.knee_shear_n, leg.shank[0].force_n.x(), 1e-9);
  }
}

// All of it as a couple, each half presses by 3/2 M/L; where its force keeps all of it on one side, it is the force.
TEST(LegStatics, ACoupleWithoutAForcePressesToo) {
  const LegStatics straight = StaticsOf(Bent(0), kMoment_nm, Alike({{200, 80}}));
  EXPECT_NEAR(straight.largest_thigh_n, 1.5 * 40 / 0.08, 1e-9);
  const LegStatics bent = StaticsOf(Bent(150), kMoment_nm, Alike({{200, 80}}));
  ASSERT_LT(6 * bent.thigh[0].moment_nm, 0.08 * bent.thigh[0].force_n.x());
  EXPECT_NEAR(bent.largest_thigh_n, bent.thigh[0].force_n.norm(), 1e-9);
  // Between them, by adding up the pressure along the cuff.
  const LegStatics between = StaticsOf(Bent(20), kMoment_nm, Alike({{200, 80}}));
  const CuffReaction& cuff = between.thigh[0];
  constexpr int kSlices = 100'000;
  double pressed_n = 0;
  for (int i = 0; i < kSlices; ++i) {
    const double at_m = 0.08 * ((i + 0.5) / kSlices - 0.5);
    const double n_per_m = cuff.force_n.x() / 0.08 + 12 * cuff.moment_nm * at_m / std::pow(0.08, 3);
    pressed_n += std::max(0.0, n_per_m) * 0.08 / kSlices;
  }
  EXPECT_NEAR(cuff.pressed_n, std::hypot(pressed_n, cuff.force_n.y()), 1e-5) << "slices of 0.8 µm";
}

// A level thigh with a link of 2 kg half way to its cuff: the cuff bears half of it, the hinge the other half, which
// hangs on the shank's cuff. What is on the thigh presses on the knee.
TEST(LegStatics, TheWeightOfALevelThighsLink) {
  CuffOptions options = Alike({{250, 0}});
  options.thigh_link_kg = 2;
  const LegStatics leg = StaticsOf(Bent(90), 0, options);
  const double weight_n = 2 * 9.80665;
  EXPECT_NEAR(leg.thigh[0].force_n.x(), -weight_n / 2, 1e-9) << "across a level thigh is up";
  EXPECT_NEAR(leg.thigh[0].force_n.y(), 0, 1e-9);
  EXPECT_NEAR(leg.shank[0].force_n.y(), -weight_n / 2, 1e-9);
  EXPECT_NEAR(leg.knee_compression_n, weight_n / 2, 1e-9);
  EXPECT_NEAR(leg.knee_shear_n, 0, 1e-9);
}

Eigen::Matrix2d Axes(double deg) {
  const double a = deg * M_PI / 180;
  Eigen::Matrix2d axes;
  axes << std::cos(a), std::sin(a), -std::sin(a), std::cos(a);
  return axes;
}

// Of a force, forward about the knee, N m; the place up the segment, mm.
double MomentForward(double up_mm, const Vector2d& force_n) {
  return up_mm / 1000 * force_n.x();
}

// Each link is in balance: forces sum to the weight of both, and about the hinge cuffs do what actuator and weight do.
// The knee passes on what the thigh's cuffs do.
TEST(LegStatics, EachFreeBodyIsInBalance) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> some(0, 1);
  for (int draw = 0; draw < 60; ++draw) {
    CuffOptions options;
    const auto cuff = [&](double from_mm) { return Cuff{from_mm + 60 * some(random), 100 * some(random)}; };
    options.thigh = {cuff(180)};
    options.shank = {cuff(180)};
    if (draw % 2) options.thigh.push_back(cuff(60));
    if (draw % 3) options.shank.push_back(cuff(60));
    options.thigh_link_kg = 2 * some(random);
    options.shank_link_kg = 2 * some(random);
    const Posture posture{-100 * some(random), 30 * some(random)};
    const double moment_nm = 80 * some(random) - 20;
    const LegStatics leg = StaticsOf(posture, moment_nm, options);
    const auto check = [&](const std::vector<Cuff>& cuffs, const std::vector<CuffReaction>& reactions, double lean_deg,
                           double side, double mass_kg) {
      Vector2d sum_n = Vector2d::Zero();
      double by_cuffs_nm = 0, outermost_mm = 0;
      for (std::size_t i = 0; i < cuffs.size(); ++i) {
        sum_n += Axes(lean_deg) * reactions[i].force_n;
        by_cuffs_nm += MomentForward(side * cuffs[i].from_knee_mm, reactions[i].force_n) + reactions[i].moment_nm;
        outermost_mm = std::max(outermost_mm, cuffs[i].from_knee_mm);
      }
      const Vector2d weight_n = Axes(lean_deg).transpose() * Vector2d(0, -9.80665 * mass_kg);
      EXPECT_NEAR(by_cuffs_nm, side * moment_nm + MomentForward(side * outermost_mm / 2, weight_n), 1e-9)
          << "seed 11, draw " << draw;
      return sum_n;
    };
    const Vector2d thigh_n = check(options.thigh, leg.thigh, posture.thigh_deg, 1, options.thigh_link_kg);
    const Vector2d shank_n = check(options.shank, leg.shank, posture.shank_deg, -1, options.shank_link_kg);
    const double weight_n = 9.80665 * (options.thigh_link_kg + options.shank_link_kg);
    EXPECT_NEAR((thigh_n + shank_n + Vector2d(0, weight_n)).norm(), 0, 1e-9) << "seed 11, draw " << draw;
    const Vector2d knee_n = Axes(posture.shank_deg).transpose() * thigh_n;
    EXPECT_NEAR(leg.knee_shear_n, std::abs(knee_n.x()), 1e-9);
    EXPECT_NEAR(leg.knee_compression_n, -knee_n.y(), 1e-9);
    // What springs do that hardly yield.
    const LegLoad stiff = LoadOnLeg(
        {.thigh_deg = posture.thigh_deg, .shank_deg = posture.shank_deg, .moment_nm = moment_nm}, options, {1e7, 1e7});
    for (std::size_t i = 0; i < leg.thigh.size(); ++i)
      EXPECT_NEAR((leg.thigh[i].force_n - stiff.thigh[i].force_n).norm(), 0, 0.05)
          << "seed 11, draw " << draw << ": some 1e-4 of 1000 N as links turn";
  }
}

TEST(LegStatics, NoSegmentIsWithoutACuff) {
  CuffOptions options;
  options.thigh.clear();
  EXPECT_THROW(StaticsOf({}, 1, options), UsageError);
}

}  // namespace
}  // namespace lake::cuffs
