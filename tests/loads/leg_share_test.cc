// How often the knee's band without plates holds a leg that bears more or less than half of the weight.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gait/synthetic_leg.h"
#include "lake/core/csv.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "lake/loads/loads.h"
#include "leg_path_of.h"
#include "name_map.h"
#include "places.h"

namespace lake {
namespace {

// A leg's moments on its plate, and what is said of them without it. Another share of the weight is taken to scale the
// moments: what accelerates shank and foot is 3 % of them.
struct LegOnPlate {
  loads::LoadsResult without_plates;
  std::vector<double> time_s, knee_nm;

  explicit LegOnPlate(bool right) {
    const std::filesystem::path folder = SharedData() / "sts_force_plates";
    const exchange::Trial trial = exchange::ReadTrial(
        folder / "STS1.trc",
        {NameMap(right ? "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS,shoulder=R_Shoulder"
                       : "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS,shoulder=L_Shoulder"),
         {},
         "x"});
    const gait::LegFitResult fit = gait::FitLeg(trial.recording, gait::MakeLegView(motion::LengthUnit::kMm, {}));
    loads::LoadsOptions options;
    options.body.mass_kg = 62.6;
    without_plates = loads::FindLoads(fit.trajectory, fit.motion, fit.events, PathOf(fit), options);
    const CsvTable table = CsvTable::Read(folder / "reference_knee_moment.csv");
    const std::size_t column = table.Column(fmt::format("knee_extension_moment_{}_nm", right ? "r" : "l"));
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      time_s.push_back(table.RequiredNumber(row, table.Column("time_s")));
      knee_nm.push_back(table.RequiredNumber(row, column));
    }
  }

  double At(double at_s) const {
    const auto after = std::ranges::lower_bound(time_s, at_s) - time_s.begin();
    return knee_nm[std::min(static_cast<std::size_t>(after), knee_nm.size() - 1)];
  }

  // The part of the rises' moments that the band holds.
  double Held(double share) const {
    int held = 0, count = 0;
    for (const loads::RiseLoads& rise : without_plates.rises)
      for (const loads::LoadsRow& row : rise.rows) {
        if (std::isnan(row.knee_nm)) continue;
        const double true_nm = At(row.time_s) * share / 0.5;
        held += row.knee_low_nm <= true_nm && true_nm <= row.knee_high_nm;
        ++count;
      }
    return static_cast<double>(held) / count;
  }
};

#define REQUIRE_PLATES() \
  if (!std::filesystem::exists(SharedData() / "sts_force_plates")) GTEST_SKIP() << "sts_force_plates is not here"

// Of both legs together. The left one's trunk is read such that its peaks are 43 % too low: beyond 0.65 that and the
// share add up.
TEST(LegShare, AKnownShareIsHeldFromAFifthToTwoThirds) {
  REQUIRE_PLATES();
  const LegOnPlate right(true), left(false);
  for (const double share : {0.2, 0.25, 0.3, 0.35, 0.39, 0.5, 0.61, 0.65, 0.7, 0.75}) {
    const double held = (right.Held(share) + left.Held(share)) / 2;
    EXPECT_GE(held, share <= 0.65 ? 0.9 : 0.87) << share;
    EXPECT_GE(std::min(right.Held(share), left.Held(share)), 0.8) << share;
  }
}

// People whose legs differ: the stronger one's share of the weight, and how much people differ in it.
struct People {
  const char* who;
  double stronger, sd;
};
constexpr People kPeople[] = {
    {"healthy", 0.50, 0.03},              // Burnett et al. 2011, doi 10.1016/j.jelekin.2011.03.006: no difference
    {"knee osteoarthritis", 0.55, 0.05},  // Turcot et al. 2012, doi 10.1016/j.gaitpost.2012.01.005: 10 % more
    // Eng & Chu 2002, doi 10.1053/apmr.2002.33644: 296 and 458 N; standing, people differ by 7.1 % (53 people,
    // PMC4777057: 60.3 % on the better leg).
    {"after a stroke", 0.61, 0.07},
};

TEST(LegShare, LegsOfEachPopulationAreHeldAsOftenAsTheBandSays) {
  REQUIRE_PLATES();
  const LegOnPlate right(true), left(false);
  std::mt19937_64 random(1);
  for (const People& people : kPeople) {
    std::normal_distribution<double> stronger(people.stronger, people.sd);
    double held = 0;
    constexpr int kDraws = 400;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double share = stronger(random);
      held += (draw % 2 ? right : left).Held(draw % 4 < 2 ? share : 1 - share) / kDraws;
    }
    EXPECT_GE(held, 0.9) << people.who;
    EXPECT_LE(held, 0.99) << people.who;
  }
}

// Peaks of drawn rises of one leg: its share is known, the rest drawn.
std::vector<double> DrawnPeaks(const gait::LegFitResult& fit, double trunk_share, loads::LoadsOptions options) {
  options.body.share = trunk_share;
  options.uncertainty.trunk_share = 0;
  options.draws = 2;
  std::vector<double> peaks_nm;
  for (options.seed = 100; options.seed < 140; ++options.seed) {
    const loads::LoadsResult drawn = loads::FindLoads(fit.trajectory, fit.motion, fit.events, PathOf(fit), options);
    // Of two values their 2.5 and 97.5 % lie 2.5 % of the difference inside them.
    const loads::Peak& peak = drawn.rises.front().peak;
    const double beyond_nm = 0.025 / 0.95 * (peak.high_nm - peak.low_nm);
    peaks_nm.push_back(peak.low_nm - beyond_nm);
    peaks_nm.push_back(peak.high_nm + beyond_nm);
  }
  return peaks_nm;
}

TEST(LegShare, DrawnPeaksOfUnevenLegsAreInTheInterval) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1});
  const gait::LegFitResult fit = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 1), ScaledView());
  loads::LoadsOptions options;
  options.body.mass_kg = 70;
  const loads::LoadsResult result = loads::FindLoads(fit.trajectory, fit.motion, fit.events, PathOf(fit), options);
  // A leg bears itself, 0.161 of the body, and none to all of 0.678: 2.5 and 97.5 % of that.
  EXPECT_NEAR(result.weight_share[0], 0.161 + 0.025 * 0.678, 0.02);
  EXPECT_NEAR(result.weight_share[1], 0.161 + 0.975 * 0.678, 0.02);
  const loads::Peak& interval = result.rises.front().peak;
  for (const double weight_share : {0.25, 0.39, 0.5, 0.61, 0.75}) {
    const std::vector<double> peaks_nm = DrawnPeaks(fit, (weight_share - 0.161) / 0.678, options);
    const auto held = std::ranges::count_if(
        peaks_nm, [&](double peak_nm) { return interval.low_nm <= peak_nm && peak_nm <= interval.high_nm; });
    EXPECT_GE(static_cast<double>(held), 0.9 * static_cast<double>(peaks_nm.size())) << weight_share;
  }
  options.uncertainty.trunk_share = 0.025;  // --share is given
  const loads::LoadsResult given = loads::FindLoads(fit.trajectory, fit.motion, fit.events, PathOf(fit), options);
  EXPECT_LT(given.rises.front().peak.high_nm, interval.high_nm);
  EXPECT_NEAR(given.weight_share[1] - given.weight_share[0], 2 * 1.96 * 0.025 * 0.678, 0.02);
}

}  // namespace
}  // namespace lake
