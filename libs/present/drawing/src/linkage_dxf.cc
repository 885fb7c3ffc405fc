#include "lake/drawing/linkage_dxf.h"

#include <dl_dxf.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

// A plate as it lies on the sheet.
struct Drawn {
  parts::Plate plate;
  std::vector<std::string> label;
};

class Sheet {
 public:
  explicit Sheet(const std::filesystem::path& path) : writer_(dxf_.out(path.c_str(), DL_VERSION_2000)) {
    if (!writer_) throw Fail("{}: cannot be written", path.string());
    dxf_.writeHeader(*writer_);
    writer_->dxfString(9, "$INSUNITS");
    writer_->dxfInt(70, 4);  // mm
    writer_->sectionEnd();
    WriteTables();
    writer_->sectionEntities();
  }

  // Arcs as bulges: the tangent of a quarter of their turn.
  void Outline(const std::vector<parts::OutlinePiece>& pieces, const Vector2d& at) {
    constexpr int kClosed = 1;
    dxf_.writePolyline(*writer_, DL_PolylineData(static_cast<int>(pieces.size()), 0, 0, kClosed), kOutline);
    for (const parts::OutlinePiece& piece : pieces) {
      const Vector2d from = at + piece.from;
      const double bulge = piece.is_arc ? std::tan((piece.to_rad - piece.from_rad) / 4) : 0;
      dxf_.writeVertex(*writer_, DL_VertexData(from.x(), from.y(), 0, bulge));
    }
    dxf_.writePolylineEnd(*writer_);
  }
  void Hole(const Vector2d& centre, double radius) {
    dxf_.writeCircle(*writer_, DL_CircleData(centre.x(), centre.y(), 0, radius), kHole);
  }
  void Label(const Vector2d& at, double height, const std::string& text) {
    constexpr int kLeft = 0, kBaseline = 0;
    Text(at, height, text, kLeft, kBaseline, kLabel);
  }
  void Engraving(const Vector2d& middle, double height, const std::string& text) {
    constexpr int kCentre = 1, kMiddle = 2;
    Text(middle, height, text, kCentre, kMiddle, kEngraving);
  }

  void Finish() {
    writer_->sectionEnd();
    dxf_.writeObjects(*writer_);
    dxf_.writeObjectsEnd(*writer_);
    writer_->dxfEOF();
    writer_->close();
  }

 private:
  void Text(const Vector2d& at, double height, const std::string& text, int across, int upright,
            const DL_Attributes& layer) {
    const DL_TextData data(at.x(), at.y(), 0, at.x(), at.y(), 0, height, 1, 0, across, upright, text, "Standard", 0);
    dxf_.writeText(*writer_, data, layer);
  }

