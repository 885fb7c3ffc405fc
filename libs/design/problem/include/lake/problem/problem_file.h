// problem.yaml: a synthesis problem; absent keys have the paper's values.
//
//   d_min_mm, d_max_mm, standing_deg, min_moment_arm_mm, min_transmission_deg, max_angle_deg, robust_mm: numbers
//   bounds: {l1: [50, 100], ...}     start: {l1: 85, ...}
//   margins: {grashof_mm, singularity_mm}     actuator: NAME or FILE (linear_actuator.h)
//   load: {knee_torque_nm, max_force_n, max_pin_force_n, max_mount_force_n, safety_factor, profile: loads.json, assist,
//   rest: anywhere|standing, duration_s: number or free} clearances: {seat_mm, limb_mm}: least distances on the body
//   parts: {plate: "4mm,6061-T6", pin_diameter_mm, rod_diameter_mm, …}: as the options of lake-simulate
//   body: {height_mm, mass_kg, thigh_mm, shank_mm, seat_edge_mm}     mount: beside|behind, which limb_mm is for
// Paths are relative to the file. The keys are those of SectionsOf (problem_options.h).
#pragma once

#include <filesystem>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/core/yaml.h"
#include "lake/linkage/design_file.h"
#include "lake/problem/evaluate.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// Throws Error with file and line: unknown keys, values of another type, what SynthesisProblem::Check() refuses.
SynthesisProblem ReadProblem(const std::filesystem::path& path);

// The maps `clearances` and `body` of a map, if it has them. Throws as above.
void ReadClearances(YamlNode& node, SynthesisProblem& problem);

// As above, from a map inside a file in this folder.
SynthesisProblem ReadProblem(YamlNode node, const std::filesystem::path& folder);

// The files that its load comes from, where there are any: "profile", and the "actuator"'s table.
std::vector<InputFile> LoadFiles(const SynthesisProblem& problem);

// Every key that ReadProblem takes, all but the first behind a '#': the paper's values and those of an example.
std::string ProblemTemplate();

// Every value of a problem, units as in the struct, but not the places of its files: problems whose JSON is equal have
// the same designs.
Json ProblemJson(const SynthesisProblem& problem);

// What design.yaml carries of the problem that a design was found for.

// These links at the problem's shortest stroke and mount.
linkage::Design DesignOf(const SynthesisProblem& problem, const linkage::Links& links);

// Range and longest stroke, as evaluated.
void TakeRange(const DesignEvaluation& evaluation, linkage::Design& design);

// Parts, body and load, where they differ from the paper's. `folder` is that of the design's file.
void TakeProblem(const SynthesisProblem& problem, const std::filesystem::path& folder, linkage::Design& design);

// Sets options to the texts that a design's file has under their keys (its parts, body or load). None is set where a
// file that one names is not there: returns that file. Throws Error with the design's file.
std::filesystem::path TakeFromDesign(const Json& texts, const std::filesystem::path& file, OptionList options);

}  // namespace lake::problem
