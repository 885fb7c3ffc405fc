// Actuators and load profiles as files have them.
#include "lake/problem/linear_actuator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/problem/load_profile.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "message_of.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using ::testing::HasSubstr;

class ActuatorFile : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) {
    WriteTextFile(path_, text);
    return path_;
  }
  template <typename Read>
  std::string ErrorOf(const std::string& text, const Read& read) {
    return MessageOf([&] { read(Write(text)); });
  }
  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "table.csv";
};

TEST(Actuators, CatalogueIsTheFile) {
  const auto known = problem::KnownActuators(),
             file = problem::ReadActuators(SourceDir() / "calibration/actuators.csv");
  ASSERT_EQ(known.size(), file.size());
  for (std::size_t i = 0; i < known.size(); ++i) {
    EXPECT_EQ(known[i].name, file[i].name);
    EXPECT_FALSE(known[i].source.empty()) << known[i].name;
    EXPECT_EQ(known[i].closed_mm, file[i].closed_mm);
  }
  EXPECT_EQ(problem::FindActuator("L16-140-150").closed_mm, 208);
  EXPECT_THROW(problem::FindActuator("L16"), Error);
}

TEST(Actuators, LawIsALineBetweenThePointsKnown) {
  const problem::LinearActuator actuator = problem::FindActuator("L16-50-35");
  EXPECT_EQ(actuator.SpeedAt(0), 32);
  EXPECT_EQ(actuator.SpeedAt(50), 16);
  EXPECT_NEAR(actuator.SpeedAt(25), 24, 1e-12);
  EXPECT_EQ(actuator.LiftingForce(), 50);
  EXPECT_NEAR(actuator.LargestPower(), 0.05 * 16, 1e-12);  // its parabola's top lies at the last point
  const problem::LinearActuator flat = problem::FindActuator("LA31-3500");
  EXPECT_EQ(flat.SpeedAt(3000), 5);
  const problem::LinearActuator no_law = problem::FindActuator("PA-14P-4-150");
  EXPECT_FALSE(no_law.HasForceSpeedLaw());
  EXPECT_EQ(no_law.SpeedAt(600), 15);
  EXPECT_FALSE(problem::FindActuator("LA23-2500").HasSpeed());
}

TEST(Actuators, LawOfManyPointsIsTheLowestLine) {
  problem::LinearActuator actuator;
  actuator.name = "concave";
  actuator.no_load_speed_mm_s = 10;
  actuator.force_speed = {{50, 9}, {100, 5}};
  actuator.Check();
  EXPECT_NEAR(actuator.SpeedAt(25), 9.5, 1e-12);
  EXPECT_NEAR(actuator.SpeedAt(75), 7, 1e-12);
  double power_w = 0;
  for (double force = 0; force <= 100; force += 0.01)
    power_w = std::max(power_w, force * actuator.SpeedAt(force) / 1000);
  EXPECT_NEAR(actuator.LargestPower(), power_w, 1e-7);
  actuator.force_speed = {{50, 4}, {100, 3}};  // bends inwards: never above its points
  EXPECT_LE(actuator.SpeedAt(25), 7);
  EXPECT_NEAR(actuator.SpeedAt(50), 4, 1e-12);
}

TEST_F(ActuatorFile, ErrorsNameLineAndReason) {
  const std::string header = "name,max_force_n,no_load_speed_mm_s,force_speed_points\n";
  const struct {
    std::string text;
    const char* reason;
  } cases[] = {{"name,volume\nA,3\n", "unknown column 'volume'"},
               {"max_force_n\n3\n", "name"},
               {header, "no actuator"},
               {header + ",1,2,\n", ":2: an actuator needs a name"},
               {header + "A,-1,2,\n", ":2: max_force_n = -1"},
               {header + "A,nan,2,\n", ":2"},
               {header + "A,many,2,\n", ":2"},
               {header + "A,10,2,fast\n", ":2: 'fast' is no point"},
               {header + "A,10,2,3 mm/s at 5 N\n", "cannot grow with the force"},
               {header + "A,10,9,3 mm/s at 5 N; 2 mm/s at 5 N\n", "two speeds at 5 N"},
               {header + "A,1,2,\nA,3,4,\n", ":3: 'A' stands twice"}};
  for (const auto& [text, reason] : cases) {
    const std::string error = ErrorOf(text, [](const auto& path) { problem::ReadActuators(path); });
    EXPECT_THAT(error, HasSubstr(reason)) << text;
    EXPECT_THAT(error, ::testing::Not(HasSubstr("\n")));
  }
  Write(header + "A,1,2,\nB,3,4,\n");
  EXPECT_EQ(problem::FindActuator(path_.string() + ":B").max_force_n, 3);
  EXPECT_THROW(problem::FindActuator(path_.string()), Error);
}

