// One leg with its share of head, arms and trunk: joint moments from the trunk down, or from the ground up.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "lake/core/options.h"
#include "lake/loads/anthropometry.h"
#include "lake/loads/inverse_dynamics.h"
#include "lake/loads/leg_path.h"

namespace lake::loads {

struct BodyOptions {
  double mass_kg = 0;                    // of the whole body
  std::optional<double> height_mm;       // stature; else from the leg's length
  std::optional<Sex> sex;                // which table of deleva
  std::string anthropometry = "winter";  // or deleva, or a file
  double share = 0.5;                    // of head, arms and trunk that this leg bears
  std::optional<std::array<double, 2>>
      foot_mm;  // how far heel and toe are behind and before the ankle; else from the stature

  // Throws Error for a mass or stature that nobody has (lake/core/plausible.h); UsageError for a mass that
  // is not given, a sex with a table that is of both, a share outside 0 to 1, a foot that does not lie under the ankle
  // or is not 0.1 to 0.5 m long.
  void Check() const;
};

void Describe(BodyOptions& o, OptionList& options);

struct SegmentInertia {
  double mass_kg = 0;
  double centre_m = 0;    // shank, thigh: from the upper end; trunk: from the hip; foot: in front of the ankle
  double gyration_m = 0;  // about the centre
};

struct LegBody {
  SegmentInertia foot, shank, thigh, trunk;  // trunk: this leg's share of its mass
  Foot sole;
  double ankle_height_m = 0;  // of the ankle marker above the ground
  double height_m = 0;        // the stature that was used
  std::string table, source;
};

// Lengths are the path's means. Throws as Check and FindAnthropometry do.
LegBody MakeLegBody(const BodyOptions& options, const LegPath& path);

// How far the trunk's centre of mass is from where the table has it, and that vector's second derivative; leg axes.
struct Displacement {
  Eigen::Vector2d value_m = Eigen::Vector2d::Zero(), acceleration_m_s2 = Eigen::Vector2d::Zero();
};

// Of `along` up the trunk and `across` forward of it, fixed in the trunk.
Displacement FixedInTrunk(const SegmentMotion& trunk, double along_m, double across_m);

// Extension (of the ankle: plantar flexion) positive.
struct JointMoments {
  double ankle_nm = 0, knee_nm = 0, hip_nm = 0;
};

struct LegLoads {
  JointMoments moments;
  Eigen::Vector2d ground_force_n = Eigen::Vector2d::Zero();  // on this foot
  double zmp_m = 0;  // where it acts on the ground, before the ankle (zero-moment point, centre of pressure)
};

// The ground bears the feet and nothing else bears the body.
LegLoads LoadsFromTrunk(const LegPoints& points, const LegBody& body, const Displacement& trunk);

// `ground`: what the ground does to this foot, about the origin of the leg's axes. The hip's moment is right only
// where no seat bears the thigh.
LegLoads LoadsFromGround(const LegPoints& points, const LegBody& body, const Wrench& ground);

// The trunk's body, and how the wrench about a point changes with a displacement of its centre (to first order).
Body TrunkBody(const LegPoints& points, const LegBody& body, const Displacement& displacement);
Wrench WrenchChange(const Body& trunk, const Displacement& change, const Eigen::Vector2d& about_m);

// Under the ankle, on the ground.
Eigen::Vector2d GroundPoint(const LegPoints& points, const LegBody& body);

}  // namespace lake::loads
