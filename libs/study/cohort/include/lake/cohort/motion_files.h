// The trials of a study as files of BIDS' Motion extension.
#pragma once

#include <filesystem>
#include <string>

namespace lake::cohort {

// The entities of BIDS file names.
struct MotionNames {
  std::string person;  // sub-01, or sub-01_ses-1
  std::string run;     // run-1, or empty
  std::string task;
};

// Of the trials of the study in `study`, into the folder `motion`: …_motion.tsv (no header, n/a where there is no
// value), …_channels.tsv, …_channels.json (reference frames), …_motion.json, …_events.tsv. Channels: time (LATENCY, s),
// the knee angle (JNTANG, degrees), and the markers' estimated positions (POS, mm in the plane frame; px in the image
// frame where there is no scale). The names have the order of BIDS' entities: acq is the trial. What was there of the
// same recordings is removed first.
void WriteMotionFiles(const std::filesystem::path& study, const MotionNames& names,
                      const std::filesystem::path& motion);

// Whether these files are there, of every trial of the study.
bool HasMotionFiles(const std::filesystem::path& study, const MotionNames& names, const std::filesystem::path& motion);

}  // namespace lake::cohort
