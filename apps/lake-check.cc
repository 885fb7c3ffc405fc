// lake-check: what a recording is worth, in seconds, before the subject goes home.
#include "lake/commands/check.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "program.h"

namespace {

cv::Rect CropOf(const std::string& text) {
  if (text.empty()) return {};
  const std::vector<double> n = lake::ParseNumbers(text, 4, "--crop");
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]), static_cast<int>(n[3])};
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-check", "What a recording is worth: in seconds, with what to change; exit 0 fit, 1 not",
                        "lake-check sit-to-stand.mp4");
  lake::commands::CheckRunOptions options;
  std::string video, crop, polarity = "bright";
  CLI::App& cli = program.Cli();
  cli.add_option("video", video, "Video, or image sequence as frames/%05d.png")->required();
  cli.add_option("--markers", options.check.markers, "How many markers should be seen")->check(CLI::Range(1, 40));
  cli.add_option("--polarity", polarity, "Markers brighter or darker than what is round them")
      ->check(CLI::IsMember({"bright", "dark"}));
  cli.add_option("--crop", crop, "X,Y,W,H: look only there");
  cli.add_option("--rotate", options.check.reader.rotate_deg,
                 "Turn the pictures clockwise by 90, 180 or 270, beyond what the file says")
      ->check(CLI::IsMember({0, 90, 180, 270}));
  bool fit = true;
  const int code = program.Main(
      argc, argv, [&] { return std::filesystem::path(video).stem().string() + "-check"; },
      [&](lake::Run& run) {
        options.video = video;
        options.check.crop = CropOf(crop);
        options.check.polarity =
            polarity == "dark" ? lake::tracking::Polarity::kDark : lake::tracking::Polarity::kBright;
        lake::Json results = lake::commands::RunCheck(options, run);
        fit = results["fit"].get<bool>();
        return results;
      },
      lake::commands::CheckReport);
  return code == 0 && !fit ? 1 : code;
}
