#include "lake/core/csv.h"

#include <csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"

namespace lake {
namespace {

// Fields and records as libcsv hands them over, with the line on which each record ended.
struct Records {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> lines;
  std::vector<std::string> current;
  std::size_t line = 0;

  static void OnField(void* field, std::size_t length, void* self) {
    static_cast<Records*>(self)->current.emplace_back(field ? static_cast<const char*>(field) : "", length);
  }
  static void OnRecord(int /*terminator*/, void* self) {
    auto* records = static_cast<Records*>(self);
    records->rows.push_back(std::move(records->current));
    records->lines.push_back(records->line);
    records->current.clear();
  }
};

Records ParseRecords(const std::string& text, char delimiter, const std::filesystem::path& path) {
  Records records;
  csv_parser parser;
  if (csv_init(&parser, CSV_STRICT | CSV_STRICT_FINI) != 0)
    throw Fail("{}: cannot set up the CSV parser", path.string());
  csv_set_delim(&parser, static_cast<unsigned char>(delimiter));
  bool parsed = true;
  for (std::size_t begin = 0; parsed && begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    ++records.line;
    parsed = csv_parse(&parser, text.data() + begin, end - begin, Records::OnField, Records::OnRecord, &records) ==
             end - begin;
    begin = end;
  }
  parsed = parsed && csv_fini(&parser, Records::OnField, Records::OnRecord, &records) == 0;
  const bool bad_quote = csv_error(&parser) == CSV_EPARSE;
  const std::string reason =
      bad_quote ? "a quote is not closed, or stands within a cell without quotes" : csv_strerror(csv_error(&parser));
  csv_free(&parser);
  if (!parsed) throw Fail("{}:{}: not a CSV table: {}", path.string(), records.line, reason);
  return records;
}

// What separates the cells of a table that should have commas: semicolons or tabs, where the header has no comma
// outside quotes. So spreadsheets save where the comma is the decimal sign.
char FindSeparator(std::string_view text) {
  bool quoted = false;
  char found = ',';
  for (const char c : text.substr(0, text.find_first_of("\r\n"))) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == ',') return ',';
    if (c == ';' || (c == '\t' && found == ',')) found = c;
  }
  return found;
}

// A table of one column with another separator in its name.
void CheckSeparator(const std::vector<std::string>& header, char delimiter, const std::filesystem::path& path) {
  if (header.size() != 1) return;
  for (const auto& [other, name] : {std::pair(';', "semicolons"), {'\t', "tabs"}, {',', "commas"}})
    if (other != delimiter && header.front().find(other) != std::string::npos)
      throw Fail("{}:1: the columns are separated by {}; save the table with {} between columns and decimal points",
                 path.string(), name, delimiter == '\t' ? "tabs" : "commas");
}

}  // namespace

CsvTable CsvTable::Read(const std::filesystem::path& path, char delimiter, Twice twice) {
  return Parse(ReadTextFile(path), path, delimiter, twice);
}

CsvTable CsvTable::Parse(std::string text, const std::filesystem::path& path, char delimiter, Twice twice) {
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  text = Utf8FromText(std::move(text));
  if (delimiter == ',') delimiter = FindSeparator(text);
  Records records = ParseRecords(text, delimiter, path);
  if (records.rows.empty()) throw Fail("{}: empty, a header line was expected", path.string());

  CheckSeparator(records.rows.front(), delimiter, path);

  CsvTable table;
  table.path_ = path;
  table.decimal_comma_ = delimiter == ';' || delimiter == '\t';
  for (const std::string& name : records.rows.front()) table.header_.emplace_back(Trim(name));
  std::vector<std::string_view> names(table.header_.begin(), table.header_.end());
  std::sort(names.begin(), names.end());
  if (const auto same = std::adjacent_find(names.begin(), names.end()); twice == Twice::kRefused && same != names.end())
    throw Fail("{}:1: column '{}' stands twice: rename or remove one", path.string(), *same);
  for (std::size_t i = 1; i < records.rows.size(); ++i) {
    if (records.rows[i].size() != table.header_.size())
      throw Fail("{}:{}: {} cells, but the header has {}", path.string(), records.lines[i], records.rows[i].size(),
                 table.header_.size());
    table.rows_.push_back(std::move(records.rows[i]));
    table.lines_.push_back(records.lines[i]);
  }
  return table;
}

