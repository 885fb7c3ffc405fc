#include "results_list.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <string_view>

#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"
#include "lake/core/results_subject.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".lake-files.json";

bool IsInside(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  return !path.empty() && path.is_relative() && *path.begin() != ".." && *path.begin() != ".";
}

// A path as JSON holds it, whatever its bytes: those that are no ASCII, and '%', in hexadecimal digits.
std::string Escaped(const std::string& path) {
  std::string text;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '%' || byte >= 0x80)
      text += fmt::format("%{:02X}", byte);
    else
      text += c;
  }
  return text;
}

std::string Unescaped(const std::string& text) {
  std::string path;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned byte = 0;
    const char* digits = text.data() + i + 1;
    const bool is_escape =
        text[i] == '%' && i + 2 < text.size() && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
    path += is_escape ? static_cast<char>(byte) : text[i];
    if (is_escape) i += 2;
  }
  return path;
}

template <typename Texts>
Json EscapedList(const Texts& texts) {
  Json list = Json::array();
  for (const std::string& text : texts) list.push_back(Escaped(text));
  return list;
}

ResultsList ReadList(const fs::path& path) {
  if (!fs::is_regular_file(path)) return {};
  try {
    const Json json = ReadJsonFile(path);
    ResultsList list{json.at("program"), json.at("command"), {}, json.at("step"), {}, {}};
    for (const std::string subject : json.at("subject")) list.subject.push_back(Unescaped(subject));
    for (const std::string file : json.at("files"))
      if (const std::string name = Unescaped(file); IsInside(name)) list.files.insert(name);
    list.is_complete = json.value("complete", list.files.contains(kSummary));
    return list;
  } catch (const Error&) {
    return {};
  } catch (const Json::exception&) {
    return {};
  }
}

void RemoveFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(fs::symlink_status(path, error))) return;
  fs::remove(path, error);
  if (error) throw Fail("{}: an earlier result cannot be removed: {}", path.string(), error.message());
}

// AtomicFile's names; what bears one when nobody is at work in the folder was left by a process that was killed.
bool IsTemporary(const std::string& name) {
  constexpr std::string_view kMark = ".lake-";
  constexpr std::size_t kLetters = 6;
  const std::size_t mark = name.rfind(kMark), letters = mark + kMark.size();
  return name.starts_with('.') && mark != std::string::npos && mark > 0 && letters + kLetters <= name.size() &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(letters),
                     name.begin() + static_cast<std::ptrdiff_t>(letters + kLetters),
                     [](unsigned char c) { return std::isalnum(c); }) &&
         (letters + kLetters == name.size() || name[letters + kLetters] == '.');
}

void RemoveTemporaries(const fs::path& folder) {
  std::error_code absent;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder, absent))
    if (IsTemporary(entry.path().filename().string())) left.push_back(entry.path());
  for (const fs::path& path : left) fs::remove_all(path, absent);
}

}  // namespace

std::string ResultsList::Describe() const {
  constexpr std::size_t kMostNamed = 2;
  if (subject.empty()) return fmt::format("{} (`{}`)", program, command);
  const std::vector<std::string> named(
      subject.begin(), subject.begin() + static_cast<std::ptrdiff_t>(std::min(subject.size(), kMostNamed)));
  const std::string more =
      subject.size() > kMostNamed ? fmt::format(" and {} more", subject.size() - kMostNamed) : std::string();
  return fmt::format("{} ({}{})", program, fmt::join(named, ", "), more);
}

fs::path UnfinishedFolder(const fs::path& folder, const std::string& program) {
  return folder / ("." + program + ".lake-unfinished");
}

fs::path ResultsListPath(const fs::path& folder, const std::string& program) {
  return folder / ("." + program + kSuffix);
}

ResultsList ReadResultsList(const fs::path& folder, const std::string& program) {
  return ReadList(ResultsListPath(folder, program));
}

std::vector<ResultsList> ResultsListsIn(const fs::path& folder) {
  std::vector<ResultsList> lists;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const std::string name = entry.path().filename().string(); name.starts_with('.') && name.ends_with(kSuffix))
      if (ResultsList list = ReadList(entry.path()); !list.program.empty()) lists.push_back(std::move(list));
  return lists;
}

std::vector<fs::path> SubjectsOf(const fs::path& folder) {
  std::vector<fs::path> subjects;
  for (const ResultsList& list : ResultsListsIn(folder))
    std::ranges::transform(list.subject, std::back_inserter(subjects), FromHome);
  return subjects;
}

void WriteResultsList(const fs::path& folder, const ResultsList& list) {
  WriteJsonFile(ResultsListPath(folder, list.program), {{"program", list.program},
                                                        {"command", list.command},
                                                        {"subject", EscapedList(list.subject)},
                                                        {"step", list.step},
                                                        {"complete", list.is_complete},
                                                        {"files", EscapedList(list.files)}});
}

void RemoveResultFiles(const fs::path& folder, const std::set<std::string>& files) {
  if (files.contains(kSummary)) RemoveFile(folder / kSummary);
  std::set<fs::path> folders;
  RemoveTemporaries(folder);
  for (const std::string& name : files) {
    RemoveFile(folder / name);
    for (fs::path parent = fs::path(name).parent_path(); !parent.empty(); parent = parent.parent_path())
      folders.insert(parent);
  }
  for (const fs::path& sub : folders) RemoveTemporaries(folder / sub);
  std::error_code not_empty;
  for (auto sub = folders.rbegin(); sub != folders.rend(); ++sub) fs::remove(folder / *sub, not_empty);
}

void RemoveResults(const fs::path& folder, const ResultsList& list) {
  RemoveResultFiles(folder, list.files);
  RemoveFile(ResultsListPath(folder, list.program));
}

void MoveResult(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::rename(from, to, error);
  if (error) throw Fail("{}: cannot be written: {}", to.string(), error.message());
}

}  // namespace lake
