// Text files line by line, with places for messages. Not part of the interface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// In UTF-8, of UTF-16 with a byte order mark, of UTF-8 and of Windows-1252; without the mark and zero bytes behind.
std::string TextFromBytes(std::string bytes);

class TextLines {
 public:
  // Lines end with LF, CR LF or CR; a byte order mark and trailing blanks (not tabs) are taken off. Throws Error if the
  // file cannot be read, or is no text.
  explicit TextLines(const std::filesystem::path& path);

  std::size_t Count() const { return lines_.size(); }
  const std::string& operator[](std::size_t i) const { return lines_[i]; }
  std::string Where(std::size_t i) const;  // "file:line"
  bool EndsWithinLine() const { return ends_within_line_; }

 private:
  std::filesystem::path path_;
  std::vector<std::string> lines_;
  bool ends_within_line_ = false;
};

// All cells, empty ones too, trimmed; quotes round a cell are taken off. Between blanks no cell is empty; one at least.
std::vector<std::string> SplitCells(std::string_view line, char separator);

// Tab, semicolon or comma: the first of these that stands outside quotes; else a comma.
char SeparatorOf(std::string_view line);

std::string Lower(std::string_view text);

// nullopt for an empty cell, for NaN in any spelling, and for a cell that is not a finite number, which sets
// `is_unreadable`; a decimal comma is understood.
std::optional<double> NumberIn(std::string_view cell, bool& is_unreadable);

// Of points to be written between tabs: throws Error for an empty name, or one with a tab or a line end.
void CheckNames(const PointRecording& points, const std::filesystem::path& path);

// More frames than any trial has; a count or number above it is damage.
inline constexpr std::size_t kMostFrames = 10'000'000;

// A whole number from 0 to `most`; nullopt for any other text.
std::optional<std::size_t> CountIn(std::string_view cell, std::size_t most = kMostFrames);

// What a reader leaves out of a file, by kind: the one rule of all readers is that what is consistent is read, and the
// rest is named in a warning.
class LeftOut {
 public:
  // One more of a kind, as "a row without a time"; `where` is the place of the first.
  void Add(const std::string& kind, const std::string& where);

  // " (the first warning)", for the error where nothing usable remains; empty if nothing was left out.
  std::string InBrackets() const;

  // A warning for each kind: its first place and how many there are.
  void AppendTo(std::vector<std::string>& warnings) const;

 private:
  struct Kind {
    std::string name, first;
    std::size_t count = 0;
  };
  std::vector<Kind> kinds_;
};

}  // namespace lake::exchange
