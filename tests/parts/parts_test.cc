// Plates and their masses, the stack and its pins, stresses and buckling.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"
#include "lake/parts/mechanism.h"
#include "lake/parts/plate.h"
#include "lake/parts/strength.h"
#include "linkage/random_links.h"
#include "published_links.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using parts::Body;
using parts::Joint;
using ::testing::ThrowsMessage;

parts::Mechanism Make(const linkage::Links& links, double d_min_mm, const parts::PartOptions& options = {}) {
  return parts::MakeMechanism(links, linkage::FindUsedRange(links, d_min_mm, {}), options);
}

// Points of a body's outline in the thigh frame.
std::vector<Vector2d> OutlinePoints(const parts::Mechanism& mechanism, Body body, const linkage::Pose& pose) {
  std::vector<Vector2d> points;
  for (const parts::OutlinePiece& piece : parts::OutlineOf(mechanism.plates[static_cast<std::size_t>(body)]))
    for (int i = 0; i < 40; ++i) {
      const double t = i / 40.0;
      const double angle = piece.from_rad + t * (piece.to_rad - piece.from_rad);
      const double radius = (piece.from - piece.centre).norm();
      const Vector2d at = piece.is_arc ? Vector2d(piece.centre + radius * Vector2d(std::cos(angle), std::sin(angle)))
                                       : Vector2d(piece.from + t * (piece.to - piece.from));
      points.push_back(parts::PlacementOf(body, pose) * at);
    }
  return points;
}

// In each of many poses, every plate whose layer a pin crosses leaves the pin alone.
void ExpectPinsClear(const parts::Mechanism& mechanism) {
  for (int i = 0; i <= 60; ++i) {
    const linkage::Pose pose = linkage::RequirePose(
        mechanism.links, mechanism.range.stroke.lower_mm + i / 60.0 * mechanism.range.stroke.Travel());
    for (const parts::Pin& pin : mechanism.stack.pins)
      for (std::size_t body = 0; body < parts::kPlates; ++body) {
        const parts::Span& plate = mechanism.stack.span[body];
        const bool crosses = pin.span.from_mm < plate.from_mm && pin.span.to_mm > plate.to_mm;
        const bool joined = std::count(pin.bodies.begin(), pin.bodies.end(), static_cast<Body>(body)) > 0;
        if (!crosses || joined) continue;
        double nearest = HUGE_VAL;
        for (const Vector2d& point : OutlinePoints(mechanism, static_cast<Body>(body), pose))
          nearest = std::min(nearest, (point - parts::PlaceOf(pin.joint, pose)).norm());
        EXPECT_GT(nearest, 6 + 1) << parts::LetterOf(pin.joint) << " through " << mechanism.plates[body].name << " at "
                                  << pose.stroke_mm << " mm";
      }
  }
}

TEST(Stack, OfThePublishedDesignKeepsAllApart) {
  const parts::Mechanism mechanism = Make(kPublishedLinks, 242);
  EXPECT_THAT(mechanism.stack.conflicts, ::testing::IsEmpty());
  ExpectPinsClear(mechanism);
  // All share a pin with a neighbour in the plane, so no two plates lie in one layer but those that never meet.
  for (std::size_t a = 0; a < parts::kBodies; ++a)
    for (std::size_t b = a + 1; b < parts::kBodies; ++b) {
      const parts::Span &one = mechanism.stack.span[a], &other = mechanism.stack.span[b];
      EXPECT_TRUE(one.to_mm + 2 <= other.from_mm + 1e-9 || other.to_mm + 2 <= one.from_mm + 1e-9) << a << " " << b;
    }
}

// The knee pin between thigh plate and shank link is met by the slewing bar, which passes over it when standing: an
// order that puts the bar between them is refused, so the two are neighbours.
TEST(Stack, PutsNothingBetweenThighAndShankThatSweepsTheKneePin) {
  const parts::Mechanism mechanism = Make(kPublishedLinks, 242);
  const auto& layer = mechanism.stack.layer;
  const auto between = [&](Body body) {
    const int at = layer[static_cast<std::size_t>(body)];
    const auto [low, high] = std::minmax(layer[0], layer[1]);
    return at > low && at < high;
  };
  EXPECT_FALSE(between(Body::kBar));
  EXPECT_FALSE(between(Body::kCoupler));
  const linkage::Pose standing = linkage::RequirePose(kPublishedLinks, mechanism.range.stroke.upper_mm);
  EXPECT_LT(parts::DistanceBetween(mechanism, Joint::kKnee, Body::kBar, standing), 0);
}

