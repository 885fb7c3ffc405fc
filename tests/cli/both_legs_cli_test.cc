// Both legs of a person, and other measures of its markers, by the programs.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kRight = "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=R_Shoulder",
                  kLeft = "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L_Shoulder";

class BothLegs : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(trial_)) GTEST_SKIP() << trial_.string() << " is not here";
  }
  static std::string Symmetry(const std::string& trials) {
    return fmt::format("lake-symmetry {} --map {} --right-map {} --forward x --quiet --json -o S ", trials, kLeft,
                       kRight);
  }

  fs::path trial_ = SharedData() / "opencap_sts/sts_default_markers.trc";
  TemporaryFolder folder_;
};

TEST_F(BothLegs, AreComparedRiseByRise) {
  const Json summary = DoneJson(folder_, Symmetry(Quoted(trial_)));
  EXPECT_EQ(summary["matched"], true);
  EXPECT_GE(summary["left_rises"], 4);
  // In space the left knee bends to 96.1 degrees and the right one to 93.4 (the recording's description).
  const Json& knee = summary["symmetry"]["knee_max_deg"];
  EXPECT_NEAR(knee["difference"], 96.14 - 93.41, 1);
  EXPECT_LT(knee["interval"][0], knee["difference"]);
  const CsvTable curve = CsvTable::Read(folder_ / "S/symmetry_curve.csv");
  EXPECT_EQ(curve.Rows(), 101u);
  for (const char* name : {"S/symmetry.csv", "S/symmetry.png"}) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_THAT(ReadTextFile(folder_ / "S/symmetry.svg"), testing::HasSubstr("largest knee angle (°)"));
}

// Of the legs of one person, whose knees bend alike within what 3 mm of a marker are, every interval holds zero; of the
// legs of two people, whose thighs are unlike, not all do.
TEST_F(BothLegs, OfOnePersonAreSymmetricAndOfTwoPeopleAreNot) {
  const std::string one = Quoted(trial_), other = Quoted(SharedData() / "sts_force_plates/STS1.trc");
  for (const std::string& trial : {one, other}) {
    const Json same = DoneJson(folder_, Symmetry(trial + " " + trial));
    EXPECT_EQ(same["asymmetric"], false) << trial;
    for (const auto& [name, difference] : same["symmetry"].items())
      EXPECT_TRUE(difference["interval"][0] < 0 && difference["interval"][1] > 0) << trial << name;
  }
  const Json unlike = DoneJson(folder_, Symmetry(other + " " + one));
  EXPECT_EQ(unlike["asymmetric"], true);
  EXPECT_LT(unlike["symmetry"]["hip_rise_mm"]["interval"][1], 0);
  EXPECT_EQ(unlike["matched"], false);
}

// A person on two plates rests on the left leg a little more while rising: 253 N against 280 on average, read from the
// table of forces at the times of the right leg's events. Five rises do not tell that from none: among twelve
// quantities Student's t of four degrees of freedom is 5.9, and the interval, −3 to 57 N, just holds zero.
TEST_F(BothLegs, BearUnequalLoads) {
  const fs::path folder = SharedData() / "sts_force_plates";
  const std::string both = Symmetry(Quoted(folder / "STS1.trc")),
                    legs = both + fmt::format("--forces {} ", Quoted(folder / "STS1_grf.mot"));
  const Json summary = DoneJson(folder_, legs + "--plates right=1,left=2"), &mean = summary["symmetry"]["load_mean_n"],
             &largest = summary["symmetry"]["load_max_n"];
  EXPECT_NEAR(mean["left"], 280, 3);  // the events of both legs are 10 ms apart
  EXPECT_NEAR(mean["right"], 253, 3);
  // ± hypot(5.885 × 4.74, 2.865 × 3.79) about 27 N: the rises' SD of their mean, and 1 % of both plates. 1.5 N are 5 %
  // of it.
  EXPECT_NEAR(mean["interval"][0], -3, 1.5);
  EXPECT_NEAR(mean["interval"][1], 57, 1.5);
  EXPECT_NEAR(largest["difference"], -5.5, 0.5);
  EXPECT_LT(largest["interval"][0], 0);
  EXPECT_GT(largest["interval"][1], 0);
  EXPECT_THAT(Done(folder_, legs + "--plates right=2,left=1").err, HasSubstr("are the plates swapped?"));
  ExpectRefused(folder_, legs, 1, "say which is the left foot's, as --plates left=1");
  WriteTextFile(folder_ / "one.mot",
                "forces\nversion=1\nnRows=2\nnColumns=7\ninDegrees=no\nendheader\n"
                "time\tboth_vx\tboth_vy\tboth_vz\tboth_px\tboth_py\tboth_pz\n"
                "0\t0\t500\t0\t0\t0\t0\n15\t0\t500\t0\t0\t0\t0\n");
  ExpectRefused(folder_, both + "--forces one.mot", 1, "both is the only plate that bears a force");
  WriteTextFile(folder_ / "sync.yaml", "offset_s: 60\n");
  ExpectRefused(folder_, legs + "--plates right=1,left=2 --sync sync.yaml", 1, "the forces of 0 of the 5 rises");
}

