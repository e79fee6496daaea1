// A strict look at an OBJ text before Assimp reads it: every message names its line.
#include <cmath>
#include <sstream>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
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

/// Length of the UTF-8 character at `at`, 1 to 4; 0: the bytes are none.
std::size_t utf8_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xc2 && first < 0xe0 ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0u) != 0x80u) return 0;
  return length;
}

/// The three numbers of a vertex's line, and what follows them; none of another line.
std::optional<std::array<double, 3>> vertex_of(const std::string& line, std::string& rest) {
  if (line.size() < 2 || line[0] != 'v' || (line[1] != ' ' && line[1] != '\t')) return std::nullopt;
  std::istringstream words(line.substr(1));
  std::array<double, 3> out{};
  for (double& value : out) {
    std::string word;
    words >> word;
    const auto number = parse_number(word);
    if (!number) return std::nullopt;
    value = *number;
  }
  std::getline(words, rest);
  rest = trimmed(rest);
  if (!rest.empty()) rest = " " + rest;
  return out;
}

bool is_utf8(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string utf8_of_latin1(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      out += c;
    } else {
      out += static_cast<char>(0xc0 | code >> 6);
      out += static_cast<char>(0x80 | (code & 0x3f));
    }
  }
  return out;
}

}  // namespace

std::size_t obj_faces(const std::string& text) {
  std::size_t out = 0;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find_first_not_of(" \t\xEF\xBB\xBF");
    out += first != std::string::npos && line[first] == 'f' && first + 1 < line.size() &&
           (line[first + 1] == ' ' || line[first + 1] == '\t');
  }
  return out;
}

std::vector<std::array<double, 3>> obj_vertices(const std::string& text) {
  std::vector<std::array<double, 3>> out;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find_first_not_of(" \t\xEF\xBB\xBF");
    if (first == std::string::npos) continue;
    std::string rest;
    if (const auto vertex = vertex_of(line.substr(first), rest)) out.push_back(*vertex);
  }
  return out;
}

std::optional<std::string> obj_for_assimp(const std::string& text, const std::array<double, 3>& centre) {
  const bool moved = centre != std::array<double, 3>{};
  std::string out;
  out.reserve(text.size());
  std::size_t at = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1);
    std::string line = text.substr(at, end - at + 1);
    at = end + 1;
    if (const auto hash = line.find('#'); hash != std::string::npos) {
      const std::string comment = line.substr(hash);
      line.erase(hash);
      if (comment.ends_with('\n')) line += '\n';
    }
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string::npos && first > 0) line.erase(0, first);
    std::string rest;
    if (const auto vertex = moved ? vertex_of(line, rest) : std::nullopt)
      line = "v " + number_text((*vertex)[0] - centre[0]) + " " + number_text((*vertex)[1] - centre[1]) + " " +
             number_text((*vertex)[2] - centre[2]) + rest + "\n";
    out += line;
  }
  if (!is_utf8(out)) out = utf8_of_latin1(out);
  return out == text ? std::nullopt : std::optional(std::move(out));
}

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
