#include "host/analysis/orthorectify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "host/analysis/impossible_places.h"
#include "host/base/error.h"
#include "host/base/gdal_library.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/base/text.h"
#include "host/products/envi_reader.h"
#include "host/products/envi_writer.h"
#include "host/products/geolocated_vrt.h"
#include "host/products/map_grid.h"

namespace raycube::analysis {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::Fault;
using base::gdal;
using base::GdalDataset;

[[noreturn]] void failed(const std::string& path, const std::string& what) {
  const std::string reason = base::gdal_message();
  throw Error(Fault::input, path + ": " + what + (reason.empty() ? "" : " (GDAL: " + reason + ")"));
}

/// Places of an image's pixels: the file, and the system they are in.
struct Places {
  std::string file;
  int epsg = 0;
};

Places places_of(const std::string& image, const products::EnviHeader& header) {
  const fs::path beside = fs::absolute(image).parent_path() / "location.img";
  if (!fs::exists(beside))
    throw Error(Fault::input, image +
                                  ": there is no location.img beside it, which says where pixels look; render with "
                                  "scene.origin = { epsg = ... }");
  const auto location = products::read_envi_header(products::find_envi_pair(beside.string()).header);
  if (location.samples != header.samples || location.lines != header.lines)
    throw Error(Fault::input, fmt::format("{}: has {} x {} pixels, location.img beside it {} x {}; both must be of one "
                                          "render",
                                          image, header.samples, header.lines, location.samples, location.lines));
  const std::string mark = "EPSG:";
  const std::size_t at = location.description.find(mark);
  const int epsg = at == std::string::npos ? 0 : std::atoi(location.description.c_str() + at + mark.size());
  if (epsg <= 0)
    throw Error(Fault::input, beside.string() + ": its header names no EPSG system; render again with this raycube");
  // GDAL makes no map of places that are no numbers.
  const products::EnviReader reader(beside.string());
  if (reader.values_per_pixel() < 2)
    throw Error(Fault::input, fmt::format("{}: has {} bands, and easting and northing are wanted; render again",
                                          beside.string(), location.bands));
  const auto places = [&](std::int64_t l, std::vector<std::array<double, 2>>& out) {
    const std::vector<double> line = reader.read_lines(l, 1);
    out.clear();
    for (std::size_t i = 0; i < line.size(); i += reader.values_per_pixel()) out.push_back({line[i], line[i + 1]});
  };
  refuse_impossible_places(beside.string(), location.lines, places);
  std::int64_t past = 0;
  std::vector<std::array<double, 2>> line;
  for (std::int64_t l = 0; l < location.lines; ++l) {
    places(l, line);
    for (const auto& place : line) past += !std::isfinite(place[0]) || !std::isfinite(place[1]);
  }
  if (past > 0)
    throw Error(Fault::input,
                fmt::format("{}: {} past the ground and so no place on a map; make the "
                            "ground larger, or the image smaller",
                            image, base::counted(past, "of its pixels has a view", "of its pixels have a view")));
  return {beside.string(), epsg};
}

/// The image as GDAL's, by the virtual raster that says where its pixels lie.
GdalDataset placed(const OrthoRequest& request, const std::string& vrt) {
  GdalDataset out(gdal().GDALOpen(vrt.c_str(), GA_ReadOnly));
  if (!out) failed(request.image, "cannot be opened for the map");
  return out;
}

/// It on the map, made when that is read; `source` must outlive it.
GdalDataset warped(const OrthoRequest& request, const GdalDataset& source, const std::optional<double>& no_data) {
  std::vector<std::string> words = {"-geoloc",
                                    "-of",
                                    "VRT",
                                    "-ot",
                                    "Float32",
                                    "-wt",
                                    "Float32",
                                    "-dstnodata",
                                    "nan",
                                    "-r",
                                    request.resampling == "nearest" ? "near" : request.resampling};
  if (no_data) words.insert(words.end(), {"-srcnodata", fmt::format("{:.17g}", *no_data)});
  if (request.pixel_m) {
    const std::string pixel = fmt::format("{:.17g}", *request.pixel_m);
    words.insert(words.end(), {"-tr", pixel, pixel});
  }
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const base::GdalOwned<&base::Gdal::GDALWarpAppOptionsFree, GDALWarpAppOptions> options(
      gdal().GDALWarpAppOptionsNew(arguments.data(), nullptr));
  GDALDatasetH from = source.get();
  int wrong_use = 0;
  GdalDataset out(gdal().GDALWarp("", nullptr, 1, &from, options.get(), &wrong_use));
  if (!out) failed(request.image, "cannot be put on a map");
  return out;
}

/// A map that takes a thousand times what the image does is none that anybody wants.
void refuse_vast_map(const Ortho& map, const products::EnviHeader& image, const std::string& places) {
  constexpr double kMostTimes = 1000, kAlways_bytes = 1 << 30;
  const double bytes = 4.0 * static_cast<double>(map.samples) * static_cast<double>(map.lines) *
                       static_cast<double>(map.bands),
               of_image = 4.0 * static_cast<double>(image.samples * image.lines) * static_cast<double>(image.bands);
  if (bytes <= std::max(kAlways_bytes, kMostTimes * of_image)) return;
  throw Error(Fault::input,
              fmt::format("{}: spreads {} x {} pixels over a map of {} x {} (pixels of {:.3g} m, {}); give a larger "
                          "--pixel, or render again if the file is damaged",
                          places, image.samples, image.lines, map.samples, map.lines, map.pixel_m,
                          base::format_bytes(static_cast<std::uint64_t>(bytes))));
}

}  // namespace

