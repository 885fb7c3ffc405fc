// Whole studies of marker files: what comes out, what is done again, what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "lake/core/error.h"
#include "pipeline/study_trials.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

TEST(StudyOfMarkerFiles, FindsWhatWasMadeAndIsDoneOnce) {
  StudyFolder study;
  const Json summary = study.Go();
  const Json& comparison = summary["comparison"];
  // 18 mm and 32 mm apart in a shank that holds marker noise of 0.1 mm and a body that sways by itself in each trial.
  EXPECT_NEAR(comparison["decomposition"]["offset_mm"][0].get<double>(), 18, 1);
  EXPECT_NEAR(comparison["decomposition"]["offset_mm"][1].get<double>(), 32, 1);
  EXPECT_NEAR(comparison["metrics"]["rms_mm"].get<double>(), std::hypot(18, 32), 2);
  EXPECT_EQ(summary["human"]["sit_to_stands"].size(), 2u);
  for (const char* file : {"report.html", "summary.json", "human/kinematics.csv", "exo/gait.png",
                           "comparison/comparison.json", "comparison/report.html", "human/summary.json"})
    EXPECT_TRUE(fs::is_regular_file(study.Out() / file)) << file;

  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(study.Done(study.Go()), IsEmpty());
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3));
}

}  // namespace
}  // namespace lake
