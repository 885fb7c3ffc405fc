// Claps in the sound of films whose truth is known: made sounds, put into films by the ffmpeg program.
#include "lake/sync/clap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <span>

#include "lake/core/error.h"
#include "lake/video/video_reader.h"
#include "video/video_files.h"

namespace lake::test {
namespace {

using testing::HasSubstr;

constexpr double kLength_s = 5;

// A room's sound, made: noise 60 dB below full scale, to which the rest is added.
class MadeSound {
 public:
  explicit MadeSound(unsigned seed, double rate_hz = 48000, double noise = 0.001)
      : rate_hz_(rate_hz), random_(seed), samples_(static_cast<std::size_t>(kLength_s * rate_hz)) {
    for (double& sample : samples_) sample = noise * normal_(random_);
  }

  // Two hands: noise that is there within 0.2 ms and dies away with 6 ms, and the room's answer 20 dB below, 0.15 s.
  MadeSound& Clap(double at_s, double amplitude = 0.5) {
    for (std::size_t i = First(at_s); i < samples_.size(); ++i) {
      const double t = At(i) - at_s;
      const double direct = -std::expm1(-t / 0.0001) * std::exp(-t / 0.006), room = 0.1 * std::exp(-t / 0.05);
      samples_[i] += amplitude * (direct + room) * 0.5 * normal_(random_);
    }
    return *this;
  }

  // Syllables, five a second: a stop's burst of 8 ms, a vowel of harmonics of 120 Hz that falls by 12 dB an octave,
  // a fricative's noise that swells within 40 ms.
  MadeSound& Speech(double from_s, double to_s, double amplitude) {
    constexpr double kSyllable_s = 0.2;
    for (std::size_t i = First(from_s); i < First(to_s); ++i) {
      const double t = std::fmod(At(i) - from_s, kSyllable_s);
      double sample = t < 0.008 ? 0.15 * normal_(random_) * std::exp(-t / 0.004) : 0;
      for (int k = 1; k <= 30 && t > 0.01 && t < 0.12; ++k)
        sample += std::sin(2 * std::numbers::pi * 120 * k * t) / (1 + k * k / 9.0) *
                  std::sin(std::numbers::pi * (t - 0.01) / 0.11) / 3;
      if (t > 0.12) sample += 0.12 * normal_(random_) * std::sin(std::numbers::pi * (t - 0.12) / 0.08);
      samples_[i] += amplitude * sample;
    }
    return *this;
  }

  // A machine that is switched on.
  MadeSound& Noise(double from_s, double amplitude) {
    for (std::size_t i = First(from_s); i < samples_.size(); ++i) samples_[i] += amplitude * normal_(random_);
    return *this;
  }

  void Write(const std::filesystem::path& wav) const {
    std::ofstream file(wav, std::ios::binary);
    const auto put = [&](std::uint32_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) file.put(static_cast<char>(value >> (8 * i)));
    };
    const auto bytes = static_cast<std::uint32_t>(2 * samples_.size()), rate = static_cast<std::uint32_t>(rate_hz_);
    file << "RIFF", put(36 + bytes, 4), file << "WAVEfmt ", put(16, 4), put(1, 2), put(1, 2), put(rate, 4);
    put(2 * rate, 4), put(2, 2), put(16, 2), file << "data", put(bytes, 4);
    for (const double sample : samples_)
      put(static_cast<std::uint16_t>(std::lround(32767 * std::clamp(sample, -1.0, 1.0))), 2);
  }

  // In blocks of 1000 samples.
  sync::SoundReading AsRead() const {
    std::vector<float> samples(samples_.begin(), samples_.end());
    return [samples = std::move(samples), rate_hz = rate_hz_](const video::TakeSamples& take) {
      constexpr std::size_t kBlock = 1000;
      for (std::size_t i = 0; i < samples.size(); i += kBlock)
        take(rate_hz, std::span(samples).subspan(i, std::min(kBlock, samples.size() - i)));
      return video::Sound{.rate_hz = rate_hz, .samples = samples.size(), .stamps = {{.sample = 0, .time_s = 0}}};
    };
  }

 private:
  double At(std::size_t i) const { return static_cast<double>(i) / rate_hz_; }
  std::size_t First(double time_s) const {
    return std::min(samples_.size(), static_cast<std::size_t>(std::ceil(time_s * rate_hz_)));
  }

