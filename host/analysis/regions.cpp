#include "host/analysis/regions.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/gdal_band.h"
#include "host/base/gdal_library.h"
#include "host/base/gdal_open.h"
#include "host/base/image_orientation.h"
#include "host/base/input_file.h"
#include "host/base/publication.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;
using base::gdal;
using base::GdalDataset;

std::string gdal_reason() {
  const std::string said = base::gdal_message();
  return said.empty() ? "" : " (" + said + ")";
}

base::OpenedByGdal open(const std::string& file, unsigned kinds) {
  base::finish_publication_around(file);
  base::refuse_other_than_plain(file);
  if (const int orientation = base::image_orientation(file); orientation != 1)
    throw Error(Fault::input,
                fmt::format("{}: it is {} by its orientation tag, in which regions are not read; write its "
                            "rows as they are to be seen and no such tag",
                            file, base::orientation_text(orientation)));
  base::OpenedByGdal out = base::open_by_gdal(file, kinds);
  if (!out.told.empty()) throw Error(Fault::input, file + ": " + out.told.front());
  return out;
}

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw Error(Fault::input, fmt::format("region \"{}\": {}", text, why));
}

bool parse(const std::string& word, double& value) {
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && code == std::errc() && end == word.data() + word.size();
}

std::string trim(const std::string& text) {
  const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// X0:X1,Y0:Y1; false: it is no such text.
bool parse_rectangle(const std::string& text, std::int64_t (&ends)[4]) {
  int at = 0;
  const char* from = text.data();
  const char* const stop = from + text.size();
  for (const char separator : {':', ',', ':', '\0'}) {
    const auto [end, code] = std::from_chars(from, stop, ends[at++]);
    if (code != std::errc()) return false;
    if (separator == '\0') return end == stop;
    if (end == stop || *end != separator) return false;
    from = end + 1;
  }
  return false;
}

Region rectangle(const std::string& name, const std::string& text, const std::int64_t (&ends)[4], const Cube& cube) {
  const auto [left, right, top, bottom] = ends;
  if (left > right || top > bottom || left < 0 || top < 0 || right >= cube.samples() || bottom >= cube.lines())
    refuse(text,
           fmt::format("{} has samples 0 to {} and lines 0 to {}", cube.path(), cube.samples() - 1, cube.lines() - 1));
  std::vector<Span> spans;
  for (std::int64_t line = top; line <= bottom; ++line) spans.push_back({line, left, right});
  return {name, std::move(spans)};
}

/// Whether a layer's name, its unit after it or not, is what is asked for.
bool is_called(const std::string& name, const std::string& layer) {
  return name == layer || name.starts_with(layer + " [") || name.starts_with(layer + " (");
}

/// Number of a band, from 1.
int band_called(GDALDatasetH set, const std::string& file, const std::string& layer) {
  if (layer.empty()) return 1;
  double number = 0;
  if (parse(layer, number) && number == std::floor(number) && number >= 1 && number <= gdal().GDALGetRasterCount(set))
    return static_cast<int>(number);
  std::string known;
  for (int b = 1; b <= gdal().GDALGetRasterCount(set); ++b) {
    std::string name = gdal().GDALGetDescription(gdal().GDALGetRasterBand(set, b));
    if (is_called(name, layer)) return b;
    if (b <= 40) known += (b > 1 ? ", " : "") + name;
  }
  throw Error(Fault::input, fmt::format("{}: has no layer \"{}\"; it has: {}", file, layer, known));
}

/// A layer of an ENVI file: scaled as cubes are, not a number where it is ignored.
std::vector<double> envi_layer(const std::string& file, const std::string& layer, std::int64_t samples,
                               std::int64_t lines) {
  const products::EnviHeader header = products::read_envi_header(products::find_envi_pair(file).header);
  std::size_t number = layer.empty() ? 1 : 0;
  double typed = 0;
  if (parse(layer, typed) && typed == std::floor(typed) && typed >= 1 && typed <= static_cast<double>(header.bands))
    number = static_cast<std::size_t>(typed);
  for (std::size_t b = 0; number == 0 && b < header.band_names.size(); ++b)
    if (is_called(header.band_names[b], layer)) number = b + 1;
  if (number == 0)
    throw Error(Fault::input,
                fmt::format("{}: has no layer \"{}\"; it has: {}", file, layer,
                            header.band_names.empty() ? fmt::format("1 to {}", header.bands)
                                                      : fmt::format("{}", fmt::join(header.band_names, ", "))));
  const Cube cube(file, {std::to_string(number), ""});
  require_same_size(cube, samples, lines, "the image");
  std::vector<double> out(cube.pixels());
  for_each_part(cube, {}, [&](std::size_t, const Pixels& pixels) {
    const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
    for (std::size_t p = 0; p < pixels.count(); ++p)
      out[first + p] = pixels.counts[p] ? *pixels.at(p) : std::numeric_limits<double>::quiet_NaN();
  });
  return out;
}

/// Whether a file is one of an ENVI pair.
bool is_envi(const std::string& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return false;
  const std::string stem = std::filesystem::path(file).replace_extension().string();
  for (const std::string& header : {file, file + ".hdr", stem + ".hdr"})
    if (header.ends_with(".hdr") && std::filesystem::exists(header, none)) return true;
  return false;
}

std::vector<double> layer_of(const base::OpenedByGdal& opened, const std::string& file, const std::string& layer,
                             std::int64_t samples, std::int64_t lines) {
  const GDALDatasetH set = opened.set.get();
  const int columns = gdal().GDALGetRasterXSize(set), rows = gdal().GDALGetRasterYSize(set);
  if (columns != samples || rows != lines)
    throw Error(Fault::input, fmt::format("{}: has {} samples x {} lines, the image {} x {}; they must be of one size",
                                          file, columns, rows, samples, lines));
  const GDALRasterBandH band = gdal().GDALGetRasterBand(set, band_called(set, file, layer));
  std::vector<double> out;
  std::vector<base::Pixel> known;
  const base::QuietGdal quiet;
  if (!base::read_rows(band, base::describe_band(opened, band), 0, rows, out, known))
    throw Error(Fault::environment, file + ": could not be read" + gdal_reason());
  for (std::size_t i = 0; i < out.size(); ++i)
    if (known[i] != base::Pixel::sound) out[i] = std::numeric_limits<double>::quiet_NaN();
  return out;
}

/// LAYER OP VALUE.
struct Condition {
  std::string left, comparison, right;
};

Condition condition_of(const std::string& text) {
  for (const char* comparison : {">=", "<=", "=", ">", "<"})
    if (const auto at = text.find(comparison); at != std::string::npos)
      return {trim(text.substr(0, at)), comparison, trim(text.substr(at + std::string(comparison).size()))};
  return {"", "=", trim(text)};
}

bool holds(double value, const std::string& comparison, double right) {
  if (comparison == ">=") return value >= right;
  if (comparison == "<=") return value <= right;
  if (comparison == ">") return value > right;
  if (comparison == "<") return value < right;
  return value == right;
}

Region of_raster(const std::string& name, const std::string& text, const base::OpenedByGdal& opened,
                 const std::string& file, const std::string& condition, const Cube& cube) {
  const Condition wanted = condition_of(condition);
  double right = 0;
  if (!condition.empty() && !parse(wanted.right, right))
    refuse(text, fmt::format("\"{}\" is no number to compare {} with", wanted.right, file));
  const std::vector<double> value = is_envi(file) ? envi_layer(file, wanted.left, cube.samples(), cube.lines())
                                                  : layer_of(opened, file, wanted.left, cube.samples(), cube.lines());
  return region_where(name, cube.samples(), cube.lines(), [&](std::int64_t line, std::int64_t sample) {
    const double here = value[static_cast<std::size_t>(line * cube.samples() + sample)];
    return condition.empty() ? here != 0 && !std::isnan(here) : holds(here, wanted.comparison, right);
  });
}

/// An empty raster on the cube's grid.
GdalDataset grid_of(const Cube& cube) {
  const GDALDriverH memory = gdal().GDALGetDriverByName("MEM");
  GdalDataset out(memory ? gdal().GDALCreate(memory, "", static_cast<int>(cube.samples()),
                                             static_cast<int>(cube.lines()), 1, GDT_Byte, nullptr)
                         : nullptr);
  if (!out) throw Error(Fault::environment, "GDAL makes no raster in memory" + gdal_reason());
  const GdalDataset like = open(products::find_envi_pair(cube.path()).data, GDAL_OF_RASTER).set;
  double transform[6] = {0, 1, 0, 0, 0, 1};
  if (like && !cube.header().map_info.empty()) {
    gdal().GDALGetGeoTransform(like.get(), transform);
    if (const OGRSpatialReferenceH system = gdal().GDALGetSpatialRef(like.get()))
      gdal().GDALSetSpatialRef(out.get(), system);
  }
  gdal().GDALSetGeoTransform(out.get(), transform);
  return out;
}

Region of_outlines(const std::string& name, const std::string& text, GDALDatasetH set, const std::string& file,
                   const std::string& condition, const Cube& cube) {
  base::OpenedByGdal grid;
  grid.set = grid_of(cube);
  const OGRLayerH layer = gdal().GDALDatasetGetLayer(set, 0);
  const OGRFeatureDefnH fields = layer ? gdal().OGR_L_GetLayerDefn(layer) : nullptr;
  if (!layer || gdal().OGR_FD_GetGeomFieldCount(fields) == 0) refuse(text, file + " has no outlines");
  if (!condition.empty()) {
    const Condition wanted = condition_of(condition);
    if (wanted.left.empty() || gdal().OGR_FD_GetFieldIndex(fields, wanted.left.c_str()) < 0)
      refuse(text, fmt::format("{} has no attribute \"{}\"; give FILE@ATTRIBUTE=TEXT", file, wanted.left));
    const std::string quoted = wanted.right.find('\'') == std::string::npos ? wanted.right : "";
    const std::string filter = fmt::format("\"{}\" {} '{}'", wanted.left, wanted.comparison, quoted);
    if (gdal().OGR_L_SetAttributeFilter(layer, filter.c_str()) != OGRERR_NONE)
      refuse(text, "its condition is not understood" + gdal_reason());
  }
  if (cube.header().map_info.empty()) gdal().OGR_GFld_SetSpatialRef(gdal().OGR_FD_GetGeomFieldDefn(fields, 0), nullptr);
  int band = 1;
  double burnt = 1;
  OGRLayerH layers[] = {layer};
  if (gdal().GDALRasterizeLayers(grid.set.get(), 1, &band, 1, layers, nullptr, nullptr, &burnt, nullptr, nullptr,
                                 nullptr) != CE_None)
    refuse(text, file + " could not be laid over the image" + gdal_reason());
  const std::vector<double> inside = layer_of(grid, file, "", cube.samples(), cube.lines());
  return region_where(name, cube.samples(), cube.lines(), [&](std::int64_t line, std::int64_t sample) {
    return inside[static_cast<std::size_t>(line * cube.samples() + sample)] != 0;
  });
}

}  // namespace