TEST_F(BothLegs, AnyMarkersAreMeasuredBesideALegAndWithoutOne) {
  const std::string elbow = "--angle elbow=shoulder,elbow,wrist --speed hand=wrist",
                    arm = "shoulder=R_Shoulder,elbow=R_elbow_lat,wrist=R_wrist_radius";
  const auto gait = [&](const std::string& map) {
    return fmt::format("lake-gait {} --map {} --forward x {} --quiet -o G", Quoted(trial_), map, elbow);
  };
  const Outcome both = Done(folder_, gait(kRight + "," + arm));
  EXPECT_TRUE(fs::exists(folder_ / "G/kinematics.csv"));
  const CsvTable table = CsvTable::Read(folder_ / "G/measures.csv");
  EXPECT_TRUE(table.Has("elbow_sd_deg_s") && table.Has("hand_mm_s"));
  EXPECT_EQ(table.Rows(), 861u);
  // Whoever measures an arm alone has asked for no leg, and is not told that there is none.
  const Outcome alone = Done(folder_, gait(arm));
  EXPECT_THAT(alone.err, testing::Not(HasSubstr("leg")));
  for (const Outcome& outcome : {both, alone}) {
    EXPECT_THAT(outcome.out, testing::ContainsRegex("elbow  [0-9.]+ to [0-9.]+°, mean [0-9.]+\n"));
    EXPECT_THAT(outcome.out, testing::ContainsRegex("hand  [0-9.]+ to [0-9.]+ mm/s, mean [0-9.]+\n"));
  }
  ExpectRefused(folder_, gait(kRight), 2, "'elbow': there is no marker 'shoulder'");
}

// The markers of the far leg are in the picture too, beside and behind those of the near one.
class FarLeg : public BothLegs {
 protected:
  FarLeg() { trial_ = SharedData() / "sts_force_plates/STS1.trc"; }

  double Truth(const CsvTable& truth, std::size_t row, const std::string& marker, const char* axis) {
    return truth.RequiredNumber(row, truth.Column(fmt::format("{}_{}_px", marker, axis)));
  }

  void ExpectNearLeg() {
    const CsvTable truth = CsvTable::Read(folder_ / "film/truth.csv"),
                   tracks = CsvTable::Read(folder_ / "trial/tracks.csv");
    constexpr double kRadius_px = 4;  // of a marker: further off it is another's place
    for (const std::string marker : {"ankle", "knee", "hip", "waist"}) {
      int detected = 0, elsewhere = 0;
      for (std::size_t row = 0; row < tracks.Rows(); ++row) {
        if (tracks.Text(row, tracks.Column(marker + "_status")) != "detected") continue;
        ++detected;
        elsewhere += std::hypot(Truth(tracks, row, marker, "x") - Truth(truth, row, marker, "x"),
                                Truth(tracks, row, marker, "y") - Truth(truth, row, marker, "y")) > kRadius_px;
      }
      EXPECT_LE(elsewhere, 0.05 * detected) << marker;                           // streaks of both hips overlap
      EXPECT_GE(detected, 0.45 * static_cast<double>(tracks.Rows())) << marker;  // both hips overlap for half the film
    }
  }
};

TEST_F(FarLeg, IsNotTakenForTheNearOne) {
  const std::string track = "lake-track film/video.mp4 --camera film/camera.yaml --quiet -o trial";
  Done(folder_, fmt::format("lake-synth --motion {} --map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS "
                            "--extra-markers L_ankle,L_knee,L_HJC,L.ASIS --rate 30 --duration 5 --quiet -o film",
                            Quoted(trial_)));
  const Outcome alone = Shell(folder_, track);
  if (alone.exit_code == 0)
    ExpectNearLeg();
  else
    EXPECT_THAT(alone.err, HasSubstr("candidates.png shows what was found, numbered"));
  const CsvTable truth = CsvTable::Read(folder_ / "film/truth.csv");
  std::string seeds;
  for (const char* marker : {"ankle", "knee", "hip", "waist"})
    seeds +=
        fmt::format(" --seed {}={:.0f},{:.0f}@0", marker, Truth(truth, 0, marker, "x"), Truth(truth, 0, marker, "y"));
  Done(folder_, track + seeds);
  ExpectNearLeg();
}

TEST(SymmetryProgram, SaysWhatIsMissingAndWhereItWas) {
  const TemporaryFolder folder;
  ExpectRefused(folder, "lake-symmetry", 2, "left");
  ExpectRefused(folder, "lake-symmetry a b --plates left=1", 2, "--plates needs a file with the forces");
  ExpectRefused(folder, "lake-compare --left a --right b", 2, "lake symmetry LEFT RIGHT");
}

}  // namespace
}  // namespace lake
