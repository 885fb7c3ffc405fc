#include "review_naming.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "lake/commands/review.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/tracking/track_markers.h"

extern char** environ;

namespace lake::commands {

namespace fs = std::filesystem;

namespace {

fs::path OutputOf(const fs::path& video) {
  return fs::path("lake-out") / video.stem();
}

// Those of lake-track's options that the page asks for, beside markers and seeds.
constexpr std::array kAsked = {"camera", "scale", "vertical", "crop", "detector", "polarity", "color", "start", "end"};

// lake-track's options as they were chosen; `words` are what its command line says. Throws UsageError for a choice that
// cannot be.
TrackRunOptions Chosen(const fs::path& video, const Json& choices, std::vector<std::string>& words) {
  TrackRunOptions options;
  OptionList list = OptionsOf(options);
  words = {(video.string().starts_with('-') ? "./" : "") + video.string()};
  const auto give = [&](const std::string& name, const OptionTexts& texts) {
    for (Option& option : list.All())
      if (option.Name() == name) option.Give(texts);
    for (const std::string& text : texts) words.push_back(fmt::format("--{}={}", name, text));
  };
  give("markers", {fmt::format("{}", fmt::join(choices.at("markers").get<OptionTexts>(), ","))});
  OptionTexts seeds;
  for (const auto& [name, spot] : choices.at("seeds").items()) {
    if (!spot.is_number_unsigned()) throw UsageError(fmt::format("marker '{}': that is no number of a spot", name));
    seeds.push_back(fmt::format("{}=#{}", name, spot.get<std::uint64_t>()));
  }
  if (!seeds.empty()) give("seed", seeds);
  for (const char* name : kAsked)
    if (const std::string text = choices.at("options").value(name, ""); !text.empty()) give(name, {text});
  list.Apply();
  options.video = video;
  return options;
}

// What lake-track is told, one word each.
std::vector<std::string> ArgumentsOf(const fs::path& video, const Json& choices) {
  std::vector<std::string> words;
  Chosen(video, choices, words);
  words.push_back("-o");
  words.push_back(OutputOf(video).string());
  return words;
}

Json SpotsJson(const fs::path& video, const tracking::CandidateList& list, const video::VideoInfo& info) {
  Json spots = Json::array();
  for (const tracking::Candidate& c : list.candidates)
    spots.push_back({{"id", c.id},
                     {"frame", c.frame},
                     {"x", c.position.x()},
                     {"y", c.position.y()},
                     {"radius", c.radius_px},
                     {"moves", c.moves}});
  return {{"name", video.filename().string()},
          {"frame", list.frame},
          {"width", info.width},
          {"height", info.height},
          {"spots", spots},
          {"choices", {{"markers", tracking::kLegMarkers}, {"seeds", Json::object()}, {"options", Json::object()}}}};
}

// A program whose stderr is read; ended with this object if it still runs.
class Child {
 public:
  Child(const fs::path& program, const std::vector<std::string>& arguments) {
    std::array<int, 2> pipe;
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) throw Fail("{}: {}", program.string(), std::strerror(errno));
    read_ = pipe[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe[1], STDERR_FILENO);
    std::string name = program.string();
    std::vector<std::string> words = arguments;
    std::vector<char*> texts = {name.data()};
    for (std::string& word : words) texts.push_back(word.data());
    texts.push_back(nullptr);
    const int error = posix_spawn(&pid_, name.c_str(), &actions, nullptr, texts.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(pipe[1]);
    if (error != 0) {
      close(read_);
      throw Fail("{}: cannot be started: {}", program.string(), std::strerror(error));
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    close(read_);
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }

  // Hands out what it says, line by line, until it ends; returns its exit code. Throws Interrupted.
  int Follow(const std::function<void(const std::string&)>& say) {
    std::string line;
    std::array<char, 4096> bytes;
    while (true) {
      ThrowIfInterrupted();
      pollfd waiting{read_, POLLIN, 0};
      if (poll(&waiting, 1, 100) <= 0) continue;
      const ssize_t count = read(read_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) break;
      for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(count)))
        if (c != '\n' && c != '\r')
          line += c;
        else if (!line.empty())
          say(std::exchange(line, {}));
    }
    int status = 0;
    waitpid(std::exchange(pid_, 0), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  int read_ = -1;
  pid_t pid_ = 0;
};

review::ReviewedTrial Track(const fs::path& video, const fs::path& programs, const Json& choices,
                            const std::function<void(const std::string&)>& progress) {
  const fs::path tracks = OutputOf(video) / "tracks.csv";
  const auto time_written = [&] {
    return fs::exists(tracks) ? std::optional(fs::last_write_time(tracks)) : std::nullopt;
  };
  const auto before = time_written();
  std::string last;
  const int code = Child(programs / "lake-track", ArgumentsOf(video, choices)).Follow([&](const std::string& line) {
    last = line;
    progress(line);
  });
  // Its tracks are there also where no leg could be fitted: that may be put right. Those of an earlier run do not
  // count.
  if (code != 0 && time_written() == before) throw Fail("lake-track ended with code {}: {}", code, last);
  return ReviewedTrialOf(ReadTrackedFolder(OutputOf(video)));
}

}  // namespace

review::NamingWork NamingOf(const fs::path& video, const fs::path& programs) {
  review::NamingWork work;
  work.find = [video, busy = std::make_shared<std::mutex>()](const Json& options) {
    const std::lock_guard one_at_a_time(*busy);
    std::vector<std::string> words;
    const Json choices = {{"markers", tracking::kLegMarkers}, {"seeds", Json::object()}, {"options", options}};
    tracking::TrackOptions track = Chosen(video, choices, words).track;
    track.quiet = true;
    const video::VideoInfo info = video::VideoReader::Open(video, track.reader)->Info();
    return SpotsJson(video, tracking::FindCandidates(video, track), info);
  };
  work.said = [video](const Json& choices) {
    std::vector<std::string> words = {"lake", "track"};
    for (const std::string& word : ArgumentsOf(video, choices)) words.push_back(ShellWord(word));
    return fmt::format("{}", fmt::join(words, " "));
  };
  work.track = [video, programs](const Json& choices, const auto& progress) {
    return Track(video, programs, choices, progress);
  };
  return work;
}

}  // namespace lake::commands
