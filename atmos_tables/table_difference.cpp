#include "atmos_tables/table_difference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <sstream>

#include "atmos_tables/detail/lit_factor.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/row_registry.h"
#include "host/base/error.h"
#include "host/base/text.h"

namespace raycube::atmos {

namespace {

using Spectrum = std::vector<double>;

constexpr double kSame_um = 1e-9;

std::string shown(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

/// A transmission and its optical depth are one quantity.
std::string stands_for(const std::string& row) {
  if (row == "sun_optical_depth") return "sun_transmission";
  if (row == "view_optical_depth") return "view_transmission";
  return row;
}

std::set<std::string> quantities_of(const RenderTable& table) {
  std::set<std::string> out;
  for (const auto& [name, row] : table.rows)
    if (name != "k_weight") out.insert(stands_for(name));
  // Transmissions per k-term carry their two-way product.
  if (table.has("k_weight") && out.count("sun_transmission") && out.count("view_transmission"))
    out.insert("two_way_factor");
  return out;
}

void say(std::vector<std::string>& out, const char* what, double a, double b, const char* unit, double same) {
  if (std::abs(a - b) > same) out.push_back(std::string(what) + ": " + shown(a) + " and " + shown(b) + " " + unit);
}

std::vector<std::string> what_differs(const RenderTable& a, const RenderTable& b) {
  std::vector<std::string> out;
  say(out, "sun zenith", a.sun_zenith_deg, b.sun_zenith_deg, "deg", 1e-9);
  say(out, "sun azimuth (does not matter: azimuths are relative)", a.sun_azimuth_deg, b.sun_azimuth_deg, "deg", 1e-9);
  say(out, "sensor height", a.sensor_height_m, b.sensor_height_m, "m", 1e-9);
  if (a.medium != b.medium) out.push_back("wavelengths: in " + a.medium + " and " + b.medium + "; taken as they stand");
  if (a.solar_source != b.solar_source) out.push_back("solar spectrum: " + a.solar_source + " and " + b.solar_source);
  for (const AxisSpec& spec : axis_registry()) {
    const auto in_a = a.axes.find(spec.name), in_b = b.axes.find(spec.name);
    if (in_a == a.axes.end() || in_b == b.axes.end() || in_a->second.nodes == in_b->second.nodes) continue;
    const auto range = [&](const std::vector<double>& nodes) {
      return nodes.size() == 1 ? "1 node at " + shown(nodes[0]) + " " + spec.unit
                               : base::counted(nodes.size(), "node") + " from " + shown(nodes.front()) + " to " +
                                     shown(nodes.back()) + " " + spec.unit;
    };
    out.push_back(std::string("axis ") + spec.name + ": " + range(in_a->second.nodes) + ", and " +
                  range(in_b->second.nodes));
  }
  return out;
}

/// Nearest to `wanted` of the values both tables can be read at. An axis of one node can be read anywhere, and is meant
/// for its node. Empty: their ranges do not meet.
std::optional<double> common_point(const RenderTable& a, const RenderTable& b, const char* axis, double wanted) {
  const auto in_a = a.axes.find(axis), in_b = b.axes.find(axis);
  const bool free_a = in_a == a.axes.end() || in_a->second.nodes.size() == 1,
             free_b = in_b == b.axes.end() || in_b->second.nodes.size() == 1;
  if (free_a && free_b)
    return in_a != a.axes.end() ? in_a->second.nodes[0] : in_b != b.axes.end() ? in_b->second.nodes[0] : wanted;
  double low = -1e30, high = 1e30;
  for (const auto& [free, found] : {std::pair{free_a, in_a}, {free_b, in_b}})
    if (!free) low = std::max(low, found->second.nodes.front()), high = std::min(high, found->second.nodes.back());
  if (low > high) return std::nullopt;
  if (free_a && in_a != a.axes.end()) wanted = in_a->second.nodes[0];
  if (free_b && in_b != b.axes.end()) wanted = in_b->second.nodes[0];
  return std::clamp(wanted, low, high);
}

Spectrum merged_grid(const Spectrum& a, const Spectrum& b, double first, double last,
                     const std::vector<DifferenceBand>& bands) {
  Spectrum out{first, last};
  for (const Spectrum* nodes : {&a, &b})
    for (const double l : *nodes)
      if (l > first && l < last) out.push_back(l);
  for (const auto& band : bands) {
    for (const double l : {band.low_um, band.high_um})
      if (l > first && l < last) out.push_back(l);
    // A response narrower than the nodes' steps still needs points to be summed over.
    for (int i = -20; band.fwhm_um > 0 && i <= 20; ++i)
      if (const double l = band.center_um + i * band.fwhm_um / 8; l > first && l < last) out.push_back(l);
  }
  std::sort(out.begin(), out.end());
  // Nodes of the same wavelength, once printed and once computed, differ by rounding.
  out.erase(std::unique(out.begin(), out.end(), [](double x, double y) { return y - x < kSame_um; }), out.end());
  return out;
}

double response(const DifferenceBand& band, double um) {
  if (um < band.low_um - kSame_um || um > band.high_um + kSame_um) return 0;
  if (!(band.fwhm_um > 0)) return 1;
  const double x = (um - band.center_um) / band.fwhm_um;
  return std::exp(-4 * std::numbers::ln2 * x * x);
}

/// Trapezoids under response times the value. Box edges are grid points, and belong to the box from inside. Empty where
/// the quantity has no value in the band.
std::optional<BandDifference> in_band(const DifferenceBand& band, const Spectrum& grid, const QuantityDifference& q) {
  BandDifference out;
  out.band = band;
  double weights = 0, squares = 0;
  const bool one_point = grid.size() == 1;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double here = std::isfinite(q.a[i]) && std::isfinite(q.b[i]) ? response(band, grid[i]) : 0;
    if (here <= 0) continue;
    double step = one_point ? 1 : 0;
    if (i > 0 && response(band, grid[i - 1]) > 0) step += (grid[i] - grid[i - 1]) / 2;
    if (i + 1 < grid.size() && response(band, grid[i + 1]) > 0) step += (grid[i + 1] - grid[i]) / 2;
    const double weight = here * step, d = q.b[i] - q.a[i];
    weights += weight, squares += weight * d * d;
    out.mean_a += weight * q.a[i], out.mean_b += weight * q.b[i];
    if (here >= 0.5 && (std::abs(d) > std::abs(out.worst) || out.worst_um == 0)) out.worst = d, out.worst_um = grid[i];
  }
  if (!(weights > 0)) return std::nullopt;
  out.mean_a /= weights, out.mean_b /= weights;
  out.mean = out.mean_b - out.mean_a;
  out.rms = std::sqrt(squares / weights);
  if (!q.ratio && out.mean_a > 0) {
    out.mean_relative = out.mean / out.mean_a;
    out.rms_relative = out.rms / out.mean_a;
    out.worst_relative = out.worst / out.mean_a;
  }
  return out;
}

/// Those of the bands that lie in the common range at all; boxes are clipped to it, a Gaussian must have its half-width
/// points inside.
std::vector<DifferenceBand> bands_within(const std::vector<DifferenceBand>& asked, double first_um, double last_um) {
  std::vector<DifferenceBand> bands;
  for (DifferenceBand band : asked) {
    const double half = band.fwhm_um / 2;
    if (band.fwhm_um > 0
            ? band.center_um - half < first_um || band.center_um + half > last_um
            : std::min(band.high_um, last_um) - std::max(band.low_um, first_um) <= kSame_um && first_um < last_um)
      continue;
    if (band.fwhm_um <= 0 && (band.low_um > last_um || band.high_um < first_um)) continue;
    band.low_um = std::max(band.low_um, first_um), band.high_um = std::min(band.high_um, last_um);
    bands.push_back(band);
  }
  if (bands.empty())
    throw base::Error(base::Fault::input,
                      "no band lies in the common range of " + shown(first_um) + " to " + shown(last_um) + " um");
  return bands;
}

/// The wavelengths both tables cover.
void find_common_range(const RenderTable& a, const RenderTable& b, TableDifference& out) {
  const Spectrum &nodes_a = wavelengths(a), &nodes_b = wavelengths(b);
  const auto range = [](const Spectrum& nodes) { return shown(nodes.front()) + " to " + shown(nodes.back()) + " um"; };
  out.first_um = std::max(nodes_a.front(), nodes_b.front());
  out.last_um = std::min(nodes_a.back(), nodes_b.back());
  if (out.first_um > out.last_um)
    throw base::Error(base::Fault::input,
                      "the tables have no wavelength in common: " + range(nodes_a) + ", and " + range(nodes_b));
}

double common_height(const RenderTable& a, const RenderTable& b, const DifferenceChoice& choice) {
  // Wanted far below: the nearest is the lowest.
  const auto height =
      common_point(a, b, "target_height", choice.height_m.value_or(find_axis_spec("target_height")->min));
  if (!height)
    throw base::Error(base::Fault::input,
                      "the tables have no target height in common (raycube atmos info names their axes)");
  return *height;
}

/// Reads the quantities that both tables hold, at the places both can be read at, and adds each to the difference. What
/// has a direction is read straight and slanted.
class QuantityReader {
 public:
  using Read = std::function<Spectrum(const RenderTable&)>;
  using ReadAtHeight = Spectrum (*)(const RenderTable&, double height_m);
  using ReadAtZenith = Spectrum (*)(const RenderTable&, double height_m, double zenith_deg);
  using ReadDirection = std::function<Spectrum(const RenderTable&, double zenith_deg, double azimuth_deg)>;

