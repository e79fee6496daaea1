#include "atmos_tables/solver/column.h"

#include <cmath>
#include <string>

#include "host/base/error.h"

namespace raycube::atmos::solver {
namespace {

bool within(double value, double low, double high) { return value >= low && value <= high; }

/// Collects the broken rules of one thing named `element`.
struct Rules {
  base::Problems& problems;
  std::string element;
  void need(bool holds, const char* rule, double found, const char* way_out) const {
    if (!holds) problems.add({"", 0, 0, element}, rule, std::to_string(found), way_out);
  }
};

void check_layer(const Layer& layer, const Rules& rules) {
  rules.need(within(layer.optical_depth, 0, 1e9), "optical depth must be in [0, 1e9]", layer.optical_depth,
             "check the extinction");
  // Sums of optical depths leave the last digits above 1; delta_m clamps them.
  rules.need(within(layer.scattering_albedo, 0, 1 + 1e-9), "single-scattering albedo must be in [0, 1]",
             layer.scattering_albedo, "divide the scattering by the extinction depth");
  for (std::size_t k = 0; k < layer.phase_moments.size(); ++k) {
    const double moment = layer.phase_moments[k];
    if (k == 0)
      rules.need(std::abs(moment - 1) <= 1e-6, "phase moment 0 must be 1", moment,
                 "normalise the phase function to 4 pi");
    else if (!within(moment, -1 - 1e-9, 1 + 1e-9))
      rules.need(false, "phase moments must be in [-1, 1]", moment, "leave the factor 2k+1 out of the moments");
  }
}

}  // namespace

void check_column(const Column& column, const Options& options) {
  base::Problems problems;
  const Rules whole{problems, "column"};
  for (std::size_t i = 0; i < column.layers.size(); ++i)
    check_layer(column.layers[i], {problems, "layer " + std::to_string(i)});
  whole.need(within(column.beam.flux, 0, 1e300), "beam flux must be finite and not negative", column.beam.flux,
             "check the source");
  whole.need(column.beam.cosine > 0 && column.beam.cosine <= 1, "beam cosine must be in (0, 1]", column.beam.cosine,
             "leave the beam out when the sun is down");
  whole.need(std::isfinite(column.beam.azimuth_deg), "beam azimuth must be finite", column.beam.azimuth_deg,
             "give degrees");
  whole.need(within(column.top_radiance, 0, 1e300), "radiance at the top must be finite and not negative",
             column.top_radiance, "check the boundary");
  const std::size_t levels = column.layers.size() + 1;
  whole.need(column.planck.empty() || column.planck.size() == levels,
             "Planck radiances are needed at each level or nowhere", static_cast<double>(column.planck.size()),
             "give one more than there are layers");
  for (double value : column.planck)
    whole.need(within(value, 0, 1e300), "Planck radiance must be finite and not negative", value,
               "check the temperatures");
  const std::vector<double>& height_m = column.level_height_m;
  whole.need(height_m.empty() || height_m.size() == levels, "heights are needed at each level or nowhere",
             static_cast<double>(height_m.size()), "give one more than there are layers");
  whole.need(within(column.planet_radius_m, 1, 1e12), "planet radius must be in [1, 1e12] m", column.planet_radius_m,
             "use 6371e3");
  for (std::size_t i = 0; i < height_m.size(); ++i) {
    whole.need(height_m[i] > -column.planet_radius_m && height_m[i] < 1e12,
               "heights must lie above the planet's centre", height_m[i], "give metres");
    if (i > 0)
      whole.need(height_m[i] < height_m[i - 1], "heights must fall from level to level", height_m[i],
                 "sort top to bottom");
  }
  whole.need(options.streams >= 2 && options.streams <= 256 && options.streams % 2 == 0,
             "streams must be even, 2 to 256", options.streams, "16 gives 1e-4 for clear air");
  whole.need(within(options.fourier_tolerance, 0, 1), "the tolerance of the azimuth series must be in [0, 1]",
             options.fourier_tolerance, "use 1e-8");
  problems.throw_if_any();
}

void check_ground(const Ground& ground) {
  base::Problems problems;
  const Rules rules{problems, "ground"};
  rules.need(within(ground.albedo, 0, 1), "albedo must be in [0, 1]", ground.albedo, "give a fraction, not percent");
  rules.need(within(ground.planck, 0, 1e300), "Planck radiance must be finite and not negative", ground.planck,
             "check the temperature");
  problems.throw_if_any();
}

}  // namespace raycube::atmos::solver
