// A tracked trial is corrected as lake-review does it: lake-track with these corrections gives the same numbers.
#include <gmock/gmock.h>

#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "file_limit.h"
#include "home_folder.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/gait/movement.h"
#include "lake/reviewing/run_review.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using review::CorrectionBook;
using review::ReviewedTrial;
using testing::HasSubstr;
using testing::ThrowsMessage;

class CorrectedTrial : public testing::Test {
 protected:
  // Tracked once for all.
  CorrectedTrial() {
    static const TemporaryFolder tracked;
    if (!fs::exists(tracked / "trial")) TrackInto(tracked / "trial");
    fs::copy(tracked / "trial", Folder("trial"));
  }

  // The recording that ctest has rendered (lake_add_recording).
  static fs::path Recording(const std::string& name) {
    return BinDir().parent_path() / "recordings/short_recording" / name;
  }
  fs::path Folder(const std::string& name) const { return folder_ / name; }

  // As the program does it, with what it keeps of its command line.
  void Track(const std::string& name, const std::optional<fs::path>& corrections = {},
             const std::optional<fs::path>& events = {}) const {
    TrackInto(Folder(name), corrections, events);
  }
  static void TrackInto(const fs::path& out, const std::optional<fs::path>& corrections = {},
                        const std::optional<fs::path>& events = {}) {
    commands::TrackRunOptions options;
    options.video = Recording("video.mp4");
    options.camera = Recording("camera.yaml");
    options.overlay = false;
    options.track.quiet = true;
    options.corrections = corrections;
    options.events = events;
    Json said = {{"out", out.string()},
                 {"video", options.video.string()},
                 {"camera", options.camera->string()},
                 {"overlay", "false"},
                 {"markers", "ankle,knee,hip,waist"}};
    std::vector<std::string> given = {"video", "camera", "overlay"};
    const auto give = [&](const char* option, const std::optional<fs::path>& file) {
      said[option] = file ? file->string() : "";
      if (file) given.emplace_back(option);
    };
    give("corrections", corrections);
    give("events", events);
    lake::Run run({"lake-track", "test", said, out, true, {}, false, "", given});
    run.WriteSummary(commands::RunTrack(options, run));
  }

  fs::path Copy(const std::string& name) const {
    fs::copy(Folder("trial"), Folder(name));
    return Folder(name);
  }

  static ReviewedTrial Open(const fs::path& folder) {
    return reviewing::ReviewedTrialOf(reviewing::ReadTrackedFolder(folder), BinDir());
  }

  // Moved, hidden, and names that were exchanged for three frames.
  static void Correct(CorrectionBook& book) {
    const Eigen::Vector2d knee = book.Detected().Find("knee")->samples[20].position;
    book.Place(20, "knee", knee + Eigen::Vector2d(0.75, -0.5), 0.5);
    book.Hide(50, "hip");
    book.SwapFrom(80, "hip", "waist");
    book.SwapFrom(83, "hip", "waist");
  }

  static void ExpectSameTables(const review::TrialFit& fit, const fs::path& folder) {
    const TemporaryFolder tables;
    motion::WriteKinematicsCsv(tables / "kinematics.csv", fit.leg->motion);
    motion::WriteEventsCsv(tables / "events.csv", fit.leg->events);
    motion::WriteMarkerCsv(tables / "tracks.csv", fit.tracks);
    for (const char* name : {"kinematics.csv", "events.csv", "tracks.csv"})
      EXPECT_EQ(ReadTextFile(tables / name), ReadTextFile(folder / name)) << name;
  }

  TemporaryFolder folder_;
};

TEST_F(CorrectedTrial, IsTheFoldersOwnBeforeAnyCorrection) {
  const ReviewedTrial trial = Open(Folder("trial"));
  ExpectSameTables(trial.work.fit(trial.book.Corrected()), Folder("trial"));
  EXPECT_THAT(trial.about["command"].get<std::string>(),
              testing::AllOf(testing::StartsWith("lake track "), HasSubstr("--camera"), HasSubstr("--no-overlay"),
                             HasSubstr("--corrections " + (Folder("trial") / "corrections.csv").string())));
}

TEST_F(CorrectedTrial, IsOfTheMovementThatIsAskedFor) {
  const reviewing::TrackedFolder folder = reviewing::ReadTrackedFolder(Folder("trial"), {{"movement", "walking"}});
  EXPECT_THAT(folder.command, HasSubstr("--movement walking"));
  ReviewedTrial trial = reviewing::ReviewedTrialOf(folder, BinDir());
  const review::TrialFit fit = trial.work.fit(trial.book.Corrected());
  EXPECT_TRUE(fit.leg->events.empty());
  EXPECT_FALSE(Open(Folder("trial")).work.fit(trial.book.Corrected()).leg->events.empty());
}

