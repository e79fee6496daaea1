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
  double number_bytes = 0;  ///< of one pixel in all bands that are asked for
  int with_flags = 0;       ///< bands that may have pixels without a value
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

double pixels_of(const Opened& opened, int count) { return double(opened.columns) * opened.rows * std::max(count, 1); }

/// What reading takes at its peak: of a pixel in each band its number, as the child hands it over and as it is held,
/// with what is known of it; thereafter what is held and what the caller makes of it.
double reading_bytes(const Opened& opened, int count, const RasterRequest& request) {
  constexpr double kFilling_bytes = 20;  // of a band whose gaps are filled: the values twice, and GDAL's copies
  const double held = opened.number_bytes + 0.125 * std::max(count, 1);
  const double flags = opened.with_flags > 0 ? opened.with_flags + 1 : 0;  // here of one band at a time
  const double filling = request.nodata == NoData::interpolate ? kFilling_bytes : 0;
  return pixels_of(opened, 1) * (held + std::max(opened.number_bytes + flags + filling, request.made_bytes));
}

bool has_bands(const Opened& opened, int first_band, int count) {
  return count >= 1 && first_band + count - 1 <= opened.band_count;
}

/// The type of a band's numbers; double where it is none of those that they are held in.
NumberType type_of(GDALRasterBandH band, const base::GdalBand& declared) {
  switch (gdal().GDALGetRasterDataType(band)) {
    case GDT_Byte:
      return declared.signed_bytes ? NumberType::i8 : NumberType::u8;
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 7, 0)
    case GDT_Int8:
      return NumberType::i8;
#endif
    case GDT_UInt16:
      return NumberType::u16;
    case GDT_Int16:
      return NumberType::i16;
    case GDT_UInt32:
      return NumberType::u32;
    case GDT_Int32:
      return NumberType::i32;
    case GDT_Float32:
      return NumberType::f32;
    default:
      return NumberType::f64;
  }
}

/// In the child: a band's type, then its numbers by pieces; false when they end early.
bool send_band(GDALRasterBandH band, const base::GdalBand& declared, NumberType type, base::Parcel& parcel) {
  const int columns = gdal().GDALGetRasterBandXSize(band), rows = gdal().GDALGetRasterBandYSize(band);
  send(parcel, declared), parcel.value(type);
  int block_columns = 0, block_rows = 1;
  gdal().GDALGetBlockSize(band, &block_columns, &block_rows);
  // Whole rows of blocks at a time.
  const int step =
      std::clamp(kPiece_values / std::max(columns, 1) / block_rows * block_rows, std::min(block_rows, rows), rows);
  std::vector<double> numbers;
  std::vector<base::Pixel> known;
  for (int row = 0; row < rows; row += step) {
    const bool read = base::read_numbers(band, declared, row, std::min(step, rows - row), numbers, known);
    parcel.text(read ? "" : gdal_message());
    if (!read) return false;
    const PackedNumbers piece = packed(numbers, type);
    const bool sound = std::all_of(known.begin(), known.end(), [](base::Pixel p) { return p == base::Pixel::sound; });
    parcel.value(piece.type), parcel.list(piece.bytes.data(), piece.bytes.size());
    parcel.list(known.data(), sound ? 0 : known.size());
  }
  return true;
}

