#include "scene_compiler/raster.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "host/base/available_memory.h"
#include "host/base/gdal_library.h"
#include "host/base/gdal_open.h"
#include "host/base/image_orientation.h"
#include "host/base/limited_child.h"
#include "host/base/memory.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::gdal;
using base::GdalDataset;
using base::GdalSpatialReference;
using base::Problems;
using base::QuietGdal;
using base::Where;

// What reading may take: GDAL needs some 10 ns a pixel of the 2^28 that are read at most, whatever a file's
// bytes unpack to.
constexpr double kRasterBase_s = 28, kRasterPerByte_s = 4e-6;
constexpr std::uint64_t kMemory_bytes = 6ull << 30;
constexpr int kPiece_values = 1 << 20;

std::string gdal_message() {
  const std::string text = base::gdal_message();
  return text.empty() ? "no message" : text;
}

/// Fills in a copy in memory: the file stays as it is.
bool interpolate(std::vector<double>& values, const std::vector<bool>& valid, int columns, int rows) {
  const GDALDriverH driver = gdal().GDALGetDriverByName("MEM");
  const GdalDataset copy(gdal().GDALCreate(driver, "", columns, rows, 1, GDT_Float64, nullptr));
  const GdalDataset mask(gdal().GDALCreate(driver, "", columns, rows, 1, GDT_Byte, nullptr));
  if (!copy || !mask) return false;
  std::vector<unsigned char> bytes(valid.size());
  for (std::size_t i = 0; i < valid.size(); ++i) bytes[i] = valid[i] ? 255 : 0;
  const GDALRasterBandH band = gdal().GDALGetRasterBand(copy.get(), 1),
                        mask_band = gdal().GDALGetRasterBand(mask.get(), 1);
  if (gdal().GDALRasterIO(band, GF_Write, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) !=
          CE_None ||
      gdal().GDALRasterIO(mask_band, GF_Write, 0, 0, columns, rows, bytes.data(), columns, rows, GDT_Byte, 0, 0) !=
          CE_None)
    return false;
  const double reach = std::hypot(columns, rows);
  return gdal().GDALFillNodata(band, mask_band, reach, 0, 0, nullptr, nullptr, nullptr) == CE_None &&
         gdal().GDALRasterIO(band, GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0) ==
             CE_None;
}

/// What the child found before any sample, as it hands it back.
struct Opened {
  int columns = 0, rows = 0, band_count = 0;
  bool georeferenced = false;
  std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
};

void send(base::Parcel& parcel, const ReferenceSystem& system) {
  for (const std::string* text : {&system.wkt, &system.name, &system.height_name}) parcel.text(*text);
  parcel.value(system.epsg), parcel.value(system.geographic);
  parcel.value(system.unit_m), parcel.value(system.height_unit_m);
}
ReferenceSystem take_system(base::Unpacked& read) {
  ReferenceSystem out;
  for (std::string* text : {&out.wkt, &out.name, &out.height_name}) *text = read.text();
  out.epsg = read.value<int>(), out.geographic = read.value<bool>();
  out.unit_m = read.value<double>(), out.height_unit_m = read.value<double>();
  return out;
}

void send(base::Parcel& parcel, const base::GdalBand& band) {
  for (const std::string* text : {&band.unit, &band.mask}) parcel.text(*text);
  for (const double value : {band.scale, band.offset, band.no_data, band.most}) parcel.value(value);
  parcel.value(band.palette), parcel.value(band.signed_bytes);
}
base::GdalBand take_declaration(base::Unpacked& read) {
  base::GdalBand out;
  for (std::string* text : {&out.unit, &out.mask}) *text = read.text();
  for (double* value : {&out.scale, &out.offset, &out.no_data, &out.most}) *value = read.value<double>();
  out.palette = read.value<bool>(), out.signed_bytes = read.value<bool>();
  return out;
}

constexpr double kMostPixels = 1 << 28;
/// Of a pixel: as the child hands it over, its value, and what is known of it.
constexpr double kPixel_bytes = 19;

double pixels_of(const Opened& opened, int count) { return double(opened.columns) * opened.rows * std::max(count, 1); }
bool has_bands(const Opened& opened, int first_band, int count) {
  return count >= 1 && first_band + count - 1 <= opened.band_count;
}

