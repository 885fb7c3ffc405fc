// The report of a study as a browser shows it: the first screen, its numbers, its layout.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <regex>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/colours.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/linkage/wear.h"
#include "lake/report/report.h"
#include "lake/report/uncertain.h"
#include "lake/review/design_explorer.h"
#include "lake/reviewing/design_review.h"
#include "lake/video/image.h"
#include "page_text.h"
#include "pipeline/study_trials.h"
#include "report/browser.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;

// The published design as it was worn: 18 mm in front of the knee and 32 mm above it, as ExoMotionOptions() has it.
constexpr const char* kWorn =
    "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n"
    "placement_mm: [18, 32]\nmount: behind\n";
constexpr const char* kDesign =
    "design: {worn: worn.yaml}\nreoptimize: {problem: {mount: behind, margins: {grashof_mm: 2, singularity_mm: 2}, "
    "load: "
    "{max_force_n: 2000}, standing_deg: 5}, max_misalignment_percent: 4, program: free, duration_s: 40, "
    "fit_placement: true, pareto: 2, starts: 1}\nstroke: {}\n";

// The folder of its results, made once for all tests.
const std::filesystem::path& Results() {
  static StudyFolder study;
  static const std::filesystem::path results = [] {
    WriteTextFile(study.Folder() / "worn.yaml", kWorn);
    study.WriteStudy(std::string(kNoAnimation) + kDesign);
    study.Go();
    return study.Out();
  }();
  return results;
}

const std::string& Page() {
  static const std::string page = ReadTextFile(Results() / "report.html");
  return page;
}

// As it is read.
const std::string& PageText() {
  static const std::string text = WithPlainSpaces(Page());
  return text;
}

// All drawings of all steps, also those that the report leaves to their files.
std::string PageOfDrawings() {
  std::vector<std::filesystem::path> drawings;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(Results()))
    if (entry.path().extension() == ".svg") drawings.push_back(entry.path());
  std::ranges::sort(drawings);
  report::Section section{"Drawings", {}};
  for (const std::filesystem::path& drawing : drawings)
    section.blocks.push_back(report::Picture{drawing, drawing.lexically_relative(Results()).string(), ""});
  return report::RenderReport({"Drawings", "", {}, {section}});
}

// Of each design its cuff forces with intervals, as the step's summary has them.
TEST(StudyPage, HasTheForcesAtTheCuffsOfEachDesign) {
  const std::string& page = PageText();
  const std::size_t table = page.find("Largest forces caused by misalignment over the rise");
  ASSERT_NE(table, page.npos);
  const std::string text = page.substr(table, page.find("</table>", table) - table);
  const Json summary = ReadJsonFile(Results() / "redesign/summary.json");
  for (const char* design : {"before", "joint_moved", "other_program", "after"}) {
    const Json& cuffs = summary[design]["cuffs"];
    const Json& interval = cuffs["shank_cuff_interval_n"];
    const auto force_n = report::UncertainOf(cuffs["shank_cuff_n"], interval);
    EXPECT_THAT(text,
                HasSubstr(fmt::format("{} ({} to {})", force_n.Text(1), RoundedText(force_n.low, force_n.Decimals(1)),
                                      RoundedText(force_n.high, force_n.Decimals(1)))))
        << design;
    EXPECT_LT(cuffs["shank_cuff_n"].get<double>(), interval[1].get<double>());
  }
}

