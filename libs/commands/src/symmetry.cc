#include "lake/commands/symmetry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "force_plates.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/compare/symmetry.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/ground_forces.h"
#include "lake/figure/trial_figures.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/sync/clock.h"
#include "png_and_svg.h"
#include "second_trial.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

// A leg's trial and its fit.
struct Side {
  exchange::Trial trial;
  gait::LegFitResult fit;
};

Side FitSide(const fs::path& path, const exchange::TrialOptions& reading, const gait::PictureScale& picture,
             const gait::MovementOptions& movement, Run& run) {
  gait::LegFitOptions options;
  options.facing_option = "--forward";
  options.movement = movement;
  exchange::Trial trial = ReadTrialFor(path, reading, picture);
  gait::LegFitResult fit = FitTrial(trial, options, run, picture);
  return {std::move(trial), std::move(fit)};
}

// What is said of the left leg's picture holds for the right leg's too, where that is in px.
gait::PictureScale RightPicture(const SymmetryRunOptions& options) {
  const gait::PictureScale& picture = options.right_picture;
  if (!picture.IsGiven()) return picture;
  const exchange::Trial right = exchange::ReadTrial(options.right, options.right_reading);
  if (right.recording.unit == motion::LengthUnit::kPx) return picture;
  if (picture != options.left_picture)
    exchange::CheckNoneIsUnused(options.right,
                                {{fmt::format("--right-{}", picture.OptionName() + 2), "its lengths are in mm"}});
  return {};
}

struct Window {
  double from_s, to_s;
};

// From seat-off to standing of the rises that both legs show, the mean of what they say, by the left leg's numbers.
std::map<int, Window> LoadedWindows(const gait::LegFitResult& left, const gait::LegFitResult& right) {
  std::map<int, Window> windows;
  const std::map<int, int> left_by_right = compare::MatchRepetitions(left, right).left_by_right;
  const std::vector<gait::SitToStand> of_right = gait::MeasureSitToStands(right, {});
  for (const gait::SitToStand& l : gait::MeasureSitToStands(left, {}))
    for (const gait::SitToStand& r : of_right) {
      const auto number = left_by_right.find(r.repetition);
      if (number == left_by_right.end() || number->second != l.repetition) continue;
      const Window window{(l.seat_off_s.value + r.seat_off_s.value) / 2, (l.standing_s.value + r.standing_s.value) / 2};
      if (window.from_s < window.to_s) windows[l.repetition] = window;
    }
  return windows;
}

// The vertical force under one foot in each rise: its mean and its largest, N.
struct FootLoads {
  std::map<int, gait::Measured> mean, largest;
};

FootLoads LoadsOf(const exchange::PlateForces& plate, const Eigen::Vector3d& up, const std::vector<double>& time_s,
                  const std::map<int, Window>& windows) {
  FootLoads loads;
  for (const auto& [repetition, window] : windows) {
    std::vector<double> forces_n;
    for (std::size_t i = 0; i < time_s.size(); ++i)
      if (time_s[i] >= window.from_s && time_s[i] <= window.to_s) forces_n.push_back(plate.force_n[i].dot(up));
    if (forces_n.empty() || time_s.front() > window.from_s || time_s.back() < window.to_s) continue;
    loads.mean[repetition].value = Mean(forces_n);
    loads.largest[repetition].value = *std::ranges::max_element(forces_n);
  }
  return loads;
}

