#include "lake/cohort/cohort_file.h"

#include <algorithm>
#include <map>
#include <optional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"
#include "lake/core/yaml.h"
#include "lake/gait/movement.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNotKnown = "n/a";

bool IsLabel(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c); });
}

bool IsNumber(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

// "sub-01" of the entity "sub".
bool IsEntity(std::string_view text, std::string_view entity) {
  return text.size() > entity.size() && text.starts_with(entity) && text[entity.size()] == '-' &&
         IsLabel(text.substr(entity.size() + 1));
}

// participants.tsv: each person's cells by column.
class Participants {
 public:
  explicit Participants(const fs::path& path) : path_(path), table_(CsvTable::Read(path, '\t')) {
    if (table_.Header().front() != "participant_id")
      throw Fail("{}:1: the first column must be participant_id, not '{}'", path.string(), table_.Header().front());
    for (std::size_t row = 0; row < table_.Rows(); ++row) {
      const std::string& id = table_.Text(row, 0);
      if (!IsEntity(id, "sub"))
        throw Fail("{}: '{}' must be sub- and a label of letters and digits, e.g. sub-01", table_.Where(row), id);
      if (!rows_.try_emplace(id, row).second) throw Fail("{}: {} stands twice", table_.Where(row), id);
      names_.push_back(id);
    }
    if (names_.empty()) throw Fail("{}: there are no participants", path.string());
    CheckColumn("mass_kg", kPlausibleMass.low, kPlausibleMass.high);
    CheckColumn("height_mm", kPlausibleStature.low, kPlausibleStature.high);
    CheckColumn("seat_height_mm", kLowestSeat_mm, kHighestSeat_mm);
  }

  const std::vector<std::string>& Names() const { return names_; }
  bool Has(const std::string& id) const { return rows_.contains(id); }

  // Of everybody.
  bool HasNumbers(const std::string& column) const {
    if (!table_.Has(column)) return false;
    for (const std::string& name : names_)
      if (!Cell(name, column)) return false;
    return true;
  }

  // nullopt where it is not known.
  std::optional<std::string> Cell(const std::string& id, const std::string& column) const {
    if (!table_.Has(column))
      throw Fail("cohort.yaml: ${}: no such column in {}; it has {}", column, path_.string(),
                 fmt::join(table_.Header(), ", "));
    const std::string text(Trim(table_.Text(rows_.at(id), table_.Column(column))));
    return text.empty() || text == kNotKnown ? std::nullopt : std::optional(text);
  }

 private:
  // Units are in a column's name, yet heights come in metres and centimetres.
  void CheckColumn(const std::string& column, double least, double largest) const {
    if (!table_.Has(column)) return;
    for (const std::string& name : names_) {
      const std::optional<std::string> text = Cell(name, column);
      const std::optional<double> value = text ? ParseNumber(*text) : std::nullopt;
      if (text && !(value && *value >= least && *value <= largest))
        throw Fail("{}: {} of {}: '{}' is not a number from {} to {}; what is not known is n/a",
                   table_.Where(rows_.at(name)), column, name, *text, least, largest);
    }
  }

  static constexpr double kLowestSeat_mm = 200, kHighestSeat_mm = 1000;

  fs::path path_;
  CsvTable table_;
  std::vector<std::string> names_;
  std::map<std::string, std::size_t> rows_;
};

// The sub-folders "ses-…" or "run-…", sorted; the folder itself if there is none.
std::vector<fs::path> FoldersOf(const fs::path& folder, std::string_view entity) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && entry.path().filename().string().starts_with(std::string(entity) + "-")) {
      if (!IsEntity(entry.path().filename().string(), entity))
        throw Fail("{}: after {}- only letters and digits may follow", entry.path().string(), entity);
      if (entity == "run" && !IsNumber(entry.path().filename().string().substr(entity.size() + 1)))
        throw Fail("{}: a run has a number, as run-1", entry.path().string());
      found.push_back(entry.path());
    }
  std::sort(found.begin(), found.end());
  return found.empty() ? std::vector{folder} : found;
}

std::vector<Recordings> RecordingsOf(const fs::path& folder, const std::string& participant) {
  std::vector<Recordings> recordings;
  for (const fs::path& session : FoldersOf(folder, "ses"))
    for (const fs::path& run : FoldersOf(session, "run"))
      if (!fs::is_empty(run))
        recordings.push_back({participant,
                              session == folder ? "" : session.filename().string(),
                              run == session ? "" : run.filename().string(),
                              run,
                              {}});
  return recordings;
}

