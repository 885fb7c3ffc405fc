// What was found in a video, numbered, for the person who is to say which is which.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lake/core/error.h"
#include "lake/tracking/tracklet.h"

namespace lake::tracking {

struct Candidate {
  int id = 0;                                          // from 1
  std::int64_t frame = 0;                              // the list's, or the nearest to it in which this was seen
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px, in that frame
  double radius_px = 0;
  std::int64_t first_frame = 0, last_frame = 0;
  bool moves = false;
  std::vector<Eigen::Vector2d> path;  // px
};

struct CandidateList {
  std::int64_t frame = 0;  // the one that shows most of what moves
  std::vector<Candidate> candidates;
};

// At most 99 of the objects that were followed for 12 frames or more: what moves comes first, then what was seen
// longest. The same tracklets get the same numbers.
CandidateList ListCandidates(const std::vector<Tracklet>& tracklets);

// How far a tracklet's positions reach, px: the diagonal of the box that holds all but 2 % at either end.
double TrimmedExtentPx(const Tracklet& tracklet);

// The markers could not be named: a person must say which is which.
class NamingError : public Error {
 public:
  NamingError(const std::string& message, CandidateList list) : Error(message), list_(std::move(list)) {}

  const CandidateList& List() const { return list_; }

 private:
  CandidateList list_;
};

}  // namespace lake::tracking
