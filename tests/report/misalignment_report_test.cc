// The comparison's report: its numbers are those of the comparison, and a browser draws it.
#include <gmock/gmock.h>

#include "browser.h"
#include "compare/closed_form.h"
#include "lake/commands/compare.h"
#include "lake/compare/misalignment.h"
#include "lake/core/provenance.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/misalignment_sections.h"
#include "name_map.h"
#include "page_text.h"
#include "places.h"

namespace lake {
namespace {

using namespace report;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<compare::StsCurve> Repetitions(const compare::StsCurve& curve, int count, double sigma_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<compare::StsCurve> repetitions(count, curve);
  for (int i = 0; i < count; ++i) {
    repetitions[i].repetition = i + 1;
    AddNoise(repetitions[i], sigma_mm, random);
  }
  return repetitions;
}

// An exoskeleton's joint 10 mm in front of the knee and 20 mm above it.
Json Placed(int repetitions) {
  const compare::StsCurve human = MakeCurve({}), exo = MakeCurve({}, [](double u) { return u; }, {10, 20});
  compare::MisalignmentOptions options;
  options.intervals = repetitions > 1;
  return compare::ComparisonJson(compare::CompareTrials({Repetitions(human, repetitions, 0.1, 1), {}},
                                                        {Repetitions(exo, repetitions, 0.1, 2), {}}, options));
}

std::string PageOf(const Json& comparison) {
  return WithPlainSpaces(RenderReport({"Misalignment", "exo against human", {}, MisalignmentSections(comparison)}));
}

TEST(MisalignmentReport, ShowsTheComparisonsNumbers) {
  const Json comparison = Placed(4);
  const std::string page = PageOf(comparison);
  const double rms = comparison["metrics"]["relative_rms"].get<double>();
  // Rounded to its interval, whatever that is.
  const Json& interval = comparison["intervals"]["relative_rms"];
  const double low = 100 * interval[0].get<double>(), high = 100 * interval[1].get<double>();
  const int decimals = KnownDecimals((high - low) / 2);
  EXPECT_THAT(page, HasSubstr(fmt::format("<dt>path difference, RMS, of the shank</dt><dd><span class=\"value\">{}",
                                          RoundedText(100 * rms, decimals))));
  EXPECT_THAT(page, HasSubstr(fmt::format("95 %: {} to ", RoundedText(low, decimals))));
  EXPECT_THAT(page,
              HasSubstr("is placement: the joint sits 10 mm in front of the knee and 20 mm above it along the shank."));
  // |D| = hypot(10, 20) everywhere, so RMS and largest distance agree but for the noise of 0.1 mm.
  EXPECT_NEAR(comparison["metrics"]["rms_mm"].get<double>(), std::hypot(10, 20), 0.1);
  EXPECT_THAT(page, HasSubstr("We compare the means of 4 repetitions"));
}

// The interval of all sources, on which a decision rests, and one rounding in figure and sentence; what is of the
// markers alone says so.
TEST(MisalignmentReport, TheJointsFiguresHaveOneIntervalEverywhere) {
  Json comparison = Placed(4);
  comparison["joint"] = {{"rms_mm", 36.66},
                         {"rms_interval_mm", {36.63, 36.70}},
                         {"max_mm", 40.2},
                         {"max_interval_mm", {40.1, 40.3}},
                         {"offset_mm", {18.2, 32.1}}};
  comparison["uncertainty"] = {
      {"joint_rms_mm", {{"marker_interval", {34.7, 38.6}}, {"anatomical_interval", {21.6, 51.7}}}},
      {"joint_offset_x_mm", {{"anatomical_interval", {-1.8, 38.2}}}},
      {"joint_offset_y_mm", {{"anatomical_interval", {17.0, 47.2}}}}};
  const std::string page = PageOf(comparison);
  const auto figure = [&](const std::string& name, const std::string& value, const std::string& interval) {
    const std::size_t at = page.find("<dt>" + name + "</dt>");
    ASSERT_NE(at, std::string::npos) << name;
    const std::string shown = page.substr(at, page.find("<dt>", at + 1) - at);
    EXPECT_THAT(shown, HasSubstr("<span class=\"value\">" + value));
    EXPECT_THAT(shown, HasSubstr(interval)) << name;
  };
  figure("joint misalignment, RMS", "37", "95 %, all sources: 22 to 52 mm");
  figure("joint misalignment, largest", "40.20", "95 %, of the markers alone: 40.10 to 40.30 mm");
  figure("joint in front of the knee", "20", "95 %, all sources: 0 to 40 mm");
  figure("joint above the knee, along the shank", "32", "95 %, all sources: 17 to 47 mm");
  EXPECT_THAT(page, HasSubstr("the joint sits 20 mm in front of the knee and 32 mm above it along the shank."));
}

TEST(MisalignmentReport, ASingleRepetitionHasNeitherBandNorIntervals) {
  const Json comparison = Placed(1);
  EXPECT_THAT(PageOf(comparison), Not(HasSubstr("95 %: ")));
  EXPECT_THAT(PathDifferenceChart(comparison).series[0].lower, IsEmpty());
  EXPECT_THAT(DecompositionChart(comparison).series[0].lower, IsEmpty());
}

// As where the leg's own knee is hidden in one of the rises: then there is no mean path of it.
TEST(MisalignmentReport, AJointWithoutTheLegsKneeOverTheRiseHasNoChart) {
  Json comparison = Placed(3);
  comparison["uncertainty"]["joint_frame_mm"] = {{"marker_sd", 1.0}, {"anatomical_sd", 8.0}};
  ASSERT_THAT(comparison["curves"]["exo_leg_knee_x_mm"], IsEmpty());
  EXPECT_THAT(PageOf(comparison), Not(HasSubstr("Joint misalignment over the rise")));
  comparison["curves"]["exo_leg_knee_x_mm"] = comparison["curves"]["human_knee_x_mm"];
  comparison["curves"]["exo_leg_knee_y_mm"] = comparison["curves"]["human_knee_y_mm"];
  EXPECT_THAT(PageOf(comparison), HasSubstr("Joint misalignment over the rise"));
}

TEST(MisalignmentReport, EqualPathsHaveNothingToDivide) {
  const compare::StsCurve curve = MakeCurve({});
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = 0;
  const Json comparison = compare::ComparisonJson(compare::CompareTrials({{curve}, {}}, {{curve}, {}}, options));
  const std::string page = PageOf(comparison);
  EXPECT_THAT(page, HasSubstr("Both paths are one"));
  EXPECT_THAT(page.substr(0, page.find("</main>")), Not(HasSubstr("nan")));
}

TEST(MisalignmentReport, AdviceNamesTheLargestPart) {
  const compare::StsCurve human = MakeCurve({}), late = MakeCurve({}, IssueWarp);
  EXPECT_THAT(DecompositionAdvice(compare::ComparisonJson(
                  compare::CompareTrials({Repetitions(human, 4, 0.1, 1), {}}, {Repetitions(late, 4, 0.1, 2), {}}))),
              HasSubstr("is timing"));
  Json comparison = Placed(4);
  comparison["decomposition"]["placement"]["fraction"] = 0.1;
  comparison["decomposition"]["shape"]["fraction"] = 0.9;
  EXPECT_THAT(DecompositionAdvice(comparison), HasSubstr("%, is shape"));
}

// No sentence rests on parts that fewer repetitions cannot tell.
TEST(MisalignmentReport, ThreeRepetitionsDoNotTellTheParts) {
  const std::string advice = DecompositionAdvice(Placed(3));
  EXPECT_THAT(advice, HasSubstr("cannot be said"));
  EXPECT_THAT(advice, Not(HasSubstr("Most of it")));
  EXPECT_THAT(PageOf(Placed(3)), HasSubstr("too few repetitions for an interval"));
}

TEST(MisalignmentReport, AdviceSaysWhenPartsCannotBeToldApart) {
  Json comparison = Placed(4);
  EXPECT_THAT(DecompositionAdvice(comparison), Not(HasSubstr("overlap")));
  comparison["decomposition"]["timing"]["interval"] = {0.0, 1.0};
  EXPECT_THAT(DecompositionAdvice(comparison), HasSubstr("intervals of the parts overlap"));
}

TEST(MisalignmentReport, ReadFromItsFileItIsTheSamePage) {
  TemporaryFolder folder;
  const Json comparison = Placed(3);
  WriteJsonFile(folder / "comparison.json", comparison);
  EXPECT_EQ(PageOf(ReadJsonFile(folder / "comparison.json")), PageOf(comparison));
}

TEST(MisalignmentReport, SpikesAreMarkedInTheChart) {
  compare::StsCurve human = MakeCurve({}), exo = MakeCurve({}, [](double u) { return u; }, {10, 0});
  exo.knee[40] += Eigen::Vector2d(0, 25);
  const LineChart chart =
      PathDifferenceChart(compare::ComparisonJson(compare::CompareTrials({{human}, {}}, {{exo}, {}})));
  const Series& spikes = chart.series.back();
  EXPECT_EQ(spikes.name, "spike");
  EXPECT_THAT(spikes.x, testing::ElementsAre(40));
}

TEST(MisalignmentReport, ABrowserDrawsIt) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  const std::string page = PageOf(Placed(3));
  EXPECT_THAT(browser.Open(page).console, IsEmpty());
  const Json answer = browser.Ask(page, R"(
    const charts = [...document.querySelectorAll('canvas')].map(canvas => Chart.getChart(canvas));
    return {charts: charts.length, wide: document.documentElement.scrollWidth <= innerWidth};)",
                                  390);
  EXPECT_EQ(answer, Json({{"charts", 5}, {"wide", true}}));
}

