// The intervals of the misalignment's parts: as often around the truth as they say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "closed_form.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/pointwise_error.h"
#include "rising_person.h"

namespace lake {
namespace {

constexpr int kDraws = 60;

struct Truth {
  const char* name;
  compare::StsCurve human, exo;
  double replacement_sd_mm;
};

std::vector<Truth> Truths() {
  const compare::StsCurve human = MakeCurve({});
  Truth placed{"placement alone", human, MakeCurve({}, [](double s) { return s; }, {8, -5}), 0};
  Truth all{"all three", human, MakeCurve({}, IssueWarp, {8, -5}), 0};
  AddShape(1.5, all.exo);
  Truth replaced{"all three, markers put back elsewhere", human, all.exo, 1};
  return {placed, all, replaced};
}

// The trial as it is measured: noise on both knees, the exoskeleton's marker put back elsewhere.
compare::Misalignment Measure(const Truth& truth, unsigned seed) {
  std::mt19937 random(seed);
  compare::StsCurve human = truth.human, exo = truth.exo;
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    exo.knee[i] += compare::ShankAxes(truth.human, i) * truth.replacement_sd_mm * Eigen::Vector2d(x, y);
  AddFilteredNoise(human, random);
  AddFilteredNoise(exo, random);
  compare::MisalignmentOptions options;
  options.resamples = 100;
  options.replacement_sd_mm = truth.replacement_sd_mm;
  return compare::CompareTrials({{human}, {}}, {{exo}, {}}, options);
}

double Rms(const std::vector<Eigen::Vector2d>& vectors) {
  return std::sqrt(compare::MeanSquare(vectors));
}

struct Coverage {
  int held = 0;
  double low = 0, high = 0;  // means

  void Add(const compare::Interval& interval, double truth) {
    held += interval.low <= truth && truth <= interval.high;
    low += interval.low / kDraws;
    high += interval.high / kDraws;
  }
};

TEST(Intervals, OfThePartsHoldTheTruthAsOftenAsTheySay) {
  int all_held = 0, all = 0;
  for (const Truth& truth : Truths()) {
    const compare::Decomposition parts = compare::Decompose(truth.human, truth.exo);
    Coverage placement, timing, shape, x, y, placement_mm, timing_mm, shape_mm;
    for (unsigned seed = 0; seed < kDraws; ++seed) {
      const compare::Misalignment m = Measure(truth, seed);
      placement.Add(m.intervals->placement, parts.placement);
      timing.Add(m.intervals->timing, parts.timing);
      shape.Add(m.intervals->shape, parts.shape);
      placement_mm.Add(m.intervals->placement_mm, Rms(parts.placement_mm));
      timing_mm.Add(m.intervals->timing_mm, Rms(parts.timing_mm));
      shape_mm.Add(m.intervals->shape_mm, Rms(parts.shape_mm));
      x.Add(m.intervals->offset_x_mm, parts.offset_mm.x());
      y.Add(m.intervals->offset_y_mm, parts.offset_mm.y());
    }
    // 95 % of 60 draws are 57 +- 1.7; the resamples are few and the noise of h(w) is drawn as if it were e's, which
    // costs some percent (51 to 58 are reached, 55 in the mean).
    for (const auto& [name, coverage] :
         {std::pair("placement", placement), std::pair("timing", timing), std::pair("shape", shape), std::pair("x", x),
          std::pair("y", y), std::pair("placement, mm", placement_mm), std::pair("timing, mm", timing_mm),
          std::pair("shape, mm", shape_mm)}) {
      EXPECT_GE(coverage.held, 0.8 * kDraws)
          << truth.name << ": " << name << ", " << coverage.low << " to " << coverage.high;
      all_held += coverage.held;
      all += kDraws;
    }
    // Noise is no shape: in the mean the interval lies around what there is without it.
    EXPECT_LE(shape.low, parts.shape) << truth.name;
    EXPECT_GE(shape.high, parts.shape) << truth.name;
  }
  EXPECT_GE(all_held, 0.88 * all);
}

// What an exoskeleton trial differs by.
struct Differences {
  Eigen::Vector2d offset_mm;
  double warp, shape_mm;

