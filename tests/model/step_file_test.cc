// The solids, read back from the file.
#include "lake/model/step_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <BRepAdaptor_Surface.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <GeomAbs_SurfaceType.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Type.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <cmath>
#include <gp_Cylinder.hxx>
#include <map>
#include <numbers>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/model/simulator_model.h"
#include "published_links.h"
#include "temporary_folder.h"

namespace lake {
namespace {

// Solids by name, where they lie.
std::map<std::string, TopoDS_Shape> ReadBack(const std::filesystem::path& path) {
  STEPCAFControl_Reader reader;
  reader.SetNameMode(true);
  EXPECT_EQ(reader.ReadFile(path.c_str()), IFSelect_RetDone);
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  EXPECT_TRUE(reader.Transfer(document));
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  TDF_LabelSequence roots, parts;
  shapes->GetFreeShapes(roots);
  EXPECT_EQ(roots.Length(), 1);
  XCAFDoc_ShapeTool::GetComponents(roots.First(), parts);
  std::map<std::string, TopoDS_Shape> solids;
  for (int i = 1; i <= parts.Length(); ++i) {
    Handle(TDataStd_Name) name;
    EXPECT_TRUE(parts(i).FindAttribute(TDataStd_Name::GetID(), name));
    char text[100];
    Standard_PCharacter at = text;
    name->Get().ToUTF8CString(at);
    std::string key = text;
    while (solids.contains(key)) key += "'";  // several spacers on a pin
    solids[key] = XCAFDoc_ShapeTool::GetShape(parts(i));
  }
  return solids;
}

double VolumeOf(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

// The axes of all holes of this diameter, in the x-y plane.
std::vector<Eigen::Vector2d> HolesOf(const TopoDS_Shape& shape, double diameter_mm) {
  std::vector<Eigen::Vector2d> holes;
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const BRepAdaptor_Surface surface(TopoDS::Face(faces.Current()));
    if (surface.GetType() != GeomAbs_Cylinder || std::abs(2 * surface.Cylinder().Radius() - diameter_mm) > 1e-9)
      continue;
    const gp_Pnt at = surface.Cylinder().Location();
    holes.emplace_back(at.X(), at.Y());
  }
  return holes;
}

// STEP holds coordinates with 15 digits; what comes of them through a rotation loses one or two.
constexpr double kWritten_mm = 1e-9;

class StepFile : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    mechanism_ = parts::MakeMechanism(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}), {});
    pose_ = model::ReferencePose(mechanism_);
    model::WriteStep(folder / "design.step", mechanism_, pose_);
    text_ = ReadTextFile(folder / "design.step");
    solids_ = ReadBack(folder / "design.step");
  }

  static inline parts::Mechanism mechanism_;
  static inline linkage::Pose pose_;
  static inline std::string text_;
  static inline std::map<std::string, TopoDS_Shape> solids_;
};

TEST_F(StepFile, HasEveryPartAsAValidSolidOfItsVolume) {
  ASSERT_EQ(solids_.size(), 4 + 5 + mechanism_.stack.spacers.size());
  for (const auto& [name, solid] : solids_) EXPECT_TRUE(BRepCheck_Analyzer(solid).IsValid()) << name;
  for (const parts::Plate& plate : mechanism_.plates) {
    const double volume = parts::MassOf(plate).area_mm2 * plate.thickness_mm;
    EXPECT_NEAR(VolumeOf(solids_.at(plate.name)), volume, 1e-8 * volume) << plate.name;
  }
  for (const parts::Pin& pin : mechanism_.stack.pins) {
    const double volume = std::numbers::pi * 16 * pin.span.Length();
    EXPECT_NEAR(VolumeOf(solids_.at(std::string("pin ") + std::string(parts::LetterOf(pin.joint)))), volume,
                1e-8 * volume);
  }
}

TEST_F(StepFile, HolesAreAsFarApartAsTheLinksAreLong) {
  const auto distance = [&](const char* plate) {
    const auto holes = HolesOf(solids_.at(plate), 8.1);
    EXPECT_EQ(holes.size(), 2u) << plate;
    return (holes.at(0) - holes.at(1)).norm();
  };
  EXPECT_NEAR(distance("coupler"), kPublishedLinks.l1, kWritten_mm);
  EXPECT_NEAR(distance("slewing bar"), kPublishedLinks.l2, kWritten_mm);
  EXPECT_NEAR(distance("shank link"), kPublishedLinks.l4, kWritten_mm);
  // The thigh plate is in its own frame: K, P and M.
  for (const Eigen::Vector2d& joint : {pose_.knee, pose_.thigh_pin, pose_.mount}) {
    double nearest = HUGE_VAL;
    for (const Eigen::Vector2d& hole : HolesOf(solids_.at("thigh plate"), 8.1))
      nearest = std::min(nearest, (hole - joint).norm());
    EXPECT_LT(nearest, kWritten_mm);
  }
}

// Pins stand in the holes of what they join.
TEST_F(StepFile, PinsStandInTheirHoles) {
  for (const parts::Pin& pin : mechanism_.stack.pins) {
    const auto axes = HolesOf(solids_.at(std::string("pin ") + std::string(parts::LetterOf(pin.joint))), 8);
    ASSERT_EQ(axes.size(), 1u);
    for (const parts::Body body : pin.bodies) {
      if (body == parts::Body::kActuator) continue;
      double nearest = HUGE_VAL;
      for (const Eigen::Vector2d& hole : HolesOf(solids_.at(std::string(parts::NameOf(body))), 8.1))
        nearest = std::min(nearest, (hole - axes.front()).norm());
      EXPECT_LT(nearest, kWritten_mm) << parts::LetterOf(pin.joint);
    }
  }
}

TEST_F(StepFile, SaysWhatMadeItAndItsUnit) {
  EXPECT_THAT(text_, ::testing::HasSubstr("lake "));
  EXPECT_THAT(text_, ::testing::HasSubstr("'2000-01-01T00:00:00'")) << "the clock is in the file";
  EXPECT_THAT(text_, ::testing::HasSubstr("SI_UNIT(.MILLI.,.METRE.)"));
  EXPECT_THROW(model::WriteStep("/no/such/folder/x.step", mechanism_, pose_), Error);
}

}  // namespace
}  // namespace lake