/// In the child: GDAL's word on the file (empty: it was opened), what it is, then for each band asked for what the file
/// declares, and by pieces GDAL's word (empty: it could be read), values and what is known of each.
void read_by_gdal(const std::string& file, int first_band, int count, double most_pixels, base::Parcel& parcel) {
  const base::OpenedByGdal found = base::open_by_gdal(file);
  const GdalDataset& dataset = found.set;
  parcel.text(found.wrong);
  if (!dataset) return;
  parcel.value(found.told.size());
  for (const std::string& told : found.told) parcel.text(told);
  const QuietGdal quiet;
  Opened opened;
  opened.columns = gdal().GDALGetRasterXSize(dataset.get()), opened.rows = gdal().GDALGetRasterYSize(dataset.get());
  opened.band_count = gdal().GDALGetRasterCount(dataset.get());
  opened.georeferenced = gdal().GDALGetGeoTransform(dataset.get(), opened.transform.data()) == CE_None;
  parcel.value(opened);
  send(parcel, describe_system(gdal().GDALGetSpatialRef(dataset.get())));
  if (count == 0) count = opened.band_count - first_band + 1;
  if (pixels_of(opened, count) > most_pixels || !has_bands(opened, first_band, count)) return;
  std::vector<double> values;
  std::vector<base::Pixel> known;
  for (int i = 0; i < count; ++i) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(dataset.get(), first_band + i);
    const base::GdalBand declared = base::describe_band(band);
    send(parcel, declared);
    int block_columns = 0, block_rows = 1;
    gdal().GDALGetBlockSize(band, &block_columns, &block_rows);
    // Whole rows of blocks at a time.
    const int step = std::clamp(kPiece_values / std::max(opened.columns, 1) / block_rows * block_rows,
                                std::min(block_rows, opened.rows), opened.rows);
    for (int row = 0; row < opened.rows; row += step) {
      const bool read = base::read_rows(band, declared, row, std::min(step, opened.rows - row), values, known);
      parcel.text(read ? "" : gdal_message());
      if (!read) return;
      parcel.list(values.data(), values.size());
      parcel.list(known.data(), known.size());
    }
  }
}

/// Takes a band's values as read_by_gdal() sends them; GDAL's word when they end early.
std::string take_band(base::Unpacked& read, std::vector<double>& values, std::vector<base::Pixel>& known,
                      std::size_t pixels) {
  values.reserve(pixels), known.reserve(pixels);
  while (values.size() < pixels) {
    std::string said = read.text();
    if (!said.empty()) return said;
    const auto piece = read.list<double>();
    const auto with = read.list<base::Pixel>();
    values.insert(values.end(), piece.begin(), piece.end());
    known.insert(known.end(), with.begin(), with.end());
  }
  return "";
}

/// Of a raster that is too large: by how much, and for what.
void report_size(const Raster& raster, int count, double pixels, double most_pixels,
                 const base::AvailableMemory& available, Problems& problems) {
  const std::string found = std::to_string(raster.columns) + " x " + std::to_string(raster.rows) + " pixels" +
                            (count > 1 ? " of " + std::to_string(count) + " bands" : "");
  if (pixels > std::min(kMostPixels, most_pixels)) {
    const double most = std::min(kMostPixels, most_pixels);
    const std::string limit =
        count > 1 ? number_text(std::floor(most / count)) + " pixels in each of " + std::to_string(count) + " bands"
                  : "2^" + std::to_string(static_cast<int>(std::log2(most))) + " pixels";
    problems.add({raster.file, 0, 0, ""}, "raster is too large", found,
                 "at most " + limit + "; cut it with gdal_translate -projwin, or make it coarser with -outsize");
    return;
  }
  problems.add({raster.file, 0, 0, ""}, "the raster needs more memory than there is",
               found + ": about " + base::format_bytes(static_cast<std::uint64_t>(pixels * kPixel_bytes)) + ", of " +
                   available.text(),
               "cut it with gdal_translate -projwin, or make it coarser with -outsize");
}

/// Told, since an earlier version took the numbers of the file: "scale 0.1 and offset 0".
void tell_of_scale(const Raster& raster, int first_band, Problems& problems) {
  std::size_t scaled = 0, first = 0;
  for (std::size_t i = raster.declared.size(); i-- > 0;)
    if (raster.declared[i].scaled()) ++scaled, first = i;
  if (scaled == 0) return;
  const base::GdalBand& band = raster.declared[first];
  problems.tell({raster.file, 0, 0, "band " + std::to_string(first_band + static_cast<int>(first))},
                "its values are the file's numbers times " + number_text(band.scale) + " plus " +
                    number_text(band.offset) + ", as the file declares" +
                    (scaled > 1 ? "; so are other bands' by their own" : ""));
}

/// Pixels as they are seen, where the file says that they stand otherwise and has no place on a map.
void turn(Raster& raster, Problems& problems) {
  const int orientation = base::image_orientation(raster.file);
  if (orientation == 1) return;
  const Where where{raster.file, 0, 0, ""};
  if (raster.georeferenced) {
    problems.tell(where, "its orientation, " + base::orientation_text(orientation) +
                             ", is not applied: its map coordinates place its rows and columns");
    return;
  }
  problems.tell(where, "it is " + base::orientation_text(orientation) + ", as the file declares");
  const auto rows = static_cast<std::size_t>(raster.rows), columns = static_cast<std::size_t>(raster.columns);
  if (orientation >= 5) std::swap(raster.rows, raster.columns);
  const auto turned = [&](auto& values) {
    const auto stored = values;
    std::size_t to = 0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(raster.rows); ++row)
      for (std::size_t column = 0; column < static_cast<std::size_t>(raster.columns); ++column) {
        const base::FilePixel from = base::file_pixel(orientation, row, column, rows, columns);
        values[to++] = stored[from.row * columns + from.column];
      }
  };
  for (auto& values : raster.bands) turned(values);
  for (auto& valid : raster.valid) turned(valid);
}

}  // namespace

