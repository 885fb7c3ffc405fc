#include "lake/report/report.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "chart_data.h"
#include "html.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "page_files.h"
#include "picture.h"

namespace lake::report {
namespace {

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

std::string CellHtml(const Cell& cell, const Column& column, bool first) {
  const bool is_text = IsText(cell);
  std::string text;
  if (const auto* words = std::get_if<std::string>(&cell)) text = column.code ? EscapeHtml(*words) : TextHtml(*words);
  if (const auto* link = std::get_if<Link>(&cell))
    text = fmt::format("<a href=\"{}\">{}</a>", EscapeHref(link->path), EscapeHtml(link->text));
  if (const auto* value = std::get_if<double>(&cell)) text = NumberText(*value, column.decimals);
  if (const auto* number = std::get_if<Number>(&cell)) text = NumberText(number->value, number->decimals);
  if (first) return fmt::format("<th scope=\"row\">{}</th>", text);
  return fmt::format("<td{}>{}</td>", !is_text ? " class=\"number\"" : column.code ? " class=\"code\"" : "", text);
}

// A column is set as numbers if its first cell is one.
bool IsNumeric(const Table& table, std::size_t column) {
  return !table.rows.empty() && !IsText(table.rows[0][column]);
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

std::string Html(const Table& table) {
  for (const auto& row : table.rows)
    if (row.size() != table.columns.size())
      throw Fail("report: table '{}': a row of {} cells under {} columns", table.caption, row.size(),
                 table.columns.size());
  const std::string filters =
      table.filters.empty() ? "" : fmt::format(" data-filters=\"{}\"", fmt::join(table.filters, " "));
  std::string html = fmt::format("<div class=\"table {}\"{}><table>\n", ClassOf(table.width), filters);
  html += Element("caption", table.caption) + "<thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    html += fmt::format("<th scope=\"col\"{}>{}</th>", IsNumeric(table, i) ? " class=\"number\"" : "",
                        TextHtml(table.columns[i].heading));
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) html += CellHtml(row[i], table.columns[i], i == 0);
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
std::string ChartHtml(const Chart& chart) {
  return fmt::format(
      "<figure class=\"chart {}\">\n{}<div class=\"plot\"><canvas role=\"img\" aria-label=\"{}\"></canvas></div>\n"
      "<noscript><p>This chart needs JavaScript.</p></noscript>\n{}"
      "<script type=\"application/json\">{}</script>\n</figure>\n",
      ClassOf(chart.width), Element("h3", chart.title), EscapeHtml(chart.alt.empty() ? chart.title : chart.alt),
      Element("figcaption", chart.caption), ScriptJson(ChartData(chart)));
}

std::string Html(const LineChart& chart) {
  return ChartHtml(chart);
}

std::string Html(const BarChart& chart) {
  return ChartHtml(chart);
}

std::string Html(const Files& files) {
  std::string html = "<ul class=\"files\">\n";
  for (const Files::File& file : files.files)
    html += fmt::format("<li><a href=\"{}\">{}</a>: {}</li>\n", EscapeHref(file.path), EscapeHtml(file.path.string()),
                        TextHtml(file.what));
  return html + "</ul>\n";
}

std::string SectionHtml(const Section& section, std::size_t index) {
  std::string html = fmt::format("<section id=\"section-{}\">\n{}", index, Element("h2", section.heading));
  for (const Block& block : section.blocks) html += std::visit([](const auto& b) { return Html(b); }, block);
  return html + "</section>\n";
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

}  // namespace

std::string NumberText(double value, int decimals) {
  return RoundedText(value, decimals);
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
  if (HasBlock(report.sections, IsChart))
    html +=
        fmt::format("<script>\n/*!\n{}*/\n{}\n</script>\n<script>\n'use strict';\n(() => {{\n{}\n{}}})();\n</script>\n",
                    ChartLicence(), ChartLibrary(), PageCharts(), PageControls());
  if (HasBlock(report.sections, HasFilters))
    html += fmt::format("<script>\n'use strict';\n(() => {{\n{}}})();\n</script>\n", PageFilters());
  return html + "</body>\n</html>\n";
}

void WriteReport(const std::filesystem::path& path, const Report& report) {
  WriteTextFile(path, RenderReport(report));
}

}  // namespace lake::report