std::uint64_t Region::count() const {
  std::uint64_t out = 0;
  for (const Span& span : spans_) out += static_cast<std::uint64_t>(span.last - span.first + 1);
  return out;
}

bool Region::holds(std::int64_t line, std::int64_t sample) const {
  const auto after =
      std::upper_bound(spans_.begin(), spans_.end(), std::pair{line, sample}, [](const auto& at, auto& s) {
        return at < std::pair{s.line, s.first};
      });
  return after != spans_.begin() && std::prev(after)->line == line && std::prev(after)->last >= sample;
}

Region read_region(const std::string& text, const Cube& cube) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(text, "give NAME=WHAT, as in lawn=10:29,40:59");
  const std::string name = text.substr(0, equals), what = text.substr(equals + 1);
  std::int64_t ends[4];
  if (parse_rectangle(what, ends)) return rectangle(name, text, ends, cube);
  const auto at = std::filesystem::exists(what) ? std::string::npos : what.rfind('@');
  const std::string file = what.substr(0, at), condition = at == std::string::npos ? "" : what.substr(at + 1);
  const base::OpenedByGdal opened =
      open(is_envi(file) ? products::find_envi_pair(file).data : file, GDAL_OF_RASTER | GDAL_OF_VECTOR);
  const GDALDatasetH set = opened.set.get();
  if (!set && !std::filesystem::exists(file)) refuse(text, file + " is no X0:X1,Y0:Y1, and no such file is there");
  if (!set) refuse(text, file + " is neither a raster nor a file of outlines that GDAL reads (" + opened.wrong + ")");
  Region out = gdal().GDALGetRasterCount(set) > 0 ? of_raster(name, text, opened, file, condition, cube)
                                                  : of_outlines(name, text, set, file, condition, cube);
  if (out.spans().empty()) refuse(text, "no pixel is in it");
  return out;
}

