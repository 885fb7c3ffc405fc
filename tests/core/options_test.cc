// Options from their description: what is read, and what is refused by which name.
#include "lake/core/options.h"

#include <gmock/gmock.h>

#include "lake/core/atomic_file.h"
#include "lake/core/yaml.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using testing::ThrowsMessage;

enum class Shape { kRound, kSquare };

struct ToolOptions {
  double speed_mm_s = 5;
  std::optional<double> duration_s;
  int knots = 21;
  std::uint64_t seed = 1;
  bool monotone = false, drawn = true;
  std::vector<std::string> names = {"ankle", "knee"};
  std::array<double, 4> box{};
  std::map<std::string, double> depth_mm;
  Shape shape = Shape::kRound;
  std::optional<std::filesystem::path> table;
};

void Describe(ToolOptions& o, OptionList& options) {
  options.Add("max-speed", o.speed_mm_s, "Speed of the tool").Unit("mm/s").Positive();
  options.Add("duration", o.duration_s, "Longest time").Unit("s").Otherwise("no limit");
  options.Add("knots", o.knots, "Knots").AtLeast(2);
  options.Add("seed-number", o.seed, "Seed");
  options.Add("monotone", o.monotone, "No turning back");
  options.Add("drawn", o.drawn, "Draw it").WithNegation();
  options.Add("names", o.names, "Names");
  options.Add("box", o.box, "A box").Value("X,Y,W,H");
  options.Add("depth", o.depth_mm, "Depth of each").Unit("mm").Value("NAME=MM").Repeats();
  options.AddChoice("shape", o.shape, OptionList::Choices<Shape>{{"round", Shape::kRound}, {"square", Shape::kSquare}},
                    "Its shape");
  options.Add("table", o.table, "A table");
}

class Options : public testing::Test {
 protected:
  Option& Named(std::string_view name) {
    for (Option& option : list_.All())
      if (option.Name() == name) return option;
    throw Fail("no option {}", name);
  }
  void Say(std::string_view name, const OptionTexts& texts) { Named(name).SetFromCommandLine(texts); }

  void ExpectRefused(std::string_view name, const OptionTexts& texts, const std::string& message) {
    EXPECT_THAT([&] { Say(name, texts); }, ThrowsMessage<UsageError>(HasSubstr(message))) << name;
  }

  ToolOptions tool_;
  OptionList list_ = OptionsOf(tool_);
};

TEST_F(Options, SayTheirKeyUnitAndDefault) {
  EXPECT_EQ(Named("max-speed").Key(), "max_speed_mm_s");
  EXPECT_EQ(Named("max-speed").Value(), "MM_S");
  EXPECT_EQ(Named("max-speed").DefaultText(), "5");
  EXPECT_EQ(Named("duration").Help(), "Longest time [s] (default: no limit)");
  EXPECT_EQ(Named("names").DefaultText(), "ankle,knee");
  EXPECT_EQ(Named("shape").Value(), "round|square");
  EXPECT_EQ(Named("shape").DefaultText(), "round");
  EXPECT_EQ(Named("table").Value(), "FILE");
  double rate_hz = 0;
  OptionList rates;
  EXPECT_EQ(rates.Add("rate", rate_hz, "Rate").Otherwise("the file's own").DefaultText(), "");
}

TEST_F(Options, AreSetFromACommandLine) {
  Say("max-speed", {"6.5"}), Say("duration", {"30"}), Say("knots", {"31"}),
      Say("seed-number", {"18446744073709551615"});
  Say("monotone", {"true"});
  Say("drawn", {"false"});
  Say("names", {"hip, waist"});
  Say("box", {"1,2,3,4"});
  Say("depth", {"knee=12", "hip=-3"});
  Say("shape", {"square"});
  Say("table", {"a,b.csv"});
  EXPECT_EQ(tool_.speed_mm_s, 6.5);
  EXPECT_EQ(tool_.duration_s, 30);
  EXPECT_EQ(tool_.knots, 31);
  EXPECT_EQ(tool_.seed, 18446744073709551615u);
  EXPECT_TRUE(tool_.monotone);
  EXPECT_FALSE(tool_.drawn);
  EXPECT_THAT(tool_.names, ElementsAre("hip", "waist"));
  EXPECT_EQ(tool_.box, (std::array<double, 4>{1, 2, 3, 4}));
  EXPECT_THAT(tool_.depth_mm, ElementsAre(Pair("hip", -3), Pair("knee", 12)));
  EXPECT_EQ(tool_.shape, Shape::kSquare);
  EXPECT_EQ(tool_.table, "a,b.csv");
}

TEST_F(Options, RefuseWhatCannotBe) {
  ExpectRefused("max-speed", {"fast"}, "--max-speed must be a finite number, not 'fast'");
  ExpectRefused("max-speed", {"inf"}, "--max-speed must be a finite number, not 'inf'");
  ExpectRefused("max-speed", {"0"}, "--max-speed must be positive, not 0");
  ExpectRefused("knots", {"1"}, "--knots must be at least 2, not 1");
  ExpectRefused("knots", {"2.5"}, "--knots must be a whole number, not 2.5");
  ExpectRefused("knots", {"99999999999"}, "whole number");
  ExpectRefused("seed-number", {"-1"}, "whole number");
  ExpectRefused("box", {"1,2"}, "--box must have 4 numbers, not 2");
  ExpectRefused("depth", {"knee"}, "--depth 'knee'");
  ExpectRefused("depth", {"knee=1", "knee=2"}, "is given twice");
  ExpectRefused("shape", {"oval"}, "--shape must be one of round, square, not 'oval'");
  ExpectRefused("table", {""}, "--table is empty");
}

TEST_F(Options, AreSetFromAFileWithTheSameRules) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    WriteTextFile(folder / "tool.yaml", text);
    YamlNode node = YamlNode::ReadFile(folder / "tool.yaml");
    ReadOptions(node, list_,
                [](const YamlNode& file, const Option&) -> OptionTexts { return {"there/" + file.AsText()}; });
    node.Finish();
  };
  read("max_speed_mm_s: 7\nnames: [a, b]\nbox: [1, 2, 3, 4]\ndepth_mm: {knee: 2}\nmonotone: yes\ntable: t.csv\n");
  EXPECT_EQ(tool_.speed_mm_s, 7);
  EXPECT_THAT(tool_.names, ElementsAre("a", "b"));
  EXPECT_EQ(tool_.box[3], 4);
  EXPECT_EQ(tool_.depth_mm.at("knee"), 2);
  EXPECT_TRUE(tool_.monotone);
  EXPECT_EQ(tool_.table, "there/t.csv");
  EXPECT_THAT([&] { read("knots: 5\nmax_speed_mm_s: -1\n"); },
              ThrowsMessage<Error>(HasSubstr("tool.yaml:2: 'max_speed_mm_s' must be positive")));
  EXPECT_THAT([&] { read("knots: 1.5\n"); }, ThrowsMessage<Error>(HasSubstr("'knots' must be a whole number")));
  EXPECT_THAT([&] { read("max_speed: 1\n"); }, ThrowsMessage<Error>(HasSubstr("tool.yaml:1: unknown key 'max_speed'")));
}

TEST_F(Options, AreLeftOutByName) {
  const OptionList rest = list_.Without({"max-speed", "table"});
  EXPECT_EQ(rest.All().size(), list_.All().size() - 2);
  EXPECT_FALSE(rest.IsGiven("table"));
  EXPECT_THROW(rest["table"], std::out_of_range);
}

}  // namespace
}  // namespace lake
