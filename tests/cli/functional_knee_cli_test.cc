// lake-compare --knee functional on a rise whose knee is known, where the knee's markers are not on it.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>

#include "cli/program_run.h"
#include "compare/closed_form.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/core/statistics.h"
#include "page_text.h"
#include "places.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

// Of the knee's marker and the exoskeleton's joint, shank's frame.
const Vector2d kMarkerOff(14, 9), kJointOff(22, -12);
const std::string kSegments = "--segment shank=s1,s2 --segment thigh=t1,t2 ";

class FunctionalKnee : public testing::Test {
 protected:
  // A second of rest, a rise of two, a second of rest, at 100 Hz, errors of 0.02 mm. `joint`: the name of the
  // exoskeleton's marker; empty: none. `with_parts`: markers on the exoskeleton's parts too, e1, e2 and f1, f2.
  void Write(const std::string& file, const std::string& joint, bool with_clusters = true,
             bool with_parts = false) const {
    std::ofstream csv(folder_ / file);
    std::vector<std::string> names{"ankle", "knee", "hip", "waist"};
    if (with_clusters) names.insert(names.end(), {"s1", "s2", "t1", "t2"});
    if (!joint.empty()) names.push_back(joint);
    if (with_parts) names.insert(names.end(), {"e1", "e2", "f1", "f2"});
    csv << "frame,time_s";
    for (const std::string& name : names) csv << "," << name << "_x_mm," << name << "_y_mm";
    csv << "\n";
    for (int i = 0; i <= 400; ++i) {
      compare::StsCurve at;
      AppendPose({}, std::clamp((i - 100) / 200.0, 0.0, 1.0), at);
      const Vector2d ankle = at.ankle[0], knee = at.knee[0], hip = at.hip[0];
      const Eigen::Matrix2d shank = compare::AxesAlong(knee - ankle), thigh = compare::AxesAlong(hip - knee);
      std::vector<Vector2d> places{ankle, knee + shank * kMarkerOff, hip, hip + Vector2d(60 - 0.1 * i, 200)};
      if (with_clusters) {
        for (const Vector2d& place : {Vector2d(-30, -280), Vector2d(25, -120)}) places.push_back(knee + shank * place);
        for (const Vector2d& place : {Vector2d(30, 110), Vector2d(-20, 290)}) places.push_back(knee + thigh * place);
      }
      const Vector2d hinge = knee + shank * kJointOff;
      if (!joint.empty()) places.push_back(hinge);
      if (with_parts) {
        for (const Vector2d& place : {Vector2d(-20, -190), Vector2d(20, -70)}) places.push_back(hinge + shank * place);
        for (const Vector2d& place : {Vector2d(20, 80), Vector2d(-20, 200)}) places.push_back(hinge + thigh * place);
      }
      csv << i << "," << 0.01 * i;
      for (std::size_t m = 0; m < places.size(); ++m)
        csv << "," << places[m].x() + 0.02 * std::sin(7.3 * i + 2.0 * static_cast<double>(m)) << ","
            << places[m].y() + 0.02 * std::sin(5.1 * i + 3.0 * static_cast<double>(m));
      csv << "\n";
    }
  }

  Json Compared(const std::string& words) const {
    return DoneJson(folder_, "lake-compare human.csv exo.csv " + words + " -o C --quiet --json");
  }

  TemporaryFolder folder_;
};

