// A publication among strangers: journals that others left or changed are obeyed by nobody, and temporaries that others
// take away leave no set half named.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <sys/stat.h>
#include <unistd.h>

#include "tests/unit/publication_kit.h"

using namespace raycube::base;
using namespace raycube::base::testing;

namespace {

/// What any journal says that would have thesis.txt removed and another file named.
const char* const kTempting = R"({"replace":true,"files":[["new","run.json",3,1,1]],"remove":["thesis.txt"]})";

/// A journal's text as it stands in a folder: with its number.
std::string in_place(const std::string& folder, const std::string& text) {
  struct stat status {};
  REQUIRE(::stat(folder.c_str(), &status) == 0);
  return text.starts_with("{\"replace\"")
             ? "{\"folder\":" + std::to_string(static_cast<std::uint64_t>(status.st_ino)) + "," + text.substr(1)
             : text;
}

/// Nothing of the folder is read, removed or named, by whoever only looks.
void check_ignored(const TestFolder& folder) {
  const Names before = folder.names();
  CHECK_FALSE(finish_publication(folder.path.string()));
  finish_publication_around(folder / "x.img");
  CHECK(folder.names() == before);
}

}  // namespace

TEST_CASE("a journal that was tampered with reaches nothing outside its folder") {
  const TestFolder folder;
  fs::create_directory(folder / "in");
  folder.write("victim", "mine");
  for (const char* text :
       {R"({"replace":true,"files":[["../victim","a"]],"remove":[]})",
        R"({"replace":true,"files":[["../victim","a",4,1,1]],"remove":[]})",
        R"({"replace":true,"files":[["a","../victim",4,1,1]],"remove":[]})",
        R"({"replace":true,"files":[["a","b"]],"remove":[]})", R"({"replace":true,"files":[],"remove":["../victim"]})",
        "{", "", "[1]", R"({"replace":1,"files":[["a","b",4,1,1]],"remove":[]})"}) {
    CAPTURE(text);
    folder.write(std::string("in/") + kJournalName, in_place(folder / "in", text));
    CHECK(error_of([&] { finish_publication(folder / "in"); }).find("cannot be read") != std::string::npos);
    CHECK(folder.read("victim") == "mine");
  }
  folder.write("in/a", "new");
  folder.write(std::string("in/") + kJournalName,
               in_place(folder / "in", R"({"replace":true,"files":[["a","b",3,1,1]],"remove":["../victim"]})"));
  CHECK(finish_publication(folder / "in"));
  CHECK(folder.read("victim") == "mine");
}

TEST_CASE("a journal that this user did not leave is obeyed by nobody and waited for by nobody") {
  const TestFolder folder;
  const std::string journal = folder / kJournalName;
  folder.write("thesis.txt", "mine");
  folder.write("new", "new");
  folder.write("elsewhere", kTempting);
  std::vector<std::pair<std::function<void()>, std::string>> ways = {
      {[&] { REQUIRE(::mkfifo(journal.c_str(), 0600) == 0); }, "it is no regular file"},
      {[&] { fs::create_symlink(folder / "elsewhere", journal); }, "it cannot be opened"},
      {[&] { folder.write(kJournalName, kTempting), ::chmod(journal.c_str(), 0664); }, "others may write it"},
      {[&] { folder.write(kJournalName, kTempting), ::chmod(journal.c_str(), 0600); }, "left in another folder"},
      {[&] { folder.write(kJournalName, in_place("/", kTempting)), ::chmod(journal.c_str(), 0600); },
       "left in another folder"}};
  if (::geteuid() == 0)
    ways.emplace_back(
        [&] {
          folder.write(kJournalName, kTempting);
          REQUIRE(::chown(journal.c_str(), 65534, 65534) == 0);
        },
        "it belongs to user 65534");
  for (const auto& [put, reason] : ways) {
    CAPTURE(reason);
    put();
    check_ignored(folder);
    // Where it stands in a folder of one's own, whoever would write is told its name.
    const std::function<void()> file = [&] { OutputFile(folder / "x"); };
    const std::function<void()> set = [&] { OutputSet(folder.path.string()); };
    for (const auto& write : {file, set}) {
      const std::string error = error_of(write);
      CHECK(error.find(journal + ": ") == 0);
      CHECK(error.find(reason) != std::string::npos);
      CHECK(error.find("remove it") != std::string::npos);
    }
    CHECK(folder.read("thesis.txt") == "mine");
    fs::remove(journal);
  }
}

