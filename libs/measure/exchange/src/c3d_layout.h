// What the header and the parameters of a C3D file say of its data. Not part of the interface.
#pragma once

#include <string>
#include <vector>

#include "c3d_bytes.h"

namespace lake::exchange {

// What the header and the parameters say about the points.
struct C3dLayout {
  std::size_t points = 0, frames = 0, first_frame = 0;
  std::size_t analog_per_frame = 0;  // samples of all channels
  std::size_t data_offset = 0;       // bytes
  double scale = -1;                 // < 0: floats
  double rate_hz = 0;
  double mm_per_unit = 1;
  char up_axis = 'z';
  std::vector<std::string> labels;  // of the points
  std::vector<std::string> warnings;

  bool IsFloat() const { return scale < 0; }
  std::size_t WordBytes() const { return IsFloat() ? 4 : 2; }
  std::size_t FrameBytes() const { return WordBytes() * (4 * points + analog_per_frame); }
};

// A 16-bit word that was read with a sign, where it has none.
inline double Unsigned(double word) {
  return word < 0 ? word + 65536 : word;
}

// The file states its sizes in its header and in its parameters. Where these differ, those hold with which the frames
// end in the file's last block; among several of them what most places state. Of a file that is cut off the frames that
// are there. Throws Error where that does not decide, and for a file that holds neither points nor analogue channels.
C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters);

}  // namespace lake::exchange