TEST_F(CorrectedTrial, IsWhatLakeTrackMakesOfTheCorrections) {
  ReviewedTrial trial = Open(Copy("exact"));
  Correct(trial.book);
  trial.work.save(trial.book);
  const review::TrialFit fit = trial.work.fit(trial.book.Corrected());
  Track("tracked", Folder("exact") / "corrections.csv");
  ExpectSameTables(fit, Folder("tracked"));
  EXPECT_NE(ReadTextFile(Folder("tracked") / "kinematics.csv"), ReadTextFile(Folder("trial") / "kinematics.csv"));
}

// Frames of the events as a page would show them.
std::map<std::string, int> EventFrames(const Json& trial) {
  std::map<std::string, int> frames;
  for (const Json& event : trial["leg"]["events"])
    frames[event["event"].get<std::string>()] = event["frame"].get<int>();
  return frames;
}

TEST_F(CorrectedTrial, HasMovedEventsAsLakeTrackPutsThem) {
  const fs::path folder = Copy("moved_events");
  ReviewedTrial trial = Open(folder);
  const review::TrialFit fit = trial.work.fit(trial.book.Corrected());
  ASSERT_GE(fit.leg->events.size(), 3u);
  const motion::StsEvent& seat_off = fit.leg->events[1];
  ASSERT_EQ(seat_off.kind, motion::StsEventKind::kSeatOff);
  EXPECT_FALSE(fs::exists(folder / "events_corrected.csv"));
  trial.book.MoveEvent(1, motion::StsEventKind::kOnset, fit.leg->events[0].frame - 5);
  trial.book.MoveEvent(1, motion::StsEventKind::kSeatOff, seat_off.frame + 3);
  trial.book.Hide(50, "hip");
  trial.work.save(trial.book);
  review::TrialFit refitted = trial.work.fit(trial.book.Corrected());
  gait::CorrectEvents(trial.book.Events(), *refitted.leg);
  Track("tracked", folder / "corrections.csv", folder / "events_corrected.csv");
  ExpectSameTables(refitted, Folder("tracked"));
  const Json summary = ReadJsonFile(Folder("tracked") / "summary.json");
  EXPECT_EQ(summary["options"]["events"], (folder / "events_corrected.csv").string());
  EXPECT_THAT(summary["inputs"].back()["path"].get<std::string>(), HasSubstr("events_corrected.csv"));
  EXPECT_EQ(motion::ReadEventsCsv(Folder("tracked") / "events.csv")[1].frame, seat_off.frame + 3);
  EXPECT_THAT(trial.about["command_with_events"].get<std::string>(),
              HasSubstr("--events " + (folder / "events_corrected.csv").string()));
  // What was found is not lost, wherever the events came from.
  Track("events_alone", {}, folder / "events_corrected.csv");
  for (const fs::path& reviewed : {folder, Folder("events_alone")}) {
    ReviewedTrial later = Open(reviewed);
    EXPECT_TRUE(later.book.IsMoved(1, motion::StsEventKind::kSeatOff));
    later.book.RestoreEvent(1, motion::StsEventKind::kSeatOff);
    EXPECT_EQ(later.work.fit(later.book.Corrected()).leg->events[1].frame, seat_off.frame);
  }
}

// Further fits of a trial whose events were moved do not find them again.
TEST_F(CorrectedTrial, KeepsMovedEventsInWhatIsMadeOfIt) {
  WriteTextFile(Folder("events.csv"), "repetition,event,time_s\n1,seat_off,1.21\n");
  Track("plates", {}, Folder("events.csv"));
  const auto gait = [&](const std::string& from, const std::string& to, const std::optional<fs::path>& events) {
    commands::GaitRunOptions options;
    options.trial = Folder(from);
    options.events = events;
    lake::Run run({"lake-gait", "test", {}, Folder(to), true});
    run.WriteSummary(commands::RunGait(options, run));
    return motion::ReadEventsCsv(Folder(to) / "events.csv")[1].time_s;
  };
  EXPECT_EQ(gait("plates", "again", {}), 1.21);
  EXPECT_EQ(gait("again", "thrice", {}), 1.21);
  EXPECT_NE(gait("trial", "found", {}), 1.21);
  EXPECT_EQ(gait("trial", "said", Folder("events.csv")), 1.21);
  WriteTextFile(Folder("late.csv"), "repetition,event,time_s\n1,seat_off,99\n");
  EXPECT_THAT([&] { gait("trial", "late", Folder("late.csv")); },
              ThrowsMessage<Error>(HasSubstr("late.csv:2: 99 s is outside the recording")));
  EXPECT_FALSE(fs::exists(Folder("late") / "summary.json"));
}