// Against the knee itself the joint is where it was put; against the marker it is off by the marker's own place. The
// budget has the axis instead of the marker's placement, and its interval holds the truth.
TEST_F(FunctionalKnee, TheJointIsAgainstTheAxisNotTheMarker) {
  Write("human.csv", "");
  Write("exo.csv", "exo_knee");
  const Json marker = Compared("--knee marker")["joint"];
  EXPECT_NEAR(marker["offset_mm"][0].get<double>(), kJointOff.x() - kMarkerOff.x(), 1.5);
  const Json compared = Compared("--knee functional " + kSegments), joint = compared["joint"];
  EXPECT_NEAR(joint["offset_mm"][0].get<double>(), kJointOff.x(), 0.5);
  EXPECT_NEAR(joint["offset_mm"][1].get<double>(), kJointOff.y(), 0.5);
  EXPECT_EQ(compared["knee_from"], "functional");
  for (const char* trial : {"human", "exo"}) EXPECT_LT(compared["knee_axis_sd_mm"][trial].get<double>(), 0.5);
  const Json x = Compared("--knee functional --soft-tissue 0 " + kSegments)["uncertainty"]["joint_offset_x_mm"];
  EXPECT_LT(x["anatomical_interval"][0].get<double>(), kJointOff.x());
  EXPECT_GT(x["anatomical_interval"][1].get<double>(), kJointOff.x());
  const Json with_marker = Compared("--soft-tissue 0")["uncertainty"]["joint_offset_x_mm"];
  EXPECT_LT(x["anatomical_sd"].get<double>(), 0.6 * with_marker["anatomical_sd"].get<double>());
}

// The human's knee is its axis too, with its own angle and lengths; also where another marker is compared, and a marker
// `knee`, which then is not the leg's either, stands beside it.
TEST_F(FunctionalKnee, TheLegBendsAtTheAxis) {
  Write("exo.csv", "exo_knee");
  const ClosedFormLeg leg;
  for (const auto& [beside, words] : {std::pair{"", ""}, std::pair{"patella", "--human-knee patella "}}) {
    Write("human.csv", beside);
    EXPECT_EQ(Compared(words + ("--knee functional " + kSegments))["knee_from"], "functional");
    const Json curves = ReadJsonFile(folder_ / "C/comparison.json")["curves"];
    EXPECT_NEAR(curves["human_knee_deg"].front().get<double>(), leg.seated_knee_deg, 0.3) << beside;
    EXPECT_NEAR(curves["human_knee_deg"].back().get<double>(), leg.standing_knee_deg, 0.5) << beside;
    EXPECT_NEAR(curves["shank_mm"].front().get<double>(), leg.shank_mm, 0.5) << beside;
  }
}

// An exoskeleton trial's `knee` alone is the joint's: the person's axis is not put over it.
TEST_F(FunctionalKnee, AJointWithoutMarkerOfItsOwnIsTheAxisOfItsParts) {
  Write("human.csv", "");
  Write("exo.csv", "", true, true);
  const std::string words = "--knee functional " + kSegments;
  const Outcome refused = ExpectRefused(folder_, "lake-compare human.csv exo.csv " + words + "-o C", 2,
                                        "exo.csv shows no joint of the exoskeleton");
  EXPECT_THAT(refused.err, HasSubstr("--exo-segment shank=A,B"));
  const Json joint = Compared(words + "--exo-segment shank=e1,e2 --exo-segment thigh=f1,f2")["joint"];
  EXPECT_NEAR(joint["offset_mm"][0].get<double>(), kJointOff.x(), 0.5);
  EXPECT_NEAR(joint["offset_mm"][1].get<double>(), kJointOff.y(), 0.5);
}

TEST_F(FunctionalKnee, AComparisonsHumanKneeStaysWhatItWas) {
  Write("human.csv", "");
  Write("exo.csv", "exo_knee");
  const auto again = [&](const std::string& words) {
    return DoneJson(folder_, "lake-compare C exo.csv -o D --quiet --json " + words)["knee_from"];
  };
  const Json sd_mm = Compared("--knee functional " + kSegments)["knee_axis_sd_mm"]["human"];
  EXPECT_EQ(again(""), "functional");
  EXPECT_EQ(ReadJsonFile(folder_ / "D/comparison.json")["knee_axis_sd_mm"]["human"], sd_mm);
  // A file of before that was written.
  Json before = ReadJsonFile(folder_ / "C/comparison.json");
  before.erase("knee_axis_sd_mm");
  WriteJsonFile(folder_ / "C/comparison.json", before);
  EXPECT_THAT(Done(folder_, "lake-compare C exo.csv -o E --quiet").err,
              HasSubstr("how precise its functional knee is"));
  Compared("--knee marker");
  EXPECT_EQ(again("--knee functional " + kSegments), "marker");
}

