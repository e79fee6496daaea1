// Texts that are cut before they nest deeper than anybody's stack.
#include <doctest/doctest.h>

#include <sstream>
#include <string>

#include "host/base/json_text.h"

using raycube::base::kDeepestJson;
using raycube::base::shallow_json;

TEST_CASE("JSON of up to the deepest level stays as it is, byte by byte") {
  const std::string deep(kDeepestJson, '['), shut(kDeepestJson, ']');
  for (const std::string& text : {std::string(), std::string(R"({"a": [1, {"b": []}]})"), deep + shut,
                                  deep + shut + deep, std::string("not json ]]]] at all"), std::string(R"("\)")}) {
    CHECK(shallow_json(text) == text);
    std::istringstream in(text);
    CHECK(shallow_json(in) == text);
  }
}

TEST_CASE("deeper text is cut at the bracket that goes beyond, whichever kind") {
  const std::string deep(kDeepestJson, '[');
  for (const char open : {'[', '{'}) CHECK(shallow_json(deep + open + "1]") == deep);
  CHECK(shallow_json(std::string(1000000, '[')).size() == kDeepestJson);
}

TEST_CASE("brackets in strings are text, quotes behind a backslash too") {
  const std::string many(5 * kDeepestJson, '[');
  for (const std::string& text : {'"' + many + '"', "{\"a\\\"" + many + "\": 1}", "[\"\\\\\", \"" + many + "\"]"})
    CHECK(shallow_json(text) == text);
  CHECK(shallow_json("\"\\\\\"" + many).size() == 4 + kDeepestJson);
}
