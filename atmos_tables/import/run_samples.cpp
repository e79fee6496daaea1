#include "atmos_tables/import/run_samples.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <tuple>

#include "host/base/text.h"
#include "atmos_tables/import/albedo_runs.h"
#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/sample_book.h"
#include "atmos_tables/import/sixs_bands.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/told_geometry.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/row_registry.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

Role role_of(const Imported& file, const Run& run) {
  if (only_tells(run)) return Role::told;
  if (file.format == "chn") return Role::channels;
  if (file.format == "plain-csv") return Role::columns;
  if (file.format == "6s") return run.mode == "joined" ? Role::bands : Role::wavelength_table;
  if (file.format == "uvspec") {
    if (run.mode.rfind("thermal", 0) == 0) return Role::emission;
    return run.mode.rfind("fluxes", 0) == 0 ? Role::solver : Role::unused;
  }
  if (run.mode == "atmospheric correction data") return Role::correction;
  if (run.mode == "direct irradiance") return Role::sun;
  if (run.find("irradiance_down_diffuse")) return Role::levels;
  if (!run.find("transmittance") || !run.geometry.sight_zenith_deg) return Role::unused;
  if (*run.geometry.sight_zenith_deg > 90) return Role::down;
  return run.find("radiance") ? Role::sky : Role::unused;
}

