#include "lake/reviewing/design_review.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <optional>

#include "lake/commands/optimize.h"
#include "lake/commands/simulate.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/results_subject.h"
#include "lake/core/run.h"
#include "lake/core/shell_word.h"
#include "lake/core/yaml.h"
#include "lake/problem/problem_file.h"
#include "lake/redesign/redesign_outcome.h"
#include "result_inputs.h"
#include "run_program.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

// Those of lake-optimize's options that judge an optimum, or that the page gives itself.
constexpr std::array kLeftOut = {"start", "starts", "certify", "yield", "round", "pareto", "actuators"};

bool IsSameFolder(const fs::path& one, const fs::path& other) {
  return (one / "").lexically_normal() == (other / "").lexically_normal();
}

// A folder of results and what its summary says.
struct Folder {
  fs::path path;
  Json summary;

  bool IsOfStudy() const { return reviewing::IsOfStudy(summary); }

  // Where a file or folder that an option names is now; as it was named, if it is among no inputs.
  std::string Find(const fs::path& named) const {
    for (const Json& input : summary.at("inputs")) {
      const fs::path path_then = input.at("path").get<std::string>();
      if (IsSameFolder(path_then.parent_path(), named)) return FindInput(input, path).parent_path().string();
      if (path_then == named) return FindInput(input, path).string();
    }
    return named.string();
  }

  // Gives the options the values that are said.
  void Give(const Json& said, OptionList& list) const {
    for (Option& option : list.All()) {
      const auto value = said.find(option.Name());
      if (value == said.end()) continue;
      OptionTexts texts = value->is_array() ? value->get<OptionTexts>() : OptionTexts{value->get<std::string>()};
      if (texts == OptionTexts{""}) continue;
      if (option.PathKind() != Option::Path::kNone)
        for (std::string& text : texts) text = Find(text);
      option.Give(texts);
    }
  }
};

Folder FolderAt(const fs::path& path) {
  return {path, ReadSummary(path / "summary.json")};
}

void AddWords(const OptionList& list, std::vector<std::string>& words) {
  for (const Option& option : list.All()) {
    if (std::ranges::count(kLeftOut, option.Name())) continue;
    const std::vector<std::string> more = WordsOf(option);
    words.insert(words.end(), more.begin(), more.end());
  }
}

// The folder of the study file whose step has its results here; that of the results, where it is not to be found.
// The study file of a folder of lake-run's with this summary, as it is now: it may have been edited since.
fs::path StudyFileOf(const Json& summary, const fs::path& folder) {
  const fs::path named = summary.at("options").at("study").get<std::string>();
  for (const fs::path& made : SubjectsOf(folder))
    if (made.filename() == named.filename() && fs::exists(made)) return made;
  for (const fs::path& place : WithAbove(fs::absolute(folder)))
    if (fs::exists(place / named)) return place / named;
  if (fs::exists(named)) return named;
  throw Fail("{}: is not to be found; start lake review in the folder in which {} was made", named.string(),
             folder.string());
}

fs::path StudyFolderOf(const fs::path& results) {
  const fs::path above = (fs::absolute(results) / "").lexically_normal().parent_path().parent_path();
  if (MakerOf(above) != "lake-run") return results;
  return StudyFileOf(ReadSummary(above / "summary.json"), above).parent_path();
}

// The problem of a study's step that stands in its section of the study file, which its files are named from.
void ReadInlineProblem(const Folder& folder, problem::SynthesisProblem& problem) {
  YamlNode summary = YamlNode::ReadFile(folder.path / "summary.json");
  YamlNode options = *summary.Child("options");
  if (auto inline_problem = options.Child("problem"); inline_problem && inline_problem->IsMap())
    problem = problem::ReadProblem(std::move(*inline_problem), StudyFolderOf(folder.path));
}

