// Points that come from other processes, as JSON, whose numbers read back as the same double.
#pragma once

#include <nlohmann/json.hpp>

#include "lake/redesign/reoptimize_problem.h"

namespace lake::redesign {

nlohmann::json JsonOf(const ReoptimizePoint& point);
ReoptimizePoint PointOf(const nlohmann::json& json);

}  // namespace lake::redesign
