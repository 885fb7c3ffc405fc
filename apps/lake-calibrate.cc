// lake-calibrate: a camera from pictures of a board; the sagittal plane from one picture; boards to print.
#include <filesystem>
#include <functional>
#include <optional>

#include "lake/camera/camera.h"
#include "lake/commands/calibrate.h"
#include "lake/core/option_template.h"
#include "program.h"

int main(int argc, char** argv) {
  using namespace lake;
  Program program("lake-calibrate", "A camera from pictures of a board, with error bars",
                  "lake-calibrate board/*.jpg --board chessboard:9x6:25 -o camera");
  commands::CalibrateRunOptions calibrate;
  commands::PlaneRunOptions plane;
  commands::SheetRunOptions sheet;
  std::optional<std::filesystem::path> make_template;
  OptionList other;
  other
      .Add("template", make_template,
           "Write a camera.yaml with every key and its meaning, for a lens that is known from elsewhere; do nothing "
           "else")
      .Value("FILE");
  program.Add(OptionsOf(calibrate));
  program.Add(std::move(other));
  const std::function<bool()> plane_command = program.AddCommand(
      "plane", "The sagittal plane from one board image or four and more known points",
      "lake-calibrate plane board.png --camera camera.yaml --board chessboard:9x6:25 -o plane", OptionsOf(plane));
  const std::function<bool()> sheet_command =
      program.AddCommand("board", "A board to print, as PDF 1:1",
                         "lake-calibrate board --board chessboard:9x6:25 --paper a4 -o print", OptionsOf(sheet));
  return program.Main(
      argc, argv, [] { return "calibrate"; },
      [&](Run& run) {
        if (plane_command()) return commands::RunPlane(plane, run);
        if (sheet_command()) return commands::RunSheet(sheet, run);
        if (make_template) {
          WriteTemplateFile(*make_template, camera::CameraTemplate());
          return Json();
        }
        return commands::RunCalibrate(calibrate, run);
      });
}
