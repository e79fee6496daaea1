// Skies to test the plan's maps and rays under: even, and a real clear one.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "atmos_tables/clear_sky.h"
#include "host/base/units.h"
#include "host/plan/sky_factors.h"

namespace raycube::test {

/// A_0 = 1 / pi: irradiance 1 on horizontal ground.
inline plan::SkyBasis uniform_sky() {
  plan::SkyBasis basis;
  for (int i = 0; i <= 12; ++i) basis.zenith_rad.push_back(base::kPi / 2 * i / 12);
  for (int j = 0; j <= 6; ++j) basis.azimuth_rad.push_back(base::kPi * j / 6);
  basis.value.assign(basis.nodes(), {1 / base::kPi, 0, 0, 0});
  return basis;
}

inline atmos::RenderTable clear_sky(double sun_zenith_deg) {
  scene::Sun sun;
  sun.zenith_deg = sun_zenith_deg;
  return atmos::build_clear_sky({}, sun, 610, atmos::clear_sky_wavelengths(0.38, 2.48, 0.02), {0, 60});
}

/// All of the table's wavelengths count alike.
inline plan::SkyFactors factors_of(const atmos::RenderTable& table, int rank) {
  const std::size_t count = table.axis("wavelength").nodes.size();
  const plan::TableSpectra air(table, false, true, 0, count);
  const plan::SkyFactorizer sky(air, 0, base::rad_from_deg(table.sun_zenith_deg));
  const auto per_wavelength = [&](const plan::SkySpectra& s) {
    std::vector<plan::Mixture> out(count, plan::Mixture{});
    for (std::size_t l = 0; l < count; ++l)
      for (std::size_t m = 0; m < 4; ++m) out[l][m] = s[m][l] / s[0][l];
    return out;
  };
  return sky.factor(rank, plan::Spectrum(count, 1.0), per_wavelength);
}

/// How wavelength `line` mixes the maps.
inline plan::Mixture mixture_of(const plan::SkyFactors& factors, std::size_t line) {
  plan::Mixture out{};
  for (std::size_t m = 0; m < out.size(); ++m) out[m] = factors.spectra[m][line] / factors.spectra[0][line];
  return out;
}

}  // namespace raycube::test
