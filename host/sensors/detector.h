// What a camera's detector makes of band radiances: photo-electrons, noise, saturation, digital numbers
// (docs/sensors.md). With L a band's radiance (W m-2 sr-1 um-1) and k electrons per radiance:
//   S = k L (1 + PRNU g)                          signal, g of the element
//   n = Poisson(S + D) + read N + DSNU h          D = dark current x integration time; N of the reading, h its own
//   n = min(n, full well), DN = round(n / gain + offset), cut to 0 .. 2^bits - 1
// and the calibration beside: L = ((DN - offset) gain - D) / k. From optics, with an aperture A, a pixel's solid angle
// W, integration time t, transmission T, quantum efficiency Q and the band's width d (the integral of its response over
// its peak): k = A W t T Q d l / (h c), l the band's centre. From a table of noise: of variance v(L) = a + b L through
// its points k = 1 / b and a reading of k sqrt(a) electrons. A table of noise as a function of L is Gaussian.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// What one band's noise is made of.
struct BandNoise {
  double electrons_per_radiance = 0;  ///< 0: noise is Gaussian, of sigma(L)
  double a = 0, b = 0, c = 0;         ///< sigma(L) = |a sqrt(b + L) + c|, W m-2 sr-1 um-1
  double sigma(double radiance) const;
  double dark_e = 0, read_e = 0;  ///< electrons in the integration time; rms of a reading
  /// Of DN: radiance = gain DN + offset.
  double gain = 1, offset = 0;
};

/// What a band measures of a radiance, in the mean and in the variance of one element's readings; without saturation.
struct Expected {
  double mean = 0, sigma = 0;  ///< W m-2 sr-1 um-1
};

/// Elements that say nothing.
struct BadElement {
  std::int64_t line = -1, sample = -1;  ///< -1: of all
  int band = 0;
  bool full = false;  ///< else 0
};

class Detector {
 public:
  /// band_mean: of the image, W m-2 sr-1 um-1, where the detector has a ratio to it (asks_mean). Throws Error(input)
  /// where a table's variance falls with radiance.
  Detector(const scene::Instrument& instrument, std::uint64_t seed, std::vector<double> band_mean = {});
  static bool asks_mean(const scene::Instrument& instrument) { return instrument.detector->snr > 0; }

  bool digital() const { return spec_.bits > 0; }
  const std::vector<BandNoise>& bands() const { return band_; }
  /// What is stored of `samples` pixels of a line: DN, or radiance. radiance, out: [sample][band]. The same whatever
  /// else is asked for. Returns values cut off at the upper end.
  std::uint64_t measure(std::int64_t line, std::int64_t first_sample, std::int64_t samples, const float* radiance,
                        float* out) const;
  /// Of readings of an element of gain 1, quantisation in it.
  Expected expected(int band, double radiance) const;
  /// Noise-equivalent radiance at a radiance, and temperature at a kelvin's black body in band centre's wavelength.
  double nedt_K(int band, double kelvin) const;
  /// Those of the image, by band, then place.
  std::vector<BadElement> bad_elements() const;

 private:
  /// What an element keeps for a band.
  struct Element {
    double gain = 1, offset_e = 0;
    double bad;  ///< not a number: it is good; else what it says
  };
  std::uint32_t element_of(std::int64_t line, std::int64_t sample) const;
  Element make_element(std::uint32_t element, int band) const;
  Element element(std::uint32_t element, int band) const {
    return kept_.empty() ? make_element(element, band) : kept_[element * band_.size() + static_cast<std::size_t>(band)];
  }
  double top() const;

  const scene::Instrument& instrument_;
  scene::DetectorSpec spec_;
  std::uint64_t seed_;
  std::vector<BandNoise> band_;
  std::vector<Element> kept_;  ///< [element][band], where lines share elements
};

/// Integral of a band's response over its peak, um.
double width_um(const scene::Band& band);

}  // namespace raycube::sensors