  double rate_hz_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<double> samples_;
};

constexpr double kFlash_s = 2, kClap_s = 2.0137;

// A film that turns white at kFlash_s, with this sound, whose clap is at kClap_s.
void MakeFilm(const std::filesystem::path& film, const MadeSound& sound, const std::string& coding,
              const std::string& before_sound = "") {
  const TemporaryFolder folder;
  sound.Write(folder / "sound.wav");
  Ffmpeg(fmt::format(
      "-f lavfi -i \"color=black:size=64x48:rate=25:duration=5,drawbox=color=white:t=fill:enable='gte(t,{})'\" {} -i "
      "{} {} {}",
      kFlash_s, before_sound, Quote(folder / "sound.wav"), coding, Quote(film)));
}

sync::SoundReading ReadingOf(const std::filesystem::path& film) {
  return [film](const video::TakeSamples& take) { return video::ReadSound(film, take); };
}

// What is known of a film's sound.
video::Sound SoundOf(const std::filesystem::path& film) {
  return video::ReadSound(film, [](double, std::span<const float>) {});
}

// When the film turns white, on the clock of its frames.
double FlashOf(const std::filesystem::path& film) {
  const auto reader = video::VideoReader::Open(film);
  for (video::VideoFrame frame; reader->Read(frame);)
    if (cv::mean(frame.luma)[0] > 128) return frame.time_s;
  throw Fail("{}: never white", film.string());
}

std::string ReasonOf(const MadeSound& sound) {
  try {
    sync::FindClaps(sound.AsRead(), "film.mp4");
  } catch (const Error& error) {
    return error.what();
  }
  return "a clap";
}

// The silence before AAC's 1024 and MP3's 1105 first samples (21 and 23 ms) is told by MP4's edit list, and by the
// stamps of Matroska and transport streams; of MP4 whose sound begins later the list is another (`is_told`), and FFmpeg
// puts the silence into its time. `sound_later_s`: the whole sound is, the pictures are not.
struct Filmed {
  const char* name;
  const char* coding;
  const char* before_sound;
  double sound_later_s = 0;
  bool is_told = true;
};

void PrintTo(const Filmed& filmed, std::ostream* out) {
  *out << filmed.name;
}

class ClapInAFilm : public testing::TestWithParam<Filmed> {};

TEST_P(ClapInAFilm, BeginsWhenItDoes) {
  const Filmed& param = GetParam();
  const TemporaryFolder folder;
  const auto film = folder / param.name;
  MakeFilm(film, MadeSound(36).Clap(kClap_s).Speech(3, 4.8, 0.02), param.coding, param.before_sound);
  EXPECT_EQ(SoundOf(film).is_priming_known, param.is_told);
  const std::vector<sync::Clap> claps = sync::FindClaps(ReadingOf(film), film);
  ASSERT_EQ(claps.size(), 1U);
  // The clap's own rise, a coder's smear, and Matroska's stamps of the frames, rounded to 1 ms.
  EXPECT_NEAR(claps[0].time_s - FlashOf(film), kClap_s - kFlash_s + param.sound_later_s, 0.001);
  EXPECT_LT(claps[0].sd_s, 0.0015);
}

constexpr const char* kPcm = "-c:v libx264 -c:a pcm_s16le";
constexpr const char* kAac = "-c:v libx264 -bf 2 -c:a aac -b:a 128k";
constexpr const char* kMp3 = "-c:v libx264 -c:a libmp3lame -b:a 128k";

INSTANTIATE_TEST_SUITE_P(Containers, ClapInAFilm,
                         testing::Values(Filmed{"pcm.mkv", kPcm, ""}, Filmed{"pcm.mov", kPcm, ""},
                                         Filmed{"pcm.avi", "-c:v mjpeg -c:a pcm_s16le", ""},  // AVI knows no B-frames
                                         Filmed{"aac.mp4", kAac, ""}, Filmed{"aac.mkv", kAac, ""},
                                         Filmed{"aac.ts", kAac, ""}, Filmed{"mp3.mp4", kMp3, ""},
                                         Filmed{"mp3.mkv", kMp3, ""}, Filmed{"flac.mkv", "-c:v libx264 -c:a flac", ""},
                                         Filmed{"later.mp4", kAac, "-itsoffset 0.7314", 0.7314, false},
                                         Filmed{"later.mkv", kAac, "-itsoffset 0.7314", 0.7314},
                                         Filmed{"earlier.mp4", kAac, "-itsoffset -0.3", -0.3},
                                         Filmed{"stereo44.mp4", "-c:v libx264 -c:a aac -ac 2 -ar 44100", ""}),
                         [](const auto& one) {
                           std::string name = one.param.name;
                           name.erase(name.find('.'), 1);
                           return name;
                         });

// At a frame's time: of a cut between two frames libav moves the pictures by the rest.
TEST(ClapInACut, IsWhereItWasInACopyThatWasCut) {
  const TemporaryFolder folder;
  MakeFilm(folder / "film.mp4", MadeSound(37).Clap(kClap_s), kAac);
  Ffmpeg(fmt::format("-ss 0.48 -i {} -c copy {}", Quote(folder / "film.mp4"), Quote(folder / "cut.mp4")));
  const auto claps = sync::FindClaps(ReadingOf(folder / "cut.mp4"), "cut.mp4");
  ASSERT_EQ(claps.size(), 1U);
  EXPECT_NEAR(claps[0].time_s - FlashOf(folder / "cut.mp4"), kClap_s - kFlash_s, 0.001);
}

// AVI does not tell of a coder's silence (here 21 and 23 ms, with the pictures at 0): not known within some 44 ms,
// which the signal's SD holds.
TEST(Sound, WithUntoldPrimingSaysSo) {
  for (const char* coding :
       {"-c:v mjpeg -c:a aac -avoid_negative_ts disabled", "-c:v mjpeg -c:a libmp3lame -avoid_negative_ts disabled"}) {
    const TemporaryFolder folder;
    const auto film = folder / "film.avi";
    MakeFilm(film, MadeSound(38).Clap(kClap_s), coding);
    EXPECT_FALSE(SoundOf(film).is_priming_known);
    const sync::Signal signal = sync::SignalOfClaps(film, {.distance_mm = 0});
    ASSERT_EQ(signal.rises_s.size(), 1U);
    EXPECT_NEAR(signal.rises_s[0] - FlashOf(film), kClap_s - kFlash_s, 2 * signal.common_sd_s) << coding;
    EXPECT_NEAR(signal.common_sd_s, 0.0127, 1e-4);  // 44 ms / √12
    EXPECT_THAT(signal.warnings, testing::ElementsAre(HasSubstr("silence its coder put before")));
  }
}

// So that a long film's sound takes no more memory than a short one's.
TEST(Sound, ComesInShortBlocks) {
  const TemporaryFolder folder;
  for (const char* coding : {kPcm, kAac}) {
    const auto film = folder / (coding == kPcm ? "pcm.mkv" : "aac.mkv");
    MakeFilm(film, MadeSound(39).Clap(kClap_s), coding);
    std::size_t longest = 0, samples = 0;
    const video::Sound sound = video::ReadSound(film, [&](double rate_hz, std::span<const float> block) {
      EXPECT_EQ(rate_hz, 48000);
      longest = std::max(longest, block.size());
      samples += block.size();
    });
    EXPECT_EQ(samples, sound.samples);
    EXPECT_NEAR(static_cast<double>(samples), kLength_s * 48000, 2 * 1024);  // coders fill a packet at both ends
    EXPECT_LT(longest, 24000U);                                              // half a second
  }
}

// With its index at the front a film opens as if it were whole; with it at the end, as cameras write it, not at all.
TEST(Sound, OfAFilmThatIsCutOffSaysSo) {
  const TemporaryFolder folder;
  for (const char* coding : {kPcm, kAac})
    for (const bool index_first : {true, false}) {
      const auto film = folder / "film.mov";
      MakeFilm(film, MadeSound(40).Clap(kClap_s), std::string(coding) + (index_first ? " -movflags +faststart" : ""));
      EXPECT_NO_THROW(SoundOf(film));
      std::filesystem::resize_file(film, std::filesystem::file_size(film) * 7 / 10);
      SCOPED_TRACE(testing::Message() << coding << ", index " << (index_first ? "first" : "last"));
      for (const bool clap : {true, false})
        EXPECT_THAT([&] { clap ? void(sync::SignalOfClaps(film)) : void(SoundOf(film)); },
                    testing::ThrowsMessage<Error>(
                        HasSubstr(index_first ? "film.mov: its sound is " : "damaged at its beginning or index")));
    }
}

TEST(Sound, NeedsASound) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=64x48:rate=25:duration=1") + Quote(folder / "mute.mp4"));
  EXPECT_THAT([&] { SoundOf(folder / "mute.mp4"); },
              testing::ThrowsMessage<Error>(HasSubstr("mute.mp4: holds no sound")));
  EXPECT_THAT([&] { SoundOf(folder / "none.mp4"); }, testing::ThrowsMessage<Error>(HasSubstr("no such file")));
}