// The misalignment's interval of the markers and that of the joints beneath the skin, and what would narrow them.
TEST(StudyPage, HasTheBudgetOfTheMisalignment) {
  const Json rms = ReadJsonFile(Results() / "comparison/summary.json")["uncertainty"]["joint_rms_mm"];
  const Json& all = rms["anatomical_interval"];
  const int decimals = KnownDecimals((all[1].get<double>() - all[0].get<double>()) / 2);
  for (const char* interval : {"marker_interval", "anatomical_interval"})
    EXPECT_THAT(PageText(), HasSubstr(fmt::format("{} to {} mm", RoundedText(rms[interval][0].get<double>(), decimals),
                                                  RoundedText(rms[interval][1].get<double>(), decimals))));
  const std::string narrower = rms["narrower"];
  EXPECT_THAT(PageText(), HasSubstr(narrower));
  EXPECT_THAT(narrower, AllOf(HasSubstr("two or more markers on shank and thigh"),
                              HasSubstr("leave the same markers on between the trials"), HasSubstr("repetitions")));
  // Single frames too, over the rise.
  EXPECT_THAT(PageText(), HasSubstr("beneath the skin"));
}

// What is wrong and the first thing to do; the ways, from the cheapest on; a picture, a chart; what next. Then the
// warnings, folded, and all of it in words.
TEST(StudyPage, SaysWhatToBuildFirst) {
  const std::string& page = PageText();
  const std::size_t warnings = page.find("<h2>Warnings</h2>"), contents = page.find("<nav");
  // On the knee its linkage reaches further into the seat than as worn.
  const Json on_body = ReadJsonFile(Results() / "comparison/summary.json")["best_placement"]["on_body"];
  ASSERT_LT(on_body["moved"]["seat_clearance_mm"], on_body["as_worn"]["seat_clearance_mm"]);
  std::size_t last = 0;
  for (const char* part :
       {"<p>The joint sits in front of and above the knee. New links help; those that were worn do not "
        "keep the limits, wherever their joint is.</p>",
        "as worn</th>", "same links, joint moved</th>", "new links</th>", "<figure class=\"chart half\">",
        "as worn, with the joint moved", "<dt>Next</dt>", "<h2>Warnings</h2>", "<h2>Why, and how sure</h2>",
        "; 95 %: ", "<dt>What is wrong</dt>", "<dt>Why new links</dt>", "<dt>What to build for new links</dt>",
        "<dt>How sure it is</dt>"}) {
    const std::size_t at = page.find(part, last);
    ASSERT_NE(at, page.npos) << part;
    last = at;
  }
  EXPECT_LT(warnings, contents);
  EXPECT_THAT(page, HasSubstr("<details>\n<summary><h2>Warnings</h2></summary>"));
  const std::string first = page.substr(0, warnings);
  EXPECT_THAT(first, AllOf(HasSubstr("limit you set"), HasSubstr("mm back"), HasSubstr("mm lower")));
  // Seen from the side it would overlap the thigh, but no clearance was asked for.
  const std::string screen = first.substr(first.find("The joint sits"));
  for (const char* unasked : {"overlaps", "clearance", "meets the seat"})
    EXPECT_THAT(screen, testing::Not(HasSubstr(unasked)));
  EXPECT_THAT(page.substr(warnings, 200), HasSubstr("Fit on the body: "));
  for (const char* file : {"simulation/design.dxf", "simulation/schematic.svg", "redesign/design.yaml"})
    EXPECT_THAT(page, HasSubstr(file));
  // The best evidence is in the page.
  EXPECT_THAT(page.substr(contents), AllOf(HasSubstr("<h3>Knee angles</h3>"), HasSubstr("class=\"folded\"")));
}

