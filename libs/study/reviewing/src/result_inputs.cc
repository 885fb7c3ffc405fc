#include "result_inputs.h"

#include <set>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/core/results_subject.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

// Of each text in it that begins with the home folder.
void PutHomeInto(Json& json) {
  if (json.is_string()) json = FromHome(json.get<std::string>()).string();
  if (json.is_structured())
    for (Json& value : json) PutHomeInto(value);
}

// Where files of a run may lie: they are named as from the folder in which it was started, which is the present one or,
// as a rule, one above the results or above what the results are of.
std::vector<fs::path> PlacesOfInputs(const fs::path& results) {
  std::vector<fs::path> places = {fs::current_path()};
  const auto add_with_above = [&](const fs::path& folder) {
    const std::vector<fs::path> more = WithAbove(folder);
    places.insert(places.end(), more.begin(), more.end());
  };
  add_with_above(fs::absolute(results));
  for (const fs::path& subject : SubjectsOf(results)) add_with_above(subject.parent_path());
  return places;
}

}  // namespace

std::vector<fs::path> WithAbove(const fs::path& folder) {
  std::vector<fs::path> places;
  for (fs::path place = folder.lexically_normal(); place.has_relative_path(); place = place.parent_path())
    places.push_back(place);
  return places;
}

Json ReadSummary(const fs::path& file) {
  Json summary = ReadJsonFile(file);
  for (const char* part : {"options", "inputs"})
    if (const auto found = summary.find(part); found != summary.end()) PutHomeInto(*found);
  return summary;
}

bool IsOfStudy(const Json& summary) {
  return !summary.at("options").contains("out");
}

Json GivenOptions(const Json& summary, const fs::path& folder) {
  const Json& options = summary.at("options");
  if (!summary.contains("given"))
    throw Fail("{}: was made by an older version of lake; make it again", (folder / "summary.json").string());
  Json given = Json::object();
  for (const Json& name : summary.at("given")) given[name.get<std::string>()] = options.at(name.get<std::string>());
  return given;
}

fs::path FindInput(const Json& input, const fs::path& results) {
  const fs::path path = input.at("path").get<std::string>();
  const std::vector<fs::path> places = PlacesOfInputs(results);
  bool is_there = false;
  std::set<fs::path> seen;  // a long video is not hashed twice
  for (const fs::path& named : {path, path.has_filename() ? path.filename() : path.parent_path().filename()})
    for (const fs::path& place : places) {
      const fs::path candidate = (place / named).lexically_normal();
      std::error_code error;
      if (!seen.insert(candidate).second || !fs::exists(candidate, error)) continue;
      is_there = is_there || named == path;
      if (input.at("sha256") == Sha256OfFile(candidate)) return candidate;
    }
  throw is_there ? Fail("{}: has changed since {} was made; make it again", path.string(), results.string())
                 : Fail(
                       "{}: is not to be found; start lake review in the folder in which {} was made, or in the one "
                       "that the file lies in now",
                       path.string(), results.string());
}

const Json* InputOf(const Json& summary, const std::string& role) {
  for (const Json& input : summary.at("inputs"))
    if (input.value("role", "") == role) return &input;
  return nullptr;
}

fs::path FindInput(const Json& summary, const std::string& role, const fs::path& results) {
  const Json* input = InputOf(summary, role);
  if (!input)
    throw Fail("{}: names no input that is the {}; it may be of an older version of lake: make it again",
               (results / "summary.json").string(), role);
  return FindInput(*input, results);
}

std::string MakerOf(const fs::path& folder) {
  const fs::path path = folder / "summary.json";
  if (!fs::exists(path)) return {};
  const Json summary = ReadJsonFile(path);
  const auto program = summary.find("program");
  return program != summary.end() && program->is_string() ? program->get<std::string>() : "";
}

bool FindsDesigns(const std::string& program) {
  return program == "lake-optimize" || program == "lake-redesign";
}

std::string OperandOf(const fs::path& path) {
  return (path.string().starts_with("-") ? "./" : "") + path.string();
}

std::vector<std::string> WordsOf(const Option& option) {
  std::vector<std::string> words;
  if (option.IsFlag()) {
    const bool is_on = !option.Given().empty() && option.Given().front() == "true";
    if (is_on || (option.HasNegation() && !option.Given().empty()))
      words.push_back(fmt::format("--{}{}", is_on ? "" : "no-", option.Name()));
    return words;
  }
  for (const std::string& text : option.Given()) words.insert(words.end(), {fmt::format("--{}", option.Name()), text});
  return words;
}

}  // namespace lake::reviewing
