// A study whose program a person has to be in balance along: what its page says of it, and the moments behind that.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "lake/compare/comparison_file.h"
#include "lake/compare/misalignment.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/core/uncertain_text.h"
#include "lake/loads/body_path.h"
#include "lake/redesign/balance.h"
#include "lake/reviewing/design_review.h"
#include "page_text.h"
#include "pipeline/study_trials.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// From one text to another behind it; empty where they are not there.
std::string Between(const std::string& page, const std::string& from, const std::string& to) {
  const std::size_t begin = page.find(from), end = page.find(to, begin);
  return begin == page.npos || end == page.npos ? "" : page.substr(begin, end - begin);
}

// The largest difference between the knee's moments of the rises, and those of the person's mean motion in the
// program's model, gone along with their own knee angles in their own time; N m. Without the first two percents on the
// feet, in which the rises' own moments jump as the fit of the trunk begins, and the last five, over which
// accelerations reach: a program stands still at its end, and a person does not yet.
double OwnMomentsDifference(const fs::path& results) {
  const compare::StsCurve human = compare::ReadComparison(results / "comparison").human;
  const CsvTable loads = CsvTable::Read(results / "loads/loads.csv");
  std::map<double, double> mean_nm;
  for (std::size_t row = 0; row < loads.Rows(); ++row)
    if (const auto knee_nm = loads.Number(row, loads.Column("knee_nm"));
        knee_nm && loads.Text(row, loads.Column("repetition")) == "mean")
      mean_nm[loads.RequiredNumber(row, loads.Column("percent"))] = *knee_nm;
  const redesign::HumanMotion motion = redesign::MakeHumanMotion(human);
  std::vector<double> knee_rad;
  for (const redesign::HumanSample& sample : motion) knee_rad.push_back(sample.knee_rad);
  const redesign::BalanceCourse course =
      redesign::FindBalance(motion, loads::ReadBodyPath(results / "loads"), knee_rad, {}, human.duration_s);
  double largest_nm = 0;
  const double first = course.samples.front().percent + 2;
  for (const redesign::BalanceSample& sample : course.samples)
    if (sample.percent >= first && sample.percent <= 95 && mean_nm.contains(sample.percent))
      largest_nm = std::max(largest_nm, std::abs(sample.knee_nm - mean_nm.at(sample.percent)));
  return mean_nm.empty() ? INFINITY : largest_nm;
}

TEST(StudyOfBalance, SaysWhetherThePersonCanFollowAndWhatThatCosts) {
  StudyFolder study;
  WriteTextFile(study.Folder() / "worn.yaml",
                "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 242\n"
                "placement_mm: [18, 32]\n");
  study.WriteStudy(std::string(kNoAnimation) +
                   "design: {worn: worn.yaml}\nloads: {mass_kg: 70, height_mm: 1750}\n"
                   "reoptimize: {problem: {margins: {grashof_mm: 2, singularity_mm: 2}, standing_deg: 5}, "
                   "max_misalignment_percent: 4, program: free, duration_s: 40, fit_placement: true, starts: 1, "
                   "balance: {margin_mm: 20}}\n");
  study.Go();
  const Json redesign = ReadJsonFile(study.Out() / "redesign/summary.json"), balance = redesign["balance"],
             after = redesign["after"], without = balance["without"];
  // The rise that was recorded is one of momentum: a program that keeps its lean cannot be followed.
  ASSERT_LT(without["balance_margin_mm"].get<double>(), 0);
  ASSERT_GE(after["balance_margin_mm"].get<double>(), 20 - 0.01);

  const std::string page = ReadPageText(study.Out() / "report.html");
  EXPECT_THAT(page, Not(HasSubstr("without support"))) << "the new program is in balance";
  const std::string table = Between(page, "Balance along the program: the centre of pressure at least 20", "</table>");
  for (const char* key :
       {"balance_margin_mm", "range_deg", "misalignment_percent", "angle_mismatch_max_deg", "program_duration_s"})
    for (const Json& design : {after, without})
      EXPECT_THAT(table, HasSubstr(RoundedText(design[key].get<double>(), 1))) << key;
  const Json did = ReadJsonFile(study.Out() / "loads/summary.json")["balance"]["own"];
  for (const char* key : {"margin_mm", "rise_s"})
    EXPECT_THAT(table, HasSubstr(RoundedText(did[key].get<double>(), 1))) << key;
  // One peak moment, with its interval; what another pace makes of it is a share of that.
  const double own_nm = did["peak_knee_nm"], program_nm = balance["peak_knee_nm"];
  EXPECT_THAT(table, HasSubstr(RoundedText(100 * program_nm / own_nm, 0)));
  for (const double nm : {own_nm, program_nm}) {
    EXPECT_THAT(table, Not(HasSubstr(RoundedText(nm, 1))));
    EXPECT_THAT(page, Not(HasSubstr(RoundedText(nm, 1) + " N m")));
  }
  const std::string answer = Between(page, "<dt>Can a person follow it</dt>", "</dd>");
  EXPECT_THAT(answer, HasSubstr("Yes: in "));
  EXPECT_THAT(answer, HasSubstr(" outside the foot, it has "));
  EXPECT_THAT(answer, Not(HasSubstr("−"))) << "what is less or more is said in words";
  const std::string compared = Between(page, "Worn, repaired and new design", "</table>");
  for (const char* design : {"before", "after"})
    EXPECT_THAT(compared, HasSubstr(RoundedText(redesign[design]["balance_margin_mm"].get<double>(), 1)));

  EXPECT_LT(OwnMomentsDifference(study.Out()), 1) << "N m, as the method asks";

  // Its new design can be explored with the limits that it was found under.
  const reviewing::DesignSubject subject = reviewing::ReadDesignSubject(study.Out() / "redesign", "");
  EXPECT_EQ(subject.explored.max_misalignment_percent, 4);
  EXPECT_NE(subject.no_command, "");
}

TEST(StudyOfBalanceTexts, AJointThatIsNowhereElseIsOnTheKnee) {
  EXPECT_EQ(compare::DescribeJoint({0.3, -0.2}), "on the knee");
  EXPECT_EQ(compare::DescribeJoint({0.3, -0.7}), "0 mm in front of the knee and 1 mm below it along the shank");
}

}  // namespace
}  // namespace lake
