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

TEST(StudyPage, AnswersTheReadersQuestionsFirst) {
  const std::string& page = Page();
  const std::size_t warnings = page.find("<h2>Warnings</h2>"), contents = page.find("<nav");
  std::size_t last = 0;
  for (const char* question :
       {"What is wrong", "What to build", "What it gives, what it costs", "How sure it is", "What next"}) {
    const std::size_t at = page.find(fmt::format("<dt>{}</dt>", question));
    ASSERT_NE(at, page.npos) << question;
    EXPECT_GT(at, last) << question;
    last = at;
  }
  EXPECT_LT(last, warnings);
  EXPECT_LT(warnings, contents);
  const std::string first = page.substr(0, warnings);
  EXPECT_THAT(first, AllOf(HasSubstr("% of the shank length"), HasSubstr("further"), HasSubstr("instead of"),
                           HasSubstr("noise floor"), HasSubstr("predicted, not recorded")));
  for (const char* file : {"simulation/design.dxf", "simulation/schematic.svg", "redesign/design.yaml"})
    EXPECT_THAT(first, HasSubstr(file));
  // What collides on the body stands there in words, and first among the warnings.
  EXPECT_THAT(first, HasSubstr("overlaps the thigh by"));
  EXPECT_THAT(first, HasSubstr("No clearance was required of the design."));
  EXPECT_THAT(page.substr(warnings, 200), HasSubstr("Fit on the body: "));
}

// A number of the first screen is that of a table or of a chapter's key figures, to its last digit.
TEST(StudyPage, EveryNumberOfTheFirstScreenIsInATable) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json answer = Browser().Ask(Page(), R"(
    const numbers = nodes => nodes.flatMap(n => [...n.textContent.matchAll(/(?<![\w.])\d+(?:\.\d+)?/g)].map(m => m[0]));
    const all = selector => [...document.querySelectorAll(selector)];
    const told = new Set(numbers(all('section:not(#section-1) :is(td, .key .value, .key .note)')));
    const first = numbers(all('#section-1 :is(.answers dd, .key .value, .key .note)'));
    return {count: first.length, unknown: first.filter(number => !told.has(number))};)");
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
      const out = [...document.querySelectorAll('main *')].filter(n => !n.closest('.table') && n.getClientRects().length &&
        n.getBoundingClientRect().right > wide + 1).map(n => n.tagName + '.' + n.className);
      const boxes = [...document.querySelectorAll('section > *')].map(n => n.getBoundingClientRect());
      const cross = boxes.some((a, i) => boxes.some((b, j) => i < j && a.left < b.right - 1 && b.left < a.right - 1 &&
                                                           a.top < b.bottom - 1 && b.top < a.bottom - 1));
      return {scroll: document.documentElement.scrollWidth - wide, out, cross,
              last: document.querySelector('.answers').getBoundingClientRect().bottom};)",
                                    width);
    EXPECT_LE(answer["scroll"], 0) << width;
    EXPECT_EQ(answer["out"], Json::array()) << width;
    EXPECT_EQ(answer["cross"], false) << width;
    if (width > 1000) {
      EXPECT_LE(answer["last"], 900) << "the answers stand above the fold of a laptop";
    }
  }
}

}  // namespace
}  // namespace lake
