// JSON that somebody else may have written.
#pragma once

#include <istream>
#include <string>

namespace raycube::base {

inline constexpr int kDeepestJson = 100;  ///< levels; what raycube writes has less than 10

/// The text, cut before it nests deeper than kDeepestJson: what is cut is no JSON, so that a parser refuses it
/// there. Parsers build any depth, and whoever copies or writes such a value runs out of stack.
std::string shallow_json(std::string text);
/// The same of all that a stream holds.
std::string shallow_json(std::istream& in);

}  // namespace raycube::base