class Reader {
 public:
  Reader(const std::vector<Imported>& files, const TableRequest& request) : book_{request, {}, {}, 0, {}} {
    for (const Imported& file : files)
      for (const Run& run : file.runs) {
        const Role role = role_of(file, run);
        if (role == Role::told)
          continue;  // what it tells stands in the runs it tells of
        else if (role == Role::unused)
          out_.notices.push_back(
              file.file + ": " + run.mode +
              ": not used; a table takes paths down, skies, sun paths, fluxes, channels and columns");
        else
          sources_.push_back({&file, &run, role});
      }
    if (sources_.empty())
      throw base::Error(base::Fault::input,
                        "none of the files holds a run that a render table can be made of; a listing (.tp6) or an "
                        "input tells of a run and holds none: give its .chn, .csv, .acd or JSON output with it");
    place_ground();
    choose_grid();
    std::stable_partition(sources_.begin(), sources_.end(),
                          [](const Source& source) { return source.role != Role::emission; });
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
        case Role::emission:
          add_solver_samples(source, book_);
          break;
        case Role::channels:
          channels(source, albedo_at);
          break;
        case Role::correction:
          correction(source);
          break;
        case Role::bands:
          add_joined_bands(source, book_);
          break;
        case Role::wavelength_table:
          add_wavelength_table(source, book_);
          break;
        case Role::columns:
          columns(source);
          break;
        case Role::told:
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

  /// z = 0: as asked for, else the ground of the runs that say where it is, else the level heights are counted from.
  void place_ground() {
    std::optional<double> told;
    for (const Source& source : sources_)
      book_.agree(told, source.run->geometry.ground_height_m, 0.5, "the ground's height", source);
    book_.ground_m = request_.ground_height_m.value_or(told.value_or(0));
    if (request_.ground_height_m && told && std::abs(*told - *request_.ground_height_m) > 0.5)
      out_.notices.push_back("z = 0 at " + shown(book_.ground_m) + " m as asked for; the ground of the runs is at " +
                             shown(*told) + " m");
    else if (!request_.ground_height_m && book_.ground_m != 0)
      out_.notices.push_back("z = 0 is the ground of the runs, " + shown(book_.ground_m) +
                             " m above the level they count heights from; --ground-height says otherwise");
  }

  void choose_grid() {
    const Source* lead = &sources_.front();
    double first = 0, last = 1e9;
    for (const Source& source : sources_) {
      const auto [low, high] = std::minmax_element(source.run->wavelength_um.begin(), source.run->wavelength_um.end());
      first = std::max(first, *low), last = std::min(last, *high);
      const auto leads_grid = [](Role role) {
        return role == Role::down || role == Role::channels || role == Role::solver || role == Role::bands;
      };
      const bool leads = leads_grid(source.role), lead_leads = leads_grid(lead->role);
      if (leads && !lead_leads) lead = &source;
    }
    out_.wavelength_um = book_.sorted(*lead->run, lead->run->wavelength_um);
    auto& grid = out_.wavelength_um;
    // Wavenumbers printed to two decimals are one wavelength to 1e-6 of it.
    const auto outside = [&](double l) { return l < first * (1 - 1e-6) || l > last * (1 + 1e-6); };
    const std::size_t all = grid.size();
    grid.erase(std::remove_if(grid.begin(), grid.end(), outside), grid.end());
    if (grid.empty())
      throw base::Error(base::Fault::input, "the runs have no wavelength in common; give runs of one range");
    if (grid.size() < all)
      out_.notices.push_back(base::counted(all - grid.size(), "wavelength") + " of " + lead->file->file +
                             " left out: other runs do not cover them");
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
    book_.sun_and_sensor(source);
    Sample place;
    place.height_m = book_.ground(g.path_end_height_m);
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
    const Spectrum t = book_.optional(first, "transmittance");
    book_.add("view_transmission", no_azimuth, t);
    book_.add("solar_irradiance", {}, book_.optional(first, "solar_irradiance"));
    Spectrum two_way = book_.optional(first, "solar_irradiance_sun_ground_sensor");
    const Spectrum above = book_.optional(first, "solar_irradiance");
    if (!two_way.empty() && !above.empty()) {
      for (std::size_t i = 0; i < two_way.size(); ++i) two_way[i] = above[i] > 0 ? two_way[i] / above[i] : 0;
      book_.add(kTwoWay, no_azimuth, std::move(two_way));
    }
    book_.add("path_radiance_solar", place, book_.optional(first, "path_radiance_solar"));
    book_.add("path_radiance_thermal", no_azimuth, book_.optional(first, "path_radiance_thermal"));
    const std::string name = runs.front().source->file->file;
    if (runs.front().albedo > 0)
      out_.notices.push_back(name + ": the path's sunlight was computed over ground of albedo " +
                             shown(runs.front().albedo) + ", not over black ground");
    std::vector<const Seen*> bright;
    for (const Seen& seen : runs)
      if (seen.albedo > 0 && (bright.empty() || seen.albedo > bright.back()->albedo + 1e-6)) bright.push_back(&seen);
    const auto seen_light = [&](const Seen& seen) {  // sunlight alone: what the ground emits is not the air's
      Spectrum light = book_.optional(*seen.source->run, "path_radiance_solar");
      const Spectrum reflected = book_.optional(*seen.source->run, "ground_reflected");
      for (std::size_t i = 0; i < light.size() && i < reflected.size(); ++i) light[i] += reflected[i];
      return light;
    };
    if (runs.front().albedo == 0 && bright.size() >= 2) {
      const Seen &low = *bright.front(), &high = *bright.back();
      const Spectrum l0 = seen_light(runs.front()), l1 = seen_light(low), l2 = seen_light(high),
                     reflected = book_.optional(*high.source->run, "ground_reflected");
      if (l0.empty() || reflected.empty()) return;
      Spectrum s, t_dif, total;
      for (std::size_t i = 0; i < l0.size(); ++i) {
        const GroundCoupling c = coupling_of_three_runs(l0[i], l1[i], l2[i], low.albedo, high.albedo);
        const double a = reflected[i] * (1 / high.albedo - c.spherical_albedo);  // T_dir E_g0 / pi
        s.push_back(c.spherical_albedo);
        t_dif.push_back(a > 0 ? std::clamp(t[i] * (c.coefficient - a) / a, 0.0, 1.0) : 0);
        total.push_back(t[i] > 0 ? base::kPi * a / t[i] : 0);
      }
      book_.add("spherical_albedo", at_height, std::move(s));
      book_.add("diffuse_view_transmission", no_azimuth, std::move(t_dif));
      book_.add(kTotalIrradiance, at_height, std::move(total));
    } else if (!bright.empty()) {
      const Seen& seen = *bright.front();
      const Spectrum reflected = book_.optional(*seen.source->run, "ground_reflected");
      Spectrum total;
      for (std::size_t i = 0; i < reflected.size(); ++i)
        total.push_back(t[i] > 0 ? base::kPi * reflected[i] / (seen.albedo * t[i]) : 0);
      book_.add(kTotalIrradiance, at_height, std::move(total));
      out_.notices.push_back(name + ": diffuse irradiance is that over ground of albedo " + shown(seen.albedo) +
                             "; three runs of albedo 0, r1 and r2 would separate ground and air");
    }
  }

  void sky(const Source& source) {
    const Geometry& g = source.run->geometry;
    book_.agree(out_.sun_zenith_deg, g.sun_zenith_deg, 0.05, "the sun's zenith", source);
    Sample place;
    place.height_m = book_.ground(g.sensor_height_m);
    place.zenith_deg = *g.sight_zenith_deg;
    Sample no_azimuth = place;
    if (*place.zenith_deg > 0.01) place.azimuth_deg = g.relative_azimuth_deg;
    book_.add("sky_radiance_solar", place, book_.optional(*source.run, "path_radiance_solar"));
    book_.add("sky_radiance_thermal", no_azimuth, book_.optional(*source.run, "path_radiance_thermal"));
    book_.add("solar_irradiance", {}, book_.optional(*source.run, "solar_irradiance"));
  }

  void sun(const Source& source) {
    const Geometry& g = source.run->geometry;
    book_.agree(out_.sun_zenith_deg, g.sight_zenith_deg, 0.05, "the sun's zenith",
                source);  // the sight is towards the sun
    Sample place;
    place.height_m = book_.ground(g.sensor_height_m);
    book_.add("sun_transmission", place, book_.optional(*source.run, "transmittance"));
    book_.add("solar_irradiance", {}, book_.optional(*source.run, "solar_irradiance"));
  }

  void levels(const Source& source) {
    for (const Column& column : source.run->columns) {
      const bool direct = column.name == "irradiance_down_direct";
      if ((!direct && column.name != "irradiance_down_diffuse") || !column.place.height_m) continue;
      Sample place;
      place.height_m = book_.ground(column.place.height_m);
      if (out_.sensor_height_m && *place.height_m > *out_.sensor_height_m + 0.5) continue;
      book_.add(direct ? "direct_irradiance" : "diffuse_irradiance", place, book_.on_grid(*source.run, column));
    }
  }

  /// Of a run whose geometry only a listing or an input tells, if any: the path's end; with zenith; with azimuth.
  std::tuple<Sample, Sample, Sample> told_places(const Geometry& g) const {
    Sample at_height;
    if (g.path_end_height_m) at_height.height_m = book_.ground(g.path_end_height_m);
    Sample no_azimuth = at_height;
    no_azimuth.zenith_deg = g.view_zenith_deg;
    Sample place = no_azimuth;
    if (place.zenith_deg.value_or(0) > 0.01) place.azimuth_deg = g.relative_azimuth_deg;
    return {at_height, no_azimuth, place};
  }

  void channels(const Source& source, std::size_t& albedo_at) {
    const Run& run = *source.run;
    const double r = albedo_of(source, albedo_at);
    const Spectrum t = book_.on_grid(run, run.at("transmittance")), a = book_.on_grid(run, run.at("coefficient_a")),
                   b = book_.on_grid(run, run.at("coefficient_b")), s = book_.on_grid(run, run.at("spherical_albedo")),
                   above = book_.on_grid(run, run.at(kIrradianceCosOverPi));
    Spectrum path = book_.on_grid(run, run.at("path_radiance_solar")), t_dif, total;
    for (std::size_t i = 0; i < t.size(); ++i) {
      path[i] = std::max(0.0, path[i] - r * b[i] * above[i] / (1 - r * s[i]));
      t_dif.push_back(a[i] > 0 ? std::clamp(t[i] * b[i] / a[i], 0.0, 1.0) : 0);
      total.push_back(t[i] > 0 ? base::kPi * a[i] * above[i] / t[i] : 0);
    }
    book_.sun_and_sensor(source);
    const auto [at_height, no_azimuth, place] = told_places(run.geometry);
    book_.add("view_transmission", no_azimuth, t);
    book_.add("path_radiance_solar", place, std::move(path));
    book_.add("path_radiance_thermal", no_azimuth, book_.optional(run, "path_radiance_thermal"));
    book_.add("spherical_albedo", at_height, s);
    book_.add("diffuse_view_transmission", no_azimuth, std::move(t_dif));
    book_.add(kTotalIrradiance, at_height, std::move(total));
    Spectrum two_way = book_.on_grid(run, run.at("solar_irradiance_sun_ground_sensor"));
    book_.add(kIrradianceCosOverPi, {}, above);
    book_.add("solar_irradiance_sun_ground_sensor", no_azimuth, std::move(two_way));
  }

  void correction(const Source& source) {
    const auto sum_over_k = [&](const char* name) -> Spectrum {
      for (const Column& column : source.run->columns)
        if (column.name == name && !column.place.k) return book_.on_grid(*source.run, column);
      return {};
    };
    book_.sun_and_sensor(source);
    const auto [at_height, no_azimuth, place] = told_places(source.run->geometry);
    book_.add("view_transmission", no_azimuth, sum_over_k("ground_sensor_transmittance_direct"));
    book_.add(kTwoWay, no_azimuth, sum_over_k("sun_ground_sensor_transmittance_direct"));
    book_.add("diffuse_view_transmission", no_azimuth, sum_over_k("ground_sensor_transmittance_diffuse"));
    book_.add("spherical_albedo", at_height, sum_over_k("spherical_albedo"));
    book_.add(kSunGroundDiffuse, at_height, sum_over_k(kSunGroundDiffuse));
    if (source.run->find("k_weight") && source.run->find("k_weight")->place.k)
      out_.notices.push_back(source.file->file +
                             ": k-terms summed with their weights; the direct light from sun to sensor is summed as "
                             "the product of each term");
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
        book_.add(name, place, book_.on_grid(*source.run, column));
      }
    }
  }

  SampleBook book_;
  const TableRequest& request_ = book_.request;
  Samples& out_ = book_.out;
  base::Problems& problems_ = book_.problems;
  std::vector<Source> sources_;
};

}  // namespace

Samples samples_of(const std::vector<Imported>& files, const TableRequest& request) {
  return Reader(files, request).read();
}

}  // namespace raycube::atmos::imported