// Nobody asks of a place of the worn joint that it reach less far into seat and limbs than it did: the nearest such
// place, found here again among all of a grid of 2 mm.
TEST(StudyPage, SaysWhatSeatAndLimbsAllowOfTheMovedJoint) {
  const Json best = ReadJsonFile(Results() / "comparison/summary.json")["best_placement"], &on_body = best["on_body"];
  const Json human = ReadJsonFile(Results() / "comparison/comparison.json")["curves"];
  const auto mean = [&](const char* curve) {
    const std::vector<double> lengths = human[curve];
    return std::accumulate(lengths.begin(), lengths.end(), 0.0) / static_cast<double>(lengths.size());
  };
  person::BodySize size;
  size.leg = person::LegLengths{mean("thigh_mm"), mean("shank_mm")};
  const person::Body body = person::BodyOf(size);
  const linkage::Links links = linkage::Links::FromValues({59.081, 68.840, 55.964, 71.849, 118.630, 287.310});
  const linkage::UsedRange range = linkage::FindUsedRange(links, 242, std::nullopt);
  const auto at = [&](double x, double y) {
    linkage::WearOptions wear;
    wear.mount = linkage::Mount::kBehind;
    wear.placement_mm = {x, y};
    return linkage::CheckWear(links, range, body, wear);
  };
  const linkage::WearCheck on_knee = at(0, 0),
                           worn = at(-best["move_mm"][0].get<double>(), -best["move_mm"][1].get<double>());
  EXPECT_NEAR(on_body["moved"]["seat_clearance_mm"].get<double>(), on_knee.seat_clearance_mm, 1e-6);
  EXPECT_NEAR(on_body["as_worn"]["actuator_to_thigh_mm"].get<double>(), worn.thigh_clearance_mm, 1e-6);
  const auto is_allowed = [&](const linkage::WearCheck& check) {
    return check.seat_clearance_mm >= std::min(0.0, worn.seat_clearance_mm) &&
           check.thigh_clearance_mm >= std::min(0.0, worn.thigh_clearance_mm) &&
           check.shank_clearance_mm >= std::min(0.0, worn.shank_clearance_mm) &&
           check.mount_below_hip_mm >= std::min(0.0, worn.mount_below_hip_mm);
  };
  ASSERT_TRUE(on_body["nearest_mm"].is_array());
  const double x = on_body["nearest_mm"][0], y = on_body["nearest_mm"][1];
  EXPECT_TRUE(is_allowed(at(x, y)));
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j)
      if (std::hypot(2 * i, 2 * j) < std::hypot(x, y) - 1e-9) {
        EXPECT_FALSE(is_allowed(at(2 * i, 2 * j))) << i << " " << j;
      }
  EXPECT_THAT(ReadPageText(Results() / "comparison/report.html"), HasSubstr("The nearest place at which nothing"));
}

// As the list of reworded sentences has it (tests/scripts/words_test.py), in the places where a reader meets them; what
// to do next has its time, and what another time for a rise would give stands beside the limit.
TEST(StudyPage, SaysItPlainly) {
  const std::string& page = PageText();
  EXPECT_THAT(page, AllOf(HasSubstr("it takes four repetitions in each trial to tell."),
                          ContainsRegex("To hold [0-9.]+ N m the actuator pushes with at most [0-9.]+ N"),
                          ContainsRegex("Below [0-9.]+ %, the noise floor, a recording shows only noise."),
                          HasSubstr("Knee angle of the person and of the new design.")));
  EXPECT_THAT(page, AllOf(HasSubstr("Cut links (a day), test without a person (a day), record again (an hour)."),
                          ContainsRegex("limit you set \\([0-9]+ s: [0-9.]+ %\\)")));
}

// Both trials at one height; in the trade of range against misalignment the designs of the first table too.
TEST(StudyPage, ChartsCanBeComparedAndHaveTheDesignsInThem) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const chart = title => {
      const heading = [...document.querySelectorAll('figure.chart h3')].find(h3 => h3.textContent === title);
      return Chart.getChart(heading.parentElement.querySelector('canvas'));
    };
    const range = title => [chart(title).scales.y.min, chart(title).scales.y.max];
    return {without: range('Knee angle, without exoskeleton'), with: range('Knee angle, with exoskeleton'),
            designs: chart('Range of rotation against path difference').data.datasets.filter(set => set.data.length === 1)
              .map(set => set.label)};)");
  EXPECT_EQ(answer["without"], answer["with"]);
  const std::vector<std::string> designs = answer["designs"];
  EXPECT_THAT(designs, testing::IsSupersetOf({"worn", "worn, joint moved", "new design"}));
}

