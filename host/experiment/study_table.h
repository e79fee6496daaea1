// A study's file: TOML read key by key, each with its place; what no one asked for is an unknown key.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::experiment {

class StudyTable {
 public:
  /// Reads a file that begins with format = 1. Throws Error(input).
  static StudyTable read(const std::string& path);
  ~StudyTable();
  StudyTable(StudyTable&&) noexcept;

  std::string text(const std::string& key, const std::optional<std::string>& otherwise = std::nullopt);
  double number(const std::string& key, const std::optional<double>& otherwise = std::nullopt);
  bool has(const std::string& key) const;
  bool is_text(const std::string& key) const;
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
  /// Every key has been asked for: reports those that no one did.
  void done();
  /// Of the file's own table, after done(): throws what has been found.
  void throw_if_any() const;
  /// Folder of the file.
  const std::string& folder() const;

 private:
  struct State;
  explicit StudyTable(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace raycube::experiment
