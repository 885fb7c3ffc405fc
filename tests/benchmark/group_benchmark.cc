// One design for many people: processor time and iterations over the number of people, and what the common design is.
//
//   lake_group_benchmark [PEOPLE …]                    one solve; default: 1 10 30 100
//   lake_group_benchmark --common [PEOPLE …]           the whole search for one design; default: 5 10 25 50 100
//   lake_group_benchmark --sizes K [PEOPLE …]          the whole search for K sizes; default: 10 25 50 100
//   lake_group_benchmark --write FOLDER PEOPLE         their comparisons, for lake-optimize
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>

#include "compare/closed_form.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/json.h"
#include "lake/core/threads.h"
#include "lake/redesign/sizes.h"

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
    leg.shank_mm = 0.246 * height_mm;
    leg.thigh_mm = 0.245 * height_mm;
    leg.seated_knee_deg = seated(random);
    leg.peak_shank_deg = peak(random);
    people.push_back({fmt::format("sub-{:03}", i + 1), {MakeCurve(leg)}});
  }
  return people;
}

redesign::GroupProblem Problem(double limit_percent) {
  redesign::GroupProblem problem;
  problem.shared.design.grashof_margin_mm = problem.shared.design.singularity_margin_mm = 2;
  problem.shared.program.kind = linkage::StrokeProgram::Kind::kFree;
  problem.shared.program.duration_s = 22;
  problem.shared.fit_placement = true;
  problem.shared.max_misalignment_percent = limit_percent;
  return problem;
}

// Of this process and of those that it waited for.
double Processor_s() {
  double sum = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    for (const timeval& time : {used.ru_utime, used.ru_stime})
      sum += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return sum;
}

void Measure(int count) {
  redesign::GroupProblem problem = Problem(3);
  std::vector<redesign::RedesignPoint> start;
  for (const redesign::PersonMeasured& person : Draw(count, 1))
    problem.people.push_back({person.name, redesign::MakeHumanMotion(person.motion.human)});
  for (int i = 0; i < count; ++i) start.push_back(redesign::StartPoint(problem.Of(i), problem.shared.design.start));
  const double before_s = Processor_s();
  const redesign::RedesignSolve solve = redesign::SolveFrom(problem, start);
  const double took_s = Processor_s() - before_s;
  fmt::print("| {} | {} | {} | {} | {:.2f} | {:.1f} | {:.4f} |\n", count,
             solve.local.program.program.Variables().size(), solve.IsUsable() ? "solved" : solve.local.solution.message,
             solve.local.iterations, took_s, 1e3 * took_s / (count * std::max(1, solve.local.iterations)),
             solve.Range_deg());
}

// The largest process, MB.
double Memory_mb() {
  long most_kb = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    most_kb = std::max(most_kb, used.ru_maxrss);
  }
  return 1e-3 * static_cast<double>(most_kb);
}

constexpr double kLimit_percent = 3.5;  // one of the hundred cannot hold 3 %, whatever the design

// The work's time and memory as the first columns of a row; what it returns are the others.
void MeasureWhole(int count, const std::function<std::string()>& work) {
  const double before_s = Processor_s();
  const auto begin = std::chrono::steady_clock::now();
  const std::string result = work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  const double took_s = Processor_s() - before_s;
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.2f} | {:.0f} | {} |\n", count, Threads(), elapsed.count(), took_s,
             took_s / count, Memory_mb(), result);
  std::fflush(stdout);
}

std::string CommonDesign(int count) {
  const redesign::GroupOutcome outcome = redesign::RunGroup(Problem(kLimit_percent), Draw(count, 1), {});
  return fmt::format("{:.4f} | {}", outcome.evaluation.range_deg, outcome.reason);
}

std::string Sizes(int sizes, int count) {
  const redesign::SizesOutcome outcome = redesign::RunSizes(Problem(kLimit_percent), Draw(count, 1), sizes, {}, {});
  std::string ranges;
  for (const redesign::GroupOutcome& size : outcome.sizes)
    ranges += fmt::format(" {}: {:.3f}", size.people.size(), size.evaluation.range_deg);
  return fmt::format("{:.4f} | {} |{} | {}", outcome.mean_value_deg, outcome.is_settled ? "yes" : "no", ranges,
                     outcome.Reason());
}

void Write(const std::filesystem::path& folder, int count) {
  for (const redesign::PersonMeasured& person : Draw(count, 1)) {
    compare::MisalignmentOptions options;
    options.intervals = false;
    const compare::Misalignment misalignment =
        compare::CompareTrials({{person.motion.human}, {}}, {{person.motion.human}, {}}, options);
    std::filesystem::create_directories(folder / person.name);
    WriteJsonFile(folder / person.name / "comparison.json", compare::ComparisonJson(misalignment));
  }
}

// The numbers after the first `from` arguments, or else `otherwise`.
std::vector<int> Counts(const std::vector<std::string>& arguments, std::size_t from, std::vector<int> otherwise) {
  if (arguments.size() <= from) return otherwise;
  std::vector<int> counts;
  for (std::size_t i = from; i < arguments.size(); ++i) counts.push_back(std::stoi(arguments[i]));
  return counts;
}

}  // namespace
}  // namespace lake

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments[0] == "--write") {
    lake::Write(arguments.at(1), std::stoi(arguments.at(2)));
  } else if (!arguments.empty() && arguments[0] == "--common") {
    fmt::print("| people | threads | elapsed, s | processor, s | s per person | memory, MB | range, ° | |\n");
    fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (const int count : lake::Counts(arguments, 1, {5, 10, 25, 50, 100}))
      lake::MeasureWhole(count, [&] { return lake::CommonDesign(count); });
  } else if (!arguments.empty() && arguments[0] == "--sizes") {
    fmt::print(
        "| people | threads | elapsed, s | processor, s | s per person | memory, MB | mean, ° | settled | people: "
        "range, ° | |\n");
    fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (const int count : lake::Counts(arguments, 2, {10, 25, 50, 100}))
      lake::MeasureWhole(count, [&] { return lake::Sizes(std::stoi(arguments.at(1)), count); });
  } else {
    fmt::print(
        "| people | variables | one solve | iterations | processor, s | ms per person and iteration | range |\n");
    fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
    for (const int count : lake::Counts(arguments, 0, {1, 10, 30, 100})) lake::Measure(count);
  }
}
