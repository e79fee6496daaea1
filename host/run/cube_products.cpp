#include "host/run/cube_products.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <optional>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/base/publication.h"
#include "host/run/measured_cube.h"
#include "host/run/radiance_guard.h"
#include "host/run/spread_files.h"
#include "host/run/truth_cubes.h"
#include "host/plan/radiance_limit.h"
#include "host/products/digest.h"
#include "host/products/envi_writer.h"
#include "host/products/exr_writer.h"
#include "host/products/geolocated_vrt.h"
#include "host/products/in_order.h"
#include "host/products/map_grid.h"
#include "host/products/quicklook.h"
#include "host/products/radiance_unit.h"
#include "host/render/truth.h"
#include "host/base/units.h"

namespace raycube::run {

namespace {

constexpr std::size_t kReadBack_bytes = 4u << 20;  ///< of lines that did not come in order, at a time

/// Width of a tabulated response between its half-maximum crossings, um.
double half_width_um(const scene::Band& band) {
  if (band.fwhm_um > 0) return band.fwhm_um;
  const double half = *std::max_element(band.response.begin(), band.response.end()) / 2;
  double first = band.wavelength_um.front(), last = band.wavelength_um.back();
  for (std::size_t i = 1; i < band.response.size(); ++i) {
    const double a = band.response[i - 1], b = band.response[i];
    const auto crossing = [&] {
      return band.wavelength_um[i - 1] + (half - a) / (b - a) * (band.wavelength_um[i] - band.wavelength_um[i - 1]);
    };
    if (a < half && b >= half && first == band.wavelength_um.front()) first = crossing();
    if (a >= half && b < half) last = crossing();
  }
  return last - first;
}

products::EnviHeader base_header(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  products::EnviHeader header;
  header.samples = instrument.pixels;
  header.lines = instrument.lines;
  header.sensor_type = "raycube " + instrument.name;
  header.acquisition_time = simulation.sun.utc;
  header.sun_azimuth_deg = simulation.sun.azimuth_deg;
  header.sun_elevation_deg = 90.0 - simulation.sun.zenith_deg;
  return header;
}

products::EnviHeader cube_header(const scene::Simulation& simulation, const scene::Instrument& instrument,
                                 const std::vector<int>& shown, const std::string& units, const std::string& what) {
  products::EnviHeader header = base_header(simulation, instrument);
  header.bands = static_cast<std::int64_t>(instrument.bands.size());
  header.interleave = products::parse_interleave(instrument.interleave);
  header.description = what;
  header.data_units = units;
  double longest_um = 0;
  for (const auto& band : instrument.bands) longest_um = std::max(longest_um, band.center_um);
  const bool nanometers = longest_um < 3.0;
  header.wavelength_units = nanometers ? "Nanometers" : "Micrometers";
  const double scale = nanometers ? 1e3 : 1.0;
  for (const auto& band : instrument.bands) {
    header.wavelength.push_back(band.center_um * scale);
    header.fwhm.push_back(half_width_um(band) * scale);
    if (!band.name.empty()) header.band_names.push_back(band.name);
  }
  if (header.band_names.size() != instrument.bands.size()) header.band_names.clear();
  for (const int band : shown) header.default_bands.push_back(band + 1);
  return header;
}

/// Places of the layers the writers look at.
std::size_t layer_index(const std::vector<render::LayerName>& layers, const std::string& name) {
  for (std::size_t i = 0; i < layers.size(); ++i)
    if (layers[i].name == name) return i;
  throw base::Error(base::Fault::bug, "no truth layer is called " + name);
}

}  // namespace

std::vector<int> shown_bands(const scene::Instrument& instrument) {
  if (!instrument.quicklook_bands.empty()) return instrument.quicklook_bands;
  std::vector<double> centers;
  for (const auto& band : instrument.bands) centers.push_back(band.center_um);
  return products::default_quicklook_bands(centers);
}

void check_output_place(const std::string& folder, bool overwrite) {
  namespace fs = std::filesystem;
  std::error_code code;
  base::finish_publication(folder, base::FolderUse::write_set);
  for (const char* name : {"radiance.img", "run.json"})
    if (!overwrite && fs::exists(fs::path(folder) / name, code))
      throw base::Error(base::Fault::input, (fs::path(folder) / name).string() +
                                                ": is there already; give --overwrite to replace it, or another -o");
  fs::path place = fs::absolute(folder);
  while (!fs::exists(place, code) && place.has_relative_path()) place = place.parent_path();
  if (!fs::is_directory(place, code))
    throw base::Error(base::Fault::environment,
                      folder + ": the folder cannot be made: " + place.string() + " is a file; choose another -o");
  if (::access(place.c_str(), W_OK) != 0)
    throw base::Error(base::Fault::environment, folder + ": cannot be written: " + place.string() + ": " +
                                                    std::strerror(errno) +
                                                    "; choose a folder you may write to with -o");
}

namespace {

/// Of the image's bands, from those that were rendered.
std::vector<double> limit_of(const CameraJob& job, const std::vector<double>& rendered) {
  if (!job.cells) return rendered;
  std::vector<double> out;
  for (const sensors::BandOfCells& band : job.cells->bands) {
    out.push_back(0);
    for (const std::size_t from : band.from) out.back() = std::max(out.back(), rendered[from]);
  }
  return out;
}

}  // namespace

struct CubeProducts::State {
  State(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation_,
        const CameraJob& job_)
      : simulation(simulation_),
        instrument(job_.image()),
        plan(job_.plan),
        set(folder, if_exists),
        cells(job_.cells.get()),
        guard(instrument, limit_of(job_, plan::radiance_limit(job_.plan, simulation_.scene, job_.table))),
        layers(render::truth_layer_names(simulation_.scene, instrument)),
        shown(shown_bands(instrument)),
        missed(simulation_, instrument),
        order(instrument.pixels, instrument.lines) {
    set.hash_blocks();
    const auto& origin = simulation.scene.origin;
    const std::string where = fmt::format("scene origin: EPSG:{} easting {:.3f} m, northing {:.3f} m, height {:.3f} m",
                                          origin.epsg, origin.easting_m, origin.northing_m, origin.height_m);
    radiance.emplace(
        set, "radiance.img",
        cube_header(simulation, instrument, shown, products::kRadianceUnit,
                    "band-averaged spectral radiance at the sensor, response normalised; line 0 is the top"),
        instrument.integer_scale);
    products::EnviHeader truth_header = base_header(simulation, instrument);
    truth_header.bands = static_cast<std::int64_t>(layers.size());
    truth_header.description = "per-pixel truth; x, y, z in metres east, north and up from the " + where +
                               "; not a number where nothing was hit";
    for (const auto& layer : layers) truth_header.band_names.push_back(layer.name + " [" + layer.unit + "]");
    truth.emplace(set, "truth.img", truth_header);
    if (origin.epsg != 0) {
      location_header = base_header(simulation, instrument);
      location_header.bands = 3;
      location_header.data_type = 5;
      location_header.description = "where each pixel looks: mean hit point in EPSG:" + std::to_string(origin.epsg);
      location_header.band_names = {"easting [m]", "northing [m]", "height [m]"};
      location = &set.add("location.img");
      location->reserve(static_cast<std::uint64_t>(instrument.pixels) * static_cast<std::uint64_t>(instrument.lines) *
                        3 * sizeof(double));
      location_text = &set.add("location.hdr");
    }
    truth_cubes.emplace(set, simulation, job_, [this](const std::string& unit, const std::string& text) {
      return cube_header(simulation, instrument, shown, unit, text);
    });
    if (instrument.standard_error == scene::StandardError::bands)
      standard_error.emplace(set, "standard_error.img",
                             cube_header(simulation, instrument, shown, products::kRadianceUnit,
                                         "standard error of the radiance by its samples; not a number: not known"));
    if (instrument.write_png) quicklook.emplace(instrument.pixels, instrument.lines, shown);
    if (instrument.write_exr) {
      products::ExrPart radiance_part{"radiance", {}}, truth_part{"truth", {}};
      const bool colour = shown.size() == 3;
      for (std::size_t i = 0; i < shown.size(); ++i)
        radiance_part.channels.push_back(colour ? std::string(1, "RGB"[i]) : "Y");
      for (const auto& layer : layers) truth_part.channels.push_back(layer.name);
      exr.emplace(set.add("preview.exr"), instrument.pixels, instrument.lines, std::vector{radiance_part, truth_part},
                  std::map<std::string, std::string>{
                      {"units", "radiance W m-2 sr-1 um-1; truth layers as in truth.hdr"}, {"origin", where}});
    }
  }