TEST_F(FunctionalKnee, WhereATrialHasNoSegmentsItsMarkerIsTakenAndThatIsSaid) {
  Write("human.csv", "", false);
  Write("exo.csv", "exo_knee");
  const std::string words = " --knee functional " + kSegments, compare = "lake-compare human.csv exo.csv" + words;
  EXPECT_THAT(Done(folder_, compare + "-o C").err,
              HasSubstr("human.csv: it has none of the markers s1, s2, t1, t2: its marker knee is taken"));
  EXPECT_EQ(ReadJsonFile(folder_ / "C/comparison.json")["knee_from"], "marker");
  ExpectRefused(folder_, "lake-optimize --human human.csv" + words + "-o O", 2,
                "human.csv has no markers of --segment");
  Write("exo.csv", "exo_knee", false);
  ExpectRefused(folder_, compare + "-o D", 2, "no trial has markers of --segment");
}

// Optical rises in space, skin markers: from the ankle to the axis is nearly one length (2.2 mm SD measured), to the
// knee's marker it is not (10.6 mm).
TEST_F(FunctionalKnee, OnARealLegTheShankKeepsItsLength) {
  const std::filesystem::path trial = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::exists(trial)) GTEST_SKIP() << trial << " is absent";
  const auto variation_mm = [&](const std::string& words) {
    Done(folder_, fmt::format("lake-compare {0} {0} --map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=R_Shoulder "
                              "--exo-knee knee {1} -o R --quiet",
                              Quoted(trial), words));
    return StandardDeviation(NumbersOrNaN(ReadJsonFile(folder_ / "R/comparison.json")["curves"]["shank_mm"]));
  };
  // Nobody wears an exoskeleton: its joint is the knee.
  const double of_axis_mm = variation_mm(fmt::format(
      "--knee functional --segment {0} --segment {1} --exo-segment {0} --exo-segment {1}",
      "shank=r_shank_antsup,r_sh2,r_sh3,r_sh4,r_ankle", "thigh=r_thigh1,r_thigh2,r_thigh3,r_thigh4,r_thigh5"));
  EXPECT_LT(of_axis_mm, 3);
  EXPECT_GT(variation_mm(""), 3 * of_axis_mm);
}

// Markers on skin: the interval of the misalignment goes as far as skin markers stray from bone (13.0 mm in walking:
// Benoit et al. 2006), that of the markers does not; each source has its row; what would narrow it is said; and so are
// the forces at the cuffs, worn and moved, each with an interval.
TEST_F(FunctionalKnee, TheReportHasBudgetAndCuffForcesWithIntervals) {
  Write("human.csv", "");
  Write("exo.csv", "exo_knee");
  const Json compared = Compared(""), rms = compared["uncertainty"]["joint_rms_mm"];
  const auto half_mm = [&](const char* interval) {
    return rms[interval][1].get<double>() - rms["value"].get<double>();
  };
  EXPECT_GT(half_mm("anatomical_interval"), 13);
  EXPECT_LT(half_mm("marker_interval"), 3);
  const std::string report = ReadPageText(folder_ / "C/report.html");
  const Json& all_sources = rms["anatomical_interval"];
  EXPECT_THAT(report, HasSubstr(fmt::format("95 %, all sources: {:.0f} to {:.0f} mm", all_sources[0].get<double>(),
                                            all_sources[1].get<double>())));
  for (const char* source : {"detection", "lens and plane", "out-of-plane movement and parallax", "event times",
                             "marker placement", "soft tissue", "soft tissue in a single frame"})
    EXPECT_THAT(report, HasSubstr(source));
  EXPECT_THAT(report, HasSubstr(rms["narrower"].get<std::string>()));
  EXPECT_THAT(
      rms["narrower"].get<std::string>(),
      testing::AllOf(HasSubstr("two or more markers on shank and thigh"),
                     HasSubstr("leave the same markers on between the trials"), HasSubstr("record more repetitions")));
  EXPECT_THAT(report, HasSubstr("Joint misalignment over the rise"));
  for (const char* joint : {"worn", "moved"})
    for (const char* force : {"thigh_cuff", "shank_cuff", "knee_shear"}) {
      const Json& cuffs = compared["cuffs"][joint];
      const Json& interval = cuffs[fmt::format("{}_interval_n", force)];
      EXPECT_THAT(report,
                  HasSubstr(fmt::format("{:.1f} ({:.1f} to {:.1f})", cuffs[fmt::format("{}_n", force)].get<double>(),
                                        interval[0].get<double>(), interval[1].get<double>())))
          << joint << " " << force;
    }
}

