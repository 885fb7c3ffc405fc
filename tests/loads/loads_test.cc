// lake-loads's work on the sit-to-stand with force plates, and on input that is wrong.
#include "lake/commands/loads.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <map>

#include "gait/synthetic_leg.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/core/statistics.h"
#include "lake/exchange/ground_forces.h"
#include "lake/gait/butterworth.h"
#include "lake/gait/leg_fit.h"
#include "lake/loads/loads.h"
#include "lake/problem/load_profile.h"
#include "message_of.h"
#include "name_map.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = SharedData() / "sts_force_plates";

#define REQUIRE_RECORDING() \
  if (!fs::exists(kFolder)) GTEST_SKIP() << kFolder.string() << " is not here"

commands::LoadsRunOptions OptionsFor(const std::string& side) {
  const bool right = side == "right";
  commands::LoadsRunOptions options;
  options.trial = kFolder / "STS1.trc";
  options.reading.names =
      NameMap(right ? "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS,shoulder=R_Shoulder"
                    : "ankle=L_ankle,knee=L_knee,hip=L_HJC,waist=L.ASIS+L.PSIS,shoulder=L_Shoulder");
  options.reading.forward = "+x";
  options.loads.body.mass_kg = 62.6;
  return options;
}

// With as many draws as what does not look at bands needs.
commands::LoadsRunOptions Quick(const std::string& side) {
  commands::LoadsRunOptions options = OptionsFor(side);
  options.loads.draws = 20;
  return options;
}

commands::LoadsRunOptions QuickOnPlates(const std::string& side) {
  commands::LoadsRunOptions options = Quick(side);
  options.forces = kFolder / "STS1_grf.mot";
  options.plates = {{"right", 1}, {"left", 2}};
  return options;
}

// The independent calculation of a knee's moment, from the same plates.
struct Reference {
  std::vector<double> time_s, knee_nm;

  explicit Reference(const std::string& side) {
    const CsvTable table = CsvTable::Read(kFolder / "reference_knee_moment.csv");
    const std::size_t column = table.Column(fmt::format("knee_extension_moment_{}_nm", side[0]));
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      time_s.push_back(table.RequiredNumber(row, table.Column("time_s")));
      knee_nm.push_back(table.RequiredNumber(row, column));
    }
  }
  double At(double at_s) const {
    const auto after = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), at_s) - time_s.begin()), 1,
        time_s.size() - 1);
    return std::lerp(knee_nm[after - 1], knee_nm[after],
                     (at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]));
  }
  double Peak(double from_s, double to_s) const {
    double peak = -1e9;
    for (std::size_t i = 0; i < time_s.size(); ++i)
      if (time_s[i] >= from_s && time_s[i] <= to_s) peak = std::max(peak, knee_nm[i]);
    return peak;
  }
};

struct Outcome {
  TemporaryFolder folder;
  Json summary;
  std::vector<std::string> warnings;
};

std::unique_ptr<Outcome> RunOn(const commands::LoadsRunOptions& options) {
  auto outcome = std::make_unique<Outcome>();
  Run run({"lake-loads", "", Json::object(), outcome->folder / "out", true});
  outcome->summary = commands::RunLoads(options, run);
  outcome->warnings = run.Warnings();
  return outcome;
}

// Differences from the reference where a rise's knee moment is given, and how often its band holds the reference.
struct Agreement {
  double rms_nm = 0, cover = 0;
  int count = 0;
};

Agreement Compare(const fs::path& table_file, const Reference& reference) {
  const CsvTable table = CsvTable::Read(table_file);
  Agreement agreement;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const auto knee_nm = table.Number(row, table.Column("knee_nm"));
    if (table.Text(row, table.Column("repetition")) == "mean" || !knee_nm) continue;
    const double true_nm = reference.At(table.RequiredNumber(row, table.Column("time_s")));
    agreement.rms_nm += std::pow(*knee_nm - true_nm, 2);
    agreement.cover += table.RequiredNumber(row, table.Column("knee_low_nm")) <= true_nm &&
                       true_nm <= table.RequiredNumber(row, table.Column("knee_high_nm"));
    ++agreement.count;
  }
  agreement.rms_nm = std::sqrt(agreement.rms_nm / agreement.count);
  agreement.cover /= agreement.count;
  return agreement;
}