  /// Keeps references. out: its height and its grid of wavelengths are known.
  QuantityReader(const RenderTable& a, const RenderTable& b, const std::vector<DifferenceBand>& bands,
                 double relative_azimuth_deg, TableDifference& out)
      : a_(a),
        b_(b),
        bands_(bands),
        relative_azimuth_deg_(relative_azimuth_deg),
        has_a_(quantities_of(a)),
        has_b_(quantities_of(b)),
        out_(out) {}

  void add_spectrum(const char* name, const Read& read) {
    if (both(name)) add(name, "", read);
  }

  void add_at_height(const char* name, ReadAtHeight read) {
    if (both(name)) add(name, "", [&](const RenderTable& t) { return read(t, out_.height_m); });
  }

  void add_at_zenith(const char* name, const char* zenith_axis, double slant_deg, ReadAtZenith read) {
    add_directed(name, zenith_axis, slant_deg, nullptr,
                 [&](const RenderTable& t, double zenith, double) { return read(t, out_.height_m, zenith); });
  }

  /// Straight and slanted, where the tables' zenith axes and the azimuth meet. azimuth_axis: null where it has none.
  void add_directed(const char* name, const char* zenith_axis, double slant_deg, const char* azimuth_axis,
                    const ReadDirection& read) {
    if (!both(name)) return;
    const bool view = std::string(zenith_axis) == "view_zenith";
    const auto azimuth = azimuth_axis ? common_point(a_, b_, azimuth_axis, fold_azimuth(relative_azimuth_deg_)) : 0.0;
    const auto straight = common_point(a_, b_, zenith_axis, 0), leaning = common_point(a_, b_, zenith_axis, slant_deg);
    if (!azimuth || !straight || !leaning) {
      out_.differs.push_back(std::string(name) + ": not compared, the tables have no direction in common");
      return;
    }
    const auto where = [&](double zenith) {
      std::string text = zenith == 0 && view ? "nadir"
                         : zenith == 0       ? "zenith"
                                             : (view ? "view zenith " : "sky zenith ") + shown(zenith) + " deg";
      return zenith != 0 && azimuth_axis ? text + ", azimuth " + shown(*azimuth) + " deg" : text;
    };
    add(name, where(*straight), [&](const RenderTable& t) { return read(t, *straight, *azimuth); });
    if (*leaning != *straight)
      add(name, where(*leaning), [&](const RenderTable& t) { return read(t, *leaning, *azimuth); });
  }

