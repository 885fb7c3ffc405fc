// What the page is told of a design is what the closed form says of it.
#include "lake/review/design_explorer.h"

#include <gmock/gmock.h>

#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/problem/evaluate.h"

namespace lake::review {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kRounding = 1e-4;  // the page's numbers have four digits behind the point

// The published linkage of the paper's problem, and limits that it meets but for the singularity's margin.
ExploredDesign Published() {
  ExploredDesign explored;
  explored.name = "design.yaml";
  explored.design.links = {59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  explored.problem.standing_deg = 5;
  explored.problem.limits["max_force_n"] = 2000;
  explored.problem.singularity_margin_mm = 2;
  return explored;
}

Json Question(const linkage::Links& links) {
  return {{"links", links.Values()}};
}

Vector2d Place(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>()};
}

const Json& CheckNamed(const Json& message, const std::string& name) {
  for (const Json& check : message.at("checks"))
    if (check.at("name") == name) return check;
  throw Fail("no requirement '{}'", name);
}

TEST(DesignExplorer, ShowsEveryPoseAsTheClosedFormHasIt) {
  const ExploredDesign design = Published();
  const linkage::Links& links = design.design.links;
  const Json curves = DesignExplorer(design).Explore(Question(links)).at("curves");
  const auto strokes = curves.at("stroke").get<std::vector<double>>();
  ASSERT_GT(strokes.size(), 100u);
  EXPECT_DOUBLE_EQ(strokes.front(), 242);
  for (const std::size_t row : {std::size_t{1}, strokes.size() / 2, strokes.size() - 2}) {
    const linkage::Pose pose = linkage::RequirePose(links, strokes[row]);
    const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
    const Json& now = curves.at("now");
    // Strokes are rounded too: half a step of them times the slope, below 3 degrees and 100 mm/rad per mm here.
    EXPECT_NEAR(now.at("knee").at(row).get<double>(), DegreesFromRadians(pose.theta_rad), 3 * kRounding);
    EXPECT_NEAR(now.at("arm").at(row).get<double>(), transmission.moment_arm_mm, 0.01);
    EXPECT_NEAR(now.at("force").at(row).get<double>() / linkage::ActuatorForce(transmission, 40), 1, 1e-3);
    EXPECT_EQ(now, curves.at("saved")) << "nothing has been changed yet";

    const Json& drawn = curves.at("poses").at(row);
    const Vector2d p = Place(drawn.at("thigh_pin")), r = Place(drawn.at("tip")), s = Place(drawn.at("shank_pin")),
                   m = Place(drawn.at("mount")), up = Place(drawn.at("thigh"));
    EXPECT_NEAR((r - s).norm(), links.l1, 3 * kRounding);
    EXPECT_NEAR((r - p).norm(), links.l2, 3 * kRounding);
    EXPECT_NEAR((r - m).norm(), strokes[row], 4 * kRounding);
    EXPECT_NEAR((p - links.l3 * up).norm(), 0, 0.01);
    EXPECT_NEAR((s - Vector2d(0, -links.l4)).norm(), 0, 2 * kRounding) << "the shank hangs upright";
    EXPECT_LT(m.x(), p.x()) << "the mount is behind the thigh";
  }
  const auto knee = curves.at("now").at("knee").get<std::vector<double>>();
  EXPECT_NEAR(knee.front(), 148.57, 0.01) << "the paper's range";
  EXPECT_NEAR(knee.back(), 5, 0.01) << "standing as the problem has it";
}

// The leg is the problem's, and its knee is where the joint is not.
TEST(DesignExplorer, DrawsTheBodyThatItsLimitsAreOn) {
  ExploredDesign explored = Published();
  explored.problem.clearances.body = {.height_mm = 1650, .mass_kg = 55, .leg = person::LegLengths{390, 360}};
  explored.design.placement_mm = {13, -4};
  const Json body = DesignExplorer(explored).About().at("body");
  const person::Body own = person::BodyOf(explored.problem.clearances.body);
  EXPECT_EQ(body.at("thigh").at("length"), 390);
  EXPECT_EQ(body.at("shank").at("length"), 360);
  EXPECT_EQ(body.at("thigh").at("proximal_radius"), own.thigh.proximal_radius_mm);
  EXPECT_EQ(body.at("shank").at("distal_radius"), own.shank.distal_radius_mm);
  EXPECT_EQ(body.at("knee"), (Json{-13, 4}));
}

// What a person needs and nobody asked for is told, and is not counted among what is met.
TEST(DesignExplorer, TellsWhatWasNotAsked) {
  ExploredDesign design = Published();
  linkage::Links links = design.design.links;
  links.l6 = 200;
  const Json message = DesignExplorer(design).Explore(Question(links));
  const Json& seated = CheckNamed(message, "seated angle");
  EXPECT_EQ(seated.at("asked"), false);
  EXPECT_EQ(seated.at("holds"), false) << "nobody can sit down in it";
  EXPECT_EQ(seated.at("value"), message.at("range_deg"));
  EXPECT_EQ(CheckNamed(message, "force").at("asked"), true);
  EXPECT_THROW(CheckNamed(message, "clearance to the seat"), Error) << "beside the leg there is none";
  design.problem.mount = linkage::Mount::kBehind;
  EXPECT_EQ(CheckNamed(DesignExplorer(design).Explore(Question(links)), "clearance to the seat").at("asked"), false);
  // What is asked stands there once.
  design.problem.clearances.seat_mm = 5;
  EXPECT_THROW(CheckNamed(DesignExplorer(design).Explore(Question(links)), "clearance to the seat"), Error);
  EXPECT_EQ(CheckNamed(DesignExplorer(design).Explore(Question(links)), "seat clearance").at("asked"), true);
}

// Whatever is typed, what is shown is of these links: a coupler that no linkage has fails the order, its bound and
// Grashof's law, although the paper's form of the law, l3 + l4 <= l1 + l2, is met.
TEST(DesignExplorer, LinksThatCannotBeFailTheirLimits) {
  const ExploredDesign design = Published();
  for (const double l1_mm : {705.0, 1e9, 1e300}) {
    linkage::Links links = design.design.links;
    links.l1 = l1_mm;
    const Json message = DesignExplorer(design).Explore(Question(links));
    EXPECT_TRUE(message.at("range_deg").is_null());
    EXPECT_TRUE(message.at("curves").is_null());
    EXPECT_EQ(CheckNamed(message, "l1").at("holds"), false);
    EXPECT_EQ(CheckNamed(message, "l1 ≤ l4").at("holds"), false);
    const Json& grashof = CheckNamed(message, "grashof");
    EXPECT_EQ(grashof.at("holds"), false);
    EXPECT_NEAR(grashof.at("slack").get<double>() / -l1_mm, 1, 0.3);
    EXPECT_EQ(CheckNamed(message, "force").at("holds"), false);
  }
}

TEST(DesignExplorer, SaysWhichRequirementFailsAndByHowMuch) {
  const ExploredDesign design = Published();
  linkage::Links links = design.design.links;
  links.l6 = 199;
  links.l3 = 58;
  const Json message = DesignExplorer(design).Explore(Question(links));
  const problem::DesignEvaluation evaluation = problem::Evaluate(links, design.problem);
  std::size_t failed = 0;
  for (const problem::RequirementCheck& check : evaluation.checks) {
    const Json& said = CheckNamed(message, std::string(check.requirement.name));
    EXPECT_EQ(said.at("holds").get<bool>(), check.slack >= -1e-6 * std::max(1.0, check.requirement.limit));
    failed += said.at("holds").get<bool>() ? 0 : 1;
    if (std::isfinite(check.slack))
      EXPECT_NEAR(said.at("slack").get<double>(), check.slack, kRounding) << check.requirement.name;
    else
      EXPECT_TRUE(said.at("slack").is_null()) << check.requirement.name;
  }
  EXPECT_GT(failed, 0u) << "shank link and thigh link are longer than coupler and slewing bar";
  EXPECT_NEAR(CheckNamed(message, "l6").at("slack").get<double>(), -1, kRounding) << "below its bound of 200 mm";
}

TEST(DesignExplorer, SaysWhereTheForceIsLargest) {
  const ExploredDesign design = Published();
  const Json message = DesignExplorer(design).Explore(Question(design.design.links));
  const Json& force = CheckNamed(message, "force");
  const double knee_deg = force.at("worst").at("knee_deg");
  const auto knee = message.at("curves").at("now").at("knee").get<std::vector<double>>();
  const auto forces = message.at("curves").at("now").at("force");
  double largest_deg = 0, largest_n = 0;
  for (std::size_t row = 0; row < knee.size(); ++row)
    if (knee[row] >= 5 && !forces[row].is_null() && forces[row].get<double>() > largest_n)
      largest_n = forces[row], largest_deg = knee[row];
  EXPECT_NEAR(knee_deg, largest_deg, 2) << "the curve's rows are up to 2 degrees apart";
}

// A joint further forward takes the linkage with it.
TEST(DesignExplorer, HoldsClearancesWhereTheJointSits) {
  ExploredDesign explored = Published();
  explored.problem.clearances.thigh_mm = 10;
  explored.design.placement_mm = {13, -4};
  const Json message = DesignExplorer(explored).Explore(Question(explored.design.links));
  problem::SynthesisProblem placed = explored.problem;
  placed.clearances.placement_mm = explored.design.placement_mm;
  const problem::DesignEvaluation evaluation = problem::Evaluate(explored.design.links, placed);
  const double clearance_mm = evaluation.CheckOf("thigh clearance").value;
  EXPECT_NEAR(CheckNamed(message, "thigh clearance").at("value").get<double>(), clearance_mm, kRounding);
}

class Dragged : public testing::TestWithParam<const char*> {};

TEST_P(Dragged, IsWhereItWasPutAndTheOtherPinsStay) {
  const ExploredDesign design = Published();
  const DesignExplorer explorer(design);
  constexpr double kStroke = 300;
  const linkage::Pose before = linkage::RequirePose(design.design.links, kStroke);
  const auto picture = [&](const Vector2d& at) {
    const double s = std::sin(before.theta_rad), c = std::cos(before.theta_rad);
    return Vector2d(-c * at.x() - s * at.y(), -s * at.x() + c * at.y());
  };
  std::map<std::string, Vector2d> expected = {
      {"thigh_pin", before.thigh_pin}, {"tip", before.tip}, {"shank_pin", before.shank_pin}, {"mount", before.mount}};
  const std::string pin = GetParam();
  // Those on thigh and shank have no place beside their axes.
  const Vector2d along_shank = before.shank_pin.normalized(), beside_shank(-along_shank.y(), along_shank.x());
  const Vector2d by = pin == "thigh_pin" ? Vector2d(0, 5) : pin == "shank_pin" ? 5 * along_shank : Vector2d(3, -4);
  expected[pin] += by;
  const Vector2d beside = pin == "thigh_pin" ? Vector2d(7, 0) : pin == "shank_pin" ? 7 * beside_shank : Vector2d(0, 0);
  const Vector2d pointed = picture(expected[pin] + beside);
  Json question = Question(design.design.links);
  question["drag"] = {{"pin", pin}, {"x", pointed.x()}, {"y", pointed.y()}, {"stroke", kStroke}};
  const Json message = explorer.Explore(question);
  const linkage::Pose after = linkage::RequirePose(LinksFrom(message.at("links")), message.at("stroke"));
  EXPECT_LT((after.thigh_pin - expected["thigh_pin"]).norm(), 1e-6);
  EXPECT_LT((after.tip - expected["tip"]).norm(), 1e-6);
  EXPECT_LT((after.shank_pin - expected["shank_pin"]).norm(), 1e-6);
  EXPECT_LT((after.mount - expected["mount"]).norm(), 1e-6);
  EXPECT_LT((Place(message.at("pose").at("mount")) - picture(expected["mount"])).norm(), 2 * kRounding);
}

INSTANTIATE_TEST_SUITE_P(Pin, Dragged, testing::Values("thigh_pin", "tip", "shank_pin", "mount"));

TEST(DesignExplorer, RefusesToFoldOver) {
  const ExploredDesign design = Published();
  Json question = Question(design.design.links);
  question["drag"] = {{"pin", "tip"}, {"x", 200}, {"y", 150}, {"stroke", 300}};
  EXPECT_THAT([&] { DesignExplorer(design).Explore(question); }, ThrowsMessage<Error>(HasSubstr("fold over")));
}

TEST(DesignExplorer, SaysWhatDoesNotClose) {
  const ExploredDesign design = Published();
  linkage::Links links = design.design.links;
  links.l2 = 20;  // l7 exceeds l2 + d_min
  const DesignExplorer explorer(design);
  const Json message = explorer.Explore(Question(links));
  EXPECT_THAT(message.at("gap").get<std::string>(), HasSubstr("by 48.8 mm"));
  EXPECT_TRUE(message.at("curves").is_null());
  EXPECT_TRUE(message.at("range_deg").is_null());
  EXPECT_FALSE(CheckNamed(message, "force").at("holds").get<bool>());
  EXPECT_THAT([&] { explorer.With(links); }, ThrowsMessage<Error>(HasSubstr("cannot be saved")));
}

TEST(DesignExplorer, RefusesWhatAreNoLinks) {
  const DesignExplorer explorer(Published());
  const auto ask = [&](const Json& links) { return [&explorer, links] { explorer.Explore({{"links", links}}); }; };
  EXPECT_THAT(ask({60, 60}), ThrowsMessage<Error>(HasSubstr("six links")));
  EXPECT_THAT(ask({60, 60, 60, 60, -1, 300}), ThrowsMessage<Error>(HasSubstr("l5")));
  EXPECT_THAT(ask({60, 60, 60, 60, 0, 300}), ThrowsMessage<Error>(HasSubstr("l5")));
  EXPECT_THROW(ask({60, 60, 60, 60, nullptr, 300})(), nlohmann::json::exception);
  Json question = Question(Published().design.links);
  question["drag"] = {{"pin", "knee"}, {"x", 0}, {"y", 0}, {"stroke", 300}};
  EXPECT_THAT([&] { explorer.Explore(question); }, ThrowsMessage<Error>(HasSubstr("'knee' is no pin")));
  question["drag"] = {{"pin", "tip"}, {"x", 0}, {"y", 0}, {"stroke", 9000}};
  EXPECT_THAT([&] { explorer.Explore(question); }, ThrowsMessage<Error>(HasSubstr("no pose")));
}

TEST(DesignExplorer, ADesignWithOtherLinksIsWhole) {
  ExploredDesign explored = Published();
  explored.design.placement_mm = {13, -4};
  explored.design.program = {linkage::StrokeProgram::Kind::kFree, 5, {{0, 250}, {10, 370}}};
  linkage::Links links = explored.design.links;
  links.l5 = 110;
  const linkage::Design design = DesignExplorer(explored).With(links);
  EXPECT_EQ(design.links.Values(), links.Values());
  const problem::DesignEvaluation evaluation = problem::Evaluate(links, explored.problem);
  EXPECT_EQ(design.range_deg, evaluation.range_deg);
  EXPECT_EQ(design.d_max_mm, evaluation.stands_mm);
  EXPECT_EQ(design.placement_mm, (std::array<double, 2>{13, -4}));
  EXPECT_FALSE(design.program) << "its strokes are of other links";
  EXPECT_THAT(design.made_by, HasSubstr("lake-review"));
}

}  // namespace
}  // namespace lake::review
