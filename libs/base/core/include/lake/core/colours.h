// The colours of all pictures and pages.
#pragma once

namespace lake {

// Colours that the colour-blind can distinguish (Okabe & Ito 2008), the same for one quantity in all figures.
namespace colour {
inline constexpr const char* kHuman = "#C17F00";  // yellow-orange, as in the paper, but dark enough for lines on white
inline constexpr const char* kExoskeleton = "#CC79A7";  // purple: far from the human's and from blue
inline constexpr const char* kWorn = kExoskeleton;      // the exoskeleton of the trial
inline constexpr const char* kNew = "#0072B2";          // the design that is proposed
inline constexpr const char* kAnkle = "#0072B2";
inline constexpr const char* kKnee = "#C17F00";
inline constexpr const char* kHip = "#009E73";
inline constexpr const char* kWaist = "#D55E00";
inline constexpr const char* kOther = "#2E8BC0";
inline constexpr const char* kFronts[] = {"#555555", kHip, kWaist};  // Pareto fronts of the stroke programs
inline constexpr const char* kGap = "#DDDDDD";
inline constexpr const char* kGrid = "#E4E4E4";
inline constexpr const char* kGuide = "#767676";  // thin lines to read by: no paler, or they are not seen
inline constexpr const char* kText = "#222222";
}  // namespace colour

}  // namespace lake
