#include "lake/problem/problem_file.h"

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/options_json.h"
#include "lake/problem/problem_options.h"
#include "load_texts.h"

namespace lake::problem {
namespace {

namespace fs = std::filesystem;

// Checks the problem as it now stands, so that an error is reported with the line that brought it.
void CheckAt(const std::string& where, const SynthesisProblem& problem) {
  try {
    problem.Check();
  } catch (const Error& error) {
    throw Fail("{}: {}", where, error.what());
  }
}

// Reads numbers of one map into fields of the problem.
class Reader {
 public:
  Reader(YamlNode& node, SynthesisProblem& problem) : node_(node), problem_(problem) {}

  template <typename Field>
  Reader& Number(std::string_view key, Field& field) {
    const auto child = node_.Child(key);
    if (!child) return *this;
    field = child->AsNumber();
    CheckAt(child->Where(), problem_);
    return *this;
  }
  // Those that stand in this map.
  Reader& Limits(std::string_view section) {
    for (const LimitInfo& info : kLimitInfos)
      if (*info.key && section == info.section) Number(info.key, problem_.limits[info.key]);
    return *this;
  }

 private:
  YamlNode& node_;
  SynthesisProblem& problem_;
};

void ReadBounds(YamlNode node, SynthesisProblem& problem) {
  for (std::size_t i = 0; i < problem.bounds.size(); ++i) {
    const auto pair = node.Numbers(LinkName(i), 2);
    if (!pair) continue;
    problem.bounds[i] = {(*pair)[0], (*pair)[1]};
    CheckAt(node.Child(LinkName(i))->Where(), problem);
  }
  node.Finish();
}

void ReadStart(YamlNode node, SynthesisProblem& problem) {
  auto values = problem.start.Values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto child = node.Child(LinkName(i));
    if (!child) continue;
    values[i] = child->AsNumber();
    problem.start = linkage::Links::FromValues(values);
    CheckAt(child->Where(), problem);
  }
  node.Finish();
}

// Sets what a text says, so that an error is reported with its line.
template <typename Set>
void SetAt(const YamlNode& node, const SynthesisProblem& problem, const Set& set) {
  try {
    set(node.AsText());
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
  CheckAt(node.Where(), problem);
}

void ReadLoad(YamlNode node, const fs::path& folder, SynthesisProblem& problem) {
  Reader(node, problem)
      .Number("knee_torque_nm", problem.knee_torque_nm)
      .Number("assist", problem.assist)
      .Limits("load");
  if (const auto profile = node.Child("profile"))
    SetAt(*profile, problem, [&](const std::string& text) { problem.profile = ReadLoadProfile(folder / text); });
  if (const auto rest = node.Child("rest"))
    SetAt(*rest, problem, [&](const std::string& text) { SetRest(text, problem); });
  if (const auto duration = node.Child("duration_s"))
    SetAt(*duration, problem, [&](const std::string& text) { SetDuration(text, problem); });
  node.Finish();
}

// Sets a number if the node has it.
void SetNumber(YamlNode& node, std::string_view key, std::optional<double>& field) {
  if (const auto child = node.Child(key)) field = child->AsNumber();
}

// By the keys of the options that describe them.
void ReadByOptions(YamlNode node, SynthesisProblem& problem, void (*describe)(SynthesisProblem&, OptionList&)) {
  OptionList options;
  describe(problem, options);
  ReadOptions(node, options, [](const YamlNode& path, const Option&) { return OptionTexts{path.AsText()}; });
  CheckAt(node.Where(), problem);
  node.Finish();
}

}  // namespace

void ReadClearances(YamlNode& node, SynthesisProblem& problem) {
  if (auto body = node.Child("body")) ReadByOptions(std::move(*body), problem, DescribeBody);
  auto clearances = node.Child("clearances");
  if (!clearances) return;
  Clearances& asked = problem.clearances;
  SetNumber(*clearances, "seat_mm", asked.seat_mm);
  SetNumber(*clearances, "limb_mm", asked.thigh_mm);
  asked.shank_mm = asked.thigh_mm;
  CheckAt(clearances->Where(), problem);
  clearances->Finish();
}

void SetRest(const std::string& text, SynthesisProblem& problem) {
  if (text != "anywhere" && text != "standing") throw UsageError("rest is anywhere or standing, not '{}'", text);
  problem.rests_anywhere = text == "anywhere";
}

void SetDuration(const std::string& text, SynthesisProblem& problem) {
  const bool is_free = text == "free";
  const std::optional<double> number = is_free ? std::nullopt : ParseNumber(text);
  if (!is_free && !(number && *number > 0 && *number <= SynthesisProblem::kLongestDuration_s))
    throw UsageError("a duration (--duration, duration_s) is free or a number of seconds above 0, at most {}, not '{}'",
                     SynthesisProblem::kLongestDuration_s, text);
  problem.duration_s = number;
  problem.goal = is_free ? SynthesisProblem::Goal::kDuration : SynthesisProblem::Goal::kRange;
}

SynthesisProblem ReadProblem(YamlNode node, const fs::path& folder) {
  if (!node.IsMap()) throw Fail("{}: a problem is a map with the keys d_min_mm, bounds, margins, …", node.Where());
  ExpectKind(node, "problem");
  SynthesisProblem problem;
  Reader(node, problem)
      .Number("d_min_mm", problem.d_min_mm)
      .Number("standing_deg", problem.standing_deg)
      .Limits("")
      .Number("robust_mm", problem.robust_mm);
  if (auto bounds = node.Child("bounds")) ReadBounds(std::move(*bounds), problem);
  if (auto start = node.Child("start")) ReadStart(std::move(*start), problem);
  if (auto margins = node.Child("margins")) {
    Reader(*margins, problem)
        .Number("grashof_mm", problem.grashof_margin_mm)
        .Number("singularity_mm", problem.singularity_margin_mm);
    margins->Finish();
  }
  if (const auto mount = node.Child("mount"))
    SetAt(*mount, problem, [&](const std::string& text) { problem.mount = linkage::MountOf(text); });
  ReadClearances(node, problem);
  if (auto parts = node.Child("parts")) ReadByOptions(std::move(*parts), problem, DescribeParts);
  if (auto load = node.Child("load")) ReadLoad(std::move(*load), folder, problem);
  if (const auto actuator = node.Child("actuator"))
    SetAt(*actuator, problem, [&](const std::string& text) { problem.actuator = FindActuator(text, folder); });
  node.Finish();
  return problem;
}

SynthesisProblem ReadProblem(const std::filesystem::path& path) {
  return ReadProblem(YamlNode::ReadFile(path), path.parent_path());
}

namespace {

// Each struct is taken apart whole, so that a new member does not compile until it is written here.

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

Json BodyJson(const person::BodySize& body) {
  const auto& [height_mm, mass_kg, leg] = body;
  return {NumberOrNull(height_mm), NumberOrNull(mass_kg), leg ? Json{leg->thigh_mm, leg->shank_mm} : Json()};
}

Json ClearancesJson(const Clearances& clearances) {
  const auto& [seat_mm, thigh_mm, shank_mm, body, seat_edge_mm, placement_mm, placement_reach_mm] = clearances;
  return {NumberOrNull(seat_mm), NumberOrNull(thigh_mm), NumberOrNull(shank_mm),          BodyJson(body),
          seat_edge_mm,          placement_mm,           NumberOrNull(placement_reach_mm)};
}

Json PartsJson(parts::PartOptions parts) {
  OptionList options;
  parts::Describe(parts, options);
  return OptionsJson(options);
}

Json BoundsJson(const std::array<Bounds, 6>& bounds) {
  Json json = Json::array();
  for (const auto& [lower, upper] : bounds) json.push_back({lower, upper});
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
  const auto& [limits, d_min_mm, bounds, start, grashof_margin_mm, singularity_margin_mm, knee_torque_nm, standing_deg,
               mount, clearances, parts, profile, assist, actuator, rests_anywhere, duration_s, robust_mm, goal] =
      problem;
  Json asked;
  for (const LimitInfo& info : kLimitInfos)
    if (*info.key) asked[info.key] = NumberOrNull(limits[info.key]);
  return {{"d_min_mm", d_min_mm},
          {"limits", asked},
          {"bounds", BoundsJson(bounds)},
          {"start", start.Values()},
          {"grashof_margin_mm", grashof_margin_mm},
          {"singularity_margin_mm", singularity_margin_mm},
          {"knee_torque_nm", knee_torque_nm},
          {"standing_deg", standing_deg},
          {"mount", linkage::NameOf(mount)},
          {"clearances", ClearancesJson(clearances)},
          {"parts", PartsJson(parts)},
          {"profile", profile ? ProfileJson(*profile) : Json()},
          {"assist", NumberOrNull(assist)},
          {"actuator", actuator ? ActuatorJson(*actuator) : Json()},
          {"rests_anywhere", rests_anywhere},
          {"duration_s", NumberOrNull(duration_s)},
          {"robust_mm", NumberOrNull(robust_mm)},
          {"seeks_duration", goal == SynthesisProblem::Goal::kDuration}};
}

}  // namespace lake::problem
