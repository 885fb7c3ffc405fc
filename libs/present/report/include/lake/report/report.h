// A report: one HTML file with text, tables, pictures and interactive charts. Style, scripts, pictures and the chart
// library are inside it and its content security policy forbids every other access, so it can be mailed, archived and
// opened anywhere. Without JavaScript all but the charts is seen. All text is plain text; it is escaped on writing.
// Every member has a default, so that designated initialisers may leave it out.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lake/core/json.h"

namespace lake::report {
// On a wide page two halves that follow each other stand side by side.
enum class Width { kFull, kHalf };

struct Paragraph {
  std::string text{};
};

struct List {
  std::vector<std::string> items{};
};

// A number to be seen first: "8.61 ± 0.30 %", with what it is above it and a remark below.
struct KeyFigure {
  std::string label{};
  double value = 0;  // NaN: "–"
  int decimals = 2;
  std::string unit{};
  std::optional<double> plus_minus{};
  std::string note{};  // e.g. "95 % interval 8.1 to 9.0 %"
};

struct KeyFigures {
  std::vector<KeyFigure> figures{};
};

// Questions that a reader has, each with its answer.
struct Answers {
  struct Answer {
    std::string question{}, text{};
  };
  std::vector<Answer> answers{};
  Width width = Width::kFull;
};

struct Column {
  std::string heading{};
  int decimals = 2;   // of the numbers in it
  bool code = false;  // set in a fixed-width face: hashes, command lines
};

// A number with decimals of its own, where a column has several units.
struct Number {
  double value = 0;
  int decimals = 2;
};

// A text that leads to a file beside the report.
struct Link {
  std::filesystem::path path{};  // relative to the report
  std::string text{};
};

using Cell = std::variant<std::string, double, Number, Link>;  // NaN: "–"

struct Table {
  std::string caption{};
  std::vector<Column> columns{};
  std::vector<std::vector<Cell>> rows{};  // the first cell of a row names it
  Width width = Width::kFull;
  std::vector<std::size_t> filters{};  // columns by whose values a reader chooses rows; of the first also thin curves
};

// PNG, JPEG, GIF, SVG (as <img>, so that no script in it runs), MP4 (with controls); distinguished by their content.
struct Picture {
  std::filesystem::path file{};
  std::string alt{};  // what is to be seen, for those who do not see it
  std::string caption{};
  Width width = Width::kFull;
};

enum class Mark { kLine, kThin, kDashed, kDotted, kPoints };

// A line over x, or a path on a plane. A NaN is a gap.
struct Series {
  std::string name{};
  std::vector<double> x{}, y{};
  std::vector<double> lower{}, upper{};  // a shaded band; empty: none
  std::string colour{};                  // "#RRGGBB"; empty: the next of the palette
  Mark mark = Mark::kLine;
  std::vector<std::string> labels{};  // one per point, shown on hover in front of its values; empty: none
};

struct Axis {
  std::string label{};                 // with the unit
  std::optional<double> from{}, to{};  // default: around the data
  bool downwards = false;              // as px count
};

// Of a series that names none: the next of the palette.
std::string ColourOf(const Series& series, std::size_t index);

struct VerticalLine {
  double x = 0;
  std::string label{};
};

struct ShadedInterval {
  double from = 0, to = 0;
  std::string label{};
};

// Hover shows values; a drag zooms; a click on a name in the legend hides it; PNG and CSV can be saved.
struct LineChart {
  std::string title{};
  std::string alt{};  // default: the title
  std::string caption{};
  Axis x{}, y{};
  std::vector<Series> series{};
  bool equal_scales = false;  // a mm is as long on both axes: for paths on a plane
  std::vector<VerticalLine> lines{};
  std::vector<ShadedInterval> intervals{};
  Width width = Width::kFull;
};

// Of a long recording a chart shows every so manieth sample: a page has some two thousand px.
constexpr std::size_t ChartStep(std::size_t samples) {
  constexpr std::size_t kMostPoints = 2000;
  return 1 + samples / kMostPoints;
}

struct BarSeries {
  std::string name{};
  std::vector<double> values{};          // one per category
  std::vector<double> lower{}, upper{};  // ends of the error bars; empty: none
  std::vector<std::string> colours{};    // one for all bars or one for each; empty: the next of the palette
};

// Horizontal bars with their values beside them.
struct BarChart {
  std::string title{};
  std::string alt{};  // default: the title
  std::string caption{};
  Axis value_axis{};
  int decimals = 1;
  std::vector<std::string> categories{};  // from the top down
  std::vector<BarSeries> series{};
  Width width = Width::kFull;
};

// Links to files beside the report.
struct Files {
  struct File {
    std::filesystem::path path;  // relative to the report
    std::string what;
  };
  std::vector<File> files{};
};

using Block = std::variant<Paragraph, List, KeyFigures, Answers, Table, Picture, LineChart, BarChart, Files>;

struct Section {
  std::string heading{};  // empty: none
  std::vector<Block> blocks;
  bool folded = false;  // closed until it is asked for
};

struct Report {
  std::string title{};
  std::string subtitle{};
  std::vector<std::string> warnings{};      // by weight
  std::vector<report::Section> sections{};  // the first is the message: warnings and contents follow it
};

// As in tables: fixed decimals, a true minus sign, "–" for NaN.
std::string NumberText(double value, int decimals);

// The page. Throws Error: a picture that cannot be read, is of no known kind or larger than 64 MB; columns of a series
// or table of unequal length.
std::string RenderReport(const Report& report);

// Writes the page, atomically.
void WriteReport(const std::filesystem::path& path, const Report& report);

// How a result came about: version, command line, options, inputs with their SHA-256; of what Run::Head() gives.
report::Section ProvenanceSection(const Json& head);

}  // namespace lake::report
