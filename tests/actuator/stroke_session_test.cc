// The host's side of a run over a real pseudo-terminal, with the firmware and its plant on the other end.
#include "lake/actuator/stroke_session.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <csignal>
#include <sstream>
#include <thread>

#include "cli/program_run.h"
#include "host/host_fixture.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake {
namespace {

using actuator::SessionOptions;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

constexpr int kTimesFaster = 8;  // the board's time runs so much faster than ours

// A board on a pty: bytes go to the firmware and back, ms by ms.
class PtyBoard {
 public:
  explicit PtyBoard(HostRig& rig) : rig_(rig) {
    std::array<char, 128> name{};
    if (openpty(&master_, &slave_, name.data(), nullptr, nullptr) != 0) throw std::runtime_error("no pty");
    port_ = name.data();
    termios raw{};
    tcgetattr(slave_, &raw);
    cfmakeraw(&raw);
    tcsetattr(slave_, TCSANOW, &raw);
    fcntl(master_, F_SETFL, O_NONBLOCK);
    rig_.KeepTalking(false);
    thread_ = std::thread([this] { Serve(); });
  }
  ~PtyBoard() {
    End();
    close(master_);
    close(slave_);
  }
  void End() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }
  const std::string& Port() const { return port_; }
  // Done at that time of the board since the program runs.
  void Later(double running_s, std::function<void(HostRig&)> act) {
    later_s_ = running_s;
    act_ = std::move(act);
  }
  // Done before this returns.
  void Do(std::function<void(HostRig&)> act) {
    now_ = std::move(act);
    is_due_ = true;
    while (is_due_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  void GoDeaf(double running_s) {
    Later(running_s, [this](HostRig&) { mute_ = true; });
  }
  // Of these lines the first character arrives as another one.
  void DamageLines(std::function<bool(const std::string& line)> which) {
    Do([this, &which](HostRig&) { is_damaged_ = std::move(which); });
  }
  int Damaged() const { return damaged_; }
  bool HasReceived() const { return has_received_; }
  // Until its own clock has gone on for that long.
  void WaitFor(double board_s) const {
    const double until_s = time_s_ + board_s;
    while (time_s_ < until_s) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  void Take(char c) {
    has_received_ = true;
    rig_.SendPlain({c});
  }
  static std::string WholeLines(const std::string& said) { return said.substr(0, said.rfind('\n') + 1); }
  std::string AsTheyArrive(const std::string& lines) {
    std::string arriving;
    for (std::size_t begin = 0, end = 0; begin < lines.size(); begin = end) {
      end = lines.find('\n', begin) + 1;
      std::string line = lines.substr(begin, end - begin);
      if (is_damaged_ && is_damaged_(line)) {
        line[0] ^= 1;
        ++damaged_;
      }
      arriving += line;
    }
    return arriving;
  }
  void Serve() {
    std::array<char, 256> buffer;
    std::size_t said = rig_.Wire().size();
    double since_s = -1;
    while (!ended_) {
      const ssize_t count = read(master_, buffer.data(), buffer.size());
      for (ssize_t i = 0; i < count; ++i) Take(buffer[static_cast<std::size_t>(i)]);
      rig_.Run(1e-3 * kTimesFaster);
      if (is_due_) {
        now_(rig_);
        is_due_ = false;
      }
      time_s_ = rig_.Time();
      if (since_s < 0 && rig_.Serial().find(",running,") != std::string::npos) since_s = rig_.Time();
      if (act_ && since_s >= 0 && rig_.Time() >= since_s + later_s_) {
        act_(rig_);
        act_ = nullptr;
      }
      const std::string lines = WholeLines(rig_.Wire().substr(said));
      said += lines.size();
      const std::string bytes = AsTheyArrive(lines);
      if (!mute_ && !bytes.empty() && write(master_, bytes.data(), bytes.size()) < 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  HostRig& rig_;
  int master_ = -1, slave_ = -1;
  std::string port_;
  std::atomic<bool> ended_ = false, mute_ = false, has_received_ = false;
  std::atomic<double> time_s_ = 0;
  std::function<void(HostRig&)> now_;
  std::atomic<bool> is_due_ = false;
  std::function<bool(const std::string&)> is_damaged_;
  std::atomic<int> damaged_ = 0;
  double later_s_ = 0;
  std::function<void(HostRig&)> act_;
  std::thread thread_;
};

class StrokeSessionTest : public HostFirmwareTest {
 protected:
  void SetUp() override {
    firmware_options_.design_hash = "0123456789ab";
    firmware_options_.command_timeout_s = 4;  // half a second of ours
    Build(FreeDesign({{0, 300}, {4, 316}, {6, 310}}));
    WriteTextFile(folder_ / "stroke_table.h", header_);
    board_ = std::make_unique<PtyBoard>(*rig_);
    options_.port = board_->Port();
    options_.keep_alive_s = 0.05;
    options_.greeting_s = 1;
    options_.silent_s = 0.6;
  }

  actuator::SessionResult Run(const std::function<void(const std::string&, double)>& poll = [](const std::string&,
                                                                                               double) {}) {
    return actuator::RunSession(options_, actuator::ReadSketchIdentity(folder_.Path()), folder_ / "log.csv", poll);
  }

  // The program needs 6.5 mm/s, and at that supply the motor has 5.7: 18.5 mm take 0.4 s longer, but for what it may be
  // behind.
  void HaveTooSlowAMotor() {
    board_.reset();
    WirePotentiometer(firmware_options_);
    actuator_.supply = [](double) { return actuator::kLowSupply; };
    Build(FreeDesign({{0, 300}, {3, 319.5}}));
    WriteTextFile(folder_ / "stroke_table.h", header_);
    board_ = std::make_unique<PtyBoard>(*rig_);
    options_.port = board_->Port();
  }

  // Whatever happened, nothing moves a second of the board later.
  void ExpectStill() {
    board_->WaitFor(1);
    board_->End();
    EXPECT_EQ(rig_->Duty(), 0);
    rig_->Run(1);
    const double stroke = rig_->Stroke();
    rig_->Run(1);
    EXPECT_NEAR(rig_->Stroke(), stroke, 1e-4);
  }

  TemporaryFolder folder_;
  SessionOptions options_;
  std::unique_ptr<PtyBoard> board_;
};

TEST_F(StrokeSessionTest, HomesRunsAndLogsEveryRow) {
  EXPECT_EQ(actuator::ReadSketchIdentity(folder_.Path()).duration_s, schedule_.Duration());
  std::size_t polls = 0;
  const actuator::SessionResult result = Run([&](const std::string&, double) { ++polls; });
  board_->End();
  EXPECT_NEAR(rig_->Stroke(), 310, 0.3);
  EXPECT_GT(polls, 10u);
  const CsvTable log = CsvTable::Read(folder_ / "log.csv");
  EXPECT_EQ(log.Rows(), result.rows);
  // Ten rows per second of the board: homing of 5 s and the program.
  EXPECT_GE(log.Rows(), 60u);
  for (std::size_t i = 1; i < log.Rows(); ++i)
    EXPECT_NEAR(log.RequiredNumber(i, 0) - log.RequiredNumber(i - 1, 0), 0.1, 0.0015) << i;
}

TEST_F(StrokeSessionTest, TellsHowMuchLongerItTook) {
  HaveTooSlowAMotor();
  const actuator::SessionResult result = Run();
  ASSERT_TRUE(result.waited_s);
  EXPECT_GT(*result.waited_s, 0.3);
  EXPECT_LT(*result.waited_s, 0.6);
}

// It is told once only.
TEST_F(StrokeSessionTest, HowMuchLongerItTookIsUnknownWhereThatLineIsDamaged) {
  HaveTooSlowAMotor();
  board_->DamageLines([](const std::string& line) { return line.starts_with("[MSG:waited"); });
  const Outcome run = Shell(folder_, "lake-stroke run . --port " + board_->Port() + " --keep-alive 0.05 -o out");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(board_->Damaged(), 1);
  EXPECT_THAT(run.out, HasSubstr("perhaps longer than planned"));
  EXPECT_THAT(ReadTextFile(folder_ / "out/summary.json"), HasSubstr("\"waited_s\": null"));
}

TEST_F(StrokeSessionTest, NothingMovesIfTheLogCannotBeWritten) {
  EXPECT_THAT(
      [&] {
        actuator::RunSession(options_, actuator::ReadSketchIdentity(folder_.Path()), "/dev/full",
                             [](const std::string&, double) {});
      },
      ThrowsMessage<Error>(HasSubstr("/dev/full: the log cannot be written (No space left on device)")));
  EXPECT_THAT(
      [&] {
        actuator::RunSession(options_, actuator::ReadSketchIdentity(folder_.Path()), folder_ / "no/such/log.csv",
                             [](const std::string&, double) {});
      },
      ThrowsMessage<Error>(HasSubstr("the log cannot be written")));
  ExpectStill();
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0);
}

TEST_F(StrokeSessionTest, AFaultEndsItWithItsMeaning) {
  board_->Later(1.5, [](HostRig& rig) { rig.PullWire(false, true); });
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("ALARM:1: an end stop in the direction of motion")));
  ExpectStill();
  EXPECT_GT(CsvTable::Read(folder_ / "log.csv").Rows(), 20u) << "what was moved is in the log";
}

// Neither a new program nor a reset of the board forgets a fault: somebody must say that it was seen to.
TEST_F(StrokeSessionTest, AFaultStaysUntilItIsAcknowledged) {
  board_->Later(1, [](HostRig& rig) { rig.PullWire(false, true); });
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("ALARM:1")));
  board_->Do([](HostRig& rig) { rig.PullWire(false, false); });
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("ALARM:1: an end stop in the direction of motion; see to "
                                                             "it, then run with --acknowledge")));
  board_->Do([](HostRig& rig) { rig.PowerUp(); });
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("--acknowledge")));
  options_.acknowledge = true;
  EXPECT_GT(Run().rows, 20u);
}

