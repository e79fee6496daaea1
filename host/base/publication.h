// How a set of files gets its names as one. POSIX renames one file at a time, and a folder may hold a user's
// files too, be a mount or somebody's working folder, so it cannot be exchanged as a whole. What commits the
// set is therefore a journal, a hidden file of the folder that says which temporaries get which names:
//   1. every temporary is whole and on the disk;
//   2. the journal appears, by one rename: from here on the set is published, whatever ends the program;
//   3. the earlier set's record (its last file: run.json) goes first, then each file gets its name, files of
//   the earlier set that have no
//      successor go, the record gets its name last, and the journal goes.
// So before 2 a reader finds all of the earlier set; after 3 all of the new one; killed in between it finds
// no record, and the next run into the folder, or the next look at it with this program, goes through step 3
// again from its beginning, which ends the same. The journal knows each temporary by its size, number and
// time, so that a file that has its name already is told from one that is lost: then no record gets its name.
// A journal is obeyed only where it is a plain file of this user's own that nobody else may write, in the folder
// that it was written for: whoever left another may run the program themselves, and one that came with an
// archive asks for what its maker wants. A folder with the sticky bit (/tmp) has one for each user.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <sys/stat.h>

#include "host/base/error.h"

namespace raycube::base {

/// In a folder with the sticky bit "-" and the user's number follow.
inline constexpr const char* kJournalName = ".raycube-publication";

/// What a folder is about to be used for, which says what to do about a journal that is not this user's own.
enum class FolderUse {
  read,        ///< it is not looked at
  write_file,  ///< an error, but not in a folder with the sticky bit, where anybody may have put it
  write_set,   ///< an error: the set needs a journal
};

class Publication {
 public:
  struct List {
    bool replace = false;  ///< else a file that has one of the names already stops the publication
    std::vector<std::pair<std::string, std::string>>
        files;                        ///< temporary, name; none with a folder. The last one is the set's record
    std::vector<std::string> remove;  ///< names of the earlier set; those that are among `files` too stay
  };

  /// Step 2. The files are the publication's from here on. Throws Error(input) when a name is taken,
  /// Error(environment) when a temporary has gone or the journal cannot be written; the files then are still
  /// the caller's.
  Publication(const std::string& folder, List list);
  /// The next change of step 3; false when there is none left. When it cannot be made, or a temporary has
  /// gone that did not get its name, throws: with `replace`, or of a publication that is taken up again, the
  /// journal stays and the error says how to go on; else what was done is taken back, temporaries too.
  bool step();

 private:
  friend bool finish_publication(const std::string&, FolderUse, bool);
  /// Takes up what the folder's journal says. Throws Error(environment) where it cannot be read.
  explicit Publication(const std::string& folder);

  /// What a file keeps when it gets another name.
  struct Mark {
    std::uint64_t bytes = 0, inode = 0;
    std::int64_t modified_ns = 0;
  };
  static Mark mark_of(const struct stat& status);

  void write_journal() const;
  void read_journal();
  bool waits(std::size_t number);
  Error gone(const std::string& temporary, const std::string& name, const std::string& way_out) const;
  bool take_record_away();
  bool name_file(std::size_t number);
  bool remove_earlier();
  void take_back(std::size_t named);
  std::string in_folder(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_, journal_;
  List list_;
  std::vector<Mark> marks_;  ///< of the temporaries
  std::size_t next_ = 0;
  bool resumed_ = false;  ///< read from a journal
};

/// Ends a publication of this user's that was cut short in this folder, if there is one: true. A living one
/// is waited for (some seconds). `locked`: the caller holds the folder's lock. Throws Error(environment)
/// where it cannot be ended, as on a read-only disk, and for somebody else's journal as `use` says.
bool finish_publication(const std::string& folder, FolderUse use = FolderUse::read, bool locked = false);

/// The same for the folder of a file that is about to be read.
void finish_publication_around(const std::string& file);

}  // namespace raycube::base