// Five optical rises of both legs, by a marker at each joint, against the flexion of a skeletal model that was fitted
// to all markers: its single frames and its mean are within the interval of the joint beneath the skin (96 % and both
// measured), of which that of the markers is a tenth.
TEST_F(FunctionalKnee, TheBandOfTheKneeAngleHoldsASkeletalModels) {
  const std::filesystem::path data = SharedData() / "opencap_sts";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is absent";
  const Json bodies = ReadJsonFile(data / "sts_default_opensim_bodies.json").at("bodies");
  const auto turn = [&](const std::string& body, std::size_t frame) {
    const Json& angles = bodies.at(body).at("rotation").at(frame);
    const auto about = [&](std::size_t k) {
      return Eigen::AngleAxisd(angles.at(k).get<double>(), Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)));
    };
    return Eigen::Matrix3d(about(0) * about(1) * about(2));
  };
  double frames = 0, held = 0;
  for (const auto& [side, model] : {std::pair("R", "r"), std::pair("L", "l")}) {
    const std::string marker = side == std::string("R") ? "r" : "L";
    const Json summary = DoneJson(
        folder_, fmt::format("lake-gait {0} --map ankle={1}_ankle,knee={1}_knee,hip={2}_HJC,waist={2}_Shoulder -o {2} "
                             "--quiet --json",
                             Quoted(data / "sts_default_markers.trc"), marker, side));
    const Json& angle = summary["uncertainty"]["knee_angle_deg"];
    const double anatomical_deg = angle["anatomical_sd"].get<double>();
    EXPECT_LT(angle["marker_sd"].get<double>(), 0.2 * anatomical_deg);
    const CsvTable kinematics = CsvTable::Read(folder_ / side / "kinematics.csv");
    std::vector<double> off_deg;
    for (std::size_t row = 0; row < kinematics.Rows(); ++row) {
      const Eigen::Matrix3d knee =
          turn(fmt::format("femur_{}", model), row).transpose() * turn(fmt::format("tibia_{}", model), row);
      off_deg.push_back(kinematics.RequiredNumber(row, kinematics.Column("knee_deg")) +
                        std::atan2(knee(1, 0), knee(0, 0)) * 180 / M_PI);
      held += std::abs(off_deg.back()) < 1.96 * anatomical_deg, ++frames;
    }
    EXPECT_LT(std::abs(Mean(off_deg)), 1.96 * anatomical_deg) << side;
  }
  EXPECT_GE(held, 0.9 * frames);
  RecordProperty("held", std::to_string(held / frames));
}

TEST_F(FunctionalKnee, WrongUseIsToldAndTheRedesignTakesWhatTheComparisonHas) {
  Write("human.csv", "");
  Write("exo.csv", "exo_knee");
  for (const auto& [words, message] :
       {std::pair{"--knee functional", "--segment shank=A,B"},
        std::pair{"--segment shank=s1,s2", "thigh=MARKER,MARKER"},
        std::pair{"--segment shank=s1,s2 --segment thigh=t1,t2", "for --knee functional"}})
    ExpectRefused(folder_, std::string("lake-compare human.csv exo.csv -o C ") + words, 2, message);
  Compared("--knee marker");
  const std::pair<std::string, const char*> kRefused[] = {
      {"", "run lake-compare with --knee functional"},
      {kSegments, "--segment is for --human"},
      {"--exo-segment shank=e1,e2 --exo-segment thigh=f1,f2", "--exo-segment belongs to lake-compare"}};
  for (const auto& [words, message] : kRefused)
    ExpectRefused(folder_, "lake-optimize --comparison C --human-only --knee functional -o O " + words, 2, message);
}

}  // namespace
}  // namespace lake