double white_of(const Raster& image) {
  const base::GdalBand& band = image.declared[0];
  const auto value_of = [&](double number) { return band.scale * number + band.offset; };
  if (band.most <= 65535) return band.most > 0 ? value_of(band.most) : 0;
  double most = 0;
  for (const auto& values : image.bands) most = std::max(most, *std::max_element(values.begin(), values.end()));
  for (const double white : {255.0, 65535.0})
    if (most <= value_of(white)) return value_of(white);
  return 0;
}

std::optional<Raster> read_raster(const std::string& file, int first_band, int count, NoData nodata,
                                  const Where& asked_by, Problems& problems, Transparent transparent,
                                  double most_pixels) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  base::ChildLimits limits;
  limits.cpu_s = kRasterBase_s + kRasterPerByte_s * static_cast<double>(std::filesystem::file_size(file));
  limits.memory_bytes = kMemory_bytes;
  gdal();  // loaded here, not by the child of each raster
  const base::AvailableMemory available = base::available_memory();
  const double room = static_cast<double>(available.bytes) / kPixel_bytes;
  base::Unpacked read = base::in_limited_child(limits, [&](base::Parcel& parcel) {
    read_by_gdal(file, first_band, count, std::min({kMostPixels, most_pixels, room}), parcel);
  });
  const std::string said = read.end == base::ChildEnd::done ? read.text() : "it " + read.why;
  if (!said.empty()) {
    problems.add({file, 0, 0, ""}, "GDAL cannot read the raster", said,
                 "correct or convert the file; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  for (auto told = read.value<std::size_t>(); told > 0; --told) problems.tell({file, 0, 0, ""}, read.text());
  const auto opened = read.value<Opened>();
  Raster raster;
  raster.file = file;
  raster.columns = opened.columns, raster.rows = opened.rows, raster.band_count = opened.band_count;
  raster.georeferenced = opened.georeferenced, raster.transform = opened.transform;
  raster.system = take_system(read);
  if (count == 0) count = raster.band_count - first_band + 1;
  if (const double wanted = pixels_of(opened, count); wanted > std::min({kMostPixels, most_pixels, room})) {
    report_size(raster, count, wanted, most_pixels, available, problems);
    return std::nullopt;
  }
  if (!has_bands(opened, first_band, count)) {
    problems.add(asked_by, "raster has no such band",
                 std::to_string(first_band + std::max(count, 1) - 1) + " of " + std::to_string(raster.band_count),
                 file);
    return std::nullopt;
  }
  const std::size_t pixels = static_cast<std::size_t>(raster.columns) * static_cast<std::size_t>(raster.rows);
  for (int i = 0; i < count; ++i) {
    raster.declared.push_back(take_declaration(read));
    auto& values = raster.bands.emplace_back();
    std::vector<base::Pixel> known;
    if (const std::string failed = take_band(read, values, known, pixels); !failed.empty()) {
      problems.add({file, 0, 0, "band " + std::to_string(first_band + i)}, "raster is truncated or damaged", failed,
                   "restore the file");
      return std::nullopt;
    }
    auto& valid = raster.valid.emplace_back(values.size(), true);
    bool holes = false;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const bool counts = known[k] == base::Pixel::transparent && transparent == Transparent::has_a_value;
      valid[k] = known[k] == base::Pixel::sound || counts;
      raster.transparent += counts && i == 0;
      holes = holes || !valid[k];
    }
    if (!holes || nodata == NoData::mark) continue;
    const QuietGdal quiet;
    std::vector<double> filled = values;
    // A post that no neighbour reaches keeps this number.
    for (std::size_t k = 0; k < filled.size(); ++k)
      if (!valid[k]) filled[k] = std::numeric_limits<double>::infinity();
    if (!interpolate(filled, valid, raster.columns, raster.rows)) {
      problems.add({file, 0, 0, ""}, "cannot interpolate the posts without data", gdal_message(),
                   "fill them with gdal_fillnodata.py");
      return std::nullopt;
    }
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!valid[k] && std::isfinite(filled[k])) values[k] = filled[k], valid[k] = true;
  }
  tell_of_scale(raster, first_band, problems);
  turn(raster, problems);
  return raster;
}

}  // namespace raycube::scene
