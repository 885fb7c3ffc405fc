// One line that describes an option is all that is needed for it; and every program's help has what is described.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/commands/axis.h"
#include "lake/commands/calibrate.h"
#include "lake/commands/compare.h"
#include "lake/commands/export.h"
#include "lake/commands/gait.h"
#include "lake/commands/loads.h"
#include "lake/commands/optimize.h"
#include "lake/commands/simulate.h"
#include "lake/commands/stroke.h"
#include "lake/commands/symmetry.h"
#include "lake/commands/sync.h"
#include "lake/commands/track.h"
#include "lake/core/yaml.h"
#include "lake/exchange/convert.h"
#include "lake/reviewing/run_review.h"
#include "pages.h"
#include "program.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct NewOptions {
  double knee_width_mm = 90;
};

void Describe(NewOptions& o, OptionList& options) {
  options.Add("knee-width", o.knee_width_mm, "Width of the knee between its condyles").Unit("mm").Positive();
}

TEST(AnOption, IsOneLine) {
  NewOptions options;
  CLI::App cli("A program", "lake-new");
  const std::vector<SharedOptions> lists = {AddOptions(cli, OptionsOf(options))};
  EXPECT_EQ(EffectiveOptions(cli, lists)["knee-width"], "90") << "the summary's options";
  EXPECT_THAT(cli.help(), AllOf(HasSubstr("--knee-width MM"), HasSubstr("90")));
  EXPECT_THAT(cli.help(), HasSubstr("Width of the knee between its condyles [mm]"));
  EXPECT_THAT(Completion(cli, "bash"), HasSubstr("--knee-width"));
  cli.parse("--knee-width 85");
  lists.front()->Apply();
  EXPECT_EQ(options.knee_width_mm, 85);
  EXPECT_EQ(EffectiveOptions(cli, lists)["knee-width"], "85");
  cli.parse("--knee-width 0");
  EXPECT_THROW(lists.front()->Apply(), UsageError);

  const TemporaryFolder folder;
  WriteTextFile(folder / "study.yaml", "knee_width_mm: 88\n");
  YamlNode section = YamlNode::ReadFile(folder / "study.yaml");
  OptionList list = OptionsOf(options);
  ReadOptions(section, list, {});
  section.Finish();
  EXPECT_EQ(options.knee_width_mm, 88);
}

TEST(AFlag, IsSetByItsLastMentionAndRefusesOtherWords) {
  struct Drawing {
    bool drawn = true;
  } drawing;
  CLI::App cli("A program", "lake-new");
  OptionList described;
  described.Add("drawn", drawing.drawn, "Draw it").WithNegation();
  const SharedOptions list = AddOptions(cli, std::move(described));
  EXPECT_EQ(EffectiveOptions(cli, {list})["drawn"], "true");
  cli.parse("--no-drawn");
  list->Apply();
  EXPECT_FALSE(drawing.drawn);
  EXPECT_EQ(EffectiveOptions(cli, {list})["drawn"], "false");
  cli.parse("--no-drawn --drawn");
  list->Apply();
  EXPECT_TRUE(drawing.drawn);
  EXPECT_THROW(cli.parse("--drawn=perhaps"), CLI::ValidationError);
}

// Default, then what the problem's file says, then the command line: in what is used and in what is said.
TEST(AProblemFile, StandsBetweenDefaultAndCommandLine) {
  const TemporaryFolder folder;
  WriteTextFile(
      folder / "problem.yaml",
      "margins: {grashof_mm: 3}\nmount: behind\nclearances: {limb_mm: 5}\nbody: {thigh_mm: 410, shank_mm: 400}\n"
      "load: {knee_torque_nm: 30, max_force_n: 900}\nparts: {pin_diameter_mm: 12, plate: \"5mm,S235\"}\n");
  const auto read = [&](const std::string& rest) {
    commands::OptimizeRunOptions options;
    CLI::App cli("A program", "lake-new");
    const SharedOptions list = AddOptions(cli, OptionsOf(options));
    cli.parse("--problem " + (folder / "problem.yaml").string() + rest);
    list->Apply();
    return std::pair(options.problem, EffectiveOptions(cli, {list}));
  };
  const auto [file, file_said] = read("");
  EXPECT_EQ(file.parts.pin_diameter_mm, 12);
  for (const auto& [name, value] : {std::pair("pin-diameter", "12"),
                                    {"plate", "5mm,S235"},
                                    {"knee-torque", "30"},
                                    {"max-force", "900"},
                                    {"grashof-margin", "3"},
                                    {"mount", "behind"},
                                    {"clear-limb", "5"},
                                    {"thigh", "410"},
                                    {"bar-width", "24"},
                                    {"singularity-margin", "0"}})
    EXPECT_EQ(file_said[name], value) << name;
  const auto [given, given_said] = read(" --pin-diameter 8 --knee-torque 40");
  EXPECT_EQ(given.parts.pin_diameter_mm, 8) << "the default, but said";
  EXPECT_EQ(given_said["pin-diameter"], "8");
  EXPECT_EQ(given.knee_torque_nm, 40);
  EXPECT_EQ(given_said["knee-torque"], "40");
  EXPECT_EQ(given_said["max-force"], "900");
}

