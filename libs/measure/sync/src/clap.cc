#include "lake/sync/clap.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>

#include "lake/core/error.h"

namespace lake::sync {

namespace {

constexpr double kBin_s = 0.0005;   // of which the rise is told
constexpr double kSilence = 1e-10;  // −100 dB of full scale: the last bit of 16
constexpr std::size_t kMostClaps = 20;

double Db(double power_ratio) {
  return 10 * std::log10(power_ratio);
}

// Butterworth's of the second order: what speech has least of. Its delay is below 0.2 ms.
class HighPass {
 public:
  explicit HighPass(double rate_hz) {
    const double corner_hz = std::min(1500.0, 0.2 * rate_hz);
    const double k = std::tan(std::numbers::pi * corner_hz / rate_hz);
    norm_ = 1 / (1 + k * std::numbers::sqrt2 + k * k);
    a1_ = 2 * (k * k - 1) * norm_;
    a2_ = (1 - k * std::numbers::sqrt2 + k * k) * norm_;
  }

  float Next(double x) {
    const double y = norm_ * (x - 2 * x1_ + x2_) - a1_ * y1_ - a2_ * y2_;
    x2_ = x1_;
    x1_ = x;
    y2_ = y1_;
    y1_ = y;
    return static_cast<float>(y);
  }

 private:
  double norm_ = 0, a1_ = 0, a2_ = 0, x1_ = 0, x2_ = 0, y1_ = 0, y2_ = 0;
};

// The sound's power over time, in bins.
class Power {
 public:
  explicit Power(double rate_hz)
      : per_bin_(std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(kBin_s * rate_hz)))),
        bin_s_(static_cast<double>(per_bin_) / rate_hz) {}

  // The next sample; what does not fill a bin at the end counts nowhere.
  void Add(float sample) {
    sum_ += sample * sample;
    if (++in_bin_ < per_bin_) return;
    sums_.push_back(sums_.back() + sum_);
    sum_ = 0;
    in_bin_ = 0;
  }

  std::ptrdiff_t Bins() const { return std::ssize(sums_) - 1; }
  std::ptrdiff_t BinsIn(double time_s) const { return std::max<std::ptrdiff_t>(1, std::llround(time_s / bin_s_)); }
  std::size_t FirstSample(std::ptrdiff_t bin) const { return static_cast<std::size_t>(bin) * per_bin_; }

  // The mean from one bin to before the other, as far as there are any; kSilence at least.
  double Mean(std::ptrdiff_t from, std::ptrdiff_t to) const {
    from = std::clamp<std::ptrdiff_t>(from, 0, Bins());
    to = std::clamp<std::ptrdiff_t>(to, 0, Bins());
    if (to <= from) return kSilence;
    const double sum = sums_[static_cast<std::size_t>(to)] - sums_[static_cast<std::size_t>(from)];
    return std::max(kSilence, sum / static_cast<double>((to - from) * static_cast<std::ptrdiff_t>(per_bin_)));
  }

 private:
  std::size_t per_bin_, in_bin_ = 0;
  double bin_s_, sum_ = 0;
  std::vector<double> sums_ = {0};
};

struct Onset {
  std::ptrdiff_t bin = 0;  // the first that is loud
  double loudness = 0;     // the mean power of its first 5 ms
};

constexpr double kRise = 100, kFall = 10, kApart = 10;  // ratios of power: 20, 10 and 10 dB
constexpr double kLoud_s = 0.005;

// What rises and falls like a clap, loudest first, down to kApart below the loudest; of those within a quarter of a
// second the loudest: others echo. No more than one beyond kMostClaps.
std::vector<Onset> FindOnsets(const Power& power) {
  const std::ptrdiff_t rise = power.BinsIn(0.003), before = power.BinsIn(0.1), loud = power.BinsIn(kLoud_s),
                       later = power.BinsIn(0.1), long_later = power.BinsIn(0.15), dead = power.BinsIn(0.25);
  std::vector<Onset> onsets;
  for (std::ptrdiff_t bin = before; bin + long_later <= power.Bins(); ++bin) {
    const double background = power.Mean(bin - rise - before, bin - rise), now = power.Mean(bin, bin + 1);
    const double loudness = power.Mean(bin, bin + loud);
    if (now > kRise * background && power.Mean(bin + later, bin + long_later) < loudness / kFall)
      onsets.push_back({bin, loudness});
  }
  std::ranges::stable_sort(onsets, std::greater{}, &Onset::loudness);
  std::vector<Onset> apart;
  for (const Onset& onset : onsets) {
    if (onset.loudness <= onsets.front().loudness / kApart || apart.size() > kMostClaps) break;
    if (std::ranges::none_of(apart, [&](const Onset& other) { return std::abs(other.bin - onset.bin) < dead; }))
      apart.push_back(onset);
  }
  return apart;
}

