#include "lake/commands/review.h"

#include <spawn.h>

#include <csignal>
#include <cstdio>
#include <memory>

#include "lake/core/error.h"
#include "lake/review/review.h"
#include "review_naming.h"

extern char** environ;

namespace lake::commands {

namespace fs = std::filesystem;

namespace {

// With the desktop's own program for addresses.
void OpenInBrowser(std::string address) {
  std::signal(SIGCHLD, SIG_DFL);
  std::string program = "xdg-open";
  char* const words[] = {program.data(), address.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, program.c_str(), nullptr, nullptr, words, environ) != 0)
    fmt::print(stderr, "lake-review: xdg-open is not there; open the address yourself\n");
}

void Announce(const std::string& address, bool open) {
  fmt::print("{}\nOpen this address in a browser; closing the page or Ctrl-C ends it.\n", address);
  std::fflush(stdout);
  if (open) OpenInBrowser(address);
}

// What is measured near a click as the tracker did it; nullopt for markers that are no blobs in the luma.
std::optional<tracking::Polarity> BlobsOf(const tracking::TrackOptions& track) {
  return track.detector == tracking::DetectorKind::kReflective ? std::optional(track.polarity) : std::nullopt;
}

}  // namespace

void Describe(ReviewRunOptions& o, OptionList& options) {
  options.AddOperand("subject", o.subject, "A lake-track folder, or a video whose markers are to be named")
      .Required()
      .IsPath(Option::Path::kVideo);
  options.Add("port", o.port, "Port on 127.0.0.1").Between(0, 65535).Otherwise("any that is free");
  options.Add("open", o.open, "Open the page in the browser");
}

review::ReviewedTrial ReviewedTrialOf(TrackedFolder tracked_folder) {
  const auto folder = std::make_shared<TrackedFolder>(std::move(tracked_folder));
  const auto fit = [folder](const motion::MarkerRecording& corrected) {
    tracking::TrackResult tracked = folder->tracked;
    tracked.recording = corrected;
    TrackFit fitted = FitTracked(folder->options, tracked);
    return review::TrialFit{std::move(fitted.leg), std::move(fitted.tracks), std::move(fitted.estimates),
                            std::move(fitted.warnings)};
  };
  const auto save = [folder](const review::CorrectionBook& book) { SaveCorrections(*folder, book.Corrections()); };
  const video::VideoInfo& video = folder->tracked.video;
  const std::vector<std::int64_t>& repeated = folder->tracked.times.repeated;
  return {review::CorrectionBook(folder->tracked.recording, video.width, video.height, repeated, folder->made),
          repeated,
          {fit, save},
          BlobsOf(folder->options.track),
          {{"name", folder->options.video.filename().string()},
           {"folder", folder->folder.string()},
           {"command", folder->command},
           {"width", video.width},
           {"height", video.height}}};
}

void RunReview(const ReviewRunOptions& options, const fs::path& programs) {
  review::ReviewOptions page;
  page.port = options.port;
  page.ready = [&options](const std::string& address) { Announce(address, options.open); };
  if (!fs::is_directory(options.subject)) {
    page.video = options.subject;
    return review::ServeReview(page, std::nullopt, NamingOf(options.subject, programs));
  }
  TrackedFolder folder = ReadTrackedFolder(options.subject);
  page.video = folder.options.video;
  page.reader = folder.options.track.reader;
  review::ServeReview(page, ReviewedTrialOf(std::move(folder)), std::nullopt);
}

}  // namespace lake::commands
