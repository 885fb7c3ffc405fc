// lake-cohort on a real Slurm: controller, node and authentication as processes of this test, in a folder of its own.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>

#include "cli/program_run.h"
#include "lake/core/csv.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A port of this machine that nobody listens at.
int FreePort() {
  const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(descriptor, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(descriptor);
  return ntohs(address.sin_port);
}

// Starts Slurm, waits until its node is idle, runs the command, and ends what it started, whatever comes.
constexpr const char* kWithSlurm = R"(
munged --foreground --force --key-file=$PWD/slurm/munge.key --socket=$PWD/slurm/munge.socket \
  --pid-file=$PWD/slurm/munged.pid --log-file=$PWD/slurm/munged.log --seed-file=$PWD/slurm/munged.seed \
  >slurm/munged.out 2>&1 &
munged=$!
export SLURM_CONF=$PWD/slurm/slurm.conf
while [ ! -S slurm/munge.socket ] && kill -0 $munged; do sleep 0.1; done
slurmctld -D -c >slurm/slurmctld.out 2>&1 &
controller=$!
slurmd -D >slurm/slurmd.out 2>&1 &
node=$!
trap 'kill $node $controller $munged; wait $node $controller $munged' EXIT
for i in $(seq 300); do sinfo -h -o %T 2>/dev/null | grep -q idle && break; sleep 0.1; done
sinfo -h -o %T | grep -q idle || { cat slurm/*.out >&2; exit 99; }
)";

class CohortSlurm : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"snakemake", "munged", "slurmctld", "slurmd", "sbatch", "sinfo"})
      if (std::system(fmt::format("command -v {} >/dev/null 2>&1", program).c_str()) != 0)
        GTEST_SKIP() << program << " is not installed; apt install snakemake slurm-wlm munge";
    fs::create_directories(folder_ / "slurm/state");
    fs::create_directories(folder_ / "slurm/spool");
    std::random_device random;
    std::string key;
    for (int i = 0; i < 1024; ++i) key += static_cast<char>(random());
    WriteTextFile(folder_ / "slurm/munge.key", key);
    fs::permissions(folder_ / "slurm/munge.key", fs::perms::owner_read | fs::perms::owner_write);
    WriteConfiguration();
  }

  void WriteConfiguration() {
    char host[256] = {};
    ASSERT_EQ(gethostname(host, sizeof host - 1), 0);
    const std::string name = std::string(host).substr(0, std::string(host).find('.'));
    const std::string folder = (folder_ / "slurm").string();
    const std::string user = std::to_string(geteuid());
    WriteTextFile(folder_ / "slurm/slurm.conf",
                  fmt::format("ClusterName=lake\nSlurmctldHost={0}(127.0.0.1)\nSlurmctldPort={1}\nSlurmdPort={2}\n"
                              "AuthType=auth/munge\nAuthInfo=socket={3}/munge.socket\nCredType=cred/munge\n"
                              "SlurmUser={4}\nSlurmdUser={4}\nStateSaveLocation={3}/state\nSlurmdSpoolDir={3}/spool\n"
                              "SlurmctldPidFile={3}/slurmctld.pid\nSlurmdPidFile={3}/slurmd.pid\n"
                              "ProctrackType=proctrack/pgid\nTaskPlugin=task/none\nMpiDefault=none\nReturnToService=2\n"
                              "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nMailProg=/bin/true\n"
                              "AccountingStorageType=accounting_storage/none\n"
                              "NodeName={0} NodeAddr=127.0.0.1 CPUs={5} RealMemory=4000 State=UNKNOWN\n"
                              "PartitionName=lake Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n",
                              name, FreePort(), FreePort(), folder, user, sysconf(_SC_NPROCESSORS_ONLN)));
  }

  TemporaryFolder folder_;
};

// The tables and curves are byte for byte those of this machine without a cluster.
TEST_F(CohortSlurm, GivesTheSameResults) {
  ASSERT_EQ(Shell(folder_,
                  "lake-synth --population 2 --seed-number 5 --repetitions 1 --rest 0.7 --rate 20 "
                  "--width 640 --height 360 --radius-px 2 --quiet -o people")
                .exit_code,
            0);
  // The studies by --slurm, the group's tables by a profile that says the same.
  fs::create_directories(folder_ / "profile");
  WriteTextFile(folder_ / "profile/config.yaml",
                "slurm: true\njobs: 8\nlatency-wait: 30\nmax-status-checks-per-second: 1\n");
  WriteTextFile(folder_ / "with_slurm.sh", std::string(kWithSlurm) +
                                               "lake-cohort people cluster participant --slurm --quiet &&\n"
                                               "lake-cohort people cluster group --profile profile --quiet\n");
  const Outcome cluster = Shell(folder_, "bash with_slurm.sh");
  ASSERT_EQ(cluster.exit_code, 0) << cluster.err;
  EXPECT_THAT(ReadTextFile(folder_ / "cluster/logs/snakemake.log"), Not(HasSubstr("rror")));
  EXPECT_TRUE(fs::is_directory(folder_ / "cluster/logs/.snakemake/slurm_logs/rule_study")) << "jobs of Slurm";

  ASSERT_EQ(Shell(folder_, "lake-cohort people here group --cores 2 --quiet").exit_code, 0);
  for (const char* table : {"trials.csv", "curves.csv", "reliability.csv", "differences.csv", "failures.csv"})
    EXPECT_EQ(ReadTextFile(folder_ / "cluster/group" / table), ReadTextFile(folder_ / "here/group" / table)) << table;
}

}  // namespace
}  // namespace lake