TEST(Sound, WithNumbersThatAreNoneIsDamaged) {
  const TemporaryFolder folder;
  Ffmpeg("-f lavfi -i \"aevalsrc='if(eq(n,30000),0/0,0.1)':s=48000:d=1\" -c:a pcm_f32le " + Quote(folder / "film.mkv"));
  EXPECT_THAT([&] { SoundOf(folder / "film.mkv"); }, testing::ThrowsMessage<Error>(HasSubstr("its sound is damaged")));
}

TEST(FindClaps, FindsThemWithinTheirInterval) {
  int beyond = 0, claps = 0;
  for (const double rate_hz : {16000., 44100., 48000.})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const double at_s = 1.5 + 0.10037 * seed;
      MadeSound sound(seed, rate_hz, 0.003);
      sound.Speech(3, 4.9, 0.05).Clap(at_s, 0.2);
      const auto found = sync::FindClaps(sound.AsRead(), "film");
      ASSERT_EQ(found.size(), 1U);
      EXPECT_NEAR(found[0].time_s, at_s, 0.001);
      beyond += std::abs(found[0].time_s - at_s) > 2 * found[0].sd_s;
      ++claps;
    }
  EXPECT_LE(beyond, claps / 10);  // 95 % within 2 SD
}

TEST(FindClaps, FindsSeveral) {
  const auto found =
      sync::FindClaps(MadeSound(4).Clap(1).Clap(1.7, 0.3).Clap(3.9, 0.4).Clap(2.5, 0.03).AsRead(), "film");
  ASSERT_EQ(found.size(), 3U) << "the fourth is 24 dB below the loudest";
  EXPECT_NEAR(found[1].time_s, 1.7, 0.001);
  EXPECT_NEAR(found[2].time_s, 3.9, 0.001);
}

