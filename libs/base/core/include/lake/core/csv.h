// Tables as the project's files have them: comma, one header line, '.' decimal point in every locale, an empty cell for
// a missing value, numbers that read back as the same double.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lake {

// A table read from a file; cells stay text until asked for.
class CsvTable {
 public:
  // Two columns of one name: allowed where they are distinguished by their places.
  enum class Twice { kRefused, kAllowed };

  // Quoted cells are understood, and tables as spreadsheets save them where the comma is the decimal sign: semicolons
  // or tabs in the place of commas. Throws Error naming file and line: no header, another separator than the one asked
  // for, a row of another width, a duplicate column.
  static CsvTable Read(const std::filesystem::path& path, char delimiter = ',', Twice twice = Twice::kRefused);

  // The same of a text; `path` is where messages say it stands.
  static CsvTable Parse(std::string text, const std::filesystem::path& path, char delimiter = ',',
                        Twice twice = Twice::kRefused);

  const std::vector<std::string>& Header() const { return header_; }
  std::size_t Rows() const { return rows_.size(); }
  bool Has(std::string_view column) const;

  // Throws Error if there is no such column.
  std::size_t Column(std::string_view column) const;
  const std::string& Text(std::size_t row, std::size_t column) const { return rows_.at(row).at(column); }

  // The cell as a number, nullopt if it is empty. Throws Error naming file, line and column if it is neither, or not
  // finite.
  std::optional<double> Number(std::size_t row, std::size_t column) const;

  // As Number, but an empty cell is an error too.
  double RequiredNumber(std::size_t row, std::size_t column) const;

  // "file:line" of a row, for messages.
  std::string Where(std::size_t row) const;

 private:
  std::filesystem::path path_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> lines_;
  bool decimal_comma_ = false;  // is understood too
};

// Collects rows, then writes the file whole and atomically.
class CsvWriter {
 public:
  explicit CsvWriter(std::vector<std::string> header);

  CsvWriter& Add(double value);  // NaN writes an empty cell
  CsvWriter& Add(std::optional<double> value);
  CsvWriter& Add(std::span<const double> values);  // a cell each
  CsvWriter& Add(std::string_view text);           // quoted if it must be
  CsvWriter& Add(const char* text) { return Add(std::string_view(text)); }
  CsvWriter& AddEmpty();

  // true and false are 1 and 0.
  template <std::integral T>
  CsvWriter& Add(T value) {
    return AddInteger(static_cast<std::int64_t>(value));
  }

  // A whole row. Throws as EndRow().
  template <typename... Cells>
  void AddRow(const Cells&... cells) {
    (Add(cells), ...);
    EndRow();
  }

  // Ends a row. Throws std::logic_error where it is not as wide as the header, a mistake of the caller's.
  void EndRow();

  // Throws Error if the file cannot be written.
  void Write(const std::filesystem::path& path) const;

 private:
  void StartCell();
  CsvWriter& AddInteger(std::int64_t value);

  std::size_t columns_;
  std::size_t cells_in_row_ = 0;
  std::string text_;
};

// The shortest text that reads back as the same double, in every locale.
std::string FormatNumber(double value);

// The whole text as a finite number in the C locale; nullopt otherwise.
std::optional<double> ParseNumber(std::string_view text);

// "1,2.5,3" as `count` numbers. Throws UsageError that names `what` and the text.
std::vector<double> ParseNumbers(std::string_view text, std::size_t count, std::string_view what);

// Without blanks, tabs and line ends at both sides.
std::string_view Trim(std::string_view text);

// The parts between separators, trimmed of blanks; an empty text has no parts.
std::vector<std::string> SplitText(std::string_view text, char separator);

}  // namespace lake
