#include "lake/synthesis/synthesis_outcome.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lake/commands/optimize_tables.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/linkage/design_file.h"
#include "paper.h"
#include "temporary_folder.h"

namespace lake {
namespace {

synthesis::SynthesisOptions FewStarts() {
  synthesis::SynthesisOptions options;
  options.optimize.starts = 3;
  return options;
}

struct Written {
  TemporaryFolder folder;
  Json summary;
};

std::unique_ptr<Written> RunAndWrite(const problem::SynthesisProblem& problem,
                                     const synthesis::SynthesisOptions& options) {
  auto written = std::make_unique<Written>();
  Run run({"lake-optimize", "lake-optimize", Json::object(), written->folder.Path(), true});
  written->summary = commands::WriteSynthesis(synthesis::RunSynthesis(problem, options), run);
  return written;
}

TEST(SynthesisOutcome, TablesAgreeWithTheSummary) {
  synthesis::SynthesisOptions options = FewStarts();
  options.certify_gap_deg = 0.1;
  options.yield_tolerance_mm = 0.1;
  options.round_mm = 0.5;
  problem::SynthesisProblem problem = WithMargins(2);
  problem.parts.bar_width_mm = 28;
  problem.clearances.body.height_mm = 1700;
  problem.knee_torque_nm = 25;
  const auto written = RunAndWrite(problem, options);
  const Json& summary = written->summary;
  EXPECT_EQ(summary["status"], "solved");
  EXPECT_LE(summary["constraint_violation"].get<double>(), 1e-6);
  EXPECT_LE(summary["kkt_error"].get<double>(), 1e-6);
  const double range = summary["range_deg"];
  EXPECT_LE(summary["certified_upper_bound_deg"].get<double>() - range, 0.1);
  for (const char* clock : {"seconds", "time_s"}) EXPECT_FALSE(summary["certificate"].contains(clock)) << clock;

  const linkage::Design design = linkage::ReadDesign(written->folder / "design.yaml");
  EXPECT_EQ(*design.range_deg, range);
  EXPECT_EQ(design.parts, Json({{"bar_width_mm", "28"}}));
  EXPECT_EQ(design.body, Json({{"height_mm", "1700"}}));
  EXPECT_EQ(design.load, Json({{"knee_torque_nm", "25"}}));
  const CsvTable optimum = CsvTable::Read(written->folder / "optimum.csv");
  EXPECT_THAT(optimum.Header(),
              ::testing::ElementsAre("variable", "initial", "optimum", "lower", "upper", "active", "multiplier"));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(optimum.Text(i, 0), problem::LinkName(i));
    EXPECT_EQ(optimum.RequiredNumber(i, 2), design.links.Values()[i]);
  }
  EXPECT_EQ(optimum.Text(4, 5), "lower");  // l5 = 50 mm
  EXPECT_LT(optimum.RequiredNumber(4, 6), -0.1);

