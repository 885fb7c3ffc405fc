#include "lake/problem/problem_file.h"

#include <algorithm>
#include <string>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/option_template.h"
#include "lake/problem/problem_options.h"

namespace lake::problem {
namespace {

namespace fs = std::filesystem;

OptionTexts TextsOf(const YamlNode& node, const Option& option, const fs::path& folder) {
  if (!node.IsList()) return {WithFile(option, node.AsText(), [&](const fs::path& file) { return folder / file; })};
  OptionTexts texts;
  for (const YamlNode& element : node.Elements()) texts.push_back(element.AsText());
  return texts;
}

// Errors are reported with the place that brought them.
template <typename Work>
void DoAt(const YamlNode& node, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
}

// The problem is checked as it then stands.
void ReadSection(YamlNode& node, OptionList& options, const fs::path& folder, const SynthesisProblem& problem) {
  for (Option& option : options.All())
    if (const auto child = node.Child(option.Key()))
      DoAt(*child, [&] {
        option.SetFromFile(TextsOf(*child, option, folder));
        problem.Check();
      });
  DoAt(node, [&] { options.RunChecks(); });
}

// The sections that a file has, or those of these names.
void ReadSections(YamlNode& node, const fs::path& folder, SynthesisProblem& problem,
                  const std::vector<std::string>& names = {}) {
  for (auto& [name, options] : SectionsOf(problem)) {
    if (!names.empty() && std::ranges::find(names, name) == names.end()) continue;
    auto child = name.empty() ? std::nullopt : node.Child(name);
    if (name.empty()) ReadSection(node, options, folder, problem);
    if (!child) continue;
    ReadSection(*child, options, folder, problem);
    child->Finish();
  }
}

}  // namespace

void ReadClearances(YamlNode& node, SynthesisProblem& problem) {
  ReadSections(node, {}, problem, {"body", "clearances"});
}

SynthesisProblem ReadProblem(YamlNode node, const fs::path& folder) {
  if (!node.IsMap()) throw Fail("{}: a problem is a map with the keys d_min_mm, bounds, margins, …", node.Where());
  ExpectKind(node, "problem");
  SynthesisProblem problem;
  ReadSections(node, folder, problem);
  node.Finish();
  return problem;
}

SynthesisProblem ReadProblem(const std::filesystem::path& path) {
  return ReadProblem(YamlNode::ReadFile(path), path.parent_path());
}

namespace {

// With every key set.
SynthesisProblem ExampleProblem() {
  SynthesisProblem example;
  for (const LimitInfo& info : kLimitInfos)
    if (*info.key) example.limits[info.key] = info.example;
  example.robust_mm = 0.1;
  example.mount = linkage::Mount::kBehind;
  example.actuator = FindActuator("LA31-1000");
  example.profile.emplace().file = "loads.json";
  example.assist = 0.4;
  example.goal = SynthesisProblem::Goal::kDuration;
  Clearances& clearances = example.clearances;
  clearances.seat_mm = clearances.thigh_mm = clearances.shank_mm = 5;
  clearances.seat_edge_mm = 200;
  clearances.body = {.height_mm = 1750, .mass_kg = 70, .leg = person::LegLengths{.thigh_mm = 410, .shank_mm = 400}};
  return example;
}

}  // namespace

std::string ProblemTemplate() {
  SynthesisProblem problem;
  const std::vector<ProblemSection> sections = SectionsOf(problem);
  problem = ExampleProblem();
  std::string lines;
  for (const auto& [name, options] : sections)
    lines += name.empty() ? OptionTemplate(options, 0) : name + ":\n" + OptionTemplate(options, 2);
  const std::size_t first = lines.find('\n') + 1;
  return "# What a design must satisfy, for `lake optimize --problem FILE` and `problem:` of a study. Remove the '#' "
         "before\n"
         "# a key, and before its section, to set it. With none set the problem is the paper's; other values are "
         "examples.\n" +
         lines.substr(0, first) + AsComment(lines.substr(first));
}

namespace {

// Both are taken apart whole, so that a new member does not compile until it is written here.

Json ActuatorJson(const LinearActuator& actuator) {
  const auto& [name, maker, source, file, closed_mm, travel_mm, max_force_n, no_load_speed_mm_s, force_speed,
               holding_force_n, mass_g, duty_cycle_percent] = actuator;
  Json json = {name, maker, source};
  for (const auto& number :
       {closed_mm, travel_mm, max_force_n, no_load_speed_mm_s, holding_force_n, mass_g, duty_cycle_percent})
    json.push_back(NumberOrNull(number));
  for (const auto& [force_n, speed_mm_s] : force_speed) json.push_back({force_n, speed_mm_s});
  return json;
}

Json ProfileJson(const LoadProfile& profile) {
  const auto& [samples, duration_s, moments_s, file] = profile;
  Json json = {duration_s, moments_s};
  for (const auto& [percent, knee_rad, rad_per_rise, knee_nm, slow_nm] : samples)
    json.push_back({percent, knee_rad, rad_per_rise, NumberOrNull(knee_nm), NumberOrNull(slow_nm)});
  return json;
}

}  // namespace

std::vector<InputFile> LoadFiles(const SynthesisProblem& problem) {
  std::vector<InputFile> files;
  if (problem.profile) files.push_back({problem.profile->file, "profile"});
  if (problem.actuator && !problem.actuator->file.empty()) files.push_back({problem.actuator->file, "actuator"});
  return files;
}

Json ProblemJson(const SynthesisProblem& problem) {
  SynthesisProblem described;
  const std::vector<ProblemSection> sections = SectionsOf(described);
  described = problem;
  Json json;
  for (const auto& [name, options] : sections)
    for (const Option& option : options.All())
      if (option.Name() != "profile" && option.Name() != "actuator") json[name][option.Key()] = option.Text();
  json["profile"] = problem.profile ? ProfileJson(*problem.profile) : Json();
  json["actuator"] = problem.actuator ? ActuatorJson(*problem.actuator) : Json();
  json["placement"] = {problem.clearances.placement_mm, NumberOrNull(problem.clearances.placement_reach_mm)};
  return json;
}

namespace {

// The options of a program that differ from its own values, by their keys; paths from this folder.
Json OptionsBeside(const SynthesisProblem& problem, const fs::path& folder,
                   void (*describe)(SynthesisProblem&, OptionList&)) {
  SynthesisProblem described;
  OptionList list;
  describe(described, list);
  described = problem;
  Json texts = Json::object();
  for (const Option& option : list.All()) {
    const std::string text = option.Text();
    if (text.empty() || text == option.DefaultText()) continue;
    texts[option.Key()] = WithFile(option, text, [&](const fs::path& file) {
      return fs::absolute(file).lexically_relative(fs::absolute(folder));
    });
  }
  return texts;
}

}  // namespace

linkage::Design DesignOf(const SynthesisProblem& problem, const linkage::Links& links) {
  linkage::Design design;
  design.links = links;
  design.d_min_mm = problem.d_min_mm;
  design.mount = problem.mount;
  return design;
}

void TakeRange(const DesignEvaluation& evaluation, linkage::Design& design) {
  if (evaluation.pose) design.range_deg = evaluation.range_deg;
  if (evaluation.stands_mm && *evaluation.stands_mm > design.d_min_mm) design.d_max_mm = evaluation.stands_mm;
}

void TakeProblem(const SynthesisProblem& problem, const fs::path& folder, linkage::Design& design) {
  design.parts = OptionsBeside(problem, folder, DescribeParts);
  design.body = OptionsBeside(problem, folder, DescribeBody);
  design.load = OptionsBeside(problem, folder, DescribeLoad);
  if (problem.knee_torque_nm != SynthesisProblem().knee_torque_nm)
    design.load["knee_torque_nm"] = FormatNumber(problem.knee_torque_nm);
}

fs::path TakeFromDesign(const Json& texts, const fs::path& file, OptionList options) {
  std::vector<std::pair<Option*, std::string>> taken;
  for (const auto& item : texts.items()) {
    const std::string& key = item.key();
    const auto option = std::ranges::find_if(options.All(), [&](const Option& o) { return o.Key() == key; });
    if (option == options.All().end()) throw Fail("{}: unknown key '{}'", file.string(), key);
    fs::path absent;
    const std::string text = WithFile(*option, item.value().get<std::string>(), [&](const fs::path& named) {
      fs::path place = (file.parent_path() / named).lexically_normal();
      if (!fs::exists(place)) absent = place;
      return place;
    });
    if (!absent.empty()) return absent;
    taken.emplace_back(&*option, text);
  }
  try {
    for (auto& [option, text] : taken) option->SetFromFile({text});
  } catch (const Error& error) {
    throw Fail("{}: {}", file.string(), error.what());
  }
  return {};
}

}  // namespace lake::problem