/// In the child: GDAL's word on the file (empty: it was opened), what it is, then for each band asked for what the file
/// declares and the type of its numbers, and by pieces GDAL's word (empty: it could be read), the numbers and, where
/// not all are sound, what is known of each.
void read_by_gdal(const std::string& file, const RasterRequest& request, double room_bytes, base::Parcel& parcel) {
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
  const int count = request.count == 0 ? opened.band_count - request.first_band + 1 : request.count;
  const bool known_bands = has_bands(opened, request.first_band, count);
  std::vector<base::GdalBand> declared;
  std::vector<NumberType> types;
  for (int i = 0; known_bands && i < count; ++i) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(dataset.get(), request.first_band + i);
    declared.push_back(base::describe_band(found, band));
    types.push_back(type_of(band, declared.back()));
    opened.number_bytes += static_cast<double>(type_bytes(types.back()));
    opened.with_flags += !declared.back().mask.empty() || types.back() >= NumberType::f32;
  }
  parcel.value(opened);
  send(parcel, describe_system(gdal().GDALGetSpatialRef(dataset.get())));
  if (!known_bands || pixels_of(opened, count) > request.most_pixels ||
      reading_bytes(opened, count, request) > room_bytes)
    return;
  for (int i = 0; i < count; ++i)
    if (const auto k = static_cast<std::size_t>(i);
        !send_band(gdal().GDALGetRasterBand(dataset.get(), request.first_band + i), declared[k], types[k], parcel))
      return;
}

/// Takes a band's numbers as send_band() sends them, and what is known of each (nothing: all are sound); GDAL's word
/// when they end early.
std::string take_band(base::Unpacked& read, std::size_t pixels, const base::GdalBand& declared, BandValues& values,
                      std::vector<base::Pixel>& known) {
  const auto type = read.value<NumberType>();
  values = BandValues(declared.scale, declared.offset, type, pixels);
  while (values.size() < pixels) {
    std::string said = read.text();
    if (!said.empty()) return said;
    PackedNumbers piece{read.value<NumberType>(), {}};
    const std::size_t before = values.size();
    piece.bytes = read.list<unsigned char>();
    values.append(piece);
    if (const auto with = read.list<base::Pixel>(); !with.empty()) {
      known.resize(pixels, base::Pixel::sound);
      std::copy(with.begin(), with.end(), known.begin() + static_cast<std::ptrdiff_t>(before));
    }
  }
  return "";
}

/// Of a raster that is too large: by how much, and for what.
void report_size(const Raster& raster, int count, double pixels, double most_pixels, double bytes,
                 const base::AvailableMemory& available, Problems& problems) {
  const std::string found = std::to_string(raster.columns) + " x " + std::to_string(raster.rows) + " pixels" +
                            (count > 1 ? " of " + std::to_string(count) + " bands" : "");
  if (pixels > most_pixels) {
    const std::string limit = count > 1 ? number_text(std::floor(most_pixels / count)) + " pixels in each of " +
                                              std::to_string(count) + " bands"
                                        : "2^" + std::to_string(static_cast<int>(std::log2(most_pixels))) + " pixels";
    problems.add({raster.file, 0, 0, ""}, "raster is too large", found,
                 "at most " + limit + "; cut it with gdal_translate -projwin, or make it coarser with -outsize");
    return;
  }
  problems.add({raster.file, 0, 0, ""}, "the raster needs more memory than there is",
               found + ": about " + base::format_bytes(static_cast<std::uint64_t>(bytes)) + ", of " + available.text(),
               "cut it with gdal_translate -projwin, or make it coarser with -outsize");
}

/// Fills the posts of a band that are not valid by their neighbours; false where GDAL cannot.
bool fill_gaps(BandValues& values, std::vector<bool>& valid, int columns, int rows) {
  std::vector<double> filled(values.size());
  // A post that no neighbour reaches keeps this number.
  for (std::size_t k = 0; k < filled.size(); ++k)
    filled[k] = valid[k] ? values[k] : std::numeric_limits<double>::infinity();
  if (!interpolate(filled, valid, columns, rows)) return false;
  for (std::size_t k = 0; k < filled.size(); ++k)
    if (!valid[k] && std::isfinite(filled[k]))
      valid[k] = true;
    else
      filled[k] = values[k];
  values = BandValues(filled);
  return true;
}

