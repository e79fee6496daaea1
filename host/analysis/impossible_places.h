// Places of an image's pixels on the ground that cannot be: a damaged location.img makes a map of terabytes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace raycube::analysis {

/// Places of a line's pixels, metres in any system; not a number: it has none.
using PlacesOfLine = std::function<void(std::int64_t line, std::vector<std::array<double, 2>>& places)>;

/// Throws Error(input) that names the first pixel of `file` whose place is no place on the Earth: more than 1e9 m from
/// zero.
void refuse_places_off_earth(const std::string& file, std::int64_t lines, const PlacesOfLine& read);

/// The same of images that are put on a map, where one pixel decides how large that is: nor may a place be more than
/// 1000 times as far from the image's middle as 98 of 100 pixels lie apart, or more than 10 times and that far from
/// each of its neighbours as well.
void refuse_impossible_places(const std::string& file, std::int64_t lines, const PlacesOfLine& read);

}  // namespace raycube::analysis