TEST(FindClaps, SaysWhyThereIsNone) {
  EXPECT_THAT(ReasonOf(MadeSound(5)), HasSubstr("no clap is heard"));
  EXPECT_THAT(ReasonOf(MadeSound(6).Noise(2, 0.2)), HasSubstr("no clap is heard"));
  for (unsigned seed = 1; seed <= 5; ++seed)
    EXPECT_THAT(ReasonOf(MadeSound(seed).Speech(1, 4.9, 0.5)), HasSubstr("no clap"));
  EXPECT_THAT(ReasonOf(MadeSound(7).Speech(1, 4.9, 0.5).Clap(0.5, 0.05)), HasSubstr("no clap stands out"));
  EXPECT_THAT(ReasonOf(MadeSound(8).Clap(1).Noise(3, 0.2)), HasSubstr("no clap stands out"));
  EXPECT_THAT(ReasonOf(MadeSound(9).Noise(kLength_s - 0.05, 0.2)), HasSubstr("no clap is heard"))
      << "nobody knows that it dies away";
  MadeSound applause(10);
  for (double at_s = 0.3; at_s < 4.8; at_s += 0.2) applause.Clap(at_s);
  EXPECT_THAT(ReasonOf(applause), HasSubstr("clap"));
  EXPECT_THAT(ReasonOf(MadeSound(11, 50).Clap(1)), HasSubstr("50 samples a second"));
}

TEST(SignalOfClaps, TakesOffTheSoundsWay) {
  const TemporaryFolder folder;
  MakeFilm(folder / "film.mkv", MadeSound(9).Clap(kClap_s), kPcm);
  const sync::Signal near = sync::SignalOfClaps(folder / "film.mkv", {.distance_mm = 0}),
                     far = sync::SignalOfClaps(folder / "film.mkv", {.distance_mm = 3430}),
                     unknown = sync::SignalOfClaps(folder / "film.mkv");
  EXPECT_NEAR(near.rises_s[0] - far.rises_s[0], 0.01, 1e-9);
  EXPECT_EQ(far.common_sd_s, 0);
  EXPECT_NEAR(near.rises_s[0] - unknown.rises_s[0], 2.5 / 343, 1e-9);
  EXPECT_NEAR(unknown.common_sd_s, 5 / 343. / std::sqrt(12), 1e-9);
  EXPECT_THAT(unknown.warnings, testing::ElementsAre(HasSubstr("how far the clap was")));
}

}  // namespace
}  // namespace lake::test