TEST_F(CorrectedTrial, TakesNoEventOutOfItsOrder) {
  const fs::path folder = Copy("order");
  ReviewedTrial trial = Open(folder);
  review::TrialSession session(std::move(trial.book), trial.repeated, trial.work, trial.about);
  const auto fitted = [&] {
    for (int i = 0; i < 600 && session.State()["fitted"] != session.State()["revision"]; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return Json::parse(session.Trial());
  };
  const std::map<std::string, int> found = EventFrames(fitted());
  const auto move = [&](const char* event, int frame) {
    session.Edit({{"op", "move_event"}, {"repetition", 1}, {"event", event}, {"frame", frame}});
  };
  EXPECT_THAT([&] { move("standing", found.at("onset")); }, ThrowsMessage<Error>(HasSubstr("is before seat_off")));
  EXPECT_THROW(move("standing", 1'000'000), Error);
  EXPECT_THROW(move("sitting", 20), Error);
  EXPECT_FALSE(fs::exists(folder / "events_corrected.csv"));
  move("onset", found.at("onset") + 2);
  const Json moved = Json::parse(session.Trial());
  EXPECT_EQ(EventFrames(moved).at("onset"), found.at("onset") + 2) << "at once, without a fit";
  EXPECT_EQ(moved["state"]["corrections"], 1);
  session.Edit({{"op", "undo"}});
  EXPECT_EQ(EventFrames(Json::parse(session.Trial())), found);
  EXPECT_TRUE(motion::ReadEventCorrections(folder / "events_corrected.csv").empty());
  session.Edit({{"op", "redo"}});
  EXPECT_EQ(motion::ReadEventCorrections(folder / "events_corrected.csv").size(), 1u);
}

TEST_F(CorrectedTrial, TrackedAgainCanStillBeTakenBack) {
  const fs::path folder = Copy("again");
  ReviewedTrial trial = Open(folder);
  Correct(trial.book);
  trial.work.save(trial.book);
  Track("again", folder / "corrections.csv");
  ReviewedTrial again = Open(folder);
  EXPECT_EQ(again.book.Count(), trial.book.Count());
  again.book.Restore(20, "knee");
  again.book.Restore(50, "hip");
  again.book.SwapFrom(80, "hip", "waist");
  again.book.SwapFrom(83, "hip", "waist");
  EXPECT_EQ(again.book.Count(), 0u);
  ExpectSameTables(again.work.fit(again.book.Corrected()), Folder("trial"));
}

TEST_F(CorrectedTrial, IsTakenBackInALaterSession) {
  const fs::path folder = Copy("later");
  ReviewedTrial trial = Open(folder);
  Correct(trial.book);
  trial.work.save(trial.book);
  ReviewedTrial later = Open(folder);
  EXPECT_EQ(later.book.Count(), trial.book.Count());
  for (int i = 0; i < 4; ++i) later.book.Undo();
  EXPECT_EQ(later.book.Count(), 0u);
  EXPECT_FALSE(later.book.CanUndo());
}

// review.json is of the tracking before.
TEST_F(CorrectedTrial, TrackedAnewIsWhatIsDetectedNow) {
  const fs::path folder = Copy("anew");
  ReviewedTrial trial = Open(folder);
  Correct(trial.book);
  trial.work.save(trial.book);
  Json review = ReadJsonFile(folder / "review.json");
  review["replaced"][0]["x_px"] = 1.5;  // knee in frame 20
  WriteJsonFile(folder / "review.json", review);
  EXPECT_EQ(Open(folder).book.Detected().Find("knee")->samples[20].position,
            trial.book.Detected().Find("knee")->samples[20].position);
}

TEST_F(CorrectedTrial, WithForeignCorrectionsIsRefused) {
  WriteTextFile(Folder("foreign.csv"), "frame,marker,x_px,y_px\n50,hip,,\n");
  Track("foreign", Folder("foreign.csv"));
  EXPECT_THAT([&] { reviewing::ReadTrackedFolder(Folder("foreign")); },
              ThrowsMessage<Error>(HasSubstr("with corrections that lake review did not make")));
}

// What the programs that read a folder warn of corrections.
std::vector<std::string> WarningsOfCorrections(const fs::path& trial) {
  const TemporaryFolder out;
  const auto warnings_of = [&](const char* program, const auto& work) {
    lake::Run run({.program = program, .command = "test", .out = out / program, .quiet = true});
    const Json summary = run.WriteSummary(work(run));
    std::vector<std::string> warnings;
    for (const std::string warning : summary["warnings"])
      if (warning.find("correction") != std::string::npos) warnings.push_back(warning);
    return warnings;
  };
  commands::GaitRunOptions gait;
  gait.trial = trial;
  const auto of_gait = warnings_of("lake-gait", [&](lake::Run& run) { return commands::RunGait(gait, run); });
  commands::CompareRunOptions compare;
  compare.human = compare.exo = trial;
  compare.exo_knee = "knee";
  const auto of_compare =
      warnings_of("lake-compare", [&](lake::Run& run) { return commands::RunCompare(compare, run); });
  EXPECT_EQ(of_compare.size(), 2 * of_gait.size()) << "both trials are this one";
  for (const std::string& warning : of_compare) EXPECT_THAT(of_gait, testing::Contains(warning));
  return of_gait;
}

TEST_F(CorrectedTrial, ThatIsNotTrackedAnewIsSaidToBeSo) {
  const fs::path folder = Copy("unapplied");
  EXPECT_THAT(WarningsOfCorrections(folder), testing::IsEmpty());
  ReviewedTrial trial = Open(folder);
  Correct(trial.book);
  trial.book.MoveEvent(1, motion::StsEventKind::kOnset,
                       trial.work.fit(trial.book.Corrected()).leg->events[0].frame - 5);
  trial.work.save(trial.book);
  const std::string command = trial.about["command_with_events"];
  EXPECT_THAT(WarningsOfCorrections(folder),
              testing::ElementsAre(AllOf(HasSubstr(fmt::format("{}: was not tracked with the {} corrections",
                                                               folder.string(), trial.book.Count())),
                                         HasSubstr(command))));
  Track("unapplied", folder / "corrections.csv", folder / "events_corrected.csv");
  EXPECT_THAT(WarningsOfCorrections(folder), testing::IsEmpty());
  // One more since.
  ReviewedTrial again = Open(folder);
  again.book.Hide(51, "hip");
  again.work.save(again.book);
  EXPECT_THAT(WarningsOfCorrections(folder), testing::ElementsAre(HasSubstr(folder.string())));
}

TEST_F(CorrectedTrial, OfAStudyIsReadToo) {
  const fs::path folder = Copy("study");
  Json summary = ReadJsonFile(folder / "summary.json");
  // The study says where the results lie; its camera stands in another section.
  summary["options"].erase("out");
  std::erase(summary["given"].get_ref<Json::array_t&>(), Json("camera"));
  WriteJsonFile(folder / "summary.json", summary);
  const ReviewedTrial trial = Open(folder);
  ExpectSameTables(trial.work.fit(trial.book.Corrected()), folder);
  EXPECT_THAT(trial.about["command"].get<std::string>(),
              HasSubstr("corrections: " + (folder / "corrections.csv").string()));
}

TEST_F(CorrectedTrial, OfAVideoInTheHomeFolderIsReadToo) {
  const HomeFolder home(Recording("video.mp4").parent_path());
  Track("home");
  EXPECT_EQ(ReadJsonFile(Folder("home") / "summary.json")["inputs"][0]["path"], "~/video.mp4");
  const reviewing::TrackedFolder folder = reviewing::ReadTrackedFolder(Folder("home"));
  EXPECT_EQ(folder.options.video, Recording("video.mp4"));
  EXPECT_EQ(folder.options.camera, Recording("camera.yaml"));
}

TEST_F(CorrectedTrial, NeedsItsOwnVideo) {
  const fs::path folder = Copy("moved");
  Json summary = ReadJsonFile(folder / "summary.json");
  const Json content = std::exchange(summary["inputs"][0]["sha256"], "00");
  WriteJsonFile(folder / "summary.json", summary);
  EXPECT_THAT([&] { reviewing::ReadTrackedFolder(folder); }, ThrowsMessage<Error>(HasSubstr("has changed since")));
  summary["inputs"][0]["path"] = "elsewhere/video.mp4";
  WriteJsonFile(folder / "summary.json", summary);
  EXPECT_THAT([&] { reviewing::ReadTrackedFolder(folder); }, ThrowsMessage<Error>(HasSubstr("is not to be found")));
  // Moved beside its results: another of its name is not taken for it.
  fs::copy_file(Recording("video.mp4"), folder / "video.mp4");
  EXPECT_THAT([&] { reviewing::ReadTrackedFolder(folder); }, ThrowsMessage<Error>(HasSubstr("is not to be found")));
  summary["inputs"][0]["sha256"] = content;
  WriteJsonFile(folder / "summary.json", summary);
  EXPECT_EQ(reviewing::ReadTrackedFolder(folder).options.video, folder / "video.mp4");
  EXPECT_THAT([&] { reviewing::ReadTrackedFolder(folder_.Path()); },
              ThrowsMessage<Error>(HasSubstr("is not a folder of lake track's")));
}

TEST_F(CorrectedTrial, OnAFullDiskKeepsWhatWasSaved) {
  const fs::path folder = Copy("full");
  ReviewedTrial trial = Open(folder);
  review::TrialSession session(std::move(trial.book), trial.repeated, trial.work, trial.about);
  session.Edit({{"op", "hide"}, {"frame", 50}, {"marker", "hip"}});
  const std::string saved = ReadTextFile(folder / "corrections.csv"), kept = ReadTextFile(folder / "review.json");
  const Json before = session.State();
  {
    const FileLimit full(10);
    EXPECT_THAT(
        [&] {
          session.Edit({{"op", "hide"}, {"frame", 51}, {"marker", "hip"}});
        },
        ThrowsMessage<Error>(HasSubstr("review.json")));
  }
  EXPECT_EQ(session.State()["revision"], before["revision"]);
  EXPECT_EQ(session.State()["corrections"], 1);
  EXPECT_EQ(ReadTextFile(folder / "corrections.csv"), saved);
  EXPECT_EQ(ReadTextFile(folder / "review.json"), kept);
  session.Edit({{"op", "hide"}, {"frame", 51}, {"marker", "hip"}});
  EXPECT_EQ(session.State()["corrections"], 2);
}

// Two programs on one folder: the second's step is refused, not the first's lost.
TEST_F(CorrectedTrial, OverwritesNoCorrectionsOfAnotherProgram) {
  const fs::path folder = Copy("twice");
  ReviewedTrial first = Open(folder), second = Open(folder);
  first.book.Hide(50, "hip");
  first.work.save(first.book);
  const std::string saved = ReadTextFile(folder / "corrections.csv");
  second.book.Hide(51, "hip");
  EXPECT_THAT([&] { second.work.save(second.book); }, ThrowsMessage<Error>(HasSubstr("changed by another program")));
  EXPECT_EQ(ReadTextFile(folder / "corrections.csv"), saved);
  first.book.Hide(52, "hip");
  first.work.save(first.book);
  EXPECT_EQ(Open(folder).book.Count(), 2u);
}

TEST_F(CorrectedTrial, IsFittedAnewInTheBackground) {
  ReviewedTrial trial = Open(Copy("session"));
  review::TrialSession session(std::move(trial.book), trial.repeated, trial.work, trial.about);
  const auto fitted = [&] {
    for (int i = 0; i < 600 && session.State()["fitted"] != session.State()["revision"]; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return Json::parse(session.Trial());
  };
  const Json before = fitted();
  for (int frame = 60; frame < 75; ++frame) session.Edit({{"op", "hide"}, {"frame", frame}, {"marker", "knee"}});
  const Json after = fitted();
  EXPECT_EQ(after["state"]["corrections"], 15);
  EXPECT_EQ(after["markers"][1]["status"].get<std::string>().substr(59, 17), "dfffffffffffffffd");
  EXPECT_GT(after["leg"]["knee_sigma"][67].get<double>(), before["leg"]["knee_sigma"][67].get<double>());
  EXPECT_EQ(after["problems"][0]["kind"], "gap");
  EXPECT_THROW(session.Edit({{"op", "erase"}, {"frame", 1}, {"marker", "knee"}}), Error);
  EXPECT_THROW(session.Edit({{"op", "hide"}, {"frame", 1e300}, {"marker", "ankle"}}), Error);
  EXPECT_THROW(session.Edit({{"op", "place"}, {"frame", 1}, {"marker", "ankle"}, {"x", -1e9}, {"y", 0}}), Error);
}

}  // namespace
}  // namespace lake
