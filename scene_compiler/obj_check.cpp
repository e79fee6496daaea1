// A strict look at an OBJ text before Assimp reads it: every message names its line.
#include <cmath>
#include <sstream>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

constexpr std::size_t kMaxObjReports = 20;

/// OBJ reals may carry a sign, a point without digits behind it and an exponent.
bool check_vertex(std::istringstream& words, const Where& where, Problems& problems) {
  std::string word;
  int count = 0;
  for (; words >> word; ++count) {
    const auto number = parse_number(word);
    if (!number) {
      problems.add(where, "vertex coordinate is not a number", "'" + word + "'", "correct the line");
      return false;
    }
    if (!std::isfinite(*number) || std::abs(*number) > 1e18) {
      problems.add(where, "vertex is not finite", word, "correct the line");
      return false;
    }
  }
  if (count >= 3) return true;
  problems.add(where, "vertex has fewer than three coordinates", std::to_string(count), "correct the line");
  return false;
}

bool check_face(std::istringstream& words, long vertices, const Where& where, Problems& problems) {
  std::string word;
  while (words >> word) {
    const auto number = parse_number(word.substr(0, word.find('/')));
    const long index = number && std::abs(*number) < 1e15 ? static_cast<long>(*number) : 0;
    if (!number || *number != static_cast<double>(index)) {
      problems.add(where, "face index is not an integer", "'" + word + "'", "correct the line");
      return false;
    }
    // Positive counts from 1; negative counts back from the last vertex read so far.
    if (index == 0 || index < -vertices || index > vertices) {
      problems.add(where, "face index out of range", "'" + word + "' with " + std::to_string(vertices) + " vertices",
                   "indices run from 1, or from -1 backwards");
      return false;
    }
  }
  return true;
}

}  // namespace

void check_obj_text(const std::string& text, const std::string& file, Problems& problems) {
  // First pass counts vertices: a face may name vertices that follow it.
  long total = 0;
  for (std::size_t at = 0; at < text.size();
       at = text.find('\n', at) == std::string::npos ? text.size() : text.find('\n', at) + 1)
    if (text[at] == 'v' && at + 1 < text.size() && (text[at + 1] == ' ' || text[at + 1] == '\t')) ++total;
  std::istringstream stream(text);
  long vertices = 0;
  std::size_t reports = 0;
  std::string line, more;
  for (int number = 1; std::getline(stream, line); ++number) {
    const Where where{file, number, 0, ""};
    // A backslash at the end continues the line.
    while (trimmed(line).ends_with('\\') && std::getline(stream, more)) {
      line = line.substr(0, line.rfind('\\')) + " " + more;
      ++number;
    }
    if (const auto hash = line.find('#'); hash != std::string::npos) line.erase(hash);
    std::istringstream words(line);
    std::string kind;
    if (!(words >> kind)) continue;
    bool sound = true;
    if (kind == "v") {
      ++vertices;
      sound = check_vertex(words, where, problems);
    } else if (kind == "f") {
      // Negative indices count from here, positive ones may look ahead.
      const auto start = words.tellg();
      sound = check_face(words, total, where, problems);
      if (sound && line.find('-') != std::string::npos) {
        words.clear();
        words.seekg(start);
        std::string word;
        while (sound && words >> word) {
          const auto index = parse_number(word.substr(0, word.find('/')));
          if (index && *index < -static_cast<double>(vertices)) {
            problems.add(where, "face index out of range",
                         "'" + word + "' after " + std::to_string(vertices) + " vertices",
                         "a negative index counts back from the last vertex above it");
            sound = false;
          }
        }
      }
    }
    if (!sound && ++reports >= kMaxObjReports) {
      problems.add({file, 0, 0, ""}, "too many errors", "stopped at line " + std::to_string(number),
                   "correct the file");
      return;
    }
  }
}

bool sound_obj_places(const std::string& text) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string kind, word;
    if (!(words >> kind) || kind != "vt") continue;
    while (words >> word && word[0] != '#') {
      const auto number = parse_number(word);
      if (!number || !std::isfinite(*number)) return false;
    }
  }
  return true;
}

}  // namespace raycube::scene
