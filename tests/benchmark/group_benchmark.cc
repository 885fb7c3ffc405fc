// One design for many people: processor time and iterations over the number of people, and what the common design is.
//
//   lake_group_benchmark [PEOPLE …]      default: 1 10 30 100
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <random>

#include "compare/closed_form.h"
#include "lake/redesign/group.h"

namespace lake {
namespace {

// Legs, seats and paces as in adult populations: Winter's parts of a height of 1710 ± 90 mm, 92 ± 5 degrees seated.
std::vector<redesign::PersonMeasured> Draw(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<redesign::PersonMeasured> people;
  for (int i = 0; i < count; ++i) {
    std::normal_distribution<double> height(1710, 90), seated(92, 5), peak(18, 2);
    const double height_mm = height(random);
    ClosedFormLeg leg;
    leg.shank_mm = 0.246 * height_mm, leg.thigh_mm = 0.245 * height_mm;
    leg.seated_knee_deg = seated(random), leg.peak_shank_deg = peak(random);
    people.push_back({fmt::format("sub-{:03}", i + 1), {MakeCurve(leg)}});
  }
  return people;
}

redesign::GroupProblem Problem() {
  redesign::GroupProblem problem;
  problem.shared.design.grashof_margin_mm = problem.shared.design.singularity_margin_mm = 2;
  problem.shared.program.kind = linkage::StrokeProgram::Kind::kFree;
  problem.shared.program.duration_s = 22;
  problem.shared.fit_placement = true;
  problem.shared.max_misalignment_percent = 3;
  return problem;
}

double Processor_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void Measure(int count) {
  redesign::GroupProblem problem = Problem();
  std::vector<redesign::ReoptimizePoint> start;
  for (const redesign::PersonMeasured& person : Draw(count, 1))
    problem.people.push_back({person.name, redesign::MakeHumanMotion(person.motion.human)});
  for (int i = 0; i < count; ++i) start.push_back(redesign::StartPoint(problem.Of(i), problem.shared.design.start));
  const double before_s = Processor_s();
  const redesign::GroupSolve solve = redesign::SolveFrom(problem, start);
  const double took_s = Processor_s() - before_s;
  fmt::print("| {} | {} | {} | {} | {:.2f} | {:.1f} | {:.4f} |\n", count,
             solve.local.program.program.Variables().size(), solve.IsUsable() ? "solved" : solve.local.solution.message,
             solve.local.iterations, took_s, 1e3 * took_s / (count * std::max(1, solve.local.iterations)),
             solve.Range_deg());
}

}  // namespace
}  // namespace lake

int main(int argc, char** argv) {
  fmt::print("| people | variables | one solve | iterations | processor, s | ms per person and iteration | range |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  if (argc < 2)
    for (const int count : {1, 10, 30, 100}) lake::Measure(count);
  for (int i = 1; i < argc; ++i) lake::Measure(std::stoi(argv[i]));
}
