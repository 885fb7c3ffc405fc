// design.yaml: a linkage with the strokes it is driven through, how it is placed on the leg, and how it is driven.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/linkage/linkage.h"

namespace lake::linkage {

// How the actuator is driven over one sit-to-stand.
struct StrokeProgram {
  struct Knot {
    double time_s = 0, stroke_mm = 0;
  };
  enum class Kind { kConstant, kFree } kind = Kind::kConstant;
  double speed_mm_s = 5;    // constant: the paper's open loop at one speed
  std::vector<Knot> knots;  // free: piecewise linear between knots, times ascending
};

// Linear between the knots, of which there are at least two; before and after them as at their ends.
double StrokeAt(const std::vector<StrokeProgram::Knot>& knots, double time_s);

struct Design {
  Links links;
  double d_min_mm = 242;                     // shortest stroke (Jain et al.'s actuator, as in the paper)
  std::optional<double> d_max_mm;            // longest stroke; absent: the stroke that stands straight
  std::optional<double> range_deg;           // theta at d_min, as its maker computed it
  std::array<double, 2> placement_mm{0, 0};  // exo knee against human knee, shank frame: x anterior, y up the shank
  Mount mount = Mount::kBeside;
  std::optional<StrokeProgram> program;
  // What it was designed for, where that differs from the paper: texts by the keys of the options of lake-simulate and
  // lake-export, which take them from here. Paths are relative to the file.
  Json parts = Json::object(), body = Json::object(), load = Json::object();
  std::string made_by;
};

// Throws Error with file and line: not YAML, an unknown or missing key, a length that is not positive, d_max <= d_min,
// a program whose times do not ascend.
Design ReadDesign(const std::filesystem::path& path);

// Numbers read back as the same double.
void WriteDesign(const std::filesystem::path& path, const Design& design);

}  // namespace lake::linkage
