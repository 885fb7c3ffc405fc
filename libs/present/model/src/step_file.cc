#include "lake/model/step_file.h"

#include "lake/core/error.h"

#ifndef LAKE_HAS_OPENCASCADE

namespace lake::model {

void WriteStep(const std::filesystem::path& path, const parts::Mechanism&, const linkage::Pose&) {
  throw Error(
      "{}: this build writes no STEP files, as OpenCASCADE was not installed: install libocct-data-exchange-dev and "
      "build "
      "again, or export dxf",
      path.string());
}

}  // namespace lake::model

#else

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Controller.hxx>
#include <Standard_Failure.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Ax2.hxx>
#include <gp_Circ.hxx>
#include <gp_Trsf.hxx>
#include <gp_Vec.hxx>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/provenance.h"

namespace lake::model {
namespace {

gp_Pnt PointOf(const Eigen::Vector2d& at) {
  return {at.x(), at.y(), 0};
}

gp_Circ CircleOf(const Eigen::Vector2d& centre, double radius) {
  return gp_Circ(gp_Ax2(PointOf(centre), gp::DZ()), radius);
}

TopoDS_Edge EdgeOf(const parts::OutlinePiece& piece) {
  if (!piece.is_arc) return BRepBuilderAPI_MakeEdge(PointOf(piece.from), PointOf(piece.to));
  const gp_Circ circle = CircleOf(piece.centre, (piece.from - piece.centre).norm());
  return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(circle, PointOf(piece.from), PointOf(piece.to), true).Value());
}

// In the plate's frame, lying on z = 0.
TopoDS_Shape SolidOf(const parts::Plate& plate) {
  BRepBuilderAPI_MakeWire outline;
  for (const parts::OutlinePiece& piece : parts::OutlineOf(plate)) outline.Add(EdgeOf(piece));
  BRepBuilderAPI_MakeFace face(outline.Wire());
  for (const parts::Hole& hole : plate.holes) {
    const TopoDS_Wire wire =
        BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(CircleOf(hole.at_mm, hole.diameter_mm / 2)));
    face.Add(TopoDS::Wire(wire.Reversed()));
  }
  return BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0, 0, plate.thickness_mm));
}

// Standing on z = 0.
TopoDS_Shape TubeOf(double length, double outer_diameter, double inner_diameter) {
  if (inner_diameter <= 0) return BRepPrimAPI_MakeCylinder(outer_diameter / 2, length);
  BRepBuilderAPI_MakeFace ring(
      BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(CircleOf({0, 0}, outer_diameter / 2))).Wire());
  const TopoDS_Wire bore = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(CircleOf({0, 0}, inner_diameter / 2)));
  ring.Add(TopoDS::Wire(bore.Reversed()));
  return BRepPrimAPI_MakePrism(ring.Face(), gp_Vec(0, 0, length));
}

TopLoc_Location LocationOf(const parts::Placement& placement, double z_mm) {
  gp_Trsf turn, move;
  turn.SetRotation(gp::OZ(), placement.turn_rad);
  move.SetTranslation(gp_Vec(placement.at_mm.x(), placement.at_mm.y(), z_mm));
  return TopLoc_Location(move * turn);
}

class Assembly {
 public:
  Assembly() : document_(new TDocStd_Document("BinXCAF")), shapes_(XCAFDoc_DocumentTool::ShapeTool(document_->Main())) {
    root_ = shapes_->NewShape();
    TDataStd_Name::Set(root_, "knee exoskeleton");
  }

  void Add(const std::string& name, const TopoDS_Shape& shape, const TopLoc_Location& location) {
    const TDF_Label part = shapes_->AddShape(shape, false);
    TDataStd_Name::Set(part, name.c_str());
    TDataStd_Name::Set(shapes_->AddComponent(root_, part, location), name.c_str());
  }

  void Write(const std::filesystem::path& path) {
    shapes_->UpdateAssemblies();
    STEPCAFControl_Writer writer;
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.product.name", "knee exoskeleton");
    if (!writer.Transfer(document_, STEPControl_AsIs)) throw Fail("{}: the solids cannot be written", path.string());
    APIHeaderSection_MakeHeader header(writer.ChangeWriter().Model());
    header.SetName(new TCollection_HAsciiString("knee exoskeleton"));
    header.SetTimeStamp(new TCollection_HAsciiString("2000-01-01T00:00:00"));  // the same design is the same file
    header.SetOriginatingSystem(new TCollection_HAsciiString(("lake " + VersionAndCommit()).c_str()));
    // In memory first: OpenCASCADE opens no file whose name is not UTF-8, and does not see that a disk is full.
    StepData_StepWriter text(writer.ChangeWriter().Model());
    text.SendModel(Handle(StepData_Protocol)::DownCast(writer.ChangeWriter().WS()->Protocol()));
    std::ostringstream stream;
    if (!text.Print(stream)) throw Fail("{}: the solids cannot be written", path.string());
    WriteTextFile(path, stream.str());
  }

 private:
  Handle(TDocStd_Document) document_;
  Handle(XCAFDoc_ShapeTool) shapes_;
  TDF_Label root_;
};

// OpenCASCADE tells its statistics on stdout, which is the results'.
void KeepQuiet() {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
}

}  // namespace

void WriteStep(const std::filesystem::path& path, const parts::Mechanism& mechanism, const linkage::Pose& pose) try {
  KeepQuiet();
  Assembly assembly;
  for (std::size_t i = 0; i < parts::kPlates; ++i) {
    const parts::Plate& plate = mechanism.plates[i];
    assembly.Add(plate.name, SolidOf(plate),
                 LocationOf(parts::PlacementOf(static_cast<parts::Body>(i), pose), mechanism.stack.span[i].from_mm));
  }
  const auto on_joint = [&](parts::Joint joint, double z_mm) {
    return LocationOf({parts::PlaceOf(joint, pose), 0}, z_mm);
  };
  for (const parts::Pin& pin : mechanism.stack.pins)
    assembly.Add(fmt::format("pin {}", parts::LetterOf(pin.joint)),
                 TubeOf(pin.span.Length(), mechanism.options.pin_diameter_mm, 0),
                 on_joint(pin.joint, pin.span.from_mm));
  for (const parts::Spacer& spacer : mechanism.stack.spacers)
    assembly.Add(fmt::format("spacer {}", parts::LetterOf(spacer.joint)),
                 TubeOf(spacer.span.Length(), spacer.outer_diameter_mm, spacer.inner_diameter_mm),
                 on_joint(spacer.joint, spacer.span.from_mm));
  assembly.Write(path);
} catch (const Standard_Failure& failure) {
  throw Fail("{}: OpenCASCADE cannot make the solids: {}", path.string(), failure.GetMessageString());
}

}  // namespace lake::model

#endif
