// How far two images of one scene are shifted against each other (docs/analysis.md).
#pragma once

#include <string>
#include <vector>

namespace raycube::analysis {

/// One band of an image, line by line; not a number: no pixel.
struct Picture {
  std::size_t samples = 0, lines = 0;
  std::vector<double> value;
  double at(std::size_t line, std::size_t sample) const { return value[line * samples + sample]; }
};

/// Means of blocks of factor x factor pixels; what does not fill a block is left out.
Picture averaged(const Picture& picture, std::size_t factor);

struct Shift {
  double samples = 0, lines = 0;  ///< the second image shows at (x, y) what the first shows at (x - samples, y - lines)
  double samples_error = 0, lines_error = 0;  ///< standard errors: of the least squares and of the interpolation
  double correlation = 0;                     ///< of the two, once shifted
  bool found = false;                         ///< false: nothing in them says how they lie
};

/// Of a rectangle of the first: the whole shift within +- reach pixels by their correlation, then to parts of a pixel
/// by least squares of second(x + d) = a + b first(x), the second interpolated by Lagrange's polynomial through six
/// pixels along each axis.
Shift shift_of(const Picture& first, const Picture& second, std::size_t left, std::size_t top, std::size_t samples,
               std::size_t lines, int reach);

}  // namespace raycube::analysis