  /// The strip without the columns of truth per band; the arrays hold what is left where there were any.
  render::Strip bands_alone(const render::Strip& strip, std::vector<float>& radiance_values,
                            std::vector<float>& error_values) const {
    const std::size_t bands = instrument.bands.size();
    if (strip.columns == 0 || strip.columns == bands) return strip;
    const products::Piece piece = piece_of(strip);
    const auto pixels = static_cast<std::size_t>(piece.lines * piece.samples);
    const auto keep = [&](const float* from, std::vector<float>& to) -> const float* {
      if (from == nullptr) return nullptr;
      for (std::size_t p = 0; p < pixels; ++p)
        to.insert(to.end(), from + p * strip.columns, from + p * strip.columns + bands);
      return to.data();
    };
    render::Strip out = strip;
    out.columns = bands;
    out.radiance = keep(strip.radiance, radiance_values), out.band_error = keep(strip.band_error, error_values);
    return out;
  }

  products::Piece piece_of(const render::Strip& strip) const {
    return {strip.first_line, strip.lines, strip.first_sample, strip.samples > 0 ? strip.samples : instrument.pixels};
  }

  products::Strip strip_of(const render::Strip& strip, const float* values, std::size_t stride) const {
    return {strip.first_line, strip.lines, values, stride, strip.first_sample, strip.samples};
  }

