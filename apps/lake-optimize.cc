// Finds the links that give the largest range of rotation, proves it, and says what it is worth; with a human's motion
// it does the work of lake-redesign.
#include <filesystem>
#include <optional>
#include <string>

#include "lake/commands/optimize.h"
#include "lake/core/option_template.h"
#include "lake/problem/problem_file.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program(
      "lake-optimize",
      "The links that give the largest range of rotation. Those that follow a person's knee: lake redesign, whose "
      "options are known here, too.",
      "lake-optimize --starts 20 --grashof-margin 2 --singularity-margin 2 --certify -o lake-out/design\n"
      "  lake-optimize --profile lake-out/loads --assist 0.4 --actuator LA31-1000 --duration free");
  lake::commands::OptimizeRunOptions options;
  lake::commands::ReoptimizeRunOptions reoptimize;
  std::optional<std::filesystem::path> make_template;
  lake::OptionList other;
  other
      .Add("template", make_template,
           "Write a problem.yaml with every key, its default and its meaning; do nothing else")
      .Value("FILE");
  program.Add(
      lake::OptionsOf(options).WithUsual({"problem", "grashof-margin", "singularity-margin", "profile", "assist",
                                          "actuator", "duration", "starts", "certify", "yield", "round", "actuators"}));
  program.Add(std::move(other));
  // The duration stands among the problem's options.
  const auto motion = program.Add(lake::OptionsOf(reoptimize).Without({"duration"}).WithUsual({}));
  return program.Main(
      argc, argv, [] { return std::string("optimize"); },
      [&](lake::Run& run) {
        if (make_template) {
          lake::WriteTemplateFile(*make_template, lake::problem::ProblemTemplate());
          return lake::Json();
        }
        options.study.quiet = options.study.optimize.quiet = run.Quiet();
        if (motion->IsAnyGiven()) options.reoptimize = reoptimize;
        return lake::commands::RunOptimize(options, run);
      });
}
