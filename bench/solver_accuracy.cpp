// raycube_solver_accuracy OUT.json: the layered air's settings against their error and their time, on one scene:
// midlatitude summer, rural aerosol, 23 km, sun at 40 degrees, seen from 3 km over ground at sea level.
// bench/solver_accuracy.py runs it and draws the chart. Every setting alone leaves its default; its errors are those
// against its most careful value.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/compiler/bin_rows.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/standard_streams.h"
#include "host/base/units.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

constexpr double kSensor_m = 3000;

/// CPU time of this thread: the machine may be busy with other work.
double cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Window {
  std::string name;
  bool thermal;
  std::vector<double> wavelength_um;  ///< where streams, layers and k-terms are judged
  double low_um, high_um;             ///< where the spectral step is
  double nm;                          ///< finest step there; channels are 20 of it wide
};

const std::vector<Window>& windows() {
  static const std::vector<Window> all = {{"visible", false, {0.45, 0.55, 0.65}, 0.53, 0.59, 0.5},
                                          {"red edge, oxygen", false, {0.70, 0.7615, 0.78}, 0.73, 0.79, 0.5},
                                          {"water band", false, {0.91, 0.94, 0.97}, 0.91, 0.97, 0.5},
                                          {"SWIR", false, {1.6, 2.05, 2.2}, 1.99, 2.05, 0.5},
                                          {"LWIR", true, {8.5, 9.6, 11.0}, 8.5, 11.5, 25}};
  return all;
}

scene::Sun sun() {
  scene::Sun out;
  out.zenith_deg = 40;
  return out;
}

scene::AirSpec default_air() {
  scene::AirSpec air;
  air.profile = "midlatitude_summer";
  return air;
}

/// Rows of the scene at some bins, and what they cost.
struct Rows {
  RenderTable table;
  double cpu_ms = 0;  ///< per wavelength, the air's preparation left out
  std::size_t layers = 0, wavelengths = 0;
};

Rows fill(const scene::AirSpec& air, const std::vector<SpectralBin>& bins, bool thermal, int repeats) {
  const AirStack stack(air, 0, {kSensor_m / 1000});
  const BinGeometry geometry(stack, sun(), 0, kSensor_m, {0});
  std::vector<double> wavelength_um;
  for (const SpectralBin& bin : bins) wavelength_um.push_back(bin.wavelength_um);
  Rows out;
  out.layers = stack.layers(), out.wavelengths = bins.size();
  out.cpu_ms = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    out.table = sunlit_table(SolarSpectrum(), sun(), kSensor_m, wavelength_um, {0});
    const BinRows rows(out.table, geometry, thermal);
    const double begin = cpu_s();
    for (std::size_t i = 0; i < bins.size(); ++i)
      rows.fill(i, SpectralAir(stack, bins[i], static_cast<std::size_t>(air.k_terms)), air.streams);
    out.cpu_ms = std::min(out.cpu_ms, 1e3 * (cpu_s() - begin) / static_cast<double>(bins.size()));
  }
  return out;
}

/// Bins of the default grid around single wavelengths.
std::vector<SpectralBin> default_bins(const Window& window) {
  std::vector<SpectralBin> bins;
  for (double at : window.wavelength_um) {
    if (at > 2.5) {
      bins.push_back({at, 1e4 / at - 2.5, 1e4 / at + 2.5});
    } else {
      const double half = at < 1 ? 0.0005 : 0.001;
      bins.push_back({at, 1e4 / (at + half), 1e4 / (at - half)});
    }
  }
  return bins;
}

/// A quantity of a table: its values per wavelength.
struct Quantity {
  std::string name;
  std::vector<std::vector<double>> values;  ///< [wavelength]
};

std::vector<double> values_at(const RenderTable& table, const char* row, std::size_t i, std::size_t wavelengths) {
  const std::vector<float>& all = table.rows.at(row).values;
  const auto size = static_cast<std::ptrdiff_t>(all.size() / wavelengths),
             begin = static_cast<std::ptrdiff_t>(i) * size;
  return {all.begin() + begin, all.begin() + begin + size};
}

/// Irradiance of a thermal sky: pi times the integral of radiance over sin^2 of the zenith angle, straight lines
/// between nodes.
double sky_irradiance(const std::vector<double>& radiance, const std::vector<double>& zenith_deg) {
  double sum = 0;
  for (std::size_t z = 0; z + 1 < zenith_deg.size(); ++z) {
    const auto square = [&](std::size_t k) { return std::pow(std::sin(base::rad_by_division(zenith_deg[k])), 2); };
    sum += 0.5 * (radiance[z] + radiance[z + 1]) * (square(z + 1) - square(z));
  }
  return std::numbers::pi * sum;
}

