// lake-gait: leg vectors, knee angle and sit-to-stand events from an existing trial.
#include "lake/commands/gait.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-gait", "Leg vectors, knee angle and sit-to-stand events from an existing trial",
                        "lake-gait trial.trc --map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS -o gait");
  lake::commands::GaitRunOptions options;
  program.Add(
      lake::OptionsOf(options).WithUsual({"map", "camera", "scale", "plane-points", "facing", "movement", "technical",
                                          "knee-from", "events", "forces", "sync", "neutral", "reference"}));
  return program.Main(
      argc, argv, [&] { return options.trial.stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunGait(options, run); });
}