// Every headline number has an interval beside it, or says why it needs none.
TEST(StudyPage, HeadlineNumbersHaveIntervalsOrAreExact) {
  const std::string& page = PageText();
  const std::size_t table = page.find("<tbody>");
  const std::string first = page.substr(table, page.find("</table>", table) - table);
  EXPECT_THAT(first, ContainsRegex("as worn</th>.*[0-9] % \\([0-9.]+–[0-9.]+\\).*[0-9] s \\([0-9.]+–[0-9.]+\\)"));
  EXPECT_THAT(first, ContainsRegex("joint moved</th>.*[0-9] % \\([0-9.]+–[0-9.]+\\)"));
  const auto note_of = [&](const char* figure) {
    const std::size_t note = page.find("class=\"note\">", page.find(figure));
    return page.substr(note, page.find("</dd>", note) - note);
  };
  EXPECT_THAT(note_of("<dt>path difference, predicted RMS"), ContainsRegex("95 %: [0-9.]+ to [0-9.]+ %"));
  EXPECT_THAT(note_of("<dt>rise time"), HasSubstr("limit you set"));
  EXPECT_THAT(note_of("<dt>range of rotation"), HasSubstr("exact: follows from the links"));
  EXPECT_THAT(note_of("<dt>knee angle error, RMS"), ContainsRegex("95 %: [0-9.]+ to [0-9.]+°"));
}

// The path difference of each way is one number with one interval and one rounding, wherever the page has it.
TEST(StudyPage, ThePathDifferenceOfEachWayHasOneValue) {
  const std::string& page = PageText();
  const auto first_of = [&](const std::string& pattern, std::size_t from) {
    std::smatch found;
    const std::string text = page.substr(from);
    EXPECT_TRUE(std::regex_search(text, found, std::regex(pattern))) << pattern;
    return std::vector<std::string>(found.begin() + (found.empty() ? 0 : 1), found.end());
  };
  const std::string number = "([0-9.]+)", with_percent = number + " % \\(" + number + "–" + number + "\\)",
                    cell = "<td[^>]*>" + number + "(?: \\(" + number + "–" + number + "\\))?</td>";
  const std::vector<std::string> worn = first_of("as worn</th><td[^>]*>" + with_percent, 0),
                                 moved = first_of("joint moved</th><td[^>]*>" + with_percent, 0),
                                 made = first_of("new links</th><td[^>]*>" + with_percent, 0);
  const std::vector<std::string> cells =
      first_of("path difference, RMS \\(% of the shank length\\)</th>" + cell + cell + cell + cell + cell,
               page.find("Worn, repaired and new design"));
  ASSERT_EQ(cells.size(), 15u);
  const auto of_column = [&](std::size_t column) {
    return std::vector<std::string>(cells.begin() + 3 * static_cast<std::ptrdiff_t>(column),
                                    cells.begin() + 3 * static_cast<std::ptrdiff_t>(column + 1));
  };
  EXPECT_EQ(of_column(0), worn);
  EXPECT_EQ(of_column(2), moved);
  EXPECT_EQ(of_column(4), made);
  const std::string of_tile = "<span class=\"value\">" + number + "<.*?95 %: " + number + " to " + number;
  EXPECT_EQ(first_of(of_tile, page.find("<dt>path difference, predicted RMS")), made);
  EXPECT_EQ(first_of(of_tile, page.find("<dt>path difference, RMS, of the shank")), worn);
  EXPECT_EQ(first_of(of_tile, page.find("<dt>path difference, joint moved, of the shank")), moved);
  const std::string predicted = of_column(1).front();
  EXPECT_THAT(page, HasSubstr("worn, predicted: " + predicted + " %"));
  EXPECT_THAT(page, HasSubstr(" % instead of " + predicted + " % of the shank length"));
  EXPECT_THAT(page, HasSubstr(predicted + " % where " + worn.front() + " % was measured"));
}

