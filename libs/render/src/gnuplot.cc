#include "lake/render/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake {
namespace {

// Runs `gnuplot SCRIPT`; what it says goes to `log`. Returns its exit status, or throws if it cannot be started.
int RunGnuplot(const std::filesystem::path& script, const std::filesystem::path& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::string name = "gnuplot", file = script.string();
  char* const arguments[] = {name.data(), file.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw Fail("gnuplot cannot be started ({}); install the package gnuplot-nox", std::strerror(error));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw Fail("gnuplot: {}", std::strerror(errno));
  return status;
}

}  // namespace

GnuplotFigure& GnuplotFigure::Line(std::string_view script) {
  script_.append(script).append("\n");
  return *this;
}

std::string GnuplotFigure::Data(const std::vector<std::vector<double>>& columns) {
  const std::string name = fmt::format("$data{}", tables_++);
  script_ += name + " << EOD\n";
  for (std::size_t row = 0; !columns.empty() && row < columns.front().size(); ++row) {
    for (const auto& column : columns) script_ += (std::isfinite(column[row]) ? FormatNumber(column[row]) : "NaN") + " ";
    script_ += "\n";
  }
  script_ += "EOD\n";
  return name;
}

void GnuplotFigure::Write(const std::filesystem::path& path) const {
  AtomicFile picture(path);
  auto script_path = path, log_path = path;
  script_path += ".gnuplot", log_path += ".log";
  // Scratch files beside the picture; never committed, so they vanish with the scope.
  const AtomicFile script(script_path), log(log_path);
  const bool svg = path.extension() == ".svg";
  const std::string terminal =
      svg ? fmt::format("svg size {},{} font 'DejaVu Sans,12' enhanced background '#ffffff'", width_px_, height_px_)
          : fmt::format("pngcairo size {},{} font 'DejaVu Sans,{}' enhanced background '#ffffff'", width_px_, height_px_, 12);
  WriteTextFile(script.TemporaryPath(), fmt::format("set encoding utf8\nset terminal {}\nset output {}\n{}\nunset output\n", terminal,
                                                    QuoteForGnuplot(picture.TemporaryPath().string()), script_));
  const int status = RunGnuplot(script.TemporaryPath(), log.TemporaryPath());
  if (status != 0) throw Fail("{}: gnuplot could not draw it: {}", path.string(), ReadTextFile(log.TemporaryPath()));
  picture.Commit();
}

std::string QuoteForGnuplot(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted.append(c == '\'' ? 2 : 1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

}  // namespace lake
