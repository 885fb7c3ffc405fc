#include "lake/figure/gnuplot.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <string_view>
#include <utility>

#include "lake/core/atomic_file.h"
#include "lake/core/child_program.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/file_descriptor.h"
#include "lake/core/processes.h"

namespace lake::figure {
namespace {

// The style of all plots: frame, grid, key and sizes of text.
constexpr const char* kFont = "DejaVu Sans,14";  // readable where a figure is shown at half its size
constexpr const char* kTheme =
    "set border 3 lc rgb '#222222'; set tics nomirror out scale 0.6; set grid lc rgb '#E4E4E4' lt 1 lw 1; set key "
    "samplen 3 spacing 1.2 noautotitle\n";

// Runs `gnuplot SCRIPT`; what it says goes to `log`. Returns its exit status, or throws if it cannot be started.
int RunGnuplot(const std::filesystem::path& script, const std::filesystem::path& log) {
  if (!IsInPath("gnuplot")) throw Error("gnuplot is not installed; install the package gnuplot-nox");
  const FileDescriptor output(WriteTo(log));
  const pid_t child = StartChild({"gnuplot", "-d", script.string()},  // -d: the user's .gnuplot is not read
                                 {.out = output, .err = output});
  return WaitForChild(child, "gnuplot", std::chrono::milliseconds(2));  // drawing takes a hundred
}

std::filesystem::path WithEnding(std::filesystem::path path, const char* ending) {
  return path += ending;
}

// Scratch files of one drawing, named after the result; never committed, so they vanish with the scope.
class Scratch {
 public:
  explicit Scratch(const std::filesystem::path& result)
      : script_(WithEnding(result, ".gnuplot")), log_(WithEnding(result, ".log")) {}

  // Throws Error with gnuplot's own words.
  void Draw(const std::filesystem::path& result, const std::vector<std::string_view>& script) const {
    std::ofstream stream(script_.TemporaryPath(), std::ios::binary);  // part by part: that of half an hour has 100 MB
    stream << "set encoding utf8\n";
    for (const std::string_view part : script) stream << part;
    stream << "\nunset output\n";
    stream.close();
    if (!stream) throw Fail("{}: cannot be written: {}", script_.TemporaryPath().string(), std::strerror(errno));
    if (RunGnuplot(script_.TemporaryPath(), log_.TemporaryPath()) != 0)
      throw Fail("{}: gnuplot could not draw it: {}", result.string(), ReadTextFile(log_.TemporaryPath()));
  }

