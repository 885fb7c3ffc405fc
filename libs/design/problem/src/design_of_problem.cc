#include "lake/problem/design_of_problem.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/problem/problem_options.h"

namespace lake::problem {
namespace {

namespace fs = std::filesystem;

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
      const fs::path place = (file.parent_path() / named).lexically_normal();
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
