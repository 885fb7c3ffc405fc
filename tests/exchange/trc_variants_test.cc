// TRC files as Cortex, Vicon, OpenSim, Mokka and spreadsheets write them: the same trial in every dialect.

#include <functional>
#include <regex>

#include "lake/exchange/formats.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

constexpr int kRows = 6, kMarkers = 3, kMissingRow = 2;

double Value(int row, int marker, int axis) {
  return 100 * marker + 10 * axis + row + 0.5;
}

// The second marker is missing in one row.
std::string MakeTrc() {
  std::string text =
      "PathFileType\t4\t(X/Y/Z)\tC:\\data\\a.trc\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
      "100.00\t100.00\t6\t3\tmm\t100.00\t1\t6\n"
      "Frame#\tTime\tR.Ankle\t\t\tR.Knee\t\t\tR.Hip\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n\n";
  for (int row = 0; row < kRows; ++row) {
    text += fmt::format("{}\t{:.5f}", row + 1, row / 100.0);
    for (int marker = 0; marker < kMarkers; ++marker)
      for (int axis = 0; axis < 3; ++axis)
        text += row == kMissingRow && marker == 1 ? "\t" : fmt::format("\t{:.5f}", Value(row, marker, axis));
    text += "\n";
  }
  return text;
}

std::string Replaced(const std::string& text, const char* pattern, const char* with) {
  return std::regex_replace(text, std::regex(pattern), with);
}

struct Dialect {
  const char* name;
  std::function<std::string(const std::string&)> of;
  bool has_gap = true;
  double sign = 1;
};

const Dialect kDialects[] = {
    {"plain", [](const std::string& t) { return t; }},
    {"Windows line ends", [](const std::string& t) { return Replaced(t, "\n", "\r\n"); }},
    {"Mac line ends", [](const std::string& t) { return Replaced(t, "\n", "\r"); }},
    {"byte order mark", [](const std::string& t) { return "\xEF\xBB\xBF" + t; }},
    {"path of Windows", [](const std::string& t) { return Replaced(t, "data", "J\x92s \xFC"); }},
    {"numbers below 0", [](const std::string& t) { return Replaced(t, "\t(\\d+\\.50000)", "\t-$1"); }, true, -1},
    {"decimal commas", [](const std::string& t) { return Replaced(t, "(\\d)\\.(\\d)", "$1,$2"); }},
    {"no blank line", [](const std::string& t) { return Replaced(t, "\n\n", "\n"); }},
    {"blank lines everywhere", [](const std::string& t) { return Replaced(t, "\n", "\n\n"); }},
    {"no row of axes", [](const std::string& t) { return Replaced(t, "\n\t\tX1.*\n", "\n"); }},
    {"axes that count from 5", [](const std::string& t) { return Replaced(t, "X1", "X5"); }},
    {"two tabs between names", [](const std::string& t) { return Replaced(t, "e\t\t\tR", "e\t\tR"); }},
    {"one tab between names", [](const std::string& t) { return Replaced(t, "e\t\t\tR", "e\tR"); }},
    {"a blank among the tabs between names", [](const std::string& t) { return Replaced(t, "e\t\t\tR", "e \t \t R"); }},
    {"tabs behind the rows", [](const std::string& t) { return Replaced(t, "(\\d)\n", "$1\t\t\t\n"); }},
    {"quotes", [](const std::string& t) { return Replaced(t, "R\\.Knee", "\"R.Knee\""); }},
    {"words for missing",
     [](const std::string& t) { return Replaced(t, "\t\t\t\t(\\d)", "\tNaN\t-nan(ind)\t1.#QNAN\t$1"); }},
    {"FRAME", [](const std::string& t) { return Replaced(t, "Frame#", "FRAME"); }},
    {"blank before Frame", [](const std::string& t) { return Replaced(t, "Frame#", " Frame#"); }},
    {"frames with decimals", [](const std::string& t) { return Replaced(t, "\n(\\d)\t", "\n$1.0\t"); }},
    {"frames from 0", [](const std::string& t) { return Replaced(t, "\n1\t", "\n0\t"); }},
    {"exponents", [](const std::string& t) { return Replaced(t, "\t(\\d+)\\.5", "\t+$1.5e+00"); }},
    {"other counts", [](const std::string& t) { return Replaced(t, "\t6\t3\tmm", "\t600\t55\tmm"); }},
    {"no counts", [](const std::string& t) { return Replaced(t, "\t6\t3\tmm", "\t\t\tmm"); }},
    {"seven keys", [](const std::string& t) { return Replaced(t, "\tOrigNumFrames", ""); }},
    {"no unit", [](const std::string& t) { return Replaced(t, "\tmm\t", "\t\t"); }},
    {"Millimeters", [](const std::string& t) { return Replaced(t, "\tmm\t", "\tMillimeters\t"); }},
    {"no first line", [](const std::string& t) { return t.substr(t.find('\n') + 1); }},
    {"columns without a name", [](const std::string& t) { return Replaced(t, "(\\d)\n(?=\\d\t)", "$1\t7\t8\t9\n"); }},
    {"a unit with more in its cell",
     [](const std::string& t) { return Replaced(t, "mm\t100.00\t1", "mm  100.00  1"); }},
    {"a key glued to the next", [](const std::string& t) { return Replaced(t, "CameraRate\t", "CameraRate\\\\"); }},
    {"unit in brackets", [](const std::string& t) { return Replaced(t, "\tmm\t", "\t(mm)\t"); }},
    {"commas for tabs", [](const std::string& t) { return Replaced(t, "\t", ","); }},
    {"names over each axis",
     [](const std::string& t) { return Replaced(t, "R\\.(\\w+)\t\t", "R.$1_x\tR.$1_y\tR.$1_z"); }},
    {"names thrice", [](const std::string& t) { return Replaced(t, "R\\.(\\w+)\t\t", "R.$1\tR.$1\tR.$1"); }},
    {"UTF-16",
     [](const std::string& t) {
       std::string wide = "\xFF\xFE";
       for (const char c : t) wide += {c, '\0'};
       return wide;
     }},
    {"UTF-16, high bytes first",
     [](const std::string& t) {
       std::string wide = "\xFE\xFF";
       for (const char c : t) wide += {'\0', c};
       return wide;
     }},
    {"zeros behind", [](const std::string& t) { return t + std::string(300, '\0'); }},
    {"Field #", [](const std::string& t) { return Replaced(t, "Frame#", "Field #"); }},
    {"um",
     [](const std::string& t) { return Replaced(Replaced(t, "\tmm\t", "\tum\t"), "\t(\\d+)\\.50000", "\t$01500"); }},
    {"9999999 for missing",
     [](const std::string& t) {
       return Replaced(t, "\t\t\t\t(\\d)", "\t9999999.00000\t9999999.00000\t9999999.00000\t$1");
     }},
    {"times that rows share", [](const std::string& t) { return Replaced(t, "\t0\\.0\\d000\t", "\t0.0\t"); }},
    {"times in ms", [](const std::string& t) { return Replaced(t, "\t0\\.0(\\d)000\t", "\t$010.0\t"); }},
    {"no line end at the end", [](const std::string& t) { return t.substr(0, t.size() - 1); }},
    {"blanks for tabs", [](const std::string& t) { return Replaced(Replaced(t, "\t+", "  "), "\n  ", "\n"); }, false},
    {"blanks for tabs in the rows",
     [](const std::string&
            t) { return t.substr(0, t.find("\n1\t")) + Replaced(t.substr(t.find("\n1\t")), "\t+", " "); },
     false}};

