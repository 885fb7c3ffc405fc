// ArUco markers that are followed. Not part of the interface.
#pragma once

#include <memory>
#include <string>

#include "lake/tracking/marker_detector.h"

namespace lake::tracking {

// As the public one. While the first `markers` ids are all followed, they are looked for where they are expected, and
// the whole picture is searched when that is asked for or one is not there; 0: always the whole picture.
std::unique_ptr<MarkerDetector> MakeArucoDetector(const std::string& dictionary, const DetectorRegion& region,
                                                  int markers);

}  // namespace lake::tracking
