// The keys of camera.yaml, each described once: for the template that a person fills in who has the lens from
// elsewhere.
#pragma once

#include <span>
#include <string>

namespace lake::camera {

struct CameraKey {
  const char* name;
  const char* value;    // an example, as OpenCV's FileStorage has it in YAML
  const char* meaning;  // with its unit
  bool is_needed = false;
};

// In the file's order: all that ReadCameraProfile knows.
std::span<const CameraKey> CameraKeys();

// A camera.yaml with every key and what it means, those that may be absent as comments. ReadCameraProfile takes it as
// it is: a camera of 1280 × 720 px without distortion and without a plane.
std::string CameraTemplate();

}  // namespace lake::camera
