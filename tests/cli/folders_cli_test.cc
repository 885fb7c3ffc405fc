// Folders of results as users come to mix them up, and commands as they are typed.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/motion/marker_recording.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Folders : public testing::Test {
 protected:
  // Without options the recording that many tests share.
  void Render(const std::string& options = "") {
    if (options.empty())
      RenderShort(folder_);
    else
      Done("lake-synth -o good --duration 3 --rate 30 --width 720 --quiet " + options);
    fs::copy_file(folder_ / "good/video.mp4", folder_ / "human.mp4");
  }

  Outcome Done(const std::string& command) { return lake::Done(folder_, command); }

  Outcome Refused(const std::string& command, int exit_code, const std::string& text) {
    return ExpectRefused(folder_, command, exit_code, text);
  }

  bool Has(const std::string& name) const { return fs::exists(folder_ / name); }

  TemporaryFolder folder_;
};

TEST_F(Folders, OfAReusedNameHoldOneRun) {
  Render();
  const std::string camera = " --camera good/camera.yaml";
  Done("lake-track human.mp4 --quiet -o D --export trc,c3d" + camera);
  for (const char* name : {"D/overlay.mp4", "D/human.trc", "D/human.c3d", "D/trajectory.csv"}) EXPECT_TRUE(Has(name));
  Done("cp human.mp4 exo.mp4 && lake-track exo.mp4 --no-overlay --quiet -o D");
  for (const char* name : {"D/overlay.mp4", "D/human.trc", "D/human.c3d", "D/trajectory.csv"})
    EXPECT_FALSE(Has(name)) << name << " is of another video";
  const Json gait = Json::parse(Done("$(command -v lake-gait) D --quiet --json -o G").out);
  EXPECT_EQ(gait["command"], "lake-gait D --quiet --json -o G");
  EXPECT_EQ(gait["inputs"][0]["path"], "D/tracks.csv");
}

TEST_F(Folders, ThatNobodyChoseAreNotTakenOver) {
  Render();
  Done("mkdir s01 s02 && cp human.mp4 s01 && cp human.mp4 s02");
  Done("lake-track s01/human.mp4 --no-overlay --quiet");
  const std::string before = ReadTextFile(folder_ / "lake-out/human/summary.json");
  const Outcome refused = Refused("lake-track s02/human.mp4 --no-overlay --quiet", 1, "s01/human.mp4");
  EXPECT_THAT(refused.err, AllOf(HasSubstr("lake-out/human"), HasSubstr("-o")));
  EXPECT_EQ(ReadTextFile(folder_ / "lake-out/human/summary.json"), before);
  Done("cd s01 && lake-track human.mp4 --no-overlay --quiet -o ../lake-out/human");
  Done("lake-track s01/human.mp4 --no-overlay --quiet");
  // lake-gait's own folder for a trial of that name is the trial itself.
  Refused("lake-gait lake-out/human --quiet", 1, "lake-track");
}

TEST_F(Folders, KeepAGoodTrialWhenItsRepetitionFails) {
  Render();
  const std::string track = "lake-track human.mp4 --no-overlay --quiet -o D";
  Done(track);
  const std::vector<std::string> names = {"summary.json", "tracks.csv", "kinematics.csv", "events.csv", "track.png"};
  std::vector<std::string> before;
  for (const std::string& name : names) before.push_back(ReadTextFile(folder_ / "D" / name));
  Refused(track + " --seed knee=10,10", 1, "knee");
  for (std::size_t i = 0; i < names.size(); ++i)
    EXPECT_EQ(ReadTextFile(folder_ / "D" / names[i]), before[i]) << names[i];
  Done("lake-gait D --quiet -o G");
  Done(track);
  EXPECT_FALSE(Has("D/failed"));
}

TEST_F(Folders, TakeOneRunAtATime) {
  Render();
  // The first is held, once it has said what it works on, while the second tries, however busy the machine.
  const Outcome both = Done(
      "lake-track human.mp4 --no-overlay --quiet -o D 2>first.txt & first=$!; "
      "until grep -qs human.mp4 D/.lake-track.lake-unfinished/.lake-track.* || ! kill -0 $first; do sleep 0.01; done; "
      "kill -STOP $first; "
      "lake-track human.mp4 --no-overlay --quiet -o D 2>second.txt; echo second $?; kill -CONT $first; "
      "wait $first; echo first $?");
  EXPECT_THAT(both.out, AllOf(HasSubstr("second 1"), HasSubstr("first 0")));
  EXPECT_THAT(ReadTextFile(folder_ / "second.txt"), AllOf(HasSubstr("another run is at work"), HasSubstr("human.mp4")));
}

