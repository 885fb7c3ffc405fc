// Whether what was named ankle, knee, hip and waist is a person's leg, as a whole recording shows it. What single
// frames show is in plausibility.h.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lake/gait/leg_fit.h"
#include "lake/motion/leg_motion.h"

namespace lake::gait {

// Far from what trials of standing up, walking, squatting and jumping show, with markers of any usual placement.
struct PersonsLegLimits {
  double least_shank_mm = 100, most_shank_mm = 650;  // ankle to knee: 400 to 490 in our trials; 570 of 2.3 m of height
  double least_thigh_mm = 120, most_thigh_mm = 800;  // knee to hip; 200 to a marker on the thigh, 535 to the pelvis
  double least_ratio = 0.25, most_ratio = 2.2;       // of thigh to shank: 0.45 to 1.25
  double least_knee_deg = -45;                       // where a facing is given; hyperextension ends at −20
  double most_standing_knee_deg = 75;                // 5 to 25; a contracture 40
  double most_shank_deg = 60;                        // from the vertical, as a rise begins: −5 to 35
  double most_backward_deg = 30;                     // lean of the trunk there against standing: 14 to 40 forward
  double most_sideways_deg = 35, usual_sideways_deg = 25;  // bend where the knee is straight: 4 to 18; valgus 25
  double most_lean_deg = 120;                              // of each segment from the vertical, in most frames: 95
};

// The markers' places in the leg's axes (x anterior, y up, z lateral, 0 for a trial of two dimensions), NaN where not
// known; all four columns have a value per frame.
struct LegPath {
  motion::LengthUnit unit = motion::LengthUnit::kPx;
  motion::Facing facing = motion::Facing::kRight;
  bool is_facing_given = false;
  bool has_true_lengths = true;  // false: of three dimensions this is the projection, where lengths change
  std::array<std::string, 4> name = {"ankle", "knee", "hip", "waist"};
  std::array<std::vector<Eigen::Vector3d>, 4> marker;
  std::vector<std::int64_t> frame;
};

// Of a motion, about its ankle.
LegPath PathOf(const motion::LegMotion& motion);

// A segment whose length changes more than a limb's: in each frame an end of it is misplaced by about as much as its
// length is off the median beyond what is usual, and the segment's angle is off by that over the length.
struct UnusualLength {
  std::string warning;
  std::vector<double> angle_sigma_deg;  // by frame; 0 where the length is usual or not known
};
std::vector<UnusualLength> UnusualLengths(const LegPath& path, const LegFitOptions& options);

// Throws Error naming what no person's leg does, and the exchange of two markers that would make it right, if there is
// one: lengths, their ratio and how constant they are, hip and waist above what they stand on, a knee that bends
// backward, a marker of the other leg; with events also how shank and trunk lean as a rise begins, and the knee's
// angle in standing. Returns warnings of what is unusual.
std::vector<std::string> CheckPersonsLeg(const LegPath& path, const std::vector<motion::StsEvent>& events,
                                         const LegFitOptions& options, const PersonsLegLimits& limits = {});

}  // namespace lake::gait
