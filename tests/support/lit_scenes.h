// Scenes under a sun and an even sky, through air that does nothing, in four narrow bands of curves that bend: what
// tests of light between surfaces hold against closed forms.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "atmos_tables/synthetic.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace raycube::test {

inline constexpr double kSunIrradiance = 1500;
inline const std::vector<double> kCentres = {0.45, 0.55, 0.7, 0.86};

/// Mean and standard error of a band over an image's pixels.
struct Mean {
  double value = 0, error = 0;
};
inline Mean mean_of(const Image& image, int band) {
  double sum = 0, square = 0;
  const int count = image.lines * image.pixels;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel) {
      const double l = image.at(line, pixel, band);
      sum += l, square += l * l;
    }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, square / count - mean * mean) / count)};
}

/// Within 4.5 of its standard errors, and what the scene's own finite size and facets miss of the closed form.
inline void check_mean(const Mean& found, double want, double unlike) {
  CAPTURE(found.value);
  CAPTURE(found.error);
  CAPTURE(want);
  CHECK_WITHIN(found.value - want, 4.5 * found.error + unlike * want);
  CHECK_BELOW(found.error, 0.01 * want);
}

/// A reflectance that bends: a + b sin(c l), on nodes of 5 nm.
inline scene::Curve wavy(double a, double b, double c) {
  scene::Curve out;
  for (int i = 0; i <= 220; ++i) {
    out.wavelength_um.push_back(0.3 + 0.005 * i);
    out.value.push_back(a + b * std::sin(c * out.wavelength_um.back()));
  }
  return out;
}
inline double at(const scene::Curve& curve, double l) {
  const double x = (l - 0.3) / 0.005;
  const auto i = static_cast<std::size_t>(x);
  const double f = x - static_cast<double>(i);
  return (1 - f) * curve.value[i] + f * curve.value[i + 1];
}
/// Mean over a band as narrow as those of `narrow`: the curves are smooth over it.
inline std::vector<scene::Band> narrow() { return gaussian_bands(kCentres, 0.004); }

/// Renders under a sun at this place and an even sky, through air that does nothing.
inline Image lit(scene::Simulation& simulation, int levels, double zenith_deg, double azimuth_deg, double sky_radiance,
                 const render::RenderOptions& options = {}) {
  simulation.bounces = levels;
  simulation.sun.zenith_deg = zenith_deg, simulation.sun.azimuth_deg = azimuth_deg;
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSunIrradiance; };
  air.sky_radiance = [=](double) { return sky_radiance; };
  air.sun_zenith_deg = zenith_deg, air.sun_azimuth_deg = azimuth_deg;
  return render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.35, 1.0, 0.005)), options);
}

}  // namespace raycube::test
