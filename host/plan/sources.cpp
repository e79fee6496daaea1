#include "host/plan/sources.h"

#include <algorithm>
#include <cmath>

namespace raycube::plan {

double Domain::horizontal_max() const { return std::sin(zenith_of_sec(view.sec_max)); }

double zenith_of_sec(double sec) { return std::acos(1 / std::max(1.0, sec)); }

Spectrum product(const Spectrum& a, const Spectrum& b, double factor) {
  Spectrum out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = factor * a[i] * b[i];
  return out;
}

Spectrum sun_source(const TableSpectra& air, double z, double sec) {
  const Spectrum sun = air.solar_irradiance();
  if (std::all_of(sun.begin(), sun.end(), [](double e) { return e == 0; }))
    return sun;  // night: such a table may lack the rest
  return product(sun, air.two_way_transmission(z, zenith_of_sec(sec)), 1 / std::numbers::pi);
}

Spectrum sky_path(const TableSpectra& air, double z, double sec, Sky sky) {
  if (!air.has_sky(sky)) return Spectrum(air.size(), 0.0);
  const double zenith = zenith_of_sec(sec);
  if (sky == Sky::thermal)
    return product(air.view_transmission(z, zenith), air.two_way_factor_thermal(z, zenith), 1 / std::numbers::pi);
  return product(air.view_transmission(z, zenith), air.two_way_factor(z, zenith), 1 / std::numbers::pi);
}

Spectrum lamp_source(const TableSpectra& air, const Domain& domain, double z, double sec) {
  if (domain.lamplight.empty()) return Spectrum(air.size(), 0.0);
  return product(domain.lamplight, air.view_transmission(z, zenith_of_sec(sec)), 1 / std::numbers::pi);
}

Spectrum environment_source(const TableSpectra& air, double z, double sec) {
  return product(air.ground_radiance(z), air.diffuse_view_transmission(z, zenith_of_sec(sec)));
}

Spectrum path_source(const TableSpectra& air, const Domain& domain, double z, double x, double y) {
  const double zenith = std::asin(std::min(1.0, std::hypot(x, y)));
  const double azimuth = x == 0 && y == 0 ? 0.0 : std::atan2(x, y) - domain.sun_azimuth;
  return air.path_radiance(z, std::min({zenith, air.last_view_zenith_rad(), 0.4999 * std::numbers::pi}), azimuth);
}

}  // namespace raycube::plan
