// Errors of the four kinds a user meets, each with its exit status, and the collector that reports all bad input at
// once.
#pragma once

#include <stdexcept>
#include <map>
#include <string>
#include <vector>

namespace raycube::base {

/// Whose fault an error is; the value is the exit status of the program.
enum class Fault {
  check = 1,         ///< a check found a difference beyond its limits
  input = 2,         ///< bad input or usage
  environment = 3,   ///< file system, memory, missing library or data
  device = 4,        ///< OpenCL device or driver
  bug = 70,          ///< ours
  interrupted = 130  ///< Ctrl-C
};

/// An error that ends the command. `what()` is one clear message: what, where, the value found, the way out.
class Error : public std::runtime_error {
 public:
  Error(Fault fault, const std::string& message) : std::runtime_error(message), fault_(fault) {}
  Fault fault() const { return fault_; }
  int exit_status() const { return static_cast<int>(fault_); }

 private:
  Fault fault_;
};

/// A place in a user's file. line and column count from 1; 0 = unknown. element names an index ("face 12") when
/// the file has no lines of interest.
struct Where {
  std::string file;
  int line = 0;
  int column = 0;
  std::string element;
  std::string text() const;
};

/// Collects every problem found in the input so that one run reports them all: of a kind the first 20 in a file, and
/// how many more. A kind is a rule, whatever names and numbers it is told with.
class Problems {
 public:
  /// what: the rule that was broken; found: the offending value; way_out: what the user can do.
  void add(const Where& where, const std::string& what, const std::string& found, const std::string& way_out);
  /// What is no problem but should be known: how a declaration of a file was taken, what was left out.
  void tell(const Where& where, const std::string& what);
  const std::vector<std::string>& notices() const { return notices_; }
  bool empty() const { return count_ == 0; }
  /// Of all problems, told or not.
  std::size_t count() const { return count_; }
  std::vector<std::string> lines() const;
  /// Throws one Error(Fault::input) that lists them all; does nothing when there are none.
  void throw_if_any() const;

 private:
  struct Kind {
    std::size_t count = 0;
    std::string file, what;
  };
  std::size_t count_ = 0;
  std::vector<std::string> lines_, notices_;
  std::map<std::string, Kind> kinds_;
};

}  // namespace raycube::base
