#include "host/plan/spectral_plan.h"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/units.h"
#include "host/plan/curve.h"
#include "host/plan/quadrature.h"
#include "host/plan/sources.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

constexpr double kLeastFwhm = 1e-6;  ///< FWHM of a band over its centre: grids of wavelengths merge 1e-9 um

/// Adds one problem for all bands whose support leaves lo..hi (um).
void check_range(base::Problems& problems, const base::Where& where, const std::vector<scene::Band>& bands, double lo,
                 double hi, const std::string& what, const std::string& way_out) {
  int count = 0;
  bool late = false, early = false;
  std::string found;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const auto [from, to] = band_support(bands[b]);
    if (from >= lo - 1e-9 && to <= hi + 1e-9) continue;
    late = late || from < lo - 1e-9;
    early = early || to > hi + 1e-9;
    if (++count > 3) continue;
    found += fmt::format("{}band {}{} {:.6g} to {:.6g} nm", found.empty() ? "" : ", ", b + 1,
                         bands[b].name.empty() ? "" : " '" + bands[b].name + "'", 1000 * from, 1000 * to);
  }
  if (count > 3) found += fmt::format(" and {} more", count - 3);
  if (count > 0)
    problems.add(where,
                 fmt::format("{} covers {:.6g} to {:.6g} nm, a band needs more: it {}", what, 1000 * lo, 1000 * hi,
                             late && early ? "begins too late and ends too early"
                             : late        ? "begins too late"
                                           : "ends too early"),
                 found, way_out);
}

std::string gaussian_reach() {
  return fmt::format("a Gaussian response reaches {:g} FWHM to each side", kGaussianCutFwhm);
}

}  // namespace

base::Where place_of(const scene::Instrument& instrument) { return {"", 0, 0, "instrument '" + instrument.name + "'"}; }

void check_bands(const scene::Instrument& instrument, base::Problems& problems) {
  const base::Where where = place_of(instrument);
  if (instrument.bands.empty()) problems.add(where, "has no bands", "", "give a band list or a response file");
  for (std::size_t b = 0; b < instrument.bands.size(); ++b) {
    const auto& band = instrument.bands[b];
    if (band.wavelength_um.size() < 2 && !(band.fwhm_um > 0 && band.center_um > 0))
      problems.add(where, fmt::format("band {} needs a centre and a FWHM above 0", b + 1),
                   fmt::format("centre {:g} nm, FWHM {:g} nm", 1000 * band.center_um, 1000 * band.fwhm_um),
                   "or give a tabulated response");
    else if (band.wavelength_um.size() < 2 && band.fwhm_um < kLeastFwhm * band.center_um)
      problems.add(where, fmt::format("band {} is narrower than any spectrum is known", b + 1),
                   fmt::format("centre {:g} nm, FWHM {:g} nm", 1000 * band.center_um, 1000 * band.fwhm_um),
                   "give a FWHM of at least a millionth of the centre");
  }
}

void check_table(const scene::Instrument& instrument, const std::vector<double>& table_um,
                 const std::string& table_name, base::Problems& problems) {
  check_range(problems, place_of(instrument), instrument.bands, table_um.front(), table_um.back(),
              "atmosphere table " + table_name, "take these bands out or use a wider table (" + gaussian_reach() + ")");
}

std::string table_name(const scene::Simulation& simulation) {
  const std::string& file = simulation.atmosphere.table_file;
  return file.empty() ? "of the built-in model" : "'" + file + "'";
}

void check_view(const scene::Instrument& instrument, const ViewBounds& view, double last_zenith_rad) {
  const double zenith_rad = zenith_of_sec(view.sec_max);
  if (zenith_rad <= last_zenith_rad + 1e-9) return;
  throw base::Error(base::Fault::input,
                    fmt::format("instrument '{}' looks {:.2f} deg off nadir, the atmosphere table ends at {:.2f} deg; "
                                "build a table with larger view zeniths or narrow the view",
                                instrument.name, base::deg_from_rad(zenith_rad), base::deg_from_rad(last_zenith_rad)));
}

