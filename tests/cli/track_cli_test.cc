// lake-track and its fellows on bad input, on a full disk, interrupted: one line, the right exit code, nothing
// half-written.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "lake/motion/leg_motion.h"
#include "programs.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A short recording that can be tracked, and files that cannot.
class TrackProgram : public testing::Test {
 protected:
  void Render() {
    RenderShort(folder_);
    fs::copy_file(folder_ / "good/video.mp4", folder_ / "good.mp4");
  }

  void Ffmpeg(const std::string& arguments) { Done(folder_, "ffmpeg -y -v error -nostdin " + arguments); }

  const std::string kTrack = "lake-track --no-overlay --quiet -o results ";

  void ExpectRefused(const std::string& arguments, int exit_code, const std::string& text) {
    const Outcome outcome = lake::ExpectRefused(folder_, kTrack + arguments, exit_code, text);
    EXPECT_EQ(outcome.ErrorLines(), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_EQ(FilesIn(folder_ / "results"), 0u) << arguments;
  }

  TemporaryFolder folder_;
};

TEST_F(TrackProgram, RefusesWhatIsNoVideo) {
  WriteTextFile(folder_ / "text.mp4", "This is not a video.\n");
  WriteTextFile(folder_ / "empty.mp4", "");
  fs::create_directory(folder_ / "folder.mp4");
  Ffmpeg("-f lavfi -i sine=duration=1 audio.mp4");
  Ffmpeg("-f lavfi -i testsrc2=size=320x240:rate=30:duration=0.02 -frames:v 1 one.mp4");
  Ffmpeg("-f lavfi -i color=black:size=320x240:rate=30:duration=1 black.mp4");
  ExpectRefused("absent.mp4", 1, "absent.mp4");
  ExpectRefused("folder.mp4", 1, "folder.mp4");
  ExpectRefused("text.mp4", 1, "text.mp4");
  ExpectRefused("empty.mp4", 1, "empty.mp4");
  ExpectRefused("audio.mp4", 1, "audio.mp4");
  ExpectRefused("one.mp4", 1, "1 frame");
  ExpectRefused("black.mp4", 1, "only 0 were seen");
  Ffmpeg(
      "-f lavfi -i testsrc2=size=320x240:rate=50:duration=0.5 -vf interlace -flags +ilme+ildct -c:v libx264 "
      "fields.mp4");
  ExpectRefused("fields.mp4", 1, "interlaced");
  ExpectRefused("absent/%05d.png", 1, "absent");
}

// Nobody writes to it: a video is not waited for, a table is, until the first signal.
TEST_F(TrackProgram, IsNotHungByAPipe) {
  Done(folder_, "mkfifo pipe.mp4 pipe.csv");
  ExpectRefused("pipe.mp4", 1, "pipe.mp4: is a pipe or a device");
  fs::create_directory(folder_ / "trial");
  for (const char* name : {"tracks.csv", "summary.json"}) WriteTextFile(folder_ / "trial" / name, "{}");
  for (const char* program : {"lake-check pipe.mp4", "lake-calibrate pipe.mp4 --board chessboard:9x6:25",
                              "lake-anonymise pipe.mp4 --trial trial"})
    EXPECT_THAT(Shell(folder_, fmt::format("timeout -k 1 20 {} -o results", program)).err,
                HasSubstr("save it as a file"));
  for (const char* program : {"lake-gait", "lake-info"})
    EXPECT_EQ(Shell(folder_, fmt::format("timeout --preserve-status -k 5 0.5 {} pipe.csv", program)).exit_code, 143)
        << program;
}

TEST_F(TrackProgram, RefusesATruncatedVideo) {
  Render();
  for (const int share : {10, 50, 90}) {
    // The index stands at the front, so the file opens; its frames end too soon.
    Ffmpeg("-i good.mp4 -c copy -movflags +faststart front.mp4");
    fs::resize_file(folder_ / "front.mp4", fs::file_size(folder_ / "front.mp4") * static_cast<unsigned>(share) / 100);
    ExpectRefused("front.mp4", 1, "front.mp4");
    fs::copy_file(folder_ / "good.mp4", folder_ / "back.mp4", fs::copy_options::overwrite_existing);
    fs::resize_file(folder_ / "back.mp4", fs::file_size(folder_ / "back.mp4") * static_cast<unsigned>(share) / 100);
    ExpectRefused("back.mp4", 1, "back.mp4");
  }
}

// Names that cannot be given: nothing is written but what was found.
TEST_F(TrackProgram, ShowsWhatItCannotName) {
  Render();
  for (const auto& [names, text] : {std::pair("a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q,r,s,t", "20 markers are wanted"),
                                    {"ankle,knee,hip,waist,toe", "toe"}}) {
    const Outcome outcome = lake::ExpectRefused(folder_, kTrack + "good.mp4 --markers " + names, 1, text);
    EXPECT_THAT(outcome.err, HasSubstr("results/candidates.png")) << names;
    for (const char* name : {"candidates.png", "candidates.csv", "summary.json"})
      EXPECT_TRUE(fs::exists(folder_ / "results" / name)) << name;
    EXPECT_FALSE(fs::exists(folder_ / "results" / "tracks.csv"));
  }
}

TEST_F(TrackProgram, RefusesOptionsThatDoNotFitTheVideo) {
  Render();
  ExpectRefused("good.mp4 --seed knee=5000,10", 1, "outside the picture");
  ExpectRefused("good.mp4 --seed knee=-1,10", 1, "outside the picture");
  ExpectRefused("good.mp4 --seed knee=640,360@99999", 1, "99999");
  ExpectRefused("good.mp4 --crop 1000,0,1000,100", 1, "--crop");
  ExpectRefused("good.mp4 --scale 10,10,500,10,0.5", 2, "is 0.5 in m?");
  ExpectRefused("good.mp4 --camera absent.yaml", 1, "absent.yaml");
  Done(folder_, "lake-synth -o other --duration 0.2 --width 640 --height 480 --quiet");
  ExpectRefused("good.mp4 --camera other/camera.yaml", 1, "640x480");
  WriteTextFile(folder_ / "broken.yaml", "%YAML:1.0\nimage_width: [\n");
  ExpectRefused("good.mp4 --camera broken.yaml", 1, "broken.yaml");
}

TEST_F(TrackProgram, RefusesWrongUsage) {
  WriteTextFile(folder_ / "video.mp4", "not looked at");
  ExpectRefused("video.mp4 --markers 'ankle,kn/ee,hip'", 2, "kn/ee");
  ExpectRefused("video.mp4 --markers ankle,knee,knee", 2, "twice");
  ExpectRefused("video.mp4 --markers ankle,,hip", 2, "--markers");
  ExpectRefused("video.mp4 --seed elbow=1,2", 2, "elbow");
  ExpectRefused("video.mp4 --seed knee", 2, "--seed");
  ExpectRefused("video.mp4 --seed knee=1", 2, "--seed");
  ExpectRefused("video.mp4 --seed knee=nan,2", 2, "--seed");
  ExpectRefused("video.mp4 --seed knee=1,2@1.5", 2, "whole number");
  ExpectRefused("video.mp4 --crop 0,0,0,10", 2, "--crop");
  ExpectRefused("video.mp4 --detector magic", 2, "magic");
  ExpectRefused("video.mp4 --color '#ff0000'", 2, "--color");
  ExpectRefused("video.mp4 --start 10 --end 5.5", 2, "--end 5.5 s is before --start 10 s");
  ExpectRefused("video.mp4 --no-such-option", 2, "--no-such-option");
  ExpectRefused("", 2, "video");
}

TEST_F(TrackProgram, SaysThatItsFolderCannotBeWritten) {
  Render();
  WriteTextFile(folder_ / "file", "in the way\n");
  lake::ExpectRefused(folder_, "lake-track good.mp4 --no-overlay --quiet -o file/results", 1, "file/results");
  EXPECT_EQ(ReadTextFile(folder_ / "file"), "in the way\n");
}

// Files may not grow beyond four kilobytes, as on a disk with no more room.
TEST_F(TrackProgram, LeavesNothingHalfWrittenOnAFullDisk) {
  Render();
  lake::ExpectRefused(folder_, "ulimit -f 4; trap '' XFSZ; " + kTrack + "good.mp4", 1, "results");
  EXPECT_FALSE(fs::exists(folder_ / "results" / "tracks.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "results" / "summary.json"));
}

TEST_F(TrackProgram, EndsCleanlyWhenInterrupted) {
  // A long video, so that the signal comes in the middle of it: the same two seconds again and again.
  Ffmpeg("-f lavfi -i testsrc2=size=1280x720:rate=60:duration=2 -c:v libx264 -preset ultrafast two_seconds.mp4");
  Ffmpeg("-stream_loop 19 -i two_seconds.mp4 -c copy long.mp4");
  for (const auto& [signal, code] : {std::pair("INT", 130), std::pair("TERM", 143)}) {
    // The signal comes when the video is open and the results are begun, however slow the machine is to get there.
    // Without job control (set -m) a shell starts programs in the background with SIGINT ignored.
    const Outcome outcome = Shell(
        folder_, fmt::format("bash -c 'set -m; lake-track long.mp4 --no-overlay --quiet -o results & "
                             "until [ -e results/.lake-track.lake-unfinished ] || ! kill -0 $!; do sleep 0.02; done; "
                             "kill -s {} $!; wait $! 2>&-'",
                             signal));
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_EQ(outcome.err, "lake-track: interrupted\n");
    EXPECT_EQ(FilesIn(folder_ / "results"), 0u);
  }
}

// A film that is stored narrower than it is shown, as DV and HDV are, says so; so do the tables that lie beside its
// summary.
TEST_F(TrackProgram, AFilmStoredNarrowerThanShownGivesTheSameAngles) {
  Render();
  Ffmpeg("-i good.mp4 -vf scale=540:ih,setsar=4/3 -c:v libx264 -crf 8 narrow.mp4");
  Done(folder_, "lake-track good.mp4 --no-overlay --quiet -o square");
  EXPECT_THAT(Done(folder_, kTrack + "narrow.mp4").err, HasSubstr("pixels are 1.33 times as wide as high"));
  EXPECT_NEAR(ReadJsonFile(folder_ / "results/summary.json")["video"]["pixel_aspect"].get<double>(), 4 / 3.0, 1e-9);
  Done(folder_, "lake-gait results --quiet -o again");
  const motion::LegMotion truth = motion::ReadKinematicsCsv(folder_ / "square/kinematics.csv");
  for (const char* folder : {"results", "again"}) {
    const motion::LegMotion narrow = motion::ReadKinematicsCsv(folder_ / folder / "kinematics.csv");
    ASSERT_EQ(narrow.samples.size(), truth.samples.size());
    double worst_deg = 0;
    for (std::size_t i = 0; i < truth.samples.size(); ++i)
      worst_deg = std::max(worst_deg, std::abs(narrow.samples[i].knee_deg - truth.samples[i].knee_deg));
    EXPECT_LT(worst_deg, 0.5) << folder;
  }
}

TEST_F(TrackProgram, PicturesThatAreTooSmallAreRefusedInOneLine) {
  for (const char* size : {"2x2", "64x2", "8x64"}) {
    Ffmpeg(fmt::format("-f lavfi -i testsrc=size={}:rate=30:duration=1 -c:v ffv1 tiny.mkv", size));
    ExpectRefused("tiny.mkv", 1, fmt::format("its pictures are of {} px", size));
    lake::ExpectRefused(folder_, "lake-check tiny.mkv --quiet -o check", 1, "its pictures are of");
  }
}

TEST_F(TrackProgram, SummaryIsOneJsonValueAndTheFrontDoorDoesTheSame) {
  Render();
  // Throws on anything before or after the value.
  const Json summary = DoneJson(folder_, "lake-track good.mp4 --no-overlay --quiet --json -o direct");
  EXPECT_EQ(summary["program"], "lake-track");
  for (const char* key : {"version", "command", "options", "inputs", "warnings", "video", "tracking"})
    EXPECT_TRUE(summary.contains(key)) << key;
  EXPECT_EQ(summary, Json::parse(ReadTextFile(folder_ / "direct" / "summary.json")));

  Done(folder_, "lake track good.mp4 --no-overlay --quiet -o front");
  for (const char* name : {"tracks.csv", "kinematics.csv", "events.csv"})
    EXPECT_EQ(ReadTextFile(folder_ / "front" / name), ReadTextFile(folder_ / "direct" / name)) << name;
}

class Programs : public testing::TestWithParam<std::string> {};

TEST_P(Programs, AnswerHelpVersionAndUnknownOptions) {
  const TemporaryFolder folder;
  const std::string program = GetParam();
  const Outcome help = Done(folder, program + " --help");
  EXPECT_EQ(help.err, "");
  EXPECT_THAT(help.out, HasSubstr("lake"));
  EXPECT_THAT(Done(folder, program + " --version").out, testing::StartsWith(program + " "));
  EXPECT_EQ(ExpectRefused(folder, program + " --no-such-option", 2, program + ": ").out, "");
}

std::vector<std::string> AllPrograms() {
  std::vector<std::string> names{"lake"};
  for (const ListedProgram& program : kPrograms) names.push_back(fmt::format("lake-{}", program.name));
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, Programs, testing::ValuesIn(AllPrograms()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace lake
