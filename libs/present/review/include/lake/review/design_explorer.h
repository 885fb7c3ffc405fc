// A design while a person changes its links: what it does in every pose and which requirements it fails, by the closed
// form of lake::linkage and the limits of lake::problem.
//
// Places are in the picture of the leg: mm, origin at the knee, x anterior, y up; the shank hangs upright from the
// knee.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/linkage/design_file.h"
#include "lake/problem/problem.h"

namespace lake::review {

// What links do in the motion of a person that a design was made for, at the knee angles of the design's own stroke
// program, as far as they reach these.
struct InMotion {
  double misalignment_percent = 0;  // RMS, of the shank length
  double rise_s = 0;                // the shortest
};

struct ExploredDesign {
  std::string name;                   // for the page
  linkage::Design design;             // as it was saved
  problem::SynthesisProblem problem;  // its limits; `d_min_mm` is where the strokes begin. Clearances are at the
                                      // design's placement
  std::string limits;                 // where they are from, one phrase
  std::vector<std::string> notes;     // what a reader must know
  // Absent: no motion is known. Gives nothing for links that cannot be assembled.
  std::function<std::optional<InMotion>(const linkage::Links&)> in_motion{};
  std::optional<double> max_misalignment_percent{}, max_rise_s{};  // that the design was made for
};

// Keeps nothing of what it was asked before, so that several windows may ask.
class DesignExplorer {
 public:
  explicit DesignExplorer(ExploredDesign explored);

  // DesignMessage in page/messages.ts.
  Json About() const;

  // {links: l1..l6 in mm; drag: {pin, x, y, stroke}, a pin that is dragged to a place, if any; builds: whether the
  // requirements are those of the worst build within the problem's tolerance, 128 times as much work, else of the
  // links as they are}. The other pins stay where they are at that stroke, and those on thigh and shank stay on their
  // axes. The answer has the links then; ExploredMessage there. Throws Error for what are no links, or where the
  // linkage would fold over.
  Json Explore(const Json& question) const;

  // The design with these links, to be saved: its strokes begin at the problem's d_min and end where the knee stands. A
  // stroke program with knots, which are of other links, is left out. Throws Error where it cannot be assembled.
  linkage::Design With(const linkage::Links& links) const;

 private:
  Json CurvesJson(const linkage::Links& links) const;
  Json ChecksJson(const linkage::Links& links, bool of_builds) const;

  ExploredDesign explored_;
};

// l1..l6 from a list of numbers. Throws Error for others.
linkage::Links LinksFrom(const Json& json);

}  // namespace lake::review
