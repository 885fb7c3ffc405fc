#include "lake/live/run_live.h"

#ifdef LAKE_HAS_LIBAVDEVICE
extern "C" {
#include <libavdevice/avdevice.h>
}
#endif

#include <cstdio>

#include "lake/compare/misalignment_options.h"
#include "lake/core/atomic_file.h"
#include "lake/core/counted.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"
#include "lake/gait/learnt_knee.h"
#include "lake/review/open_browser.h"
#include "lake/tracking/track_markers.h"
#include "session.h"
#include "trial.h"

namespace lake::live {

namespace fs = std::filesystem;

namespace {

// The address goes to stderr: stdout has the report, or with --json the summary.
void Announce(const std::string& address, const review::PageOptions& page) {
  if (const std::string warning = WhoCanReach(page); !warning.empty()) fmt::print(stderr, "lake-live: {}\n", warning);
  fmt::print(stderr, "{}\nOpen this address in a browser; Ctrl-C ends the recording.\n", address);
  std::fflush(stderr);
  if (page.open) review::OpenInBrowser("lake-live", address);
}

std::vector<std::string> ArgumentsIn(const fs::path& folder) {
  return ReadJsonFile(folder / kLive).at("track_arguments").get<std::vector<std::string>>();
}

// A killed program may have written a part of the last row.
void DropTornRow(const fs::path& table) {
  if (!fs::exists(table)) return;
  const std::string text = ReadTextFile(table);
  if (!text.empty() && text.back() != '\n') WriteTextFile(table, text.substr(0, text.rfind('\n') + 1));
}

std::string ReportOf(const LiveFigures& figures) {
  std::string text =
      fmt::format("{} in {:.1f} s recorded; {}\n", Counted(figures.frames, "frame"), figures.recorded_s, figures.ended);
  if (const auto& place = figures.place)
    text += fmt::format("after {} the joint sits {}\n{}\n", Counted(place->rises, "rise"), place->where, place->move);
  else
    text += "no rise was measured\n";
  if (figures.difference_px)
    text += fmt::format("live positions differ from lake track's by {:.3f} px RMS\n", *figures.difference_px);
  return text;
}

// Of the session that wrote this live.json.
LiveFigures RecordedFigures(const Json& live, const LiveDifference& difference) {
  LiveFigures figures{.frames = live.at("frames").get<std::int64_t>(),
                      .recorded_s = live.at("recorded_s").get<double>(),
                      .ended = live.at("ended").get<std::string>(),
                      .place = {},
                      .difference_px = difference.all.RmsPx()};
  if (const Json& place = live.at("place"); !place.is_null())
    figures.place = LiveFigures::Told{.rises = place.at("rises").get<int>(),
                                      .where = place.at("where").get<std::string>(),
                                      .move = place.at("move").get<std::string>()};
  return figures;
}

// What a program that was killed or interrupted has left.
Json FinishFolder(const LiveRunOptions& options, const fs::path& programs, Run& run) {
  const fs::path folder = options.input, recording = folder / kVideo;
  std::error_code error;
  if (!fs::equivalent(run.Folder(), folder, error))
    throw UsageError("-o {} cannot be given with a recording to finish: its trial is made in {}", run.Folder().string(),
                     folder.string());
  run.TakeFolder();  // a session may be recording there
  const bool is_unfinished = fs::exists(video::UnfinishedRecording(recording));
  if (!is_unfinished && !fs::exists(recording)) throw Fail("{}: holds no recording of lake live", folder.string());
  if (fs::exists(folder / kSummary)) throw Fail("{}: is a trial already", folder.string());
  if (is_unfinished) video::CompleteRecording(recording);
  for (const char* table : {kTracks, kRises, kMoves}) DropTornRow(folder / table);
  const auto say = [](const std::string&) {};
  run.ReleaseFolder();
  TrackTrial(programs, folder, ArgumentsIn(folder), say, [] { ThrowIfInterrupted(); });
  Json live = ReadJsonFile(folder / kLive);
  const LiveDifference difference = FindDifference(motion::ReadMarkerCsv(folder / kTracks), folder);
  live["difference"] = DifferenceJson(difference);
  if (live["ended"].is_null()) live["ended"] = "the program was interrupted";
  WriteJsonFile(folder / kLive, live);
  run.Report(ReportOf(RecordedFigures(live, difference)));
  return live;
}

// That the trial was not made is what the interruption asked for; that the recording was not completed is not.
void FinishInterrupted(Session& session, const fs::path& folder) {
  std::string why;
  try {
    session.Finish();
  } catch (const std::exception& error) {
    why = FaultText(error);
  }
  if (fs::exists(folder / kVideo) && !fs::exists(folder / kSummary))
    fmt::print(stderr, "lake-live: the recording is whole; make a trial of it with: lake live {}\n", folder.string());
  else if (!why.empty())
    fmt::print(stderr, "lake-live: {}\n", why);
}

}  // namespace

void Describe(LiveRunOptions& o, OptionList& options) {
  options
      .AddOperand("input", o.input,
                  "A camera (/dev/video0), a stream (rtsp://, udp://, tcp://, http://), - for standard input, a pipe, "
                  "with --replay a file; or the folder of a recording that was interrupted, to finish it")
      .Required()
      .IsPath(Option::Path::kVideo);
  video::Describe(o.stream, options);
  Describe(static_cast<gait::PictureScale&>(o), options);
  gait::DescribeDepths(o.depths, options);
  tracking::DescribeNames(o.markers, o.seeds, options);
  tracking::DescribePolarity(o.polarity, options);
  tracking::DescribeCrop(o.crop, options);
  gait::Describe(o.fit.technical, options);
  gait::DescribeKneeFrom(o.fit.knee_trial, options);
  options.Check([&o](const OptionList&) { gait::AddTechnical(o.fit.technical, o.markers); });
  options.Add("joint", o.joint, "Which of the markers sits on the exoskeleton's joint").Value("NAME");
  compare::DescribeJointAt(o.joint_at_mm, options);
  options.Add("tolerance", o.tolerance_mm, "How far the joint may be from the knee").Unit("mm").Positive();
  options.Add("overlay", o.overlay, "Let lake track write overlay.mp4").WithNegation();
  review::Describe(o.page, options);
}

bool IsFolderToFinish(const LiveRunOptions& options) {
  std::error_code error;
  return fs::is_directory(options.input, error);
}

Json RunLive(const LiveRunOptions& options, const fs::path& programs, Run& run) {
  if (IsFolderToFinish(options)) return FinishFolder(options, programs, run);
#ifdef LAKE_HAS_LIBAVDEVICE
  avdevice_register_all();
#endif
  Session session(options, programs, run);
  review::PageOptions page = options.page;
  page.ready = [&](const std::string& address) {
    Announce(address, options.page);
    session.Start();
  };
  try {
    review::ServeLive(page, session.PageWork());
    session.Finish();
  } catch (const Interrupted&) {
    session.Abandon();
    FinishInterrupted(session, run.Folder());
    throw;
  }
  run.Report(ReportOf(session.Figures()));
  return session.LiveJson();
}

}  // namespace lake::live