TEST(Stack, SpacersAndPlatesFillEachPin) {
  testing::RandomLinks random;
  for (int i = 0; i < 5; ++i) {
    const linkage::Links links = i == 0 ? kPublishedLinks : random.Next();
    const double from_mm = i == 0 ? 242 : linkage::AssemblyRanges(links).front().lower_mm + 1;
    parts::PartOptions options;
    options.thickness_mm = random.Uniform(2, 8);
    parts::Mechanism mechanism;
    try {
      mechanism = Make(links, from_mm, options);
    } catch (const Error&) {
      continue;  // no range from there on
    }
    for (const parts::Pin& pin : mechanism.stack.pins) {
      double filled = 2 * options.gap_mm;
      for (const Body body : pin.bodies) filled += mechanism.stack.span[static_cast<std::size_t>(body)].Length();
      for (const parts::Spacer& spacer : mechanism.stack.spacers)
        if (spacer.joint == pin.joint) filled += spacer.span.Length();
      EXPECT_NEAR(filled, pin.span.Length(), 1e-9) << testing::TextOf(links);
    }
  }
}

// Between poses that the search looks at nothing moves farther than it adds to the clearance.
TEST(Stack, SweepsInSmallSteps) {
  const parts::Mechanism mechanism = Make(kPublishedLinks, 242);
  const std::vector<double> strokes = parts::SweepStrokes(mechanism);
  EXPECT_EQ(strokes.front(), mechanism.range.stroke.lower_mm);
  EXPECT_EQ(strokes.back(), mechanism.range.stroke.upper_mm);
  for (std::size_t i = 1; i < strokes.size(); ++i) {
    const linkage::Pose from = linkage::RequirePose(kPublishedLinks, strokes[i - 1]);
    const linkage::Pose to = linkage::RequirePose(kPublishedLinks, strokes[i]);
    EXPECT_LE((from.tip - to.tip).norm(), parts::kSweepStep_mm);
    EXPECT_LE((from.shank_pin - to.shank_pin).norm(), parts::kSweepStep_mm);
  }
}

// Plates far too wide for the links meet whatever the order.
TEST(Stack, SaysWhatNoOrderKeepsApart) {
  parts::PartOptions options;
  options.bar_width_mm = 110;
  const parts::Mechanism mechanism = Make(kPublishedLinks, 242, options);
  ASSERT_FALSE(mechanism.stack.conflicts.empty());
  EXPECT_THAT(mechanism.stack.conflicts,
              ::testing::Each(::testing::ContainsRegex("meet between [0-9.]+° and [0-9.]+°")));
}

TEST(PartList, HasEveryPartWithItsMass) {
  const parts::Mechanism mechanism = Make(kPublishedLinks, 242);
  double plates_g = 0;
  int pins = 0;
  for (const parts::PartRow& row : parts::PartList(mechanism)) {
    if (row.part.starts_with("pin")) {
      ++pins;
      EXPECT_NEAR(*row.mass_g, M_PI * 16 * *row.length_mm * 7.85e-3, 1e-9);
    }
    if (row.material == "6061-T6") plates_g += *row.mass_g;
  }
  EXPECT_EQ(pins, 5);
  for (const parts::Plate& plate : mechanism.plates) plates_g -= 1000 * parts::MassOf(plate).mass_kg;
  EXPECT_NEAR(plates_g, 0, 1e-9);
}

TEST(PartOptions, RefuseWhatCannotBeMade) {
  EXPECT_NO_THROW(parts::PartOptions().Check());
  const auto refuses = [](double parts::PartOptions::*field, double value, const char* message) {
    parts::PartOptions options;
    options.*field = value;
    EXPECT_THAT([&] { options.Check(); }, ThrowsMessage<Error>(::testing::HasSubstr(message)));
  };
  refuses(&parts::PartOptions::bar_width_mm, 6, "a pin of 8 mm does not fit");
  refuses(&parts::PartOptions::bar_width_mm, 0, "a plate width of 0 mm cannot be cut");
  refuses(&parts::PartOptions::thickness_mm, 0, "a plate thickness of 0 mm");
  refuses(&parts::PartOptions::thickness_mm, NAN, "a plate thickness of nan mm");
  refuses(&parts::PartOptions::bore_clearance_mm, 50, "a bore of 58 mm does not fit");
  refuses(&parts::PartOptions::cuff_hole_diameter_mm, -1, "a cuff's hole of -1 mm");
  refuses(&parts::PartOptions::actuator_eye_mm, 500, "an actuator's eye of 500 mm must be within its diameter");
  refuses(&parts::PartOptions::rod_diameter_mm, 500, "a rod of 500 mm does not fit");
  refuses(&parts::PartOptions::cuff_hole_spacing_mm, 1, "cannot be 1 mm apart");
  EXPECT_THAT([] { parts::MaterialOf("cheese"); },
              ThrowsMessage<Error>(::testing::HasSubstr("no material 'cheese': there are 6061-T6")));
}

// Outline, area and inertia of plates, by hand and against sums over a fine grid.

