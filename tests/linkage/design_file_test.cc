#include "lake/linkage/design_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kLinksLine = "links: {l1: 59.081, l2: 68.84, l3: 55.964, l4: 71.849, l5: 118.63, l6: 287.31}\n";

class DesignFile : public ::testing::Test {
 protected:
  void ExpectError(const std::string& text, const std::string& message) {
    WriteTextFile(path_, text);
    EXPECT_THAT([&] { linkage::ReadDesign(path_); }, ThrowsMessage<Error>(HasSubstr(message))) << text;
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "design.yaml";
};

TEST_F(DesignFile, ReadsBackWhatWasWritten) {
  linkage::Design design;
  design.links = {59.081, 68.840, 55.964, 71.849, 118.630, 287.310 + 1e-13};
  design.d_min_mm = 242.125;
  design.d_max_mm = 374.5205;
  design.range_deg = 148.5715062;
  design.placement_mm = {1.0 / 3, -12.5};
  design.mount = linkage::Mount::kBehind;
  design.made_by = "it's lake-optimize 'x': 1";
  design.parts = {{"plate", "6mm,S235"}};
  design.load = {{"profile", "../it's/loads: \"1\".json"}, {"knee_torque_nm", "25"}};
  linkage::StrokeProgram free;
  free.kind = linkage::StrokeProgram::Kind::kFree;
  free.knots = {{0, 250}, {0.1, 251.7}, {1.0 / 7 + 1, 300}};
  for (const auto& program :
       {std::optional<linkage::StrokeProgram>(), std::optional(linkage::StrokeProgram{}), std::optional(free)}) {
    design.program = program;
    linkage::WriteDesign(path_, design);
    const linkage::Design read = linkage::ReadDesign(path_);
    EXPECT_EQ(read.links.Values(), design.links.Values());
    EXPECT_EQ(read.d_min_mm, design.d_min_mm);
    EXPECT_EQ(read.d_max_mm, design.d_max_mm);
    EXPECT_EQ(read.range_deg, design.range_deg);
    EXPECT_EQ(read.placement_mm, design.placement_mm);
    EXPECT_EQ(read.mount, design.mount);
    EXPECT_EQ(read.made_by, design.made_by);
    EXPECT_EQ(read.parts, design.parts);
    EXPECT_EQ(read.body, design.body);
    EXPECT_EQ(read.load, design.load);
    ASSERT_EQ(read.program.has_value(), program.has_value());
    if (!program) continue;
    EXPECT_EQ(read.program->kind, program->kind);
    EXPECT_EQ(read.program->speed_mm_s, program->speed_mm_s);
    ASSERT_EQ(read.program->knots.size(), program->knots.size());
    for (std::size_t i = 0; i < program->knots.size(); ++i) {
      EXPECT_EQ(read.program->knots[i].time_s, program->knots[i].time_s);
      EXPECT_EQ(read.program->knots[i].stroke_mm, program->knots[i].stroke_mm);
    }
  }
}

TEST_F(DesignFile, SaysWhatIsWrongAndWhere) {
  ExpectError("links: {l1: 1, l2: 2, l3: 3, l4: 4, l5: 5}\nd_min_mm: 242\n", ":1: the key 'links: l6' is missing");
  ExpectError("d_min_mm: 242\n", ":1: the key 'links' is missing");
  ExpectError(kLinksLine, "the key 'd_min_mm' is missing");
  ExpectError(std::string(kLinksLine) + "d_min_mm: 242\ncolour: red\n", ":3: unknown key 'colour'");
  ExpectError("d_min_mm: 242\nlinks:\n  l1: 59\n  l2: 68\n  l3: 55\n  l4: 71\n  l5: 118\n  l6: 287\n  l7: 9\n",
              ":9: unknown key 'l7'");
  ExpectError("d_min_mm: 242\nlinks:\n  l1: 59\n  l2: -68\n  l3: 55\n  l4: 71\n  l5: 118\n  l6: 287\n",
              "link l2 is -68 mm");
  ExpectError("links: {l1: 59, l2: .nan, l3: 55, l4: 71, l5: 118, l6: 287}\nd_min_mm: 242\n",
              ":1: '.nan' is not a finite number");
  ExpectError("links: {l1: 59, l2: 0, l3: 55, l4: 71, l5: 118, l6: 287}\nd_min_mm: 242\n", "link l2 is 0 mm");
  ExpectError("links: [1, 2]\nd_min_mm: 242\n", ":1: 'links' must have keys, such as l1");
  ExpectError(std::string(kLinksLine) + "d_min_mm: -1\n", "d_min_mm must be above 0, not -1");
  ExpectError(std::string(kLinksLine) + "d_min_mm: long\n", ":2: 'long' is not a finite number");
  ExpectError(std::string(kLinksLine) + "d_min_mm: 242\nd_max_mm: 240\n", "d_max_mm = 240 must exceed d_min_mm = 242");
  ExpectError(std::string(kLinksLine) + "d_min_mm: 242\nplacement_mm: [1]\n",
              ":3: 'placement_mm' must have 2 numbers, not 1");
  ExpectError(std::string(kLinksLine) + "d_min_mm: 242\nmount: under\n", ":3: a mount is beside or behind the leg");
  ExpectError(std::string(kLinksLine) + "d_min_mm: 242\nparts: thick\n", ":3: 'parts' must have keys");
  ExpectError("d_min_mm: 242\nbounds: {l1: [40, 60]}\n", "is a problem, not a design");
  ExpectError("- a\n- b\n", "a design is a map");
  ExpectError("", "a design is a map");
  ExpectError("links: {l1: [\n", "not YAML");
}

TEST_F(DesignFile, SaysWhatIsWrongInAProgram) {
  const std::string head = std::string(kLinksLine) + "d_min_mm: 242\n";
  ExpectError(head + "program: {kind: dance}\n", ":3: program kind 'dance' is neither");
  ExpectError(head + "program: {kind: constant}\n", ":3: the key 'program: speed_mm_s' is missing");
  ExpectError(head + "program: {kind: constant, speed_mm_s: 0}\n", ":3: speed_mm_s must be above 0, not 0");
  ExpectError(head + "program: {kind: free, knots: [[0, 250]]}\n", ":3: a free program needs at least two knots");
  ExpectError(head + "program:\n  kind: free\n  knots:\n    - [0, 250]\n    - [0, 251]\n",
              ":7: the times of knots must ascend");
  ExpectError(head + "program:\n  kind: free\n  knots:\n    - [0, 250]\n    - [1]\n",
              ":7: a knot is [time_s, stroke_mm], not 1 values");
  ExpectError(head + "program: {kind: constant, speed_mm_s: 5, knots: []}\n", ":3: unknown key 'knots'");
}

TEST_F(DesignFile, AbsentFile) {
  EXPECT_THAT([] { linkage::ReadDesign("/no/such/design.yaml"); },
              ThrowsMessage<Error>(HasSubstr("/no/such/design.yaml")));
}

}  // namespace
}  // namespace lake