// Nothing that can be known before costs the minutes of tracking.
TEST_F(Folders, AreNotBegunWithWhatCannotEndWell) {
  Render("--jitter 0.3");
  const std::string track = "lake-track human.mp4 --no-overlay --quiet -o D ";
  Refused(track + "--camera good/camera.yaml --export c3d", 1, "uneven");
  Refused(track + "--camera good/camera.yaml --markers ankle,knee,waist --export mot", 2, "mot");
  const auto corrected = [&](const char* row, const char* text) {
    WriteTextFile(folder_ / "c.csv", std::string("frame,marker,x_px,y_px\n") + row);
    Refused(track + "--corrections c.csv", 1, text);
  };
  corrected("1,elbow,3,4\n", "c.csv:2: no marker 'elbow'");
  corrected("1.5,knee,3,4\n", "c.csv:2: frame 1.5");
  corrected("100000,knee,3,4\n", "c.csv:2: frame 100000 is not in the recording");
  corrected("1,knee,3,\n", "c.csv:2: x_px and y_px");
  corrected("1,knee,3,99999\n", "outside the picture");
  WriteTextFile(folder_ / "e.csv", "repetition,event,time_s\n1,onset,1\n1,standing,1000\n");
  Refused(track + "--events e.csv", 1, "e.csv:3: 1000 s is outside the recording");
  Refused(track + "--events none.csv", 1, "none.csv: no such file");
  Refused(track + "--events e.csv --markers ankle,knee,waist", 2, "--events: without ankle, knee and hip");
  EXPECT_FALSE(Has("D"));
}

// Knee and hip in each other's places from half-way on, by the user's own corrections.
TEST_F(Folders, KeepWhatWasTrackedWhereNoLegCanBeFitted) {
  Render("--still");
  Done("lake-track human.mp4 --no-overlay --quiet -o right");
  const motion::MarkerRecording right = motion::ReadMarkerCsv(folder_ / "right/tracks.csv");
  std::string rows = "frame,marker,x_px,y_px\n";
  for (std::size_t i = right.Frames() / 2; i < right.Frames(); ++i)
    for (const auto& [name, other] : {std::pair("knee", "hip"), std::pair("hip", "knee")}) {
      const Eigen::Vector2d place = right.Find(other)->samples[i].position;
      rows += fmt::format("{},{},{},{}\n", right.frame[i], name, place.x(), place.y());
    }
  WriteTextFile(folder_ / "swapped.csv", rows);
  const Outcome outcome = Refused("lake-track human.mp4 --quiet -o D --corrections swapped.csv", 1,
                                  "what was tracked, without a leg, is in D");
  EXPECT_THAT(outcome.err, Not(HasSubstr("--up")));
  for (const char* name : {"D/tracks.csv", "D/track.png", "D/overlay.mp4"}) EXPECT_TRUE(Has(name)) << name;
  EXPECT_FALSE(Has("D/kinematics.csv"));
  const Json summary = ReadJsonFile(folder_ / "D/summary.json");
  EXPECT_THAT(summary["failed"].get<std::string>(), HasSubstr("leg fit"));
}

