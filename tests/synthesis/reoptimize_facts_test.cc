#include <fmt/format.h>
#include <fmt/ranges.h>

#include "lake/core/angles.h"
#include "lake/synthesis/reoptimize.h"
#include "synthesis/paper.h"
#include "synthesis/real_motion.h"

namespace lake {
namespace {

class RealMotion : public testing::Test {
 protected:
  void SetUp() override {
    const auto human = RealSitToStand();
    if (!human) GTEST_SKIP() << "the recording opencap_sts is not in " << LAKE_SHARED_DATA;
    problem_.human = *human;
    problem_.design.start = kPublished;
  }
  ReoptimizeProblem problem_;
};

TEST_F(RealMotion, Explore) {
  const auto& h = problem_.human;
  fmt::print("human {} .. {}\n", DegreesFromRadians(h.front().knee_rad), DegreesFromRadians(h.back().knee_rad));
  Design d;
  d.links = kPublished;
  auto strokes = ProgramStrokes(d, 0, h);
  auto p = Predict(kPublished, 242, 0, {0, 0}, *strokes, h);
  fmt::print("constant {} {}  T* {}\n", 100 * p->relative_rms, p->rms_mm, TrackingTime(*TrackingStrokes(kPublished, 242, 0, h), 5));
  const auto show = [&](const char* what, const ReoptimizeResult& r) {
    for (const auto& s : r.starts) { const auto lv = s.point.links.Values();
      fmt::print("{}: {} usable {} range {:.4f} mis {:.4f} it {} t {:.2f} knots0 {:.2f} links {:.2f} p {:.2f} {:.2f} T {:.2f} viol {} T* {:.2f}\n", what, s.local.solution.message, s.usable, s.Range_deg(),
                 s.Misalignment_percent(), s.local.iterations, s.local.seconds, s.point.knots_mm[0], fmt::join(lv, ","), s.point.placement_mm.x(), s.point.placement_mm.y(), s.point.duration_s, s.local.evaluation.violation, TrackingTime(TrackingStrokes(s.point.links,242,0,h).value_or(std::vector<double>(2,0.0)),5)); }
  };
  OptimizeOptions o;
  o.starts = 6;
  ReoptimizeProblem q = problem_;
  q.goal = ReoptimizeProblem::Goal::kMisalignment;
  show("links", Reoptimize(q, {kPublished}, o));
  q.fit_placement = true;
  show("links+p", Reoptimize(q, {kPublished}, o));
  q.goal = ReoptimizeProblem::Goal::kRange;
  show("range", Reoptimize(q, {kPublished}, o));
  o.starts = 10;
  q.goal = ReoptimizeProblem::Goal::kDuration; q.fit_placement = false;
  q.program.kind = StrokeProgram::Kind::kFree;
  q.max_misalignment_percent = 0.1;
  show("duration", Reoptimize(q, {kPublished}, o));
  q.program.kind = StrokeProgram::Kind::kConstant; q.fit_placement = true; q.max_misalignment_percent = {};
  for (const auto& p : ParetoFront(q, 8, {kPublished}, o)) { const auto lv = p.point.links.Values(); fmt::print("pareto {} {} {} {:.2f}\n", p.least_range_deg, p.range_deg, p.misalignment_percent, fmt::join(lv, ",")); }
  for (std::size_t i = 0; i < 6; ++i) q.design.bounds[i] = {kPublished.Values()[i], kPublished.Values()[i]};
  // placement alone
  q.goal = ReoptimizeProblem::Goal::kMisalignment;
  o.starts = 1;
  show("p", Reoptimize(q, {kPublished}, o));
  q.fit_placement = false;
  q.program.kind = StrokeProgram::Kind::kFree;
  for (double T : {25., 30., 45.}) {
    q.program.duration_s = T;
    show("free published", Reoptimize(q, {kPublished}, o));
  }
}

}  // namespace
}  // namespace lake
