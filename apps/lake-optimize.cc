// Finds the links that give the largest range of rotation, proves it, and says what it is worth; with a human's motion,
// those whose knee also goes along with it.
#include <algorithm>
#include <optional>
#include <string>

#include "lake/commands/gait.h"
#include "lake/commands/optimize.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/problem/problem_file.h"
#include "program.h"

namespace {

using lake::Json;

struct Options {
  std::string problem, start;
  int starts = lake::synthesis::OptimizeOptions{}.starts;
  std::uint64_t seed = lake::synthesis::OptimizeOptions{}.seed;
  std::optional<double> grashof_margin, singularity_margin, max_force, knee_torque, min_moment_arm, min_transmission,
      max_angle, max_length, yield, round;
  double certify = lake::certificate::CertificateOptions{}.gap_deg;
  lake::commands::ReoptimizeRunOptions reoptimize;
  std::string comparison, human, worn, map, up, unit = "mm", program = "constant";
};

// Options that say something only about a human's motion.
constexpr const char* kReoptimizeOptions = "Re-optimisation";

void AddOptions(CLI::App& cli, Options& options) {
  cli.add_option("--problem", options.problem, "Problem file (default: the paper's problem)");
  cli.add_option("--start", options.start, "Links to start from, l1,l2,l3,l4,l5,l6 in mm");
  cli.add_option("--starts", options.starts, "Number of starts; all but the first are random within the bounds");
  cli.add_option("--seed-number", options.seed, "Seed of everything random");
  cli.add_option("--grashof-margin", options.grashof_margin, "Margin of Grashof's law, mm");
  cli.add_option("--singularity-margin", options.singularity_margin, "Margin from the actuator singularity, mm");
  cli.add_option("--max-force", options.max_force, "Greatest actuator force over the used range, N");
  cli.add_option("--knee-torque", options.knee_torque, "Knee torque that the force balances, N m");
  cli.add_option("--min-moment-arm", options.min_moment_arm, "Least moment arm over the used range, mm per rad");
  cli.add_option("--min-transmission", options.min_transmission,
                 "Least transmission angle between coupler and shank link over the used range, deg");
  cli.add_option("--max-angle", options.max_angle, "Anatomical cap on the knee angle, deg");
  cli.add_option("--max-length", options.max_length, "Longest stroke of the actuator; the knee must stand by then, mm");
  cli.add_option("--certify", options.certify, "Prove an upper bound on the range to within this gap, deg")
      ->expected(0, 1);
  cli.add_option(
      "--yield", options.yield,
      "Evaluate the fraction of builds that work when every link is off by up to this, mm, and the actuator's "
      "length and the pins are exact; no constraint");
  cli.add_option("--round", options.round, "Also give the best design with links that are multiples of this, mm");
}

void AddReoptimizeOptions(CLI::App& cli, Options& options) {
  lake::commands::ReoptimizeRunOptions& reoptimize = options.reoptimize;
  CLI::App* group = cli.add_option_group(kReoptimizeOptions, "With --comparison or --human:");
  group->option_defaults()->always_capture_default();
  group->add_option("--comparison", options.comparison, "Folder that lake-compare wrote: human and exoskeleton trial");
  group->add_option("--human", options.human, "A human trial alone, as lake-compare reads it");
  group->add_option("--human-knee", reoptimize.human_knee, "The knee marker of --human");
  group->add_option("--map", options.map, "ankle=NAME,knee=NAME,hip=NAME,waist=NAME: the markers of a --human file");
  group->add_option("--up", options.up, "x, y or z: vertical axis of a 3-D --human file");
  group->add_option("--forward", reoptimize.human_reading.forward, "+x, -x, …: where the subject of a file faces");
  group->add_option("--unit", options.unit, "mm, cm or m: of a --human file that does not say (Tracker text, Kinovea)");
  group->add_option("--worn", options.worn, "design.yaml worn in the exoskeleton trial of --comparison");
  group->add_flag("--human-only", reoptimize.human_only, "Leave the exoskeleton trial of --comparison out");
  group->add_option("--max-misalignment", reoptimize.max_misalignment_percent,
                    "Greatest misalignment, RMS in percent of the shank");
  group->add_option("--penalty", reoptimize.penalty_deg_per_mm, "Range given up for less misalignment, deg per mm RMS");
  group->add_option("--program", options.program, "Stroke program: constant (one speed) or free")
      ->check(CLI::IsMember({"constant", "free"}));
  group->add_option("--max-speed", reoptimize.program.max_speed_mm_s, "Speed of the actuator, mm/s");
  group->add_option("--duration", reoptimize.program.duration_s,
                    "Longest time of a sit-to-stand, s (default: no limit)");
  group->add_flag("--monotone", reoptimize.program.monotone, "A free program may not turn back");
  group->add_option("--knots", reoptimize.program.knots, "Knots of a free program");
  group->add_flag("--fit-placement", reoptimize.fit_placement, "Move the exoskeleton's joint on the shank too");
  group->add_option("--placement-reach", reoptimize.placement_reach_mm,
                    "How far from the knee it may sit, mm to either side");
  group->add_option("--pareto", reoptimize.pareto_points,
                    "Range against misalignment in this many points, for a constant and a short free program");
}

template <typename Field>
void Override(Field& field, const std::optional<double>& option) {
  if (option) field = *option;
}

void OverrideAll(const Options& options, lake::problem::SynthesisProblem& problem) {
  Override(problem.grashof_margin_mm, options.grashof_margin);
  Override(problem.singularity_margin_mm, options.singularity_margin);
  Override(problem.max_force_n, options.max_force);
  Override(problem.knee_torque_nm, options.knee_torque);
  Override(problem.min_moment_arm_mm, options.min_moment_arm);
  Override(problem.min_transmission_deg, options.min_transmission);
  Override(problem.max_angle_deg, options.max_angle);
  Override(problem.d_max_mm, options.max_length);
  if (options.start.empty()) return;
  const std::vector<double> links = lake::ParseNumbers(options.start, 6, "--start");
  problem.start = lake::linkage::Links::FromValues({links[0], links[1], links[2], links[3], links[4], links[5]});
}

lake::problem::SynthesisProblem ProblemOf(const Options& options) {
  lake::problem::SynthesisProblem problem;
  if (!options.problem.empty()) problem = lake::problem::ReadProblem(std::filesystem::path(options.problem));
  OverrideAll(options, problem);
  try {
    problem.Check();
  } catch (const lake::Error& error) {  // the file itself was checked when it was read
    throw lake::UsageError(fmt::format("the options contradict the problem: {}", error.what()));
  }
  return problem;
}

lake::commands::ReoptimizeRunOptions ReoptimizeOf(const Options& options) {
  lake::commands::ReoptimizeRunOptions reoptimize = options.reoptimize;
  reoptimize.comparison = options.comparison, reoptimize.human = options.human, reoptimize.worn = options.worn;
  reoptimize.human_reading.names = lake::exchange::ParseNameMap(options.map);
  reoptimize.human_reading.up = lake::exchange::ParseUp(options.up);
  reoptimize.human_reading.mm_per_unit = lake::commands::MmPerUnit(options.unit);
  reoptimize.program.kind = options.program == "free" ? lake::linkage::StrokeProgram::Kind::kFree
                                                      : lake::linkage::StrokeProgram::Kind::kConstant;
  return reoptimize;
}

// Is an option of the re-optimisation given?
bool IsReoptimisation(const CLI::App& cli) {
  const auto options = cli.get_option_group(kReoptimizeOptions)->get_options();
  return std::any_of(options.begin(), options.end(), [](const CLI::Option* option) { return option->count() > 0; });
}

Json Optimize(const Options& options, const CLI::App& cli, lake::Run& run) {
  lake::commands::OptimizeRunOptions work;
  work.problem = ProblemOf(options);
  work.problem_file = options.problem;
  work.study.optimize.starts = options.starts;
  work.study.optimize.seed = options.seed;
  work.study.optimize.quiet = work.study.quiet = run.Quiet();
  if (cli.get_option("--certify")->count() > 0) work.study.certify_gap_deg = options.certify;
  work.study.yield_tolerance_mm = options.yield;
  work.study.round_mm = options.round;
  if (IsReoptimisation(cli)) work.reoptimize = ReoptimizeOf(options);
  return lake::commands::RunOptimize(work, run);
}

// Before and after, where there is a motion.
std::string ReportMotion(const Json& summary) {
  if (!summary.contains("before")) return "";
  const auto line = [&](const char* name, const char* key, const char* unit) {
    const auto cell = [&](const char* when) {
      const Json& value = summary[when][key];
      return value.is_number() ? fmt::format("{:10.4g}", value.get<double>()) : fmt::format("{:>10}", "-");
    };
    return fmt::format("  {:<22}{} ->{} {}\n", name, cell("before"), cell("after"), unit);
  };
  return line("range", "range_deg", "deg") + line("misalignment", "misalignment_percent", "% of the shank, RMS") +
         line("", "misalignment_rms_mm", "mm RMS") + line("  placement", "part_placement", "of it") +
         line("  timing", "part_timing", "of it") + line("  shape", "part_shape", "of it") +
         line("joint sits", "placement_x_mm", "mm in front of the knee") +
         line("", "placement_y_mm", "mm above it, along the shank") + line("program", "program_duration_s", "s") +
         line("exact tracking takes", "exact_tracking_time_s", "s") + summary["trial_text"].get<std::string>() + "\n" +
         summary["build_text"].get<std::string>() + "\n";
}

std::string Report(const Json& summary) {
  std::string text = fmt::format("range {:.4f} deg", summary["range_deg"].get<double>());
  if (const Json& bound = summary["certified_upper_bound_deg"]; bound.is_number())
    text += fmt::format(", proved to be at most {:.4f} deg for any design", bound.get<double>());
  text += "\n";
  text += ReportMotion(summary);
  for (const auto& [name, length] : summary["links"].items())
    text += fmt::format("  {} {:9.4f} mm\n", name, length.get<double>());
  for (const Json& limit : summary["active"]) {
    text += fmt::format("  at its limit: {}", limit["limit"].get<std::string>());
    if (limit["multiplier"].is_number())
      text += fmt::format(", {:.4g} {}", limit["multiplier"].get<double>(), limit["unit"].get<std::string>());
    text += "\n";
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program(
      "lake-optimize",
      "The links that give the largest range of rotation; with a human's motion, the exoskeleton that goes along.",
      "lake-optimize --starts 20 --grashof-margin 2 --singularity-margin 2 --certify -o lake-out/design\n"
      "  lake-optimize --comparison lake-out/comparison --worn worn.yaml --max-misalignment 3 --program free "
      "--duration 25 --fit-placement --pareto 12");
  Options options;
  AddOptions(program.Cli(), options);
  AddReoptimizeOptions(program.Cli(), options);
  return program.Main(
      argc, argv, [&] { return std::string("optimize"); },
      [&](lake::Run& run) { return Optimize(options, program.Cli(), run); }, Report);
}
