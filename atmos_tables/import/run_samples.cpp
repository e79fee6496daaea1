#include "atmos_tables/import/run_samples.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <tuple>

#include "atmos_tables/import/albedo_runs.h"
#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/row_registry.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

enum class Role { down, sky, sun, levels, solver, channels, correction, columns, unused };

struct Source {
  const Imported* file;
  const Run* run;
  Role role;
};

Role role_of(const Imported& file, const Run& run) {
  if (file.format == "chn") return Role::channels;
  if (file.format == "plain-csv") return Role::columns;
  if (file.format == "uvspec") return run.mode.rfind("fluxes", 0) == 0 ? Role::solver : Role::unused;
  if (run.mode == "atmospheric correction data") return Role::correction;
  if (run.mode == "direct irradiance") return Role::sun;
  if (run.find("irradiance_down_diffuse")) return Role::levels;
  if (!run.find("transmittance") || !run.geometry.sight_zenith_deg) return Role::unused;
  if (*run.geometry.sight_zenith_deg > 90) return Role::down;
  return run.find("radiance") ? Role::sky : Role::unused;
}

class Reader {
 public:
  Reader(const std::vector<Imported>& files, const TableRequest& request) : request_(request) {
    for (const Imported& file : files)
      for (const Run& run : file.runs) {
        const Role role = role_of(file, run);
        if (role == Role::unused)
          out_.notices.push_back(
              file.file + ": " + run.mode +
              ": not used; a table takes paths down, skies, sun paths, fluxes, channels and columns");
        else
          sources_.push_back({&file, &run, role});
      }
    if (sources_.empty())
      throw base::Error(base::Fault::input, "none of the files holds a run that a render table can be made of");
    choose_grid();
  }

  Samples read() {
    std::map<std::tuple<double, double, double>, std::vector<Seen>> paths;
    std::size_t albedo_at = 0;
    for (const Source& source : sources_) {
      switch (source.role) {
        case Role::down:
          down(source, albedo_at, paths);
          break;
        case Role::sky:
          sky(source);
          break;
        case Role::sun:
          sun(source);
          break;
        case Role::levels:
          levels(source);
          break;
        case Role::solver:
          solver(source);
          break;
        case Role::channels:
          channels(source, albedo_at);
          break;
        case Role::correction:
          correction(source);
          break;
        case Role::columns:
          columns(source);
          break;
        case Role::unused:
          break;
      }
    }
    if (!request_.albedo.empty() && request_.albedo.size() != albedo_at)
      problems_.add({}, "one albedo is needed per run that looks down",
                    std::to_string(request_.albedo.size()) + " for " + std::to_string(albedo_at) + " runs",
                    "give as many --albedo as runs");
    for (auto& [place, runs] : paths) over_ground(runs);
    problems_.throw_if_any();
    return std::move(out_);
  }

 private:
  /// A run that looks down, and the ground it looks at.
  struct Seen {
    const Source* source;
    double albedo;
    Sample place;
  };

  void choose_grid() {
    const Source* lead = &sources_.front();
    double first = 0, last = 1e9;
    for (const Source& source : sources_) {
      const auto [low, high] = std::minmax_element(source.run->wavelength_um.begin(), source.run->wavelength_um.end());
      first = std::max(first, *low), last = std::min(last, *high);
      const bool leads = source.role == Role::down || source.role == Role::channels || source.role == Role::solver;
      const bool lead_leads = lead->role == Role::down || lead->role == Role::channels || lead->role == Role::solver;
      if (leads && !lead_leads) lead = &source;
    }
    out_.wavelength_um = sorted(*lead->run, lead->run->wavelength_um);
    auto& grid = out_.wavelength_um;
    // Wavenumbers printed to two decimals are one wavelength to 1e-6 of it.
    const auto outside = [&](double l) { return l < first * (1 - 1e-6) || l > last * (1 + 1e-6); };
    const std::size_t all = grid.size();
    grid.erase(std::remove_if(grid.begin(), grid.end(), outside), grid.end());
    if (grid.empty())
      throw base::Error(base::Fault::input, "the runs have no wavelength in common; give runs of one range");
    if (grid.size() < all)
      out_.notices.push_back(std::to_string(all - grid.size()) + " wavelengths of " + lead->file->file +
                             " left out: other runs do not cover them");
  }

