// JSON at the boundary: order of keys kept, files read with their place in the error and written atomically.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace lake {

using Json = nlohmann::ordered_json;

// Throws Error naming the file and the place.
Json ReadJsonFile(const std::filesystem::path& path);

// NaN and infinities become null.
void WriteJsonFile(const std::filesystem::path& path, const Json& value);

// Of a value that may not be defined: null is NaN. Throws if it is anything else but a number.
double NumberOrNaN(const Json& value);
std::vector<double> NumbersOrNaN(const Json& values);

}  // namespace lake
