#include "lake/report/report.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <regex>
#include <string>
#include <string_view>

#include "html.h"
#include "lake/core/atomic_file.h"
#include "lake/core/colours.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/json_or_null.h"
#include "lake/core/provenance.h"
#include "lake/core/uncertain_text.h"
#include "page_files.h"

namespace lake::report {
namespace {

struct EmbeddedFile {
  std::string media_type;  // "image/png", …
  std::string data_uri{};
  std::string drawing{};  // of an SVG that runs nothing: its element, which stands in the page as it is
  int width_px = 0;       // of the drawing
  bool IsVideo() const { return media_type == "video/mp4"; }
};

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;

std::string MediaType(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\x89PNG\r\n\x1A\n"sv)) return "image/png";
  if (bytes.starts_with("\xFF\xD8\xFF"sv)) return "image/jpeg";
  if (bytes.starts_with("GIF87a"sv) || bytes.starts_with("GIF89a"sv)) return "image/gif";
  if (bytes.substr(0, 12).find("ftyp"sv) == 4) return "video/mp4";
  if (bytes.substr(0, 1024).find("<svg"sv) != bytes.npos) return "image/svg+xml";
  return {};
}

void ReplaceAll(std::string& text, std::string_view from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) text.replace(at, from.size(), to);
}

// What an SVG calls its parts, under names that no other drawing of the page has.
void NameParts(std::string& svg) {
  const std::string own = "d" + Sha256OfText(svg).substr(0, 8) + "-";
  for (const std::string_view before : {"id='", "id=\"", "href='#", "href=\"#", "url(#"})
    ReplaceAll(svg, before, std::string(before) + own);
}

// A page may run scripts, so what it takes in as text must have none; pictures never run any.
bool RunsSomething(const std::string& svg) {
  static const std::regex kRuns("<script|<foreignObject|\\son[a-z]+\\s*=|javascript:", std::regex::icase);
  return std::regex_search(svg, kRuns);
}

// Without what is no part of the element, and without its title, which a page would show over all of it.
std::optional<std::string> ElementOf(const std::string& svg) {
  const std::size_t from = svg.find("<svg"), to = svg.rfind("</svg>");
  if (from == svg.npos || to == svg.npos || to < from || RunsSomething(svg)) return std::nullopt;
  std::string element = svg.substr(from, to - from) + "</svg>";
  const std::size_t title = element.find("<title>"), title_end = element.find("</title>");
  if (title < title_end && title_end != element.npos)
    element.erase(title, title_end + std::string_view("</title>").size() - title);
  NameParts(element);
  return element;
}

// In the element's own tag; 0 if it does not say.
int WidthOf(std::string_view element) {
  constexpr std::string_view kWidth = " width=\"";
  const std::size_t at = element.substr(0, element.find('>')).find(kWidth);
  int width_px = 0;
  if (at != element.npos)
    std::from_chars(element.data() + at + kWidth.size(), element.data() + element.size(), width_px);
  return width_px;
}

// The type follows from the content. Throws Error: unreadable, unknown, larger than 64 MB.
EmbeddedFile EmbedFile(const std::filesystem::path& file) {
  const std::string bytes = ReadTextFile(file, kMaxBytes);
  const std::string type = MediaType(bytes);
  if (type.empty()) throw Fail("{}: a report takes PNG, JPEG, GIF, SVG and MP4 only", file.string());
  EmbeddedFile embedded{.media_type = type};
  if (type == "image/svg+xml")
    if (auto element = ElementOf(bytes); element && WidthOf(*element) > 0) {
      embedded.width_px = WidthOf(*element);
      embedded.drawing = *std::move(element);
      return embedded;
    }
  embedded.data_uri = "data:" + type + ";base64," + Base64(bytes);
  return embedded;
}

// Okabe & Ito (2008), as colours.h has them for the figures.
constexpr std::array kPalette = {colour::kAnkle, colour::kExoskeleton, colour::kHip,
                                 colour::kWaist, colour::kHuman,       colour::kOther};

std::string ColourOr(const std::string& colour, std::size_t index) {
  return colour.empty() ? kPalette[index % kPalette.size()] : colour;
}

// Infinities, like NaN, are gaps.
Json Numbers(const std::vector<double>& values) {
  Json numbers = Json::array();
  for (const double value : values) numbers.push_back(NumberOrNull(value));
  return numbers;
}

Json AxisData(const Axis& axis) {
  return {{"label", axis.label},
          {"from", ValueOrNull(axis.from)},
          {"to", ValueOrNull(axis.to)},
          {"downwards", axis.downwards}};
}

void CheckLength(const std::string& chart, const std::string& series, const char* column, std::size_t length,
                 std::size_t expected, bool may_be_empty) {
  if (length == expected || (may_be_empty && length == 0)) return;
  throw Fail("report: chart '{}', series '{}': {} values in {} where {} are needed", chart, series, length, column,
             expected);
}

const char* ToString(Mark mark) {
  switch (mark) {
    case Mark::kLine:
      return "line";
    case Mark::kThin:
      return "thin";
    case Mark::kDashed:
      return "dashed";
    case Mark::kDotted:
      return "dotted";
    case Mark::kPoints:
      return "points";
  }
  return "line";
}

Json SeriesData(const LineChart& chart, const Series& series, std::size_t index) {
  const auto check = [&](const char* column, std::size_t length, bool may_be_empty) {
    CheckLength(chart.title, series.name, column, length, series.x.size(), may_be_empty);
  };
  check("y", series.y.size(), false);
  check("labels", series.labels.size(), true);
  check("lower", series.lower.size(), true);
  check("upper", series.upper.size(), series.lower.empty());
  return {{"name", series.name},
          {"x", Numbers(series.x)},
          {"y", Numbers(series.y)},
          {"lower", Numbers(series.lower)},
          {"upper", Numbers(series.upper)},
          {"colour", ColourOf(series, index)},
          {"mark", ToString(series.mark)},
          {"labels", series.labels}};
}

Json BarSeriesData(const BarChart& chart, const BarSeries& series, std::size_t index) {
  const std::size_t bars = chart.categories.size();
  const auto check = [&](const char* column, std::size_t length, bool may_be_empty) {
    CheckLength(chart.title, series.name, column, length, bars, may_be_empty);
  };
  check("values", series.values.size(), false);
  check("lower", series.lower.size(), true);
  check("upper", series.upper.size(), series.lower.empty());
  Json colours = Json::array();
  if (series.colours.size() <= 1) {
    colours.push_back(ColourOr(series.colours.empty() ? "" : series.colours[0], index));
  } else {
    check("colours", series.colours.size(), false);
    colours = series.colours;
  }
  return {{"name", series.name},
          {"values", Numbers(series.values)},
          {"lower", Numbers(series.lower)},
          {"upper", Numbers(series.upper)},
          {"colours", colours}};
}

// Throw Error for columns of unequal length.
Json ChartData(const LineChart& chart) {
  Json data = {{"kind", "line"},         {"title", chart.title},        {"x", AxisData(chart.x)},
               {"y", AxisData(chart.y)}, {"equal", chart.equal_scales}, {"series", Json::array()},
               {"lines", Json::array()}, {"intervals", Json::array()}};
  for (std::size_t i = 0; i < chart.series.size(); ++i) data["series"].push_back(SeriesData(chart, chart.series[i], i));
  for (const VerticalLine& line : chart.lines) data["lines"].push_back({{"x", line.x}, {"label", line.label}});
  for (const ShadedInterval& interval : chart.intervals)
    data["intervals"].push_back({{"from", interval.from}, {"to", interval.to}, {"label", interval.label}});
  return data;
}

Json ChartData(const BarChart& chart) {
  Json data = {{"kind", "bar"},
               {"title", chart.title},
               {"x", AxisData(chart.value_axis)},
               {"decimals", chart.decimals},
               {"categories", chart.categories},
               {"series", Json::array()}};
  for (std::size_t i = 0; i < chart.series.size(); ++i)
    data["series"].push_back(BarSeriesData(chart, chart.series[i], i));
  return data;
}

// The page may run what it contains and show what it contains; nothing else, so no network access.
constexpr const char* kSecurityPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; media-src data:";

std::string Element(const char* name, const std::string& text) {
  return text.empty() ? "" : fmt::format("<{0}>{1}</{0}>\n", name, TextHtml(text));
}

const char* ClassOf(Width width) {
  return width == Width::kHalf ? "half" : "full";
}

bool IsText(const Cell& cell) {
  return std::holds_alternative<std::string>(cell) || std::holds_alternative<Link>(cell);
}

std::string CellHtml(const Cell& cell, const Column& column, bool first, bool is_numeric) {
  std::string text;
  if (const auto* words = std::get_if<std::string>(&cell)) text = column.code ? EscapeHtml(*words) : TextHtml(*words);
  if (const auto* link = std::get_if<Link>(&cell))
    text = fmt::format("<a href=\"{}\">{}</a>", EscapeHref(link->path), EscapeHtml(link->text));
  if (const auto* value = std::get_if<double>(&cell)) text = NumberText(*value, column.decimals);
  if (const auto* number = std::get_if<Number>(&cell)) text = NumberText(number->value, number->decimals);
  if (first) return fmt::format("<th scope=\"row\">{}</th>", text);
  return fmt::format("<td{}>{}</td>", is_numeric ? " class=\"number\"" : column.code ? " class=\"code\"" : "", text);
}

bool IsNothing(const Cell& cell) {
  const auto* value = std::get_if<double>(&cell);
  const auto* number = std::get_if<Number>(&cell);
  return (value && std::isnan(*value)) || (number && std::isnan(number->value));
}

// Without rows and columns in which nothing is known, but for what names them.
Table WithoutNothing(Table table) {
  const auto known_in = [](const std::vector<Cell>& row) {
    return row.size() < 2 || !std::all_of(row.begin() + 1, row.end(), IsNothing);
  };
  std::erase_if(table.rows, [&](const auto& row) { return !known_in(row); });
  for (std::size_t column = table.columns.size(); column-- > 1;) {
    const bool is_known =
        table.rows.empty() || !std::ranges::all_of(table.rows, [&](const auto& row) { return IsNothing(row[column]); });
    if (is_known || std::ranges::count(table.filters, column) > 0) continue;
    table.columns.erase(table.columns.begin() + static_cast<std::ptrdiff_t>(column));
    for (auto& row : table.rows) row.erase(row.begin() + static_cast<std::ptrdiff_t>(column));
    for (std::size_t& filter : table.filters) filter -= filter > column ? 1 : 0;
  }
  return table;
}

// A column is set as numbers if one of its cells is one, also where others have an interval.
bool IsNumeric(const Table& table, std::size_t column) {
  return std::ranges::any_of(table.rows, [&](const auto& row) { return !IsText(row[column]); });
}

std::string Html(const Paragraph& paragraph) {
  return Element("p", paragraph.text);
}

std::string Html(const List& list) {
  std::string html = "<ul>\n";
  for (const std::string& item : list.items) html += Element("li", item);
  return html + "</ul>\n";
}

std::string Html(const KeyFigures& key) {
  std::string html = "<dl class=\"key\">\n";
  for (const KeyFigure& figure : key.figures) {
    html += fmt::format("<div><dt>{}</dt><dd><span class=\"value\">{}", TextHtml(figure.label),
                        NumberText(figure.value, figure.decimals));
    if (figure.plus_minus)
      html += fmt::format("<span class=\"pm\"> ± {}</span>", NumberText(*figure.plus_minus, figure.decimals));
    html += fmt::format("<span class=\"unit\"> {}</span></span>", EscapeHtml(figure.unit));
    if (!figure.note.empty()) html += fmt::format("<span class=\"note\">{}</span>", TextHtml(figure.note));
    html += "</dd></div>\n";
  }
  return html + "</dl>\n";
}

std::string Html(const Answers& answers) {
  std::string html = fmt::format("<dl class=\"answers {}\">\n", ClassOf(answers.width));
  for (const Answers::Answer& answer : answers.answers)
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", TextHtml(answer.question), TextHtml(answer.text));
  return html + "</dl>\n";
}

std::string Html(const Table& given) {
  for (const auto& row : given.rows)
    if (row.size() != given.columns.size())
      throw Fail("report: table '{}': a row of {} cells under {} columns", given.caption, row.size(),
                 given.columns.size());
  const Table table = WithoutNothing(given);
  const std::string filters =
      table.filters.empty() ? "" : fmt::format(" data-filters=\"{}\"", fmt::join(table.filters, " "));
  std::string html = fmt::format("<div class=\"table {}\"{}><table>\n", ClassOf(table.width), filters);
  html += Element("caption", table.caption) + "<thead><tr>";
  std::vector<bool> is_numeric;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    is_numeric.push_back(IsNumeric(table, i));
    html += fmt::format("<th scope=\"col\"{}>{}</th>", is_numeric[i] ? " class=\"number\"" : "",
                        TextHtml(table.columns[i].heading));
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) html += CellHtml(row[i], table.columns[i], i == 0, is_numeric[i]);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string Html(const Picture& picture) {
  const EmbeddedFile file = EmbedFile(picture.file);
  const std::string alt = EscapeHtml(picture.alt);
  // At one scale, so that all have one size of type; what an upright page has no room for is printed on one of its own.
  constexpr int kUprightPage_px = 1120;
  if (!file.drawing.empty())
    return fmt::format(
        "<figure class=\"{} drawing{}\">\n<div class=\"paper\" role=\"img\" aria-label=\"{}\" style=\"--wide: "
        "{}px\">{}</div>\n{}</figure>\n",
        ClassOf(picture.width), file.width_px > kUprightPage_px ? " wide" : "", alt, file.width_px, file.drawing,
        Element("figcaption", picture.caption));
  const std::string element =
      file.IsVideo()
          ? fmt::format("<video controls muted playsinline aria-label=\"{}\" src=\"{}\"></video>", alt, file.data_uri)
          : fmt::format("<img alt=\"{}\" src=\"{}\">", alt, file.data_uri);
  return fmt::format("<figure class=\"{}\">{}\n{}</figure>\n", ClassOf(picture.width), element,
                     Element("figcaption", picture.caption));
}

// The figure of both kinds of charts; page/charts.js draws the data in its script element on its canvas.
template <typename Chart>
std::string Html(const Chart& chart) {
  return fmt::format(
      "<figure class=\"chart {}\">\n{}<div class=\"plot\"><canvas role=\"img\" aria-label=\"{}\"></canvas></div>\n"
      "<noscript><p>This chart needs JavaScript.</p></noscript>\n{}"
      "<script type=\"application/json\">{}</script>\n</figure>\n",
      ClassOf(chart.width), Element("h3", chart.title), EscapeHtml(chart.alt.empty() ? chart.title : chart.alt),
      Element("figcaption", chart.caption), ScriptJson(ChartData(chart)));
}

std::string Html(const Files& files) {
  std::string html = "<ul class=\"files\">\n";
  for (const Files::File& file : files.files)
    html += fmt::format("<li><a href=\"{}\">{}</a>: {}</li>\n", EscapeHref(file.path), EscapeHtml(file.path.string()),
                        TextHtml(file.what));
  return html + "</ul>\n";
}

std::string SectionHtml(const Section& section, std::size_t index) {
  std::string blocks;
  for (const Block& block : section.blocks) blocks += std::visit([](const auto& b) { return Html(b); }, block);
  if (!section.folded)
    return fmt::format("<section id=\"section-{}\">\n{}{}</section>\n", index, Element("h2", section.heading), blocks);
  return fmt::format(
      "<section id=\"section-{}\" class=\"folded\">\n<details>\n<summary><h2>{}</h2></summary>\n<div "
      "class=\"blocks\">\n"
      "{}</div>\n</details>\n</section>\n",
      index, TextHtml(section.heading), blocks);
}

bool IsLong(const Report& report) {
  constexpr std::size_t kLongReport = 5;  // chapters
  return report.sections.size() >= kLongReport;
}

// Folded in a long report, so that they do not stand between its message and its chapters.
std::string WarningsHtml(const Report& report) {
  const std::vector<std::string>& warnings = report.warnings;
  if (warnings.empty()) return "";
  std::string list = "<ul>\n";
  for (const std::string& warning : warnings) list += Element("li", warning);
  list += "</ul>\n";
  if (!IsLong(report)) return "<section class=\"warnings\">\n<h2>Warnings</h2>\n" + list + "</section>\n";
  return "<section class=\"warnings\">\n<details>\n<summary><h2>Warnings</h2></summary>\n" + list +
         "</details>\n</section>\n";
}

// The headings of a long report after the first.
std::string ContentsHtml(const Report& report) {
  const std::vector<Section>& sections = report.sections;
  if (!IsLong(report)) return "";
  std::string html = "<nav aria-label=\"Contents\"><ol>\n";
  for (std::size_t i = 1; i < sections.size(); ++i)
    if (!sections[i].heading.empty())
      html += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1, TextHtml(sections[i].heading));
  return html + "</ol></nav>\n";
}

