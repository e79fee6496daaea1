// Which pixels need all samples, by a first look with few.
//
// The look's samples are a lattice shifted in each pixel, so that a line or an edge that misses one pixel's samples
// meets its neighbours'. A pixel is settled when it and its eight neighbours are all in sunlight or all out of it, all
// on the scene or all off it, and their standard errors, pooled, are within the tolerance. A pixel's own spread would
// not do: edges between its samples leave none, and such pixels would carry the whole error. What is not settled is
// rendered with other samples, so that its value does not depend on having been picked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace raycube::render {

/// What the look saw of a rectangle of pixels, line by line.
struct FirstLook {
  int lines = 0, columns = 0;
  std::vector<float> error;  ///< of the worst band (standard_error.h); NaN: not known
  std::vector<float> truth;  ///< [pixel][layer]
  std::size_t layers = 0;
};

/// Pixels that need all samples: 1, the others 0. Neighbours outside the rectangle have no say.
std::vector<std::uint8_t> unsettled(const FirstLook& look, double tolerance);

}  // namespace raycube::render
