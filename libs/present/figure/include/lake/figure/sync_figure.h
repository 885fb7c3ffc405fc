// The figure of lake-sync.
#pragma once

#include <filesystem>
#include <string>

#include "lake/sync/align.h"

namespace lake::figure {

// PNG or SVG by the extension. Above: a signal of one recording and its prediction from the other, on A's clock. Below:
// how likely each offset is, and how far parts of the overlap depart from the clock that was found, with their ± 2 SD.
// Of clocks aligned by a common signal, the departures alone. Throws Error if it cannot be drawn.
void DrawSync(const std::filesystem::path& path, const sync::Alignment& alignment, const std::string& title);

}  // namespace lake::figure