// How well the joint can be put in its place: with all sources of the comparison's budget, not the markers' alone.
TEST(StudyPage, ThePredictionsIntervalIsThatOfAllSources) {
  const Json comparison = ReadJsonFile(Results() / "comparison/summary.json"), &of = comparison["uncertainty"];
  const double percent = ReadJsonFile(Results() / "redesign/summary.json")["after"]["misalignment_percent"],
               sd_mm = std::hypot(of["joint_offset_x_mm"]["anatomical_sd"].get<double>(),
                                  of["joint_offset_y_mm"]["anatomical_sd"].get<double>()) /
                       std::numbers::sqrt2,
               off_percent = 100 * std::sqrt(7.377759) * sd_mm / comparison["shank_mm"].get<double>();
  const report::Uncertain known{percent, percent, std::hypot(percent, off_percent)};
  EXPECT_THAT(PageText(),
              HasSubstr(fmt::format("95 %: {} to {} %", known.Text(1), RoundedText(known.high, known.Decimals(1)))));
}

// A knee angle is not better known in the rises' table than the same recording's budget says.
TEST(StudyPage, TheRisesKneeAnglesHaveAllSources) {
  const CsvTable rises = CsvTable::Read(Results() / "human/sit_to_stand.csv");
  const double all_sources_deg =
      ReadJsonFile(Results() / "human/summary.json")["uncertainty"]["knee_angle_deg"]["anatomical_sd"];
  for (const char* knee : {"knee_seat_off_deg_sd", "knee_max_deg_sd"})
    EXPECT_GE(rises.RequiredNumber(0, rises.Column(knee)), all_sources_deg) << knee;
}

// Where the worn joint is as good as the new one's place, nobody is told to move it there.
TEST(StudyPage, MovesTheJointOnlyWhereThatHelps) {
  const Json redesign = ReadJsonFile(Results() / "redesign/summary.json"), &range = redesign["placement_range"];
  const std::string text = redesign["build_text"];
  ASSERT_FALSE(text.empty());
  const auto is_as_good = [&](const char* axis) {
    if (!range.is_object()) return false;  // a side was not found
    const double worn_mm = redesign["before"][fmt::format("placement_{}", axis)];
    return range[axis][0].get<double>() <= worn_mm && worn_mm <= range[axis][1].get<double>();
  };
  EXPECT_EQ(text.find("mm further ") == text.npos, is_as_good("x_mm")) << text;
  EXPECT_EQ(text.find("mm lower") == text.npos && text.find("mm higher") == text.npos, is_as_good("y_mm")) << text;
}

TEST(StudyPage, ItsDrawingsHaveNoNamesOfGnuplot) {
  EXPECT_THAT(Page(), testing::Not(HasSubstr("gnuplot_")));
}

// All that is open before the first chapter, but for the contents. The first table's rows: less than as worn with the
// joint moved, in the same time, as the redesign's own summary has it.
TEST(StudyPage, TheFirstScreenIsShort) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const first = document.querySelector('#section-1');
    const answers = [...first.querySelectorAll('.answers')].filter(answer => answer.innerText.includes('Limits that are violated'));
    const forbids = Math.max(0, ...answers.map(answer => answer.getBoundingClientRect().bottom));
    for (const part of first.querySelectorAll('figure')) part.style.display = 'none';
    for (const part of document.querySelectorAll('details:not([open]) > :not(summary)')) part.style.display = 'none';
    const open = [first, ...document.querySelectorAll('main > .warnings')];
    const text = open.map(part => part.innerText).join(' ').replace(/\u2060/g, '').replace(/\([\d.]+–[\d.]+\)/g, '');
    const rows = [...first.querySelectorAll('tbody tr')].map(row => [...row.children].map(cell => parseFloat(cell.innerText)));
    return {forbids, rows, words: text.match(/[A-Za-z]{2,}/g).filter(word => word !== 'mm').length,
            numbers: text.match(/\d+(\.\d+)?/g).length};)",
                                    1400);
  EXPECT_LE(answer["words"], 80);
  EXPECT_LE(answer["numbers"], 15);  // three of them forces
  EXPECT_LE(answer["forbids"], 600) << "the violated limits stand high on a laptop's screen";
  const Json& rows = answer["rows"];
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_LT(rows[1][1], rows[0][1]);
  EXPECT_NEAR(rows[1][2].get<double>(), rows[0][2].get<double>(), 0.1);
}

