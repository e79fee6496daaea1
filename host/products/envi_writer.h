// Writes an ENVI raster piece by piece in any order, in any interleave, as float32 or scaled uint16.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/products/coverage.h"
#include "host/products/envi_header.h"

namespace raycube::products {

/// Lines of an image, whole or a part of each, values in (line, sample, band) order as the kernels leave them.
struct Strip {
  std::int64_t first_line = 0;
  std::int64_t lines = 0;
  const float* values = nullptr;
  std::size_t pixel_stride = 0;  ///< floats from one pixel to the next, at least bands; 0: bands
  std::int64_t first_sample = 0;
  std::int64_t samples = 0;  ///< of a line; 0: all

  /// In an image whose lines have so many samples.
  Piece piece(std::int64_t all_samples) const {
    return {first_line, lines, first_sample, samples > 0 ? samples : all_samples};
  }
};

/// Samples that a uint16 product could not hold.
struct ClippedSamples {
  std::uint64_t low = 0;   ///< below 0, written as 0
  std::uint64_t high = 0;  ///< above 65535 / scale, written as 65535
  std::uint64_t nan = 0;   ///< not a number, written as 0
  double largest = 0;      ///< of all values, as they came
};

class EnviWriter {
 public:
  /// Begins `name` (".img") and its header (same name with ".hdr") in the set and claims the disk space. From `header`
  /// all but data type, byte order, header offset and gains is taken as it stands; interleave is the one it names. With
  /// integer_scale the file holds uint16 = round(value * scale) and the header data gain 1 / scale.
  EnviWriter(base::OutputSet& set, const std::string& name, EnviHeader header,
             std::optional<double> integer_scale = {});

  /// A strip, to its place in the file, whatever has come before. Throws Error(bug) when it leaves the image or comes
  /// twice.
  void write(const Strip& strip);
  /// Throws Error(bug) when something is missing.
  void require_whole() const { coverage_.require_whole(); }
  /// Writes the header, once the image is whole. Throws Error(bug) when something is missing.
  void finish();

  const EnviHeader& header() const { return header_; }
  EnviHeader& header() { return header_; }  ///< to complete before finish()
  const ClippedSamples& clipped() const { return clipped_; }
  /// Lines written before, in (line, sample, band) order, float32 files only.
  void read_back(std::int64_t first_line, std::int64_t lines, float* values) const;

 private:
  template <class Sample, class Convert>
  void write_as(const Strip& strip, Convert convert);
  template <class Sample>
  void write_piece(const Piece& piece, const Sample* values);
  void count_clipped(const Strip& strip, float scale);

  base::OutputFile& data_;
  base::OutputFile& text_;
  EnviHeader header_;
  std::optional<double> integer_scale_;
  Coverage coverage_;
  ClippedSamples clipped_;
  std::vector<unsigned char> buffer_;
};

}  // namespace raycube::products
