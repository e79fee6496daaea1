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
// again from its beginning, which ends the same.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace raycube::base {

inline constexpr const char* kJournalName = ".raycube-publication";

class Publication {
 public:
  struct List {
    bool replace = false;  ///< else a file that has one of the names already stops the publication
    std::vector<std::pair<std::string, std::string>>
        files;  ///< temporary, name; none with a folder. The last one is the set's record
    std::vector<std::string> remove;  ///< names of the earlier set; those that are among `files` too stay
  };

  /// Step 2. The files are the publication's from here on. Throws Error(input) when a name is taken,
  /// Error(environment) when the journal cannot be written; the files then are still the caller's.
  Publication(const std::string& folder, List list);
  /// The next change of step 3; false when there is none left. When it cannot be made, throws: with
  /// `replace`, or of a publication that is taken up again, the journal stays and the error says how to go
  /// on; else what was done is taken back, temporaries too.
  bool step();

 private:
  friend bool finish_publication(const std::string&, bool);
  Publication() = default;

  bool take_record_away();
  bool name_file(std::size_t number);
  bool remove_earlier();
  void take_back(std::size_t named);
  std::string in_folder(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
  List list_;
  std::size_t next_ = 0;
  bool resumed_ = false;  ///< read from a journal
};

/// Ends a publication that was cut short in this folder, if there is one: true. A living one is waited for
/// (some seconds). `locked`: the caller holds the folder's lock. Throws Error(environment) where it cannot be
/// ended, as on a read-only disk.
bool finish_publication(const std::string& folder, bool locked = false);

/// The same for the folder of a file that is about to be read.
void finish_publication_around(const std::string& file);

}  // namespace raycube::base