// A number of the answers is that of a table or of a chapter's key figures, to its last digit.
TEST(StudyPage, EveryNumberOfTheAnswersIsInATable) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const numbers = nodes => nodes.flatMap(n => [...n.textContent.matchAll(/(?<![\w.])\d+(?:\.\d+)?/g)].map(m => m[0]));
    const all = selector => [...document.querySelectorAll(selector)];
    const told = new Set(numbers(all('section:not(#section-2) :is(td, .key .value, .key .note)')));
    const said = numbers(all('#section-2 :is(.answers dd, .key .value, .key .note)'));
    return {count: said.length, unknown: said.filter(number => !told.has(number) && number !== '95')};)");
  EXPECT_GT(answer["count"], 30);
  EXPECT_EQ(answer["unknown"], Json::array());
}

// Wherever a line ends; nor does one at the dash of an interval.
TEST(StudyPage, NoNumberStandsWithoutItsUnit) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const quantity = /\d[ \n](%|mm|s|N|N m|N[ \u00a0]m|kg|px|Hz)(?![\w])|\d\u00a0N m(?!\w)|± |\w ±/g;
    const walk = document.createTreeWalker(document.querySelector('main'), NodeFilter.SHOW_TEXT), faults = [];
    let kept = 0, intervals = 0;
    while (walk.nextNode()) {
      const node = walk.currentNode;
      if (node.parentElement.closest('script, style, svg, .code, .key .value')) continue;
      kept += (node.data.match(/\d\u00a0(%|mm|s|N)(?!\w)/g) ?? []).length;
      for (const interval of node.data.matchAll(/\d–\u2060?\d/g)) {
        if (!node.parentElement.getClientRects().length) continue;
        const range = document.createRange(), end = interval.index + interval[0].length;
        range.setStart(node, interval.index);
        range.setEnd(node, end);
        ++intervals;
        const tall = range.getBoundingClientRect().height / parseFloat(getComputedStyle(node.parentElement).fontSize);
        if (tall > 1.8 || interval[0].length !== 4)  // two lines are 2.4 letters tall or more
          faults.push(node.data.slice(Math.max(0, interval.index - 20), end + 20));
      }
      for (const fault of node.data.matchAll(quantity))
        faults.push(node.data.slice(Math.max(0, fault.index - 20), fault.index + 20));
    }
    return {kept, intervals, faults};)",
                                    400);
  EXPECT_GT(answer["kept"], 100);
  EXPECT_GE(answer["intervals"], 3);
  EXPECT_EQ(answer["faults"], Json::array());
}

TEST(StudyPage, FitsScreensOfAllWidthsInLightAndDark) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  EXPECT_THAT(browser.Open(Page()).console, IsEmpty());
  for (const int width : {1300, 800, 400}) {
    const Json answer = browser.Ask(Page(), R"(
      const wide = document.documentElement.clientWidth;
      const out = [...document.querySelectorAll('main *')].filter(n => !n.closest('.table, .drawing') && n.getClientRects().length &&
        n.getBoundingClientRect().right > wide + 1).map(n => n.tagName + '.' + n.className);
      const boxes = [...document.querySelectorAll('section > *')].map(n => n.getBoundingClientRect());
      const cross = boxes.some((a, i) => boxes.some((b, j) => i < j && a.left < b.right - 1 && b.left < a.right - 1 &&
                                                           a.top < b.bottom - 1 && b.top < a.bottom - 1));
      return {scroll: document.documentElement.scrollWidth - wide, out, cross,
              last: [...document.querySelectorAll('#section-1 .answers')].pop().getBoundingClientRect().bottom};)",
                                    width);
    EXPECT_LE(answer["scroll"], 0) << width;
    EXPECT_EQ(answer["out"], Json::array()) << width;
    EXPECT_EQ(answer["cross"], false) << width;
    if (width > 1000) {
      EXPECT_LE(answer["last"], 900) << "the first screen is one screen of a laptop";
    }
  }
}

