#include "host/plan/curve.h"

#include "host/base/error.h"
#include "host/plan/sky_basis.h"

namespace raycube::plan {

std::vector<double> sample_curve(const scene::Material& material, const std::vector<double>& wavelength_um) {
  const auto& x = material.reflectance.wavelength_um;
  const auto& y = material.reflectance.value;
  if (x.empty()) throw base::Error(base::Fault::input, "material '" + material.name + "' has no reflectance curve");
  if (x.size() == 1) return std::vector<double>(wavelength_um.size(), y[0]);
  std::vector<double> out;
  out.reserve(wavelength_um.size());
  for (const double l : wavelength_um) {
    if (l < x.front() - 1e-9 || l > x.back() + 1e-9)
      throw base::Error(base::Fault::input, "material '" + material.name + "': its curve ends at " +
                                                std::to_string(1000 * (l < x.front() ? x.front() : x.back())) + " nm, " +
                                                std::to_string(1000 * l) + " nm is needed (" + material.source +
                                                "); give a curve that covers the instrument's bands");
    const Cell cell = find_cell(x, l);
    out.push_back((1 - cell.fraction) * y[cell.index] + cell.fraction * y[cell.index + 1]);
  }
  return out;
}

}  // namespace raycube::plan
