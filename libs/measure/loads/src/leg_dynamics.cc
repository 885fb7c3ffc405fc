#include "lake/loads/leg_dynamics.h"

#include <array>
#include <vector>

#include "lake/core/cross.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/plausible.h"
#include "lake/core/statistics.h"

namespace lake::loads {
namespace {

using Eigen::Vector2d;

double MeanLength(const LegPath& path, Joint lower, Joint upper) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < path.frames.size(); ++i)
    if (path.known[i]) lengths.push_back((path.frames[i][upper].position_m - path.frames[i][lower].position_m).norm());
  if (lengths.empty())
    throw Fail("loads: '{}' and '{}' are never known together", path.names[lower], path.names[upper]);
  return Mean(lengths);
}

SegmentInertia InertiaOf(const SegmentShare& share, double mass_kg, double length_m) {
  return {share.mass * mass_kg, share.centre * length_m, share.gyration * length_m};
}

// A segment between two joints, its centre on the line between them.
Body SegmentBody(const SegmentInertia& inertia, const PointMotion& lower, const PointMotion& upper) {
  const SegmentMotion motion = SegmentBetween(lower, upper);
  const double from_upper = inertia.centre_m / motion.length_m;
  return {inertia.mass_kg, inertia.mass_kg * inertia.gyration_m * inertia.gyration_m,
          (1 - from_upper) * upper.position_m + from_upper * lower.position_m,
          (1 - from_upper) * upper.acceleration_m_s2 + from_upper * lower.acceleration_m_s2,
          -motion.tilt_acceleration_rad_s2};
}

// The foot stands still.
Body FootBody(const LegPoints& points, const LegBody& body) {
  return {body.foot.mass_kg, body.foot.mass_kg * body.foot.gyration_m * body.foot.gyration_m,
          points[kAnkle].position_m + Vector2d(body.foot.centre_m, -body.ankle_height_m / 2), Vector2d::Zero(), 0};
}

}  // namespace

void BodyOptions::Check() const {
  if (mass_kg == 0) throw UsageError("--mass is missing: the person's mass in kg, with what is worn");
  // The person belongs to the recording: no wrong usage, but an input that cannot be.
  if (!kPlausibleMass.Holds(mass_kg)) throw Error(ImplausibleText("--mass", mass_kg, kPlausibleMass));
  if (height_mm && !kPlausibleStature.Holds(*height_mm))
    throw Error(ImplausibleText("--height", *height_mm, kPlausibleStature));
  if (!(share > 0 && share <= 1)) throw UsageError("--share {}: of the trunk's weight, above 0 and at most 1", share);
  if (sex && anthropometry != kDeLeva)
    throw UsageError(
        "--sex has no effect on the table '{}', which is the same for both: leave it out, or give --anthropometry {}",
        anthropometry, kDeLeva);
  if (!foot_mm) return;
  const auto [heel_mm, toe_mm] = *foot_mm;
  if (!(heel_mm >= 0 && toe_mm > 0 && heel_mm + toe_mm >= 100 && heel_mm + toe_mm <= 500))
    throw UsageError("--foot {},{}: mm behind and before the ankle, neither negative, together 100 to 500", heel_mm,
                     toe_mm);
}

void Describe(BodyOptions& o, OptionList& options) {
  options.Add("mass", o.mass_kg, "The person's mass, with what is worn").Unit("kg").Required();
  options.Add("height", o.height_mm, "The person's stature").Unit("mm").Otherwise("from the leg's length");
  options.AddChoice("sex", o.sex, OptionList::Choices<Sex>{{"male", Sex::kMale}, {"female", Sex::kFemale}},
                    "Which of the tables that differ by sex (deleva)");
  options.Add("anthropometry", o.anthropometry, "Table of the segments' masses, or a YAML file with one")
      .Value("winter|deleva|FILE");
  options.Add("share", o.share, "Share of head, arms and trunk that this leg bears");
  options.Add("foot", o.foot_mm, "How far heel and toe are behind and before the ankle")
      .Unit("mm")
      .Value("HEEL,TOE")
      .Otherwise("from the stature");
  options.Check([&o](const OptionList&) { o.Check(); });
}

