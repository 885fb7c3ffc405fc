// The report of a study as a browser shows it: the first screen, its numbers, its layout.
#include <gmock/gmock.h>

#include "lake/core/atomic_file.h"
#include "pipeline/study_trials.h"
#include "report/browser.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// The published design as it was worn: 18 mm in front of the knee and 32 mm above it, as ExoMotionOptions() has it.
constexpr const char* kWorn =
    "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n"
    "placement_mm: [18, 32]\n";
constexpr const char* kDesign =
    "design: {worn: worn.yaml}\nreoptimize: {problem: {margins: {grashof_mm: 2, singularity_mm: 2}, load: "
    "{max_force_n: 2000}, standing_deg: 5}, max_misalignment_percent: 4, program: free, duration_s: 40, "
    "fit_placement: true, pareto: 2, starts: 1}\nstroke: {}\n";

const std::string& Page() {
  static const std::string page = [] {
    const StudyFolder study;
    WriteTextFile(study.Folder() / "worn.yaml", kWorn);
    const_cast<StudyFolder&>(study).WriteStudy(kDesign);
    const_cast<StudyFolder&>(study).Go();
    return ReadTextFile(study.Out() / "report.html");
  }();
  return page;
}

// What is wrong and the first thing to do; the ways, from the cheapest on; what forbids them; a picture, a chart; what
// next. Then the warnings, and all of it in words.
TEST(StudyPage, SaysTheCheapestRepairFirst) {
  const std::string& page = Page();
  const std::size_t warnings = page.find("<h2>Warnings</h2>"), contents = page.find("<nav");
  std::size_t last = 0;
  for (const char* part :
       {"<p>The exoskeleton&#39;s joint sits in front of and above the knee. Move it onto the knee first.</p>",
        "as worn</th>", "same links, joint moved</th>", "new links</th>", "<dt>What forbids it</dt>",
        "<figure class=\"chart half\">", "as worn, with the joint moved", "<dt>Next</dt>", "<h2>Warnings</h2>",
        "<h2>Why, and how sure</h2>", "<dt>What is wrong</dt>", "<dt>What to build for new links</dt>",
        "<dt>How sure it is</dt>"}) {
    const std::size_t at = page.find(part, last);
    ASSERT_NE(at, page.npos) << part;
    last = at;
  }
  EXPECT_LT(warnings, contents);
  const std::string first = page.substr(0, warnings);
  EXPECT_THAT(first, AllOf(HasSubstr("overlaps the thigh by"), HasSubstr("limit you set"), HasSubstr("mm back"),
                           HasSubstr("mm lower")));
  EXPECT_THAT(page.substr(warnings, 200), HasSubstr("Fit on the body: "));
  for (const char* file : {"simulation/design.dxf", "simulation/schematic.svg", "redesign/design.yaml"})
    EXPECT_THAT(page, HasSubstr(file));
}

// The first table's rows: less than as worn with the joint moved, in the same time, as the redesign's own summary has
// it.
TEST(StudyPage, TheFirstScreenIsShort) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const first = document.querySelector('#section-1');
    const forbids = first.querySelector('.answers').getBoundingClientRect().bottom;
    for (const part of first.querySelectorAll('figure')) part.style.display = 'none';
    const text = first.innerText.replace(/\([\d.]+–[\d.]+\)/g, '');
    const rows = [...first.querySelectorAll('tbody tr')].map(row => [...row.children].map(cell => parseFloat(cell.innerText)));
    return {forbids, rows, words: text.match(/[A-Za-z]{2,}/g).filter(word => word !== 'mm').length,
            numbers: text.match(/\d+(\.\d+)?/g).length};)",
                                    1400);
  EXPECT_LE(answer["words"], 80);
  EXPECT_LE(answer["numbers"], 12);
  EXPECT_LE(answer["forbids"], 600) << "what forbids it stands high on a laptop's screen";
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

TEST(StudyPage, FitsScreensOfAllWidthsInLightAndDark) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  EXPECT_THAT(browser.Open(Page()).console, IsEmpty());
  for (const int width : {1300, 400}) {
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

}  // namespace
}  // namespace lake