namespace {

std::uint32_t role_of(const scene::CompiledScene& scene, std::uint32_t curve) {
  return rc_curve_role(curve, scene::material_count(scene));
}

std::string what_of(const scene::CompiledScene& scene, std::uint32_t curve) {
  const std::uint32_t role = role_of(scene, curve);
  return role == RC_CURVE_REFLECTANCE ? "the curve" : role == RC_CURVE_GLOSS ? "the index" : "the transmittance";
}

/// Of real cameras: what a LIDAR's background is looked at with takes narrow gloss for as wide as that.
void check_width(const scene::CompiledScene& scene, const base::Where& where, base::Problems& problems) {
  for (const auto index : scene::used_families(scene)) {
    const scene::Material& material = scene.materials[index];
    for (const auto& part : scene::gloss_parts(material)) {
      const double roughness = rc_shape_roughness(part.shape.number, part.shape.parameters());
      if (roughness >= scene::kLeastRoughness) continue;
      problems.add(where, "gloss of material '" + material.name + "' is narrower than cameras can see",
                   fmt::format("as narrow as GGX of roughness {:g}", roughness),
                   fmt::format("make it as wide as one of {:g}, or remove it", scene::kLeastRoughness));
      break;
    }
  }
}

void check_mixed_gloss(const scene::CompiledScene& scene, const base::Where& where, base::Problems& problems) {
  if (const auto [first, other] = scene::gloss_clash(scene); other)
    problems.add(where, "materials of different gloss mixed in a cell",
                 "'" + first->name + "' and '" + other->name + "'",
                 "give them one gloss, or set mixture = \"stochastic\"");
}

/// Paths go straight on through a whole surface, or not.
void check_mixed_plates(const scene::CompiledScene& scene, const base::Where& where, base::Problems& problems) {
  const auto used = scene::used_materials(scene);
  for (const shared::Surface& surface : scene.surfaces) {
    const scene::Material *plate = nullptr, *other = nullptr;
    bool seen = true;
    scene::for_each_material(surface, [&](std::size_t material, float fraction) {
      const scene::Material& here = scene.materials[material];
      if (fraction > 0) (scene::is_plate(here) ? plate : other) = &here;
      seen = seen && std::binary_search(used.begin(), used.end(), static_cast<std::uint32_t>(material));
    });
    if (!plate || !other || !seen) continue;
    problems.add(where, "a plate mixed in a cell with other matter", "'" + plate->name + "' and '" + other->name + "'",
                 "set mixture = \"stochastic\"");
    return;
  }
}

}  // namespace

void check_curves(const scene::CompiledScene& scene, const scene::Instrument& instrument, base::Problems& problems,
                  const std::map<std::string, std::string>& curve_file) {
  const base::Where where = place_of(instrument);
  const auto source = [&](const scene::Material& material) {
    const auto file = curve_file.find(material.name);
    const std::string& name = file != curve_file.end() ? file->second : material.source;
    return name.empty() ? std::string("this") : "'" + name + "'";
  };
  if (instrument.auto_bounces) check_width(scene, where, problems);
  check_mixed_gloss(scene, where, problems);
  check_mixed_plates(scene, where, problems);
  std::set<std::pair<std::uint32_t, std::uint32_t>>
      told;  // family and role: its members have the wavelengths of one file
  for (const auto curve : scene::seen_curves(scene)) {
    const std::uint32_t index = scene::material_of_curve(scene, curve), role = role_of(scene, curve);
    const auto& material = scene.materials[index];
    const bool made = role == RC_CURVE_GLOSS ? material.index_n.value.empty() : role >= RC_CURVE_FURTHER;
    if (!scene::carries_light(scene, curve) || made) continue;
    if (!told.emplace(index - material.in_family, role).second) continue;
    const auto& x = scene::curve_of(scene, curve).wavelength_um;
    if (x.empty()) problems.add(where, "material '" + material.name + "' has no reflectance curve", "", "give one");
    if (x.size() > 1)
      check_range(problems, where, instrument.bands, x.front(), x.back(),
                  what_of(scene, curve) + " of material '" + material.name + "'",
                  "take these bands out or give a wider curve than " +
                      (role == RC_CURVE_GLOSS ? "the file of n and k" : source(material)) + " (" + gaussian_reach() +
                      ")");
  }
}

SpectralPlan make_spectral_plan(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                const std::vector<double>& table_um, const std::string& table_name,
                                const std::vector<double>& lamp_um) {
  const auto used = scene::used_materials(scene);
  base::Problems problems;
  check_bands(instrument, problems);
  problems.throw_if_any();
  check_table(instrument, table_um, table_name, problems);
  check_curves(scene, instrument, problems);
  problems.throw_if_any();

  std::vector<double> breakpoints = table_um;
  // Bands end inside the table, so that its ends are nodes enough there; beyond them nobody could read it.
  const auto add = [&](const std::vector<double>& nodes) {
    std::copy_if(nodes.begin(), nodes.end(), std::back_inserter(breakpoints),
                 [&](double node) { return node > table_um.front() && node < table_um.back(); });
  };
  for (const auto curve : scene::seen_curves(scene)) {
    const auto& x = scene::curve_of(scene, curve).wavelength_um;
    if (x.size() >= 2 && scene::carries_light(scene, curve)) add(x);
  }
  add(lamp_um);
  SpectralPlan out;
  SpectralGrid grid = make_spectral_grid(std::move(breakpoints), instrument.bands);
  for (const auto& band : instrument.bands) out.bands.push_back(band_quadrature(band, grid));
  out.wavelength_um = std::move(grid.wavelength_um);
  out.mean_reflectance.assign(out.wavelength_um.size(), used.empty() ? 0.2 : 0.0);
  out.largest_reflectance = out.mean_reflectance;
  for (const auto material : used) {
    const auto r = sample_reflectance(scene.materials[material], out.wavelength_um);
    for (std::size_t i = 0; i < r.size(); ++i) {
      out.mean_reflectance[i] += r[i] / static_cast<double>(used.size());
      out.largest_reflectance[i] = std::max(out.largest_reflectance[i], r[i]);
    }
  }
  return out;
}

}  // namespace raycube::plan
