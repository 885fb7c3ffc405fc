// lake-convert: a trial in another program's format. Writes one file, so it has no folder of results.
#include <fmt/format.h>

#include <filesystem>

#include "lake/exchange/convert.h"
#include "program.h"

int main(int argc, char** argv) {
  std::filesystem::path in, out;
  lake::exchange::ConvertOptions options;
  lake::OptionList list;
  list.AddOperand("in", in,
                  "A lake-track or lake-gait folder, " + lake::exchange::ReadableEndings() +
                      ", .mot, .sto, a folder with one .txt or .csv per marker, or a camera's file")
      .Required();
  list.AddOperand("out", out, "The file to write").Required();
  Describe(options, list);
  return lake::RunTool("lake-convert",
                       "A trial in another program's format. The ending of OUT says which:\n"
                       "  .trc          OpenSim, Pose2Sim: 3-D, y up\n"
                       "  .c3d          Vicon, Qualisys, Visual3D\n"
                       "  .txt, .trk    Tracker: table in mm or px; project over the video (px)\n"
                       "  _kinovea.csv, .kva   Kinovea: table; annotations over the video (px)\n"
                       "  .csv          lake\n"
                       "  .mot, .sto    OpenSim: knee angle and tilts, from kinematics.csv or a folder that has one\n"
                       "  .yaml         a camera of ROS, kalibr, Pose2Sim, caliscope, Vicon, Qualisys or OpenCV",
                       "Examples:\n"
                       "  lake-convert walking.c3d walking.trc --forward +x\n"
                       "  lake-convert trial.trc side.csv --map ankle=RANK,knee=RKNE,hip=RHIP --crop 2.5,6\n"
                       "  lake-convert lake-out/human human.mot --flexion-negative",
                       std::move(list), argc, argv, [&] {
                         for (const std::string& warning : lake::exchange::ConvertFile(in, out, options))
                           fmt::print(stderr, "lake-convert: warning: {}\n", warning);
                       });
}