TEST_CASE("in a folder of everybody's nobody's journal stands in another's way") {
  const TestFolder folder;
  fs::permissions(folder.path, fs::perms::all | fs::perms::sticky_bit);
  const std::string own = kJournalName + ("-" + std::to_string(::geteuid()));
  folder.write("thesis.txt", "mine");
  folder.write(kJournalName, "garbage");
  folder.write(std::string(kJournalName) + "-4242", kTempting);
  check_ignored(folder);
  publish(folder, "new", IfExists::refuse);
  CHECK(whole(folder, "new"));
  {
    const Orphans orphans(folder, "newer", true);
    const Publication publication(folder.path.string(), orphans.list);
    CHECK(folder.names().count(own) == 1);
  }
  CHECK(finish_publication(folder.path.string()));
  CHECK(whole(folder, "newer"));
  // Somebody has put something under this user's name for it: files pass by, a set has to go elsewhere.
  REQUIRE(::mkfifo((folder / own).c_str(), 0600) == 0);
  check_ignored(folder);
  write_output_file(folder / "x.csv", "x", IfExists::refuse);
  CHECK(folder.read("x.csv") == "x");
  CHECK(error_of([&] { OutputSet set(folder.path.string()); }).find(own + ": ") != std::string::npos);
  CHECK(folder.read("thesis.txt") == "mine");
}

TEST_CASE("another user's hidden files are not swept: they may wait for their names" *
          doctest::skip(::geteuid() != 0)) {
  const TestFolder folder;
  folder.write(".a.raycube-abc123", "theirs");
  folder.write(".b.raycube-abc123", "mine");
  REQUIRE(::chown((folder / ".a.raycube-abc123").c_str(), 65534, 65534) == 0);
  { OutputFile next(folder / "next.img"); }
  CHECK(folder.names() == Names{".a.raycube-abc123"});
}

TEST_CASE("the journal is private whatever the umask, so that it is obeyed again") {
  const TestFolder folder;
  const mode_t mask = ::umask(0);
  Orphans orphans(folder, "new", false);
  { const Publication publication(folder.path.string(), orphans.list); }
  ::umask(mask);
  struct stat status {};
  REQUIRE(::stat((folder / kJournalName).c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0600);
  CHECK(finish_publication(folder.path.string()));
  CHECK(whole(folder, "new"));
}

TEST_CASE("a temporary that vanishes names no record beside another run's files") {
  for (const bool replace : {true, false})
    for (const char* lost : {"radiance.img", "run.json"}) {
      CAPTURE(replace);
      CAPTURE(lost);
      const std::string temporary = std::string(".") + lost + ".raycube-abc123";
      // Before the journal: nothing has happened.
      {
        const TestFolder folder;
        if (replace) publish(folder, "old run");
        const Orphans orphans(folder, "new", replace);
        fs::remove(folder / temporary);
        const std::string error = error_of([&] { Publication(folder.path.string(), orphans.list); });
        CHECK(error.find(temporary + ": has gone") != std::string::npos);
        CHECK_FALSE(fs::exists(folder / kJournalName));
        if (replace) CHECK(whole(folder, "old run"));
      }
      // In the middle of a living publication.
      {
        const TestFolder folder;
        if (replace) publish(folder, "old run");
        const Orphans orphans(folder, "new", replace);
        Publication publication(folder.path.string(), orphans.list);
        fs::remove(folder / temporary);
        CHECK(error_of([&] {
                while (publication.step()) {
                }
              }).find(temporary + ": has gone") != std::string::npos);
        if (!replace) CHECK(folder.names().empty());
        if (fs::exists(folder / "run.json")) CHECK(whole(folder, "old run"));
      }
      // Killed, and gone before the next look: nothing changes, and nothing has the wrong name.
      {
        const TestFolder folder;
        if (replace) publish(folder, "old run");
        {
          const Orphans orphans(folder, "new", replace);
          const Publication publication(folder.path.string(), orphans.list);
        }
        fs::remove(folder / temporary);
        const Names before = folder.names();
        const std::string error = error_of([&] { finish_publication(folder.path.string()); });
        CHECK(error.find(temporary + ": has gone") != std::string::npos);
        CHECK(error.find("remove " + (folder / kJournalName) + " and run again") != std::string::npos);
        CHECK(folder.names() == before);
        if (replace) CHECK(whole(folder, "old run"));
        // The way out is one.
        fs::remove(folder / kJournalName);
        publish(folder, "newer");
        CHECK(whole(folder, "newer"));
        CHECK(folder.names() == kSet);
      }
    }
}
