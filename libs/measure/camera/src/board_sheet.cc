#include <cairo-pdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "lake/camera/board.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake::camera {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kRim = 0.3;      // of a square, white around the board
constexpr double kMarginMm = 5;   // printers leave a rim
constexpr double kFooterMm = 16;  // ruler and text
constexpr double kTickMm = 4;     // of the ruler, at every 10 mm
constexpr double kLineMm = 0.2;

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

// Where the board goes on the sheet; mm from its top left corner, y down.
struct Layout {
  double left, top;  // of the board's squares
  double ruler_left, ruler_y, ruler_mm;
};

Layout LayOut(const Board& board, const Paper& paper) {
  const double s = board.square_mm, width = board.SquareColumns() * s, height = board.SquareRows() * s;
  const double room_x = paper.width_mm, room_y = paper.height_mm - kFooterMm;
  if (width + 2 * kRim * s > room_x || height + 2 * kRim * s > room_y) {
    const double largest =
        std::min(room_x / (board.SquareColumns() + 2 * kRim), room_y / (board.SquareRows() + 2 * kRim));
    throw Fail("the board {} does not fit on {} ({} x {} mm) with a white rim; its squares can be {:.1f} mm",
               ToString(board), paper.name, paper.width_mm, paper.height_mm, std::floor(largest * 10) / 10);
  }
  return {.left = (paper.width_mm - width) / 2,
          .top = (room_y - height) / 2,
          .ruler_left = kMarginMm + 5,
          .ruler_y = paper.height_mm - kMarginMm - 6,
          .ruler_mm = std::min(200.0, 50 * std::floor((room_x - 110) / 50))};
}

void DrawBoard(cairo_t* context, const Board& board, const Layout& layout) {
  const double s = board.square_mm;
  // One path for all, so that cells that touch leave no hairline; board frame to sheet: y turns over.
  for (const BoardRectangle& r : BoardInk(board))
    cairo_rectangle(context, layout.left + s + r.left, layout.top + (board.SquareRows() - 1) * s - r.bottom - r.height,
                    r.width, r.height);
  cairo_fill(context);
}

void DrawText(cairo_t* context, double x, double y, double size_mm, const std::string& text) {
  cairo_set_font_size(context, size_mm);
  cairo_move_to(context, x, y);
  cairo_show_text(context, text.c_str());
}

void DrawRuler(cairo_t* context, const Layout& layout) {
  cairo_set_line_width(context, kLineMm);
  for (double mm = 0; mm <= layout.ruler_mm; mm += 10) {
    const double tick = std::fmod(mm, 50) == 0 ? kTickMm : kTickMm / 2;
    cairo_move_to(context, layout.ruler_left + mm, layout.ruler_y);
    cairo_line_to(context, layout.ruler_left + mm, layout.ruler_y - tick);
  }
  cairo_move_to(context, layout.ruler_left - kLineMm / 2, layout.ruler_y);
  cairo_line_to(context, layout.ruler_left + layout.ruler_mm + kLineMm / 2, layout.ruler_y);
  cairo_stroke(context);
  for (double mm = 0; mm <= layout.ruler_mm; mm += 50)
    DrawText(context, layout.ruler_left + mm - (mm == 0 ? 0.8 : 3), layout.ruler_y + 4, 3, fmt::format("{:.0f}", mm));
}

void DrawPage(cairo_t* context, const Board& board, const Layout& layout) {
  cairo_scale(context, kPointsPerMm, kPointsPerMm);
  cairo_set_source_rgb(context, 0, 0, 0);
  DrawBoard(context, board, layout);
  DrawRuler(context, layout);
  cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  const double x = layout.ruler_left + layout.ruler_mm + 10;
  DrawText(context, x, layout.ruler_y - 1, 3.2, "--board " + ToString(board));
  DrawText(context, x, layout.ruler_y + 4, 2.8, "Print at 100 %. The ruler must measure");
  DrawText(context, x, layout.ruler_y + 8, 2.8,
           fmt::format("{:.0f} mm. Glue it on a flat, stiff plate.", layout.ruler_mm));
}

cairo_status_t Append(void* text, const unsigned char* bytes, unsigned count) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Paper ParsePaper(std::string_view name) {
  static const std::array kPapers = {Paper{"a4", 297, 210}, Paper{"a3", 420, 297}, Paper{"letter", 279.4, 215.9}};
  for (const Paper& paper : kPapers)
    if (paper.name == name) return paper;
  throw UsageError("--paper '{}': a4, a3 and letter are known", name);
}

void WriteBoardSheet(const std::filesystem::path& path, const Board& board, const Paper& paper) {
  const Layout layout = LayOut(board, paper);
  std::string pdf;  // in memory first: cairo writes files without looking whether the disk took them
  const Surface surface(
      cairo_pdf_surface_create_for_stream(Append, &pdf, paper.width_mm * kPointsPerMm, paper.height_mm * kPointsPerMm),
      cairo_surface_destroy);
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, ToString(board).c_str());
  // A fixed date: the same board is the same file.
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  const Context context(cairo_create(surface.get()), cairo_destroy);
  DrawPage(context.get(), board, layout);
  cairo_show_page(context.get());
  cairo_surface_finish(surface.get());
  if (const cairo_status_t status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS)
    throw Fail("{}: the board cannot be written: {}", path.string(), cairo_status_to_string(status));
  WriteTextFile(path, pdf);
}

}  // namespace lake::camera