template <typename Predicate>
bool HasBlock(const std::vector<Section>& sections, Predicate is) {
  return std::ranges::any_of(sections, [&](const Section& section) { return std::ranges::any_of(section.blocks, is); });
}

bool IsChart(const Block& block) {
  return std::holds_alternative<LineChart>(block) || std::holds_alternative<BarChart>(block);
}

bool HasFilters(const Block& block) {
  const auto* table = std::get_if<Table>(&block);
  return table && !table->filters.empty();
}

// An option that was left at nothing says nothing.
bool IsUnset(const Json& value) {
  return value.empty() || value == "" || value == false;
}

std::string OptionText(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

std::string NumberText(double value, int decimals) {
  return RoundedText(value, decimals);
}

std::string ColourOf(const Series& series, std::size_t index) {
  return ColourOr(series.colour, index);
}

std::string RenderReport(const Report& report) {
  const std::string title = EscapeHtml(report.title);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<header>\n<h1>{}</h1>\n{}</header>\n<main>\n",
      kSecurityPolicy, title, PageStyle(), title, Element("p", report.subtitle));
  for (std::size_t i = 0; i < report.sections.size(); ++i) {
    html += SectionHtml(report.sections[i], i + 1);
    if (i == 0) html += WarningsHtml(report) + ContentsHtml(report);
  }
  html += "</main>\n";
  const auto script = [](const std::string& code) {
    return fmt::format("<script>\n'use strict';\n(() => {{\n{}}})();\n</script>\n", code);
  };
  if (HasBlock(report.sections, IsChart))
    html += fmt::format("<script>\n/*!\n{}*/\n{}\n</script>\n{}", ChartLicence(), ChartLibrary(),
                        script(fmt::format("{}\n{}", PageCharts(), PageControls())));
  if (std::ranges::any_of(report.sections, &Section::folded)) html += script(std::string(PageFolds()));
  if (HasBlock(report.sections, HasFilters)) html += script(std::string(PageFilters()));
  return html + "</body>\n</html>\n";
}

void WriteReport(const std::filesystem::path& path, const Report& report) {
  WriteTextFile(path, RenderReport(report));
}

Section ProvenanceSection(const Json& head) {
  Section section{"Provenance", {}};
  Table made{"", {{"What"}, {.heading = "Value", .code = true}}, {}};
  made.rows.push_back({"program", head.at("program").get<std::string>() + " " + head.at("version").get<std::string>()});
  made.rows.push_back({"command", head.at("command").get<std::string>()});
  for (const auto& [name, value] : head.at("options").items())
    if (!IsUnset(value)) made.rows.push_back({"option " + name, OptionText(value)});
  Table inputs{"Inputs", {{"File"}, {.heading = "SHA-256", .code = true}}, {}};
  for (const Json& input : head.at("inputs"))
    inputs.rows.push_back({input.at("path").get<std::string>(), input.at("sha256").get<std::string>()});
  section.blocks.push_back(std::move(made));
  if (!inputs.rows.empty()) section.blocks.push_back(std::move(inputs));
  return section;
}

}  // namespace lake::report
