#include "host/experiment/result_files.h"

#include <fstream>

#include "host/base/error.h"
#include "host/experiment/study_table.h"

namespace raycube::experiment {

void check_place(StudyTable& table, const std::string& key, const std::string& place) {
  bool sound = place.empty() || place.front() == '/';
  try {
    static_cast<void>(nlohmann::json::json_pointer(sound ? place : ""));
  } catch (const nlohmann::json::exception&) {
    sound = false;
  }
  if (!sound)
    table.problem(key, "no place in a JSON file", "'" + place + "'", "begin with /, as in /curves/0/area (RFC 6901)");
}

const nlohmann::json& ResultFiles::at(const std::string& path, const std::string& place, const std::string& where) {
  const auto [file, fresh] = files_.try_emplace(path);
  if (fresh) {
    std::ifstream in(path);
    if (!in) throw base::Error(base::Fault::input, where + ": " + path + " is not there; is its step among the steps?");
    file->second = nlohmann::json::parse(in, nullptr, false);
  }
  if (file->second.is_discarded())
    throw base::Error(base::Fault::input, where + ": " + path + " is no JSON (which has no NaN)");
  const nlohmann::json* found = nullptr;
  try {
    const nlohmann::json::json_pointer pointer(place);
    if (file->second.contains(pointer)) found = &file->second.at(pointer);
  } catch (const nlohmann::json::exception&) {
  }
  if (!found) throw base::Error(base::Fault::input, where + ": " + path + " has nothing at " + place);
  return *found;
}

}  // namespace raycube::experiment
