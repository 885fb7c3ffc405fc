#include "lake/drawing/linkage_dxf.h"

#include <dl_dxf.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

struct Plate {
  std::vector<Vector2d> pins;  // counter-clockwise; their hull is the plate's middle line
  std::vector<std::string> label;
};

class Sheet {
 public:
  explicit Sheet(const std::filesystem::path& path) : writer_(dxf_.out(path.c_str(), DL_VERSION_2000)) {
    if (!writer_) throw Fail("{}: cannot be written", path.string());
    dxf_.writeHeader(*writer_);
    writer_->dxfString(9, "$INSUNITS"), writer_->dxfInt(70, 4);  // mm
    writer_->sectionEnd();
    WriteTables();
    writer_->sectionEntities();
  }

  void Line(const Vector2d& from, const Vector2d& to) {
    dxf_.writeLine(*writer_, DL_LineData(from.x(), from.y(), 0, to.x(), to.y(), 0), kOutline);
  }
  void Arc(const Vector2d& centre, double radius, double from_rad, double to_rad) {
    const DL_ArcData arc(centre.x(), centre.y(), 0, radius, DegreesFromRadians(from_rad), DegreesFromRadians(to_rad));
    dxf_.writeArc(*writer_, arc, kOutline);
  }
  void Hole(const Vector2d& centre, double radius) {
    dxf_.writeCircle(*writer_, DL_CircleData(centre.x(), centre.y(), 0, radius), kHole);
  }
  void Text(const Vector2d& at, double height, const std::string& text) {
    constexpr int kLeft = 0, kBaseline = 0;
    const DL_TextData data(at.x(), at.y(), 0, at.x(), at.y(), 0, height, 1, 0, kLeft, kBaseline, text, "Standard", 0);
    dxf_.writeText(*writer_, data, kLabel);
  }

  void Finish() {
    writer_->sectionEnd();
    dxf_.writeObjects(*writer_);
    dxf_.writeObjectsEnd(*writer_);
    writer_->dxfEOF();
    writer_->close();
  }

 private:
  void WriteTables() {
    writer_->sectionTables();
    dxf_.writeVPort(*writer_);
    writer_->tableLinetypes(3);
    for (const char* type : {"BYBLOCK", "BYLAYER", "CONTINUOUS"})
      dxf_.writeLinetype(*writer_, DL_LinetypeData(type, "", 0, 0, 0));
    writer_->tableEnd();
    writer_->tableLayers(4);
    const auto layer = [&](const char* name, int colour) {
      dxf_.writeLayer(*writer_, DL_LayerData(name, 0), DL_Attributes("", colour, -1, "CONTINUOUS", 1.0));
    };
    layer("0", 7), layer("OUTLINE", 7), layer("HOLES", 1), layer("LABELS", 5);
    writer_->tableEnd();
    writer_->tableStyle(1);
    dxf_.writeStyle(*writer_, DL_StyleData("Standard", 0, 0, 1, 0, 0, 2.5, "txt", ""));
    writer_->tableEnd();
    dxf_.writeView(*writer_);
    dxf_.writeUcs(*writer_);
    writer_->tableAppid(1);
    dxf_.writeAppid(*writer_, "ACAD");
    writer_->tableEnd();
    dxf_.writeDimStyle(*writer_, 1, 1, 1, 1, 1);
    dxf_.writeBlockRecord(*writer_);
    writer_->tableEnd();
    writer_->sectionEnd();
    writer_->sectionBlocks();
    for (const char* block : {"*Model_Space", "*Paper_Space", "*Paper_Space0"}) {
      dxf_.writeBlock(*writer_, DL_BlockData(block, 0, 0, 0, 0));
      dxf_.writeEndBlock(*writer_, block);
    }
    writer_->sectionEnd();
  }

