// A small set of files and the ways it is published, or left half published, in tests of publications.
#pragma once

#include <doctest/doctest.h>

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/base/publication.h"
#include "tests/unit/test_folder.h"

namespace raycube::base::testing {

using raycube::testing::TestFolder;
namespace fs = std::filesystem;
using Names = std::set<std::string>;

inline const Names kSet = {"radiance.img", "radiance.hdr", "truth.img", "run.json"};

/// Files "what" of the set with one generation's content, record last.
inline void begin(OutputSet& set, const std::string& generation) {
  for (const char* name : {"radiance.img", "radiance.hdr", "truth.img"}) set.add(name).append(generation);
  set.add("run.json").append(generation);
}

inline void publish(const TestFolder& folder, const std::string& generation, IfExists if_exists = IfExists::replace) {
  OutputSet set(folder.path.string(), if_exists);
  begin(set, generation);
  set.publish();
}

/// Temporaries as a run has them that is about to publish, locked while the object lives, and with nobody who
/// would remove them after.
struct Orphans {
  Orphans(const TestFolder& folder, const std::string& generation, bool replace) {
    list.replace = replace;
    for (const char* name : {"radiance.img", "radiance.hdr", "truth.img", "run.json"}) {
      const std::string temporary = std::string(".") + name + ".raycube-abc123";
      folder.write(temporary, generation);
      list.files.emplace_back(temporary, name);
      locks.push_back(::open((folder / temporary).c_str(), O_RDONLY | O_CLOEXEC));
      REQUIRE(::flock(locks.back(), LOCK_EX | LOCK_NB) == 0);
    }
  }
  ~Orphans() {
    for (const int fd : locks) ::close(fd);
  }
  Orphans(const Orphans&) = delete;
  Orphans& operator=(const Orphans&) = delete;

  Publication::List list;
  std::vector<int> locks;
};

/// Every file of the set is there, of this generation.
inline bool whole(const TestFolder& folder, const std::string& generation) {
  for (const auto& name : kSet)
    if (!fs::exists(folder / name) || folder.read(name) != generation) return false;
  return true;
}

/// The message of the error that the action ends with.
inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  FAIL("no error");
  return "";
}

}  // namespace raycube::base::testing