// The clearances that a design was held to, the body and the parts: a study takes them from its sections and the
// person.
void TakeClearances(const Json& summary, problem::SynthesisProblem& problem) {
  const Json used = summary.value("clearances", Json());
  if (!used.is_object()) return;
  problem::Clearances& clearances = problem.clearances;
  const auto limit = [&](const char* key, std::optional<double>& mm) {
    if (used.at(key).is_number()) mm = used.at(key).get<double>();
  };
  limit("seat_mm", clearances.seat_mm);
  limit("limb_mm", clearances.thigh_mm);
  limit("limb_mm", clearances.shank_mm);
  clearances.body.height_mm = used.at("height_mm");
  clearances.body.mass_kg = used.at("mass_kg");
  clearances.body.leg = {used.at("thigh_mm").get<double>(), used.at("shank_mm").get<double>()};
  clearances.seat_edge_mm = used.value("seat_edge_mm", clearances.seat_edge_mm);
  problem.parts.bar_width_mm = used.value("bar_width_mm", problem.parts.bar_width_mm);
  problem.parts.actuator_diameter_mm = used.value("actuator_diameter_mm", problem.parts.actuator_diameter_mm);
}

// The comparison that a design was made for; empty: none, or one of each of several people.
fs::path ComparisonOf(const Folder& folder, const commands::ReoptimizeRunOptions& motion) {
  if (motion.comparisons.size() == 1) return motion.comparisons.front();
  const fs::path beside = folder.path / ".." / "comparison";
  return motion.comparisons.empty() && folder.IsOfStudy() && fs::exists(beside) ? beside : fs::path();
}

// Through these knee angles, as far as the links reach them; nothing if they cannot be assembled.
std::optional<review::InMotion> ThroughAngles(const redesign::RedesignProblem& problem, const compare::StsCurve& human,
                                              const std::vector<double>& knee_rad, linkage::Design design) {
  const auto strokes = redesign::StrokesForAngles(problem.Driven(design.links), knee_rad);
  if (!strokes) return std::nullopt;
  const double rise_s = redesign::TrackingTime(*strokes, problem.program.max_speed_mm_s);
  design.d_max_mm.reset();
  design.program = linkage::StrokeProgram{
      .kind = linkage::StrokeProgram::Kind::kFree, .speed_mm_s = problem.program.max_speed_mm_s, .knots = {}};
  for (std::size_t i = 0; i < strokes->size(); ++i)
    design.program->knots.push_back(
        {rise_s * static_cast<double>(i) / static_cast<double>(strokes->size() - 1), (*strokes)[i]});
  const redesign::DesignInMotion driven = redesign::PutInMotion(problem, human, design);
  if (!driven.misalignment) return std::nullopt;
  return review::InMotion{100 * driven.misalignment->metrics.relative_rms, rise_s};
}

void TakeMotion(const Folder& folder, const commands::ReoptimizeRunOptions& motion, review::ExploredDesign& explored) {
  const fs::path comparison = ComparisonOf(folder, motion);
  redesign::DesignInMotion saved;
  redesign::RedesignProblem problem;
  compare::StsCurve human;
  if (!comparison.empty()) {
    human = compare::ReadComparisonOfRises(comparison).human;
    problem.design = explored.problem;
    problem.program = motion.program;
    problem.human = redesign::MakeHumanMotion(human);
    saved = redesign::PutInMotion(problem, human, explored.design);
  }
  if (!saved.prediction) {
    explored.notes.push_back(
        "the misalignment with the person's motion is not evaluated here: lake optimize and lake compare do that");
    return;
  }
  explored.max_misalignment_percent = motion.max_misalignment_percent;
  explored.max_rise_s = explored.problem.duration_s;
  explored.in_motion = [problem, human, saved](const linkage::Links& links) {
    linkage::Design design = saved.design;
    design.links = links;
    return ThroughAngles(problem, human, saved.prediction->theta_rad, design);
  };
}

