// The markers of a leg in the files of one optical laboratory (../shared/data: sts_force_plates, real_motions, …).
#pragma once

namespace lake {

inline constexpr const char* kRightLeg = "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS";
inline constexpr const char* kLeftLeg = "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS";

}  // namespace lake