Ortho orthorectify(const OrthoRequest& request, const std::function<base::OutputSet&()>& set) {
  const auto pair = products::find_envi_pair(request.image);
  products::EnviHeader header = products::read_envi_header(pair.header);
  if (header.spectral_library)
    throw Error(Fault::input, pair.data + ": is a spectral library, not an image; it has no place on a map");
  if (header.type().components != 1)
    throw Error(Fault::input, pair.data + ": complex numbers are not put on a map; take their parts apart first");
  const Places places = places_of(pair.data, header);
  const auto gain = header.data_gain, offset = header.data_offset;
  const std::string vrt = products::geolocated_vrt(header, fs::absolute(pair.data).string(), places.file,
                                                   products::projected_wkt(places.epsg));
  const GdalDataset source = placed(request, vrt), map = warped(request, source, header.data_ignore_value);
  double corner[6] = {};
  gdal().GDALGetGeoTransform(map.get(), corner);
  Ortho out{gdal().GDALGetRasterXSize(map.get()),
            gdal().GDALGetRasterYSize(map.get()),
            header.bands,
            corner[0],
            corner[3],
            corner[1],
            places.epsg};
  refuse_vast_map(out, header, places.file);

  header.samples = out.samples, header.lines = out.lines;
  header.interleave = products::Interleave::bip;
  header.header_offset = 0, header.byte_order = 0, header.data_type = 4;
  header.data_gain.clear(), header.data_offset.clear();
  header.data_ignore_value = std::numeric_limits<double>::quiet_NaN();
  header.description += (header.description.empty() ? "" : ", ") + std::string("on a map, ") + request.resampling;
  products::set_map_grid(header, places.epsg, corner[0], corner[3], corner[1], -corner[5]);
  products::EnviWriter writer(set(), "ortho.img", header);
  constexpr std::int64_t kPiece_bytes = std::int64_t{64} << 20;
  const std::int64_t line_bytes = out.samples * out.bands * static_cast<std::int64_t>(sizeof(float)),
                     together = std::max<std::int64_t>(1, kPiece_bytes / line_bytes);
  std::vector<float> values;
  for (std::int64_t first = 0; first < out.lines; first += together) {
    base::throw_if_interrupted();
    const std::int64_t lines = std::min(together, out.lines - first);
    values.resize(static_cast<std::size_t>(lines * out.samples * out.bands));
    const auto pixel = static_cast<GSpacing>(static_cast<std::size_t>(out.bands) * sizeof(float));
    if (gdal().GDALDatasetRasterIOEx(map.get(), GF_Read, 0, static_cast<int>(first), static_cast<int>(out.samples),
                                     static_cast<int>(lines), values.data(), static_cast<int>(out.samples),
                                     static_cast<int>(lines), GDT_Float32, static_cast<int>(out.bands), nullptr, pixel,
                                     pixel * out.samples, sizeof(float), nullptr) != CE_None)
      failed(request.image, "cannot be read onto the map");
    for (std::size_t i = 0; !(gain.empty() && offset.empty()) && i < values.size(); ++i) {
      const std::size_t band = i % static_cast<std::size_t>(out.bands);
      values[i] = static_cast<float>(static_cast<double>(values[i]) * (band < gain.size() ? gain[band] : 1) +
                                     (band < offset.size() ? offset[band] : 0));
    }
    writer.write({first, lines, values.data(), 0, 0, 0});
  }
  writer.finish();
  return out;
}

}  // namespace raycube::analysis
