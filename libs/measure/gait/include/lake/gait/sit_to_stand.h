// What a clinic reports of a sit-to-stand: times of the rise and its phases, angles, speeds and power, of each rise and
// of the five-times test.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"
#include "lake/motion/person.h"

namespace lake::gait {

// The markers of the pelvis: above its front and its back (spina iliaca anterior and posterior superior), each of the
// near side, or in three dimensions the middle of both sides.
inline constexpr const char *kAsis = "asis", *kPsis = "psis";

// One value per frame, NaN where not known: trunk_deg less the pelvis' forward tilt, which is the angle of the line
// from `psis` to `asis` below the horizontal; its SD. `warning`: why all of it is unknown, although one of the markers
// is in the recording (the other one is not, they are exchanged, or the waist marker is on the pelvis too); else empty.
struct TrunkOnPelvis {
  std::vector<double> deg, sd_deg;
  std::string warning;
};
TrunkOnPelvis FindTrunkOnPelvis(const LegFitResult& fit);

inline constexpr double kSteadyFraction = 0.05;  // as of the knee's extension at standing
inline constexpr double kSteady_s = 0.5;

// One rise, or the means of five. Of a rise, the SDs are the fit's, and those of the events' times, which have what
// markers slide on the skin in them, at the onset the sway of the rest before it too. Of the five-times test they are
// those between its rises.
struct SitToStand {
  static std::span<const Field<SitToStand>> Fields();

  int repetition = 0;  // from 1; 0: the five-times test
  Measured onset_s, seat_off_s, standing_s;
  Measured rise_s;  // onset to standing
  // Phases I to III of Schenkman et al. (1990, doi:10.1093/ptj/70.10.638): onset to seat-off, from there to the largest
  // ankle dorsiflexion (forward lean of the shank), from there to standing.
  Measured flexion_s, transfer_s, extension_s;
  // Phase IV: from standing until the person is steady. Schenkman et al. end it when all motion that belongs to
  // stabilisation is complete, and give no limit; here it is when the angular speeds of hip and knee and the hip's
  // speed up or down have come below kSteadyFraction of their peaks in the rise, and stay there for kSteady_s. NaN
  // where that is not recorded, where the descent begins before, without a waist marker, and where a speed's SD is more
  // than half of its limit.
  Measured stabilisation_s;
  Measured descent_s;                                                // from standing to the seat
  Measured knee_seat_off_deg, hip_seat_off_deg, trunk_seat_off_deg;  // knee and hip: flexion; trunk: from the vertical
  Measured knee_max_deg, hip_max_deg, trunk_max_deg;                 // between onset and standing
  Measured knee_extension_max_deg_s, trunk_flexion_max_deg_s;        // peak angular speeds of the rise
  Measured hip_rise;                                                 // from onset to standing; unit of the plane
  Measured hip_speed, hip_speed_max;                                 // hip_rise over seat-off to standing; the peak
  // Mean power of the rise over body mass: 0.9 g h / t, where 0.9 is the part of the mass that is lifted (all but
  // shanks and feet), h is the hip's rise and t is rise_s, of the five-times test a ninth of five_times_s: to the fifth
  // standing it holds 5 rises and 4 lowerings (Alcazar et al. 2018, doi:10.1016/j.exger.2018.08.006). Only in mm.
  Measured power_w_kg;
  Measured five_times_s;  // of the five-times test alone: first onset to fifth standing
  // Lean of the trunk relative to the pelvis, at seat-off and the largest between onset and standing: the trunk's lean
  // less the pelvis' forward tilt, which is the angle of the line from kPsis to kAsis below the horizontal. Positive:
  // the back is bent forward; below zero in a person who stands, whose pelvis is tilted forward. NaN without these
  // markers, and where TrunkOnPelvis has a warning.
  Measured trunk_pelvis_seat_off_deg, trunk_pelvis_max_deg;
  // The whole body's centre of mass: how far it is before the ankle marker at seat-off, negative behind it, and its
  // largest velocities from onset to standing. A velocity is the momentum per kg of body mass. NaN where
  // CentresOfMass has none.
  Measured com_seat_off_mm, com_forward_max_mm_s, com_upward_max_mm_s;
};

// The whole body's centre of mass in a rise, as in SitToStand. It takes a table of the segments' masses, which
// the caller gives.
struct CentreOfMassInRise {
  Measured seat_off_mm, forward_max_mm_s, upward_max_mm_s;
};
using CentresOfMass = std::map<int, CentreOfMassInRise>;  // by repetition

// The rises in order, then the five-times test: the first five rises of which onset and standing are known; without
// five, all of it is NaN. `on_pelvis` is what FindTrunkOnPelvis says of this fit; empty, for whoever does not ask for
// it. `centres`: of the rises of which they are known.
std::vector<SitToStand> MeasureSitToStands(const LegFitResult& fit, TrunkOnPelvis on_pelvis,
                                           const CentresOfMass& centres = {});
std::vector<SitToStand> MeasureSitToStands(const LegFitResult& fit);

// Whom norms are looked up for.
struct Person {
  std::optional<double> age_years;
  std::optional<motion::Sex> sex;
};
void Describe(Person& o, OptionList& options);

// Times of the five-times test beyond which a person of this age does worse than average: 11.4 s from 60 to 69 years,
// 12.6 s from 70 to 79, 14.8 s from 80 to 89, of both sexes (Bohannon 2006, doi:10.2466/pms.103.1.215-222). That test
// is timed from the word to the fifth standing or sitting; ours from the first onset to the fifth standing, which is
// shorter by the reaction. nullopt for other ages: the source has none.
std::optional<double> FiveTimesReference_s(double age_years);

// Power of the five-times test over body mass below which it is low among older adults: 2.5 W/kg of men, 1.9 W/kg of
// women (Baltasar-Fernandez et al. 2021, doi:10.1038/s41598-021-98871-3). They have the hip's rise from stature and
// height of the chair, by Alcazar's equation; ours is measured. nullopt below kOlder_years: the source has older adults
// alone.
inline constexpr double kOlder_years = 65;
std::optional<double> LowPowerWKg(motion::Sex sex, std::optional<double> age_years);

// For summaries: time and power of the five-times test with their SDs, where its time ends and how many rises and
// lowerings it holds; at an age the time's reference, of a sex the power's; null without five rises.
Json FiveTimesJson(const SitToStand& five_times, const Person& person);

// sit_to_stand.csv of these rows: the values, then the SDs (…_sd); lengths end in the plane's unit.
void WriteSitToStandCsv(const std::filesystem::path& path, const std::vector<SitToStand>& rows,
                        motion::LengthUnit of_plane);

// The deviations of onset, seat-off and standing as that table has them, which events.csv has not; events that are at
// another time, as those of a correction are, keep none. Throws Error for a damaged table.
void ReadEventDeviations(const std::filesystem::path& path, std::vector<motion::StsEvent>& events);

}  // namespace lake::gait
