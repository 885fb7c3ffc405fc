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
#include "published_links.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct Vertex {
  Vector2d at;
  double bulge;  // of the edge that begins here: the tangent of a quarter of its turn, 0 straight
};

class Reader : public DL_CreationAdapter {
 public:
  void addPolyline(const DL_PolylineData& line) override {
    EXPECT_EQ(attributes.getLayer(), "OUTLINE");
    EXPECT_EQ(line.flags & 1, 1) << "an open outline";
    outlines.emplace_back();
  }
  void addVertex(const DL_VertexData& vertex) override {
    outlines.back().push_back({{vertex.x, vertex.y}, vertex.bulge});
  }
  void addLine(const DL_LineData&) override { ADD_FAILURE() << "a line outside an outline"; }
  void addArc(const DL_ArcData&) override { ADD_FAILURE() << "an arc outside an outline"; }
  void addCircle(const DL_CircleData& circle) override {
    EXPECT_EQ(attributes.getLayer(), "HOLES");
    (circle.radius == 2.75 ? cuff_holes : holes).emplace_back(circle.cx, circle.cy);
    hole_radii.push_back(circle.radius);
  }
  void addText(const DL_TextData& text) override {
    (attributes.getLayer() == "LABELS" ? labels : engravings).push_back(text.text);
    // As wide as its letters may be in any font, from its left end or about its middle.
    const Vector2d size(1.2 * text.height * static_cast<double>(text.text.size()), text.height), at(text.apx, text.apy);
    text_corners.push_back(text.hJustification == 0 ? at : at - size / 2);
    text_sizes.push_back(size);
    if (attributes.getLayer() != "LABELS") {
      EXPECT_EQ(attributes.getLayer(), "ENGRAVING");
      engraved_at.emplace_back(text.apx, text.apy);
    }
  }

  std::vector<std::vector<Vertex>> outlines;
  std::vector<Vector2d> holes, cuff_holes, engraved_at, text_corners, text_sizes;
  std::vector<double> hole_radii;
  std::vector<std::string> labels, engravings;
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
    const linkage::Links links = i == 0 ? kPublishedLinks : random.Next();
    drawing::WriteLinkPlates(folder / "design.dxf", links);
    const Reader plates = ReadBack(folder / "design.dxf");
    ASSERT_EQ(plates.holes.size(), 9u);
    const auto distance = [&](int a, int b) { return (plates.holes[a] - plates.holes[b]).norm(); };
    EXPECT_NEAR(distance(0, 1), links.l1, kWritten_mm);
    EXPECT_NEAR(distance(2, 3), links.l2, kWritten_mm);
    EXPECT_NEAR(distance(4, 5), links.l4, kWritten_mm);
    // The thigh plate: K, P, M.
    EXPECT_NEAR(distance(6, 7), links.l3, kWritten_mm);
    EXPECT_NEAR(distance(7, 8), links.L7(), kWritten_mm);
    EXPECT_NEAR(distance(6, 8), std::hypot(links.l5, links.l3 + links.l6), kWritten_mm);
    for (const double radius : plates.hole_radii) EXPECT_TRUE(radius == 2.75 || std::abs(radius - 4.05) < 1e-12);
  }
}

// The heading of an outline as it leaves a vertex, and as it reaches the next.
std::pair<double, double> HeadingsOf(const Vertex& from, const Vertex& to) {
  const Vector2d chord = to.at - from.at;
  const double heading = std::atan2(chord.y(), chord.x()), half_turn = 2 * std::atan(from.bulge);
  return {heading - half_turn, heading + half_turn};
}

TEST(LinkPlates, OutlinesAreClosedAndSmooth) {
  const TemporaryFolder folder;
  drawing::WriteLinkPlates(folder / "design.dxf", kPublishedLinks);
  const Reader plates = ReadBack(folder / "design.dxf");
  ASSERT_EQ(plates.outlines.size(), 4u);
  for (const std::vector<Vertex>& outline : plates.outlines) {
    double turn = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vertex &vertex = outline[i], &next = outline[(i + 1) % outline.size()];
      const Vertex& after = outline[(i + 2) % outline.size()];
      turn += 4 * std::atan(vertex.bulge);
      const double kink = HeadingsOf(vertex, next).second - HeadingsOf(next, after).first;
      EXPECT_NEAR(std::remainder(kink, 2 * M_PI), 0, 1e-9);
      // An arc about a pin passes through the ends of the lines beside it: every end is half a width from a pin, but
      // at the end of the shank link, which is about the outer cuff hole.
      double nearest = HUGE_VAL;
      for (const auto& ends : {plates.holes, plates.cuff_holes})
        for (const Vector2d& hole : ends) nearest = std::min(nearest, (hole - vertex.at).norm());
      EXPECT_NEAR(nearest, 12, kWritten_mm);
    }
    EXPECT_NEAR(turn, 2 * M_PI, 1e-9);  // once round, anticlockwise
  }
}