std::vector<compare::FurtherQuantity> ReadLoads(const SymmetryRunOptions& options, const Side& left, const Side& right,
                                                Run& run) {
  if (options.forces.empty()) return {};
  if (!fs::equivalent(options.left, options.right))
    throw UsageError(
        "--forces: the load on each foot needs one recording that shows both legs: give LEFT alone, and name the right "
        "leg's markers with --right-map");
  if (left.fit.movement.kind != gait::MovementKind::kSitToStand)
    throw UsageError("--forces: the load on each foot is measured while one rises; of a walk use lake loads");
  const exchange::GroundForceRecording file = exchange::ReadGroundForces(options.forces);
  std::vector<double> time_s = file.time_s;
  if (options.sync) {
    const sync::Clock clock = sync::ReadClockOf(*options.sync, options.forces);
    for (double& time : time_s) time = clock.FromB(time);
  }
  const exchange::PlateForces &l = exchange::PlateOf(file, options.plates, "left", options.forces),
                              &r = exchange::PlateOf(file, options.plates, "right", options.forces);
  if (&l == &r)
    throw Fail(
        "{}: {} is the only plate that bears a force: under both feet it does not say what either bears; leave "
        "--forces out",
        options.forces.string(), l.name);
  const Eigen::Vector3d up = VerticalOf(file, left.trial, options.forces);
  VerticalOf(file, right.trial, options.forces);  // the same
  const std::string way_out = "Name them with --plates";
  WarnOfSwappedPlates(file, l, "left", left.trial, options.left_reading, way_out, run);
  WarnOfSwappedPlates(file, r, "right", right.trial, options.right_reading, way_out, run);
  const std::map<int, Window> windows = LoadedWindows(left.fit, right.fit);
  const FootLoads of_left = LoadsOf(l, up, time_s, windows), of_right = LoadsOf(r, up, time_s, windows);
  if (of_left.mean.size() < 2)
    throw Fail(
        "{}: it has the forces of {} of the {} rises; a difference needs two (are both on one clock? See lake "
        "sync)",
        options.forces.string(), of_left.mean.size(), windows.size());
  constexpr double kPlate = 0.01;  // of a force: what makers state as linearity and crosstalk is 0.2 to 2 %
  return {{"load_mean_n", of_left.mean, of_right.mean, kPlate},
          {"load_max_n", of_left.largest, of_right.largest, kPlate}};
}

void WriteQuantities(const fs::path& path, const compare::Symmetry& symmetry) {
  CsvWriter csv({"quantity", "left", "right", "difference", "difference_low", "difference_high", "index_percent",
                 "index_low_percent", "index_high_percent", "asymmetric"});
  for (const compare::SideDifference& of : symmetry.quantities)
    csv.AddRow(of.name, of.left, of.right, of.difference, of.interval.low, of.interval.high, of.index_percent,
               of.index_interval.low, of.index_interval.high, of.IsAsymmetric());
  csv.Write(path);
}

void WriteCurve(const fs::path& path, const compare::Symmetry& symmetry) {
  CsvWriter csv(
      {"percent", "left_knee_deg", "right_knee_deg", "difference_deg", "difference_low_deg", "difference_high_deg"});
  for (std::size_t percent = 0; percent < symmetry.knee_deg.size(); ++percent) {
    const compare::SideDifference& of = symmetry.knee_deg[percent];
    csv.AddRow(percent, of.left, of.right, of.difference, of.interval.low, of.interval.high);
  }
  csv.Write(path);
}

Json DifferenceJson(const compare::SideDifference& difference) {
  return {{"left", difference.left},
          {"right", difference.right},
          {"difference", difference.difference},
          {"interval", {NumberOrNull(difference.interval.low), NumberOrNull(difference.interval.high)}},
          {"index_percent", NumberOrNull(difference.index_percent)},
          {"index_interval_percent",
           {NumberOrNull(difference.index_interval.low), NumberOrNull(difference.index_interval.high)}},
          {"asymmetric", difference.IsAsymmetric()}};
}

// "+4.1 (95 %: +0.3 to +7.9)": as far as the interval knows the difference.
std::string DifferenceText(double difference, const compare::Interval& interval, const char* unit, const char* level) {
  if (std::isnan(interval.low)) return fmt::format("{}{}", WithSign(SignificantText(difference, 3)), unit);
  const auto text = [&](double value) { return WithSign(KnownText(value, 0.5 * (interval.high - interval.low), 1)); };
  return fmt::format("{}{} ({}{} to {})", text(difference), unit, level, text(interval.low), text(interval.high));
}

const char* Verdict(const compare::Symmetry& symmetry) {
  if (symmetry.is_asymmetric) return "asymmetric";
  const bool has_interval = std::ranges::any_of(
      symmetry.quantities, [](const compare::SideDifference& of) { return std::isfinite(of.interval.low); });
  return has_interval ? "no difference beyond its interval" : "too few for an interval";
}

std::string ReportOf(const compare::Symmetry& symmetry) {
  std::string text =
      fmt::format("{} and {} {}s of the left and the right leg: {}\n", symmetry.left_count, symmetry.right_count,
                  gait::MovementOf(symmetry.movement).repetition, Verdict(symmetry));
  for (const compare::SideDifference& of : symmetry.quantities) {
    text += fmt::format("{} {}  left less right {}", of.IsAsymmetric() ? "*" : " ", of.name,
                        DifferenceText(of.difference, of.interval, "", "95 %: "));
    if (std::isfinite(of.index_percent))
      text += fmt::format(", index {}", DifferenceText(of.index_percent, of.index_interval, " %", ""));
    text += "\n";
  }
  return text;
}

}  // namespace