// The loudest 5 ms apart from these, from just before each until it has died away.
double LoudestElse(const Power& power, const std::vector<Onset>& onsets) {
  const std::ptrdiff_t loud = power.BinsIn(kLoud_s), begin = power.BinsIn(0.03), end = power.BinsIn(0.6);
  double loudest = kSilence;
  for (std::ptrdiff_t bin = 0; bin + loud <= power.Bins(); ++bin) {
    const bool is_of_one =
        std::ranges::any_of(onsets, [&](const Onset& o) { return bin > o.bin - begin && bin < o.bin + end; });
    if (!is_of_one) loudest = std::max(loudest, power.Mean(bin, bin + loud));
  }
  return loudest;
}

// Some of the high-passed samples, from one to before the other.
struct Excerpt {
  std::size_t begin = 0, end = 0;
  std::vector<float> samples = {};
};

// The sound's amplitude around these samples: root mean square over half a millisecond.
std::vector<double> AmplitudeOf(const Excerpt& excerpt, std::size_t from, std::size_t to, std::size_t half) {
  std::vector<double> amplitude;
  amplitude.reserve(to - from);
  for (std::size_t i = from; i < to; ++i) {
    const std::size_t begin = i - std::min(i, half), end = std::min(excerpt.end, i + half + 1);
    const float* const first = excerpt.samples.data() + (begin - excerpt.begin);
    const double sum = std::inner_product(first, first + (end - begin), first, 0.0);
    amplitude.push_back(std::sqrt(sum / static_cast<double>(end - begin)));
  }
  return amplitude;
}

// Going back from the peak: the first sample from which on it is louder than this. A dip of a millisecond ends nothing.
std::size_t Passes(const std::vector<double>& amplitude, std::size_t peak, double least, double rate_hz) {
  const auto dip = static_cast<std::size_t>(0.001 * rate_hz);
  std::size_t passes = peak;
  for (std::size_t i = peak; i-- > 0 && passes - i <= dip;)
    if (amplitude[i] >= least) passes = i;
  return passes;
}

// What is looked at around an onset: 20 ms before it, 10 ms after, and on both sides what an amplitude is of.
class Surroundings {
 public:
  Surroundings(const Onset& onset, const Power& power, const video::Sound& sound)
      : half_(static_cast<std::size_t>(std::llround(kBin_s / 2 * sound.rate_hz))) {
    const std::size_t at = power.FirstSample(onset.bin), reach = static_cast<std::size_t>(0.01 * sound.rate_hz);
    from_ = at - std::min(at, 2 * reach);
    to_ = std::min(sound.samples, at + reach);
    excerpt_ = {.begin = from_ - std::min(from_, half_), .end = std::min(sound.samples, to_ + half_)};
    excerpt_.samples.reserve(excerpt_.end - excerpt_.begin);
  }

  void Take(std::size_t index, float sample) {
    if (index >= excerpt_.begin && index < excerpt_.end) excerpt_.samples.push_back(sample);
  }

  std::size_t From() const { return from_; }
  std::vector<double> Amplitude() const { return AmplitudeOf(excerpt_, from_, to_, half_); }

 private:
  std::size_t half_, from_ = 0, to_ = 0;
  Excerpt excerpt_;
};

// It begins where it has a third of its first peak's amplitude (−10 dB), as certain as it rises from a tenth to 0.7:
// coders smear what precedes a sudden sound (pre-echo).
Clap Begin(const Surroundings& around, const video::Sound& sound) {
  const double rate_hz = sound.rate_hz;
  const std::vector<double> amplitude = around.Amplitude();
  const auto peak = static_cast<std::size_t>(std::ranges::max_element(amplitude) - amplitude.begin());
  const auto passes = [&](double part) { return Passes(amplitude, peak, part * amplitude[peak], rate_hz); };
  constexpr double kLeastSd_s = 0.0001;  // of the high-pass filter's delay and the half millisecond's shape
  const double rise_s = static_cast<double>(passes(0.7) - passes(0.1)) / rate_hz;
  return {.time_s = sound.TimeOf(static_cast<double>(around.From() + passes(0.316))),
          .sd_s = std::hypot(rise_s / std::sqrt(12.0), kLeastSd_s)};
}