  double At(double s) const { return s + warp * std::sin(std::numbers::pi * s); }
};

compare::StsCurve WithDifferences(const Differences& by) {
  compare::StsCurve exo = MakeCurve(
      {}, [&](double s) { return by.At(s); }, by.offset_mm);
  AddShape(by.shape_mm, exo);
  return exo;
}

struct Recordings {
  int repetitions;
  double replacement_sd_mm;
};

// Two trials of a person, the knee's marker put back elsewhere in the second.
compare::Misalignment MeasureRises(const Differences& by, const Recordings& how, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  const Eigen::Vector2d at_mm = by.offset_mm + how.replacement_sd_mm * Eigen::Vector2d(x, y);
  Person person(random);
  compare::RegisteredTrial human, exo;
  for (int repetition = 0; repetition < how.repetitions; ++repetition) {
    human.repetitions.push_back(person.Rise([](double s) { return s; }, {0, 0}, 0));
    exo.repetitions.push_back(person.Rise([&](double s) { return by.At(s); }, at_mm, by.shape_mm));
  }
  compare::MisalignmentOptions options;
  options.resamples = 100;
  options.replacement_sd_mm = how.replacement_sd_mm;
  return compare::CompareTrials(human, exo, options);
}

// The path difference of the joint moved is no member of the others' intervals.
struct Quantity {
  const char* name;
  compare::Interval compare::MisalignmentIntervals::*interval;
  double truth;

