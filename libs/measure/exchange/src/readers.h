// What the readers share: lines of text, what is left out of a file, tables with a row per frame, points by the number
// of a video's frame, files of one marker each. Not part of the interface.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lake/exchange/formats.h"

namespace lake::exchange {

// In UTF-8, of UTF-16, of UTF-8 and of Windows-1252; without a byte order mark and zero bytes behind.
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

// Tables in text with one row per frame and some columns per point, as most programs export them: each dialect says
// where its columns are, and one reader does the rest.
struct PointColumns {
  std::string name;
  std::vector<std::size_t> axes;  // columns of x, y and, in space, z
  std::optional<std::size_t> likelihood = {};
};

struct PointTable {
  PointSpace space = PointSpace::kPlane;
  std::size_t first_row = 1;  // index of the line
  char separator = ',';
  std::optional<std::size_t> time = {}, frame = {};  // columns; a time may be hours:minutes:seconds:hundredths
  double rate_hz = 0;                                // gives the time of a row that has none of its own
  double first_frame = 0;                            // the number by which the file calls it
  std::vector<PointColumns> points = {};
  double mm_per_unit = 1;
  double first_pixel = 0;        // coordinate of the centre of the top-left pixel
  double least_likelihood = 0;   // below it a point counts as not seen
  bool zero_is_missing = false;  // 0, 0, 0 stands for a missing point
  bool names_all = false;        // a value in any other column is of a point without a name
  std::optional<std::size_t> stated_rows = {};
  std::optional<std::vector<std::size_t>> rows = {};  // indices of their lines, if not all from first_row
};

// Cells that are no number are missing; rows without a time, or with one that does not follow the one before, and a
// last row that is cut off are left out, each with a warning. Throws Error if no row is left.
PointRecording ReadPointTable(const TextLines& lines, const PointTable& table, const std::filesystem::path& path);

// Tracker and Kinovea place a position on the picture as it is drawn: the top-left pixel's centre is at (0.5, 0.5).
constexpr double kPixelCentre = 0.5;

// Positions in the image as tables in px have them: from the picture's top-left corner, y up. Others as they are.
PointRecording AsDrawn(PointRecording points);

struct FramePoints {
  std::string name;
  std::map<std::int64_t, Eigen::Vector3d> positions;  // by frame, not negative; image frame
};

// All frames from 0 to the last that has a position, with the times of a frame rate if it is given. Throws Error if
// there is no position, and if a frame's number asks for more memory than the size of the file makes believable.
PointRecording PointsByFrame(const std::vector<FramePoints>& points, std::size_t file_bytes,
                             const std::filesystem::path& path, double rate_hz = 0, const LeftOut& left_out = {});

// What stands before a place where the file is no XML, or cut off, is kept: a warning names the byte. Throws Error if
// nothing does.
std::vector<std::string> ParseXml(const std::string& text, const std::filesystem::path& path,
                                  pugi::xml_document& document);

// Whole and atomically.
void WriteXml(const std::filesystem::path& path, const pugi::xml_document& document);

// The first entry of a zip archive whose name has this ending. Throws Error if there is none or the archive is damaged.
std::string ReadZipEntry(const std::filesystem::path& path, const std::string& ending);

// The .txt and .csv files of a folder that lake did not write, by name; empty for other paths.
std::vector<std::filesystem::path> MarkerFilesOf(const std::filesystem::path& path);

// Each file's only marker under the file's name without its ending. A frame that a file lacks is missing there; times
// less than a tenth of a frame apart are one frame's. Throws Error for a file with no marker or several, for points of
// different kinds, and for times that lie between those of the other files.
PointRecording ReadMarkerFiles(const std::vector<std::filesystem::path>& files, const ReadOptions& options);

// Recordings of one marker each, as one: frames are joined by their times. Throws Error, naming the `whole`, for times
// that lie between those of another.
PointRecording JoinMarkers(const std::vector<PointRecording>& files, const std::filesystem::path& whole);

// Kinovea's times, in s, ms or µs, become s: a frame lasts between 1 ms and 1 s.
void ToSeconds(PointRecording& recording, const std::filesystem::path& path);

}  // namespace lake::exchange