TEST(TrcVariants, AreTheSameTrial) {
  const TemporaryFolder folder;
  for (const Dialect& dialect : kDialects) {
    SCOPED_TRACE(dialect.name);
    exchange::PointRecording read;
    ASSERT_EQ(MessageOf([&] { read = exchange::ReadPoints(WriteFile(folder / "a.trc", dialect.of(MakeTrc()))); }), "");
    ASSERT_EQ(read.points.size(), static_cast<std::size_t>(kMarkers));
    EXPECT_EQ(read.frame.front(), 0);
    EXPECT_EQ(read.points[0].name + read.points[1].name + read.points[2].name, "R.AnkleR.KneeR.Hip");
    ASSERT_EQ(read.time_s.size(), static_cast<std::size_t>(dialect.has_gap ? kRows : kRows - 1))
        << testing::PrintToString(read.warnings);
    std::size_t i = 0;
    for (int row = 0; row < kRows; ++row) {
      if (row == kMissingRow && !dialect.has_gap) continue;  // without tabs nothing says which marker is missing
      EXPECT_NEAR(read.time_s[i], row / 100.0, 1e-9);
      for (int marker = 0; marker < kMarkers; ++marker)
        for (int axis = 0; axis < 3; ++axis) {
          const double value = read.points[static_cast<std::size_t>(marker)].positions[i][axis];
          if (row == kMissingRow && marker == 1)
            EXPECT_TRUE(std::isnan(value));
          else
            EXPECT_NEAR(value, dialect.sign * Value(row, marker, axis), 1e-9) << row << ", " << marker;
        }
      ++i;
    }
  }
}

}  // namespace
}  // namespace lake
