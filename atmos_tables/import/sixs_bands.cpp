#include "atmos_tables/import/sixs_bands.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "atmos_tables/import/text_lines.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

bool is_one_band(const Imported& file, const Run& run) { return file.format == "6s" && run.wavelength_um.size() == 1; }

/// Runs that differ in wavelength alone.
std::tuple<double, double, double> view_of(const Run& run) {
  const Geometry& g = run.geometry;
  return {g.view_zenith_deg.value_or(0), g.relative_azimuth_deg.value_or(0), g.sensor_height_m.value_or(-1)};
}

Run joined(std::vector<const Run*> runs, const std::string& file, base::Problems& problems) {
  std::sort(runs.begin(), runs.end(),
            [](const Run* a, const Run* b) { return a->wavelength_um[0] < b->wavelength_um[0]; });
  Run out;
  out.mode = "joined", out.geometry = runs.front()->geometry;
  for (const Column& first : runs.front()->columns) {
    Column column = first;
    column.values.clear(), column.rounding.clear();
    for (const Run* run : runs)
      if (const Column* more = run->find(first.name)) {
        column.values.push_back(more->values[0]);
        column.rounding.push_back(more->rounding[0]);
      }
    if (column.values.size() == runs.size()) out.columns.push_back(std::move(column));
  }
  for (const Run* run : runs) {
    const double um = run->wavelength_um[0];
    if (!out.wavelength_um.empty() && !(um > out.wavelength_um.back()))
      problems.add({file, 0, 0, run->mode}, "two runs are of one wavelength and one view", shown(um) + " um",
                   "give one run per wavelength and view");
    out.wavelength_um.push_back(um);
    const auto apart = [&](const char* what, const std::optional<double>& here, const std::optional<double>& before) {
      if (here != before)
        problems.add({file, 0, 0, run->mode}, std::string(what) + " is not that of the runs before",
                     shown(here.value_or(-1)) + " after " + shown(before.value_or(-1)),
                     "make one table per ground, sun and sensor");
    };
    apart("the ground's height", run->geometry.ground_height_m, out.geometry.ground_height_m);
    apart("the sun's azimuth", run->geometry.sun_azimuth_deg, out.geometry.sun_azimuth_deg);
    if (run->geometry.sun_zenith_deg != out.geometry.sun_zenith_deg)
      problems.add({file, 0, 0, run->mode}, "the sun's zenith is not that of the runs before",
                   shown(run->geometry.sun_zenith_deg.value_or(-1)) + " after " +
                       shown(out.geometry.sun_zenith_deg.value_or(-1)),
                   "make one table per sun and sensor");
  }
  // Bands are channels: their middle and, of a filter that is one inside, its width.
  if (const Column* width = out.find("channel_width")) {
    Column center{"channel_center", "um", "wl inf, wl sup", {}, out.wavelength_um, {}}, fwhm = *width;
    center.rounding.assign(out.wavelength_um.size(), 0.0), fwhm.name = "channel_fwhm";
    out.columns.push_back(std::move(center)), out.columns.push_back(std::move(fwhm));
  }
  return out;
}

/// What a render needs of a joined run, and what of 6S prints it.
constexpr std::pair<const char*, const char*> kNeeded[] = {{"sun_ground_transmittance_gas", "global gas. trans."},
                                                           {"ground_sensor_transmittance_scattering", "total sca."},
                                                           {"spherical_albedo", "spherical albedo"},
                                                           {"optical_depth", "optical depth total"},
                                                           {"path_radiance_solar", "atm. intrin. rad."},
                                                           {"irradiance_down_direct", "direct solar irr."},
                                                           {"solar_irradiance", "int. sol. spect or sol. spect"}};

}  // namespace

std::vector<Imported> with_bands_joined(const std::vector<Imported>& files) {
  std::vector<Imported> out;
  std::map<std::tuple<double, double, double>, std::vector<const Run*>> by_view;
  base::Problems problems;
  const Imported* first = nullptr;
  for (const Imported& file : files) {
    Imported rest{file.file, file.code, file.format, {}};
    for (const Run& run : file.runs) {
      if (!is_one_band(file, run)) {
        rest.runs.push_back(run);
        continue;
      }
      if (!first) first = &file;
      by_view[view_of(run)].push_back(&run);
    }
    if (!rest.runs.empty() || file.runs.empty()) out.push_back(std::move(rest));
  }
  if (!first) return out;
  Imported together{first->file, first->code, first->format, {}};
  for (const auto& [view, runs] : by_view) together.runs.push_back(joined(runs, first->file, problems));
  problems.throw_if_any();
  out.push_back(std::move(together));
  return out;
}

