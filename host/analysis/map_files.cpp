#include "host/analysis/map_files.h"

#include <array>
#include <cstdio>
#include <mutex>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/gdal_library.h"
#include "host/products/coverage.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;
using base::gdal;

/// Colours of classes, far from one another: Okabe & Ito's eight, then darker.
std::array<int, 3> class_colour(std::size_t number) {
  constexpr int colours[8][3] = {{230, 159, 0}, {86, 180, 233}, {0, 158, 115},   {240, 228, 66},
                                 {0, 114, 178}, {213, 94, 0},   {204, 121, 167}, {153, 153, 153}};
  if (number == 0) return {0, 0, 0};
  const auto& colour = colours[(number - 1) % 8];
  const int darker = 1 + static_cast<int>((number - 1) / 8 % 4);
  return {colour[0] / darker, colour[1] / darker, colour[2] / darker};
}

/// Where a cube lies on the map.
void place(GDALDatasetH out, const Cube& like) {
  if (like.header().map_info.empty()) return;
  const std::string file = products::find_envi_pair(like.path()).data;
  const base::GdalDataset set(gdal().GDALOpenEx(file.c_str(), GDAL_OF_RASTER, nullptr, nullptr, nullptr));
  double transform[6];
  if (!set || gdal().GDALGetGeoTransform(set.get(), transform) != CE_None) return;
  gdal().GDALSetGeoTransform(out, transform);
  if (const OGRSpatialReferenceH system = gdal().GDALGetSpatialRef(set.get())) gdal().GDALSetSpatialRef(out, system);
}

}  // namespace

products::EnviHeader header_like(const Cube& cube, const std::string& description) {
  products::EnviHeader out = cube.header();
  out.bands = 1, out.description = description, out.data_units.clear();
  out.header_offset = 0, out.interleave = products::Interleave::bsq;
  out.wavelength.clear(), out.fwhm.clear(), out.bad_bands.clear(), out.band_names.clear(), out.default_bands.clear();
  out.data_gain.clear(), out.data_offset.clear(), out.data_ignore_value.reset(), out.reflectance_scale_factor.reset();
  out.wavelength_units.clear(), out.other.clear(), out.warnings.clear();
  return out;
}

struct MapFiles::State {
  State(base::OutputSet& set, const std::string& name, products::EnviHeader like, bool of_classes)
      : classes(of_classes),
        header(std::move(like)),
        data(set.add(name + ".img")),
        text(set.add(name + ".hdr")),
        tiff(set.add(name + ".tif")),
        drawn(tiff.temporary_path() + ".tif"),
        coverage(data.final_path(), header.samples, header.lines) {
    header.interleave = products::Interleave::bsq, header.byte_order = 0, header.data_type = classes ? 12 : 5;
    data.reserve(header.data_bytes());
  }
  ~State() {
    geo.reset();
    std::remove(drawn.c_str());
  }

  std::size_t bands() const { return static_cast<std::size_t>(header.bands); }

  template <class Number>
  void write_band(const Pixels& where, std::size_t band, const std::vector<double>& values) {
    std::vector<Number> row(where.count());
    for (std::size_t p = 0; p < row.size(); ++p) row[p] = static_cast<Number>(values[p * bands() + band]);
    const auto line = band * static_cast<std::uint64_t>(header.lines) + static_cast<std::uint64_t>(where.first_line);
    data.write_at(line * static_cast<std::uint64_t>(header.samples) * sizeof(Number), row.data(),
                  row.size() * sizeof(Number));
  }

  /// The GeoTIFF, uncompressed, so that lines may come in any order.
  void begin_tiff(const Cube& like) {
    const GDALDriverH driver = gdal().GDALGetDriverByName("GTiff");
    const char* options[] = {"INTERLEAVE=BAND", "BIGTIFF=IF_SAFER", nullptr};
    if (driver)
      geo.reset(gdal().GDALCreate(driver, drawn.c_str(), static_cast<int>(like.samples()),
                                  static_cast<int>(like.lines()), static_cast<int>(bands()),
                                  classes ? GDT_UInt16 : GDT_Float64, const_cast<char**>(options)));
    if (!geo) throw Error(Fault::environment, tiff.final_path() + ": GDAL cannot begin it");
    place(geo.get(), like);
  }

