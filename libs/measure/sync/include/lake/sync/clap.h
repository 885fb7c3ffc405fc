// Claps in a film's sound: when they begin.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "lake/sync/align.h"
#include "lake/video/sound.h"

namespace lake::sync {

struct Clap {
  double time_s = 0;  // on the clock of the film's frames, when its sound reached the microphone
  double sd_s = 0;    // of its rise
};

// Goes through a sound from its beginning, each time that it is called.
using SoundReading = std::function<video::Sound(const video::TakeSamples& take)>;

// Sounds that rise by 20 dB within 3 ms above 1.5 kHz, have fallen by 10 dB after 0.1 s, and of which everything else
// stays 10 dB below; those within 10 dB of the loudest, in order. The sound is read twice: for its power, of which 16
// kB a second are kept, and for the samples around each clap. Throws Error, saying why, where there is none.
std::vector<Clap> FindClaps(const SoundReading& read, const std::filesystem::path& film);

struct ClapOptions {
  // From the clap to the film's microphone, mm. Not known: anything up to 5 m is as likely.
  std::optional<double> distance_mm = {};
};

// The film's claps as a signal on the clock of its frames, the sound's way taken off. Throws Error as FindClaps.
Signal SignalOfClaps(const std::filesystem::path& film, const ClapOptions& options = {});

}  // namespace lake::sync
