// The mechanism as a model for a multibody simulator.
//
// Bodies: thigh plate (held still), shank link, coupler, slewing bar, actuator body and actuator rod. Plates have the
// mass and inertia of their shape with its holes, the actuator's body that of a solid cylinder, its rod of a steel one;
// pins and spacers have none. Lengths are in metres. The model's frame is at the knee pin: x anterior, z up the thigh,
// y along the pins, so that flexion is positive about y. Layers lie towards +y, outwards on a left leg.
#pragma once

#include <filesystem>

#include "lake/parts/mechanism.h"

namespace lake::model {

// The pose that the files hold: in the middle of the used strokes, far from both dead points.
linkage::Pose ReferencePose(const parts::Mechanism& mechanism);

// MuJoCo: joints `knee` (flexion, the true angle: 0 straight) and `stroke` (the true length, pin to pin), position
// servo `actuator` on the stroke, whose force is positive when it pushes. The two loops are closed by equality
// constraints, which in MuJoCo yield a little: stiff enough for a hundredth of a degree.
void WriteMjcf(const std::filesystem::path& path, const parts::Mechanism& mechanism);

// OpenSim 4: the thigh plate welded to ground, coordinates `knee` and `stroke` (the true angle, rad, and length, m);
// `thigh_pin`, `tip` and `mount` count from the reference pose. The loops are closed by point-on-line constraints. Here
// x is anterior, y up the thigh, z along the pins to the right; layers lie towards -z.
void WriteOsim(const std::filesystem::path& path, const parts::Mechanism& mechanism);

// URDF is a tree and cannot close a loop: the loops are cut at the shank pin and at the actuator's rod end, and the two
// places that must meet are links without mass, `coupler_end` with `shank_pin` and `rod_end` with `bar_tip`; comments
// say so. Joints `knee` and `stroke` count from the straight knee and from a length of 0.
void WriteUrdf(const std::filesystem::path& path, const parts::Mechanism& mechanism);

}  // namespace lake::model
