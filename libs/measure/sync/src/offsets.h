// How well a movement is told at every offset: the coarse search. Not part of the interface.
#pragma once

#include <vector>

#include "pairing.h"

namespace lake::sync {

// Over offsets one step of y apart, to add to y's times. Where the overlap holds too little of the movement of either,
// nothing is told.
struct OffsetSearch {
  std::vector<double> offset_s;
  std::vector<double> unexplained;     // 1: nothing is told
  std::vector<double> log_likelihood;  // over that of unrelated movements
};

OffsetSearch SearchOffsets(const Pairing& pairing);

}  // namespace lake::sync
