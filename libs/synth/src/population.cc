#include "lake/synth/population.h"

#include <cmath>
#include <random>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/json.h"
#include "lake/core/numbers.h"
#include "lake/person/body.h"
#include "lake/synth/recording.h"
#include "lake/synth/scene.h"

namespace lake::synth {
namespace {

namespace fs = std::filesystem;

constexpr double kTrunk = 0.117;  // part of the body height: the waist marker is some way up

class Lot {
 public:
  explicit Lot(std::uint64_t seed) : random_(seed) {}

  // Within 2.5 standard deviations: nobody is a giant.
  double operator()(double mean, double sd) {
    constexpr double kWidest = 2.5;
    double normal = normal_(random_);
    while (std::abs(normal) > kWidest) normal = normal_(random_);
    return mean + sd * normal;
  }
  Eigen::Vector2d operator()(const Eigen::Vector2d& mean, double sd) {
    const double x = (*this)(mean.x(), sd), y = (*this)(mean.y(), sd);
    return {x, y};
  }
  std::uint64_t Seed() { return random_() % 1000000; }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

Session DrawSession(const PopulationOptions& of, const Session& person, const StsMotionOptions& human,
                    const Eigen::Vector2d& exo_knee, double pace, Lot& lot) {
  Session session = person;
  session.human = human;
  session.human.seed = lot.Seed();
  session.human.seated_knee_deg = lot(human.seated_knee_deg, of.seated_knee_session_sd_deg);
  session.human.rise_s = lot(human.rise_s, of.rise_session_sd_s);
  session.exo = session.human;
  session.exo.pace = pace;
  session.exo.exo_knee_mm = lot(exo_knee, of.exo_knee_session_sd_mm);
  return session;
}

fs::path WriteTrial(const Session& session, const StsMotionOptions& motion, const char* trial, SceneOptions options,
                    const fs::path& folder, const std::optional<camera::CameraProfile>& camera, Json* seeds) {
  options.motion = motion;
  options.seed = motion.seed + (seeds ? 1 : 0);
  options.camera = camera;
  const Scene scene(options);
  const fs::path out = folder / session.Folder() / trial;
  fs::create_directories(out);
  RecordingOptions recording;
  recording.preset = "veryfast";
  WriteRecording(scene, out, recording);
  if (!seeds) return out;
  const FrameTruth first = scene.Truth(0);
  for (const char* marker : {"knee", "exo_knee"}) {
    const auto index = static_cast<std::size_t>(IndexOfMarker(scene.Motion(), marker));
    seeds->push_back(
        fmt::format("{}={:.0f},{:.0f}@0", marker, first.markers[index].px.x(), first.markers[index].px.y()));
  }
  return out;
}

void WriteTruth(const std::vector<Session>& sessions, const fs::path& path) {
  CsvWriter csv({"participant_id", "session", "height_mm", "mass_kg", "shank_mm", "thigh_mm", "seated_knee_deg",
                 "rise_s", "exo_knee_x_mm", "exo_knee_y_mm"});
  for (const Session& s : sessions)
    csv.AddRow(s.participant, s.session, s.height_mm, s.mass_kg, s.human.shank_mm, s.human.thigh_mm,
               s.human.seated_knee_deg, s.human.rise_s, s.exo.exo_knee_mm->x(), s.exo.exo_knee_mm->y());
  csv.Write(path);
}

// The table, and beside it what its columns are, as BIDS has it.
void WriteParticipants(const std::vector<Session>& sessions, const fs::path& folder) {
  std::string text = "participant_id\tmass_kg\theight_mm\n", last;
  for (const Session& s : sessions)
    if (s.participant != last) {
      last = s.participant;
      text += fmt::format("{}\t{:.1f}\t{:.0f}\n", s.participant, s.mass_kg, s.height_mm);
    }
  WriteTextFile(folder / "participants.tsv", text);
  WriteJsonFile(
      folder / "participants.json",
      {{"mass_kg", {{"Description", "Body mass that was drawn; nothing rendered depends on it"}, {"Units", "kg"}}},
       {"height_mm", {{"Description", "Standing height"}, {"Units", "mm"}}}});
}

}  // namespace

void PopulationOptions::Check() const {
  if (people < 1 || sessions < 1) throw UsageError("a population has one person and one session at least");
}

fs::path Session::Folder() const {
  const fs::path person = fs::path("sourcedata") / participant;
  return session.empty() ? person : person / session;
}

std::vector<Session> DrawPopulation(const PopulationOptions& of, const StsMotionOptions& motion) {
  of.Check();
  Lot lot(of.seed);
  std::vector<Session> sessions;
  for (int i = 1; i <= of.people; ++i) {
    Session person;
    person.participant = fmt::format("sub-{:02}", i);
    person.height_mm = lot(of.height_mm, of.height_sd_mm);
    const double height_m = person.height_mm / kMmPerM;
    person.mass_kg = lot(of.mass_index_kg_m2, of.mass_index_sd) * height_m * height_m;
    StsMotionOptions human = motion;
    human.shank_mm = person::kShank * person.height_mm;
    human.thigh_mm = person::kThigh * person.height_mm;
    human.trunk_mm = kTrunk * person.height_mm;
    human.seated_knee_deg = lot(of.seated_knee_deg, of.seated_knee_sd_deg);
    human.rise_s = lot(of.rise_s, of.rise_sd_s);
    const Eigen::Vector2d exo_knee = lot(of.exo_knee_mm, of.exo_knee_sd_mm);
    const double pace = lot(of.pace, of.pace_sd);
    for (int j = 1; j <= of.sessions; ++j) {
      sessions.push_back(DrawSession(of, person, human, exo_knee, pace, lot));
      if (of.sessions > 1) sessions.back().session = fmt::format("ses-{}", j);
    }
  }
  return sessions;
}

void WritePopulation(const std::vector<Session>& sessions, const SceneOptions& scene, const fs::path& folder) {
  Json people = Json::object();
  for (const Session& session : sessions) {
    ThrowIfInterrupted();
    Json seeds = Json::array();
    const fs::path human = WriteTrial(session, session.human, "human", scene, folder, scene.camera, nullptr);
    WriteTrial(session, session.exo, "exo", scene, folder, camera::ReadCameraProfile(human / "camera.yaml"), &seeds);
    people[session.participant + (session.session.empty() ? "" : "_" + session.session)] = {
        {"exo", {{"seeds", seeds}}}};
  }
  const Json cohort = {
      {"name", "Rendered population"},
      {"steps", {"comparison"}},
      {"study",
       {{"camera", "human/camera.yaml"},
        {"human", {{"video", "human/video.mp4"}, {"markers", {"ankle", "knee", "hip", "waist"}}, {"overlay", false}}},
        {"exo",
         {{"video", "exo/video.mp4"}, {"markers", {"ankle", "knee", "hip", "waist", "exo_knee"}}, {"overlay", false}}},
        {"compare", {{"human_knee", "knee"}, {"exo_knee", "exo_knee"}}}}},
      {"people", people}};
  WriteTextFile(folder / "cohort.yaml", cohort.dump(2) + "\n");
  WriteParticipants(sessions, folder);
  WriteTruth(sessions, folder / "truth.csv");
}

}  // namespace lake::synth