std::vector<Quantity> quantities(const Rows& rows, bool thermal) {
  std::vector<Quantity> out = {{"path radiance", {}}, {"sky radiance", {}}, {"fluxes", {}}};
  for (std::size_t i = 0; i < rows.wavelengths; ++i) {
    const auto take = [&](const char* row) { return values_at(rows.table, row, i, rows.wavelengths); };
    out[0].values.push_back(take(thermal ? "path_radiance_thermal" : "path_radiance_solar"));
    out[1].values.push_back(take(thermal ? "sky_radiance_thermal" : "sky_radiance_solar"));
    if (thermal) {
      out[2].values.push_back({sky_irradiance(out[1].values.back(), rows.table.axes.at("sky_zenith").nodes)});
    } else {
      out[2].values.push_back(take("diffuse_irradiance"));
      out[2].values.back().push_back(take("spherical_albedo")[0]);
    }
  }
  return out;
}

struct Error {
  double rms = 0, worst = 0;
};

/// Relative errors over all wavelengths and directions; values below 1e-6 of a quantity's largest are left out.
Error relative_error(const Quantity& found, const Quantity& reference) {
  double largest = 0, squares = 0;
  for (const auto& values : reference.values)
    for (double value : values) largest = std::max(largest, value);
  Error error;
  std::size_t count = 0;
  for (std::size_t i = 0; i < reference.values.size(); ++i)
    for (std::size_t k = 0; k < reference.values[i].size(); ++k) {
      const double truth = reference.values[i][k];
      if (!(truth > 1e-6 * largest)) continue;
      const double off = std::abs(found.values[i][k] / truth - 1);
      squares += off * off;
      error.worst = std::max(error.worst, off);
      ++count;
    }
  if (count == 0)
    throw base::Error(base::Fault::check, "bench: " + reference.name + " of the reference is nothing but zeros");
  error.rms = std::sqrt(squares / static_cast<double>(count));
  return error;
}

class Chart {
 public:
  void add(const std::string& knob, double setting, bool is_default, const Window& window, double cpu_ms,
           std::size_t layers, const std::vector<Quantity>& found, const std::vector<Quantity>& reference) {
    for (std::size_t q = 0; q < found.size(); ++q) {
      const Error error = relative_error(found[q], reference[q]);
      if (!std::isfinite(error.rms))
        throw base::Error(base::Fault::check, "bench: an error that is no number, " + knob);
      points_.push_back({{"knob", knob},
                         {"setting", setting},
                         {"default", is_default},
                         {"window", window.name},
                         {"quantity", found[q].name},
                         {"layers", layers},
                         {"cpu_ms", cpu_ms},
                         {"rms", error.rms},
                         {"worst", error.worst}});
    }
    std::printf("%-9s %5g  %-17s %9.2f ms\n", knob.c_str(), setting, window.name.c_str(), cpu_ms);
    std::fflush(stdout);
  }
  void write(const std::string& file) const {
    std::ofstream out(file);
    out << points_.dump(1) << '\n';
    if (!out) throw base::Error(base::Fault::input, "bench: cannot write " + file);
  }

 private:
  nlohmann::json points_ = nlohmann::json::array();
};

/// One setting of the air, at the wavelengths of all windows.
void sweep_air(Chart& chart, const std::string& knob, const std::vector<int>& settings, int careful,
               const std::function<void(scene::AirSpec&, int)>& set) {
  for (const Window& window : windows()) {
    scene::AirSpec air = default_air();
    set(air, careful);
    const std::vector<SpectralBin> bins = default_bins(window);
    const Rows best = fill(air, bins, window.thermal, 1);
    const std::vector<Quantity> reference = quantities(best, window.thermal);
    for (int setting : settings) {
      air = default_air();
      set(air, setting);
      const bool is_default = air.streams == default_air().streams && air.k_terms == default_air().k_terms &&
                              air.layering == default_air().layering;
      const Rows rows = fill(air, bins, window.thermal, 3);
      chart.add(knob, setting, is_default, window, rows.cpu_ms, rows.layers, quantities(rows, window.thermal),
                reference);
    }
  }
}