 private:
  AtomicFile script_, log_;
};

std::string PngTerminal(int width_px, int height_px) {
  return fmt::format("set terminal pngcairo size {},{} font '{}' enhanced background '#ffffff'\n", width_px, height_px,
                     kFont);
}

std::string SvgTerminal(int width_px, int height_px) {
  return fmt::format("set terminal svg size {},{} font '{}' enhanced background '#ffffff'\n", width_px, height_px,
                     kFont);
}

bool IsSvg(const std::filesystem::path& path) {
  return path.extension() == ".svg";
}

// A figure of half an hour has 30 MB: its end says enough.
std::string EndOf(const std::filesystem::path& file) {
  constexpr std::streamoff kMost = 64;
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  stream.seekg(std::max<std::streamoff>(0, stream.tellg() - kMost));
  return {std::istreambuf_iterator<char>(stream), {}};
}

// gnuplot ends with 0 even where it could not write. A picture that ends as its format does is whole.
void CheckWhole(const std::filesystem::path& written, const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  const std::string picture = EndOf(written);
  const std::string extension = path.extension().string();
  const bool whole = extension == ".svg"   ? Trim(picture).ends_with("</svg>")
                     : extension == ".gif" ? picture.ends_with("\0;"sv)
                                           : picture.ends_with("IEND\xAE\x42\x60\x82"sv);
  if (!whole) throw Fail("{}: gnuplot could not write it whole; is the disk full?", path.string());
}

// In a dark page or viewer the picture is dark, and on paper it is not: lightness is reversed, and hues stay.
constexpr std::string_view kThemeOfSvg =
    "<style>@media screen and (prefers-color-scheme: dark) { svg { filter: invert(0.9) hue-rotate(180deg) } }</style>";

// gnuplot's names of its parts, which a viewer shows as a hint over them, and of which a page with several plots has
// each more than once.
void DropNames(std::string& line) {
  if (line.find("gnuplot_") == std::string::npos) return;
  static const std::regex kNames(" id=\"gnuplot_[a-z0-9_]*\"|<title>gnuplot_plot_[0-9a-z]*</title>");
  line = std::regex_replace(line, kNames, "");
}

// What gnuplot has no command for in an SVG: its title, and that its parts have none; that it follows the reader's
// theme; that filled shapes, for which gnuplot switches smoothing off, have no jagged edges.
void FinishSvg(const std::filesystem::path& svg, std::string title) {
  std::ranges::replace(title, '_', ' ');
  const std::pair<std::string_view, std::string> kChanges[] = {
      {"crispEdges", "geometricPrecision"},
      {"<title>Gnuplot</title>", fmt::format("<title>{}</title>\n{}", title, kThemeOfSvg)}};
  AtomicFile finished(svg);
  std::ifstream from(svg, std::ios::binary);
  std::ofstream to(finished.TemporaryPath(), std::ios::binary);
  for (std::string line; std::getline(from, line);) {  // one by one: that of half an hour has 30 MB
    for (const auto& [old, now] : kChanges)
      for (std::size_t at = 0; (at = line.find(old, at)) != std::string::npos; at += now.size())
        line.replace(at, old.size(), now);
    DropNames(line);
    to << line << '\n';
  }
  to.close();
  if (!to) throw Fail("{}: cannot be written: {}", svg.string(), std::strerror(errno));
  finished.Commit();
}

// In double quotes, where \ooo is a byte: a path may hold any but 0, and in single quotes gnuplot has no newline.
// Digits too: gnuplot would add one that follows to the number before it.
std::string QuotePath(const std::filesystem::path& path) {
  std::string quoted = "\"";
  for (const char c : path.string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = byte >= 0x80 || std::isalpha(byte) || c == '/' || c == '.' || c == '-' || c == '_';
    quoted += is_plain ? std::string(1, c) : fmt::format("\\{:03o}", byte);
  }
  return quoted + "\"";
}

// a, b, …, above the vertical axis of each panel, of which one alone needs none.
void LetterPanels(std::string& page, const std::vector<std::size_t>& panels) {
  if (panels.size() < 2) return;
  for (std::size_t i = panels.size(); i-- > 0;)  // from the last: what stands before it keeps its place
    page.insert(panels[i], fmt::format("set label 99 '{{/:Bold {}}}' at graph 0, graph 1 right offset -2.2,0.8\n",
                                       static_cast<char>('a' + i)));
}

std::string SetOutput(const std::filesystem::path& path) {
  return fmt::format("set output {}\n", QuotePath(path));
}

}  // namespace

GnuplotFigure::GnuplotFigure(int width_px, int height_px)
    : width_px_(width_px), height_px_(height_px), pages_{kTheme} {}

GnuplotFigure& GnuplotFigure::Line(std::string_view script) {
  std::string& page = pages_.back();
  if (script.starts_with("set multiplot")) panels_.clear();
  if (script.starts_with("plot ")) panels_.push_back(page.size());
  if (script == "unset multiplot") LetterPanels(page, panels_);
  page.append(script).append("\n");
  return *this;
}

std::string GnuplotFigure::Data(const std::vector<std::vector<double>>& columns) {
  const std::string name = fmt::format("$data{}", tables_++);
  std::string& script = pages_.back();
  script += name + " << EOD\n";
  for (std::size_t row = 0; !columns.empty() && row < columns.front().size(); ++row) {
    for (const auto& column : columns) script += (std::isfinite(column[row]) ? FormatNumber(column[row]) : "NaN") + " ";
    script += "\n";
  }
  script += "EOD\n";
  return name;
}

GnuplotFigure& GnuplotFigure::NextPage() {
  pages_.emplace_back(fmt::format("reset\n{}", kTheme));
  return *this;
}

void GnuplotFigure::Write(const std::filesystem::path& path) const {
  std::vector<std::filesystem::path> paths = {path};
  if (!path.has_extension()) paths = {WithEnding(path, ".png"), WithEnding(path, ".svg")};
  std::deque<AtomicFile> pictures;
  std::deque<std::string> begins;
  std::vector<std::string_view> script;
  for (const std::filesystem::path& one : paths) {
    const AtomicFile& picture = pictures.emplace_back(one);
    begins.push_back((IsSvg(one) ? SvgTerminal(width_px_, height_px_) : PngTerminal(width_px_, height_px_)) +
                     SetOutput(picture.TemporaryPath()));
    if (!script.empty()) script.emplace_back("\nunset output\nreset\n");
    script.push_back(begins.back());
    script.insert(script.end(), pages_.begin(), pages_.end());
  }
  Scratch(paths.front()).Draw(paths.front(), script);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    CheckWhole(pictures[i].TemporaryPath(), paths[i]);
    if (IsSvg(paths[i])) FinishSvg(pictures[i].TemporaryPath(), paths[i].stem().string());
    pictures[i].Commit();
  }
}

void GnuplotFigure::WriteGif(const std::filesystem::path& path, double pages_per_s) const {
  AtomicFile picture(path);
  const std::string terminal = fmt::format(
      "set terminal gif animate delay {} loop 0 optimize size {},{} font '{}' enhanced background '#ffffff'\n",
      std::lround(100 / pages_per_s), width_px_, height_px_, kFont);  // the format counts hundredths of a second
  const std::string output = SetOutput(picture.TemporaryPath());
  std::vector<std::string_view> script = {terminal, output};
  script.insert(script.end(), pages_.begin(), pages_.end());
  Scratch(path).Draw(path, script);
  CheckWhole(picture.TemporaryPath(), path);
  picture.Commit();
}

void GnuplotFigure::WritePages(const std::filesystem::path& folder) const {
  std::string script = PngTerminal(width_px_, height_px_);
  const auto picture = [&](std::size_t page) { return folder / fmt::format("{:05}.png", page); };
  for (std::size_t page = 0; page < pages_.size(); ++page) script += SetOutput(picture(page)) + pages_[page];
  Scratch(folder / "pages").Draw(folder, {script});
  for (std::size_t page = 0; page < pages_.size(); ++page) CheckWhole(picture(page), picture(page));
}

std::string QuoteForGnuplot(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted.append(c == '\'' ? 2 : 1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

}  // namespace lake::figure