  /// Values in ascending order of wavelength: channels stand as in their filter file.
  Spectrum sorted(const Run& run, const Spectrum& values) {
    std::vector<std::size_t> order(run.wavelength_um.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return run.wavelength_um[a] < run.wavelength_um[b]; });
    Spectrum out;
    for (const std::size_t i : order) out.push_back(values[i]);
    return out;
  }

  Spectrum on_grid(const Run& run, const Spectrum& values) {
    const Spectrum from = sorted(run, run.wavelength_um), y = sorted(run, values);
    if (from.size() == 1) return Spectrum(out_.wavelength_um.size(), y[0]);
    Spectrum to = out_.wavelength_um;
    for (double& l : to) l = std::clamp(l, from.front(), from.back());
    return resample_linear(from, y, to);
  }
  Spectrum on_grid(const Run& run, const Column& column) { return on_grid(run, column.values); }
  /// Empty where the run has no such column.
  Spectrum optional(const Run& run, const std::string& name) {
    const Column* column = run.find(name);
    return column ? on_grid(run, *column) : Spectrum{};
  }

  void add(const std::string& row, const Sample& place, Spectrum values) {
    if (values.empty()) return;
    Sample sample = place;
    sample.row = row, sample.values = std::move(values);
    out_.all.push_back(std::move(sample));
  }

  void agree(std::optional<double>& standing, std::optional<double> found, double tolerance, const char* what,
             const Source& source) {
    if (!found) return;
    if (standing && std::abs(*standing - *found) > tolerance)
      problems_.add({source.file->file, 0, 0, source.run->mode}, std::string(what) + " is not that of the runs before",
                    shown(*found) + " after " + shown(*standing), "make one table per sun and sensor");
    if (!standing) standing = found;
  }

  double ground(std::optional<double> height) const {
    return height.value_or(request_.ground_height_m) - request_.ground_height_m;
  }

  double albedo_of(const Source& source, std::size_t& at) {
    if (at++ < request_.albedo.size()) return request_.albedo[at - 1];
    const Column* emissivity = source.run->find("surface_emissivity");
    if (!emissivity) return 0;
    // Printed to 1e-4; ratios of single-precision sums are off by 1e-5.
    const double mean = std::accumulate(emissivity->values.begin(), emissivity->values.end(), 0.0) /
                        static_cast<double>(emissivity->values.size());
    return 1 - mean < 5e-5 ? 0 : 1 - mean;
  }

  void down(const Source& source, std::size_t& albedo_at,
            std::map<std::tuple<double, double, double>, std::vector<Seen>>& paths) {
    const Geometry& g = source.run->geometry;
    if (g.sensor_height_m)
      agree(out_.sensor_height_m, *g.sensor_height_m - request_.ground_height_m, 0.5, "the sensor's height", source);
    agree(out_.sun_zenith_deg, g.sun_zenith_deg, 0.05, "the sun's zenith", source);
    Sample place;
    place.height_m = ground(g.path_end_height_m);
    place.zenith_deg = g.view_zenith_deg.value_or(180 - *g.sight_zenith_deg);
    if (*place.zenith_deg > 0.01) place.azimuth_deg = g.relative_azimuth_deg;
    paths[{*place.height_m, *place.zenith_deg, place.azimuth_deg.value_or(0)}].push_back(
        {&source, albedo_of(source, albedo_at), place});
  }

  /// All runs of one line of sight: black ground first, then what the others say of ground and air.
  void over_ground(std::vector<Seen>& runs) {
    std::stable_sort(runs.begin(), runs.end(), [](const Seen& a, const Seen& b) { return a.albedo < b.albedo; });
    const Run& first = *runs.front().source->run;
    const Sample& place = runs.front().place;
    Sample no_azimuth = place, at_height = place;
    no_azimuth.azimuth_deg.reset(), at_height.azimuth_deg.reset(), at_height.zenith_deg.reset();
    const Spectrum t = optional(first, "transmittance");
    add("view_transmission", no_azimuth, t);
    add("solar_irradiance", {}, optional(first, "solar_irradiance"));
    Spectrum two_way = optional(first, "solar_irradiance_sun_ground_sensor");
    const Spectrum above = optional(first, "solar_irradiance");
    if (!two_way.empty() && !above.empty()) {
      for (std::size_t i = 0; i < two_way.size(); ++i) two_way[i] = above[i] > 0 ? two_way[i] / above[i] : 0;
      add(kTwoWay, no_azimuth, std::move(two_way));
    }
    add("path_radiance_solar", place, optional(first, "path_radiance_solar"));
    add("path_radiance_thermal", no_azimuth, optional(first, "path_radiance_thermal"));
    const std::string name = runs.front().source->file->file;
    if (runs.front().albedo > 0)
      out_.notices.push_back(name + ": the path's sunlight was computed over ground of albedo " +
                             shown(runs.front().albedo) + ", not over black ground");
    std::vector<const Seen*> bright;
    for (const Seen& seen : runs)
      if (seen.albedo > 0 && (bright.empty() || seen.albedo > bright.back()->albedo + 1e-6)) bright.push_back(&seen);
    const auto seen_light = [&](const Seen& seen) {  // sunlight alone: what the ground emits is not the air's
      Spectrum light = optional(*seen.source->run, "path_radiance_solar");
      const Spectrum reflected = optional(*seen.source->run, "ground_reflected");
      for (std::size_t i = 0; i < light.size() && i < reflected.size(); ++i) light[i] += reflected[i];
      return light;
    };
    if (runs.front().albedo == 0 && bright.size() >= 2) {
      const Seen &low = *bright.front(), &high = *bright.back();
      const Spectrum l0 = seen_light(runs.front()), l1 = seen_light(low), l2 = seen_light(high),
                     reflected = optional(*high.source->run, "ground_reflected");
      if (l0.empty() || reflected.empty()) return;
      Spectrum s, t_dif, total;
      for (std::size_t i = 0; i < l0.size(); ++i) {
        const GroundCoupling c = coupling_of_three_runs(l0[i], l1[i], l2[i], low.albedo, high.albedo);
        const double a = reflected[i] * (1 / high.albedo - c.spherical_albedo);  // T_dir E_g0 / pi
        s.push_back(c.spherical_albedo);
        t_dif.push_back(a > 0 ? std::clamp(t[i] * (c.coefficient - a) / a, 0.0, 1.0) : 0);
        total.push_back(t[i] > 0 ? base::kPi * a / t[i] : 0);
      }
      add("spherical_albedo", at_height, std::move(s));
      add("diffuse_view_transmission", no_azimuth, std::move(t_dif));
      add(kTotalIrradiance, at_height, std::move(total));
    } else if (!bright.empty()) {
      const Seen& seen = *bright.front();
      const Spectrum reflected = optional(*seen.source->run, "ground_reflected");
      Spectrum total;
      for (std::size_t i = 0; i < reflected.size(); ++i)
        total.push_back(t[i] > 0 ? base::kPi * reflected[i] / (seen.albedo * t[i]) : 0);
      add(kTotalIrradiance, at_height, std::move(total));
      out_.notices.push_back(name + ": diffuse irradiance is that over ground of albedo " + shown(seen.albedo) +
                             "; three runs of albedo 0, r1 and r2 would separate ground and air");
    }
  }

  void sky(const Source& source) {
    const Geometry& g = source.run->geometry;
    agree(out_.sun_zenith_deg, g.sun_zenith_deg, 0.05, "the sun's zenith", source);
    Sample place;
    place.height_m = ground(g.sensor_height_m);
    place.zenith_deg = *g.sight_zenith_deg;
    Sample no_azimuth = place;
    if (*place.zenith_deg > 0.01) place.azimuth_deg = g.relative_azimuth_deg;
    add("sky_radiance_solar", place, optional(*source.run, "path_radiance_solar"));
    add("sky_radiance_thermal", no_azimuth, optional(*source.run, "path_radiance_thermal"));
    add("solar_irradiance", {}, optional(*source.run, "solar_irradiance"));
  }

  void sun(const Source& source) {
    const Geometry& g = source.run->geometry;
    agree(out_.sun_zenith_deg, g.sight_zenith_deg, 0.05, "the sun's zenith", source);  // the sight is towards the sun
    Sample place;
    place.height_m = ground(g.sensor_height_m);
    add("sun_transmission", place, optional(*source.run, "transmittance"));
    add("solar_irradiance", {}, optional(*source.run, "solar_irradiance"));
  }

  void levels(const Source& source) {
    for (const Column& column : source.run->columns) {
      const bool direct = column.name == "irradiance_down_direct";
      if ((!direct && column.name != "irradiance_down_diffuse") || !column.place.height_m) continue;
      Sample place;
      place.height_m = ground(column.place.height_m);
      if (out_.sensor_height_m && *place.height_m > *out_.sensor_height_m + 0.5) continue;
      add(direct ? "direct_irradiance" : "diffuse_irradiance", place, on_grid(*source.run, column));
    }
  }

  void channels(const Source& source, std::size_t& albedo_at) {
    const Run& run = *source.run;
    const double r = albedo_of(source, albedo_at);
    const Spectrum t = on_grid(run, run.at("transmittance")), a = on_grid(run, run.at("coefficient_a")),
                   b = on_grid(run, run.at("coefficient_b")), s = on_grid(run, run.at("spherical_albedo")),
                   above = on_grid(run, run.at(kIrradianceCosOverPi));
    Spectrum path = on_grid(run, run.at("path_radiance_solar")), t_dif, total;
    for (std::size_t i = 0; i < t.size(); ++i) {
      path[i] = std::max(0.0, path[i] - r * b[i] * above[i] / (1 - r * s[i]));
      t_dif.push_back(a[i] > 0 ? std::clamp(t[i] * b[i] / a[i], 0.0, 1.0) : 0);
      total.push_back(t[i] > 0 ? base::kPi * a[i] * above[i] / t[i] : 0);
    }
    add("view_transmission", {}, t);
    add("path_radiance_solar", {}, std::move(path));
    add("path_radiance_thermal", {}, optional(run, "path_radiance_thermal"));
    add("spherical_albedo", {}, s);
    add("diffuse_view_transmission", {}, std::move(t_dif));
    add(kTotalIrradiance, {}, std::move(total));
    Spectrum two_way = on_grid(run, run.at("solar_irradiance_sun_ground_sensor"));
    add(kIrradianceCosOverPi, {}, above);
    add("solar_irradiance_sun_ground_sensor", {}, std::move(two_way));
  }

  void correction(const Source& source) {
    const auto sum_over_k = [&](const char* name) -> Spectrum {
      for (const Column& column : source.run->columns)
        if (column.name == name && !column.place.k) return on_grid(*source.run, column);
      return {};
    };
    add("view_transmission", {}, sum_over_k("ground_sensor_transmittance_direct"));
    add(kTwoWay, {}, sum_over_k("sun_ground_sensor_transmittance_direct"));
    add("diffuse_view_transmission", {}, sum_over_k("ground_sensor_transmittance_diffuse"));
    add("spherical_albedo", {}, sum_over_k("spherical_albedo"));
    add(kSunGroundDiffuse, {}, sum_over_k(kSunGroundDiffuse));
    if (source.run->find("k_weight") && source.run->find("k_weight")->place.k)
      out_.notices.push_back(source.file->file +
                             ": k-terms summed with their weights; the direct light from sun to sensor is summed as "
                             "the product of each term");
  }

  /// uvspec: levels by zout. Transmissions from the direct beam at two levels, which is Beer's law along another slant.
  void solver(const Source& source) {
    const Run& run = *source.run;
    const auto same = [](const Place& a, const Place& b) {
      return a.top_of_air == b.top_of_air && a.height_m == b.height_m;
    };
    std::vector<Place> places;
    for (const Column& column : run.columns)
      if (column.name == "irradiance_down_direct") places.push_back(column.place);
    std::sort(places.begin(), places.end(),
              [](const Place& a, const Place& b) { return a.height_m.value_or(1e9) < b.height_m.value_or(1e9); });
    agree(out_.sun_zenith_deg, run.geometry.sun_zenith_deg, 0.05, "the sun's zenith", source);
    if (places.empty() || !run.geometry.sun_zenith_deg) {
      problems_.add({source.file->file, 0, 0, ""}, "a uvspec run needs sza and the column edir to become a table", "",
                    "ask for output_user lambda edir edn uu");
      return;
    }
    const double mu0 = std::cos(base::rad_from_deg(*run.geometry.sun_zenith_deg));
    const auto column_at = [&](const std::string& name, const Place& level, double zenith, double azimuth) -> Spectrum {
      for (const Column& c : run.columns)
        if (c.name == name && same(c.place, level) && std::abs(c.place.zenith_deg.value_or(zenith) - zenith) < 1e-6 &&
            std::abs(c.place.relative_azimuth_deg.value_or(azimuth) - azimuth) < 1e-6)
          return on_grid(run, c);
      return {};
    };
    const Place& top = places.back();
    const Spectrum beam_top = column_at("irradiance_down_direct", top, 0, 0);
    if (top.top_of_air) {
      Spectrum e0 = beam_top;
      for (double& e : e0) e /= mu0;
      add("solar_irradiance", {}, std::move(e0));
    }
    // The sensor's level: the one asked for, else the highest with a height, else the top of the air.
    const Place* sensor = nullptr;
    for (const Place& level : places)
      if (level.height_m && (!request_.sensor_height_m ||
                             std::abs(*level.height_m - request_.ground_height_m - *request_.sensor_height_m) < 0.5))
        sensor = &level;
    if ((!sensor || sensor == &places.front()) && top.top_of_air) sensor = &top;
    if (!sensor || sensor == &places.front()) {
      problems_.add({source.file->file, 0, 0, ""}, "no level of zout is the sensor's",
                    request_.sensor_height_m ? shown(*request_.sensor_height_m) + " m" : "",
                    "run uvspec with zout at ground, sensor and TOA");
      return;
    }
    if (sensor->height_m)
      agree(out_.sensor_height_m, *sensor->height_m - request_.ground_height_m, 0.5, "the sensor's height", source);
    const Spectrum beam_sensor = column_at("irradiance_down_direct", *sensor, 0, 0);
    std::set<std::pair<double, double>> up;
    for (const Column& c : run.columns)
      if (c.name == "radiance_upward" && same(c.place, *sensor))
        up.insert({*c.place.zenith_deg, c.place.relative_azimuth_deg.value_or(0)});
    for (const Place& level : places) {
      if (&level == sensor) break;
      const Spectrum beam = column_at("irradiance_down_direct", level, 0, 0);
      Sample at_height;
      at_height.height_m = ground(level.height_m);
      add("direct_irradiance", at_height, beam);
      add("diffuse_irradiance", at_height, column_at("irradiance_down_diffuse", level, 0, 0));
      const auto ratio = [&](const Spectrum& over, double power) {
        Spectrum out;
        for (std::size_t i = 0; i < beam.size(); ++i)
          out.push_back(over[i] > 0 ? std::pow(std::min(1.0, beam[i] / over[i]), power) : 0);
        return out;
      };
      if (top.top_of_air) add("sun_transmission", at_height, ratio(beam_top, 1));
      for (const Column& c : run.columns)
        if (c.name == "radiance_downward" && same(c.place, level)) {
          Sample place = at_height;
          place.zenith_deg = c.place.zenith_deg;
          if (*place.zenith_deg > 0.01) place.azimuth_deg = c.place.relative_azimuth_deg;
          add("sky_radiance_solar", place, on_grid(run, c));
        }
      for (const auto& [zenith, azimuth] : up) {
        Sample place = at_height;
        place.zenith_deg = zenith;
        const Spectrum t = ratio(beam_sensor, mu0 / std::cos(base::rad_from_deg(zenith)));
        add("view_transmission", place, t);
        if (zenith > 0.01) place.azimuth_deg = azimuth;
        const Spectrum at_sensor = column_at("radiance_upward", *sensor, zenith, azimuth),
                       at_target = column_at("radiance_upward", level, zenith, azimuth);
        Spectrum path;
        for (std::size_t i = 0; i < at_sensor.size() && i < at_target.size(); ++i)
          path.push_back(std::max(0.0, at_sensor[i] - t[i] * at_target[i]));
        add("path_radiance_solar", place, std::move(path));
      }
    }
    out_.notices.push_back(source.file->file +
                           ": view transmission is that of the direct beam between the levels, exp((mu0/mu) "
                           "ln(edir(target)/edir(sensor)))");
    if (run.geometry.ground_albedo.value_or(0) > 0)
      out_.notices.push_back(source.file->file + ": computed over ground of albedo " +
                             shown(*run.geometry.ground_albedo) + "; path, sky and irradiance hold its light");
  }

  /// Plain columns named as rows, with the place behind the name: sky_radiance_solar_z30_a90, view_transmission_h0_z20.
  void columns(const Source& source) {
    for (const Column& column : source.run->columns) {
      std::string name = column.name;
      Sample place;
      for (;;) {
        const std::size_t at = name.rfind('_');
        if (at == std::string::npos || at + 2 >= name.size() ||
            std::string("hza").find(name[at + 1]) == std::string::npos ||
            !std::all_of(name.begin() + static_cast<std::ptrdiff_t>(at) + 2, name.end(),
                         [](unsigned char c) { return std::isdigit(c); }))
          break;
        const double value = std::stod(name.substr(at + 2));
        (name[at + 1] == 'h' ? place.height_m : name[at + 1] == 'z' ? place.zenith_deg : place.azimuth_deg) = value;
        name.resize(at);
      }
      const RowSpec* row = find_row_spec(name);
      if (!row || std::string(row->axes).find("wavelength") == std::string::npos ||
          std::string(row->axes).find("range_height") != std::string::npos ||
          std::string(row->axes).find("scattering_angle") != std::string::npos || name == "k_weight") {
        out_.notices.push_back(source.file->file + ": " + column.name +
                               " left out: no row of a table has this name (docs/table_format.md)");
      } else if (column.unit != row->unit) {
        problems_.add({source.file->file, 0, 0, column.name}, std::string("the unit must be ") + row->unit, column.unit,
                      "convert the column");
      } else {
        add(name, place, on_grid(*source.run, column));
      }
    }
  }

  const TableRequest& request_;
  std::vector<Source> sources_;
  Samples out_;
  base::Problems problems_;
};

}  // namespace

Samples samples_of(const std::vector<Imported>& files, const TableRequest& request) {
  return Reader(files, request).read();
}

}  // namespace raycube::atmos::imported