parts::Plate BarOf(double length, double radius) {
  parts::Plate plate;
  plate.corners = {{0, 0}, {length, 0}};
  plate.radius_mm = radius;
  plate.thickness_mm = 4;
  plate.density_kg_m3 = 2700;
  return plate;
}

TEST(Plates, OutlineIsClosedSmoothAndAnticlockwise) {
  parts::Plate plate = BarOf(60, 12);
  plate.corners = {{0, 0}, {118, 343}, {0, 56}};
  const auto outline = parts::OutlineOf(plate);
  ASSERT_EQ(outline.size(), 6u);
  double turn = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const parts::OutlinePiece& next = outline[(i + 1) % outline.size()];
    EXPECT_NEAR((outline[i].to - next.from).norm(), 0, 1e-12);
    if (outline[i].is_arc) {
      EXPECT_GT(outline[i].to_rad, outline[i].from_rad);
      turn += outline[i].to_rad - outline[i].from_rad;
    }
  }
  EXPECT_NEAR(turn, 2 * std::numbers::pi, 1e-12);
}

// A stadium with two holes by hand.
TEST(Plates, MassOfABar) {
  parts::Plate plate = BarOf(60, 12);
  const double stadium = 60 * 24 + std::numbers::pi * 144;
  EXPECT_NEAR(parts::MassOf(plate).area_mm2, stadium, 1e-10);
  // About its own centre: a rectangle, and two half discs as one disc pulled apart by 60 mm.
  const double disc = std::numbers::pi * 144, half_disc_offset = 30;
  const double xx = 60 * std::pow(24, 3) / 12 + disc * 144 / 4;
  const double half_centroid = 4 * 12 / (3 * std::numbers::pi);
  const double yy = 24 * std::pow(60, 3) / 12 + disc * 144 / 4 + disc * half_disc_offset * half_disc_offset +
                    2 * disc * half_disc_offset * half_centroid;
  const parts::PlateMass mass = parts::MassOf(plate);
  const double per_area = 2700 * 4 * 1e-9;
  EXPECT_NEAR(mass.mass_kg, stadium * per_area, 1e-12);
  EXPECT_NEAR((mass.centre_mm - Vector2d(30, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(mass.zz_kg_mm2, (xx + yy) * per_area, 1e-9);
  EXPECT_NEAR(mass.xx_kg_mm2, xx * per_area + mass.mass_kg * 16 / 12, 1e-9);
  EXPECT_NEAR(mass.xy_kg_mm2, 0, 1e-12);

  plate.holes = {{{0, 0}, 8}, {{60, 0}, 8}};
  EXPECT_NEAR(parts::MassOf(plate).area_mm2, stadium - 2 * std::numbers::pi * 16, 1e-10);
}

// A triangle with one hole against a sum over squares of 0.1 mm: the outline is 0.05 mm uncertain along 250 mm.
TEST(Plates, MassOfATriangleAgainstAGrid) {
  parts::Plate plate = BarOf(1, 8);
  plate.corners = {{0, 0}, {60, 20}, {10, 70}};
  plate.holes = {{{10, 60}, 9}};
  const auto inside = [&](const Vector2d& point) {
    if ((point - Vector2d(10, 60)).norm() < 4.5) return false;
    bool in = true;
    double nearest = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector2d a = plate.corners[i], side = plate.corners[(i + 1) % 3] - a, to = point - a;
      in = in && side.x() * to.y() - side.y() * to.x() >= 0;
      nearest = std::min(nearest, (to - std::clamp(to.dot(side) / side.squaredNorm(), 0.0, 1.0) * side).norm());
    }
    return in || nearest < 8;
  };
  constexpr double kStep = 0.1;
  double area = 0, xx = 0, yy = 0, xy = 0;
  Vector2d first(0, 0);
  for (double x = -8 + kStep / 2; x < 68; x += kStep)
    for (double y = -8 + kStep / 2; y < 78; y += kStep) {
      if (!inside({x, y})) continue;
      constexpr double kArea = kStep * kStep;
      area += kArea;
      first += kArea * Vector2d(x, y);
      xx += kArea * y * y;
      yy += kArea * x * x;
      xy += kArea * x * y;
    }
  const parts::PlateMass mass = parts::MassOf(plate);
  const double per_area = 2700 * 4 * 1e-9;
  const Vector2d centre = first / area;
  constexpr double kRelative = 1e-3;
  EXPECT_NEAR(mass.area_mm2, area, kRelative * area);
  EXPECT_NEAR((mass.centre_mm - centre).norm(), 0, 0.02);
  const double zz = xx + yy - area * centre.squaredNorm(), product = xy - area * centre.x() * centre.y();
  EXPECT_NEAR(mass.zz_kg_mm2, zz * per_area, kRelative * zz * per_area);
  EXPECT_NEAR(mass.xy_kg_mm2, -product * per_area, kRelative * zz * per_area);
}

// Stresses and buckling by hand.

// The check pose of libs/design/linkage/README.md: 72 N m put 1000 N on actuator and coupler, nothing on the bar.
class CheckPose : public ::testing::Test {
 protected:
  CheckPose() {
    const linkage::Links links{60, 72, 60, 72, 72, 240};
    mechanism_ = parts::MakeMechanism(links, linkage::FindUsedRange(links, 200, {}), {});
    const linkage::Pose pose = linkage::RequirePose(links, 240);
    poses_ = {{pose, 36, linkage::MemberForcesOf(pose, 36)}, {pose, 72, linkage::MemberForcesOf(pose, 72)}};
  }

  parts::StrengthCheck Find(std::string_view part, std::string_view check) const {
    for (const parts::StrengthCheck& found : parts::CheckStrength(mechanism_, poses_))
      if (found.part == part && found.check == check) return found;
    ADD_FAILURE() << "no check " << check << " of " << part;
    return {};
  }

  parts::Mechanism mechanism_;
  std::vector<parts::LoadedPose> poses_;
};

TEST_F(CheckPose, StressesByHand) {
  EXPECT_NEAR(*Find("coupler", "bearing at R and S").stress_mpa, 1000.0 / (8 * 4), 1e-9);
  EXPECT_NEAR(*Find("coupler", "net section").stress_mpa, 1000.0 / ((24 - 8.1) * 4), 1e-9);
  EXPECT_NEAR(Find("coupler", "net section").Safety(), 240 * (24 - 8.1) * 4 / 1000, 1e-9);  // 6061-T6
  EXPECT_NEAR(*Find("thigh plate", "bearing at M").stress_mpa, 1000.0 / 32, 1e-9);
  const double second_moment = 4 * (24 * 24 * 24 - 8.1 * 8.1 * 8.1) / 12;
  EXPECT_NEAR(*Find("shank link", "bending at S").stress_mpa, 72000 * 12 / second_moment, 1e-9);
  EXPECT_NEAR(Find("shank link", "bending at S").load, 72, 1e-12);  // the worse of the two poses
}

// A steel rod of 10 mm, pinned, 240 mm long: pi^2 210 GPa x 490.87 mm^4 / (240 mm)^2.
TEST_F(CheckPose, EulersLoadByHand) {
  const parts::StrengthCheck rod = Find("actuator", "buckling of the rod");
  EXPECT_NEAR(rod.allowed, M_PI * M_PI * 210000 * 490.8739 / (240 * 240), 0.1);
  EXPECT_NEAR(rod.load, 1000, 1e-9);
  EXPECT_FALSE(rod.stress_mpa);
}

TEST_F(CheckPose, ARodThatPullsDoesNotBuckle) {
  for (parts::LoadedPose& pose : poses_) pose.forces = linkage::MemberForcesOf(pose.pose, -pose.knee_torque_nm);
  for (const parts::StrengthCheck& check : parts::CheckStrength(mechanism_, poses_)) EXPECT_NE(check.part, "actuator");
}

// In a wide bar the pins bear least, in a narrow one the section beside the holes.
TEST(Capacity, IsThatOfTheWeakestCheck) {
  const linkage::Links links{60, 72, 60, 72, 72, 240};
  const linkage::Pose pose = linkage::RequirePose(links, 240);
  const parts::LoadedPose loaded{pose, 50, {.actuator_n = 300, .coupler_n = 500, .bar_n = 400}};
  for (const double width_mm : {24.0, 14.0}) {
    parts::PartOptions options;
    options.bar_width_mm = width_mm;
    const parts::Capacity capacity = parts::CapacityOf(options);
    const std::pair<const char*, double> expected[] = {{"coupler", capacity.coupler_n / 500},
                                                       {"bar", capacity.bar_n / 400},
                                                       {"actuator", capacity.rod_nmm2 / (240.0 * 240) / 300}};
    const std::vector<parts::StrengthCheck> checks = parts::CheckStrength(
        parts::MakeMechanism(links, linkage::FindUsedRange(links, 200, {}), options), {&loaded, 1});
    for (const auto& [part, safety] : expected) {
      double least = INFINITY;
      for (const parts::StrengthCheck& check : checks)
        if (check.part == part) least = std::min(least, check.Safety());
      EXPECT_NEAR(safety, least, 1e-9 * least) << part << ", " << width_mm << " mm wide";
    }
    for (const parts::StrengthCheck& check : checks) {
      if (check.check == "bearing at M") {
        EXPECT_NEAR(check.allowed, capacity.actuator_n, 1e-9);
      }
      if (check.check == "bending at S") {
        EXPECT_NEAR(check.allowed, capacity.knee_torque_nm, 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace lake