template <typename Options>
Options ReadAs(const std::string& words) {
  Options options;
  CLI::App cli("A program", "lake-new");
  const SharedOptions list = AddOptions(cli, OptionsOf(options));
  cli.parse(words);
  list->Apply();
  return options;
}

void ExpectSecond(const exchange::TrialOptions& reading, const gait::PictureScale& picture) {
  EXPECT_EQ(reading.view, "cam2");
  EXPECT_EQ(reading.up, 'z');
  EXPECT_EQ(reading.forward, "x");
  EXPECT_EQ(reading.values, motion::MarkerValues::kEstimated);
  EXPECT_EQ(reading.mm_per_unit, 10);
  EXPECT_THAT(reading.names, testing::ElementsAre(testing::Pair("knee", "b")));
  EXPECT_EQ(picture.depths.size(), 1u);
  EXPECT_EQ(picture.camera, "camera.yaml");
}

TEST(ASecondTrial, IsReadAsTheFirstUnlessItsOwnOptionsSayOtherwise) {
  const std::string words =
      "a.csv b.csv --view cam2 --up z --forward x --smoothed --unit cm --map knee=a --depth knee=5 --camera "
      "camera.yaml ";
  const auto compared = ReadAs<commands::CompareRunOptions>(words + "--exo-map knee=b");
  ExpectSecond(compared.exo_reading, compared.exo_picture);
  const auto legs = ReadAs<commands::SymmetryRunOptions>(words + "--right-map knee=b");
  ExpectSecond(legs.right_reading, legs.right_picture);
  const auto own = ReadAs<commands::SymmetryRunOptions>(words + "--right-unit m --right-scale 0,0,9,9,500");
  EXPECT_EQ(own.right_reading.mm_per_unit, 1000);
  EXPECT_THAT(own.right_reading.names, testing::ElementsAre(testing::Pair("knee", "a")));
  EXPECT_FALSE(own.right_picture.camera);
}

// What several values leave of a command line, as a program of two operands reads it.
struct ListOptions {
  std::vector<double> angles_deg;
  std::map<std::string, double> depth_mm;
  std::vector<std::string> names;
  std::string file, second;
};

void Describe(ListOptions& o, OptionList& options) {
  options.AddOperand("file", o.file, "A file").Required();
  options.AddOperand("second", o.second, "Another");
  options.Add("angles", o.angles_deg, "Angles").Unit("degrees").Value("DEG,...").Repeats();
  options.Add("depth", o.depth_mm, "Depths").Unit("mm").Value("NAME=MM").Repeats();
  options.Add("names", o.names, "Names").Repeats();
}

ListOptions ReadLists(std::vector<std::string> words) {
  ListOptions options;
  CLI::App cli("A program", "lake-new");
  const SharedOptions list = AddOptions(cli, OptionsOf(options));
  std::vector<char*> arguments = {cli.get_display_name().data()};
  for (std::string& word : words) arguments.push_back(word.data());
  const int code = ParseAndRun(cli, {list}, static_cast<int>(arguments.size()), arguments.data(), [&] {
    list->Apply();
    return 0;
  });
  EXPECT_EQ(code, 0) << fmt::format("{}", fmt::join(words, " "));
  return options;
}

