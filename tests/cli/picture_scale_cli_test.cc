// lake-compare of tracks that other programs leave in px: a camera file or a scale bar gives what the same tracks in mm
// give.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "cli/program_run.h"
#include "gait/synthetic_leg.h"
#include "lake/camera/camera.h"
#include "lake/core/json.h"
#include "lake/motion/marker_recording.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

class TracksInPx : public testing::Test {
 protected:
  // The leg, and the same person with a joint that sits 20 mm before and 10 mm above the knee.
  void SetUp() override {
    const gait::LegView calibrated = CalibratedView();
    camera::WriteCameraProfile(folder_ / "camera.yaml", {.camera = *calibrated.camera,
                                                         .camera_from_plane = calibrated.camera_from_plane,
                                                         .uncertainty = {},
                                                         .plane_uncertainty = {}});
    gait::LegView mm;
    mm.recorded_in_plane = true;
    Write("human", "human_mm", MakeSyntheticLeg({.rate_hz = 60}), calibrated, mm, std::nullopt);
    Write("exo", "exo_mm", MakeSyntheticLeg({.rate_hz = 60, .move_s = 2}), ScaledView(), mm, Eigen::Vector2d(20, 10));
  }

  void Write(const std::string& in_px, const std::string& in_mm, const SyntheticLeg& leg, const gait::LegView& view,
             const gait::LegView& mm, const std::optional<Eigen::Vector2d>& joint_mm) const {
    for (const auto& [name, of_view] : {std::pair(in_px, view), std::pair(in_mm, mm)}) {
      motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, of_view, {.sigma_px = 0.02}, 5);
      if (joint_mm) {
        motion::MarkerTrack joint = tracks.markers[1];
        joint.name = "exo_knee";
        for (std::size_t i = 0; i < leg.time_s.size(); ++i)
          joint.samples[i].position = gait::RecordedFromPlane<double>(of_view, *leg.points_mm[i].knee + *joint_mm, 0);
        tracks.markers.push_back(std::move(joint));
      }
      motion::WriteMarkerCsv(folder_ / (name + ".csv"), tracks);
    }
  }

  Json Compare(const std::string& words, const std::string& program = "lake-compare ") const {
    return DoneJson(folder_, program + words + " --quiet --json");
  }

  void ExpectRefused(const std::string& words, int exit_code, const std::string& message,
                     const std::string& program = "lake-compare ") const {
    lake::ExpectRefused(folder_, program + words + " -o R", exit_code, message);
    EXPECT_FALSE(fs::exists(folder_ / "R"));
  }

  TemporaryFolder folder_;
};

TEST_F(TracksInPx, AreComparedAsTheSameTracksInMm) {
  const Json mm = Compare("human_mm.csv exo_mm.csv -o M"),
             px = Compare("human.csv exo.csv --camera camera.yaml --exo-scale 0,0,500,0,1000 -o P");
  // 0.02 px are up to 0.06 mm, of each of some hundred samples.
  EXPECT_NEAR(px["joint"]["rms_mm"], mm["joint"]["rms_mm"], 0.05);
  EXPECT_NEAR(px["joint"]["rms_mm"], std::hypot(20, 10), 0.2);
  EXPECT_NEAR(px["metrics"]["rms_mm"], mm["metrics"]["rms_mm"], 0.05);
  const Json summary = ReadJsonFile(folder_ / "P/summary.json");
  EXPECT_TRUE(std::ranges::any_of(summary["inputs"], [](const Json& input) { return input["role"] == "human camera"; }))
      << summary["inputs"].dump();
}

TEST_F(TracksInPx, OneScaleIsForBothUnlessTheOtherHasItsOwn) {
  const Json both = Compare("exo.csv exo.csv --human-knee knee --scale 0,0,500,0,1000 -o B");
  EXPECT_NEAR(both["joint"]["rms_mm"], std::hypot(20, 10), 0.2);
  // Of use for one of the two is enough.
  const Json one = Compare("human_mm.csv exo.csv --scale 0,0,500,0,1000 -o O");
  EXPECT_NEAR(one["joint"]["rms_mm"], std::hypot(20, 10), 0.2);
}