  void add_location(const render::Strip& strip) {
    const products::Piece piece = piece_of(strip);
    const std::size_t pixels = static_cast<std::size_t>(piece.lines * piece.samples);
    const std::size_t x = layer_index(layers, "x_m");
    const auto& origin = simulation.scene.origin;
    std::vector<double> values;
    for (std::size_t p = 0; p < pixels; ++p) {
      const float* at = strip.truth + p * layers.size() + x;
      values.insert(values.end(), {at[0] + origin.easting_m, at[1] + origin.northing_m, at[2] + origin.height_m});
    }
    const std::size_t row = static_cast<std::size_t>(piece.samples) * 3;
    for (std::int64_t l = 0; l < piece.lines; ++l) {
      const std::int64_t first = (piece.first_line + l) * instrument.pixels + piece.first_sample;
      location->write_at(static_cast<std::uint64_t>(first) * 3 * sizeof(double),
                         values.data() + static_cast<std::size_t>(l) * row, row * sizeof(double));
    }
  }

  /// `map info` in every header when the pixels lie on a map grid; else location.img alone says where they look.
  void georeference() {
    const auto grid =
        products::find_map_grid(instrument.pixels, instrument.lines, [&](std::int64_t line, double* values) {
          const std::size_t bytes = static_cast<std::size_t>(instrument.pixels) * 3 * sizeof(double);
          location->read_at(static_cast<std::uint64_t>(line) * bytes, values, bytes);
        });
    if (!grid) return;
    std::vector<products::EnviHeader*> headers = truth_cubes->headers();
    headers.insert(headers.end(), {&location_header, &radiance->header(), &truth->header()});
    if (standard_error) headers.push_back(&standard_error->header());
    for (auto* header : headers)
      products::set_map_grid(*header, simulation.scene.origin.epsg, grid->easting_m, grid->northing_m, grid->pixel_x_m,
                             grid->pixel_y_m);
  }

