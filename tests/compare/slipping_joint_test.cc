// A joint that is misplaced and slips a little from rise to rise: nothing else is wrong with it. What intervals must
// hold.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "draws.h"
#include "lake/compare/misalignment.h"
#include "rising_person.h"

namespace lake {
namespace {

using compare::Interval, compare::Misalignment;
using Eigen::Vector2d;

constexpr unsigned kPeople = 100;
constexpr double kSlip_mm = 3;  // of a rise, along each axis
const Vector2d kPlace_mm(10, -5);

struct Slipping {
  int repetitions;
  double replacement_sd_mm = 0;
};

// A person's two trials. The knee's marker is put back elsewhere for the second one.
Misalignment Measure(const Slipping& how, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sd_mm) {
    const double x = normal(random), y = normal(random);
    return Vector2d(sd_mm * x, sd_mm * y);
  };
  const auto as_it_is = [](double s) { return s; };
  Person person(random);
  const Vector2d seen_mm = kPlace_mm + draw(how.replacement_sd_mm);
  compare::RegisteredTrial human, exo;
  for (int repetition = 0; repetition < how.repetitions; ++repetition) {
    human.repetitions.push_back(person.Rise(as_it_is, {0, 0}, 0));
    exo.repetitions.push_back(person.Rise(as_it_is, seen_mm + draw(kSlip_mm), 0));
  }
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = how.replacement_sd_mm;
  return compare::CompareTrials(human, exo, options);
}

struct SlipCoverage {
  double held = 0, given = 0;

  void Add(const Interval& interval, double truth) {
    if (std::isnan(interval.low) || std::isnan(interval.high)) return;
    ++given;
    held += interval.low <= truth && truth <= interval.high;
  }
  double Share() const { return held / given; }
};

// What is left at the next donning, of a joint that is moved by the mean over n rises: that mean's error, slip /
// sqrt(n) and how the marker was put back, and the slip of the next time, each along both axes. Reported is how the
// place varies within the mean rise, 0.3 mm at most; right is the root sum of squares, of which one rise alone shows no
// part.
TEST(SlippingJoint, WhatMovingItLeavesIsThatOfTheNextDonning) {
  for (const Slipping& how : {Slipping{2}, Slipping{3}, Slipping{3, 3}}) {
    SlipCoverage remainder;
    double sum_of_squares = 0;
    for (unsigned seed = 0; seed < kPeople; ++seed) {
      const Misalignment m = Measure(how, seed);
      const double along_an_axis = std::hypot(kSlip_mm * std::sqrt(1 + 1.0 / how.repetitions), how.replacement_sd_mm);
      remainder.Add(m.joint->intervals->remainder_mm, std::numbers::sqrt2 * along_an_axis);
      sum_of_squares += std::pow(m.joint->remainder_mm / (std::numbers::sqrt2 * along_an_axis), 2);
    }
    SCOPED_TRACE(testing::Message() << how.repetitions << " repetitions, replacement " << how.replacement_sd_mm);
    EXPECT_EQ(remainder.given, kPeople);
    EXPECT_GE(remainder.Share(), 0.85);
    EXPECT_NEAR(std::sqrt(sum_of_squares / kPeople), 1, 0.15);
  }
}

// The interval of the headline knows of the slip, whatever the number of rises; of one there is none.
TEST(SlippingJoint, ItsMisalignmentIsThatOfManyRises) {
  EXPECT_FALSE(Measure({1}, 0).joint->intervals);
  for (const int repetitions : {2, 5}) {
    SlipCoverage rms, x, y;
    for (unsigned seed = 0; seed < Draws(50, kPeople); ++seed) {
      const Misalignment m = Measure({repetitions}, seed);
      ASSERT_TRUE(m.joint->intervals);
      rms.Add(m.joint->intervals->rms_mm, kPlace_mm.norm());
      x.Add(m.joint->intervals->mean_x_mm, kPlace_mm.x());
      y.Add(m.joint->intervals->mean_y_mm, kPlace_mm.y());
    }
    SCOPED_TRACE(testing::Message() << repetitions << " repetitions");
    for (const SlipCoverage& coverage : {rms, x, y}) EXPECT_GE(coverage.held, 0.85 * coverage.given);
  }
}

// The interval of the two trials' path difference is hardly wider than it has to be: of 200 people 99, 98.5 and 97 %
// were held. What is known of people adds to a single rise's.
TEST(SlippingJoint, ThePathDifferencesIntervalIsNotTooWide) {
  for (const int repetitions : {1, 3, 5}) {
    SlipCoverage rms;
    for (unsigned seed = 0; seed < 200; ++seed)
      rms.Add(Measure({repetitions}, seed).intervals->rms_mm, kPlace_mm.norm());
    EXPECT_GE(rms.Share(), 0.85) << repetitions;
    EXPECT_LE(rms.Share(), 0.99) << repetitions;
  }
}

// Nothing but placement: its fraction is 1, the others' are 0. How a person's pace varies from rise to rise looks like
// timing, so that few repetitions cannot tell the parts: below four they have no interval.
TEST(SlippingJoint, IsPlacementAndNoTiming) {
  for (const int repetitions : {1, 3}) {
    const Misalignment m = Measure({repetitions}, 1);
    EXPECT_FALSE(m.part_intervals) << repetitions;
    EXPECT_TRUE(compare::ComparisonJson(m)["parts_mm"].is_null()) << repetitions;
  }
  for (const int repetitions : {4, 6}) {
    SlipCoverage placement, timing, x, y, timing_mm;
    for (unsigned seed = 0; seed < kPeople; ++seed) {
      const Misalignment m = Measure({repetitions}, seed);
      placement.Add(m.part_intervals->fraction[0], 1);
      timing.Add(m.part_intervals->fraction[1], 0);
      timing_mm.Add(m.part_intervals->rms_mm[1], 0);
      x.Add(m.part_intervals->offset_x_mm, kPlace_mm.x());
      y.Add(m.part_intervals->offset_y_mm, kPlace_mm.y());
    }
    SCOPED_TRACE(testing::Message() << repetitions << " repetitions");
    for (const SlipCoverage& coverage : {placement, timing, timing_mm, x, y}) EXPECT_GE(coverage.Share(), 0.85);
  }
}

}  // namespace
}  // namespace lake
