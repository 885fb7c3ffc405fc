// What a trial's loads are worked out from: its rises, and everything that moments at a moment need. Not part of the
// interface.
#pragma once

#include <optional>
#include <vector>

#include "lake/loads/loads.h"
#include "lake/loads/trunk_fit.h"

namespace lake::loads {

// The events of one repetition; absent where the recording has none.
struct Rise {
  int repetition = 0;
  double onset_s = 0, seat_off_s = 0, standing_s = 0;
  std::optional<double> descent_s, seated_s;
  double onset_sd_s = 0, seat_off_sd_s = 0, standing_sd_s = 0;  // 0 where not known
};

// The time of a percent of it.
double TimeOf(const Rise& rise, int percent);

// Whether the feet alone bear the body at a time.
bool SeatIsLeft(const Rise& rise, double at_s, const LoadsOptions& options);

// The first frame that is not before a time.
std::size_t FrameFrom(const std::vector<double>& time_s, double at_s);

// Where a time is between two frames.
struct Between {
  std::size_t before = 0;
  double part = 0;
};

Between Locate(const std::vector<double>& time_s, double at_s);

// Everything that moments at a moment are worked out from; a draw has its own.
struct Model {
  LegPath path;
  LegBody body;
  std::optional<TrunkFit> trunk;              // without plates
  std::vector<std::optional<Wrench>> ground;  // with plates, per frame
};

}  // namespace lake::loads