  /// Of files that keep integers the radiance that did not come in order waits beside them, in a file that never gets a
  /// name.
  void keep_radiance(const render::Strip& strip) {
    if (!instrument.integer_scale) return;
    if (!floats) floats.emplace(set.folder() + "/radiance.float32");
    const products::Piece piece = piece_of(strip);
    const std::size_t row = static_cast<std::size_t>(piece.samples) * instrument.bands.size();
    for (std::int64_t l = 0; l < piece.lines; ++l)
      floats->write_at(float_offset(piece.first_line + l, piece.first_sample),
                       strip.radiance + static_cast<std::size_t>(l) * row, row * sizeof(float));
  }

  std::uint64_t float_offset(std::int64_t line, std::int64_t sample) const {
    return static_cast<std::uint64_t>(line * instrument.pixels + sample) * instrument.bands.size() * sizeof(float);
  }

  void read_radiance(std::int64_t first_line, std::int64_t lines, std::vector<float>& values) const {
    if (floats)
      floats->read_at(float_offset(first_line, 0), values.data(), values.size() * sizeof(float));
    else
      radiance->read_back(first_line, lines, values.data());
  }

  /// Whole lines, the next ones of the image: what must see them in order.
  void in_order(const render::Strip& strip) {
    const std::size_t bands = instrument.bands.size();
    const products::Strip cube{strip.first_line, strip.lines, strip.radiance, bands};
    const products::Strip truth_lines{strip.first_line, strip.lines, strip.truth, layers.size()};
    guard.add(strip.first_line, strip.lines, strip.radiance);
    missed.add(strip);
    digest.add_radiance(cube, instrument.pixels, static_cast<std::int64_t>(bands));
    if (quicklook) quicklook->add(cube);
    if (!exr) return;
    std::vector<std::size_t> all(layers.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    exr->write({{cube, {shown.begin(), shown.end()}}, {truth_lines, all}});
  }

  const scene::Simulation& simulation;
  const scene::Instrument& instrument;
  const plan::Plan& plan;
  base::OutputSet set;
  const sensors::Cells* cells;
  RadianceGuard guard;
  std::vector<render::LayerName> layers;
  std::vector<int> shown;
  products::Digest digest;
  std::optional<products::EnviWriter> radiance, truth, standard_error;
  std::optional<TruthCubes> truth_cubes;
  products::EnviHeader location_header;
  base::OutputFile* location = nullptr;
  base::OutputFile* location_text = nullptr;
  std::optional<products::Quicklook> quicklook;
  std::optional<products::ExrWriter> exr;
  MissedSamples missed;
  products::InOrder order;
  std::optional<base::OutputFile> floats;  ///< never published
};

CubeProducts::CubeProducts(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
                           const CameraJob& job)
    : state_(std::make_unique<State>(folder, if_exists, simulation, job)) {}
CubeProducts::~CubeProducts() = default;

void CubeProducts::add(const render::Strip& whole) {
  State& s = *state_;
  s.truth_cubes->write(whole);
  std::vector<float> radiance, error;
  const render::Strip strip = s.bands_alone(whole, radiance, error);
  // Hashing the strip takes as long as writing it: one does not wait for the other.
  std::future<void> looked_at;
  if (s.order.takes(s.piece_of(strip)))
    looked_at = base::beside(0, [&] { s.in_order(strip); });
  else
    s.keep_radiance(strip);
  s.radiance->write(s.strip_of(strip, strip.radiance, s.instrument.bands.size()));
  s.truth->write(s.strip_of(strip, strip.truth, s.layers.size()));
  if (s.location) s.add_location(strip);
  if (s.standard_error) s.standard_error->write(s.strip_of(strip, strip.band_error, s.instrument.bands.size()));
  if (looked_at.valid()) looked_at.get();
}

void CubeProducts::complete() {
  State& s = *state_;
  s.radiance->require_whole();
  const std::size_t bands = s.instrument.bands.size(), layers = s.layers.size(),
                    line_pixels = static_cast<std::size_t>(s.instrument.pixels);
  const std::int64_t lines_each = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(kReadBack_bytes / (line_pixels * (bands + layers) * sizeof(float))));
  std::vector<float> radiance, truth;
  s.order.rest(lines_each, [&](std::int64_t first_line, std::int64_t lines) {
    radiance.resize(static_cast<std::size_t>(lines) * line_pixels * bands);
    truth.resize(static_cast<std::size_t>(lines) * line_pixels * layers);
    s.read_radiance(first_line, lines, radiance);
    s.truth->read_back(first_line, lines, truth.data());
    s.in_order({static_cast<int>(first_line), static_cast<int>(lines), radiance.data(), truth.data()});
  });
  s.floats.reset();
}

const MissedSamples& CubeProducts::missed() const { return state_->missed; }

std::optional<std::string> CubeProducts::warning() const { return state_->guard.warning(); }

void CubeProducts::publish(products::RunRecord& record, const Services& services) {
  State& s = *state_;
  record.more_json.emplace_back("radiance_bound", s.guard.json());
  if (s.location) s.georeference();
  s.radiance->finish();
  s.truth->finish();
  s.digest.add_truth(*s.truth);
  record.digest = s.digest.hex();
  record.files = {{"radiance.img", "radiance cube, ENVI"}, {"truth.img", "truth layers, ENVI"}};
  if (s.location) {
    s.location_text->append(products::envi_header_text(s.location_header));
    record.files.emplace_back("location.img", "easting, northing, height of each pixel, ENVI");
  }
  if (s.location && !s.missed.any()) {  // GDAL takes no map from places that are not there
    s.set.add("radiance.vrt")
        .append(products::geolocated_vrt(s.radiance->header(), "radiance.img", "location.img",
                                         products::projected_wkt(s.simulation.scene.origin.epsg)));
    record.files.emplace_back("radiance.vrt", "the cube where its pixels look, for gdalwarp -geoloc");
  }
  s.truth_cubes->finish(record);
  if (s.cells) {
    for (const auto& [name, what] : add_spread_files(*s.cells, s.set)) record.files.emplace_back(name, what);
    record.more_json.emplace_back("focal_planes", spread_json(*s.cells));
  }
  if (s.instrument.detector) {
    const ReadsRadiance read = [&](std::int64_t first, std::int64_t lines, float* to) {
      s.radiance->read_back(first, lines, to);
    };
    const MeasuredCube measured =
        measure_cube(s.instrument, s.simulation.seed, read, s.radiance->header(), s.set, services);
    for (const auto& [name, what] : measured.files) record.files.emplace_back(name, what);
    if (measured.saturated > 0) record.warnings.push_back(measured.warning());
  }
  if (s.standard_error) {
    s.standard_error->finish();
    record.files.emplace_back("standard_error.img", "standard error of the radiance per band, ENVI");
  }
  if (s.exr) {
    s.exr->finish();
    record.files.emplace_back("preview.exr", "shown bands and truth, OpenEXR");
  }
  if (s.quicklook) {
    std::vector<std::string> names;
    for (const int band : s.shown) names.push_back(fmt::format("{:.4g} um", s.instrument.bands[band].center_um));
    s.quicklook->write(s.set.add("quicklook.png"), names);
    record.files.emplace_back("quicklook.png", "picture of the shown bands, 2 to 98 % stretch");
  }
  const auto& clipped = s.radiance->clipped();
  record.clipped_low = clipped.low;
  record.clipped_high = clipped.high;
  record.not_a_number = clipped.nan;
  if (clipped.low + clipped.high > 0) {
    record.warnings.push_back(
        fmt::format("{} of the values of radiance.img do not fit 16 bits at integer_scale = {:g} ({} above, {} below "
                    "0) and are cut{}",
                    clipped.low + clipped.high, *s.instrument.integer_scale, clipped.high, clipped.low,
                    clipped.high > 0 ? fmt::format("; {:.3g} would hold them", 65535 / clipped.largest) : ""));
    services.log.warning(s.instrument.name + ": " + record.warnings.back());
  }
  products::publish_run(s.set, record);
}

}  // namespace raycube::run