// At the knee angles of its own program a design has its own misalignment, in its own time; links whose range ends
// before the person sits have more.
TEST(StudyPage, ItsDesignIsExploredInThePersonsMotion) {
  const review::DesignExplorer explorer(reviewing::ReadDesignSubject(Results() / "redesign", "").explored);
  const auto at_saved_angles = [&](const Json& links, const std::string& what) {
    const Json explored = explorer.Explore({{"links", links}});
    for (const Json& check : explored.at("checks"))
      if (check.at("name") == what + " at the saved knee angles") return check;
    return Json();
  };
  const Json redesign = ReadJsonFile(Results() / "redesign/summary.json"), links = explorer.About().at("links");
  const Json misalignment = at_saved_angles(links, "misalignment"), rise = at_saved_angles(links, "rise");
  EXPECT_EQ(misalignment["limit"], 4);
  EXPECT_TRUE(misalignment["holds"]);
  EXPECT_NEAR(misalignment["value"].get<double>(), redesign["misalignment_percent"].get<double>(), 0.01);
  EXPECT_EQ(rise["limit"], 40);
  EXPECT_TRUE(rise["holds"]);
  EXPECT_NEAR(rise["value"].get<double>(), redesign["after"]["program_duration_s"].get<double>(), 0.1);
  Json slower = links;
  slower[0] = links[0].get<double>() + 1;
  EXPECT_NE(at_saved_angles(slower, "rise")["value"], rise["value"]);
  Json short_ranged = links;
  short_ranged[5] = 200;
  EXPECT_GT(at_saved_angles(short_ranged, "misalignment")["value"], 4);
  EXPECT_FALSE(at_saved_angles(short_ranged, "misalignment")["holds"]);
}

// Contrast as WCAG 2.1 has it, of what is drawn on white and of the same in the dark: `shown` is what the drawings'
// own filter makes of a colour.
const std::string kContrast = R"(
    const linear = c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
    const contrast = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
    const turn = [[-0.574, 1.43, 0.144], [0.426, 0.43, 0.144], [0.426, 1.43, -0.856]];
    const shown = colour => turn.map(row => row.reduce((sum, w, i) => sum + w * (0.9 - 0.8 * colour[i]), 0))
                                .map(c => Math.min(Math.max(c, 0), 1));
    const white = [1, 1, 1], black = shown(white);
    const least = colour => Math.min(contrast(colour, white), contrast(shown(colour), black));
    const parsed = text => text.startsWith('rgb') ? text.match(/[\d.]+/g).slice(0, 3).map(c => c / 255) : null;
)";

TEST(StudyPage, DrawingsCanBeReadInLightAndDark) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer =
      Browser().Ask(PageOfDrawings(), kContrast + fmt::format("const grid = ['{}', '#ffffff'];", colour::kGrid) + R"(
    const isGrid = c => grid.includes('#' + c.map(part => Math.round(255 * part).toString(16).padStart(2, '0')).join('').toUpperCase())
                        || c.every(part => part === 1);
    const faults = new Set();
    let texts = 0, lines = 0;
    for (const paper of document.querySelectorAll('.paper')) {
      for (const part of paper.querySelectorAll('tspan')) {
        const colour = parsed(getComputedStyle(part).fill);
        if (!colour || !part.textContent.trim()) continue;
        ++texts;
        if (least(colour) < 4.5) faults.add(`${paper.ariaLabel}: text ${part.textContent}: ${least(colour).toFixed(2)}`);
      }
      for (const line of paper.querySelectorAll('path, line, circle, polyline')) {
        if (line.closest('defs')) continue;
        const style = getComputedStyle(line), colour = parsed(style.stroke);
        if (!colour || isGrid(colour)) continue;
        ++lines;
        if (least(colour) < 3) faults.add(`${paper.ariaLabel}: line ${style.stroke}: ${least(colour).toFixed(2)}`);
      }
    }
    return {texts, lines, faults: [...faults]};)");
  EXPECT_GT(answer["texts"], 200);
  EXPECT_GT(answer["lines"], 200);
  EXPECT_EQ(answer["faults"], Json::array());
}

