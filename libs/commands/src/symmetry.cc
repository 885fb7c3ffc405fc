#include "lake/commands/symmetry.h"

#include <fmt/format.h>

#include "lake/commands/gait.h"
#include "lake/compare/symmetry.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/figure/symmetry_figure.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

gait::LegFitResult FitSide(const fs::path& path, const exchange::TrialOptions& reading,
                           const gait::PictureScale& picture, Run& run) {
  gait::LegFitOptions fit;
  fit.facing_option = "--forward";
  return FitTrial(ReadTrialFor(path, reading, picture), fit, run, picture);
}

void AddDifference(const compare::SideDifference& difference, CsvWriter& csv) {
  csv.Add(difference.left).Add(difference.right).Add(difference.difference);
  csv.Add(difference.interval.low).Add(difference.interval.high);
}

void WriteQuantities(const fs::path& path, const compare::Symmetry& symmetry) {
  CsvWriter csv({"quantity", "left", "right", "difference", "difference_low", "difference_high", "index_percent",
                 "index_low_percent", "index_high_percent", "asymmetric"});
  for (const compare::SideDifference& difference : symmetry.quantities) {
    csv.Add(difference.name);
    AddDifference(difference, csv);
    csv.Add(difference.index_percent).Add(difference.index_interval.low).Add(difference.index_interval.high);
    csv.Add(difference.IsAsymmetric() ? 1 : 0).EndRow();
  }
  csv.Write(path);
}

void WriteCurve(const fs::path& path, const compare::Symmetry& symmetry) {
  CsvWriter csv(
      {"percent", "left_knee_deg", "right_knee_deg", "difference_deg", "difference_low_deg", "difference_high_deg"});
  for (std::size_t percent = 0; percent < symmetry.knee_deg.size(); ++percent) {
    csv.Add(static_cast<int>(percent));
    AddDifference(symmetry.knee_deg[percent], csv);
    csv.EndRow();
  }
  csv.Write(path);
}

Json DifferenceJson(const compare::SideDifference& difference) {
  return {{"left", difference.left},
          {"right", difference.right},
          {"difference", difference.difference},
          {"interval", {difference.interval.low, difference.interval.high}},
          {"index_percent", difference.index_percent},
          {"index_interval_percent", {difference.index_interval.low, difference.index_interval.high}},
          {"asymmetric", difference.IsAsymmetric()}};
}

}  // namespace

Json RunSymmetry(const CompareRunOptions& options, Run& run) {
  CheckReading(options.left, options.human_reading);
  CheckReading(options.right, options.right_reading);
  run.AddInputs(InputsOf(options));
  const gait::LegFitResult left = FitSide(options.left, options.human_reading, options.human_picture, run),
                           right = FitSide(options.right, options.right_reading, options.right_picture, run);
  compare::SymmetryOptions of_sides;
  of_sides.replacement_sd_mm = options.misalignment.replacement_sd_mm;
  of_sides.one_recording = fs::equivalent(options.left, options.right);
  const compare::Symmetry symmetry = compare::CompareSides(left, right, of_sides);
  run.Begin({"summary.json", "symmetry.csv", "symmetry_curve.csv", "symmetry.png", "symmetry.svg"});
  WriteQuantities(run.Result("symmetry.csv"), symmetry);
  WriteCurve(run.Result("symmetry_curve.csv"), symmetry);
  DrawPngAndSvg("symmetry", run, [&](const fs::path& path) { figure::DrawSymmetry(path, symmetry); });
  Json quantities = Json::object();
  for (const compare::SideDifference& difference : symmetry.quantities)
    quantities[difference.name] = DifferenceJson(difference);
  return {{"asymmetric", symmetry.is_asymmetric},
          {"left_rises", symmetry.left_rises},
          {"right_rises", symmetry.right_rises},
          {"matched", of_sides.one_recording},
          {"symmetry", quantities}};
}

std::string SymmetryReport(const Json& summary) {
  std::string text = fmt::format("{} and {} rises of the left and the right leg: {}\n", summary["left_rises"].dump(),
                                 summary["right_rises"].dump(),
                                 summary["asymmetric"] == true ? "asymmetric" : "no difference beyond its interval");
  for (const auto& [name, difference] : summary["symmetry"].items()) {
    const Json &interval = difference["interval"], &index = difference["index_interval_percent"];
    text +=
        fmt::format("{} {}  left less right {:+.3g} (95 %: {:+.3g} to {:+.3g}), index {:+.1f} % ({:+.1f} to {:+.1f})\n",
                    difference["asymmetric"] == true ? "*" : " ", name, NumberOrNaN(difference["difference"]),
                    NumberOrNaN(interval[0]), NumberOrNaN(interval[1]), NumberOrNaN(difference["index_percent"]),
                    NumberOrNaN(index[0]), NumberOrNaN(index[1]));
  }
  return text;
}

}  // namespace lake::commands