// A quick rise throws the body over the feet; slowly along the same path it would fall back onto the seat.
TEST(Balance, ARiseByMomentumCannotBeSlow) {
  REQUIRE_RECORDING();
  for (const char* side : {"right", "left"}) {
    commands::LoadsRunOptions options = OptionsFor(side);
    options.loads.rise_s = 30;
    options.loads.draws = 100;
    const auto outcome = RunOn(options);
    const Json& balance = outcome->summary["balance"];
    // 8 to 70 mm behind the heel by an independent calculation of thirteen natural rises.
    EXPECT_LT(balance["slow"]["margin_mm"].get<double>(), -8) << side;
    EXPECT_GT(balance["slow"]["margin_mm"].get<double>(), -70) << side;
    EXPECT_GT(balance["own"]["margin_mm"].get<double>(), balance["slow"]["margin_mm"].get<double>() + 30) << side;
    // 30 s are slow: of accelerations a thousandth is left.
    EXPECT_NEAR(balance["asked"]["margin_mm"].get<double>(), balance["slow"]["margin_mm"].get<double>(), 1) << side;
    EXPECT_THAT(outcome->warnings, testing::Contains(testing::HasSubstr("in 30 s nobody keeps the balance"))) << side;
  }
}

// In the person's own time the moments are those of the rise: the means of both, percent by percent.
TEST(Balance, TheOwnPacesMomentsAreTheRises) {
  REQUIRE_RECORDING();
  const auto outcome = RunOn(Quick("right"));
  const CsvTable loads = CsvTable::Read(outcome->folder / "out/loads.csv"),
                 paces = CsvTable::Read(outcome->folder / "out/pace.csv");
  std::map<int, double> mean_nm;
  for (std::size_t row = 0; row < loads.Rows(); ++row)
    if (const auto knee_nm = loads.Number(row, loads.Column("knee_nm"));
        knee_nm && loads.Text(row, loads.Column("repetition")) == "mean")
      mean_nm[static_cast<int>(loads.RequiredNumber(row, loads.Column("percent")))] = *knee_nm;
  int compared = 0;
  for (std::size_t row = 0; row < paces.Rows(); ++row) {
    const int percent = static_cast<int>(paces.RequiredNumber(row, paces.Column("percent")));
    if (paces.Text(row, paces.Column("pace")) != "own" || !mean_nm.contains(percent)) continue;
    // Both tables' digits.
    EXPECT_NEAR(paces.RequiredNumber(row, paces.Column("knee_nm")), mean_nm.at(percent), 1e-3) << percent;
    ++compared;
  }
  EXPECT_GT(compared, 40);
}

// What is written of the body reads back, and the profile's moments at another pace are those of pace.csv.
TEST(Balance, TheProfileIsOfAnyPace) {
  REQUIRE_RECORDING();
  commands::LoadsRunOptions options = Quick("right");
  options.loads.rise_s = 3;
  const auto outcome = RunOn(options);
  const loads::BodyPath body = loads::ReadBodyPath(outcome->folder / "out");
  EXPECT_EQ(body.trunk.size(), 101u);
  EXPECT_GT(body.feet_from_percent, 10);
  EXPECT_LT(body.feet_from_percent, 70);
  EXPECT_NEAR(body.body.trunk.mass_kg, 0.678 * 62.6 / 2, 1e-6);
  const problem::LoadProfile profile = problem::ReadLoadProfile(outcome->folder / "out");
  const auto same = problem::AtPace(profile, profile.duration_s), asked = problem::AtPace(profile, 3);
  ASSERT_TRUE(same && asked);
  const CsvTable paces = CsvTable::Read(outcome->folder / "out/pace.csv");
  int compared = 0;
  for (std::size_t row = 0; row < paces.Rows(); ++row) {
    const auto percent = static_cast<std::size_t>(paces.RequiredNumber(row, paces.Column("percent")));
    if (paces.Text(row, paces.Column("pace")) != "asked" || std::isnan(profile.samples[percent].knee_nm)) continue;
    EXPECT_NEAR(same->samples[percent].knee_nm, profile.samples[percent].knee_nm, 1e-9);
    // What a thousand seconds leave of accelerations, and the tables' digits.
    EXPECT_NEAR(asked->samples[percent].knee_nm, paces.RequiredNumber(row, paces.Column("knee_nm")), 1e-3);
    ++compared;
  }
  EXPECT_GT(compared, 40);
}

