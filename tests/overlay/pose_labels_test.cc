// Labels of the linkage's poses, each in a picture of its own and as pages of the animation.
#include <gtest/gtest.h>

#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "lake/drawing/linkage_figures.h"
#include "lake/linkage/linkage.h"
#include "lake/linkage/wear.h"
#include "linkage_page.h"
#include "published_links.h"
#include "report/browser.h"
#include "temporary_folder.h"

namespace lake {
namespace {

constexpr linkage::Links kRedesign{59.894, 65.557, 50.000, 65.557, 58.513, 299.902};  // of the sample study
constexpr int kPoses = 25;                                                            // the animation's

enum class Drawn { kAlone, kInSeries };

// Poses from the shortest to the longest stroke.
class Poses {
 public:
  explicit Poses(const linkage::Links& links)
      : look_{.links = links,
              .range = linkage::FindUsedRange(links, kShortest_mm, {}),
              .body = person::BodyOf(1800, 80),
              .wear = {},
              .knee_torque_nm = 40} {}

  // The picture; `labels` as DrawLinkagePose has them.
  std::string Draw(int pose, drawing::LabelPlaces& labels) const {
    const TemporaryFolder folder;
    const double stroke_mm = kShortest_mm + look_.range.stroke.Travel() * pose / (kPoses - 1);
    drawing::DrawLinkagePose(folder / "pose.svg", look_, linkage::RequirePose(look_.links, stroke_mm), labels);
    return ReadTextFile(folder / "pose.svg");
  }

  // All in one page.
  std::string Page(Drawn drawn) const {
    std::string page = "<!DOCTYPE html><html><head>\n</head><body>";
    drawing::LabelPlaces labels;
    for (int pose = 0; pose < kPoses; ++pose) {
      if (drawn == Drawn::kAlone) labels.clear();
      page += Draw(pose, labels);
    }
    return page + "</body></html>";
  }

 private:
  static constexpr double kShortest_mm = 242;

  drawing::LinkageLook look_;
};

// In PNG and GIF letters are 4/3 as large as in the SVG, where a point is a px; a line of text has room above and below
// its letters, a fifth of its height. On a ground of its own a name is drawn twice, first for its ground. Grid, axes
// and the leg's edges may be behind a label.
constexpr const char* kFaults = R"(
  const behind = ['rgb(228, 228, 228)', 'rgb(102, 102, 102)', 'rgb(160, 127, 96)', 'rgb(246, 231, 218)'];
  const drawn = (part, kind) => {
    const colour = getComputedStyle(part)[kind];
    return colour.startsWith('rgb') && !behind.includes(colour);
  };
  const faults = [];
  let labels = 0;
  for (const svg of document.querySelectorAll('svg')) {
    const frame = svg.getBoundingClientRect(), 
          pose = [...svg.querySelectorAll('text')].find(text => text.textContent.includes('°')).textContent.slice(0, 9);
    const texts = [...svg.querySelectorAll('text')].filter(text => text.textContent.trim() && !text.closest('[style*=filter]'));
    const boxes = texts.map(text => text.getBoundingClientRect()).map(box => {
      const x = (box.left + box.right) / 2, y = (box.top + box.bottom) / 2, wide = box.width * 2 / 3, high = 0.8 * box.height * 2 / 3;
      return {left: x - wide, right: x + wide, top: y - high, bottom: y + high};
    });
    const lines = [...svg.querySelectorAll('path')].filter(part => !part.closest('defs') && drawn(part, 'stroke'));
    const plates = [...svg.querySelectorAll('polygon')].filter(part => drawn(part, 'fill'));
    texts.forEach((text, i) => {
      const a = boxes[i];
      if (a.left < frame.left || a.right > frame.right || a.top < frame.top || a.bottom > frame.bottom)
        faults.push(`${pose}: outside: ${text.textContent}`);
      boxes.forEach((b, j) => {
        if (i < j && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
          faults.push(`${pose}: ${text.textContent} over ${texts[j].textContent}`);
      });
      if (!/^([KPRSMθ]|[ld]\d? = .* mm)$/.test(text.textContent)) return;
      ++labels;
      const covers = part => {
        const box = part.getBoundingClientRect();
        if (box.left > a.right || box.right < a.left || box.top > a.bottom || box.bottom < a.top) return false;
        for (let x = a.left; x <= a.right; x += 2)
          for (let y = a.top; y <= a.bottom; y += 2) {
            const point = new DOMPoint(x, y).matrixTransform(part.getScreenCTM().inverse());
            if (part.tagName === 'path' ? part.isPointInStroke(point) : part.isPointInFill(point)) return true;
          }
        return false;
      };
      for (const part of [...lines, ...plates])
        if (covers(part)) faults.push(`${pose}: ${text.textContent} over a ${part.tagName} ${part.getAttribute('stroke') ?? part.getAttribute('fill')}`);
    });
  }
  return {labels, faults};)";

TEST(PoseLabels, CoverNeitherEachOtherNorLinksAndStayInThePicture) {
  LAKE_SKIP_WITHOUT_BROWSER();
  for (const linkage::Links& links : {kPublishedLinks, kRedesign})
    for (const Drawn drawn : {Drawn::kAlone, Drawn::kInSeries}) {
      const Json answer = Browser().Ask(Poses(links).Page(drawn), kFaults, 1400);
      EXPECT_GE(answer["labels"], 12 * kPoses);  // five letters, seven lengths; near 0° no θ
      EXPECT_EQ(answer["faults"], Json::array()) << "l6 = " << links.l6;
    }
}

// Where one has left its place, it would not have kept it beside the others as they are now.
TEST(PoseLabels, StayWhereTheyWereThroughTheAnimationWhileTheirPlaceIsFree) {
  for (const linkage::Links& links : {kPublishedLinks, kRedesign}) {
    const Poses poses(links);
    drawing::LabelPlaces before;
    int moves = 0;
    for (int pose = 0; pose < kPoses; ++pose) {
      drawing::LabelPlaces now = before;
      poses.Draw(pose, now);
      for (const auto& [name, place] : before) {
        if (now.at(name) == place) continue;
        ++moves;
        drawing::LabelPlaces stayed = now;
        stayed[name] = place;
        const drawing::LabelPlaces asked = stayed;
        poses.Draw(pose, stayed);
        EXPECT_NE(stayed, asked) << "pose " << pose << ": " << name << " left a place that is free";
      }
      before = now;
    }
    EXPECT_LE(moves, 57) << "l6 = " << links.l6;  // half of what pictures by themselves move: 115 and 112; here 39, 38
  }
}

}  // namespace
}  // namespace lake
