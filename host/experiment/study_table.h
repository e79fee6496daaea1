// A study's file: TOML read by the option table of its kind, each key with its place.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/option_table.h"

namespace raycube::experiment {

class StudyTable {
 public:
  /// Reads a file that begins with format = 1. Throws Error(input).
  static StudyTable read(const std::string& path, const scene::FileFormat& format);
  ~StudyTable();
  StudyTable(StudyTable&&) noexcept;

  /// What the key says, or its default; what it must say and does not is a problem.
  std::string text(const std::string& key);
  double number(const std::string& key);
  bool has(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key);
  std::vector<double> numbers(const std::string& key);
  /// A list of lists of texts, or one list of texts.
  std::vector<std::vector<std::string>> commands(const std::string& key);
  /// [[key]], or [key] alone; none when it is not there.
  std::vector<StudyTable> tables(const std::string& key);
  /// Where the table begins, or one of its keys.
  base::Where where(const std::string& key = "") const;
  /// Reports a problem with a key; collected with all others of the file.
  void problem(const std::string& key, const std::string& what, const std::string& found, const std::string& way_out);
  /// Of the file's own table, when all of it has been read: throws what has been found.
  void throw_if_any() const;
  /// Folder of the file.
  const std::string& folder() const;

 private:
  struct State;
  explicit StudyTable(std::shared_ptr<State> state);
  /// Row of a key of this table.
  const scene::KeySpec& spec(const std::string& key) const;
  /// Name of the table in messages, with a blank before it: " in [[step]]".
  std::string in() const;
  void missing(const std::string& key, const std::string& way_out);
  void report_unknown_keys();
  std::shared_ptr<State> state_;
};

}  // namespace raycube::experiment
