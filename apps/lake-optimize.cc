// Finds the links that give the largest range of rotation, proves it, and says what it is worth.
#include <optional>
#include <string>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/render/synthesis_figures.h"
#include "lake/synthesis/problem_file.h"
#include "lake/synthesis/study.h"
#include "program.h"

namespace {

using lake::Json;

struct Options {
  std::string problem, start;
  int starts = lake::OptimizeOptions{}.starts;
  std::uint64_t seed = lake::OptimizeOptions{}.seed;
  std::optional<double> grashof_margin, singularity_margin, max_force, knee_torque, min_moment_arm, min_transmission,
      max_angle, max_length, yield, round;
  double certify = lake::CertificateOptions{}.gap_deg;
};

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
  cli.add_option("--yield", options.yield, "Fraction of builds that work when every link is off by up to this, mm");
  cli.add_option("--round", options.round, "Also give the best design with links that are multiples of this, mm");
}

template <typename Field>
void Override(Field& field, const std::optional<double>& option) {
  if (option) field = *option;
}

lake::SynthesisProblem ProblemOf(const Options& options) {
  lake::SynthesisProblem problem;
  if (!options.problem.empty()) problem = lake::ReadProblem(std::filesystem::path(options.problem));
  Override(problem.grashof_margin_mm, options.grashof_margin);
  Override(problem.singularity_margin_mm, options.singularity_margin);
  Override(problem.max_force_n, options.max_force);
  Override(problem.knee_torque_nm, options.knee_torque);
  Override(problem.min_moment_arm_mm, options.min_moment_arm);
  Override(problem.min_transmission_deg, options.min_transmission);
  Override(problem.max_angle_deg, options.max_angle);
  Override(problem.d_max_mm, options.max_length);
  if (!options.start.empty()) {
    const std::vector<double> links = lake::ParseNumbers(options.start, 6, "--start");
    problem.start = lake::Links::FromValues({links[0], links[1], links[2], links[3], links[4], links[5]});
  }
  problem.Check();
  return problem;
}

Json Optimize(const Options& options, bool certify, lake::Run& run) {
  const lake::SynthesisProblem problem = ProblemOf(options);
  if (!options.problem.empty()) run.AddInput(options.problem);
  lake::StudyOptions study_options;
  study_options.optimize.starts = options.starts;
  study_options.optimize.seed = options.seed;
  study_options.optimize.quiet = study_options.quiet = run.Quiet();
  if (certify) study_options.certify_gap_deg = options.certify;
  study_options.yield_tolerance_mm = options.yield;
  study_options.round_mm = options.round;

  const lake::Study study = lake::RunStudy(problem, study_options);
  Json summary = lake::WriteStudy(study, run);
  DrawConvergence(study, run.Result("convergence.png"));
  if (!study.IsSolved()) {
    run.WriteSummary(summary);
    throw lake::SolverError(study.infeasible->sentence);
  }
  DrawSensitivity(study, run.Result("sensitivity.png"));
  DrawMargins(study, run.Result("margin.png"));
  return summary;
}

std::string Report(const Json& summary) {
  std::string text = fmt::format("range {:.4f} deg", summary["range_deg"].get<double>());
  if (const Json& bound = summary["certified_upper_bound_deg"]; bound.is_number())
    text += fmt::format(", proved to be at most {:.4f} deg for any design", bound.get<double>());
  text += "\n";
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
      "lake-optimize", "The links that give the largest range of rotation.",
      "lake-optimize --starts 20 --grashof-margin 2 --singularity-margin 2 --certify -o lake-out/design");
  Options options;
  AddOptions(program.Cli(), options);
  const CLI::Option* certify = program.Cli().get_option("--certify");
  return program.Main(
      argc, argv, [&] { return std::string("optimize"); },
      [&](lake::Run& run) { return Optimize(options, certify->count() > 0, run); }, Report);
}