  const DL_Attributes kOutline{"OUTLINE", 256, -1, "BYLAYER", 1.0};
  const DL_Attributes kHole{"HOLES", 256, -1, "BYLAYER", 1.0};
  const DL_Attributes kLabel{"LABELS", 256, -1, "BYLAYER", 1.0};
  DL_Dxf dxf_;
  std::unique_ptr<DL_WriterA> writer_;
};

std::vector<Plate> PlatesOf(const linkage::Links& l) {
  const auto bar = [](const char* joints, const char* symbol, double length) {
    return Plate{{{0, 0}, {length, 0}}, {fmt::format("{} {} = {:.3f}", joints, symbol, length)}};
  };
  // The thigh plate lies down: y of the thigh along x of the sheet, so M is to its left.
  const Plate thigh{{{0, 0}, {l.l3 + l.l6, -l.l5}, {l.l3, 0}},
                    {fmt::format("KPM l3 = {:.3f}", l.l3), fmt::format("l5 = {:.3f} l6 = {:.3f}", l.l5, l.l6)}};
  return {bar("RS", "l1", l.l1), bar("PR", "l2", l.l2), bar("KS", "l4", l.l4), thigh};
}

// The outline is the middle line's hull, moved out by the radius: a line along each side, an arc about each pin.
void DrawPlate(Sheet& sheet, const Plate& plate, const Vector2d& at, const PlateOptions& options) {
  const double radius = options.bar_width_mm / 2;
  const std::size_t count = plate.pins.size();
  std::vector<double> outward(count);  // heading of the normal of the side that starts at each pin
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d side = plate.pins[(i + 1) % count] - plate.pins[i];
    outward[i] = std::atan2(-side.x(), side.y());
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d out = radius * Vector2d(std::cos(outward[i]), std::sin(outward[i]));
    sheet.Line(at + plate.pins[i] + out, at + plate.pins[(i + 1) % count] + out);
    sheet.Arc(at + plate.pins[i], radius, outward[(i + count - 1) % count], outward[i]);
    sheet.Hole(at + plate.pins[i], options.pin_diameter_mm / 2);
  }
  constexpr double kTextHeight_mm = 4;
  for (std::size_t i = 0; i < plate.label.size(); ++i)
    sheet.Text(at + Vector2d(0, radius + 2 + (plate.label.size() - 1 - i) * 1.5 * kTextHeight_mm), kTextHeight_mm,
               plate.label[i]);
}

// dxflib does not tell whether it could write. Its stream writes nothing more once a write has failed, so a file that
// ends as it should is whole.
void CheckWhole(const std::filesystem::path& written, const std::filesystem::path& path) {
  if (!Trim(ReadTextFile(written)).ends_with("EOF"))
    throw Fail("{}: cannot be written whole; is the disk full?", path.string());
}

}  // namespace

void PlateOptions::Check() const {
  if (!(bar_width_mm > 0 && bar_width_mm < 1000)) throw Fail("a plate width of {} mm cannot be cut", bar_width_mm);
  if (!(pin_diameter_mm > 0 && pin_diameter_mm < bar_width_mm))
    throw Fail("a pin of {} mm does not fit a plate of {} mm", pin_diameter_mm, bar_width_mm);
}

void WriteLinkPlates(const std::filesystem::path& path, const linkage::Links& links, const PlateOptions& options) {
  linkage::CheckLinks(links, path.string());
  options.Check();
  AtomicFile file(path);
  Sheet sheet(file.TemporaryPath());
  Vector2d at(0, 0);
  for (const Plate& plate : PlatesOf(links)) {
    DrawPlate(sheet, plate, at, options);
    double lowest = 0;
    for (const Vector2d& pin : plate.pins) lowest = std::min(lowest, pin.y());
    constexpr double kLabels_mm = 14;
    at.y() += lowest - options.bar_width_mm - options.gap_mm - kLabels_mm;
  }
  sheet.Finish();
  CheckWhole(file.TemporaryPath(), path);
  file.Commit();
}

}  // namespace lake::drawing
