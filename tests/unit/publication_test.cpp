// A set of files appears as one: killed after any single change of a publication, or at any instant of a
// thousand runs, the folder holds all of the old set, or what the next look completes to all of the new one.
#include <cerrno>
#include <chrono>
#include <csignal>
#include <random>
#include <thread>

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/interrupt.h"
#include "tests/support/patience.h"
#include "tests/unit/publication_kit.h"

using namespace raycube::base;
using namespace raycube::base::testing;
using raycube::testing::Patience;

namespace {

/// A file system that can refuse a name neither by rename nor by hard links, as FAT on an old kernel.
bool plain_file_system = false;

/// From microseconds to tens of milliseconds, all magnitudes alike: whatever a publication takes here, some of these
/// instants come before its end. What is asked holds at every instant.
std::chrono::microseconds drawn_instant(std::mt19937& draw) {
  return std::chrono::microseconds(std::int64_t{1} << (draw() % 15));
}

}  // namespace

// The program finds these before libc's.
extern "C" int renameat2(int from_in, const char* from, int to_in, const char* to, unsigned flags) noexcept {
  if (plain_file_system && flags != 0) return errno = EINVAL, -1;
  return static_cast<int>(::syscall(SYS_renameat2, from_in, from, to_in, to, flags));
}

extern "C" int link(const char* from, const char* to) noexcept {
  if (plain_file_system) return errno = EPERM, -1;
  return static_cast<int>(::syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0));
}

TEST_CASE("killed after any step: no record beside files of another run, and the next look completes the set") {
  for (const bool replace : {true, false})
    for (int steps = 0;; ++steps) {
      CAPTURE(replace);
      CAPTURE(steps);
      const TestFolder folder;
      folder.write("notes.txt", "mine");
      if (replace) {
        publish(folder, "old");
        folder.write("preview.exr", "old");  // of the earlier set, without a successor
      }
      Orphans orphans(folder, "new", replace);
      if (replace) orphans.list.remove = {"preview.exr", "radiance.img", "../outside", "gone"};
      bool more = true;
      {
        Publication publication(folder.path.string(), orphans.list);
        for (int i = 0; i < steps && more; ++i) more = publication.step();
      }  // forgotten here, as by kill -9
      const bool cut = fs::exists(folder / kJournalName);
      if (fs::exists(folder / "run.json") && cut) {
        const std::string generation = folder.read("run.json");
        CHECK(whole(folder, generation));
        if (generation == "new") CHECK_FALSE(fs::exists(folder / "preview.exr"));
      }
      CHECK(finish_publication(folder.path.string()) == cut);
      CHECK(whole(folder, "new"));
      Names expected = kSet;
      expected.insert("notes.txt");
      CHECK(folder.names() == expected);
      CHECK_FALSE(finish_publication(folder.path.string()));
      if (more) continue;
      CHECK(steps ==
            2 + 4 + replace + replace);  // the files, the journal, the end; the old record and what has no successor
      break;
    }
}

TEST_CASE("killed while it is completed, at random instants: it still ends the same") {
  const Patience patience("a hundred publications that are completed");
  std::mt19937 draw(5);
  int cut_again = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const TestFolder folder;
    publish(folder, "old");
    {
      const Orphans orphans(folder, "new", true);
      const Publication publication(folder.path.string(), orphans.list);
    }
    const pid_t child = ::fork();
    if (child == 0) {
      finish_publication(folder.path.string());
      ::pause();
    }
    std::this_thread::sleep_for(drawn_instant(draw));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    cut_again += finish_publication(folder.path.string());
    CHECK(whole(folder, "new"));
    CHECK(folder.names() == kSet);
  }
  MESSAGE(cut_again << " of 100 were cut again");
}

TEST_CASE("kill -9 at random instants of hundreds of runs: all of the old set or all of the new one") {
  const TestFolder folder;
  const Patience patience("the journals of hundreds of publications");
  std::mt19937 draw(11);
  publish(folder, "0");
  int old_kept = 0, completed = 0, in_between = 0;
  for (int run = 1; run <= 200; ++run) {
    const std::string before = folder.read("run.json"), after = std::to_string(run);
    int ready[2];
    REQUIRE(::pipe(ready) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
      OutputSet set(folder.path.string(), IfExists::replace);
      begin(set, after);
      (void)!::write(ready[1], "x", 1);
      if (run == 2) ::pause();  // one at least is killed before it begins, on any machine
      set.publish();
      ::pause();
    }
    char byte;
    REQUIRE(::read(ready[0], &byte, 1) == 1);
    ::close(ready[0]), ::close(ready[1]);
    // Every other one where it matters: after the journal has appeared.
    const bool committed = run % 2 == 1;
    while (committed && !fs::exists(folder / kJournalName) && !whole(folder, after)) {
    }
    std::this_thread::sleep_for(drawn_instant(draw));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    // As somebody finds it who knows nothing of the journal.
    if (fs::exists(folder / "run.json")) CHECK((whole(folder, before) || whole(folder, after)));
    in_between += finish_publication(folder.path.string());
    const bool is_new = whole(folder, after);
    CHECK((is_new || (!committed && whole(folder, before))));
    (is_new ? completed : old_kept) += 1;
  }
  {
    OutputSet next(folder.path.string(), IfExists::replace);
    next.add("run.json");
  }
  CHECK(folder.names() == kSet);  // what the killed runs left is swept
  MESSAGE(old_kept << " kept the old set, " << completed << " have the new one, " << in_between
                   << " were killed in between");
  CHECK(old_kept > 0);
  CHECK(completed > 0);
}

