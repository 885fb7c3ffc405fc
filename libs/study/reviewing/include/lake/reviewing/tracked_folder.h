// A lake-track folder as it was made: its recording, its options, and what a person corrected in it since.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lake/commands/track.h"
#include "lake/core/json.h"
#include "lake/motion/corrections.h"
#include "lake/motion/event_corrections.h"
#include "lake/review/correction_book.h"
#include "lake/tracking/track_markers.h"

namespace lake::reviewing {

struct TrackedFolder {
  std::filesystem::path folder;
  commands::TrackRunOptions options;            // with the inputs where they are now
  tracking::TrackResult tracked;                // what the detector measured, before any correction
  std::vector<motion::Correction> made;         // corrections.csv in the folder
  std::vector<motion::EventCorrection> events;  // events_corrected.csv in the folder
  std::vector<motion::Correction> known;        // detector's samples of all that lake-review corrected in these tracks
  Json history;                                 // CorrectionBook's, of the last session; null: none
  std::map<std::string, std::string> kept;      // what lake-review's files in the folder last held
  std::vector<std::string> arguments;           // lake-track's, that apply corrections.csv; empty: a study tracks it
  std::string command;                          // the same for a person to type, or what to write into the study …
  std::string command_with_events;              // … with events_corrected.csv too
  std::vector<std::string> warnings;            // of the run that tracked it
};

// Throws Error: not such a folder, a file of it or its video is not to be found or has changed, or it was tracked with
// corrections that lake-review did not make. `given`: options of lake-track in the place of its own.
TrackedFolder ReadTrackedFolder(const std::filesystem::path& folder, const Json& given = Json::object());

// Writes corrections.csv, events_corrected.csv once an event was moved, and review.json, which keeps what they and
// those before them replaced, and the steps in which they were made. Throws Error (a full disk, a folder that cannot be
// written, files that somebody else changed since they were read); each file is either the new one or the old one then.
void SaveCorrections(TrackedFolder& folder, const review::CorrectionBook& book);

}  // namespace lake::reviewing
