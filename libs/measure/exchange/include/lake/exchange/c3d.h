// C3D, the binary format of motion laboratories (c3d.org, The C3D File Format, user guide): its points and events.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/exchange/formats.h"
#include "lake/exchange/ground_forces.h"
#include "lake/motion/leg_motion.h"

namespace lake::exchange {

// Integer and float files of Intel, DEC and MIPS processors; more than 65 535 frames through TRIAL:ACTUAL_*_FIELD or a
// float POINT:FRAMES; more than 255 points, channels or events through LABELS2, TIMES2, … Analogue channels are
// skipped: ReadC3dForces has them. Events are those of the group EVENT and of the header; where they are damaged, a
// warning says so instead. Up is POINT:Y_SCREEN if it is there, else z. Throws Error naming file and what is wrong: not
// C3D, a parameter that is absent or contradicts the file's size.
PointRecording ReadC3d(const std::filesystem::path& path, const ReadOptions& options = {});

// The force plates of such a file; ReadGroundForces (ground_forces.h) says which. Throws Error.
GroundForceRecording ReadC3dForces(const std::filesystem::path& path);

// Whether the file holds no points, only analogue channels. Throws Error.
bool IsC3dWithoutPoints(const std::filesystem::path& path);

// Intel, float, of points in mm. C3D has a frame rate instead of time stamps: throws Error where these are uneven by
// more than 5 % of a step, and for more names and events than 127 kB hold (some 5000 events).
void WriteC3d(const std::filesystem::path& path, const PointRecording& points);

// As other programs name them: of a walk "Foot Strike" and "Foot Off" in the context "Left" or "Right", else "General".
std::vector<PointEvent> PointEvents(const std::vector<motion::StsEvent>& events, motion::Side leg);

// Checks times as WriteC3d does, before the points exist. Throws Error.
void CheckC3dTimes(const std::filesystem::path& path, const std::vector<double>& time_s);

}  // namespace lake::exchange
