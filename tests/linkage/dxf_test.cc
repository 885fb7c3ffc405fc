// The link plates, read back from the file by dxflib's own reader.
#include <dl_creationadapter.h>
#include <dl_dxf.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/drawing/linkage_dxf.h"
#include "linkage/random_links.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
constexpr linkage::Links kOptimum{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};

struct Edge {
  Vector2d from, to;
  double radius;  // 0: straight
};

class Reader : public DL_CreationAdapter {
 public:
  void addLine(const DL_LineData& line) override {
    EXPECT_EQ(attributes.getLayer(), "OUTLINE");
    edges.push_back({{line.x1, line.y1}, {line.x2, line.y2}, 0});
  }
  void addArc(const DL_ArcData& arc) override {
    EXPECT_EQ(attributes.getLayer(), "OUTLINE");
    const auto at = [&](double degrees) {
      const double angle = RadiansFromDegrees(degrees);
      return Vector2d(arc.cx + arc.radius * std::cos(angle), arc.cy + arc.radius * std::sin(angle));
    };
    edges.push_back({at(arc.angle1), at(arc.angle2), arc.radius});
  }
  void addCircle(const DL_CircleData& circle) override {
    EXPECT_EQ(attributes.getLayer(), "HOLES");
    holes.emplace_back(circle.cx, circle.cy);
    hole_radii.push_back(circle.radius);
  }
  void addText(const DL_TextData& text) override {
    EXPECT_EQ(attributes.getLayer(), "LABELS");
    labels.push_back(text.text);
  }

  std::vector<Edge> edges;
  std::vector<Vector2d> holes;
  std::vector<double> hole_radii;
  std::vector<std::string> labels;
};

Reader ReadBack(const std::filesystem::path& path) {
  Reader reader;
  DL_Dxf dxf;
  EXPECT_TRUE(dxf.in(path.string(), &reader));
  return reader;
}

// Coordinates are written with 16 digits; angles of arcs go through degrees.
constexpr double kWritten_mm = 1e-9;

TEST(LinkPlates, HolesAreAsFarApartAsTheLinksAreLong) {
  testing::RandomLinks random;
  const TemporaryFolder folder;
  for (int i = 0; i < 20; ++i) {
    const linkage::Links links = i == 0 ? kOptimum : random.Next();
    drawing::WriteLinkPlates(folder / "design.dxf", links);
    const Reader plates = ReadBack(folder / "design.dxf");
    ASSERT_EQ(plates.holes.size(), 9u);
    const auto distance = [&](int a, int b) { return (plates.holes[a] - plates.holes[b]).norm(); };
    EXPECT_NEAR(distance(0, 1), links.l1, kWritten_mm);
    EXPECT_NEAR(distance(2, 3), links.l2, kWritten_mm);
    EXPECT_NEAR(distance(4, 5), links.l4, kWritten_mm);
    // The thigh plate: K, M, P.
    EXPECT_NEAR(distance(6, 8), links.l3, kWritten_mm);
    EXPECT_NEAR(distance(7, 8), links.L7(), kWritten_mm);
    EXPECT_NEAR(distance(6, 7), std::hypot(links.l5, links.l3 + links.l6), kWritten_mm);
    for (const double radius : plates.hole_radii) EXPECT_DOUBLE_EQ(radius, 4);
  }
}

TEST(LinkPlates, OutlinesAreClosedAndSmooth) {
  const TemporaryFolder folder;
  drawing::WriteLinkPlates(folder / "design.dxf", kOptimum);
  const Reader plates = ReadBack(folder / "design.dxf");
  ASSERT_EQ(plates.edges.size(), 3 * 4 + 6u);  // a bar: two lines and two arcs
  for (const Edge& edge : plates.edges)
    for (const Vector2d& end : {edge.from, edge.to}) {
      const auto meets = [&](const Edge& other) {
        return std::min((other.from - end).norm(), (other.to - end).norm()) < kWritten_mm;
      };
      EXPECT_EQ(std::count_if(plates.edges.begin(), plates.edges.end(), meets), 2);
    }
  // An arc about a pin passes through the ends of the lines beside it: every end is half a width from its pin.
  for (const Edge& edge : plates.edges) {
    double nearest = HUGE_VAL;
    for (const Vector2d& hole : plates.holes) nearest = std::min(nearest, (hole - edge.from).norm());
    EXPECT_NEAR(nearest, 12, kWritten_mm);
  }
}

TEST(LinkPlates, AreLabelledAndDoNotOverlap) {
  const TemporaryFolder folder;
  drawing::WriteLinkPlates(folder / "design.dxf", kOptimum);
  const Reader plates = ReadBack(folder / "design.dxf");
  EXPECT_THAT(plates.labels, ::testing::ElementsAre("RS l1 = 59.081", "PR l2 = 68.840", "KS l4 = 71.849",
                                                    "KPM l3 = 55.964", "l5 = 118.630 l6 = 287.310"));
  // Plates lie one below the other: the lowest point of each above the highest of the next.
  for (int plate = 0; plate + 1 < 4; ++plate) {
    double lowest = HUGE_VAL, highest_below = -HUGE_VAL;
    const auto first = plates.edges.begin() + 4 * plate;
    for (auto edge = first; edge != first + 4; ++edge) lowest = std::min({lowest, edge->from.y(), edge->to.y()});
    const auto next_end = plate == 2 ? plates.edges.end() : first + 8;
    for (auto edge = first + 4; edge != next_end; ++edge)
      highest_below = std::max({highest_below, edge->from.y(), edge->to.y()});
    EXPECT_GT(lowest, highest_below + 10);
  }
}

TEST(LinkPlates, RefuseWhatCannotBeCut) {
  const TemporaryFolder folder;
  drawing::PlateOptions thin;
  thin.bar_width_mm = 6;
  EXPECT_THAT([&] { drawing::WriteLinkPlates(folder / "x.dxf", kOptimum, thin); },
              ThrowsMessage<Error>(HasSubstr("a pin of 8 mm does not fit")));
  EXPECT_THAT(
      [&] {
        drawing::WriteLinkPlates(folder / "x.dxf", {1, 2, 3, 4, 5, -6});
      },
      ThrowsMessage<Error>(HasSubstr("link l6 is -6")));
  EXPECT_THAT([&] { drawing::WriteLinkPlates("/no/such/folder/x.dxf", kOptimum); },
              ThrowsMessage<Error>(HasSubstr("/no/such/folder")));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.dxf"));
}

}  // namespace
}  // namespace lake