TEST_CASE(
    "a publication that meets somebody's file gives nothing a name, and loses nothing when it was killed "
    "before") {
  const TestFolder folder;
  CHECK(error_of([&] {
          OutputSet set(folder.path.string());
          begin(set, "new");
          folder.write("truth.img", "somebody's");
          set.publish();
        }).find("is there already") != std::string::npos);
  CHECK(folder.names() == Names{"truth.img"});
  CHECK(folder.read("truth.img") == "somebody's");
  fs::remove(folder / "truth.img");

  // The name is taken between the journal and the renames: taken back.
  {
    const Orphans orphans(folder, "new", false);
    Publication publication(folder.path.string(), orphans.list);
    CHECK(publication.step());
    folder.write("truth.img", "somebody's");
    CHECK(error_of([&] {
            while (publication.step()) {
            }
          }).find("truth.img: is there already") != std::string::npos);
  }
  CHECK(folder.names() == Names{"truth.img"});

  // The same, and killed before it was noticed: the files wait for the user's word.
  fs::remove(folder / "truth.img");
  {
    const Orphans orphans(folder, "new", false);
    Publication publication(folder.path.string(), orphans.list);
    CHECK(publication.step());
  }
  folder.write("truth.img", "somebody's");
  CHECK(error_of([&] { finish_publication(folder.path.string()); }).find("move it away") != std::string::npos);
  CHECK(error_of([&] { OutputFile other(folder / "x"); }).find("move it away") != std::string::npos);
  CHECK(folder.read("truth.img") == "somebody's");
  fs::rename(folder / "truth.img", folder / "kept");
  CHECK(finish_publication(folder.path.string()));
  CHECK(whole(folder, "new"));
}

TEST_CASE("the next run into a folder completes what was cut, and then refuses or replaces as always") {
  for (const bool replace : {false, true}) {
    const TestFolder folder;
    publish(folder, "old");
    {
      const Orphans orphans(folder, "new", true);
      Publication publication(folder.path.string(), orphans.list);
      publication.step();
      publication.step();
    }
    CHECK_FALSE(fs::exists(folder / "run.json"));
    if (replace) {
      publish(folder, "newer");
      CHECK(whole(folder, "newer"));
    } else {
      OutputSet set(folder.path.string());
      CHECK(whole(folder, "new"));
      CHECK(error_of([&] { set.add("run.json"); }).find("--overwrite") != std::string::npos);
    }
    CHECK(folder.names() == kSet);
  }
}

TEST_CASE("a second Ctrl-C in the middle of a publication removes none of its files") {
  const Patience patience("the end of a run after a second Ctrl-C");
  const TestFolder folder;
  publish(folder, "old");
  const pid_t child = ::fork();
  if (child == 0) {
    install_signal_handlers();
    std::thread([&] {
      while (!fs::exists(folder / kJournalName)) {
      }
      while (true) ::kill(::getpid(), SIGINT);
    }).detach();
    try {
      while (true) publish(folder, "new");
    } catch (const Error&) {  // the first Ctrl-C, had it come between two publications
      ::pause();
    }
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK(WEXITSTATUS(status) == 130);
  finish_publication(folder.path.string());
  CHECK(whole(folder, "new"));
}

TEST_CASE("whatever killed runs left behind is swept, of other names too; a living run's temporaries stay") {
  const TestFolder folder;
  OutputFile living(folder / "living.img");
  for (const char* name :
       {".gone.img.raycube-AbC123", ".pictures.json.raycube-aaaaaa", ".pictures.json.raycube-aaaaaa.points.png"})
    folder.write(name, "x");
  const std::string beside = fs::path(living.temporary_path()).filename().string() + ".png";
  folder.write(beside, "x");
  const Names strangers = {".raycube-abc123",   ".a.raycube-abc12", ".a.raycube-abc1234",
                           ".a.raycube-abc_23", "a.raycube-abc123", ".a.raycube-"};
  for (const auto& name : strangers) folder.write(name, "a user's");
  { OutputFile next(folder / "next.img"); }
  Names expected = strangers;
  expected.insert({beside, fs::path(living.temporary_path()).filename().string()});
  CHECK(folder.names() == expected);
}

TEST_CASE("on a file system that cannot refuse a name --overwrite works, and a refusal says its reason") {
  const TestFolder folder;
  plain_file_system = true;
  publish(folder, "old");
  publish(folder, "new");
  CHECK(whole(folder, "new"));
  CHECK(folder.names() == kSet);
  const Orphans orphans(folder, "newer", true);
  Publication::List list = orphans.list;
  list.replace = false;
  for (auto& [temporary, name] : list.files) name = "other " + name;
  Publication publication(folder.path.string(), list);
  const std::string error = error_of([&] { publication.step(); });
  plain_file_system = false;
  CHECK(error.find("cannot be named: Operation not permitted") != std::string::npos);
}