// The moments of the rise that the design was found for.
void TakePace(const Json& summary, problem::SynthesisProblem& problem) {
  const Json assistance = summary.value("assistance", Json());
  if (!problem.HasLoadProfile() || !assistance.is_object()) return;
  const double moments_s = NumberOrNaN(assistance.value("moments_of_s", Json()));
  if (std::isfinite(moments_s))
    problem.profile = problem::AtPace(*problem.profile, moments_s).value_or(*problem.profile);
}

// Limits as lake-optimize had them.
void TakeLimits(const Folder& folder, DesignSubject& subject) {
  commands::OptimizeRunOptions options;
  commands::ReoptimizeRunOptions motion;
  OptionList list = OptionsOf(options), motion_list = OptionsOf(motion).Without({"duration"});
  Json said = GivenOptions(folder.summary, folder.path);
  const bool has_motion = folder.summary.contains("misalignment_percent");
  if (folder.IsOfStudy()) {
    const Json& all = folder.summary.at("options");
    ReadInlineProblem(folder, options.problem);
    if (has_motion || all.value("problem", Json()).is_object() || all.contains("clearances"))
      subject.no_command = "this is a step of a study: change its section of the study file, and run lake run again";
    if (const Json* profile = InputOf(folder.summary, "profile")) said["profile"] = profile->at("path");
  }
  folder.Give(said, list);
  list.Apply();
  AddWords(list, subject.limit_words);
  subject.explored.problem = problem::WithActuator(options.problem);
  TakeClearances(folder.summary, subject.explored.problem);
  TakePace(folder.summary, subject.explored.problem);
  subject.explored.limits = fmt::format("the limits of {}", folder.path.string());
  if (!has_motion) return;
  folder.Give(said, motion_list);
  motion_list.Apply();
  AddWords(motion_list, subject.limit_words);
  TakeMotion(folder, motion, subject.explored);
}

linkage::Design DesignOfSimulation(const Folder& folder) {
  linkage::Design design;
  const Json& options = folder.summary.at("options");
  const std::string links = options.value("links", "");
  if (!links.empty()) {
    design.links = linkage::Links::FromValues([&] {
      std::array<double, 6> values{};
      const Json& said = folder.summary.at("links");
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = said.at(problem::LinkName(i));
      return values;
    }());
  } else {
    design = linkage::ReadDesign(FindInput(folder.summary, "design", folder.path));
  }
  const Json& used = folder.summary.at("used_stroke_mm");
  design.d_min_mm = used.at(0);
  design.d_max_mm = used.at(1);
  design.mount = linkage::MountOf(folder.summary.at("mannequin").value("mount", "beside"));
  return design;
}

// The paper's limits, at the design's shortest stroke.
void TakePapersLimits(DesignSubject& subject) {
  problem::SynthesisProblem problem;
  if (problem.d_min_mm != subject.explored.design.d_min_mm)
    subject.no_command = "the design's shortest stroke is not that of the paper's problem: give limits with --problem";
  problem.d_min_mm = subject.explored.design.d_min_mm;
  problem.mount = subject.explored.design.mount;
  subject.explored.problem = problem;
  subject.explored.limits = "the limits of the paper's problem; --problem gives others";
}

void TakeProblem(const fs::path& file, DesignSubject& subject) {
  subject.explored.problem = problem::WithActuator(problem::ReadProblem(file));
  subject.explored.limits = fmt::format("the limits of {}", file.string());
  subject.limit_words = {"--problem", file.string()};
}

void ReadSubject(const fs::path& subject, DesignSubject& result) {
  const bool is_folder = fs::is_directory(subject);
  result.folder = is_folder ? subject : subject.parent_path();
  const fs::path named = fs::absolute(subject).lexically_normal();  // "." has a name
  result.explored.name = (named.has_filename() ? named : named.parent_path()).filename().string();
  std::optional<Folder> simulation;
  if (is_folder && MakerOf(subject) == "lake-simulate") simulation = FolderAt(subject);
  result.explored.design =
      simulation ? DesignOfSimulation(*simulation) : linkage::ReadDesign(is_folder ? subject / "design.yaml" : subject);
  if (FindsDesigns(MakerOf(result.folder)))
    TakeLimits(FolderAt(result.folder), result);
  else
    TakePapersLimits(result);
  if (simulation && simulation->summary.contains("knee_torque_nm"))
    result.explored.problem.knee_torque_nm = simulation->summary.at("knee_torque_nm");
}