/// The next band as it comes; false after reporting.
bool add_band(base::Unpacked& read, const RasterRequest& request, int number, Raster& raster, Problems& problems) {
  const std::size_t pixels = static_cast<std::size_t>(raster.columns) * static_cast<std::size_t>(raster.rows);
  const bool first = raster.bands.empty();
  raster.declared.push_back(take_declaration(read));
  BandValues& values = raster.bands.emplace_back();
  std::vector<base::Pixel> known;
  if (const std::string failed = take_band(read, pixels, raster.declared.back(), values, known); !failed.empty()) {
    problems.add({raster.file, 0, 0, "band " + std::to_string(number)}, "raster is truncated or damaged", failed,
                 "restore the file");
    return false;
  }
  std::vector<bool>& valid = raster.valid.emplace_back(pixels, true);
  bool holes = false;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const bool counts = known[k] == base::Pixel::transparent && request.transparent == Transparent::has_a_value;
    valid[k] = known[k] == base::Pixel::sound || counts;
    raster.transparent += counts && first;
    holes = holes || !valid[k];
  }
  if (!holes || request.nodata == NoData::mark) return true;
  const QuietGdal quiet;
  if (fill_gaps(values, valid, raster.columns, raster.rows)) return true;
  problems.add({raster.file, 0, 0, ""}, "cannot interpolate the posts without data", gdal_message(),
               "fill them with gdal_fillnodata.py");
  return false;
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
  const auto width = static_cast<std::size_t>(raster.columns);
  const auto stored_at = [&](std::size_t i) {
    const base::FilePixel from = base::file_pixel(orientation, i / width, i % width, rows, columns);
    return from.row * columns + from.column;
  };
  for (BandValues& values : raster.bands) values.reorder(stored_at);
  for (std::vector<bool>& valid : raster.valid) {
    const std::vector<bool> stored = valid;
    for (std::size_t i = 0; i < valid.size(); ++i) valid[i] = stored[stored_at(i)];
  }
}

}  // namespace

double white_of(const Raster& image) {
  const base::GdalBand& band = image.declared[0];
  const auto value_of = [&](double number) { return band.scale * number + band.offset; };
  if (band.most <= 65535) return band.most > 0 ? value_of(band.most) : 0;
  double most = 0;
  for (const BandValues& values : image.bands) most = std::max(most, values.least_and_most().second);
  for (const double white : {255.0, 65535.0})
    if (most <= value_of(white)) return value_of(white);
  return 0;
}

std::optional<Raster> read_raster(const std::string& file, const RasterRequest& request, const Where& asked_by,
                                  Problems& problems) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  base::ChildLimits limits;
  limits.cpu_s = kRasterBase_s + kRasterPerByte_s * static_cast<double>(std::filesystem::file_size(file));
  limits.memory_bytes = kMemory_bytes;
  gdal();  // loaded here, not by the child of each raster
  const base::AvailableMemory available = base::available_memory();
  const auto room_bytes = static_cast<double>(available.bytes);
  base::Unpacked read =
      base::in_limited_child(limits, [&](base::Parcel& parcel) { read_by_gdal(file, request, room_bytes, parcel); });
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
  const int count = request.count == 0 ? raster.band_count - request.first_band + 1 : request.count;
  const double pixels = pixels_of(opened, count), bytes = reading_bytes(opened, count, request);
  if (pixels > request.most_pixels || bytes > room_bytes) {
    report_size(raster, count, pixels, request.most_pixels, bytes, available, problems);
    return std::nullopt;
  }
  if (!has_bands(opened, request.first_band, count)) {
    problems.add(
        asked_by, "raster has no such band",
        std::to_string(request.first_band + std::max(count, 1) - 1) + " of " + std::to_string(raster.band_count), file);
    return std::nullopt;
  }
  for (int i = 0; i < count; ++i)
    if (!add_band(read, request, request.first_band + i, raster, problems)) return std::nullopt;
  tell_of_scale(raster, request.first_band, problems);
  turn(raster, problems);
  return raster;
}

}  // namespace raycube::scene