// What both plates give the body on the feet alone is the change of its momentum, N s, forward and up.
TEST(CentreOfMass, ItsMomentumChangesByWhatThePlatesGive) {
  REQUIRE_RECORDING();
  const exchange::GroundForceRecording ground = exchange::ReadGroundForces(kFolder / "STS1_grf.mot");
  const auto impulse_ns = [&](double from_s, double to_s) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t i = 1; i < ground.time_s.size(); ++i)
      if (ground.time_s[i] > from_s && ground.time_s[i] <= to_s)
        sum += (ground.time_s[i] - ground.time_s[i - 1]) *
               (ground.plates[0].force_n[i] + ground.plates[1].force_n[i] - 62.6 * 9.80665 * Eigen::Vector3d::UnitY())
                   .head<2>();
    return sum;
  };
  for (const char* side : {"right", "left"}) {
    const auto outcome = RunOn(Quick(side));
    const CsvTable centre = CsvTable::Read(outcome->folder / "out/centre_of_mass.csv");
    ASSERT_EQ(centre.Rows(), 5u * 101);
    const auto at = [&](std::size_t row, const char* column) {
      return centre.RequiredNumber(row, centre.Column(column));
    };
    for (std::size_t rise = 0; rise < 5; ++rise) {
      const double left_s = outcome->summary["rises"][rise]["seat_off_s"].get<double>() + 0.1;
      const std::size_t standing = 101 * rise + 100;
      std::vector<double> forward_ns, upward_ns;  // the motion's less the plates', up to a constant
      for (std::size_t row = 101 * rise; row <= standing; ++row) {
        if (at(row, "time_s") < left_s) continue;
        const Eigen::Vector2d given = impulse_ns(at(row, "time_s"), at(standing, "time_s"));
        forward_ns.push_back(at(row, "com_forward_ns") + given.x());
        upward_ns.push_back(at(row, "com_upward_ns") + given.y());
      }
      // A tenth of the largest, 42 and 55 N s: arms swing and markers slide.
      EXPECT_LT(StandardDeviation(forward_ns), 4.2) << side << " " << rise;
      EXPECT_LT(StandardDeviation(upward_ns), 5.5) << side << " " << rise;
    }
    const Json& momentum = outcome->summary["momentum"];
    // Plates add nothing to what is of the motion alone.
    const auto with_plates = RunOn(QuickOnPlates(side));
    EXPECT_EQ(with_plates->summary["momentum"], momentum) << side;
    EXPECT_EQ(with_plates->summary["balance"]["own"], outcome->summary["balance"]["own"]) << side;
    const CsvTable table = CsvTable::Read(outcome->folder / "out/momentum.csv");
    for (std::size_t row = 0; row < 5; ++row) {
      const auto value = [&](const char* column) { return table.RequiredNumber(row, table.Column(column)); };
      EXPECT_NEAR(value("com_forward_max_ns"), 0.0626 * value("com_forward_max_mm_s"), 1e-9);
      EXPECT_LT(value("com_seat_off_mm"), -50);  // behind the heel: carried by momentum
      EXPECT_GT(value("com_seat_off_mm_sd"), 5);
      EXPECT_GT(value("com_forward_max_mm_s_sd"), 5);
      EXPECT_LT(std::abs(value("com_forward_lead_s")), 0.15);
    }
  }
}

class OnForcePlates : public testing::TestWithParam<std::string> {};

TEST_P(OnForcePlates, FromTheGroundItEqualsTheReferenceWithItsInertias) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  // Of 62.6 kg and a shank of 405 mm: 3.274 kg and 0.0488 kg m² of the shank, 1.542 kg of the foot.
  std::ofstream(folder / "body.yaml") << "source: the reference's\n"
                                         "foot: {mass: 0.02463, centre: 0.5, gyration: 0.475}\n"
                                         "shank: {mass: 0.0523, centre: 0.433, gyration: 0.3014}\n"
                                         "thigh: {mass: 0.1, centre: 0.433, gyration: 0.323}\n"
                                         "trunk: {mass: 0.646, centre: 0.626, gyration: 0.496}\n";
  commands::LoadsRunOptions options = OptionsFor(GetParam());
  options.loads.body.anthropometry = folder / "body.yaml";
  options.loads.body.foot_mm = std::array<double, 2>{62, 154};  // the markers of heel and toe
  options.forces = kFolder / "STS1_grf.mot";
  options.plates = {{"right", 1}, {"left", 2}};
  const auto outcome = RunOn(options);
  const Reference reference(GetParam());
  const Agreement agreement = Compare(outcome->folder / "out/loads.csv", reference);
  EXPECT_EQ(agreement.count, 505);
  EXPECT_LE(agreement.rms_nm, 1.5);  // 3 N m for both legs
  EXPECT_GE(agreement.cover, 0.95);
  ASSERT_EQ(outcome->summary["rises"].size(), 5u);
  for (const Json& rise : outcome->summary["rises"]) {
    const double peak_nm = reference.Peak(rise["seat_off_s"], rise["standing_s"]);
    EXPECT_NEAR(rise["peak"]["knee_nm"].get<double>(), peak_nm, 0.03 * peak_nm);
  }
  for (const std::string& warning : outcome->warnings)
    EXPECT_THAT(warning, testing::Not(testing::ContainsRegex("swapped|acts outside|bears|clock")));
}

std::vector<std::string> Fields(const std::string& line) {
  return SplitText(line, '\t');
}

