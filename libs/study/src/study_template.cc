#include "lake/study/study_template.h"

#include <fmt/format.h>

#include "lake/core/option_template.h"
#include "lake/study/study_file.h"
#include "lake/synthesis/synthesis_options.h"
#include "section_keys.h"

namespace lake::study {
namespace {

template <typename Options>
std::string KeysOf(const OptionNames& without = {}, int indent = 2) {
  Options options;
  return OptionTemplate(OptionsOf(options).Without(without), indent);
}

std::string Section(std::string_view name, std::string_view meaning, const std::string& keys) {
  return fmt::format("\n# {}\n{}:\n{}", meaning, name, keys);
}

// One that may be left out.
std::string Optional(std::string_view name, std::string_view meaning, const std::string& keys) {
  return fmt::format("\n# {}\n{}", meaning, AsComment(fmt::format("{}:\n{}", name, keys)));
}

std::string Line(std::string_view key, std::string_view value, std::string_view meaning) {
  return TemplateLine(key, value, meaning, 2);
}

std::string CalibrationSection() {
  return "# Instead of the line above:\n" +
         AsComment("camera:\n  calibrate:\n" +
                   TemplateLine("images", "'board/*.png'", "pictures of the board; or video: FILE", 4) +
                   KeysOf<commands::CalibrateRunOptions>(kGivenToCalibration, 4) + "    plane:\n" +
                   KeysOf<commands::PlaneRunOptions>(kGivenToPlane, 6));
}

}  // namespace

std::string StudyTemplate() {
  return "# A study for `lake run`. Paths are relative to this file. Remove the '#' before a key, and before its "
         "section,\n"
         "# to set it; the values shown are the defaults or examples.\n" +
         TemplateLine("name", "My study", "stands above the report") +
         AsComment(TemplateLine("out", "lake-out/my-study", "folder for the results") +
                   TemplateLine("folder", "recordings", "folder that all paths below are relative to")) +
         TemplateLine("camera", "camera.yaml", "lens and sagittal plane, from lake calibrate") + CalibrationSection() +
         Section("human", "The trial without exoskeleton.",
                 Line("video", "human.mp4", "video, or image sequence as frames/%05d.png") +
                     AsComment(KeysOf<commands::TrackRunOptions>({"video"}), 2)) +
         Section("exo", "The trial with it. Without this section there is nothing to compare.",
                 Line("video", "exo.mp4", "the keys are those of `human`") +
                     Line("markers", "[ankle, knee, hip, waist, exo_knee]",
                          "the leg's, and that of the exoskeleton's joint") +
                     Line("seeds", "['exo_knee=640,360']", "where the joint's marker is in the first frame, px")) +
         Optional("human", "A trial that was tracked before, in the place of a video; exo likewise.",
                  Line("trial", "human.trc", "a lake track folder, or .csv, .trc, .c3d, .trk, .txt") +
                      KeysOf<commands::GaitRunOptions>({"trial"})) +
         Optional("compare", "How the two trials are compared.", KeysOf<commands::CompareRunOptions>(kGivenToCompare)) +
         Optional("design", "The largest range of rotation, whoever wears it.",
                  Line("problem", "problem.yaml", "what it must satisfy: lake optimize --template problem.yaml") +
                      Line("worn", "worn.yaml", "the design that was worn in the exo trial") +
                      KeysOf<synthesis::SynthesisOptions>()) +
         Optional("reoptimize", "A design for this person; with an exo trial it needs design: {worn: FILE}.",
                  Line("balance", "{margin_mm: 20}", "the person keeps the balance all along; needs loads") +
                      KeysOf<synthesis::SynthesisOptions>() +
                      KeysOf<commands::ReoptimizeRunOptions>(kGivenToRedesign)) +
         Optional("loads", "The moments at the joints of the trial without exoskeleton.",
                  KeysOf<commands::LoadsRunOptions>(kGivenToLoads)) +
         Optional("assistance", "The links with which an actuator provides the knee moment; needs loads.",
                  Line("problem", "problem.yaml", "as in design") +
                      Line("actuator", "LA31-1000", "a name of the catalogue, or a file") +
                      KeysOf<commands::OptimizeRunOptions>(kGivenToAssistance)) +
         Optional("simulate", "The body on which designs are drawn and held against seat and limbs.",
                  KeysOf<commands::SimulationOptions>(kGivenToSimulation)) +
         Optional("stroke", "The actuator's stroke program and firmware.",
                  KeysOf<commands::StrokeRunOptions>(kGivenToStroke));
}

}  // namespace lake::study
