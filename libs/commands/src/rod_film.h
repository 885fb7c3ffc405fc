// The actuator's length in a tracked video.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/actuator/duty_video.h"

namespace lake::commands {

// The distance of two markers, on the actuator's body and on its rod, in the frames that show both, mm. Throws Error
// naming the file: no trajectory in mm, no such marker.
actuator::ActuatorFilm ReadRodFilm(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace lake::commands