// The trial with a marker on the medial side of the right knee, on an axis that is turned by 15° about the vertical
// from the plane's normal; and at each frame the moment about that axis, in space: the plate's force and the weights
// of shank and foot, N m, extension positive.
class MedialMarker {
 public:
  explicit MedialMarker(const fs::path& trc) {
    std::ifstream in(kFolder / "STS1.trc");
    std::ofstream out(trc);
    std::string line;
    for (int row = 0; std::getline(in, line); ++row) {
      while (!line.empty() && (line.back() == '\r' || line.back() == '\t')) line.pop_back();
      if (row == 2) line = "100\t100\t1399\t52\tm\t100\t0\t1399";
      if (row == 3) TakeNames(line), line += "\t\t\tr_knee_med";
      if (row == 4) line += "\tX52\tY52\tZ52";
      if (const std::vector<std::string> fields = Fields(line); row > 4 && fields.size() > 2) line += AddFrame(fields);
      out << line << '\n';
    }
  }

  double PeakBetween(double from_s, double to_s) const {
    double peak_nm = -1e9;
    const std::vector<double> smooth_nm = gait::ZeroPhaseButterworthAtTimes(moment_nm_, time_s_, 6);
    for (std::size_t i = 0; i < time_s_.size(); ++i)
      if (time_s_[i] >= from_s && time_s_[i] <= to_s) peak_nm = std::max(peak_nm, smooth_nm[i]);
    return peak_nm;
  }

 private:
  void TakeNames(const std::string& line) {
    const std::vector<std::string> names = Fields(line);
    for (std::size_t i = 2; i < names.size(); i += 3) column_[names[i]] = i;
  }

  std::string AddFrame(const std::vector<std::string>& fields) {
    const auto at = [&](const char* name) {
      const std::size_t i = column_.at(name);
      return Eigen::Vector3d(std::stod(fields[i]), std::stod(fields[i + 1]), std::stod(fields[i + 2]));
    };
    const double yaw = 15 * M_PI / 180;
    const Eigen::Vector3d axis(std::sin(yaw), 0, -std::cos(yaw));  // to the left: medial of the right knee
    const Eigen::Vector3d medial = at("r_knee") + 0.1 * axis, knee = at("r_knee") + 0.05 * axis, ankle = at("r_ankle");
    const std::size_t i = time_s_.size();
    const auto force = [&](char part) {
      const double* const first = &grf_[i * kColumns + (part == 'v' ? 1 : 4)];  // after the time
      return Eigen::Vector3d(first[0], first[1], first[2]);
    };
    // Winter's table of 62.6 kg: shank 0.0465, centre at 0.433 below the knee; foot 0.0145, under the ankle's front.
    const Eigen::Vector3d g(0, -9.80665, 0), shank = knee + 0.433 * (ankle - knee),
                                             foot = (at("r_calc") + at("r_toe")) / 2;
    Eigen::Vector3d moment = (force('p') - knee).cross(force('v'));
    moment += (shank - knee).cross(0.0465 * 62.6 * g) + (foot - knee).cross(0.0145 * 62.6 * g);
    time_s_.push_back(std::stod(fields[1]));
    moment_nm_.push_back(moment.dot(axis));
    return fmt::format("\t{}\t{}\t{}", medial.x(), medial.y(), medial.z());
  }

  std::map<std::string, std::size_t> column_;
  static constexpr std::size_t kColumns = 28;
  std::vector<double> grf_ = Forces();
  std::vector<double> time_s_, moment_nm_;

  static std::vector<double> Forces() {
    std::ifstream in(kFolder / "STS1_grf.mot");
    std::string line;
    while (std::getline(in, line) && !line.starts_with("time")) continue;
    std::vector<double> values;
    for (double value; in >> value;) values.push_back(value);
    return values;
  }
};

// With both markers of the knee the moment is that about its own axis, 15° off the plane in which the leg moves most.
TEST(LoadsAboutTheKneesAxis, AreThoseOfSpaceWhereMedialMarkersAreGiven) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  const MedialMarker truth(folder / "medial.trc");
  commands::LoadsRunOptions options = OptionsFor("right");
  options.trial = folder / "medial.trc";
  options.forces = kFolder / "STS1_grf.mot";
  options.plates = {{"right", 1}, {"left", 2}};
  const auto farthest = [&](const char* knee) {
    options.reading.names["knee"] = knee;
    const auto outcome = RunOn(options);
    EXPECT_EQ(outcome->summary["rises"].size(), 5u);
    double most = 0;
    for (const Json& rise : outcome->summary["rises"]) {
      const double true_nm = truth.PeakBetween(rise["seat_off_s"], rise["standing_s"]);
      most = std::max(most, std::abs(rise["peak"]["knee_nm"].get<double>() / true_nm - 1));
    }
    return most;
  };
  EXPECT_LE(farthest("r_knee+r_knee_med"), 0.08);
  EXPECT_GT(farthest("r_knee"), 0.08);
}

