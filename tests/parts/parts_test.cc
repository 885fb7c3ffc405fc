// The stacking order: what it keeps apart, held against outlines sampled independently of how it was found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/parts/mechanism.h"
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

}  // namespace
}  // namespace lake