void add_joined_bands(const Source& source, SampleBook& book) {
  const Run& run = *source.run;
  book.sun_and_sensor(source);
  bool whole = run.geometry.sun_zenith_deg && run.geometry.view_zenith_deg;
  if (!whole)
    book.problems.add({source.file->file, 0, 0, ""}, "the runs name no angles of sun and view", "",
                      "give the whole text output of 6S");
  for (const auto& [name, printed] : kNeeded)
    if (!run.find(name)) {
      whole = false;
      book.problems.add({source.file->file, 0, 0, ""}, std::string("not every run has ") + name, printed,
                        "give the whole text output of 6S; 6SV prints it of every band and wavelength");
    }
  if (!whole) return;
  const double mu0 = std::cos(base::rad_from_deg(*run.geometry.sun_zenith_deg)),
               mu = std::cos(base::rad_from_deg(*run.geometry.view_zenith_deg));
  const auto of = [&](const char* name) { return book.on_grid(run, run.at(name)); };
  const Spectrum e0 = of("solar_irradiance"), direct = of("irradiance_down_direct"),
                 gas_up = of("ground_sensor_transmittance_gas"), gas_down = of("sun_ground_transmittance_gas"),
                 gas = of("sun_ground_sensor_transmittance_gas"), up = of("ground_sensor_transmittance_scattering"),
                 depth = of(run.find("optical_depth_below_plane") && run.geometry.sensor_height_m
                                ? "optical_depth_below_plane"
                                : "optical_depth");
  Sample at_height;
  at_height.height_m = book.ground(run.geometry.ground_height_m);
  Sample no_azimuth = at_height;
  no_azimuth.zenith_deg = run.geometry.view_zenith_deg;
  Sample place = no_azimuth;
  if (*place.zenith_deg > 0.01) place.azimuth_deg = run.geometry.relative_azimuth_deg;
  Spectrum view, diffuse_view, sun, joined_path;
  for (std::size_t i = 0; i < e0.size(); ++i) {
    view.push_back(gas_up[i] * std::exp(-depth[i] / mu));
    diffuse_view.push_back(std::max(0.0, gas_up[i] * up[i] - view[i]));
    sun.push_back(e0[i] > 0 ? std::min(1.0, direct[i] / (e0[i] * mu0)) : 0);
    const double separate = gas_down[i] * gas_up[i];
    joined_path.push_back(separate > 0 ? sun[i] * view[i] * gas[i] / separate : 0);
  }
  book.add("solar_irradiance", {}, e0);
  book.add("view_transmission", no_azimuth, std::move(view));
  book.add("diffuse_view_transmission", no_azimuth, std::move(diffuse_view));
  book.add("sun_transmission", at_height, std::move(sun));
  book.add(kTwoWay, no_azimuth, std::move(joined_path));
  book.add("path_radiance_solar", place, of("path_radiance_solar"));
  book.add("diffuse_irradiance", at_height, of("irradiance_down_diffuse"));
  book.add("spherical_albedo", at_height, of("spherical_albedo"));
  if (!run.geometry.sensor_height_m)
    book.out.notices.push_back(source.file->file +
                               ": 6S computed for a satellite, above all air; --sensor-height says where it is");
}

void add_wavelength_table(const Source& source, SampleBook& book) {
  const std::string lacks =
      "a table by wavelength (iwave -2) has direct and diffuse light in one number, so a render lacks "
      "view_transmission, sun_transmission and diffuse_irradiance (optical depths and irradiances by wavelength), "
      "path_radiance_solar (radiance by wavelength) and sky_radiance_solar";
  const std::string way_out =
      "run 6SV once per wavelength (iwave -1) or band (iwave 0) and give all the outputs, with --even-sky";
  if (!book.request.partial) {
    book.problems.add({source.file->file, 0, 0, ""}, lacks, "", way_out);
    return;
  }
  book.sun_and_sensor(source);
  book.add("solar_irradiance", {}, book.optional(*source.run, "solar_irradiance"));
  book.add("spherical_albedo", {}, book.optional(*source.run, "spherical_albedo"));
  book.out.notices.push_back(source.file->file + ": " + lacks + "; " + way_out);
}

}  // namespace raycube::atmos::imported