// Without the plates it is an estimate, and says how sure it is.
TEST_P(OnForcePlates, FromTheTrunkEachPeakIsInsideItsInterval) {
  REQUIRE_RECORDING();
  const auto outcome = RunOn(OptionsFor(GetParam()));
  const Reference reference(GetParam());
  const Agreement agreement = Compare(outcome->folder / "out/loads.csv", reference);
  EXPECT_GT(agreement.count, 250);
  EXPECT_LE(agreement.rms_nm, 15);
  EXPECT_GE(agreement.cover, 0.9);
  ASSERT_EQ(outcome->summary["rises"].size(), 5u);
  int near = 0;
  for (const Json& rise : outcome->summary["rises"]) {
    const double peak_nm = reference.Peak(rise["seat_off_s"], rise["standing_s"]);
    const Json& peak = rise["peak"];
    EXPECT_LE(peak["knee_nm_interval"][0].get<double>(), peak_nm);
    EXPECT_GE(peak["knee_nm_interval"][1].get<double>(), peak_nm);
    // Yoshioka 2007: 0.5 to 2.0 N m/kg.
    EXPECT_GE(peak["knee_nm_kg"].get<double>(), 0.5);
    EXPECT_LE(peak["knee_nm_kg"].get<double>(), 2.0);
    near += std::abs(peak["knee_nm"].get<double>() / peak_nm - 1) < 0.25;
  }
  EXPECT_GE(near, 4);  // of five; the left leg's first rise is read 43 % too low
}

// While the seat bears a part that nobody knows.
TEST_P(OnForcePlates, TheBoundsBeforeTheSeatIsLeftHoldTheReference) {
  REQUIRE_RECORDING();
  const auto outcome = RunOn(OptionsFor(GetParam()));
  const Reference reference(GetParam());
  const CsvTable table = CsvTable::Read(outcome->folder / "out/loads.csv");
  int held = 0, count = 0;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const auto low_nm = table.Number(row, table.Column("knee_low_nm"));
    if (table.Text(row, table.Column("repetition")) == "mean" || table.Number(row, table.Column("knee_nm")) || !low_nm)
      continue;
    const double true_nm = reference.At(table.RequiredNumber(row, table.Column("time_s")));
    held += *low_nm <= true_nm && true_nm <= table.RequiredNumber(row, table.Column("knee_high_nm"));
    ++count;
  }
  EXPECT_GT(count, 100);
  EXPECT_GE(held, 0.9 * count) << held << " of " << count;
}

INSTANTIATE_TEST_SUITE_P(, OnForcePlates, testing::Values("right", "left"),
                         [](const auto& info) { return info.param; });

TEST(LoadsTables, BeforeTheSeatIsLeftThereAreBoundsAndNoMoment) {
  REQUIRE_RECORDING();
  const auto outcome = RunOn(OptionsFor("right"));
  const CsvTable table = CsvTable::Read(outcome->folder / "out/loads.csv");
  EXPECT_THAT(table.Header(), testing::ElementsAre("repetition", "percent", "time_s", "knee_deg", "knee_deg_s",
                                                   "ankle_nm", "knee_nm", "hip_nm", "knee_sd_nm", "knee_low_nm",
                                                   "knee_high_nm", "zmp_mm", "ground_force_n", "knee_power_w"));
  ASSERT_EQ(table.Rows(), 6u * 101);
  int empty = 0;
  for (std::size_t row = 0; row < 101; ++row) {
    const double time_s = table.RequiredNumber(row, table.Column("time_s"));
    const bool known = table.Number(row, table.Column("knee_nm")).has_value();
    EXPECT_EQ(known, time_s >= outcome->summary["rises"][0]["seat_off_s"].get<double>() + 0.1);
    EXPECT_LE(table.RequiredNumber(row, table.Column("knee_low_nm")),
              table.RequiredNumber(row, table.Column("knee_high_nm")));
    empty += !known;
  }
  EXPECT_GT(empty, 20);
  const Json profile = ReadJsonFile(outcome->folder / "out/loads.json");
  EXPECT_EQ(profile["percent"].size(), 101u);
  EXPECT_EQ(profile["knee_nm"].size(), 101u);
  EXPECT_TRUE(profile["knee_nm"][0].is_null());
  EXPECT_TRUE(profile["knee_nm"][100].is_number());
}