std::vector<double> read_layer(const std::string& file, const std::string& layer, std::int64_t samples,
                               std::int64_t lines) {
  if (is_envi(file)) return envi_layer(file, layer, samples, lines);
  const base::OpenedByGdal opened = open(file, GDAL_OF_RASTER);
  if (!opened.set) throw Error(Fault::input, file + ": is no raster that can be read (" + opened.wrong + ")");
  return layer_of(opened, file, layer, samples, lines);
}

std::vector<Region> read_classes(const std::string& file, const Cube& cube) {
  const base::OpenedByGdal opened = open(file, GDAL_OF_RASTER);
  const GDALDatasetH set = opened.set.get();
  if (!set) throw Error(Fault::input, file + ": is no raster that can be read (" + opened.wrong + ")");
  const std::vector<double> value = layer_of(opened, file, "", cube.samples(), cube.lines());
  std::map<double, bool> values;
  for (const double v : value) {
    if (std::isfinite(v) && v != 0) values[v] = true;
    if (values.size() > 10000)
      throw Error(Fault::input, file + ": has more than 10000 different values; it is no raster of classes");
  }
  if (values.empty()) throw Error(Fault::input, file + ": no pixel has a class (all are 0)");
  char** const names = gdal().GDALGetRasterCategoryNames(gdal().GDALGetRasterBand(set, 1));
  std::vector<Region> out;
  for (const auto& [number, unused] : values) {
    const bool named = names && number == std::floor(number) && number > 0 && number < gdal().CSLCount(names);
    out.push_back(region_where(named ? names[static_cast<int>(number)] : fmt::format("{:g}", number), cube.samples(),
                               cube.lines(), [&, n = number](std::int64_t line, std::int64_t sample) {
                                 return value[static_cast<std::size_t>(line * cube.samples() + sample)] == n;
                               }));
  }
  return out;
}

}  // namespace raycube::analysis
