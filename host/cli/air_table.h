// The render table a simulation asks for: read from its file, built, or taken from the cache of tables built before.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/cli/verb.h"
#include "scene_compiler/simulation.h"

namespace raycube::cli {

struct AirRequest {
  const scene::AtmosphereSpec* spec = nullptr;
  scene::Sun sun;
  double sensor_height_m = 0;              ///< above the scene's z = 0
  double first_um = 0, last_um = 0, step_um = 0;  ///< step 0: the model's own grid
  double low_m = 0, high_m = 0;            ///< of the targets
  bool cached = true;
};

/// Tables of the layered model are kept under $XDG_CACHE_HOME/raycube/atmosphere (else ~/.cache), named by the SHA-256 of the
/// request and of this program: another build never reads them. A cache that cannot be read or written costs the build, no more.
atmos::RenderTable air_table(const AirRequest& request, Context& context);

/// The table where it takes no computing, read from its file or that of no air; none for the models, whose request is looked at as
/// building it would. Throws Error(input) for what the table or the model refuses.
std::optional<atmos::RenderTable> known_table(const AirRequest& request);

/// Wavelengths that the responses of some bands reach, um; a Gaussian is cut at 2.5 FWHM, where it has fallen to 3e-8.
std::pair<double, double> band_range(const std::vector<scene::Band>& bands);

}  // namespace raycube::cli