TEST(LinkPlates, AreLabelledEngravedAndDoNotOverlap) {
  const TemporaryFolder folder;
  drawing::WriteLinkPlates(folder / "design.dxf", kPublishedLinks);
  const Reader plates = ReadBack(folder / "design.dxf");
  EXPECT_THAT(plates.labels, ::testing::ElementsAre("RS l1 = 59.081", "PR l2 = 68.840", "KS l4 = 71.849",
                                                    "KPM l3 = 55.964", "l5 = 118.630 l6 = 287.310"));
  EXPECT_THAT(plates.engravings, ::testing::ElementsAre("RS 4 mm", "PR 4 mm", "KS 4 mm", "KPM 4 mm"));
  // Plates lie one below the other: the lowest point of each above the highest of the next. The round ends reach no
  // farther than half a width beyond the vertices, which are half a width from the pins.
  for (std::size_t plate = 0; plate + 1 < 4; ++plate) {
    double lowest = HUGE_VAL, highest_below = -HUGE_VAL;
    for (const Vertex& vertex : plates.outlines[plate]) lowest = std::min(lowest, vertex.at.y());
    for (const Vertex& vertex : plates.outlines[plate + 1]) highest_below = std::max(highest_below, vertex.at.y());
    EXPECT_GT(lowest, highest_below + 10);
    EXPECT_GT(plates.engraved_at[plate].y(), lowest);
  }
}

TEST(LinkPlates, NoTextLiesOverAHole) {
  testing::RandomLinks random;
  const TemporaryFolder folder;
  for (int i = 0; i < 20; ++i) {
    drawing::WriteLinkPlates(folder / "design.dxf", i == 0 ? kPublishedLinks : random.Next());
    const Reader plates = ReadBack(folder / "design.dxf");
    std::vector<Vector2d> holes = plates.holes;
    holes.insert(holes.end(), plates.cuff_holes.begin(), plates.cuff_holes.end());
    for (std::size_t text = 0; text < plates.text_corners.size(); ++text)
      for (const Vector2d& hole : holes) {
        const Vector2d &low = plates.text_corners[text], high = low + plates.text_sizes[text];
        const double away = (hole - hole.cwiseMax(low).cwiseMin(high)).norm();
        EXPECT_GT(away, 4.05) << "text " << text << " of design " << i;
      }
  }
}

// Two on the thigh plate between P and M, two on the shank link beyond S: one plate's width from the pin, and 30 mm on.
TEST(LinkPlates, HaveHolesForTheCuffs) {
  const TemporaryFolder folder;
  drawing::WriteLinkPlates(folder / "design.dxf", kPublishedLinks);
  const Reader plates = ReadBack(folder / "design.dxf");
  ASSERT_EQ(plates.cuff_holes.size(), 4u);
  const Vector2d shank_pin = plates.holes[5], thigh_pin = plates.holes[7], mount = plates.holes[8];
  EXPECT_NEAR((plates.cuff_holes[0] - shank_pin).norm(), 24, kWritten_mm);
  EXPECT_NEAR((plates.cuff_holes[1] - shank_pin).norm(), 54, kWritten_mm);
  const Vector2d along = (mount - thigh_pin).normalized();
  EXPECT_NEAR((plates.cuff_holes[2] - thigh_pin - 24 * along).norm(), 0, kWritten_mm);
  EXPECT_NEAR((plates.cuff_holes[3] - thigh_pin - 54 * along).norm(), 0, kWritten_mm);
}

TEST(LinkPlates, RefuseWhatCannotBeCut) {
  const TemporaryFolder folder;
  parts::PartOptions thin;
  thin.bar_width_mm = 6;
  EXPECT_THAT([&] { drawing::WriteLinkPlates(folder / "x.dxf", kPublishedLinks, thin); },
              ThrowsMessage<Error>(HasSubstr("a pin of 8 mm does not fit")));
  EXPECT_THAT(
      [&] {
        drawing::WriteLinkPlates(folder / "x.dxf", {1, 2, 3, 4, 5, -6});
      },
      ThrowsMessage<Error>(HasSubstr("link l6 is -6")));
  EXPECT_THAT([&] { drawing::WriteLinkPlates("/no/such/folder/x.dxf", kPublishedLinks); },
              ThrowsMessage<Error>(HasSubstr("/no/such/folder")));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.dxf"));
}

}  // namespace
}  // namespace lake