LegBody MakeLegBody(const BodyOptions& options, const LegPath& path) {
  options.Check();
  const Anthropometry table = FindAnthropometry(options.anthropometry, options.sex);
  const double shank_m = MeanLength(path, kAnkle, kKnee), thigh_m = MeanLength(path, kKnee, kHip),
               trunk_m = MeanLength(path, kHip, kTrunkTop);
  LegBody body;
  body.table = table.name;
  body.source = table.source;
  body.height_m = options.height_mm ? *options.height_mm / kMmPerM : StatureOfLeg(shank_m + thigh_m);
  body.sole = FootOfStature(body.height_m);
  if (options.foot_mm) body.sole = {(*options.foot_mm)[0] / kMmPerM, (*options.foot_mm)[1] / kMmPerM};
  body.ankle_height_m = AnkleHeightOfStature(body.height_m);
  body.foot = InertiaOf(table.foot, options.mass_kg, body.sole.Length());
  body.foot.centre_m -= body.sole.heel_m;
  body.shank = InertiaOf(table.shank, options.mass_kg, shank_m);
  body.thigh = InertiaOf(table.thigh, options.mass_kg, thigh_m);
  body.trunk = InertiaOf(table.trunk, options.mass_kg * options.share,
                         path.has_shoulder ? trunk_m : TrunkOfStature(body.height_m));
  return body;
}

Displacement FixedInTrunk(const SegmentMotion& trunk, double along_m, double across_m) {
  const double turn2 = trunk.tilt_rate_rad_s * trunk.tilt_rate_rad_s, turning = trunk.tilt_acceleration_rad_s2;
  return {along_m * trunk.along + across_m * trunk.across,
          along_m * (turning * trunk.across - turn2 * trunk.along) +
              across_m * (-turning * trunk.along - turn2 * trunk.across)};
}

Vector2d GroundPoint(const LegPoints& points, const LegBody& body) {
  return points[kAnkle].position_m - Vector2d(0, body.ankle_height_m);
}

Body TrunkBody(const LegPoints& points, const LegBody& body, const Displacement& displacement) {
  const SegmentMotion motion = SegmentBetween(points[kHip], points[kTrunkTop]);
  const Displacement centre = FixedInTrunk(motion, body.trunk.centre_m, 0);
  return {body.trunk.mass_kg, body.trunk.mass_kg * body.trunk.gyration_m * body.trunk.gyration_m,
          points[kHip].position_m + centre.value_m + displacement.value_m,
          points[kHip].acceleration_m_s2 + centre.acceleration_m_s2 + displacement.acceleration_m_s2,
          -motion.tilt_acceleration_rad_s2};
}

Wrench WrenchChange(const Body& trunk, const Displacement& change, const Vector2d& about_m) {
  const Vector2d force_per_kg = trunk.acceleration_m_s2 + kGravity_m_s2 * Vector2d::UnitY();
  return {trunk.mass_kg * change.acceleration_m_s2,
          trunk.mass_kg *
              (Cross(change.value_m, force_per_kg) + Cross(trunk.centre_m - about_m, change.acceleration_m_s2))};
}

LegLoads LoadsFromTrunk(const LegPoints& points, const LegBody& body, const Displacement& displacement) {
  const std::array<Body, 4> bodies = {TrunkBody(points, body, displacement),
                                      SegmentBody(body.thigh, points[kKnee], points[kHip]),
                                      SegmentBody(body.shank, points[kAnkle], points[kKnee]), FootBody(points, body)};
  const auto above = [&](std::size_t count, Joint joint) {
    return RequiredWrench(std::span(bodies).first(count), points[joint].position_m).moment_nm;
  };
  const Wrench ground = RequiredWrench(bodies, GroundPoint(points, body));
  return {.moments = {above(3, kAnkle), -above(2, kKnee), above(1, kHip)},
          .ground_force_n = ground.force_n,
          .zmp_m = ground.moment_nm / ground.force_n.y()};
}

LegLoads LoadsFromGround(const LegPoints& points, const LegBody& body, const Wrench& ground) {
  const std::array<Body, 3> bodies = {FootBody(points, body), SegmentBody(body.shank, points[kAnkle], points[kKnee]),
                                      SegmentBody(body.thigh, points[kKnee], points[kHip])};
  // What the segments below a joint need, less what the ground gives, comes from above: the joint passes the opposite
  // up.
  const auto below = [&](std::size_t count, Joint joint) {
    const Vector2d& at = points[joint].position_m;
    return About(ground, Vector2d::Zero(), at).moment_nm - RequiredWrench(std::span(bodies).first(count), at).moment_nm;
  };
  return {.moments = {below(1, kAnkle), -below(2, kKnee), below(3, kHip)},
          .ground_force_n = ground.force_n,
          .zmp_m = About(ground, Vector2d::Zero(), GroundPoint(points, body)).moment_nm / ground.force_n.y()};
}

}  // namespace lake::loads
