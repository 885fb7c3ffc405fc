#include "lake/core/csv.h"

#include <gmock/gmock.h>

#include <array>
#include <clocale>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <locale>
#include <random>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// A decimal comma and grouped thousands, as in German.
class CommaPunctuation : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// Sets C++'s global locale, and C's where one with a comma is installed; puts both back.
class CommaLocale {
 public:
  CommaLocale() {
    std::locale::global(std::locale(before_, new CommaPunctuation));
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "es_ES.UTF-8", "it_IT.UTF-8"})
      if (std::setlocale(LC_NUMERIC, name)) break;
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;
  ~CommaLocale() {
    std::locale::global(before_);
    std::setlocale(LC_NUMERIC, before_c_.c_str());
  }
  bool IsSetInC() const { return *std::localeconv()->decimal_point == ','; }

 private:
  const std::locale before_;
  const std::string before_c_ = std::setlocale(LC_NUMERIC, nullptr);
};

TEST(Csv, NumbersAndTablesHaveAPointInEveryLocale) {
  const TemporaryFolder folder;
  {
    const CommaLocale comma;
    std::ostringstream stream;
    stream << 1234.5;
    ASSERT_EQ(stream.str(), "1.234,5");  // the locale is at work
    EXPECT_EQ(FormatNumber(1234.5), "1234.5");
    EXPECT_EQ(ParseNumber("1234.5"), 1234.5);
    EXPECT_FALSE(ParseNumber("1234,5"));
    CsvWriter writer({"frame", "x"});
    writer.Add(123456).Add(0.5).EndRow();
    writer.Write(folder / "t.csv");
    EXPECT_EQ(CsvTable::Read(folder / "t.csv").RequiredNumber(0, 1), 0.5);
    if (!comma.IsSetInC()) std::cout << "no locale with a decimal comma is installed: C's functions are not tried\n";
  }
  EXPECT_EQ(ReadTextFile(folder / "t.csv"), "frame,x\n123456,0.5\n");
}

TEST(Csv, NumbersReadBackAsTheSameDouble) {
  const CommaLocale comma;
  std::mt19937_64 generator(1);
  for (int i = 0; i < 10000; ++i) {
    double value = 0;
    const std::uint64_t bits = generator();
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(ParseNumber(FormatNumber(value)), value);
  }
  EXPECT_EQ(FormatNumber(0.1), "0.1");
}

TEST(Csv, OnlyWholeFiniteNumbersAreNumbers) {
  EXPECT_EQ(ParseNumber("+1.5"), 1.5);
  for (const char* text : {"", "1,5", "1.5x", "nan", "inf", "0x10", " 1", "1e999"})
    EXPECT_FALSE(ParseNumber(text)) << text;
}

TEST(Csv, WritesAndReadsBack) {
  const TemporaryFolder folder;
  CsvWriter writer({"a", "b,c", "d"});
  writer.Add(1.25).Add("say \"so\", then").Add(3).EndRow();
  writer.Add(std::numeric_limits<double>::quiet_NaN()).AddEmpty().Add(std::int64_t{-4}).EndRow();
  writer.Write(folder / "t.csv");
  EXPECT_EQ(ReadTextFile(folder / "t.csv"), "a,\"b,c\",d\n1.25,\"say \"\"so\"\", then\",3\n,,-4\n");

  const CsvTable table = CsvTable::Read(folder / "t.csv");
  ASSERT_EQ(table.Rows(), 2u);
  EXPECT_EQ(table.Number(0, table.Column("a")), 1.25);
  EXPECT_EQ(table.Text(0, table.Column("b,c")), "say \"so\", then");
  EXPECT_EQ(table.Number(1, 0), std::nullopt);
  EXPECT_THAT([&] { table.RequiredNumber(1, 0); }, ThrowsMessage<Error>(HasSubstr("t.csv:3: column 'a' is empty")));
  EXPECT_THAT([&] { table.Column("e"); }, ThrowsMessage<Error>(HasSubstr("no column 'e'")));
}

TEST(Csv, ARowTakesNumbersTextsAndRangesOfNumbers) {
  CsvWriter writer({"size", "flag", "none", "name", "x", "y"});
  writer.AddRow(std::size_t{7}, true, std::nullopt, std::string("a,b"), std::array{0.5, -0.25});
  const TemporaryFolder folder;
  writer.Write(folder / "t.csv");
  EXPECT_EQ(ReadTextFile(folder / "t.csv"), "size,flag,none,name,x,y\n7,1,,\"a,b\",0.5,-0.25\n");
  EXPECT_THAT([&] { writer.AddRow(1, 2); }, ThrowsMessage<std::logic_error>(HasSubstr("in a table of 6 columns")));
}

