// A strict look at a PLY header before Assimp reads it: every message names its line.
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::scene {
namespace {

constexpr std::size_t kLongestLine = 65536;

/// Bytes of a scalar type in a binary file; none for an unknown name (Turk 1994, and the names with sizes
/// that came later).
std::optional<int> bytes_of(const std::string& type) {
  static const std::map<std::string, int> known = {{"char", 1},  {"uchar", 1},  {"short", 2},   {"ushort", 2},
                                                   {"int", 4},   {"uint", 4},   {"float", 4},   {"double", 8},
                                                   {"int8", 1},  {"uint8", 1},  {"int16", 2},   {"uint16", 2},
                                                   {"int32", 4}, {"uint32", 4}, {"float32", 4}, {"float64", 8}};
  const auto at = known.find(type);
  return at == known.end() ? std::nullopt : std::optional(at->second);
}

struct Element {
  int line = 0;
  std::string name, digits;
  double count = 0;
  double least_bytes_binary = 0, values = 0;  ///< of one element; a list has at least its length
};

class HeaderCheck {
 public:
  HeaderCheck(const std::string& text, const std::string& file, base::Problems& problems)
      : text_(text), file_(file), problems_(problems) {}

  void run() {
    while (const auto line = next_line()) {
      std::istringstream stream{std::string(*line)};
      std::vector<std::string> words;
      for (std::string word; stream >> word;) words.push_back(word);
      if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") {
        data_ = at_;
        check_counts();
        return;
      }
      if (!(words[0] == "format"    ? format(words)
            : words[0] == "element" ? element(words)
                                    : words[0] == "property" && property(words))) {
        report(line_, "PLY header has a line that PLY does not know", "'" + std::string(line->substr(0, 60)) + "'",
               "correct the file; is it cut short?");
        return;
      }
    }
    report(line_, "PLY header has no end", std::to_string(text_.size()) + " bytes without end_header",
           "restore the file: it is cut short");
  }

  /// Where the values of a binary file begin; 0: of text, or without an end of the header.
  std::size_t binary_data() const { return binary_ ? data_ : 0; }

 private:
  void report(int line, const std::string& what, const std::string& found, const std::string& way_out) {
    problems_.add({file_, line, 0, ""}, what, found, way_out);
  }

  /// Up to the line's end, which is \n, \r\n or, of old Macintoshes, \r; none past the text, or where a line
  /// goes on for ever.
  std::optional<std::string_view> next_line() {
    if (at_ >= text_.size()) return std::nullopt;
    const std::size_t end = text_.find_first_of("\r\n", at_);
    if (end == std::string::npos || end - at_ > kLongestLine) return std::nullopt;
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + (text_.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    ++line_;
    return line;
  }

  bool format(const std::vector<std::string>& words) {
    if (words.size() < 2) return false;
    binary_ = words[1] != "ascii";
    return words[1] == "ascii" || words[1] == "binary_little_endian" || words[1] == "binary_big_endian";
  }

  bool element(const std::vector<std::string>& words) {
    if (words.size() != 3) return false;
    const auto count = parse_number(words[2]);
    if (!count || !std::isfinite(*count) || *count < 0 || *count != std::floor(*count)) return false;
    elements_.push_back({line_, words[1], words[2], *count});
    return true;
  }

  bool property(const std::vector<std::string>& words) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (elements_.empty() || (!list && words.size() != 3)) return false;
    const auto bytes = bytes_of(words[list ? 2 : 1]);
    if (!bytes || (list && !bytes_of(words[3]))) return false;
    elements_.back().least_bytes_binary += *bytes;
    elements_.back().values += 1;
    return true;
  }

  /// A value of text takes a digit and something that parts it from the next; the last one may end the file.
  void check_counts() {
    double left = static_cast<double>(text_.size() - at_) + (binary_ ? 0 : 1);
    for (const Element& e : elements_) {
      const double needed = e.count * (binary_ ? e.least_bytes_binary : 2 * e.values);
      if (needed > left) {
        report(e.line, "PLY header counts more than the file holds",
               e.digits + " of '" + e.name + "' in " + std::to_string(text_.size()) + " bytes",
               "restore the file: it is cut short, or its header is another file's");
        return;
      }
      left -= needed;
    }
  }

  const std::string& text_;
  const std::string file_;
  base::Problems& problems_;
  std::size_t at_ = 0, data_ = 0;
  int line_ = 0;
  bool binary_ = false;
  std::vector<Element> elements_;
};

}  // namespace

void check_ply_header(const std::string& text, const std::string& file, base::Problems& problems) {
  HeaderCheck(text, file, problems).run();
}

std::optional<std::string> ply_for_assimp(const std::string& text) {
  base::Problems none;
  HeaderCheck header(text, "", none);
  if (text.starts_with("ply")) header.run();
  const std::size_t data = header.binary_data();
  if (data == 0 || data >= text.size() || text[data] != '\n' || text.compare(data - 2, 2, "\r\n") == 0)
    return std::nullopt;
  return text.substr(0, data) + "\n" + text.substr(data);
}

}  // namespace raycube::scene