TEST_F(TracksInPx, OfBothLegsHaveTheirScalesToo) {
  const Json legs =
      Compare("human.csv exo.csv --camera camera.yaml --right-scale 0,0,500,0,1000 -o S", "lake-symmetry ");
  EXPECT_LT(std::abs(legs["symmetry"]["hip_rise_mm"]["difference"].get<double>()), 1);
  // Of use for the left one alone is enough, and so is a scale of the right one's own.
  for (const char* words :
       {"exo.csv human_mm.csv --scale 0,0,500,0,1000 -o L", "human_mm.csv exo.csv --right-scale 0,0,500,0,1000 -o R"}) {
    const Json one = Compare(words, "lake-symmetry ");
    EXPECT_LT(std::abs(one["symmetry"]["hip_rise_mm"]["difference"].get<double>()), 1) << words;
  }
}

// Recognised by the exoskeleton's marker; whoever means it so names what is compared.
TEST_F(TracksInPx, ExchangedTrialsAreRefusedWithTheRightCommand) {
  ExpectRefused("exo_mm.csv human_mm.csv", 2, "the trials are exchanged");
  ExpectRefused("exo_mm.csv human_mm.csv", 2, "lake compare human_mm.csv exo_mm.csv");
  EXPECT_TRUE(Compare("exo_mm.csv human_mm.csv --exo-knee knee -o X").is_object());
}

TEST_F(TracksInPx, WhatNoPersonOrDeviceCanBeIsRefused) {
  ExpectRefused("human_mm.csv exo_mm.csv --joint-at 0,-6000", 2,
                "--joint-at must be at least -700, not -6000 (from -700 to 700)");
  ExpectRefused("human_mm.csv exo_mm.csv --soft-tissue 7000", 2,
                "--soft-tissue must be at most 200, not 7000 (from 0 to 200)");
  ExpectRefused("human_mm.csv exo_mm.csv --human-knee hip", 2, "--human-knee hip: is the leg's hip");
  ExpectRefused("human_mm.csv exo_mm.csv --exo-knee ankle", 2, "--exo-knee ankle: is the leg's ankle");
}

TEST_F(TracksInPx, AScaleThatHasNoEffectIsRefused) {
  ExpectRefused("human_mm.csv exo_mm.csv --scale 0,0,500,0,1000", 2,
                "--scale has no effect on human_mm.csv: its lengths are in mm");
  ExpectRefused("human.csv exo_mm.csv --scale 0,0,500,0,1000 --exo-camera camera.yaml", 2,
                "--exo-camera has no effect on exo_mm.csv: its lengths are in mm");
  ExpectRefused("human_mm.csv exo.csv --exo-scale 0,0,500,0,1000 --camera camera.yaml", 2,
                "--camera has no effect on human_mm.csv: its lengths are in mm");
  ExpectRefused("human_mm.csv exo.csv", 1, "give the one in px a scale: --exo-camera with a plane, or --exo-scale");
  ExpectRefused("human_mm.csv human_mm.csv --scale 0,0,500,0,1000", 2, "--scale has no effect", "lake-symmetry ");
  ExpectRefused("human_mm.csv exo.csv", 1, "give the one in px a scale: --right-camera with a plane, or --right-scale",
                "lake-symmetry ");
  ExpectRefused("exo.csv human_mm.csv", 1, "give the one in px a scale: --camera with a plane, or --scale",
                "lake-symmetry ");
  ExpectRefused("human_mm.csv exo_mm.csv --height 1800", 2, "--height only applies together with --worn");
}

// A folder of lake-gait in px is fitted once more, with its scale.
TEST_F(TracksInPx, AFolderWithoutScaleIsGivenOne) {
  Done(folder_, "lake-gait exo.csv --quiet -o E");
  const Json folder = Compare("human_mm.csv E --exo-scale 0,0,500,0,1000 -o F");
  EXPECT_NEAR(folder["joint"]["rms_mm"], std::hypot(20, 10), 0.2);
  Done(folder_, "lake-gait human_mm.csv --quiet -o H");
  ExpectRefused("H E --camera camera.yaml --exo-scale 0,0,500,0,1000", 2, "--camera has no effect on H");
  ExpectRefused("F E --camera camera.yaml --exo-scale 0,0,500,0,1000", 2, "--camera has no effect on F");
}

}  // namespace
}  // namespace lake