TEST_F(StrokeSessionTest, AnInterruptStopsWhateverMoves) {
  for (const bool while_running : {false, true}) {
    int left = 3;
    EXPECT_THROW(Run([&](const std::string& state, double) {
                   if (state == (while_running ? "running" : "homing") && --left == 0) throw std::runtime_error("^C");
                 }),
                 std::runtime_error);
    board_->WaitFor(1);
  }
  ExpectStill();
}

TEST_F(StrokeSessionTest, ASilentBoardIsGivenUpAndStopsByItself) {
  board_->GoDeaf(1);
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("the firmware has been silent for 0.6 s")));
  ExpectStill();
}

TEST_F(StrokeSessionTest, AnotherProgramInTheBoardIsRefused) {
  actuator::SketchIdentity other = actuator::ReadSketchIdentity(folder_.Path());
  other.design_hash = "ffff";
  EXPECT_THAT(
      [&] { actuator::RunSession(options_, other, folder_ / "log.csv", [](const std::string&, double) {}); },
      ThrowsMessage<Error>(HasSubstr("the board has the program of design 0123456789ab, the folder that of ffff")));
  ExpectStill();
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0);
}

// The same design, but for one option, one number of the duty table or one stroke of the program.
TEST_F(StrokeSessionTest, AnotherProgramOfTheSameDesignIsRefusedBeforeAnythingMoves) {
  const auto header = [&](const std::function<void(actuator::FirmwareOptions&)>& change, double last_mm, double speed) {
    actuator::FirmwareOptions options = firmware_options_;
    change(options);
    const actuator::StrokeSchedule schedule =
        actuator::MakeSchedule(FreeDesign({{0, 300}, {4, 316}, {6, last_mm}}), {});
    std::vector<actuator::DutyRow> rows = table_.rows;
    rows.back().extend_mm_s *= speed;
    return actuator::StrokeTableHeader({schedule, actuator::MakeDutyTable(rows, "other"), options}, "test");
  };
  const auto same = [](actuator::FirmwareOptions&) {};
  ASSERT_EQ(header(same, 310, 1), header_);
  for (const std::string& other : {header([](actuator::FirmwareOptions& o) { o.stop_travel_mm = 1.5; }, 310, 1),
                                   header([](actuator::FirmwareOptions& o) { o.command_timeout_s = 60; }, 310, 1),
                                   header(same, 310.5, 1), header(same, 310, 1.001)}) {
    WriteTextFile(folder_ / "stroke_table.h", other);
    EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("the board has another program of this design")));
  }
  std::string by_hand = header_;
  by_hand.replace(by_hand.find("LAKE_STOP_TRAVEL_UM 2000L"), 25, "LAKE_STOP_TRAVEL_UM 9000L");
  WriteTextFile(folder_ / "stroke_table.h", by_hand);
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("it is not as lake-stroke wrote it")));
  ExpectStill();
  for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0);
}