  const CsvTable margins = CsvTable::Read(written->folder / "margin.csv");
  for (std::size_t row = 0; row < margins.Rows(); ++row) {
    const double at = margins.RequiredNumber(row, margins.Column("range_deg"));
    if (margins.RequiredNumber(row, 0) == 2) {
      EXPECT_NEAR(at, range, 1e-6);
    }
    if (row > 0) {
      EXPECT_LT(at, margins.RequiredNumber(row - 1, margins.Column("range_deg")));
    }
  }
  EXPECT_TRUE(margins.Has("yield"));
  EXPECT_FALSE(margins.Has("certified_upper_bound_deg")) << "what is proved is the problem that was asked";
  EXPECT_THAT(summary["yield"]["scope"].get<std::string>(), ::testing::HasSubstr("play of the pins"));
  EXPECT_EQ(CsvTable::Read(written->folder / "starts.csv").Rows(), 3u);
  EXPECT_EQ(CsvTable::Read(written->folder / "sensitivity.csv").Rows(), 7u * 201u);
  EXPECT_GT(CsvTable::Read(written->folder / "convergence.csv").Rows(), 5u);
  const linkage::Design rounded = linkage::ReadDesign(written->folder / "rounded.yaml");
  for (const double value : rounded.links.Values()) EXPECT_EQ(value * 2, std::round(value * 2));
}

TEST(SynthesisOutcome, MultipliersAreNotPublishedWhereTheyAreNotUnique) {
  const auto written = RunAndWrite(problem::SynthesisProblem{}, FewStarts());
  EXPECT_FALSE(written->summary["multipliers_unique"].get<bool>());
  EXPECT_TRUE(written->summary["certified_upper_bound_deg"].is_null());
  for (const Json& entry : written->summary["active"]) EXPECT_TRUE(entry["multiplier"].is_null());
  const CsvTable optimum = CsvTable::Read(written->folder / "optimum.csv");
  for (std::size_t row = 0; row < optimum.Rows(); ++row) EXPECT_EQ(optimum.Text(row, 6), "");
}

TEST(SynthesisOutcome, InfeasibleProblemLeavesItsBestPointMarked) {
  problem::SynthesisProblem problem;
  problem.limits["min_moment_arm_mm"] = 60;
  const auto written = RunAndWrite(problem, FewStarts());
  EXPECT_EQ(written->summary["status"], "infeasible");
  EXPECT_FALSE(written->summary["smallest_relaxation"].empty());
  EXPECT_THAT(linkage::ReadDesign(written->folder / "design.yaml").made_by, ::testing::HasSubstr("NOT A SOLUTION"));
  EXPECT_FALSE(std::filesystem::exists(written->folder / "sensitivity.csv"));
}

// Without the force limit the range is 12.5° larger, which the bound was until it took that limit in.
TEST(SynthesisOutcome, CertificateHoldsWithRequirementsOverTheUsedRange) {
  problem::SynthesisProblem problem = WithMargins(1);
  problem.limits["max_force_n"] = 2000;
  const double range = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  const certificate::Certificate certificate = certificate::CertifyRange(problem, range, {.gap_deg = 8});
  EXPECT_GT(certificate.upper_bound_deg, range);
  EXPECT_TRUE(certificate.reached);
}

// What the bound does without sets what it can come to: it is found without using up the budget, and does not reach the
// gap asked for.
TEST(SynthesisOutcome, CertificateAimsAtTheOptimumWithoutWhatItDoesWithout) {
  problem::SynthesisProblem problem = WithMargins(2);
  const double without_deg = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  problem.robust_mm = 0.5;
  const synthesis::LocalSolve robust = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(robust.IsUsable());
  const double range_deg = robust.evaluation.range_deg;
  ASSERT_LT(range_deg, without_deg - 0.2);
  const certificate::CertificateOptions options{.max_boxes = 5000};
  const certificate::Certificate certificate =
      synthesis::CertifyOptimum(problem, robust.end, range_deg, options, FewStarts().optimize);
  EXPECT_LT(certificate.boxes, options.max_boxes);
  EXPECT_EQ(certificate.end, certificate::Certificate::End::kGap);
  EXPECT_GE(certificate.upper_bound_deg, without_deg - 1e-6);
  EXPECT_LE(certificate.upper_bound_deg, without_deg + options.gap_deg + 1e-6);
  EXPECT_EQ(certificate.range_deg, range_deg);
  EXPECT_FALSE(certificate.reached);
}

TEST(SynthesisOutcome, CapIsPartOfTheCertificate) {
  problem::SynthesisProblem problem = WithMargins(1);
  problem.limits["max_angle_deg"] = 130;
  const certificate::Certificate certificate = certificate::CertifyRange(problem, 130, {.max_boxes = 1000});
  EXPECT_TRUE(certificate.reached);
  EXPECT_EQ(certificate.upper_bound_deg, 130);
}

TEST(SynthesisOutcome, RefusesSenselessOptions) {
  synthesis::SynthesisOptions options;
  options.certify_gap_deg = -1;
  EXPECT_THROW(synthesis::RunSynthesis(problem::SynthesisProblem{}, options), Error);
  options = {};
  options.yield_tolerance_mm = NAN;
  EXPECT_THROW(synthesis::RunSynthesis(problem::SynthesisProblem{}, options), Error);
}

}  // namespace
}  // namespace lake