  void WriteTables() {
    writer_->sectionTables();
    dxf_.writeVPort(*writer_);
    writer_->tableLinetypes(3);
    for (const char* type : {"BYBLOCK", "BYLAYER", "CONTINUOUS"})
      dxf_.writeLinetype(*writer_, DL_LinetypeData(type, "", 0, 0, 0));
    writer_->tableEnd();
    writer_->tableLayers(5);
    const auto layer = [&](const char* name, int colour) {
      dxf_.writeLayer(*writer_, DL_LayerData(name, 0), DL_Attributes("", colour, -1, "CONTINUOUS", 1.0));
    };
    layer("0", 7);
    layer("OUTLINE", 7);
    layer("HOLES", 1);
    layer("ENGRAVING", 3);
    layer("LABELS", 5);
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
  const DL_Attributes kEngraving{"ENGRAVING", 256, -1, "BYLAYER", 1.0};
  const DL_Attributes kLabel{"LABELS", 256, -1, "BYLAYER", 1.0};
  DL_Dxf dxf_;
  std::unique_ptr<DL_WriterA> writer_;
};

// The thigh plate lies down: y of the thigh along x of the sheet, so M is to its left.
parts::Plate LyingDown(parts::Plate plate) {
  const auto turn = [](Vector2d& at) { at = Vector2d(at.y(), -at.x()); };
  for (Vector2d& corner : plate.corners) turn(corner);
  for (parts::Hole& hole : plate.holes) turn(hole.at_mm);
  return plate;
}

std::vector<Drawn> DrawnPlates(const linkage::Links& l, const parts::PartOptions& options) {
  const std::array<parts::Plate, parts::kPlates> plates = parts::PlatesOf(l, options);
  const auto bar = [&](parts::Body body, const char* symbol, double length) {
    const parts::Plate& plate = plates[static_cast<std::size_t>(body)];
    return Drawn{plate, {fmt::format("{} {} = {:.3f}", plate.label, symbol, length)}};
  };
  const parts::Plate thigh = LyingDown(plates[static_cast<std::size_t>(parts::Body::kThigh)]);
  return {
      bar(parts::Body::kCoupler, "l1", l.l1),
      bar(parts::Body::kBar, "l2", l.l2),
      bar(parts::Body::kShank, "l4", l.l4),
      {thigh, {fmt::format("{} l3 = {:.3f}", thigh.label, l.l3), fmt::format("l5 = {:.3f} l6 = {:.3f}", l.l5, l.l6)}}};
}

constexpr double kTextHeight_mm = 4;

// On the first hole's right, as large as there is room up to the next hole.
void Engrave(Sheet& sheet, const parts::Plate& plate, const Vector2d& at) {
  const std::string text = fmt::format("{} {:g} mm", plate.label, plate.thickness_mm);
  const parts::Hole &first = plate.holes[0], &second = plate.holes[1];
  constexpr double kGap_mm = 1;  // to each hole
  const double room = second.at_mm.x() - first.at_mm.x() - first.diameter_mm - 2 * kGap_mm;
  constexpr double kWidthPerHeight = 1.2;  // of a character with its space, at most
  const double height =
      std::min({kTextHeight_mm, plate.radius_mm / 2, room / (kWidthPerHeight * static_cast<double>(text.size()))});
  if (height > 0) sheet.Engraving(at + (first.at_mm + second.at_mm) / 2, height, text);
}

void Draw(Sheet& sheet, const Drawn& drawn, const Vector2d& at) {
  const parts::Plate& plate = drawn.plate;
  sheet.Outline(parts::OutlineOf(plate), at);
  for (const parts::Hole& hole : plate.holes) sheet.Hole(at + hole.at_mm, hole.diameter_mm / 2);
  Engrave(sheet, plate, at);
  for (std::size_t i = 0; i < drawn.label.size(); ++i)
    sheet.Label(at + Vector2d(0, plate.radius_mm + 2 + (drawn.label.size() - 1 - i) * 1.5 * kTextHeight_mm),
                kTextHeight_mm, drawn.label[i]);
}

// dxflib does not say whether it could write. Its stream writes nothing more once a write has failed, so a file that
// ends as it should is whole.
void CheckWhole(const std::filesystem::path& written, const std::filesystem::path& path) {
  if (!Trim(ReadTextFile(written)).ends_with("EOF"))
    throw Fail("{}: cannot be written whole; is the disk full?", path.string());
}

}  // namespace

void WriteLinkPlates(const std::filesystem::path& path, const linkage::Links& links,
                     const parts::PartOptions& options) {
  const std::vector<Drawn> plates = DrawnPlates(links, options);
  AtomicFile file(path);
  Sheet sheet(file.TemporaryPath());
  Vector2d at(0, 0);
  for (const Drawn& drawn : plates) {
    Draw(sheet, drawn, at);
    double lowest = 0;
    for (const Vector2d& corner : drawn.plate.corners) lowest = std::min(lowest, corner.y());
    constexpr double kGapAndLabels_mm = 29;
    at.y() += lowest - options.bar_width_mm - kGapAndLabels_mm;
  }
  sheet.Finish();
  CheckWhole(file.TemporaryPath(), path);
  file.Commit();
}

}  // namespace lake::drawing