// What is said of one person over what is said of all: maps key by key, everything else as a whole.
void Override(Json& all, const Json& one) {
  if (!all.is_object() || !one.is_object()) {
    all = one;
    return;
  }
  for (const auto& [key, value] : one.items()) {
    if (value.is_null())
      all.erase(key);
    else if (all.contains(key))
      Override(all[key], value);
    else
      all[key] = value;
  }
}

// The names in a text, replaced; nullopt for a text that is nothing but the name of what is not known.
class Names {
 public:
  Names(const Participants& participants, const Recordings& of, std::string cohort)
      : participants_(participants), of_(of), cohort_(std::move(cohort)) {}

  void ReplaceIn(Json& value) const {
    if (value.is_array())
      for (Json& element : value) ReplaceIn(element);
    if (!value.is_object()) return;
    Json kept = Json::object();
    for (auto& [key, child] : value.items()) {
      if (child.is_string()) {
        const std::optional<std::string> text = Replaced(child.get<std::string>());
        if (text) kept[key] = *text;
        continue;
      }
      ReplaceInList(child);
      ReplaceIn(child);
      kept[key] = std::move(child);
    }
    value = std::move(kept);
  }

 private:
  void ReplaceInList(Json& list) const {
    if (!list.is_array()) return;
    Json kept = Json::array();
    for (Json& element : list) {
      const std::optional<std::string> text = element.is_string() ? Replaced(element.get<std::string>()) : std::nullopt;
      if (text)
        kept.push_back(*text);
      else if (!element.is_string())
        kept.push_back(std::move(element));
    }
    list = std::move(kept);
  }

  std::optional<std::string> Replaced(const std::string& text) const {
    std::string replaced;
    for (std::size_t i = 0; i < text.size();) {
      if (text[i] != '$') {
        replaced += text[i++];
        continue;
      }
      if (text.substr(i, 2) == "$$") {
        replaced += '$';
        i += 2;
        continue;
      }
      std::size_t end = i + 1;
      while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) || text[end] == '_')) ++end;
      const std::string name = text.substr(i + 1, end - i - 1);
      const std::optional<std::string> value = name == "cohort" ? cohort_ : participants_.Cell(of_.participant, name);
      if (!value && end - i == text.size()) return std::nullopt;
      if (!value) throw Fail("participants.tsv: {} has no {}, which '{}' needs", of_.participant, name, text);
      replaced += *value;
      i = end;
    }
    return replaced;
  }

  const Participants& participants_;
  const Recordings& of_;
  std::string cohort_;
};

std::vector<std::string> Chosen(const Participants& all, const std::vector<std::string>& asked) {
  if (asked.empty()) return all.Names();
  std::vector<std::string> names;
  for (const std::string& name : asked) {
    const std::string id = name.starts_with("sub-") ? name : "sub-" + name;
    if (!all.Has(id))
      throw UsageError("--participant-label {}: not in participants.tsv, which has {}", name,
                       fmt::join(all.Names(), ", "));
    if (std::find(names.begin(), names.end(), id) == names.end()) names.push_back(id);
  }
  return names;
}

std::vector<std::string> ReadSteps(YamlNode& root) {
  std::vector<std::string> steps;
  if (const auto list = root.Child("steps"))
    for (const YamlNode& step : list->Elements()) steps.push_back(step.AsText());
  return steps;
}

// Everybody's recordings; a folder of somebody who is not in the table is a name misspelt.
std::map<std::string, std::vector<Recordings>> FindRecordings(const fs::path& source, const Participants& people) {
  if (!fs::is_directory(source))
    throw Fail("{}: no such folder; recordings lie in its sub-01, sub-02, …", source.string());
  std::map<std::string, std::vector<Recordings>> found;
  for (const fs::path& folder : FoldersOf(source, "sub")) {
    if (folder == source) break;
    const std::string participant = folder.filename().string();
    if (!people.Has(participant))
      throw Fail("{}: {} is not in participants.tsv; add a row, or move the folder away", folder.string(), participant);
    found[participant] = RecordingsOf(folder, participant);
  }
  return found;
}

// Whether markers as a study file has them, a list or "ankle,knee" (absent: the usual four), show where the trunk is.
bool ShowTrunk(const Json& trial) {
  if (!trial.contains("markers")) return true;
  const Json& markers = trial["markers"];
  const Json names = markers.is_string() ? Json(SplitText(markers.get<std::string>(), ',')) : markers;
  return std::ranges::any_of(names, [](const Json& name) { return name == "waist" || name == "shoulder"; });
}

