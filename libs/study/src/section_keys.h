// What a study gives itself, of the options of the program behind each of its sections.
#pragma once

#include <string_view>
#include <vector>

namespace lake::study {

using OptionNames = std::vector<std::string_view>;

inline const OptionNames kGivenToCalibration{"pictures"};
inline const OptionNames kGivenToPlane{"camera"};
inline const OptionNames kGivenToCompare{
    "human", "exo",          "map",        "up",        "forward",          "unit", "exo-map", "exo-unit", "camera",
    "scale", "plane-points", "exo-camera", "exo-scale", "exo-plane-points", "worn", "height",  "mass",     "seat-edge"};
inline const OptionNames kGivenToPopulation{"comparison", "human",  "human-knee",   "map",  "up",      "forward",
                                            "unit",       "worn",   "participants", "body", "balance", "device-mass",
                                            "hold-force", "pareto", "cuff-penalty", "knee", "segment", "exo-segment"};
inline const OptionNames kGivenToRedesign{"comparison", "human",       "human-knee", "map",          "up",
                                          "forward",    "unit",        "worn",       "participants", "body",
                                          "balance",    "device-mass", "hold-force", "across",       "quantile",
                                          "sizes",      "knee",        "segment",    "exo-segment"};
inline const OptionNames kGivenToLoads{"trial", "map", "up", "forward", "unit", "rate"};
inline const OptionNames kGivenToAssistance{"problem", "profile", "actuator"};
inline const OptionNames kGivenToStroke{"design", "motion", "validate", "tolerance"};
inline const OptionNames kGivenToSimulation{"thigh", "shank", "mount"};

}  // namespace lake::study
