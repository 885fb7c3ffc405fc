// The film that a recording's frames were chosen from, each the one that was shown last at its time. Not part of the
// interface.
#pragma once

#include <functional>
#include <vector>

namespace lake::tracking {

// With so many frames for each of the recording, frame floor(ratio · i + phase) of the film is shown in frame i.
struct Film {
  double rate_hz = 0, ratio = 1;
  double phase = 0.5;
  double log_odds = 0;  // of its rate among others

  double Source(double i) const;
  bool Repeats(double i) const { return i > 0 && Source(i) == Source(i - 1); }
};

// Films of the rates at which films are made, and those of which m in every n frames are shown (odds 1/n²), up to a
// ratio of 1. `shown_hz`: the recording's.
std::vector<Film> SlowerFilms(double shown_hz);
// Films of those rates whose frames are shown unevenly, some not at all.
std::vector<Film> FasterFilms(double shown_hz);

// Sets the phase to the middle of those at which this logarithm is largest, of so many and then between them; returns
// it.
double FindPhase(const std::function<double(const Film&)>& log_likelihood, int phases, Film& film);

}  // namespace lake::tracking
