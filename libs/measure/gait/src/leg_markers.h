// The markers and the segments of the leg. Not part of the interface.
#pragma once

#include <array>
#include <cstdint>

namespace lake::gait {

enum LegMarker : std::uint8_t { kAnkle, kKnee, kHip, kWaist };
inline constexpr int kLegMarkers = 4;

struct LegSegment {
  const char* name;  // of its vector
  LegMarker lower, upper;
};
enum LegSegmentIndex : std::uint8_t { kShank, kThigh, kTrunk };
inline constexpr std::array<LegSegment, 3> kLegSegments = {
    {{"ak", kAnkle, kKnee}, {"kh", kKnee, kHip}, {"hw", kHip, kWaist}}};

}  // namespace lake::gait
