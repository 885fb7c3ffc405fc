#include "lake/loads/anthropometry.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "lake/core/error.h"
#include "lake/loads/leg_dynamics.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake::loads {
namespace {

TEST(Anthropometry, EveryTableAddsUpToTheBody) {
  for (const Anthropometry& table : {FindAnthropometry("winter", {}), FindAnthropometry("deleva", Sex::kMale),
                                     FindAnthropometry("deleva", Sex::kFemale)}) {
    EXPECT_NEAR(2 * (table.foot.mass + table.shank.mass + table.thigh.mass) + table.trunk.mass, 1, 1e-12) << table.name;
    EXPECT_THAT(table.source, testing::HasSubstr("doi 10."));
  }
}

// One of de Leva's segments: mass, height of its centre above the hips with hanging arms, and radius of gyration, mm.
struct Part {
  double mass, height_mm, gyration_mm;
};

void ExpectTrunk(const SegmentShare& trunk, const std::vector<Part>& parts, double hip_to_shoulder_mm) {
  double mass = 0, moment = 0, inertia = 0;
  for (const Part& part : parts) mass += part.mass, moment += part.mass * part.height_mm;
  const double centre = moment / mass;
  for (const Part& part : parts)
    inertia += part.mass * (part.gyration_mm * part.gyration_mm + std::pow(part.height_mm - centre, 2));
  EXPECT_NEAR(trunk.mass, mass, 5e-4);  // the table's own rounding
  EXPECT_NEAR(trunk.centre, centre / hip_to_shoulder_mm, 1e-3);
  EXPECT_NEAR(trunk.gyration, std::sqrt(inertia / mass) / hip_to_shoulder_mm, 1e-3);
}

// Trunk from mid-hip to mid-shoulder, head from the seventh cervical vertebra to the vertex, arms hanging from the
// shoulder; lengths, shares and the gyrations about the mediolateral axis (the trunk's is of the length from the
// seventh cervical vertebra to mid-hip) of de Leva's table 4.
TEST(Anthropometry, DeLevasTrunkIsTrunkHeadAndHangingArms) {
  const double male = 515.5, female = 497.9;
  ExpectTrunk(FindAnthropometry("deleva", Sex::kMale).trunk,
              {{0.4346, male * (1 - 0.431), 603.3 * 0.306},
               {0.0694, 603.3 + 242.9 * (1 - 0.5002), 242.9 * 0.315},
               {2 * 0.0271, male - 281.7 * 0.5772, 281.7 * 0.269},
               {2 * 0.0162, male - 281.7 - 268.9 * 0.4574, 268.9 * 0.265},
               {2 * 0.0061, male - 281.7 - 268.9 - 86.2 * 0.79, 86.2 * 0.513}},
              male);
  ExpectTrunk(FindAnthropometry("deleva", Sex::kFemale).trunk,
              {{0.4257, female * (1 - 0.3782), 614.8 * 0.292},
               {0.0668, 614.8 + 243.7 * (1 - 0.4841), 243.7 * 0.295},
               {2 * 0.0255, female - 275.1 * 0.5754, 275.1 * 0.260},
               {2 * 0.0138, female - 275.1 - 264.3 * 0.4559, 264.3 * 0.257},
               {2 * 0.0056, female - 275.1 - 264.3 - 78.0 * 0.7474, 78.0 * 0.454}},
              female);
}

// About the anteroposterior axis they are 0.251 and 0.267 of the shank, 0.329 and 0.369 of the thigh.
TEST(Anthropometry, DeLevasGyrationsAreAboutTheAxisOfFlexion) {
  const Anthropometry male = FindAnthropometry("deleva", Sex::kMale),
                      female = FindAnthropometry("deleva", Sex::kFemale);
  EXPECT_EQ(male.shank.gyration, 0.246);
  EXPECT_EQ(female.shank.gyration, 0.263);
  EXPECT_EQ(male.thigh.gyration, 0.329);
  EXPECT_EQ(female.thigh.gyration, 0.364);
  EXPECT_EQ(male.foot.gyration, 0.245);
  EXPECT_EQ(female.foot.gyration, 0.279);
}

// The measurements that de Leva's shares were made of: masses and principal moments of inertia of Zatsiorsky's men and
// women (V. M. Zatsiorsky, Kinetics of Human Motion, Human Kinetics 2002; as github.com/wspr/body-segment-param has
// them), kg and kg cm², with de Leva's lengths, mm. Which axis is which the trunk shows, as a chest is broader than it
// is deep: 1726 of a man's upper trunk about the anteroposterior axis, 705 about the mediolateral one.
TEST(Anthropometry, DeLevasGyrationsAreThoseOfTheMeasurementsBehindThem) {
  const struct {
    Sex sex;
    SegmentShare Anthropometry::*segment;
    double mass_kg, mediolateral_kg_cm2, anteroposterior_kg_cm2, length_mm;
  } measured[] = {{Sex::kMale, &Anthropometry::foot, 0.997, 40, 44, 258.1},
                  {Sex::kMale, &Anthropometry::shank, 3.16, 371, 385, 440.3},
                  {Sex::kMale, &Anthropometry::thigh, 10.36, 1999.4, 1997.8, 422.2},
                  {Sex::kFemale, &Anthropometry::foot, 0.88, 35.6, 41.1, 228.3},
                  {Sex::kFemale, &Anthropometry::shank, 3.0, 399.7, 409.9, 438.6},
                  {Sex::kFemale, &Anthropometry::thigh, 9.16, 1647.3, 1690.1, 368.5}};
  for (const auto& [sex, segment, mass_kg, mediolateral, anteroposterior, length_mm] : measured) {
    const double gyration_mm = (FindAnthropometry("deleva", sex).*segment).gyration * length_mm;
    const auto radius_mm = [&](double inertia_kg_cm2) { return 10 * std::sqrt(inertia_kg_cm2 / mass_kg); };
    EXPECT_NEAR(gyration_mm, radius_mm(mediolateral), 0.3) << length_mm;  // half of a last digit is 0.2 mm
    if (std::abs(radius_mm(mediolateral) - radius_mm(anteroposterior)) > 1) {
      EXPECT_GT(std::abs(gyration_mm - radius_mm(anteroposterior)), 1) << length_mm;
    }
  }
}

// Other people by another method (McConville et al. 1980 and Young et al. 1983, in Dumas et al. 2007, J. Biomech.
// 40(3), 543-553, doi 10.1016/j.jbiomech.2006.02.013, men and women): about the mediolateral axis 0.30 and 0.32 of the
// thigh, 0.28 of the shank. They cut the thigh from the trunk elsewhere, and people differ by a tenth.
TEST(Anthropometry, AnotherMeasurementHasSimilarGyrations) {
  const auto expect_near = [](double gyration, double other) { EXPECT_NEAR(gyration, other, 0.15 * other); };
  const Anthropometry male = FindAnthropometry("deleva", Sex::kMale),
                      female = FindAnthropometry("deleva", Sex::kFemale), winter = FindAnthropometry("winter", {});
  expect_near(male.thigh.gyration, 0.30);
  expect_near(female.thigh.gyration, 0.32);
  expect_near(male.shank.gyration, 0.28);
  expect_near(female.shank.gyration, 0.28);
  expect_near(winter.thigh.gyration, 0.31);
  expect_near(winter.shank.gyration, 0.28);
}

std::string ReadFailure(const std::string& text) {
  const TemporaryFolder folder;
  std::ofstream(folder / "table.yaml") << text;
  return MessageOf([&] { ReadAnthropometry(folder / "table.yaml"); });
}

TEST(Anthropometry, FilesAreCheckedWithTheirLine) {
  const std::string rest =
      "foot: {mass: 0.0145, centre: 0.5, gyration: 0.475}\nshank: {mass: 0.0465, centre: 0.433, gyration: 0.302}\n"
      "thigh: {mass: 0.1, centre: 0.433, gyration: 0.323}\n";
  EXPECT_EQ(ReadFailure(rest + "trunk: {mass: 0.678, centre: 0.626, gyration: 0.496}\n"), "");
  EXPECT_THAT(ReadFailure(rest), testing::HasSubstr("no segment 'trunk'"));
  EXPECT_THAT(ReadFailure(rest + "trunk: {mass: 0.5, centre: 0.626, gyration: 0.496}\n"),
              testing::HasSubstr("add up to 0.822"));
  EXPECT_THAT(ReadFailure(rest + "trunk: {mass: 6.78, centre: 0.626, gyration: 0.496}\n"),
              testing::AllOf(testing::HasSubstr("table.yaml:4"), testing::HasSubstr("6.78")));
  EXPECT_THAT(ReadFailure(rest + "trunk: {mass: 0.678, center: 0.626, gyration: 0.496}\n"),
              testing::HasSubstr("no 'centre'"));
  EXPECT_THROW(FindAnthropometry("deleva", {}), UsageError);
  EXPECT_THROW(FindAnthropometry("nobody", {}), Error);
}

TEST(Anthropometry, BodiesThatNobodyHasAreRefused) {
  BodyOptions body;
  EXPECT_THROW(body.Check(), UsageError);  // no mass
  for (const double mass_kg : {-70.0, 7.0, 700.0, std::numeric_limits<double>::quiet_NaN()}) {
    body.mass_kg = mass_kg;
    EXPECT_THROW(body.Check(), Error) << mass_kg;
  }
  body.mass_kg = 70;
  EXPECT_NO_THROW(body.Check());
  body.sex = Sex::kFemale;
  EXPECT_THROW(body.Check(), UsageError) << "Winter's table is of both";
  body.anthropometry = "deleva";
  EXPECT_NO_THROW(body.Check());
  body.height_mm = 1.75;
  EXPECT_THROW(body.Check(), Error);
  body.height_mm = 1750;
  body.share = 0;
  EXPECT_THROW(body.Check(), UsageError);
  body.share = 0.5, body.foot_mm = std::array<double, 2>{20, 30};
  EXPECT_THROW(body.Check(), UsageError);
}

}  // namespace
}  // namespace lake::loads
