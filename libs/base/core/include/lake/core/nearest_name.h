// What a misspelt name was meant to be.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lake {

// "; did you mean 'detector'?": the known name that the fewest letters exchanged, added, left out or swapped make of
// `name` (optimal string alignment), up to a third of its letters; empty where none is so near.
std::string DidYouMean(std::string_view name, const std::vector<std::string>& known);

}  // namespace lake
