#include "host/base/publication.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/output_file.h"

namespace raycube::base {
namespace fs = std::filesystem;
namespace {

constexpr std::chrono::milliseconds kPatience{10000}, kGlance{10};

bool present(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat first {}, second {};
  return ::lstat(a.c_str(), &first) == 0 && ::lstat(b.c_str(), &second) == 0 &&
         first.st_dev == second.st_dev && first.st_ino == second.st_ino;
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

void sync_folder(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);  // some file systems refuse it for folders: the renames themselves have succeeded
  ::close(fd);
}

void write_journal(const std::string& folder, const Publication::List& list) {
  nlohmann::json files = nlohmann::json::array();
  for (const auto& [temporary, name] : list.files) files.push_back({temporary, name});
  const auto text = nlohmann::json{{"replace", list.replace}, {"files", files}, {"remove", list.remove}}.dump(
      -1, ' ', false, nlohmann::json::error_handler_t::replace);
  write_output_file(folder + "/" + kJournalName, text, IfExists::refuse);
}

Publication::List read_journal(const std::string& folder) {
  const std::string path = folder + "/" + kJournalName;
  std::ifstream in(path);
  try {
    const auto json = nlohmann::json::parse(in);
    Publication::List list{json.at("replace"), json.at("files"), json.at("remove")};
    bool sound = !list.files.empty();
    for (const auto& [temporary, name] : list.files)
      sound = sound && plain_name(temporary) && plain_name(name);
    if (sound) return list;
  } catch (const nlohmann::json::exception&) {
  }
  throw Error(Fault::environment, path +
                                      ": a run was cut short while its files got their names, and its list "
                                      "of them cannot be read; look at the "
                                      "hidden files of the folder, then remove this one");
}

}  // namespace

Publication::Publication(const std::string& folder, List list) : folder_(folder), list_(std::move(list)) {
  for (const auto& [temporary, name] : list_.files)
    if (!list_.replace && present(in_folder(name))) throw taken(in_folder(name));
  write_journal(folder_, list_);
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
      ::unlink(in_folder(kJournalName).c_str());
      sync_folder(folder_);
      return true;
    } else {
      return false;
    }
  }
}

bool Publication::take_record_away() {
  const auto& [temporary, name] = list_.files.back();
  // Where the temporary has gone, the record that stands there is the new one.
  if (!list_.replace || !present(in_folder(temporary))) return false;
  return ::unlink(in_folder(name).c_str()) == 0;
}

/// False: it had been named before.
bool Publication::name_file(std::size_t number) {
  const std::string from = in_folder(list_.files[number].first), to = in_folder(list_.files[number].second);
  if (!present(from)) return false;
  if (list_.replace) {
    if (::rename(from.c_str(), to.c_str()) != 0)
      throw Error(Fault::environment, to + ": cannot be named: " + std::strerror(errno) +
                                          "; mend that, and the next look at the folder (`raycube info " +
                                          folder_ + "`) or run into it names the rest");
    return true;
  }
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  int code = errno;
  if (code == EINVAL ||
      code == ENOSYS) {  // file systems without it: a hard link refuses an existing name just as well
    code = ::link(from.c_str(), to.c_str()) == 0 || same_file(from, to) ? 0 : errno;
    if (code == 0) return ::unlink(from.c_str()), true;
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
  if (!present(in_folder(list_.files.back().first))) return false;  // done before the record had its name
  for (const std::string& name : list_.remove) {
    if (!list_.replace || !plain_name(name)) continue;
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
    if (!present(from)) ::rename(to.c_str(), from.c_str());
  }
  ::unlink(in_folder(kJournalName).c_str());
  for (const auto& file : list_.files) ::unlink(in_folder(file.first).c_str());
}

bool finish_publication(const std::string& folder, bool locked) {
  const std::string journal = folder + "/" + kJournalName;
  if (!present(journal)) return false;
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
    if (!present(journal)) return true;
  }
  if (!present(journal)) return true;
  if (::access(folder.c_str(), W_OK) != 0)
    throw Error(
        Fault::environment,
        folder + ": a run was killed while its files got their names, and they cannot be changed here: " +
            std::strerror(errno) + "; run `raycube info` on the folder as somebody who may write there");
  Publication rest;
  rest.folder_ = folder;
  rest.list_ = read_journal(folder);
  rest.resumed_ = true;
  while (rest.step()) {
  }
  return true;
}

void finish_publication_around(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  finish_publication(folder.empty() ? "." : folder.string());
}

}  // namespace raycube::base
