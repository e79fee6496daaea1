#include "host/base/json_text.h"

#include <iterator>
#include <utility>

namespace raycube::base {

std::string shallow_json(std::string text) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted) {
      if (c == '\\') ++at;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepestJson) {
        text.resize(at);
        return text;
      }
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return text;
}

std::string shallow_json(std::istream& in) { return shallow_json(std::string(std::istreambuf_iterator<char>(in), {})); }

}  // namespace raycube::base