// Pictures of people have their heads blurred, unless the study says otherwise.
void Anonymise(Json& study, const std::string& of) {
  for (const char* trial : {"human", "exo"}) {
    if (!study.contains(trial) || !study[trial].is_object() || !study[trial].contains("video")) continue;
    if (study[trial].contains("anonymise")) continue;
    if (!ShowTrunk(study[trial]))
      throw Fail(
          "{}: '{}' has neither waist nor shoulder among its markers, so the head's position is unknown: add one, or "
          "say 'anonymise: false'",
          of, trial);
    study[trial]["anonymise"] = true;
  }
}

struct Difference {
  std::string of, where;
  Json study;
};

std::vector<Difference> ReadPeople(YamlNode& root, const std::map<std::string, std::vector<Recordings>>& found) {
  std::vector<Difference> differences;
  auto people = root.Child("people");
  if (!people) return differences;
  for (auto& [name, node] : people->Pairs()) {
    const auto is_known = [&name = name](const auto& of) {
      return of.first == name || std::any_of(of.second.begin(), of.second.end(),
                                             [&](const Recordings& recordings) { return recordings.Name() == name; });
    };
    if (std::none_of(found.begin(), found.end(), is_known)) throw Fail("{}: no recordings of '{}'", node.Where(), name);
    differences.push_back({name, node.Where(), node.ToJson()});
  }
  return differences;
}

}  // namespace

std::string Recordings::Name() const {
  return participant + (session.empty() ? "" : "_" + session) + (run.empty() ? "" : "_" + run);
}

fs::path Recordings::Folder() const {
  fs::path folder = participant;
  for (const std::string& part : {session, run})
    if (!part.empty()) folder /= part;
  return folder;
}

Cohort ReadCohort(const fs::path& folder, const std::vector<std::string>& asked) {
  Cohort cohort;
  cohort.folder = fs::absolute(folder).lexically_normal();
  if (!fs::is_directory(folder))
    throw Fail("{}: no such folder; `lake cohort --template FOLDER` makes one", folder.string());
  const Participants people(folder / "participants.tsv");
  std::map<std::string, std::vector<Recordings>> found = FindRecordings(cohort.folder / "sourcedata", people);
  YamlNode root = YamlNode::ReadFile(folder / "cohort.yaml");
  cohort.name = root.Text("name").value_or(cohort.folder.filename().string());
  cohort.task = root.Text("task").value_or("sitstand");
  if (!IsLabel(cohort.task)) throw Fail("{}: 'task' must be letters and digits, not '{}'", root.Where(), cohort.task);
  cohort.steps = ReadSteps(root);
  const auto study = root.Child("study");
  if (!study || !study->IsMap())
    throw Fail("{}: 'study' is missing: the keys of each person's study.yaml", root.Where());
  const Json of_all = study->ToJson();
  const std::vector<Difference> differences = ReadPeople(root, found);
  if (auto population = root.Child("population"))
    cohort.population = study::ReadPopulation(std::move(*population), cohort.folder);
  root.Finish();

  cohort.has_heights = people.HasNumbers("height_mm");
  for (const std::string& participant : Chosen(people, asked)) {
    if (found[participant].empty()) cohort.absent.push_back(participant);
    for (Recordings& recordings : found[participant]) {
      recordings.study = of_all;
      for (const bool whole_person : {true, false})
        for (const Difference& difference : differences)
          if (difference.of == (whole_person ? participant : recordings.Name()) &&
              (whole_person || recordings.Name() != participant))
            Override(recordings.study, difference.study);
      Names(people, recordings, cohort.folder.lexically_relative(recordings.source).string())
          .ReplaceIn(recordings.study);
      Anonymise(recordings.study, recordings.Name());
      if (!recordings.study.contains("name")) recordings.study["name"] = recordings.Name();
      cohort.recordings.push_back(std::move(recordings));
    }
  }
  return cohort;
}

void SetMovement(gait::MovementKind movement, Cohort& cohort) {
  for (Recordings& recordings : cohort.recordings)
    for (const char* section : {"human", "exo", "compare"})
      if (const auto found = recordings.study.find(section); found != recordings.study.end() && found->is_object())
        (*found)["movement"] = gait::NameOf(movement);
}

}  // namespace lake::cohort