// Knee and hip by each other's names, by the user's own seeds; and what is shown then.
TEST_F(Folders, ShowWhatWasFoundWhereTheMarkersCannotBeNamed) {
  Render("--still");
  Done("lake-track human.mp4 --no-overlay --quiet -o right");
  const motion::MarkerRecording right = motion::ReadMarkerCsv(folder_ / "right/tracks.csv");
  const auto seed = [&](const char* name, const char* at) {
    const Eigen::Vector2d place = right.Find(at)->samples.front().position;
    return fmt::format(" --seed {}={:.1f},{:.1f}", name, place.x(), place.y());
  };
  const std::string track = "lake-track human.mp4 --no-overlay --quiet";
  Refused(track + " -o D" + seed("hip", "knee") + seed("knee", "hip"), 1, "D/candidates.png shows what was found");
  EXPECT_EQ(ReadTextFile(folder_ / "D/candidates.png").substr(1, 3), "PNG");
  EXPECT_THAT(ReadTextFile(folder_ / "D/candidates.csv"),
              testing::StartsWith("id,frame,x_px,y_px,radius_px,first_frame,last_frame,moves\n1,"));
  for (const char* name : {"D/tracks.csv", "D/kinematics.csv", "D/track.png"}) EXPECT_FALSE(Has(name)) << name;

  Done(track + " --list -o list");
  EXPECT_EQ(ReadTextFile(folder_ / "list/candidates.csv"), ReadTextFile(folder_ / "D/candidates.csv"));
  const CsvTable list = CsvTable::Read(folder_ / "list/candidates.csv");
  std::string numbers;
  for (std::size_t row = 0; row < list.Rows(); ++row)
    for (const motion::MarkerTrack& marker : right.markers) {
      const auto frame = static_cast<std::size_t>(list.RequiredNumber(row, list.Column("frame")));
      const Eigen::Vector2d place(list.RequiredNumber(row, list.Column("x_px")),
                                  list.RequiredNumber(row, list.Column("y_px")));
      if ((marker.samples[frame].position - place).norm() < 1)
        numbers += fmt::format(" --seed {}=#{}", marker.name, list.Text(row, list.Column("id")));
    }
  Done(track + " -o numbered" + numbers);
  EXPECT_EQ(ReadTextFile(folder_ / "numbered/tracks.csv"), ReadTextFile(folder_ / "right/tracks.csv"));
  Refused(track + " -o none --seed knee=#77", 1, "--seed knee=#77");
  Refused(track + " -o none --seed knee=#0", 2, "#N");
}

TEST_F(Folders, AreConvertedAsTheirTables) {
  Render();
  Done("lake-track human.mp4 --no-overlay --quiet -o D --camera good/camera.yaml");
  ASSERT_TRUE(Has("D/trajectory.csv"));
  Done("lake-convert D folder.trk && lake-convert D/tracks.csv table.trk && cmp folder.trk table.trk");
  Done("lake-convert D folder.kva && lake-convert D folder.mot && lake-convert D/kinematics.csv table.mot");
  EXPECT_EQ(ReadTextFile(folder_ / "folder.mot").substr(20), ReadTextFile(folder_ / "table.mot").substr(20));
}

TEST_F(Folders, AreFoundFromWithinAndByAnyName) {
  Render();
  Done("mkdir frames && ffmpeg -v error -nostdin -i human.mp4 -start_number 0 frames/%05d.png");
  const Json inside = Json::parse(
      Done("cd frames && lake-track %05d.png --capture-rate 30 --no-overlay --quiet --json -o ../inside").out);
  EXPECT_EQ(inside["inputs"][0]["path"], ".");
  // Pictures have no times of their own: whoever wants times has to give the rate.
  const char* programs[] = {"track", "check", "review", "anonymise --trial inside"};
  for (const std::string program : programs)
    Refused(fmt::format("lake {} frames/%05d.png", program), 1, "--capture-rate HZ");
  const Json check = Json::parse(Done("lake-check frames/%05d.png --capture-rate 60 --quiet --json").out);
  EXPECT_EQ(check["video"]["frame_rate_hz"], 60);
  EXPECT_EQ(check["figures"]["frames_in_file"], inside["video"]["frames"]);
  Done("lake-anonymise frames/%05d.png --trial inside --capture-rate 30 --quiet");
  // A name in Latin-1, and one that looks like a pattern.
  Done("cp human.mp4 $(printf 'Stra\\337e.mp4') && mkdir '50%[a]' && cp human.mp4 '50%[a]/human.mp4'");
  const Outcome latin = Done("lake-track $(printf 'Stra\\337e.mp4') --no-overlay --quiet --json -o latin");
  EXPECT_THAT(Json::parse(latin.out)["inputs"][0]["path"].get<std::string>(), HasSubstr("Stra"));
  Done("lake-track '50%[a]/human.mp4' --no-overlay --quiet -o percent");
}

