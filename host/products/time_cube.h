// Waveforms as an ENVI raster: samples are range bins, lines are records (pulse by pulse, of a pulse pixel by pixel),
// bands are what a record holds (laser lines, orders of scattering, expected and recorded). float32, BIL: each waveform
// is one run of bytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/output_file.h"

namespace raycube::products {

struct TimeCubeBand {
  std::string name;  ///< with its unit
  double wavelength_um = 0;
};

/// The time axis stands in the header as keys of our own, which other readers keep or skip:
///   raycube bin start ns   start of sample 0, after the centre of the emitted pulse
///   raycube bin width ns
///   raycube group index    range of a time t: c t / (2 group index)
///   raycube pixels         lines of one pulse
struct TimeCubeAxis {
  double start_s = 0, bin_s = 1e-9;
  int bins = 0;
  double group_index = 1;
  int pixels = 1;
};

/// Streams: rows go to disk as they come and their number need not be known before.
class TimeCubeWriter {
 public:
  TimeCubeWriter(base::OutputFile& data, base::OutputFile& header, TimeCubeAxis axis, std::vector<TimeCubeBand> bands);
  /// Next line: [band][bin].
  void add(const std::vector<float>& values);
  /// Writes the header. `sensor`, `description`, `acquisition_time`: see EnviHeader.
  void finish(const std::string& description, const std::string& sensor, const std::string& acquisition_time);
  std::int64_t lines() const { return lines_; }
  std::size_t bands() const { return bands_.size(); }

 private:
  base::OutputFile& data_;
  base::OutputFile& header_;
  TimeCubeAxis axis_;
  std::vector<TimeCubeBand> bands_;
  std::int64_t lines_ = 0;
  std::vector<float> buffer_;
};

}  // namespace raycube::products
