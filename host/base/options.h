// Options of the command line, each declared once: name, unit, default, range and help. The parser, --help, the man
// page and --json-usage all read this table.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace raycube::base {

/// One row of the table. `set` receives the text a user typed; it checks the range and throws Error(input).
struct Option {
  std::string names;         ///< "-o,--output"; of a positional argument its placeholder, "FILE"
  std::string type;          ///< flag | count | integer | number | text | choice | memory
  std::string value_name;    ///< placeholder in usage lines: "N", "FILE"
  std::string unit;          ///< SI unit; empty when dimensionless
  std::string default_text;  ///< empty: none
  std::string range;         ///< "1 to 1024", "bip, bil, bsq"; empty: any
  std::string help;          ///< one sentence
  bool positional = false;
  bool required = false;
  bool repeats = false;  ///< may be given, or list values, more than once
  bool common = false;   ///< shared by several verbs
  std::function<void(const std::string&)> set;

  bool takes_value() const { return type != "flag" && type != "count"; }
  /// "--output" of "-o,--output"; a positional's placeholder.
  std::string long_name() const;
};

/// Declares options and binds each to a variable. The default shown to the user is the variable's value at declaration.
/// Every function returns the row so that rare attributes can be set.
class OptionTable {
 public:
  Option& flag(const std::string& names, const std::string& help, bool& value);
  Option& count(const std::string& names, const std::string& help, int& value);
  Option& text(const std::string& names, const std::string& value_name, const std::string& help, std::string& value);
  Option& texts(const std::string& names, const std::string& value_name, const std::string& help,
                std::vector<std::string>& values);
  Option& choice(const std::string& names, const std::vector<std::string>& choices, const std::string& help,
                 std::string& value);
  Option& number(const std::string& names, const std::string& unit, double low, double high, const std::string& help,
                 double& value);
  Option& memory(const std::string& names, const std::string& help, std::uint64_t& bytes);
  /// Integer: int, std::int64_t, std::uint64_t or std::uint32_t.
  template <class Integer>
  Option& integer(const std::string& names, const std::string& unit, Integer low, Integer high, const std::string& help,
                  Integer& value);
  /// No default: the variable stays empty unless the user gives a value.
  template <class Integer>
  Option& integer(const std::string& names, const std::string& unit, Integer low, Integer high, const std::string& help,
                  std::optional<Integer>& value);

  /// Positional arguments, in order of declaration.
  Option& argument(const std::string& placeholder, const std::string& help, std::string& value);
  Option& optional_argument(const std::string& placeholder, const std::string& help, std::string& value);
  /// One or more, the last of the positional arguments.
  Option& arguments(const std::string& placeholder, const std::string& help, std::vector<std::string>& values);

  const std::vector<Option>& rows() const { return rows_; }
  std::vector<Option>& rows() { return rows_; }

 private:
  Option& add(Option option);
  std::vector<Option> rows_;
};

}  // namespace raycube::base
