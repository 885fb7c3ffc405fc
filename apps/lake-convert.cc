// lake-convert: a trial in another program's format. Writes one file, so it has no folder of results.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/trial.h"

namespace {

int Complain(const std::string& text, int code) {
  fmt::print(stderr, "lake-convert: {}\n", text);
  return code;
}

// Angles: from kinematics.csv (or a folder that has one) to MOT. Everything else is points.
void Convert(const std::filesystem::path& in, const std::filesystem::path& out, double mm_per_unit,
             bool flexion_negative) {
  if (out.extension() == ".mot" || out.extension() == ".sto") {
    const auto table = std::filesystem::is_directory(in) ? in / "kinematics.csv" : in;
    if (table.extension() == ".mot" || table.extension() == ".sto")
      lake::WriteMot(out, lake::ReadMot(table));
    else
      lake::WriteMot(out, lake::MotFromLegMotion(lake::ReadKinematicsCsv(table), flexion_negative));
    return;
  }
  lake::WritePoints(out, lake::ReadPoints(in, mm_per_unit));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli(
      "A trial in another format: .trc, .c3d, .txt (Tracker), .csv (lake), _kinovea.csv, .mot (from kinematics.csv)",
      "lake-convert");
  cli.footer("Example:\n  lake-convert walking.c3d walking.trc");
  std::string in, out;
  double mm_per_unit = 1;
  bool flexion_negative = false;
  cli.add_option("in", in, "A lake-track folder, or .trc, .c3d, .trk, .txt, .csv, .mot")->required();
  cli.add_option("out", out, "The file to write; its ending says the format")->required();
  cli.add_option("--mm-per-unit", mm_per_unit, "Of files that do not say their unit (Tracker text, Kinovea)")
      ->capture_default_str();
  cli.add_flag("--flexion-negative", flexion_negative, "Knee angle of a .mot as OpenSim's older models have it");
  cli.set_version_flag("--version", fmt::format("lake-convert {}", lake::Version()));
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? cli.exit(error)
                                      : Complain(std::string(error.what()) + "; see lake-convert --help", 2);
  }
  try {
    Convert(in, out, mm_per_unit, flexion_negative);
    return 0;
  } catch (const lake::UsageError& error) {
    return Complain(error.what(), 2);
  } catch (const std::exception& error) {
    return Complain(error.what(), 1);
  }
}