// The power of a sound, and what is known of it. Throws Error for a rate at which no clap is found.
struct HeardSound {
  video::Sound sound;
  Power power;
};
HeardSound Hear(const SoundReading& read, const std::filesystem::path& film) {
  constexpr double kLeastRateHz = 8000;  // a telephone's: below it little is left above the filter's corner
  std::optional<HighPass> filter;
  std::optional<Power> power;
  video::Sound sound = read([&](double rate_hz, std::span<const float> samples) {
    if (!(rate_hz >= kLeastRateHz))
      throw Fail("{}: its sound has {:g} samples a second; a clap is found in {:g} or more", film.string(), rate_hz,
                 kLeastRateHz);
    if (!filter) {
      filter.emplace(rate_hz);
      power.emplace(rate_hz);
    }
    for (const float sample : samples) power->Add(filter->Next(sample));
  });
  return {std::move(sound), std::move(power.value())};
}

std::vector<Surroundings> SurroundingsOf(const std::vector<Onset>& onsets, const HeardSound& heard,
                                         const SoundReading& read, const std::filesystem::path& film) {
  std::vector<Surroundings> around;
  around.reserve(onsets.size());
  for (const Onset& onset : onsets) around.emplace_back(onset, heard.power, heard.sound);
  HighPass filter(heard.sound.rate_hz);
  std::size_t index = 0;
  read([&](double, std::span<const float> samples) {
    for (const float sample : samples) {
      const float passed = filter.Next(sample);
      for (Surroundings& one : around) one.Take(index, passed);
      ++index;
    }
  });
  if (index != heard.sound.samples) throw Fail("{}: its sound changed while it was read; try again", film.string());
  return around;
}

std::vector<Clap> ClapsIn(const HeardSound& heard, const SoundReading& read, const std::filesystem::path& film) {
  const auto& [sound, power] = heard;
  const std::vector<Onset> onsets = FindOnsets(power);
  if (onsets.empty())
    throw Fail("{}: no clap is heard: nothing rises by {:.0f} dB within 3 ms and has died away 0.1 s later",
               film.string(), Db(kRise));
  if (onsets.size() > kMostClaps)
    throw Fail("{}: more than {} claps are heard; a signal is one of them, or a few at unlike intervals", film.string(),
               kMostClaps);
  const double loudest_else = LoudestElse(power, onsets), apart = onsets.back().loudness / loudest_else;
  if (apart < kApart)
    throw Fail(
        "{}: no clap stands out: the loudest sudden sound, at {:.2f} s, is {:+.0f} dB against what else is heard, "
        "speech perhaps, where a clap is {:.0f} dB above it; clap nearer to the microphone, and be silent meanwhile",
        film.string(), sound.TimeOf(static_cast<double>(power.FirstSample(onsets.front().bin))), Db(apart), Db(kApart));
  const std::vector<Surroundings> around = SurroundingsOf(onsets, heard, read, film);
  std::vector<Clap> claps;
  claps.reserve(onsets.size());
  for (const Surroundings& of : around) claps.push_back(Begin(of, sound));
  std::ranges::sort(claps, {}, &Clap::time_s);
  return claps;
}

}  // namespace

std::vector<Clap> FindClaps(const SoundReading& read, const std::filesystem::path& film) {
  return ClapsIn(Hear(read, film), read, film);
}

Signal SignalOfClaps(const std::filesystem::path& film, const ClapOptions& options) {
  constexpr double kSound_mm_s = 343e3, kFarthest_mm = 5000;  // air at 20 °C; a laboratory
  const SoundReading read = [&film](const video::TakeSamples& take) { return video::ReadSound(film, take); };
  const HeardSound heard = Hear(read, film);
  const video::Sound& sound = heard.sound;
  const double way_s = options.distance_mm.value_or(kFarthest_mm / 2) / kSound_mm_s;
  const double way_sd_s = options.distance_mm ? 0 : kFarthest_mm / kSound_mm_s / std::sqrt(12.0);
  const double priming_s = sound.is_priming_known ? 0 : video::Sound::kMostPriming / sound.rate_hz;
  Signal signal{.name = "claps", .sd_s = 0};
  for (const Clap& clap : ClapsIn(heard, read, film)) {
    signal.rises_s.push_back(clap.time_s - way_s - priming_s / 2);
    signal.sd_s = std::max(signal.sd_s, clap.sd_s);
  }
  signal.common_sd_s = std::hypot(way_sd_s, priming_s / std::sqrt(12.0));
  if (!sound.is_priming_known)
    signal.warnings.push_back(
        fmt::format("{}: it does not say how much silence its coder put before the sound, up to {:.0f} ms: give a film "
                    "with uncompressed sound, or in the container in which the camera wrote it",
                    film.string(), 1e3 * priming_s));
  if (!options.distance_mm)
    signal.warnings.push_back(fmt::format(
        "{}: how far the clap was from its microphone is not given and taken as 0 to {:.0f} m, {:.0f} ms of sound",
        film.string(), kFarthest_mm / 1000, 1e3 * kFarthest_mm / kSound_mm_s));
  return signal;
}

}  // namespace lake::sync