TEST(AListOfValues, EndsWhereAWordIsNone) {
  using testing::ElementsAre;
  using testing::Pair;
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--angles", "-20", "70,90", "a.yaml", "b.yaml"},
                                             {"--angles=-20", "70", "90", "a.yaml", "b.yaml"},
                                             {"a.yaml", "--angles", "-20", "--angles", "70", "90", "b.yaml"},
                                             {"--angles", "-20,70,90", "--", "a.yaml", "b.yaml"}}) {
    const ListOptions read = ReadLists(words);
    EXPECT_THAT(read.angles_deg, ElementsAre(-20, 70, 90)) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_EQ(read.file, "a.yaml");
    EXPECT_EQ(read.second, "b.yaml");
  }
  const ListOptions named = ReadLists({"--depth", "hip=5", "knee=6", "a.yaml", "--names", "x", "y", "--angles", "1"});
  EXPECT_THAT(named.depth_mm, ElementsAre(Pair("hip", 5), Pair("knee", 6)));
  EXPECT_THAT(named.names, ElementsAre("x", "y"));
  EXPECT_THAT(named.angles_deg, ElementsAre(1));
  EXPECT_EQ(named.file, "a.yaml");
  EXPECT_EQ(ReadLists({"--angles", "2", "--", "3"}).file, "3") << "after -- all are operands";
}

// `others`: options of the struct for which another of the program's stands.
template <typename Options>
void ExpectHelp(const std::string& program, const std::vector<std::string_view>& others = {}) {
  const TemporaryFolder folder;
  Options options;
  const std::string help = Shell(folder, program + " --help-all").out,
                    completion = Shell(folder, program + " --completion bash").out;
  const OptionList list = OptionsOf(options).Without(others);
  for (const Option& option : list.All()) {
    const std::string name = option.IsOperand() ? option.Name() : "--" + option.Name();
    EXPECT_THAT(help, HasSubstr(name)) << program;
    EXPECT_THAT(help, HasSubstr(option.Help())) << program;
    EXPECT_THAT(help, HasSubstr(option.Value())) << program;
    if (option.IsOperand()) continue;
    EXPECT_THAT(completion, HasSubstr(name)) << program;
  }
}

TEST(Help, FitsOnAScreenAndSaysWhatShowsTheRest) {
  const TemporaryFolder folder;
  for (const std::string name :
       {"track", "compare", "gait", "synth", "loads", "live", "simulate", "optimize", "redesign"}) {
    const std::string help = Shell(folder, "lake-" + name + " --help").out;
    EXPECT_LE(std::ranges::count(help, '\n'), 50) << name;
    EXPECT_THAT(help, testing::EndsWith(" further options: lake-" + name + " --help-all\n"));
  }
  EXPECT_THAT(Shell(folder, "lake-track --help").out,
              AllOf(HasSubstr("--camera"), testing::Not(HasSubstr("--soft-tissue"))));
}

TEST(Help, HasEveryDescribedOptionWithItsUnit) {
  ExpectHelp<commands::TrackRunOptions>("lake-track");
  ExpectHelp<commands::GaitRunOptions>("lake-gait");
  ExpectHelp<commands::LoadsRunOptions>("lake-loads");
  ExpectHelp<commands::AxisRunOptions>("lake-axis");
  ExpectHelp<commands::SyncRunOptions>("lake-sync");
  ExpectHelp<reviewing::ReviewRunOptions>("lake-review");
  ExpectHelp<commands::CompareRunOptions>("lake-compare");
  ExpectHelp<commands::SymmetryRunOptions>("lake-symmetry");
  ExpectHelp<commands::OptimizeRunOptions>("lake-optimize");
  ExpectHelp<commands::ReoptimizeRunOptions>("lake-optimize", {"duration"});
  ExpectHelp<commands::ReoptimizeRunOptions>("lake-redesign", {"duration"});
  ExpectHelp<commands::StrokeRunOptions>("lake-stroke");
  ExpectHelp<commands::DutyRunOptions>("lake-stroke calibrate");
  ExpectHelp<commands::CalibrateRunOptions>("lake-calibrate");
  ExpectHelp<commands::PlaneRunOptions>("lake-calibrate plane");
  ExpectHelp<commands::SheetRunOptions>("lake-calibrate board");
  ExpectHelp<commands::SimulationOptions>("lake-simulate");
  ExpectHelp<commands::ExportOptions>("lake-export");
  ExpectHelp<exchange::ConvertOptions>("lake-convert");
}

}  // namespace
}  // namespace lake
