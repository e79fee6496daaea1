// Reads any ENVI raster or spectral library: all eleven data types, both byte orders, the three interleaves.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/products/envi_header.h"

namespace raycube::products {

/// The two files of an ENVI pair. header: `name.img.hdr` or `name.hdr`; data: `name.img`, `name`, `name.dat`,
/// `name.sli` ...
struct EnviPaths {
  std::string header;
  std::string data;  ///< empty: a header without data
};

/// Finds the pair from the name of either file. Throws Error(input) when there is no header.
EnviPaths find_envi_pair(const std::string& path);

/// An open ENVI file. Values are handed out in (line, sample, band) order whatever the interleave; a complex sample
/// gives two values, real and imaginary. 64-bit integers beyond 2^53 round to the nearest double.
class EnviReader {
 public:
  /// Opens the pair. Throws Error(input) when a file is missing, the header is bad or the data file is too short for
  /// it.
  explicit EnviReader(const std::string& path);
  ~EnviReader();
  EnviReader(EnviReader&&) noexcept;

  const EnviHeader& header() const;
  const EnviPaths& paths() const;
  /// Values per pixel: bands, twice as many when complex.
  std::size_t values_per_pixel() const;

  /// Stored numbers of `count` lines, as they are.
  std::vector<double> read_lines(std::int64_t first, std::int64_t count) const;
  /// Stored numbers of some bands, numbered from 0, in the order given and without repeats: (line, sample, band). `out`
  /// is made as large as they are. Threads may read at once.
  void read_bands(std::int64_t first, std::int64_t count, std::span<const std::size_t> bands,
                  std::vector<double>& out) const;
  /// Whether the file holds floats of this machine's byte order, pixel by pixel, as read_floats() hands them out.
  bool holds_plain_floats() const;
  /// Numbers of `count` pixels, counted line by line from 0, of a file that holds plain floats: [pixel][band]. Threads
  /// may read at once. (The file is not mapped: a mapped file that is cut meanwhile ends the program.)
  void read_floats(std::uint64_t first_pixel, std::size_t count, float* out) const;
  /// read_lines() times data gain plus data offset, where the header has them.
  std::vector<double> read_lines_scaled(std::int64_t first, std::int64_t count) const;
  /// Stored numbers of one pixel.
  std::vector<double> read_pixel(std::int64_t line, std::int64_t sample) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::products