 private:
  bool both(const char* name) const { return has_a_.count(name) && has_b_.count(name); }

  void add(const std::string& name, const std::string& where, const Read& read) {
    QuantityDifference q;
    q.name = name, q.where = where, q.unit = find_row_spec(name)->unit;
    q.ratio = q.unit == "1";
    q.a = resample_linear(wavelengths(a_), read(a_), out_.wavelength_um);
    q.b = resample_linear(wavelengths(b_), read(b_), out_.wavelength_um);
    for (const DifferenceBand& band : bands_)
      if (const auto difference = in_band(band, out_.wavelength_um, q)) q.bands.push_back(*difference);
    out_.quantities.push_back(std::move(q));
  }

  const RenderTable &a_, &b_;
  const std::vector<DifferenceBand>& bands_;
  double relative_azimuth_deg_;
  std::set<std::string> has_a_, has_b_;
  TableDifference& out_;
};

/// Every quantity that can be compared, in the order of the report.
void read_quantities(QuantityReader& reader, double height_m, const DifferenceChoice& choice) {
  const double h = height_m, view = choice.view_zenith_deg, sky = choice.sky_zenith_deg;
  reader.add_spectrum("solar_irradiance", solar_irradiance);
  reader.add_at_height("sun_transmission", sun_transmission);
  reader.add_at_zenith("view_transmission", "view_zenith", view, view_transmission);
  reader.add_at_zenith("two_way_factor", "view_zenith", view, detail::lit_two_way_factor);
  reader.add_directed(
      "path_radiance_solar", "view_zenith", view, "relative_azimuth",
      [&](const RenderTable& t, double zenith, double azimuth) { return path_radiance(t, h, zenith, azimuth); });
  reader.add_directed(
      "sky_radiance_solar", "sky_zenith", sky, "sky_azimuth",
      [&](const RenderTable& t, double zenith, double azimuth) { return sky_radiance(t, h, zenith, azimuth); });
  reader.add_at_height("direct_irradiance", direct_irradiance);
  reader.add_at_height("diffuse_irradiance", diffuse_irradiance);
  reader.add_at_height("spherical_albedo", spherical_albedo);
  reader.add_at_zenith("diffuse_view_transmission", "view_zenith", view, diffuse_view_transmission);
  reader.add_at_zenith("diffuse_return", "sky_zenith", sky, diffuse_return);
  reader.add_at_zenith("path_radiance_thermal", "view_zenith", view, path_radiance_thermal);
  reader.add_at_zenith("sky_radiance_thermal", "sky_zenith", sky, sky_radiance_thermal);
  reader.add_at_zenith("two_way_factor_thermal", "view_zenith", view, two_way_factor_thermal);
}

}  // namespace

std::vector<DifferenceBand> atmospheric_windows() {
  std::vector<DifferenceBand> out;
  for (const auto& [low, high] : std::initializer_list<std::pair<double, double>>{
           {0.30, 0.40}, {0.40, 0.50}, {0.50, 0.58}, {0.58, 0.70}, {0.70, 1.00}, {1.00, 1.30}, {1.30, 1.50},
           {1.45, 1.75}, {1.75, 2.00}, {2.00, 2.40}, {2.40, 3.00}, {3.00, 3.40}, {3.40, 3.96}, {3.96, 4.40},
           {4.40, 4.60}, {4.60, 4.80}, {4.80, 5.50}, {5.50, 8.00}, {8.0, 8.5},   {8.5, 9.0},   {9.0, 9.4},
           {9.4, 10.0},  {10.0, 10.5}, {10.5, 11.0}, {11.0, 11.5}, {11.5, 12.0}, {12.0, 12.5}, {12.5, 13.0},
           {13.0, 14.0}, {14.0, 17.0}, {17.0, 22.0}, {22.0, 30.0}})
    out.push_back({low, high, (low + high) / 2, 0});
  return out;
}

std::vector<DifferenceBand> even_bands(double first_um, double last_um, double width_um) {
  std::vector<DifferenceBand> out;
  // From the index, so that steps do not add up their rounding; a last sliver of rounding is no band.
  for (int i = 0;; ++i) {
    const double low = first_um + i * width_um;
    if (!(last_um - low > 1e-6 * width_um)) return out;
    const double high = std::min(last_um, first_um + (i + 1) * width_um);
    out.push_back({low, high, (low + high) / 2, 0});
  }
}

DifferenceBand gaussian_band(double center_um, double fwhm_um) {
  return {center_um - 2.5 * fwhm_um, center_um + 2.5 * fwhm_um, center_um, fwhm_um};
}

TableDifference table_difference(const RenderTable& a, const RenderTable& b, const DifferenceChoice& choice) {
  TableDifference out;
  find_common_range(a, b, out);
  out.differs = what_differs(a, b);
  out.height_m = common_height(a, b, choice);
  const std::vector<DifferenceBand> bands = bands_within(choice.bands, out.first_um, out.last_um);
  out.wavelength_um = merged_grid(wavelengths(a), wavelengths(b), out.first_um, out.last_um, bands);

  const std::set<std::string> has_a = quantities_of(a), has_b = quantities_of(b);
  std::set_difference(has_a.begin(), has_a.end(), has_b.begin(), has_b.end(), std::back_inserter(out.only_a));
  std::set_difference(has_b.begin(), has_b.end(), has_a.begin(), has_a.end(), std::back_inserter(out.only_b));

  QuantityReader reader(a, b, bands, choice.relative_azimuth_deg, out);
  read_quantities(reader, out.height_m, choice);
  if (out.quantities.empty())
    throw base::Error(base::Fault::input,
                      "the tables have no row in common that can be compared (raycube atmos info lists rows)");
  return out;
}

}  // namespace raycube::atmos
