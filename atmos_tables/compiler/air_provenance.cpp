#include "atmos_tables/compiler/air_provenance.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "atmos_tables/compiler/air_stack.h"

namespace raycube::atmos {

namespace {

/// Every field that says something.
nlohmann::json stated(const scene::OwnAerosolSpec& aerosol) {
  nlohmann::json out;
#define RC_OWN_AEROSOL(type, name, fallback, text) out[#name] = aerosol.name;
#include "scene_compiler/air_spec.def"
  for (auto field = out.begin(); field != out.end();)
    field = field->is_array() && field->empty() ? out.erase(field) : ++field;
  if (!aerosol.extinction.empty() || !aerosol.refractive_n.empty()) out.erase("angstrom");
  if (!aerosol.height_km.empty()) out.erase("scale_height_km");
  return out;
}

}  // namespace

nlohmann::json air_parameters(const scene::AtmosphereSpec& spec, const AerosolColumn& aerosols) {
  const scene::AirSpec& air = *spec.layered;
  const bool none = air.aerosol == "none";
  nlohmann::json out = {
      {"ground_height_m", spec.ground_height_m},
      {"profile", air.profile},
      {"profile_file", air.profile_file.empty() ? nlohmann::json() : nlohmann::json(air.profile_file)},
      {"aerosol", air.aerosol},
      {"visibility_km", none ? nlohmann::json() : nlohmann::json(aerosols.visibility_km())},
      {"aod_550", aerosols.aod_550()},
      {"aod_550_from", none && air.own_aerosols.empty() ? "no aerosol"
                       : none                           ? "own aerosols"
                       : air.aod_550 >= 0               ? "stated"
                                                        : "visibility"}};
  for (const scene::OwnAerosolSpec& aerosol : air.own_aerosols) out["own_aerosols"].push_back(stated(aerosol));
  return out;
}

std::string aerosol_source(const scene::AirSpec& air) {
  std::string out;
  for (const scene::OwnAerosolSpec& aerosol : air.own_aerosols)
    out += (out.empty() ? "" : "; ") + aerosol.name + ": the user's" +
           (aerosol.refractive_n.empty() ? "" : ", Mie's series (Bohren & Huffman 1983)");
  const bool shipped = air.aerosol != "none" || !air.clouds.empty() || out.empty();
  return "aerosols: " + std::string(shipped ? "LOWTRAN7 (Shettle & Fenn 1979), Mie phase functions" : "") +
         (shipped && !out.empty() ? "; " : "") + out;
}

GasesLeftOut gases_left_out(const scene::AirSpec& spec, double ground_km, const std::vector<double>& wavelength_um) {
  const AirStack stack(spec, ground_km, {});
  const std::vector<double> up(stack.layers(), 1.0);
  double most = -1, at_um = 0;
  for (const double um : wavelength_um) {
    const double per_cm = 1e4 / um;
    double depth = stack.gases().line_depth(per_cm, up);
    for (std::size_t layer = 0; layer < stack.layers(); ++layer) depth += stack.gases().grey_depth(per_cm, layer);
    if (const double share = -std::expm1(-depth); share > most) most = share, at_um = um;
  }
  char text[300];
  std::snprintf(text, sizeof text,
                "no lines or cross-sections given: absorption by gases is absent, which band models cannot "
                "give at a laser's line; near %.6g nm they have %.*f %% of the light taken on the way straight "
                "up through this air",
                1000 * at_um, most < 0.1, 100 * most);
  return {text, most};
}

}  // namespace raycube::atmos
