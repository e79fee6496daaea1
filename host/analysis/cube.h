// An ENVI cube as the analyses read it: the bands that are asked for, in double, some lines at a time, so that memory
// does not grow with the cube.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/products/envi_reader.h"

namespace raycube::analysis {

/// Which bands take part; both empty: all but those that the header calls bad (bbl).
struct BandChoice {
  std::string numbers;         ///< "1:50,60": from 1, ends included, bad ones too
  std::string wavelengths_nm;  ///< "418:643,900:1300": bands whose centre lies in one of these, but bad ones
};

/// Some lines of a cube.
struct Pixels {
  std::int64_t first_line = 0, lines = 0, samples = 0;
  std::size_t bands = 0;
  std::vector<double> value;         ///< [pixel][band], pixels line by line
  std::vector<std::uint8_t> counts;  ///< [pixel]: 0: a band is not finite, or the header's ignore value

  std::size_t count() const { return static_cast<std::size_t>(lines * samples); }
  const double* at(std::size_t pixel) const { return value.data() + pixel * bands; }
};

class Cube {
 public:
  /// Throws Error(input): no such file, complex numbers, no band left, a choice that names what is not there.
  explicit Cube(const std::string& path, const BandChoice& choice = {});

  std::int64_t samples() const { return header().samples; }
  std::int64_t lines() const { return header().lines; }
  std::size_t bands() const { return band_.size(); }
  std::uint64_t pixels() const { return static_cast<std::uint64_t>(samples()) * static_cast<std::uint64_t>(lines()); }
  const std::string& path() const { return path_; }
  const products::EnviHeader& header() const { return reader_.header(); }
  /// Numbers in the file, from 0, of the bands that take part.
  const std::vector<std::size_t>& chosen() const { return band_; }
  /// Of the bands that take part, um; empty: the header has none.
  std::vector<double> wavelength_um() const { return of_chosen(header().wavelength_um()); }
  std::vector<double> fwhm_um() const { return of_chosen(header().fwhm_um()); }
  /// "12 (509 nm)", or the band's name, or its number.
  std::string band_text(std::size_t band) const;

  /// Stored numbers times data gain plus data offset, over the reflectance scale factor.
  void read(std::int64_t first_line, std::int64_t lines, Pixels& out) const;
  /// Whether the numbers are used as they lie in the file, all bands of a pixel together.
  bool plain_floats() const;
  /// Of such a cube: numbers of `count` pixels from number `first_pixel` on, [pixel][band].
  void read_floats(std::size_t first_pixel, std::size_t count, float* out) const {
    reader_.read_floats(first_pixel, count, out);
  }
  /// Lines that are read at once: some megabytes.
  std::int64_t lines_at_once() const;

 private:
  std::vector<double> of_chosen(const std::vector<double>& all) const;

  std::string path_;
  products::EnviReader reader_;
  std::vector<std::size_t> band_;
  std::vector<double> gain_, offset_;  ///< of chosen bands
};

/// Parts of a cube that are gone through side by side, each in the order of its lines. Their number does not depend on
/// the number of threads, so that sums over them, taken in order, do not either.
inline constexpr int kMostParts = 32;

struct PartRange {
  std::int64_t first_line = 0, end_line = 0;
};
std::vector<PartRange> parts_of(const Cube& cube, int most = kMostParts);

/// What a long pass over a cube uses of the program around it.
struct Pass {
  int threads = 0;                                           ///< 0: as many as the machine has
  std::function<void(std::int64_t lines)> after_lines = {};  ///< told of lines done, from any thread
  int most_parts = kMostParts;                               ///< where each holds much
};

/// work(part, pixels) for all lines of all parts.
void for_each_part(const Cube& cube, const Pass& pass,
                   const std::function<void(std::size_t part, const Pixels& pixels)>& work);

/// Two cubes that are compared band by band must have as many, and at the same wavelengths within 1 %, or of the same
/// numbers where a header has none, and no two different units of radiance; Error(input) else.
void require_same_bands(const Cube& a, const Cube& b);
/// Two cubes of one scene must have as many samples, lines and bands; Error(input) else.
void require_same_size(const Cube& a, std::int64_t samples, std::int64_t lines, const std::string& other);

}  // namespace raycube::analysis
