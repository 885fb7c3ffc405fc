// A study.yaml to be filled in.
#pragma once

#include <string>

namespace lake::study {

// Every key of every section, with its default and what it means. What may be left out stands behind a '#'; the rest is
// a study of human.mp4, exo.mp4 and camera.yaml beside the file.
std::string StudyTemplate();

}  // namespace lake::study