// When a rise begins and ends is not known either: the bands over its percents hold that.
TEST(LoadsBands, HoldWhatIsNotKnownOfTheEvents) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1, .rest_s = 3});
  const gait::LegFitResult fit = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 1), ScaledView());
  loads::LegPathOptions path;
  path.facing = fit.motion.facing;
  path.up = fit.up;
  loads::LoadsOptions options;
  options.body.mass_kg = 70;
  options.draws = 60;
  const auto at = [&](double standing_sd_s, std::size_t percent) {
    std::vector<motion::StsEvent> events = fit.events;
    for (motion::StsEvent& event : events)
      event.sd_s = event.kind == motion::StsEventKind::kStanding ? standing_sd_s : 0;
    return loads::FindLoads(fit.trajectory, fit.motion, events, path, options, {}).rises.front().rows[percent];
  };
  constexpr std::size_t kSteep = 80;  // the moment falls there
  constexpr double kUnsure_s = 0.2;
  const loads::LoadsRow row = at(0, kSteep), before = at(0, kSteep - 1);
  const double per_s = (row.knee_nm - before.knee_nm) / (row.time_s - before.time_s);
  const double added_nm = std::sqrt(std::pow(at(kUnsure_s, kSteep).knee_sd_nm, 2) - std::pow(row.knee_sd_nm, 2));
  // The percent's time goes along with the end by 0.8; 60 draws, of a moment that does not fall evenly.
  EXPECT_NEAR(added_nm, 0.8 * kUnsure_s * std::abs(per_s), 0.4 * kUnsure_s * std::abs(per_s));
  EXPECT_EQ(at(NAN, kSteep).knee_sd_nm, row.knee_sd_nm) << "given by a person";
}

TEST(LoadsTables, TheSameSeedGivesTheSameBands) {
  REQUIRE_RECORDING();
  commands::LoadsRunOptions options = Quick("right");
  const Json first = RunOn(options)->summary, again = RunOn(options)->summary;
  EXPECT_EQ(first, again);
  options.loads.seed = 2;
  EXPECT_NE(first, RunOn(options)->summary);
}

std::string Failure(const commands::LoadsRunOptions& options) {
  return MessageOf([&] { RunOn(options); });
}

TEST(LoadsOfBadInput, SwappedPlatesAreWarnedOfWithNumbers) {
  REQUIRE_RECORDING();
  commands::LoadsRunOptions options = QuickOnPlates("right");
  options.plates = {{"right", 2}, {"left", 1}};
  EXPECT_THAT(RunOn(options)->warnings,
              testing::Contains(testing::AllOf(testing::HasSubstr("plates swapped"), testing::HasSubstr("343 mm"),
                                               testing::HasSubstr("43 mm:"))));
  options.plates = {{"right", 3}};
  EXPECT_THAT(Failure(options), testing::HasSubstr("bears no force"));
  options.plates.clear();
  EXPECT_THAT(Failure(options), testing::HasSubstr("--plates right=1"));
}

// The names of markers say the leg wherever the side stands in them: "lateral_ankle_r" is of the right one. Where none
// does, a warning says which leg it is taken for.
TEST(LoadsOfBadInput, TheLegIsTheOneThatTheMarkersNamesSay) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  const auto renamed = [&](const char* file, const std::string& ankle, const std::string& knee) {
    std::string text = ReadTextFile(kFolder / "STS1.trc");
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"\tr_ankle\t", ankle}, {"\tr_knee\t", knee}})
      text.replace(text.find(from), from.size(), "\t" + to + "\t");
    std::ofstream(folder / file) << text;
    commands::LoadsRunOptions options = QuickOnPlates("right");
    options.trial = folder / file;
    options.reading.names["ankle"] = ankle;
    options.reading.names["knee"] = knee;
    return options;
  };
  const auto expected = RunOn(QuickOnPlates("right"));
  const auto lateral = RunOn(renamed("lateral.trc", "lateral_ankle_r", "lateral_knee_r"));
  EXPECT_EQ(lateral->summary["peak_knee_nm"], expected->summary["peak_knee_nm"]);
  EXPECT_THAT(lateral->warnings, testing::Not(testing::Contains(testing::HasSubstr("plates swapped"))));
  const auto unnamed = RunOn(renamed("unnamed.trc", "lateral malleolus", "lateral condyle"));
  EXPECT_EQ(unnamed->summary["peak_knee_nm"], expected->summary["peak_knee_nm"]);
  EXPECT_THAT(unnamed->warnings, testing::Contains(testing::HasSubstr("say it with --leg")));
}

// The recording's forces with its numbers changed, column by column.
fs::path ForcesWith(const fs::path& file,
                    const std::function<double(const std::string& column, double value)>& change) {
  std::ifstream in(kFolder / "STS1_grf.mot");
  std::ofstream out(file);
  std::string line;
  while (std::getline(in, line) && !line.starts_with("time")) out << line << "\n";
  out << line << "\n";
  const std::vector<std::string> columns = SplitText(line, '\t');
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = SplitText(line, '\t');
    for (std::size_t i = 0; i < cells.size(); ++i)
      out << (i ? "\t" : "") << fmt::format("{}", change(columns[i], ParseNumber(cells[i]).value_or(0)));
    out << "\n";
  }
  return file;
}

