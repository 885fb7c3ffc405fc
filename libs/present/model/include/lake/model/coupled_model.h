// The mechanism on a person's leg, as a model for MuJoCo: foot, shank, thigh and trunk with their masses, the
// exoskeleton beside them, held by cuffs that yield, and both driven through a rise.
//
// The sagittal plane: world frame at the ankle, x anterior, z up, y to the left. Joints, all in degrees as the file
// says them: `ankle` (lean of the shank, forward positive), `human_knee` (flexion), `hip` (lean of the trunk less that
// of the thigh), each with a position servo that stands for the person, who moves as the motion says; `stroke` with the
// servo `actuator`, which follows the program. Each cuff is a pad without size on its segment, joints `thigh_cuff_1_x`,
// `_z` and `_turn` with the cuff's stiffness, welded to the exoskeleton's link: force = stiffness x joint position, on
// the segment. Free of stress at standing, as in cuffs/cuff_course.h. Keyframes `0_percent` … `100_percent` hold time
// and controls of the rise, as the table of WriteCourse does.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "lake/cuffs/cuff_model.h"
#include "lake/loads/body_path.h"
#include "lake/parts/mechanism.h"

namespace lake::model {

// One moment of the rise. Lean from the vertical, forward positive.
struct WornSample {
  double time_s = 0;
  double shank_deg = 0, knee_deg = 0, trunk_deg = 0;
  double stroke_mm = 0;
};

struct Subject {
  loads::BodyPath body;
  double shank_mm = 0, thigh_mm = 0;
  Eigen::Vector2d hinge_mm = Eigen::Vector2d::Zero();  // against the knee at standing: shank's frame
  cuffs::CuffOptions cuffs;                            // of the stiffness the geometric mean
  std::vector<WornSample> rise;                        // standing last
};

// Throws UsageError for cuffs that LoadOnLeg refuses.
void WriteCoupledMjcf(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject);

// OpenSim 4: the same person, mechanism and cuffs, ground's frame at the ankle with x anterior, y up, z to the right.
// Coordinates `ankle`, `human_knee`, `hip` and `stroke` with the signs above, in rad and m, prescribed over the rise;
// `knee`, `thigh_pin`, `tip` and `mount` follow them through the loops, which constraints close; `exo_turn`, `exo_x`
// and `exo_y` (the thigh plate in ground: anticlockwise seen from the right, and its hinge) are free, held by the
// cuffs' bushings, whose first frame is on the segment. A CoordinateActuator on each prescribed coordinate is for tools
// that take the prescription off. Throws UsageError for cuffs that LoadOnLeg refuses.
void WriteCoupledOsim(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject);

// All those coordinates over the rise (MOT: degrees, m), the exoskeleton where its cuffs let it rest, without weight.
// Throws Error where the mechanism cannot be assembled at a stroke of the rise.
void WriteOsimMotion(const std::filesystem::path& path, const parts::Mechanism& mechanism, const Subject& subject);

// time_s, then the controls: ankle_deg, human_knee_deg, hip_deg, stroke_mm.
void WriteCourse(const std::filesystem::path& path, const Subject& subject);

}  // namespace lake::model