// `stem` + `ending`, or the first of `stem`-2, -3, … that `take` takes.
fs::path FirstFree(const fs::path& stem, const std::string& ending, const std::function<bool(const fs::path&)>& take) {
  constexpr int kMost = 10000;
  for (int i = 1; i < kMost; ++i) {
    fs::path path = stem;
    path += i == 1 ? ending : fmt::format("-{}{}", i, ending);
    if (take(path)) return path;
  }
  throw Fail("{}{}: there are {} of these already", stem.string(), ending, kMost);
}

bool IsFree(const fs::path& path) {
  return !fs::exists(fs::symlink_status(path));
}

// Makes the file, unless there is one: two programs never get the same name.
bool MakeEmpty(const fs::path& path) {
  if (std::FILE* const file = std::fopen(path.c_str(), "wx")) return std::fclose(file) == 0;
  if (errno == EEXIST) return false;
  throw Fail("{}: {}", path.string(), std::strerror(errno));
}

// As explored.yaml, or the first of explored-2.yaml, … that is free.
fs::path SaveExplored(const fs::path& folder, const linkage::Design& design) {
  const fs::path path = FirstFree(folder / "explored", ".yaml", MakeEmpty);
  try {
    linkage::WriteDesign(path, design);
  } catch (const Error&) {
    fs::remove(path);
    throw;
  }
  return path;
}

std::vector<std::string> ArgumentsOf(const DesignSubject& subject, const linkage::Links& links, const fs::path& out) {
  if (!subject.no_command.empty()) throw Error(subject.no_command);
  std::vector<std::string> texts;
  constexpr double kSteps = 1e4;  // finer than anybody chooses a start
  for (const double length : links.Values()) texts.push_back(FormatNumber(std::round(kSteps * length) / kSteps));
  std::vector<std::string> words = subject.limit_words;
  words.insert(words.end(), {"--start", fmt::format("{}", fmt::join(texts, ",")), "--starts", "1", "-o", out.string()});
  return words;
}

fs::path OptimumOf(const DesignSubject& subject) {
  const std::string name = fs::path(subject.explored.name).stem().string();
  return FirstFree(fs::path("lake-out") / (name + "-optimised"), "", IsFree);
}

linkage::Design Optimise(const DesignSubject& subject, const fs::path& programs, const linkage::Links& links,
                         const review::BackgroundJob::Control& control) {
  const fs::path out = OptimumOf(subject);
  RunProgram(programs / "lake-optimize", ArgumentsOf(subject, links, out), control);
  return linkage::ReadDesign(out / "design.yaml");
}

}  // namespace

DesignSubject ReadDesignSubject(const fs::path& subject, const fs::path& problem_file) {
  DesignSubject result;
  try {
    ReadSubject(subject, result);
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake writes it ({})", (result.folder / "summary.json").string(), error.what());
  }
  if (!problem_file.empty()) {
    result.no_command.clear();
    TakeProblem(problem_file, result);
  }
  return result;
}

review::DesignWork DesignWorkOf(const DesignSubject& subject, const fs::path& programs) {
  review::DesignWork work;
  work.save = [subject](const linkage::Design& design) { return SaveExplored(subject.folder, design); };
  work.command = [subject](const linkage::Links& links) {
    std::string command = "lake optimize";
    for (const std::string& word : ArgumentsOf(subject, links, OptimumOf(subject)))
      command += fmt::format(" {}", ShellWord(word));
    return command;
  };
  work.optimise = [subject, programs](const linkage::Links& links, const review::BackgroundJob::Control& control) {
    return Optimise(subject, programs, links, control);
  };
  return work;
}

}  // namespace lake::reviewing