  bool classes;
  products::EnviHeader header;
  base::OutputFile &data, &text, &tiff;
  std::string drawn;  ///< GDAL writes by name; its bytes then go where an unfinished file is never seen
  products::Coverage coverage;
  base::GdalDataset geo;
  std::mutex alone;
};

MapFiles::MapFiles(std::unique_ptr<State> state) : state_(std::move(state)) {}
MapFiles::~MapFiles() = default;
MapFiles::MapFiles(MapFiles&&) noexcept = default;

MapFiles::MapFiles(base::OutputSet& set, const std::string& name, const Cube& like,
                   const std::vector<std::string>& layers, const std::string& description) {
  products::EnviHeader header = header_like(like, description);
  header.bands = static_cast<std::int64_t>(layers.size()), header.band_names = layers;
  state_ = std::make_unique<State>(set, name, std::move(header), false);
  state_->begin_tiff(like);
  for (std::size_t b = 0; b < layers.size(); ++b)
    gdal().GDALSetDescription(gdal().GDALGetRasterBand(state_->geo.get(), static_cast<int>(b) + 1), layers[b].c_str());
}

MapFiles MapFiles::of_classes(base::OutputSet& set, const std::string& name, const Cube& like,
                              const std::vector<std::string>& classes, const std::string& description) {
  products::EnviHeader header = header_like(like, description);
  header.file_type = "ENVI Classification", header.band_names = {"class"};
  std::string names = "{none", lookup = "{0, 0, 0";
  const base::GdalOwned<&base::Gdal::GDALDestroyColorTable> colours(gdal().GDALCreateColorTable(GPI_RGB));
  for (std::size_t k = 0; k < classes.size(); ++k) {
    const auto [r, g, b] = class_colour(k + 1);
    std::string text = classes[k];
    for (char& c : text)
      if (c == ',' || c == '{' || c == '}' || c == '\n') c = ' ';
    names += ", " + text, lookup += fmt::format(", {}, {}, {}", r, g, b);
    const GDALColorEntry entry = {static_cast<short>(r), static_cast<short>(g), static_cast<short>(b), 255};
    gdal().GDALSetColorEntry(colours.get(), static_cast<int>(k) + 1, &entry);
  }
  header.other["classes"] = std::to_string(classes.size() + 1);
  header.other["class names"] = names + "}", header.other["class lookup"] = lookup + "}";
  MapFiles out(std::make_unique<State>(set, name, std::move(header), true));
  out.state_->begin_tiff(like);
  gdal().GDALSetRasterColorTable(gdal().GDALGetRasterBand(out.state_->geo.get(), 1), colours.get());
  return out;
}

void MapFiles::write(const Pixels& where, const std::vector<double>& values) {
  State& s = *state_;
  for (std::size_t b = 0; b < s.bands(); ++b)
    s.classes ? s.write_band<std::uint16_t>(where, b, values) : s.write_band<double>(where, b, values);
  const std::lock_guard lock(s.alone);
  s.coverage.add({where.first_line, where.lines, 0, where.samples});
  const auto pixel = static_cast<GSpacing>(s.bands() * sizeof(double)), line = pixel * where.samples;
  const int wide = static_cast<int>(where.samples), high = static_cast<int>(where.lines);
  if (gdal().GDALDatasetRasterIOEx(s.geo.get(), GF_Write, 0, static_cast<int>(where.first_line), wide, high,
                                   const_cast<double*>(values.data()), wide, high, GDT_Float64,
                                   static_cast<int>(s.bands()), nullptr, pixel, line, sizeof(double),
                                   nullptr) != CE_None)
    throw Error(Fault::environment, s.tiff.final_path() + ": GDAL could not write it; is the disk full?");
}

void MapFiles::finish() {
  state_->coverage.require_whole();
  state_->text.append(products::envi_header_text(state_->header));
  state_->geo.reset();
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(state_->drawn.c_str(), "rb"), std::fclose);
  if (!in) throw Error(Fault::environment, state_->tiff.final_path() + ": GDAL wrote nothing");
  std::vector<char> buffer(std::size_t{1} << 20);
  for (std::size_t bytes; (bytes = std::fread(buffer.data(), 1, buffer.size(), in.get())) > 0;)
    state_->tiff.append(buffer.data(), bytes);
}

}  // namespace raycube::analysis