TEST(Csv, TextThatIsNotUtf8HasReplacementCharacters) {
  CsvWriter table({"name"});
  table.Add(std::string_view("J\xFCrgen, b")).EndRow();
  const TemporaryFolder folder;
  table.Write(folder / "t.csv");
  EXPECT_EQ(ReadTextFile(folder / "t.csv"), "name\n\"J\uFFFDrgen, b\"\n");
}

TEST(Csv, ARowOfAnotherWidthIsNotWritten) {
  for (const int cells : {1, 3}) {
    CsvWriter table({"a", "b"});
    for (int i = 0; i < cells; ++i) table.Add(i);
    EXPECT_THAT([&] { table.EndRow(); }, ThrowsMessage<std::logic_error>(HasSubstr("in a table of 2 columns")));
  }
}

TEST(Csv, NamesTheLineOfABadTable) {
  const TemporaryFolder folder;
  const auto read = [&](const char* text) {
    WriteTextFile(folder / "t.csv", text);
    const CsvTable table = CsvTable::Read(folder / "t.csv");
    return table.RequiredNumber(0, 0);
  };
  EXPECT_THAT([&] { read(""); }, ThrowsMessage<Error>(HasSubstr("a header line was expected")));
  EXPECT_THAT([&] { read("a,b\n1,2\n3\n"); },
              ThrowsMessage<Error>(HasSubstr("t.csv:3: 1 cells, but the header has 2")));
  EXPECT_THAT([&] { read("a,a\n1,2\n"); }, ThrowsMessage<Error>(HasSubstr("'a' stands twice")));
  EXPECT_THAT([&] { read("a\nnan\n"); }, ThrowsMessage<Error>(HasSubstr("t.csv:2: column 'a': 'nan'")));
  EXPECT_THAT([&] { read("a\n\"1\n"); }, ThrowsMessage<Error>(HasSubstr("not a CSV table")));
  EXPECT_THAT([&] { CsvTable::Read(folder / "none.csv"); }, ThrowsMessage<Error>(HasSubstr("no such file")));
  EXPECT_THAT([&] { CsvTable::Read(folder.Path()); }, ThrowsMessage<Error>(HasSubstr("is a folder")));
}

// As spreadsheets save it where the decimal sign is a comma, and as others do with tabs.
TEST(Csv, ReadsSemicolonsAndDecimalCommas) {
  const TemporaryFolder folder;
  for (const char* text :
       {"frame;time_s;note\n1;0,5;\"a; b\"\n2;-1,25e-3;c\n", "frame\ttime_s\tnote\n1\t0,5\ta; b\n2\t-0.00125\tc\n"}) {
    WriteTextFile(folder / "t.csv", text);
    const CsvTable table = CsvTable::Read(folder / "t.csv");
    ASSERT_EQ(table.Header().size(), 3u) << text;
    EXPECT_EQ(table.RequiredNumber(0, 1), 0.5);
    EXPECT_EQ(table.RequiredNumber(1, 1), -0.00125);
    EXPECT_EQ(table.Text(0, 2), "a; b");
  }
  WriteTextFile(folder / "t.csv", "time_s;x\n1,000,5;1\n");
  EXPECT_THAT([&] { CsvTable::Read(folder / "t.csv").Number(0, 0); },
              ThrowsMessage<Error>(HasSubstr("'1,000,5' is not a finite number")));
  WriteTextFile(folder / "t.csv",
                "time_s,\"a; b\"\n\"1,5\",1\n");  // with commas between cells there are none in numbers
  EXPECT_THAT([&] { CsvTable::Read(folder / "t.csv").Number(0, 0); },
              ThrowsMessage<Error>(HasSubstr("'1,5' is not a finite number")));
}

TEST(Csv, SaysThatATableHasAnotherSeparator) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "t.tsv", "participant_id,group\nsub-01,a\n");
  EXPECT_THAT([&] { CsvTable::Read(folder / "t.tsv", '\t'); },
              ThrowsMessage<Error>(HasSubstr("separated by commas; save the table with tabs between columns")));
}

TEST(Csv, ParsesListsOfNumbers) {
  EXPECT_EQ(ParseNumbers("1, 2.5,-3", 3, "--crop"), (std::vector<double>{1, 2.5, -3}));
  EXPECT_THAT([] { ParseNumbers("1,2", 3, "--crop"); },
              ThrowsMessage<UsageError>(HasSubstr("3 numbers separated by commas")));
  EXPECT_THAT([] { ParseNumbers("1,x,3", 3, "--crop"); }, ThrowsMessage<UsageError>(HasSubstr("'x' is not a number")));
}

}  // namespace
}  // namespace lake