TEST(LoadsOfBadInput, SwappedUnitsSignsAndPlatesAreErrors) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  commands::LoadsRunOptions options = QuickOnPlates("right");
  options.forces = ForcesWith(folder / "mm.mot", [](const std::string& column, double value) {
    return column.find("_p") == std::string::npos ? value : 1000 * value;
  });
  EXPECT_THAT(Failure(options),
              testing::AllOf(testing::ContainsRegex("the force acts 23[89]\\.[0-9] m behind the ankle"),
                             testing::HasSubstr("its points seem to be in mm")));
  options.forces = ForcesWith(folder / "elsewhere.mot", [](const std::string& column, double value) {
    return column.ends_with("px") ? value + 3 : value;
  });
  EXPECT_THAT(Failure(options), testing::HasSubstr("are the axes and the origin the markers' own"));
  options.forces = ForcesWith(folder / "down.mot", [](const std::string& column, double value) {
    return column.find("_v") == std::string::npos && column.find("_m") == std::string::npos ? value : -value;
  });
  EXPECT_THAT(Failure(options), testing::HasSubstr("the ground pulls the foot down, by 268 N"));
  const std::map<std::string, int> both_feet = {{"right", 1}, {"left", 1}};
  EXPECT_THAT(MessageOf<UsageError>([&] { exchange::CheckPlates(both_feet); }),
              testing::HasSubstr("a plate under both feet"));
}

// 0.15 s read 85 for 62 N m. The recording's own clock is off by less than 0.02 s, of either plate.
TEST(LoadsOfBadInput, SwappedClocksAreWarnedOfWithTheOffset) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  for (const char* side : {"right", "left"})
    for (const double late_s : {-0.25, 0.0, 0.05, 0.15}) {
      commands::LoadsRunOptions options = QuickOnPlates(side);
      options.forces = ForcesWith(folder / "late.mot", [&](const std::string& column, double value) {
        return column == "time" ? value + late_s : value;
      });
      const auto warnings = RunOn(options)->warnings;
      const auto clock = std::ranges::find_if(
          warnings, [](const std::string& warning) { return warning.find("clock") != std::string::npos; });
      ASSERT_EQ(clock != warnings.end(), late_s != 0) << side << " " << late_s;
      if (late_s == 0) continue;
      std::string told = clock->substr(clock->find("best with ") + 10);
      const std::string minus = "−";
      if (told.starts_with(minus)) told.replace(0, minus.size(), "-");
      double add_s = 0, sd_s = 0;
      ASSERT_EQ(std::sscanf(told.c_str(), "%lf ± %lf", &add_s, &sd_s), 2) << *clock;
      EXPECT_NEAR(add_s, -late_s, 0.02) << side;
      EXPECT_NEAR(sd_s, 0.01, 0.005) << side;
    }
  // Nor does the waist for the shoulder make one of a clock that is right.
  commands::LoadsRunOptions options = QuickOnPlates("right");
  options.reading.names.erase("shoulder");
  EXPECT_THAT(RunOn(options)->warnings, testing::Not(testing::Contains(testing::HasSubstr("clock"))));
}

TEST(LoadsOfBadInput, ForcesOfAnotherTimeAreRefused) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  std::ofstream(folder / "other.mot") << "other\nnRows=3\nnColumns=7\nendheader\n"
                                         "time\tf_vx\tf_vy\tf_vz\tf_px\tf_py\tf_pz\n"
                                         "100\t0\t300\t0\t0\t0\t0\n101\t0\t300\t0\t0\t0\t0\n102\t0\t300\t0\t0\t0\t0\n";
  commands::LoadsRunOptions options = OptionsFor("right");
  options.forces = folder / "other.mot";
  EXPECT_THAT(Failure(options), testing::AllOf(testing::HasSubstr("100.00 to 102.00 s"), testing::HasSubstr("trial")));
}

// The mean is of the rises that have forces, and each of these is whole.
TEST(LoadsOfBadInput, RisesWithoutForcesAreLeftOutAndSaidToBe) {
  REQUIRE_RECORDING();
  const TemporaryFolder folder;
  std::ifstream whole(kFolder / "STS1_grf.mot");
  std::ofstream cut(folder / "cut.mot");
  for (std::string line; std::getline(whole, line) && !(std::atof(line.c_str()) > 6.8);) cut << line << "\n";
  cut.close();
  commands::LoadsRunOptions options = QuickOnPlates("right");
  options.forces = folder / "cut.mot";
  const auto outcome = RunOn(options);
  EXPECT_EQ(outcome->summary["rises"].size(), 3u);
  for (const Json& rise : outcome->summary["rises"]) EXPECT_GT(rise["knee_energy_j"], 20);
  EXPECT_THAT(outcome->warnings, testing::Contains(testing::HasSubstr("3 of the 5 rises")));
}

