// Values of the command line in place of a file's: "atmosphere.visibility_km=12", "instrument.spectir.pixels=100".
// For document.cpp alone, which reads TOML.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

class Overrides {
 public:
  /// KEY=VALUE: tables and keys between dots; an entry of an array of tables by its name or its number from 0. VALUE as
  /// in TOML; what is no TOML is a text.
  Overrides(const std::vector<std::string>& texts, base::Problems& problems);

  /// Puts values where the table has their parent, the first table that does. prefix: of the table within the file, as
  /// "instrument.spectir.", for a file that says what another's table does.
  void apply(toml::table& table, const std::string& prefix = {});
  /// Reports values that found no place.
  void report_unused(const std::string& file, base::Problems& problems) const;

 private:
  struct One {
    std::string text;
    std::vector<std::string> way;  ///< of tables
    std::string key;
    toml::table holder;  ///< with `value`
    bool used = false;
  };
  std::vector<One> all_;
};

}  // namespace raycube::scene
