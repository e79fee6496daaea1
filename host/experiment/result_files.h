// Numbers in the JSON files that steps leave, by their places: RFC 6901's, where name[key=value, ...] stands for the
// one element of a list that has these values. What stands in a sweep's lists has no number that lasts and is only
// found so.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace raycube::experiment {

class StudyTable;

/// Reports a text that is no place in a JSON file.
void check_place(StudyTable& table, const std::string& key, const std::string& place);

/// Of many places in few files: each is read once.
class ResultFiles {
 public:
  /// What lies there. where: who asks. Throws Error(input): no such file, no JSON, nothing there.
  const nlohmann::json& at(const std::string& path, const std::string& place, const std::string& where);

 private:
  std::map<std::string, nlohmann::json> files_;
};

}  // namespace raycube::experiment
