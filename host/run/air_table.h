// The render table a simulation asks for: read from its file, built, or taken from the cache of tables built before.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/run/air_request.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Tables of the layered model are kept under $XDG_CACHE_HOME/raycube/atmosphere (else ~/.cache), named by
/// the SHA-256 of the request and of this program: another build never reads them. A cache that cannot be
/// read or written costs the build, no more. What a user should know of the air (the table's own notices)
/// goes to the log.
atmos::RenderTable air_table(const AirRequest& request, Services& services);

/// The table where it takes no computing, read from its file or that of no air; none for the models, whose request is
/// looked at as building it would. Throws Error(input) for what the table or the model refuses.
std::optional<atmos::RenderTable> known_table(const AirRequest& request);

/// The table where it takes a tenth of a second at most: known_table's, the clear sky's by its formulas, and of the
/// layered model one that is kept from a run before. None where the layered air has yet to be solved. Throws what
/// known_table does.
std::optional<atmos::RenderTable> quick_table(const AirRequest& request);

/// What a user should know of the air of a built table: its provenance's notices.
std::vector<std::string> air_notices(const atmos::RenderTable& table);

/// Those as warnings, each once in a run whatever the number of its tables; the aerosol with -v.
void say_air(const atmos::RenderTable& table, Services& services);

/// The aerosol of a built table in words, one line: "aerosol: optical depth 0.235 at 550 nm (rural,
/// visibility 23 km)\n", or "aerosol: none\n"; empty where the table says nothing of it.
std::string aerosol_text(const atmos::RenderTable& table);

/// What a user should know of bands below 2.5 um that are narrower than the steps of the sun's spectrum there: its
/// lines are smoothed in them. Nothing of a table of the user's.
std::optional<std::string> coarse_sun_notice(const scene::AtmosphereSpec& spec, const std::vector<scene::Band>& bands);

/// Wavelengths that the responses of some bands reach, um; a Gaussian is cut at 2.5 FWHM, where it has fallen to 3e-8.
std::pair<double, double> band_range(const std::vector<scene::Band>& bands);

}  // namespace raycube::run