bool CsvTable::Has(std::string_view column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

std::size_t CsvTable::Column(std::string_view column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  if (found == header_.end()) throw Fail("{}: no column '{}'", path_.string(), column);
  return static_cast<std::size_t>(found - header_.begin());
}

std::optional<double> CsvTable::Number(std::size_t row, std::size_t column) const {
  const std::string_view text = Trim(Text(row, column));
  if (text.empty()) return std::nullopt;
  std::optional<double> value = ParseNumber(text);
  if (!value && decimal_comma_ && text.find('.') == std::string_view::npos) {
    std::string with_point(text);
    std::ranges::replace(with_point, ',', '.');  // two commas are no number then either
    value = ParseNumber(with_point);
  }
  if (!value)
    throw Fail("{}: column '{}': '{}' is not a finite number; leave the cell empty where there is none", Where(row),
               header_.at(column), text);
  return value;
}

double CsvTable::RequiredNumber(std::size_t row, std::size_t column) const {
  const std::optional<double> value = Number(row, column);
  if (!value) throw Fail("{}: column '{}' is empty, a number is needed", Where(row), header_.at(column));
  return *value;
}

std::string CsvTable::Where(std::size_t row) const {
  return fmt::format("{}:{}", path_.string(), lines_.at(row));
}

CsvWriter::CsvWriter(std::vector<std::string> header) : columns_(header.size()) {
  for (const std::string& name : header) Add(std::string_view(name));
  EndRow();
}

void CsvWriter::StartCell() {
  if (cells_in_row_++ > 0) text_ += ',';
}

CsvWriter& CsvWriter::Add(double value) {
  StartCell();
  if (std::isfinite(value)) text_ += FormatNumber(value);
  return *this;
}

CsvWriter& CsvWriter::Add(std::optional<double> value) {
  return value ? Add(*value) : AddEmpty();
}

CsvWriter& CsvWriter::Add(std::span<const double> values) {
  for (const double value : values) Add(value);
  return *this;
}

CsvWriter& CsvWriter::AddInteger(std::int64_t value) {
  StartCell();
  text_ += fmt::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::Add(std::string_view any_text) {
  StartCell();
  const std::string text = ReadableUtf8(any_text);
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    text_ += text;
    return *this;
  }
  text_ += '"';
  for (const char c : text) text_.append(c == '"' ? 2 : 1, c);
  text_ += '"';
  return *this;
}

CsvWriter& CsvWriter::AddEmpty() {
  StartCell();
  return *this;
}

void CsvWriter::EndRow() {
  if (cells_in_row_ != columns_)
    throw std::logic_error(fmt::format("a row of {} cells in a table of {} columns", cells_in_row_, columns_));
  cells_in_row_ = 0;
  text_ += '\n';
}

void CsvWriter::Write(const std::filesystem::path& path) const {
  WriteTextFile(path, text_);
}

std::string FormatNumber(double value) {
  return fmt::format("{}", value);
}

std::optional<double> ParseNumber(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> ParseNumbers(std::string_view text, std::size_t count, std::string_view what) {
  std::vector<double> numbers;
  for (const std::string& part : SplitText(text, ',')) {
    const std::optional<double> number = ParseNumber(part);
    if (!number) throw UsageError("{} '{}': '{}' is not a number", what, text, part);
    numbers.push_back(*number);
  }
  if (numbers.size() != count)
    throw UsageError("{} '{}': {} numbers separated by commas are needed, not {}", what, text, count, numbers.size());
  return numbers;
}

std::string_view Trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::vector<std::string> SplitText(std::string_view text, char separator) {
  std::vector<std::string> parts;
  if (Trim(text).empty()) return parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.emplace_back(Trim(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

}  // namespace lake