TEST_F(StrokeSessionTest, APortThatIsNoneIsAnError) {
  board_->End();
  options_.port = folder_ / "stroke_table.h";
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("this is no serial line")));
  options_.port = "/dev/no-such-tty";
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("cannot be opened")));
}

// By hand: lines get their check sum, what is said loses it, and at the end of the input nothing moves on.
TEST_F(StrokeSessionTest, ATerminalJogsAndStopsAtTheEndOfItsInput) {
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  std::ostringstream said;
  std::atomic<bool> ended = false;
  std::thread talk([&] {
    actuator::RunTalk({options_.port, 0.05}, pipe_ends[0], said, folder_ / "serial.csv", [] {});
    ended = true;
  });
  const auto type = [&](const std::string& text) {
    ASSERT_EQ(write(pipe_ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    board_->WaitFor(1.5);
  };
  type("jog 500 800\n?\n");
  type("zero\r\nnonsense\n");
  type("jog 500 9000\n");
  close(pipe_ends[1]);
  talk.join();
  close(pipe_ends[0]);
  ExpectStill();
  EXPECT_GT(rig_->Stroke(), 300.5) << "it jogged";
  EXPECT_LT(rig_->Stroke(), 315) << "and not to the jog's end";
  const std::string text = said.str();
  for (const char* line : {"ok\n", "error:1\n", "[MSG:done]\n", ",jogging,"}) EXPECT_THAT(text, HasSubstr(line));
  EXPECT_EQ(std::ranges::count(text, '<'), 1) << "the status that was asked for";
  EXPECT_THAT(text, Not(HasSubstr("*")));
  EXPECT_EQ(ReadTextFile(folder_ / "serial.csv"), text);
  EXPECT_THAT(text, Not(HasSubstr("damaged")));
}

// A row may be damaged on its way: it is left out, and nothing else happens.
TEST_F(StrokeSessionTest, ADamagedRowIsLeftOut) {
  board_->DamageLines([rows = 0](const std::string& line) mutable {
    return std::isdigit(static_cast<unsigned char>(line[0])) && ++rows % 20 == 0;
  });
  const actuator::SessionResult result = Run();
  const CsvTable log = CsvTable::Read(folder_ / "log.csv");
  EXPECT_EQ(log.Rows(), result.rows);
  EXPECT_GE(board_->Damaged(), 3);
  EXPECT_GE(log.Rows(), 57u) << "of 60, and 3 damaged";
  for (std::size_t i = 1; i < log.Rows(); ++i) EXPECT_GT(log.RequiredNumber(i, 0), log.RequiredNumber(i - 1, 0)) << i;
}

// The remark that homing or the program has ended comes once only; the rows say it again and again.
TEST_F(StrokeSessionTest, ADamagedRemarkOfTheEndIsToldByTheRows) {
  board_->DamageLines([](const std::string& line) { return line.starts_with("[MSG:done]"); });
  EXPECT_GE(Run().rows, 60u);
  EXPECT_EQ(board_->Damaged(), 2);
  board_->End();
  EXPECT_NEAR(rig_->Stroke(), 310, 0.3);
}

// After a reset the firmware is idle, as at the end of a program; its clock begins anew.
TEST_F(StrokeSessionTest, AResetWhoseGreetingIsDamagedIsNoEnd) {
  board_->DamageLines([](const std::string& line) { return line.starts_with("[MSG:lake-stroke"); });
  board_->Later(1, [](HostRig& rig) { rig.PowerUp(); });
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("the board was reset")));
  ExpectStill();
}

TEST_F(StrokeSessionTest, AHoldWhoseReasonIsDamagedIsTold) {
  board_->DamageLines([](const std::string& line) { return line.starts_with("[MSG:host silent"); });
  options_.keep_alive_s = 60;
  EXPECT_THAT([&] { Run(); }, ThrowsMessage<Error>(HasSubstr("is held at its place, and the firmware's reason was "
                                                             "damaged on the line")));
  ExpectStill();
}

// As a user runs it; Ctrl-C in the middle of the program.
TEST_F(StrokeSessionTest, TheProgramRunsItAndStopsOnCtrlC) {
  const Outcome run = Shell(folder_, "lake-stroke run . --port " + board_->Port() + " --keep-alive 0.05 -o out");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("rows in log.csv"));
  EXPECT_GT(CsvTable::Read(folder_ / "out/log.csv").Rows(), 60u);
  const Outcome stopped = Shell(
      folder_, "timeout -s INT 5 lake-stroke run . --port " + board_->Port() + " --keep-alive 0.05 -o second; exit $?");
  EXPECT_TRUE(stopped.exit_code == 124 || stopped.exit_code == 130 || stopped.exit_code == 0) << stopped.err;
  ExpectStill();
}

}  // namespace
}  // namespace lake
