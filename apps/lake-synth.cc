// lake-synth: a rendered recording of a sit-to-stand or a walk with its ground truth.
#include "lake/synth/synth_run.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-synth", "Renders a recording of a sit-to-stand or a walk with its ground truth.",
                        "lake-synth --scene hard --seed-number 7 --facing left --crf 23 -o renderings/hard7");
  lake::synth::SynthRunOptions options;
  program.Add(lake::OptionsOf(options).WithUsual({"scene", "seed-number", "facing", "movement", "repetitions", "exo",
                                                  "hub", "motion", "duration", "rate", "width", "height", "camera",
                                                  "markers", "depth", "crf"}));
  return program.Main(
      argc, argv, [&] { return "synth-" + lake::synth::NameOf(options); },
      [&](lake::Run& run) { return lake::synth::RunSynth(options, run); });
}
