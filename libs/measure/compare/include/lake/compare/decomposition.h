// What a misalignment is made of: placement, timing, shape (the room's README has the method).
//
//   min over p, w:  Σ |e(s) − h(w(s)) − F(w(s)) p|² + λ Σ (Δ² w_k)²,   F = axes of the human's shank,
//   w piecewise linear over 9 knots w_0..w_8, slope ≥ 0.05, clamped to 0..100.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "lake/compare/registration.h"

namespace lake::compare {

struct DecompositionOptions {
  // mm² per percent²: a bend of 1 % between knots costs as much as a residual of 0.3 mm, about what a good recording
  // leaves.
  double roughness_weight = 0.1;
  double least_slope = 0.05;
  int max_iterations = 100;
  double tolerance = 1e-10;  // of the cost, relative
};

struct Decomposition {
  static constexpr int kKnots = 9;  // at 0, 12.5, … 100 %

  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();  // p: shank frame, x anterior, y from ankle to knee
  std::array<double, kKnots> knots_percent{};           // w at the knots
  std::vector<double> timing_percent;                   // w(s) − s: positive where the exoskeleton is ahead
  std::vector<Eigen::Vector2d> placement_mm, timing_mm, shape_mm;  // leg frame; they sum to e − h
  // Σ x·D / Σ |D|²; sum to 1, small negative values are possible. NaN where both paths are one.
  double placement = 0, timing = 0, shape = 0;

  bool converged = false;
  int iterations = 0;
  double cost = 0;         // mm², with the roughness
  const char* start = "";  // the start that led to the least cost: placement, timing, zero
};

// A part of the path difference; Decompose fills its vectors and its fraction. Files, tables, charts and pages go
// through the list.
struct Part {
  const char* name;
  const char* meaning;  // a clause
  double Decomposition::*fraction;
  std::vector<Eigen::Vector2d> Decomposition::*vectors_mm;
};
inline constexpr std::array kParts = {
    Part{"placement", "an offset constant in the frame of the shank, which moving the joint removes",
         &Decomposition::placement, &Decomposition::placement_mm},
    Part{"timing", "a change of pace within the repetition, which a program of the actuator removes",
         &Decomposition::timing, &Decomposition::timing_mm},
    Part{"shape", "the rest, noise included", &Decomposition::shape, &Decomposition::shape_mm}};

// "placement, timing and shape"
std::string PartNames();

Decomposition Decompose(const StsCurve& human, const StsCurve& exo, const DecompositionOptions& options = {});

}  // namespace lake::compare