/// Means over channels of a spectrum that is a straight line between its nodes.
std::vector<Quantity> channel_means(const std::vector<Quantity>& spectrum, const std::vector<double>& wavelength_um,
                                    double width_um, double low_um, double high_um) {
  constexpr int kSamples = 200;
  std::vector<Quantity> out = spectrum;
  for (std::size_t q = 0; q < spectrum.size(); ++q) {
    out[q].values.clear();
    for (double centre = low_um + width_um; centre < high_um - width_um + 1e-9; centre += 0.5 * width_um) {
      std::vector<double> mean(spectrum[q].values[0].size(), 0.0);
      for (int s = 0; s < kSamples; ++s) {
        const double at = centre + width_um * ((s + 0.5) / kSamples - 0.5);
        const auto above = std::upper_bound(wavelength_um.begin() + 1, wavelength_um.end() - 1, at);
        const auto i = static_cast<std::size_t>(above - wavelength_um.begin());
        const double part = (at - wavelength_um[i - 1]) / (wavelength_um[i] - wavelength_um[i - 1]);
        for (std::size_t k = 0; k < mean.size(); ++k)
          mean[k] += ((1 - part) * spectrum[q].values[i - 1][k] + part * spectrum[q].values[i][k]) / kSamples;
      }
      out[q].values.push_back(mean);
    }
  }
  return out;
}

/// Bins of a wavelength step; the nodes end one channel beyond the channels that are judged.
std::vector<SpectralBin> stepped_bins(const Window& window, double step_um) {
  std::vector<double> nodes;
  const int count = static_cast<int>(std::lround((window.high_um - window.low_um) / step_um));
  for (int i = 0; i <= count; ++i) nodes.push_back(window.low_um + i * step_um);
  return spectral_bins(nodes);
}

void sweep_step(Chart& chart) {
  for (const Window& window : windows()) {
    const double width_um = 20 * window.nm / 1000;
    std::vector<Quantity> reference;
    for (double multiple : {1, 2, 4, 10, 20, 40}) {
      const std::vector<SpectralBin> bins = stepped_bins(window, multiple * window.nm / 1000);
      const Rows rows = fill(default_air(), bins, window.thermal, 1);
      const std::vector<Quantity> means =
          channel_means(quantities(rows, window.thermal), rows.table.axes.at("wavelength").nodes, width_um,
                        window.low_um, window.high_um);
      if (multiple == 1) {
        reference = means;
        continue;
      }
      // Time of one channel's width of spectrum.
      const double cpu_ms = rows.cpu_ms * 20 / multiple;
      const double usual = window.high_um < 1 ? 2 : window.thermal ? 2 : 4;  // 1 nm, 2 nm, 5 cm-1 (50 nm at 10 um)
      chart.add("step", multiple * window.nm, multiple == usual, window, cpu_ms, rows.layers, means, reference);
    }
  }
}

/// What is timed is what the program builds: the same rows, bit for bit, as build_layered.
void validate_rows() {
  for (const Window& window : windows()) {
    scene::AtmosphereSpec spec;
    spec.layered = default_air();
    const double at = window.wavelength_um[1], half = at < 1 ? 0.001 : 0.002;
    const std::vector<double> nodes = {at - half, at, at + half};
    const RenderTable built = build_layered(spec, sun(), kSensor_m, nodes, {0}, {.threads = 1, .finished = {}});
    const std::vector<SpectralBin> bins = spectral_bins(nodes);
    Rows ours = fill(default_air(), bins, window.thermal, 1);
    for (const char* row : {"spherical_albedo", "diffuse_view_transmission", "view_transmission"})
      if (built.rows.at(row).values != ours.table.rows.at(row).values)
        throw base::Error(base::Fault::check,
                          std::string("bench: the rows ") + row + " are not those of raycube atmos build");
    validate(ours.table, "bench");
    const std::vector<Quantity> own = quantities(ours, window.thermal);
    for (const Quantity& quantity : own)
      for (const auto& values : quantity.values)
        for (double value : values)
          if (!(value > 0))
            throw base::Error(base::Fault::check, "bench: a " + quantity.name + " that is not above 0, " + window.name);
  }
}

}  // namespace

int main(int argc, char** argv) {
  raycube::base::claim_standard_descriptors();
  try {
    if (argc != 2) throw base::Error(base::Fault::input, "usage: raycube_solver_accuracy OUT.json");
    const double begin = cpu_s();
    validate_rows();
    Chart chart;
    sweep_air(chart, "streams", {4, 8, 16, 32}, 64, [](scene::AirSpec& air, int value) { air.streams = value; });
    sweep_air(chart, "layering", {1, 2, 3}, 6, [](scene::AirSpec& air, int value) { air.layering = value; });
    sweep_air(chart, "k-terms", {1, 2, 3, 4}, 5, [](scene::AirSpec& air, int value) { air.k_terms = value; });
    sweep_step(chart);
    chart.write(argv[1]);
    std::printf("%.0f s of CPU time in all; %s\n", cpu_s() - begin, argv[1]);
    return 0;
  } catch (const base::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
