// Pictures of the linkage: poses in the paper's manner, curves over the stroke, the labelled drawing, the mannequin.
// Files are PNG or SVG by their extension.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/linkage/linkage.h"
#include "lake/linkage/wear.h"

namespace lake::drawing {

// Common to all pictures of one design.
struct LinkageLook {
  linkage::Links links;
  linkage::UsedRange range;
  person::Body body;
  linkage::WearOptions wear;
  double knee_torque_nm = 40;
};

// The paper's graphical simulation: the linkage on axes in mm with its dimensions, cylinder red, piston black, the leg
// behind; beside it the four-bar enlarged.
void DrawLinkagePose(const std::filesystem::path& path, const LinkageLook& look, const linkage::Pose& pose);

// Knee angle, moment arm with force, and transmission angles over the used range; `marked` strokes, ascending, are
// marked.
void DrawAngleVsStroke(const std::filesystem::path& path, const LinkageLook& look,
                       const std::vector<double>& marked_mm);

// The drawing that defines the symbols: joints, l1..l8, d, alpha, beta, theta in the thigh frame.
void DrawLinkageSchematic(const std::filesystem::path& path, const linkage::Links& links, const linkage::Pose& pose);

// The design on a body, standing and seated, with the clearances.
void DrawMannequin(const std::filesystem::path& path, const LinkageLook& look, const linkage::WearCheck& check);

}  // namespace lake::drawing