void Describe(SymmetryRunOptions& o, OptionList& options) {
  options
      .AddOperand("left", o.left,
                  "The left leg's trial: a lake-track folder, .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker)")
      .Required();
  options.AddOperand("right", o.right, "The right leg's trial").Otherwise("LEFT, which shows both legs");
  Describe(o.left_reading, options);
  options.Add("forces", o.forces, "Ground forces of the recording of both legs: OpenSim's .mot or .sto, or a .c3d")
      .Otherwise("the load on each foot is not reported");
  options.Add("plates", o.plates, "The feet's force plates, in the file's order").Value("left=N,right=N");
  options.Add("sync", o.sync, "The forces' clock against the trial's: the sync.yaml of lake sync TRIAL FORCES")
      .Otherwise("one clock");
  Describe(o.movement, options);
  compare::DescribeReplacement(o.replacement_sd_mm, options);
  Describe(o.left_picture, options);
  gait::DescribeDepths(o.left_picture.depths, options);
  DescribeSecond("right", "the right leg's trial", {o.left_reading, o.left_picture}, {o.right_reading, o.right_picture},
                 options);
  options.Check([&o](const OptionList&) {
    exchange::CheckPlates(o.plates);
    if (!o.plates.empty() && o.forces.empty())
      throw UsageError("--plates needs a file with the forces: give it with --forces");
    if (o.sync && o.forces.empty()) throw UsageError("--sync only applies together with --forces");
    if (o.right.empty()) o.right = o.left;
  });
}

std::vector<InputFile> InputsOf(const SymmetryRunOptions& options) {
  std::vector<InputFile> inputs = TrialInputs(options.left, "left");
  for (InputFile& input : TrialInputs(options.right, "right")) inputs.push_back(std::move(input));
  if (!options.forces.empty()) inputs.push_back({options.forces, "forces"});
  if (options.sync) inputs.push_back({*options.sync, "sync"});
  if (const auto& camera = options.left_picture.camera) inputs.push_back({*camera, "left camera"});
  if (const auto& camera = options.right_picture.camera) inputs.push_back({*camera, "right camera"});
  return inputs;
}

Json RunSymmetry(const SymmetryRunOptions& options, Run& run) {
  CheckReading(options.left, options.left_reading);
  CheckReading(options.right, options.right_reading);
  SymmetryRunOptions used = options;
  used.right_picture = RightPicture(options);
  run.AddInputs(InputsOf(used));
  const Side left = FitSide(options.left, options.left_reading, options.left_picture, options.movement, run),
             right = FitSide(options.right, options.right_reading, used.right_picture, options.movement, run);
  compare::SymmetryOptions of_sides;
  of_sides.replacement_sd_mm = options.replacement_sd_mm;
  of_sides.one_recording = fs::equivalent(options.left, options.right);
  of_sides.further = ReadLoads(options, left, right, run);
  const compare::Symmetry symmetry = compare::CompareSides(left.fit, right.fit, of_sides);
  for (const std::string& warning : symmetry.warnings) run.Warn(warning);
  run.Begin({"summary.json", "symmetry.csv", "symmetry_curve.csv", "symmetry.png", "symmetry.svg"});
  WriteQuantities(run.Result("symmetry.csv"), symmetry);
  WriteCurve(run.Result("symmetry_curve.csv"), symmetry);
  DrawPngAndSvg("symmetry", run, figure::DrawSymmetry, symmetry);
  Json quantities = Json::object();
  for (const compare::SideDifference& difference : symmetry.quantities)
    quantities[difference.name] = DifferenceJson(difference);
  run.Report(ReportOf(symmetry));
  const gait::Movement& movement = gait::MovementOf(symmetry.movement);
  return {{"movement", movement.name},
          {"asymmetric", symmetry.is_asymmetric},
          {fmt::format("left_{}s", movement.repetition), symmetry.left_count},
          {fmt::format("right_{}s", movement.repetition), symmetry.right_count},
          {"matched", of_sides.one_recording},
          {"symmetry", quantities}};
}

}  // namespace lake::commands