// A name on a ground of its own is drawn twice, first for its ground.
TEST(StudyPage, LabelsOfDrawingsAreWithinThePictureAndNotOverEachOther) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(PageOfDrawings(), R"(
    const faults = [];
    for (const paper of document.querySelectorAll('.paper')) {
      const frame = paper.querySelector('svg').getBoundingClientRect();
      const texts = [...paper.querySelectorAll('text')].filter(text => text.textContent.trim() &&
                                                                       !text.closest('[style*=filter]'));
      const boxes = texts.map(text => text.getBoundingClientRect()).map(box => {
        const room = 0.2 * Math.min(box.width, box.height);  // of a line above and below its letters
        return {left: box.left + room, right: box.right - room, top: box.top + room, bottom: box.bottom - room};
      });
      texts.forEach((text, i) => {
        const a = boxes[i];
        if (a.left < frame.left || a.right > frame.right || a.top < frame.top || a.bottom > frame.bottom)
          faults.push(`${paper.ariaLabel}: outside: ${text.textContent}`);
        boxes.forEach((b, j) => {
          if (i < j && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
            faults.push(`${paper.ariaLabel}: ${text.textContent} over ${texts[j].textContent}`);
        });
      });
    }
    return {drawings: document.querySelectorAll('.paper').length, faults};)");
  EXPECT_GT(answer["drawings"], 12);
  EXPECT_EQ(answer["faults"], Json::array());
}

TEST(StudyPage, DrawingsStandInThePageAtOneSize) {
  LAKE_SKIP_WITHOUT_BROWSER();
  EXPECT_THAT(Page(), testing::Not(HasSubstr("data:image/svg+xml")));
  EXPECT_THAT(Page(), testing::Not(HasSubstr("Gnuplot<")));
  for (const int width : {1400, 400}) {
    const Json answer = Browser().Ask(Page(), R"(
      const scales = new Set(), ids = [...document.querySelectorAll('[id]')].map(part => part.id);
      let least = Infinity;
      for (const svg of document.querySelectorAll('.paper svg')) {
        const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
        scales.add(scale.toFixed(2));
        for (const part of svg.querySelectorAll('tspan'))
          if (part.textContent.trim()) least = Math.min(least, scale * parseFloat(getComputedStyle(part).fontSize));
      }
      return {scales: [...scales], least, repeated: ids.length - new Set(ids).size};)",
                                      width);
    EXPECT_EQ(answer["scales"].size(), 1u) << answer;
    EXPECT_GE(answer["least"], 7.5) << width << " px wide: type of so many px";
    EXPECT_EQ(answer["repeated"], 0);
  }
}

// No more of a dark page is as light as paper than its letters are.
TEST(StudyPage, DrawingsAreNoWhiteSlabsInTheDark) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  browser.PreferDark();
  const cv::Mat picture = video::ReadImage(browser.Screenshot(PageOfDrawings(), 1300, 4000), true);
  cv::Mat channel, light;
  cv::extractChannel(picture, channel, 1);
  cv::compare(channel, 200, light, cv::CMP_GT);
  EXPECT_LT(cv::countNonZero(light), 0.05 * static_cast<double>(light.total()));
}

}  // namespace
}  // namespace lake