TEST(LoadsOfBadInput, AWalkWithoutForcesSaysWhatItNeeds) {
  const fs::path walk = SharedData() / "opensim_walk/walking2.c3d";
  if (!fs::exists(walk)) GTEST_SKIP() << walk.string() << " is not here";
  commands::LoadsRunOptions options;
  options.trial = walk;
  options.reading.names = NameMap("ankle=RAJC,knee=RKJC,hip=RHJC");
  options.loads.body.mass_kg = 70;
  EXPECT_THAT(Failure(options), testing::HasSubstr("give --forces"));
}

TEST(GroundForces, OlderFilesNameAllPlatesAlike) {
  const TemporaryFolder folder;
  std::ofstream(folder / "old.mot")
      << "old\nnRows=1\nnColumns=19\nendheader\n"
         "time\tground_force_vx\tground_force_vy\tground_force_vz\tground_force_px\tground_force_py\tground_force_pz\t"
         "ground_force_vx\tground_force_vy\tground_force_vz\tground_force_px\tground_force_py\tground_force_pz\t"
         "ground_torque_x\tground_torque_y\tground_torque_z\tground_torque_x\tground_torque_y\tground_torque_z\n"
         "0\t1\t2\t3\t4\t5\t6\t11\t12\t13\t14\t15\t16\t0\t7\t0\t0\t17\t0\n";
  const exchange::GroundForceRecording forces = exchange::ReadGroundForces(folder / "old.mot");
  ASSERT_EQ(forces.plates.size(), 2u);
  EXPECT_EQ(forces.plates[1].force_n[0], Eigen::Vector3d(11, 12, 13));
  EXPECT_EQ(forces.plates[1].point_m[0], Eigen::Vector3d(14, 15, 16));
  EXPECT_EQ(forces.plates[1].moment_nm[0], Eigen::Vector3d(0, 17, 0));
  EXPECT_THROW(exchange::ReadGroundForces(folder / "old.txt"), Error);
  EXPECT_THROW(exchange::CheckPlates({{"right", 0}}), UsageError);
  EXPECT_THROW(exchange::CheckPlates({{"both", 1}}), UsageError);
}

// Someone walks over two plates: each step bears about the body's weight, and the force acts within a foot's length of
// an ankle.
TEST(GroundForces, OfAC3dFileActUnderTheFoot) {
  const fs::path walk = SharedData() / "opensim_walk/walking2.c3d";
  if (!fs::exists(walk)) GTEST_SKIP() << walk.string() << " is not here";
  const exchange::GroundForceRecording forces = exchange::ReadGroundForces(walk);
  const exchange::PointRecording points = exchange::ReadPoints(walk);
  ASSERT_EQ(forces.plates.size(), 2u);
  ASSERT_EQ(forces.up_axis, 'z');
  ASSERT_EQ(forces.time_s.size(), 8 * points.time_s.size());  // 2000 and 250 Hz
  for (const exchange::PlateForces& plate : forces.plates) {
    double largest_n = 0, least_n = 0;
    for (const Eigen::Vector3d& force_n : plate.force_n)
      largest_n = std::max(largest_n, force_n.z()), least_n = std::min(least_n, force_n.z());
    EXPECT_GT(least_n, -30);  // the plates' own zero is off by up to 27 N
    EXPECT_GT(largest_n, 700);
    EXPECT_LT(largest_n, 1200);
    int stands = 0, under = 0;
    for (std::size_t i = 0; i < points.time_s.size(); ++i) {
      const Eigen::Vector3d force_n = plate.force_n[8 * i];
      if (force_n.z() < 300) continue;
      const Eigen::Vector3d at_mm =
          1000 * (plate.point_m[8 * i] + Eigen::Vector3d::UnitZ().cross(plate.moment_nm[8 * i]) / force_n.z());
      double least_mm = 1e9;
      for (const char* ankle : {"RAJC", "LAJC"}) {
        const Eigen::Vector3d apart_mm = points.Find(ankle)->positions[i] - at_mm;
        if (apart_mm.allFinite()) least_mm = std::min(least_mm, apart_mm.head<2>().norm());
      }
      ++stands, under += least_mm < 250;
    }
    EXPECT_GT(stands, 100);
    EXPECT_EQ(under, stands);
  }
}

}  // namespace
}  // namespace lake