TEST_F(ActuatorFile, ProfileErrorsNameFileAndReason) {
  const struct {
    const char *text, *reason;
  } cases[] = {
      {"[]", "not a profile"},
      {"{}", "'time_s' is missing"},
      {R"({"time_s": [0, 1, "x"], "percent": [0, 50, 100], "knee_deg": [90, 40, 5], "knee_nm": [1, 2, 3]})",
       "no number"},
      {R"({"time_s": [0, 1], "percent": [0, 100], "knee_deg": [90, 5], "knee_nm": [1, 2]})", "at least three"},
      {R"({"time_s": [0, 1, 2], "percent": [0, 50, 100], "knee_deg": [90, 5], "knee_nm": [1, 2, 3]})", "equal length"},
      {R"({"time_s": [0, 1, 2], "percent": [0, 50, 90], "knee_deg": [90, 40, 5], "knee_nm": [1, 2, 3]})",
       "from 0 to 100"},
      {R"({"time_s": [0, 1, 2], "percent": [0, 50, 100], "knee_deg": [90, null, 5], "knee_nm": [1, 2, 3]})",
       "knee angle"},
      {R"({"time_s": [0, 1, 2], "percent": [0, 50, 100], "knee_deg": [90, 40, 5], "knee_nm": [1, 2e9, 3]})",
       "no knee bears"},
      {R"({"time_s": [0, 1, 2], "percent": [0, 50, 100], "knee_deg": [90, 40, 5], "knee_nm": [null, null, null]})",
       "no known moment"},
      {R"({"time_s": [2, 1, 0], "percent": [0, 50, 100], "knee_deg": [90, 40, 5], "knee_nm": [1, 2, 3]})",
       "cannot take"},
  };
  for (const auto& [text, reason] : cases) {
    const std::string error = ErrorOf(text, [](const auto& path) { problem::ReadLoadProfile(path); });
    EXPECT_THAT(error, ::testing::AllOf(HasSubstr(reason), HasSubstr(path_.filename().string()))) << text;
  }
}

// A design's file may name an actuator's table of its own; both are beside the file, wherever the program is started.
TEST_F(ActuatorFile, OfADesignIsBesideTheDesign) {
  Write("name,maker,closed_mm,stroke_mm,max_force_n\nstrong,M,242,150,2000\n");
  const std::string table = path_.filename().string();
  for (const std::string& text : {table, table + ":strong"}) {
    problem::SynthesisProblem problem;
    OptionList options;
    problem::DescribeLoad(problem, options);
    EXPECT_EQ(problem::TakeFromDesign({{"actuator", text}}, path_.parent_path() / "design.yaml", options), "");
    ASSERT_TRUE(problem.actuator) << text;
    EXPECT_EQ(problem.actuator->name, "strong");
    linkage::Design design = problem::DesignOf(problem, {});
    problem::TakeProblem(problem, path_.parent_path(), design);
    EXPECT_EQ(design.load["actuator"], table + ":strong");
  }
  problem::SynthesisProblem problem;
  OptionList options;
  problem::DescribeLoad(problem, options);
  EXPECT_EQ(problem::TakeFromDesign({{"actuator", "absent.csv"}}, "d/design.yaml", options), "d/absent.csv");
}

}  // namespace
}  // namespace lake