// The lengths of Tracker's tables are in whatever unit the user chose there.
TEST_F(Folders, WithTablesInMetresAreAskedAbout) {
  Render("--repetitions 2");
  Done("lake-track human.mp4 --no-overlay --quiet -o D --camera good/camera.yaml && lake-convert D mm.txt");
  Done("awk -F'\\t' -v OFS='\\t' 'NR>3{for(i=2;i<=NF;++i) if($i!=\"\") $i=$i/1000}1' mm.txt > m.txt");
  const std::string compare = "lake-compare mm.txt m.txt --exo-knee knee -o ";
  for (const std::string& program : {compare + "C", std::string("lake-gait m.txt --quiet -o G"),
                                     std::string("lake-optimize --human m.txt --max-misalignment 20 --starts 1 -o O")})
    Refused(program, 1, "is the file in another unit? Give it with --unit");
  // Names that say mm over lengths in whole thousandths of a metre, which are as noise to a fit.
  Done(
      "awk -F, -v OFS=, 'NR==1{for(i=1;i<=NF;++i) mm[i]=$i~/_mm$/} "
      "NR>1{for(i=1;i<=NF;++i) if(mm[i] && $i!=\"\") $i=sprintf(\"%.3f\",$i/1000)}1' D/trajectory.csv > m.csv");
  Refused("lake-gait m.csv --quiet -o G", 1, "It says mm, and the lengths look like m: write them in mm");
  const Outcome right = Done(compare + "C2 --exo-unit m --json");
  // Of a folder that says itself what its markers are, this would be passed over.
  Refused("lake-gait D --unit m -o G", 2, "--unit has no effect on D");
  Refused("lake-gait mm.txt --up z -o G", 2, "--up has no effect on mm.txt");
  Refused("lake-loads D --mass 70 --leg left -o L", 2, "--leg has no effect without --forces");
  Refused("lake-compare D D --unit m -o C", 2, "--unit has no effect on D");
  Refused("lake-compare D mm.txt --map knee=hip --exo-map knee=knee -o C", 2, "--map has no effect on D");
  Refused("lake-compare mm.txt D --exo-map knee=hip -o C", 2, "--exo-map has no effect on D");
  Refused("lake-compare D D --smoothed -o C", 2, "--smoothed has no effect on D");
  Refused("lake-optimize --human D --unit m --max-misalignment 20 -o O", 2, "--unit has no effect on D");
  Refused("lake-info D --rate 60", 2, "--rate has no effect on D");
  EXPECT_FALSE(Has("G") || Has("L") || Has("C"));
  EXPECT_LT(Json::parse(right.out)["metrics"]["rms_mm"].get<double>(), 0.01);  // the digits that awk keeps
}

// A file of the user's that has a result's name is found before the work, not when its turn comes.
TEST_F(Folders, WithAFileInTheWayAreRefusedBeforeTheWork) {
  fs::create_directories(folder_ / "S");
  fs::create_directories(folder_ / "O");
  WriteTextFile(folder_ / "S/design.dxf", "mine");
  WriteTextFile(folder_ / "O/margin.png", "mine");
  for (const char* program : {"lake-simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 -o S",
                              "lake-optimize --starts 1 --quiet -o O"})
    Refused(program, 1, "would be overwritten");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "S"), {}), 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "O"), {}), 1);
}

TEST_F(Folders, AreLeftAtOnceWhenAFigureIsInterrupted) {
  // A gnuplot that takes its time, in the foreground group as on a terminal: the signal reaches the whole group.
  WriteTextFile(folder_ / "gnuplot", "#!/bin/sh\ntrap 'exit 3' INT\ntouch drawing\nsleep 20\n");
  fs::permissions(folder_ / "gnuplot", fs::perms::owner_all);
  const Outcome outcome = Shell(
      folder_,
      "bash -c 'set -m; PATH=$PWD:$PATH lake-simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 --quiet -o D "
      "& until [ -e drawing ] || ! kill -0 $!; do sleep 0.02; done; kill -INT -- -$!; wait $! 2>&-'");
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_TRUE(outcome.err.ends_with("lake-simulate: interrupted\n")) << outcome.err;
  EXPECT_FALSE(Has("D/summary.json"));
}

}  // namespace
}  // namespace lake
