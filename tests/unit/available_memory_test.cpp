// Memory that limits of cgroups leave, from trees of /proc and /sys as Linux lays them out: sums by hand.
#include <doctest/doctest.h>

#include <filesystem>
#include <string>

#include "host/base/available_memory.h"
#include "tests/unit/test_folder.h"

using namespace raycube::base;
using raycube::testing::TestFolder;

namespace {

constexpr std::uint64_t kMiB = 1 << 20;

/// A machine of 8 GiB free, on which this process is in some groups.
struct Machine {
  explicit Machine(const std::string& cgroup) {
    put("proc/meminfo", "MemTotal:       16777216 kB\nMemAvailable:    8388608 kB\n");
    put("proc/self/status", "Name:\traycube\nVmSize:\t 1024 kB\nVmData:\t 512 kB\n");
    put("proc/self/cgroup", cgroup);
  }
  void put(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder.path / name).parent_path());
    folder.write(name, text);
  }
  void group2(const std::string& at, const std::string& limit, std::uint64_t used, std::uint64_t files = 0) const {
    put("sys/fs/cgroup" + at + "/memory.max", limit + "\n");
    put("sys/fs/cgroup" + at + "/memory.current", std::to_string(used) + "\n");
    put("sys/fs/cgroup" + at + "/memory.stat",
        "anon 1\ninactive_file " + std::to_string(files / 2) + "\nactive_file " + std::to_string(files / 2) + "\n");
  }
  AvailableMemory left() const { return available_memory(folder.path); }
  TestFolder folder;
};

}  // namespace

TEST_CASE("without limits the machine's free memory counts") {
  const Machine none("0::/user.slice\n");
  CHECK(none.left().bytes == 8192 * kMiB);
  CHECK(none.left().by == "free on this machine");
  none.group2("/user.slice", "max", 100 * kMiB);
  CHECK(none.left().bytes == 8192 * kMiB);
}

TEST_CASE("cgroups of version 2: the least that a group or one above it leaves; files read can be given back") {
  const Machine machine("0::/user.slice/job\n");
  machine.group2("/user.slice/job", std::to_string(1000 * kMiB), 300 * kMiB, 100 * kMiB);
  CHECK(machine.left().bytes == 800 * kMiB);  // 1000 - (300 - 100)
  CHECK(machine.left().by == "left by the limit of cgroup /user.slice/job");
  CHECK(machine.left().text() == "800 MiB left by the limit of cgroup /user.slice/job");
  // A limit above that is lower, and one that is there but leaves more.
  machine.group2("/user.slice", std::to_string(500 * kMiB), 400 * kMiB);
  CHECK(machine.left().bytes == 100 * kMiB);
  CHECK(machine.left().by == "left by the limit of cgroup /user.slice");
  machine.group2("/user.slice", std::to_string(5000 * kMiB), 400 * kMiB);
  CHECK(machine.left().bytes == 800 * kMiB);
  machine.group2("/user.slice/job", "max", 300 * kMiB);
  CHECK(machine.left().bytes == 4600 * kMiB);
  // More used than the limit says, as it is lowered below what is there: nothing is left.
  machine.group2("/user.slice/job", std::to_string(200 * kMiB), 300 * kMiB);
  CHECK(machine.left().bytes == 0);
}

TEST_CASE("cgroups of version 2 in a container, which sees its own as the root") {
  const Machine machine("0::/\n");
  machine.group2("", std::to_string(2000 * kMiB), 500 * kMiB);
  CHECK(machine.left().bytes == 1500 * kMiB);
  CHECK(machine.left().by == "left by the limit of cgroup /");
}

TEST_CASE("cgroups of version 1: the memory controller's, no limit where the number is huge") {
  const Machine machine("12:cpu,cpuacct:/docker/a\n7:memory:/docker/a\n0::/docker/a\n");
  const auto group1 = [&](const std::string& at, const std::string& limit, std::uint64_t used, std::uint64_t files) {
    machine.put("sys/fs/cgroup/memory" + at + "/memory.limit_in_bytes", limit + "\n");
    machine.put("sys/fs/cgroup/memory" + at + "/memory.usage_in_bytes", std::to_string(used) + "\n");
    machine.put("sys/fs/cgroup/memory" + at + "/memory.stat",
                "inactive_file 7\ntotal_inactive_file " + std::to_string(files) + "\ntotal_active_file 0\n");
  };
  group1("/docker/a", "9223372036854771712", 300 * kMiB, 0);
  CHECK(machine.left().bytes == 8192 * kMiB);
  group1("/docker/a", std::to_string(1000 * kMiB), 300 * kMiB, 50 * kMiB);
  CHECK(machine.left().bytes == 750 * kMiB);
  CHECK(machine.left().by == "left by the limit of cgroup /docker/a");
  // A container whose own group is mounted as the root, under the host's name.
  std::filesystem::remove_all(machine.folder.path / "sys/fs/cgroup/memory/docker");
  group1("", std::to_string(600 * kMiB), 100 * kMiB, 0);
  CHECK(machine.left().bytes == 500 * kMiB);
}