  compare::Interval Of(const compare::Misalignment& m) const {
    return interval ? (*m.intervals).*interval : m.joint_moved->intervals->rms_mm;
  }
};

// Of the exoskeleton's path moved onto the knee by the mean of where its joint is.
double TrueRmsWithJointMoved(const Differences& by) {
  const compare::StsCurve human = MakeCurve({}), exo = WithDifferences(by),
                          knee = MakeCurve({}, [&](double s) { return by.At(s); });
  std::vector<Eigen::Vector2d> place, moved;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    place.emplace_back(compare::ShankAxes(knee, i).transpose() * (exo.knee[i] - knee.knee[i]));
  const Eigen::Vector2d sum = std::accumulate(place.begin(), place.end(), Eigen::Vector2d(0, 0)),
                        mean = sum / compare::kPercentSamples;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    moved.emplace_back(exo.knee[i] - compare::ShankAxes(knee, i) * mean);
  return std::sqrt(compare::MeanSquaredDistance(moved, human.knee));
}

double TrueAngleRms(const Differences& by) {
  const compare::StsCurve human = MakeCurve({}), exo = WithDifferences(by);
  double square = 0;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    square += std::pow(exo.knee_deg[i] - human.knee_deg[i], 2) / compare::kPercentSamples;
  return std::sqrt(square);
}

std::vector<Quantity> TrueQuantities(const Differences& by) {
  using Intervals = compare::MisalignmentIntervals;
  const compare::StsCurve human = MakeCurve({}), exo = WithDifferences(by);
  const compare::Decomposition parts = compare::Decompose(human, exo);
  const double square = compare::MeanSquaredDistance(exo.knee, human.knee),
               relative = compare::MeanSquaredMisalignment(exo.knee, human.knee, compare::ShankLengths(human));
  return {{"RMS", &Intervals::rms_mm, std::sqrt(square)},
          {"relative RMS", &Intervals::relative_rms, std::sqrt(relative)},
          {"offset x", &Intervals::offset_x_mm, parts.offset_mm.x()},
          {"offset y", &Intervals::offset_y_mm, parts.offset_mm.y()},
          {"placement", &Intervals::placement_mm, Rms(parts.placement_mm)},
          {"timing", &Intervals::timing_mm, Rms(parts.timing_mm)},
          {"shape", &Intervals::shape_mm, Rms(parts.shape_mm)},
          {"placement's fraction", &Intervals::placement, parts.placement},
          {"timing's fraction", &Intervals::timing, parts.timing},
          {"shape's fraction", &Intervals::shape, parts.shape},
          {"knee angle", &Intervals::knee_rmse_deg, TrueAngleRms(by)},
          {"joint moved", nullptr, TrueRmsWithJointMoved(by)}};
}

TEST(Intervals, OfFewRepetitionsHoldTheTruthAsOftenAsTheySay) {
  constexpr unsigned kPeople = 200;
  const std::vector<Differences> differences = {
      {{8, -5}, 0.05, 1.5}, {{18, 32}, 0.04, 4}, {{-25, 10}, -0.03, 8}, {{40, 15}, 0.08, 5}};
  std::vector<std::vector<Quantity>> truths;
  for (const Differences& by : differences) truths.push_back(TrueQuantities(by));
  for (const Recordings& how : {Recordings{1, 0}, Recordings{1, 3}, Recordings{3, 0}, Recordings{3, 3}}) {
    std::vector<double> held(truths.front().size(), 0);
    for (unsigned person = 0; person < kPeople; ++person) {
      const std::size_t which = person % differences.size();
      const compare::Misalignment m = MeasureRises(differences[which], how, person);
      for (std::size_t i = 0; i < held.size(); ++i) {
        const compare::Interval interval = truths[which][i].Of(m);
        held[i] += interval.low <= truths[which][i].truth && truths[which][i].truth <= interval.high;
      }
    }
    for (std::size_t i = 0; i < held.size(); ++i) {
      const std::string name = truths.front()[i].name;
      SCOPED_TRACE(testing::Message() << name << " of " << how.repetitions << " repetitions, replacement "
                                      << how.replacement_sd_mm << " mm");
      EXPECT_GE(held[i], 0.90 * kPeople);
      // What is below its noise, as a shape and what moving the joint leaves, has an interval from 0, which can miss it
      // at one end alone.
      const bool is_below_noise = name.starts_with("shape") || name == "joint moved";
      EXPECT_LE(held[i], (is_below_noise ? 1 : 0.98) * kPeople);
    }
  }
}

// Of two trials that differ by placement, one rise each.
compare::MisalignmentIntervals IntervalsWith(double event_sd_s, double onset_sd_s, double standing_sd_s) {
  compare::StsCurve human = MakeCurve({}), exo = MakeCurve({}, [](double s) { return s; }, {8, -5});
  human.onset_sd_s = onset_sd_s;
  human.standing_sd_s = standing_sd_s;
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = options.progress_sd_percent = options.lean_sd_deg = 0;
  options.event_sd_s = event_sd_s;
  return *compare::CompareTrials({{human}, {}}, {{exo}, {}}, options).intervals;
}

// The events' times are in the intervals of what is over percent: those that the fit tells and those as defined.
TEST(Intervals, KnowTheUncertaintyOfTheEvents) {
  const auto width = [](const compare::Interval& interval) { return interval.high - interval.low; };
  const compare::MisalignmentIntervals sure = IntervalsWith(0, 0, 0), defined = IntervalsWith(0.05, 0, 0),
                                       onset = IntervalsWith(0, 0.1, 0), standing = IntervalsWith(0, 0, 0.1);
  for (const auto interval : {&compare::MisalignmentIntervals::rms_mm, &compare::MisalignmentIntervals::timing_mm})
    for (const compare::MisalignmentIntervals* unsure : {&defined, &onset, &standing}) {
      EXPECT_GT(width((*unsure).*interval), 2 * width(sure.*interval));
      EXPECT_LE(((*unsure).*interval).low, (sure.*interval).low);
    }
}

// A mean that another comparison wrote, or a predicted path, is no repetition of a person.
TEST(Intervals, OfAMeanAreItsMarkersNoise) {
  compare::StsCurve human = MakeCurve({}), exo = MakeCurve({}, [](double s) { return s; }, {8, -5});
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = 0;
  const auto width = [&] {
    const compare::Interval interval = compare::CompareTrials({{human}, {}}, {{exo}, {}}, options).intervals->rms_mm;
    return interval.high - interval.low;
  };
  EXPECT_GT(width(), 10);
  human.repetition = exo.repetition = 0;
  EXPECT_LT(width(), 0.5);
}

TEST(Intervals, ATrialWithItselfHasNoParts) {
  const compare::StsCurve human = MakeCurve({});
  const compare::Misalignment m = compare::CompareTrials({{human}, {}}, {{human}, {}});
  EXPECT_EQ(m.metrics.rms_mm, 0);
  EXPECT_TRUE(std::isnan(m.decomposition.placement));
  EXPECT_THAT(m.warnings, testing::ElementsAre(testing::HasSubstr("both knee paths are one")));
  const Json parts = compare::ComparisonJson(m)["decomposition"];
  for (const char* part : {"placement", "timing", "shape"}) {
    EXPECT_TRUE(parts[part]["fraction"].is_null()) << part;
    EXPECT_TRUE(parts[part]["interval"].is_null()) << part;
  }
}

}  // namespace
}  // namespace lake
