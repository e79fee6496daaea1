#include "host/base/publication.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/json_text.h"
#include "host/base/output_file.h"
#include "host/base/own_file.h"

namespace raycube::base {
namespace fs = std::filesystem;
namespace {

constexpr std::chrono::milliseconds kPatience{10000}, kGlance{10};

bool is_there(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat first {
  }, second{};
  return ::lstat(a.c_str(), &first) == 0 && ::lstat(b.c_str(), &second) == 0 && first.st_dev == second.st_dev &&
         first.st_ino == second.st_ino;
}

/// The folder's journal. Where everybody may put files that only their owners take away, as in /tmp, each
/// user has one of their own, so that nobody waits for another's.
std::string journal_of(const std::string& folder) {
  struct stat status {};
  const bool shared = ::stat(folder.c_str(), &status) == 0 && (status.st_mode & S_ISVTX) != 0;
  return folder + "/" + kJournalName + (shared ? "-" + std::to_string(::geteuid()) : "");
}

/// Number of a folder in its file system; 0: there is none.
std::uint64_t number_of(const std::string& folder) {
  struct stat status {};
  return ::stat(folder.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_ino) : 0;
}

/// Why what stands there is no journal that this user left in this folder; empty: it is one, or cannot be read, which
/// is told later. A journal names its folder's number: one that was unpacked or copied with a folder stands in another.
std::string why_not_own(const std::string& journal) {
  try {
    const auto json = nlohmann::json::parse(shallow_json(read_own_file(journal)), nullptr, false);
    const auto folder = fs::path(journal).parent_path().string();
    if (json.is_object() && json.value("folder", nlohmann::json()) != nlohmann::json(number_of(folder)))
      return "it was left in another folder, and came with a copy of it";
    return "";
  } catch (const std::runtime_error& reason) {
    return reason.what();
  }
}

/// What is not this user's own is obeyed by nobody, and ignored by who only reads. Whoever writes needs the
/// journal's name (a set), or would write among files that another run is about to name (a single file, but
/// not where everybody's files lie side by side).
void refuse_to_write_beside(const std::string& journal, const std::string& reason, FolderUse use) {
  const bool shared = fs::path(journal).filename() != kJournalName;
  if (use == FolderUse::read || (use == FolderUse::write_file && shared) || !is_there(journal)) return;
  throw Error(Fault::environment,
              journal + ": a list of files that wait for their names is obeyed only if this user left it (" + reason +
                  "); let whoever did run `raycube info` on the folder, or remove it, or choose "
                  "another -o");
}

/// A journal may come with a folder from anywhere: it reaches nothing outside.
bool plain_name(const std::string& name) {
  return !name.empty() && name.find('\0') == std::string::npos && name != "." && name != ".." &&
         name == fs::path(name).filename();
}

Error taken(const std::string& path) {
  return Error(Fault::input, path + ": is there already; give --overwrite to replace it, or another -o");
}

Error not_named(const std::string& path, int code) {
  return Error(Fault::environment, path + ": cannot be named: " + std::strerror(code));
}

}  // namespace

Publication::Publication(const std::string& folder, List list)
    : folder_(folder), journal_(journal_of(folder)), list_(std::move(list)) {
  for (const auto& [temporary, name] : list_.files) {
    if (!list_.replace && is_there(in_folder(name))) throw taken(in_folder(name));
    struct stat status {};
    if (::lstat(in_folder(temporary).c_str(), &status) != 0) throw gone(temporary, name, "run again");
    marks_.push_back(mark_of(status));
  }
  write_journal();
}

Publication::Publication(const std::string& folder) : folder_(folder), journal_(journal_of(folder)), resumed_(true) {
  read_journal();
}

Publication::Mark Publication::mark_of(const struct stat& status) {
  return {static_cast<std::uint64_t>(status.st_size), static_cast<std::uint64_t>(status.st_ino),
          std::int64_t{status.st_mtim.tv_sec} * 1000000000 + status.st_mtim.tv_nsec};
}

/// Replaces: its absence is known, the folder is locked, and not every file system can refuse a name.
void Publication::write_journal() const {
  nlohmann::json files = nlohmann::json::array();
  for (std::size_t i = 0; i < marks_.size(); ++i)
    files.push_back(
        {list_.files[i].first, list_.files[i].second, marks_[i].bytes, marks_[i].inode, marks_[i].modified_ns});
  OutputFile out(journal_, IfExists::replace);
  ::chmod(out.temporary_path().c_str(), 0600);  // whatever the umask: one that others may write is not obeyed
  out.append(nlohmann::json{
      {"folder", number_of(folder_)}, {"replace", list_.replace}, {"files", files}, {"remove", list_.remove}}
                 .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  out.publish();
}

void Publication::read_journal() {
  try {
    const auto json = nlohmann::json::parse(shallow_json(read_own_file(journal_)));
    list_.replace = json.at("replace"), list_.remove = json.at("remove");
    bool sound = !json.at("files").empty();
    for (const auto& file : json.at("files")) {
      list_.files.emplace_back(file.at(0), file.at(1));
      marks_.push_back({file.at(2), file.at(3), file.at(4)});
      sound = sound && plain_name(list_.files.back().first) && plain_name(list_.files.back().second);
    }
    if (sound) return;
  } catch (const std::exception&) {  // of the parser, or of who took the file away
  }
  throw Error(Fault::environment, journal_ +
                                      ": a run was cut short while its files got their names, and its list "
                                      "of them cannot be read; look at the "
                                      "hidden files of the folder, then remove this one");
}

bool Publication::step() {
  while (true) {
    const std::size_t files = list_.files.size(), at = next_++;
    // 0: the record goes; 1 ...: all files but the last; then the earlier set's rest, the last, the journal.
    if (at == 0) {
      if (take_record_away()) return true;
    } else if (at < files) {
      if (name_file(at - 1)) return true;
    } else if (at == files) {
      if (remove_earlier()) return true;
    } else if (at == files + 1) {
      if (name_file(files - 1)) return true;
    } else if (at == files + 2) {
      sync_folder(folder_);
      ::unlink(journal_.c_str());
      sync_folder(folder_);
      return true;
    } else {
      return false;
    }
  }
}

/// True: the file has its temporary name still. False: its final one, where a file stands that has the mark
/// of what was to be named. Another one there, or none, ends the publication.
bool Publication::waits(std::size_t number) {
  const auto& [temporary, name] = list_.files[number];
  if (is_there(in_folder(temporary))) return true;
  struct stat status {};
  if (::lstat(in_folder(name).c_str(), &status) == 0) {
    const Mark is = mark_of(status), was = marks_[number];
    // Some file systems number their files anew when they are mounted, and copies keep the time.
    if (is.bytes == was.bytes && (is.inode == was.inode || is.modified_ns == was.modified_ns)) return false;
  }
  if (list_.replace || resumed_) throw gone(temporary, name, "remove " + journal_ + " and run again with --overwrite");
  take_back(number);
  throw gone(temporary, name, "run again");
}

Error Publication::gone(const std::string& temporary, const std::string& name, const std::string& way_out) const {
  return Error(Fault::environment, in_folder(temporary) + ": has gone before it could be named " + name +
                                       ", so its run cannot be whole; " + way_out);
}

bool Publication::take_record_away() {
  // Where it waits no more, the record that stands there is the new one.
  if (!list_.replace || !waits(list_.files.size() - 1)) return false;
  return ::unlink(in_folder(list_.files.back().second).c_str()) == 0;
}

/// False: it had been named before.
bool Publication::name_file(std::size_t number) {
  const std::string from = in_folder(list_.files[number].first), to = in_folder(list_.files[number].second);
  if (!waits(number)) return false;
  if (list_.replace) {
    if (::rename(from.c_str(), to.c_str()) != 0)
      throw Error(Fault::environment, to + ": cannot be named: " + std::strerror(errno) +
                                          "; mend that, and the next look at the folder (`raycube info " + folder_ +
                                          "`) or run into it names the rest");
    return true;
  }
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  int code = errno;
  if (code == EINVAL || code == ENOSYS) {  // file systems without it: a hard link refuses an existing name just as well
    code = ::link(from.c_str(), to.c_str()) == 0 ? 0 : errno;
    if (code == 0 || same_file(from, to)) return ::unlink(from.c_str()), true;
  }
  if (resumed_)
    throw Error(Fault::environment, to +
                                        ": stands where a run that was killed while its files got their "
                                        "names wants to put one; move it away "
                                        "and look at the folder again (`raycube info " +
                                        folder_ + "`)");
  take_back(number);
  throw code == EEXIST ? taken(to) : not_named(to, code);
}

bool Publication::remove_earlier() {
  bool any = false;
  // Where the record waits no more it was done before.
  if (!list_.replace || !waits(list_.files.size() - 1)) return false;
  for (const std::string& name : list_.remove) {
    if (!plain_name(name)) continue;
    const std::string path = in_folder(name);
    std::error_code code;
    if (!fs::is_regular_file(fs::symlink_status(path, code))) continue;
    // By what the names mean to the file system: one that does not tell upper from lower case has two for our
    // own.
    const bool ours = std::any_of(list_.files.begin(), list_.files.end(), [&](const auto& file) {
      return file.second == name || file.first == name || same_file(in_folder(file.second), path);
    });
    if (!ours) any |= fs::remove(path, code);
  }
  return any;
}

/// Nothing was replaced: the files before `named` go back to their temporaries, the journal goes, then the
/// temporaries.
void Publication::take_back(std::size_t named) {
  while (named-- > 0) {
    const std::string from = in_folder(list_.files[named].first), to = in_folder(list_.files[named].second);
    if (!is_there(from)) ::rename(to.c_str(), from.c_str());
  }
  ::unlink(journal_.c_str());
  for (const auto& file : list_.files) ::unlink(in_folder(file.first).c_str());
}

bool finish_publication(const std::string& folder, FolderUse use, bool locked) {
  const std::string journal = journal_of(folder);
  if (!is_there(journal)) return false;
  if (const std::string reason = why_not_own(journal); !reason.empty()) {
    refuse_to_write_beside(journal, reason, use);
    return false;
  }
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  struct Close {
    int fd;
    ~Close() {
      if (fd >= 0) ::close(fd);
    }
  } close{fd};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  // Whoever publishes holds the folder's lock; file systems without locks answer otherwise and are taken to
  // be free.
  while (!locked && fd >= 0 && ::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    if (std::chrono::steady_clock::now() > deadline)
      throw Error(Fault::environment, folder + ": another run is giving its files their names; wait for it");
    std::this_thread::sleep_for(kGlance);
    if (!is_there(journal)) return true;
  }
  if (!is_there(journal)) return true;
  if (::access(folder.c_str(), W_OK) != 0)
    throw Error(Fault::environment,
                folder + ": a run was killed while its files got their names, and they cannot be changed here: " +
                    std::strerror(errno) + "; run `raycube info` on the folder as somebody who may write there");
  Publication rest(folder);
  // Before anything changes: each file waits, or has its name.
  for (std::size_t i = 0; i < rest.list_.files.size(); ++i) rest.waits(i);
  while (rest.step()) {
  }
  return true;
}

void finish_publication_around(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  finish_publication(folder.empty() ? "." : folder.string());
}

}  // namespace raycube::base