// Right leg as the human's, left leg as the exoskeleton's: a recording of five sit-to-stands at 100 Hz.
TEST(MisalignmentReport, LakeCompareWritesItForARealRecording) {
  const std::filesystem::path folder = SharedData() / "opencap_sts";
  std::filesystem::path trc;
  if (std::filesystem::is_directory(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".trc") trc = entry.path();
  if (trc.empty()) GTEST_SKIP() << "no recording opencap_sts in " << SharedData();
  TemporaryFolder out;
  lake::Run::Info info;
  info.program = "lake-compare", info.command = "lake-compare <a> b", info.out = out / "cmp", info.quiet = true;
  lake::Run run(info);
  commands::CompareRunOptions options;
  options.human = options.exo = trc;
  options.exo_knee = "knee";
  options.human_reading.names = NameMap("ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS");
  options.exo_reading.names = NameMap("ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS");
  commands::RunCompare(options, run);
  run.Publish();
  const std::string page = ReadTextFile(out / "cmp" / "report.html");
  EXPECT_THAT(page, HasSubstr(Sha256OfFile(trc)));
  EXPECT_THAT(page, HasSubstr("lake-compare &lt;a&gt; b"));
  for (const std::string& warning : run.Warnings()) EXPECT_THAT(page, HasSubstr(warning.substr(0, 20)));
  LAKE_SKIP_WITHOUT_BROWSER();
  EXPECT_THAT(Browser().Open(page).console, IsEmpty());
}

}  // namespace
}  // namespace lake
