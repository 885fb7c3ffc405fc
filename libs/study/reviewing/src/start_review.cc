#include <fcntl.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/child_program.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/processes.h"
#include "lake/core/uncertain_text.h"
#include "lake/core/yaml.h"
#include "lake/motion/saved_corrections.h"
#include "lake/video/video_reader.h"
#include "other_reviews.h"
#include "result_inputs.h"
#include "run_program.h"

namespace lake::reviewing {
namespace {

namespace fs = std::filesystem;

// ---- what lies in the folder

struct Found {
  fs::path path;
  std::string kind, what = {}, lacks = {};
  std::string film = {};  // of a trial: the file's name
};

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

bool IsOneOf(const std::string& extension, const std::vector<std::string>& all) {
  return std::ranges::find(all, extension) != all.end();
}

bool IsFilm(const fs::path& path) {
  return IsOneOf(LowerExtension(path), {".mp4", ".mov", ".avi", ".mkv", ".m4v", ".webm", ".mts"});
}

bool IsPicture(const fs::path& path) {
  return IsOneOf(LowerExtension(path), {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"});
}

Found FoundFilm(const fs::path& path) {
  Found found{path, "film"};
  try {
    const video::VideoInfo info = video::VideoReader::Open(path, {})->Info();
    found.what = fmt::format("{} × {}, {} frames/s", info.width, info.height, SignificantText(info.frame_rate_hz, 4));
  } catch (const Error& error) {
    found.lacks = error.what();
  }
  return found;
}

// By the keys that are in it.
Found FoundYaml(const fs::path& path) {
  constexpr std::size_t kMost = 1 << 20;
  const std::string text = fs::file_size(path) < kMost ? "\n" + ReadTextFile(path) : "";
  const auto has = [&](std::string_view key) { return text.find(fmt::format("\n{}:", key)) != std::string::npos; };
  const YamlKind* kind = KindByKeys(has);
  if (!kind) return {path, ""};
  if (kind->name == "study") return {path, "study file"};  // "study": its results
  Found found{path, std::string(kind->name)};
  if (kind->name != "camera") return found;
  const bool has_plane = has("plane_rvec");
  found.what = has_plane ? "lens and sagittal plane" : "lens";
  found.lacks = has_plane ? "" : "no sagittal plane";
  return found;
}

Found FoundTrial(const fs::path& folder, const Json& summary) {
  Found found{folder, "trial"};
  std::vector<std::string> names;
  const fs::path tracks = folder / "tracks.csv";
  if (!fs::exists(tracks)) return {folder, "trial", "", "its markers are not named"};
  constexpr std::string_view kPlace = "_x_px";
  std::string header;
  std::getline(std::ifstream(tracks), header);
  for (const std::string& column : SplitText(header, ','))
    if (column.ends_with(kPlace)) names.push_back(column.substr(0, column.size() - kPlace.size()));
  found.what = fmt::format("{}{}", fmt::join(names, ", "),
                           summary.contains("movement") ? "; " + summary["movement"].get<std::string>() : "");
  if (const Json* video = InputOf(summary, "video"))
    found.film = fs::path(video->value("path", "")).filename().string();
  if (!InputOf(summary, "camera")) found.lacks = "no camera: lengths are in px";
  if (!motion::UnappliedCorrections(folder).empty()) found.lacks = "its corrections are not applied";
  return found;
}

Found FoundResult(const fs::path& folder) {
  const Json summary = ReadJsonFile(folder / "summary.json");
  const std::string maker = summary.value("program", "");
  if (maker == "lake-track") return FoundTrial(folder, summary);
  if (maker == "lake-compare") return {folder, "comparison"};
  if (FindsDesigns(maker) || maker == "lake-simulate") return {folder, "design"};
  if (maker == "lake-run")
    return {folder, "study", summary.value("name", ""), fs::exists(folder / "report.html") ? "" : "no report yet"};
  return {folder, ""};
}

// Films, pictures, results and files that a study begins with; what is inside of results is not looked at, except for
// those of the default folder.
std::vector<Found> FindAll() {
  constexpr int kDeepest = 3;
  constexpr std::size_t kMost = 300;
  std::vector<Found> all;
  std::map<fs::path, std::size_t> pictures;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto at = fs::recursive_directory_iterator(".", options); at != fs::recursive_directory_iterator(); ++at) {
    const fs::path path = at->path().lexically_normal();
    std::error_code error;
    const bool is_folder = at->is_directory(error);
    if (path.filename().string().starts_with(".") || at.depth() >= kDeepest) {
      if (is_folder) at.disable_recursion_pending();
      continue;
    }
    Found found;
    try {
      if (is_folder && fs::exists(path / "summary.json")) {
        at.disable_recursion_pending();
        found = FoundResult(path);
      } else if (!is_folder && IsFilm(path)) {
        found = FoundFilm(path);
      } else if (!is_folder && LowerExtension(path) == ".yaml") {
        found = FoundYaml(path);
      } else if (!is_folder && IsPicture(path)) {
        found = {path, "picture"};
        ++pictures[path.parent_path()];
      }
    } catch (const std::exception& damaged) {
      found = {path, is_folder ? "result" : "file", "", damaged.what()};
    }
    if (!found.kind.empty()) all.push_back(std::move(found));
    if (all.size() == kMost) break;
  }
  constexpr std::size_t kFewestViews = 3;
  for (const auto& [folder, count] : pictures)
    if (count >= kFewestViews)
      all.push_back({folder.empty() ? "." : folder, "pictures", fmt::format("{} pictures", count)});
  std::ranges::sort(all, {}, &Found::path);
  return all;
}

// Films whose trial is there too are tracked.
Json FoundJson(const std::vector<Found>& all) {
  std::set<std::string> tracked;
  for (const Found& found : all) tracked.insert(found.film);
  Json list = Json::array();
  for (const Found& found : all) {
    const bool is_untracked = found.kind == "film" && !tracked.contains(found.path.filename().string());
    list.push_back({{"path", found.path.string()},
                    {"kind", found.kind},
                    {"what", found.what},
                    {"lacks", found.lacks.empty() && is_untracked ? "not tracked" : found.lacks}});
  }
  return list;
}

// ---- pages of what was found

// Each is served by a lake-review of its own until its last window is closed.
class OpenPages {
 public:
  OpenPages(const review::PageOptions& page, const fs::path& programs) : page_(page), programs_(programs) {}
  OpenPages(const OpenPages&) = delete;
  OpenPages& operator=(const OpenPages&) = delete;
  ~OpenPages() {
    for (const auto& [pid, said] : pages_) {
      kill(pid, SIGTERM);
      WaitForEnd(pid);
      close(said);
    }
  }

  std::string Open(const fs::path& subject) {
    std::array<int, 2> pipe;
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw Fail("{}: {}", subject.string(), std::strerror(errno));
    const pid_t pid = StartChild({(programs_ / "lake-review").string(), OperandOf(subject), "--listen", page_.listen},
                                 {.out = pipe[1], .err = pipe[1]});
    close(pipe[1]);
    std::string line, last;
    for (char c = 0; read(pipe[0], &c, 1) == 1;) {
      if (c != '\n') {
        line += c;
        continue;
      }
      if (line.starts_with("http://")) {
        const std::lock_guard lock(mutex_);
        pages_.emplace_back(pid, pipe[0]);
        return line;
      }
      last = std::exchange(line, {});
    }
    WaitForEnd(pid);
    close(pipe[0]);
    throw Error(last.empty() ? "lake-review ended without a page" : last);
  }

  bool Any() {
    const std::lock_guard lock(mutex_);
    std::erase_if(pages_, [](const auto& page) {
      const bool has_ended = waitpid(page.first, nullptr, WNOHANG) != 0;
      if (has_ended) close(page.second);
      return has_ended;
    });
    return !pages_.empty();
  }

 private:
  const review::PageOptions page_;
  const fs::path programs_;
  std::mutex mutex_;
  std::vector<std::pair<pid_t, int>> pages_;  // processes, and what they write to
};

// ---- what the page makes

using Control = review::BackgroundJob::Control;

std::string Required(const Json& asked, const char* key, const char* what) {
  std::string text = asked.value(key, "");
  if (text.empty()) throw Fail("{} is missing", what);
  return text;
}

void CheckIsNew(const char* file) {
  if (fs::exists(file)) throw Fail("{} is there already: move it away, or use it", file);
}

// camera.yaml in the folder, of the board's pictures and the picture that shows it in the sagittal plane.
void MakeCamera(const Json& asked, const fs::path& programs, const Control& control) {
  constexpr const char* kCamera = "camera.yaml";
  CheckIsNew(kCamera);
  const std::string board = Required(asked, "board", "the board (chessboard:9x6:25)"),
                    plane = Required(asked, "plane", "the picture of the board in the sagittal plane");
  const fs::path views = Required(asked, "views", "film or pictures of the board"), lens = "lake-out/camera",
                 whole = "lake-out/plane";
  std::vector<std::string> arguments = {"--board", board, "-o", lens.string()};
  if (fs::is_directory(views)) {
    for (const auto& entry : fs::directory_iterator(views))
      if (IsPicture(entry.path())) arguments.push_back(OperandOf(entry.path()));
    std::sort(arguments.begin() + 4, arguments.end());
  } else {
    arguments.push_back(OperandOf(views));
  }
  RunProgram(programs / "lake-calibrate", arguments, control);
  RunProgram(programs / "lake-calibrate",
             {"plane", OperandOf(plane), "--camera", (lens / kCamera).string(), "--board", board, "-o", whole.string()},
             control);
  WriteTextFile(kCamera, ReadTextFile(whole / kCamera));
}

std::string Quoted(const std::string& text) {
  return Json(text).dump();  // YAML reads JSON's strings
}

// The section of the study file that looks for new links; empty where no longest rise is given, which says how far they
// may go.
std::string RedesignSection(const Json& asked) {
  const double rise_s = asked.value("rise_s", 0.0);
  if (!(rise_s > 0)) return "";
  std::string text = "reoptimize:\n";
  if (const std::string problem = asked.value("problem", ""); !problem.empty())
    text += fmt::format("  problem: {}\n", Quoted(problem));
  if (const double percent = asked.value("percent", 0.0); percent > 0)
    text += fmt::format("  max_misalignment_percent: {}\n", percent);
  if (const double speed_mm_s = asked.value("speed_mm_s", 0.0); speed_mm_s > 0)
    text += fmt::format("  max_speed_mm_s: {}\n", speed_mm_s);
  return text + fmt::format("  program: free\n  duration_s: {}\n  fit_placement: true\n", rise_s);
}

// study.yaml in the folder, of two trials, and its results.
void MakeStudy(const Json& asked, const fs::path& programs, const Control& control) {
  constexpr const char* kStudy = "study.yaml";
  CheckIsNew(kStudy);
  std::string text = fmt::format("name: {}\n", Quoted(asked.value("name", "").empty() ? "Study" : asked["name"]));
  text += fmt::format("human: {{trial: {}}}\n", Quoted(Required(asked, "human", "the trial without exoskeleton")));
  if (const std::string exo = asked.value("exo", ""); !exo.empty())
    text += fmt::format("exo: {{trial: {}}}\n", Quoted(exo));
  if (const std::string worn = asked.value("worn", ""); !worn.empty())
    text += fmt::format("design: {{worn: {}}}\n", Quoted(worn));
  if (const double mass_kg = asked.value("mass_kg", 0.0); mass_kg > 0)
    text += fmt::format("loads: {{mass_kg: {}}}\n", mass_kg);
  text += RedesignSection(asked);
  WriteTextFile(kStudy, text);
  try {
    RunProgram(programs / "lake-run", {kStudy, "--plan"}, control);
  } catch (const Error&) {
    fs::remove(kStudy);  // so that it can be asked for otherwise
    throw;
  }
  RunProgram(programs / "lake-run", {kStudy, "-o", "lake-out/study"}, control);
}

review::OtherPages PagesOf(const review::PageOptions& page, const fs::path& programs) {
  const auto pages = std::make_shared<OpenPages>(page, programs);
  return {[pages](const std::string& path) { return pages->Open(path); }, [pages] { return pages->Any(); }};
}

}  // namespace

review::StartWork StartWorkOf(const review::PageOptions& page, const fs::path& programs) {
  review::StartWork work;
  work.folder = fs::current_path().string();
  work.found = [] { return FoundJson(FindAll()); };
  work.pages = PagesOf(page, programs);
  work.make = [programs](const Json& asked, const Control& control) {
    if (asked.at("what") == "camera") return MakeCamera(asked, programs, control);
    if (asked.at("what") == "study") return MakeStudy(asked, programs, control);
    throw Error("a camera or a study can be made");
  };
  return work;
}

fs::path TrackedTrialOf(const fs::path& folder) {
  if (MakerOf(folder) != "lake-gait") return folder;
  const fs::path trial = FindInput(ReadSummary(folder / "summary.json"), "trial", folder);
  if (MakerOf(trial.parent_path()) != "lake-track")
    throw Fail("{}: is of {}, which is none of lake track's: there is no film to look at", folder.string(),
               trial.string());
  return trial.parent_path();
}

review::StudyWork StudyWorkOf(const fs::path& folder, const review::PageOptions& page, const fs::path& programs) {
  review::StudyWork work;
  const Json summary = ReadSummary(folder / "summary.json");
  try {
    work.name = summary.at("name");
    work.command = summary.at("command");
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake run writes it ({})", (folder / "summary.json").string(), error.what());
  }
  work.report = folder / "report.html";
  work.parts = Json::array();
  for (const char* step : {"human", "exo", "comparison", "redesign", "optimum"})
    if (!MakerOf(folder / step).empty()) work.parts.push_back({{"step", step}, {"path", (folder / step).string()}});
  work.pages = PagesOf(page, programs);
  work.pages.open = [open = work.pages.open](const std::string& path) { return open(TrackedTrialOf(path).string()); };
  return work;
}

}  // namespace lake::reviewing
