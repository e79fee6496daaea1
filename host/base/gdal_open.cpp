#include "host/base/gdal_open.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "host/base/gdal_band.h"
#include "host/base/image_orientation.h"
#include "host/base/netcdf_size.h"
#include "host/base/special_files.h"
#include "host/base/text_grid.h"

namespace raycube::base {
namespace {

class Sources;
/// open_by_gdal(), of a source in a virtual raster in a virtual raster ...
OpenedByGdal open_at_depth(const std::string& file, unsigned kinds, int depth, Sources& sources);

/// Of a raw file that ends before its header says: what is wrong; else empty. GDAL reads what is missing as zeros (with
/// RAW_CHECK_FILE_SIZE it refuses files of less than half their size alone).
std::string cut_short(GDALDatasetH dataset, const std::string& file) {
  const std::string driver = gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset));
  std::error_code failed;
  const auto bytes = static_cast<double>(std::filesystem::file_size(file, failed));
  const auto ends_early = [&](double needed) {
    return failed || bytes >= needed ? std::string()
                                     : "the file ends after " + std::to_string(static_cast<std::uint64_t>(bytes)) +
                                           " of " + std::to_string(static_cast<std::uint64_t>(needed)) + " bytes";
  };
  if (driver == "netCDF") return ends_early(static_cast<double>(netcdf_bytes(file)));
  if (driver != "ENVI" && driver != "EHdr" && driver != "ISCE" && driver != "ROI_PAC") return "";
  const auto said = [&](const char* key, const char* domain) {
    const char* const value = gdal().GDALGetMetadataItem(dataset, key, domain);
    return value ? std::atof(value) : 0.0;
  };
  if (said("file_compression", "ENVI") != 0) return "";
  double bits = 0;
  for (int b = 1; b <= gdal().GDALGetRasterCount(dataset); ++b) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(dataset, b);
    const char* const fewer = gdal().GDALGetMetadataItem(band, "NBITS", "IMAGE_STRUCTURE");
    bits += fewer ? std::atof(fewer) : gdal().GDALGetDataTypeSizeBits(gdal().GDALGetRasterDataType(band));
  }
  const double needed = std::ceil(bits * gdal().GDALGetRasterXSize(dataset) * gdal().GDALGetRasterYSize(dataset) / 8) +
                        said("header_offset", "ENVI");
  return ends_early(needed);
}

/// A scale and an offset, and a unit of lengths by its metres, so that those that mean the same are written the same.
std::string scale_text(const GdalBand& band) {
  std::ostringstream out;
  out.precision(15);
  if (band.scaled()) out << "scale " << band.scale << " and offset " << band.offset;
  return out.str();
}
std::string unit_text(const std::string& unit) {
  const double metres = metres_of(unit);
  std::ostringstream out;
  out.precision(15);
  if (metres > 0)
    out << metres << " m";
  else
    out << unit;
  return out.str();
}

/// What any band of a raster declares of its numbers.
struct Declared {
  bool scaled = false, unit = false, gaps = false, signed_bytes = false, complex = false;
  std::set<std::string> scales, units;  ///< of its bands, as one writes them
  SharedBySources first;                ///< of the first band
};
Declared declared_by(const OpenedByGdal& opened) {
  Declared out;
  const GDALDatasetH dataset = opened.set.get();
  for (int b = 1; b <= gdal().GDALGetRasterCount(dataset); ++b) {
    const GDALRasterBandH handle = gdal().GDALGetRasterBand(dataset, b);
    const GdalBand band = describe_band(opened, handle);
    if (b == 1) out.first = {band.scale, band.offset, band.unit};
    out.scales.insert(scale_text(band));
    out.units.insert(unit_text(band.unit));
    out.scaled = out.scaled || band.scaled();
    out.unit = out.unit || !band.unit.empty();
    out.gaps = out.gaps || !band.mask.empty();
    out.signed_bytes = out.signed_bytes || band.signed_bytes;
    out.complex = out.complex || gdal().GDALDataTypeIsComplex(gdal().GDALGetRasterDataType(handle));
  }
  return out;
}

bool is_virtual(GDALDatasetH dataset) {
  return std::string(gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(dataset))) == "VRT";
}

/// A file below a virtual raster, opened once however many name it.
struct Source {
  std::string wrong;       ///< why it is refused
  bool is_raster = false;  ///< that could be opened
  Declared declared;
  int orientation = 1;
  std::optional<bool> has_gaps;  ///< by its pixels, once that was asked
};

GdalDataset open_as(const std::string& file, unsigned kinds, const char* const* options) {
  return GdalDataset(gdal().GDALOpenEx(file.c_str(), kinds | GDAL_OF_READONLY, nullptr, options, nullptr));
}

/// Whether any pixel of a file has no data; true, too, where reading it all would take long.
bool has_gaps(const std::string& file) {
  constexpr double kMostPixels = 1 << 26;
  const GdalDataset set = open_as(file, GDAL_OF_RASTER, nullptr);
  if (!set) return true;
  const int columns = gdal().GDALGetRasterXSize(set.get()), rows = gdal().GDALGetRasterYSize(set.get()),
            bands = gdal().GDALGetRasterCount(set.get());
  if (double(columns) * rows * bands > kMostPixels) return true;
  const int step = std::clamp((1 << 20) / std::max(columns, 1), 1, std::max(rows, 1));
  std::vector<double> values;
  std::vector<Pixel> known;
  for (int b = 1; b <= bands; ++b) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(set.get(), b);
    const GdalBand described = describe_band(band);
    for (int row = 0; row < rows; row += step) {
      if (!read_rows(band, described, row, std::min(step, rows - row), values, known)) return true;
      if (std::any_of(known.begin(), known.end(), [](Pixel pixel) { return pixel != Pixel::sound; })) return true;
    }
  }
  return false;
}

/// All files below a virtual raster: GDAL takes the numbers of each as they stand.
class Sources {
 public:
  /// Looks at those of one, and fills in what they share; why it is refused, or empty.
  std::string look(OpenedByGdal& opened, const std::string& file, int depth) {
    constexpr int kDeepest = 8;
    const GDALDatasetH dataset = opened.set.get();
    if (!is_virtual(dataset)) return "";
    if (depth > kDeepest) return "virtual rasters of virtual rasters, more than 8 deep";
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    const auto says = [&](const char* key) { return text.str().find(key) != std::string::npos; };
    const Declared here = declared_by(opened);
    const bool ratio = says("<ScaleRatio>"), computed = says("<PixelFunctionType>");
    // Numbers that it makes anew are no source's.
    const bool as_they_stand = !ratio && !computed && !says("<ScaleOffset>") && !says("<LUT>") && !says("<Exponent>");
    Agreement scale, unit;
    std::string wrong;
    char** const files = gdal().GDALGetFileList(dataset);
    for (char** each = files; each && *each && wrong.empty(); ++each) {
      const std::string name = *each;
      std::error_code failed;
      if (std::filesystem::equivalent(name, file, failed) || name.ends_with(".xml")) continue;
      Source& source = at(name, depth + 1);
      const Declared& there = source.declared;
      wrong = source.wrong;
      if (there.signed_bytes && !here.signed_bytes)
        wrong = "its numbers are signed bytes, which the virtual raster takes as 0 to 255; write it as Int16";
      if (there.complex && !here.complex && !computed)
        wrong = "it holds complex numbers, of which the virtual raster takes the real part; write the parts apart";
      if (!wrong.empty()) wrong = "its source " + name + ": " + wrong;
      if (source.is_raster) scale.add(name, there.scales, there.first), unit.add(name, there.units, there.first);
      if (there.gaps && !here.gaps) {
        if (!source.has_gaps) source.has_gaps = has_gaps(name);
        if (*source.has_gaps) lost_[2].insert(name);
      }
      if (source.orientation != 1) lost_[3].insert(name);
    }
    gdal().CSLDestroy(files);
    if (!here.scaled && !ratio) {
      if (as_they_stand && scale.same())
        opened.shared.scale = scale.first.scale, opened.shared.offset = scale.first.offset;
      else
        lose(0, scale);
    }
    if (!here.unit) {
      if (as_they_stand && unit.same())
        opened.shared.unit = unit.first.unit;
      else
        lose(1, unit);
    }
    return wrong;
  }

  /// What they declare and virtual rasters leave out, each kind in one sentence.
  std::vector<std::string> told() const {
    static constexpr std::pair<const char*, const char*> kKinds[] = {
        {"a scale or an offset", "give its band <Scale> and <Offset> of its own, or name the source"},
        {"a unit", "give its band a <UnitType> of its own, or name the source"},
        {"pixels without data", "give its band a <NoDataValue> of its own, or name the source"},
        {"an orientation", "write the source's rows and columns as they are to be seen"}};
    std::vector<std::string> out;
    for (std::size_t kind = 0; kind < std::size(kKinds); ++kind) {
      const std::size_t count = lost_[kind].size();
      if (count == 0) continue;
      const std::string first = *lost_[kind].begin();
      out.push_back((count == 1 ? "its source " + first + " declares "
                                : std::to_string(count) + " of its sources, " + first + " first, declare ") +
                    kKinds[kind].first + ", which the virtual raster leaves out" + differ_[kind] + "; " +
                    kKinds[kind].second);
    }
    return out;
  }

 private:
  /// What a virtual raster's own sources say of one thing.
  struct Agreement {
    std::map<std::string, std::string> who;  ///< the first source of each word; "" none declares it
    std::set<std::string> declaring;
    SharedBySources first;
    void add(const std::string& name, const std::set<std::string>& words, const SharedBySources& declared) {
      if (who.empty()) first = declared;
      for (const std::string& word : words) {
        who.emplace(word, name);
        if (!word.empty()) declaring.insert(name);
      }
    }
    bool same() const { return who.size() <= 1; }
  };

  /// What sources declare and a virtual raster leaves out, and in what they differ, by name.
  void lose(std::size_t kind, const Agreement& said) {
    lost_[kind].insert(said.declaring.begin(), said.declaring.end());
    if (said.same() || said.declaring.empty() || !differ_[kind].empty()) return;
    for (const auto& [word, name] : said.who)
      differ_[kind] +=
          (differ_[kind].empty() ? ", and they differ: " : ", ") + name + " has " + (word.empty() ? "none" : word);
  }

  Source& at(const std::string& file, int depth) {
    std::error_code failed;
    const auto [entry, fresh] = met_.try_emplace(std::filesystem::weakly_canonical(file, failed).string());
    Source& out = entry->second;
    if (!fresh) return out;
    const OpenedByGdal part = open_at_depth(file, GDAL_OF_RASTER, depth, *this);
    if (!part.set && part.refused && std::filesystem::exists(file, failed)) out.wrong = part.wrong;
    if (!part.set) return out;
    out.is_raster = gdal().GDALGetRasterCount(part.set.get()) > 0;
    out.declared = declared_by(part), out.orientation = image_orientation(file);
    return out;
  }

  std::map<std::string, Source> met_;          ///< by canonical paths
  std::array<std::set<std::string>, 4> lost_;  ///< names of sources, by the kind of what is left out
  std::array<std::string, 4> differ_;          ///< what they say instead of one thing, of the first that differ
};

/// Of a text grid: what is wrong, or empty. GDAL takes integers for its type where the first lines have no other
/// numbers, and the smallest or the beginning of what they cannot hold: such a grid is opened anew with doubles, which
/// a virtual raster does not do for its sources.
std::string open_text_grid(GdalDataset& set, const std::string& file, bool is_source) {
  const TextGrid grid = read_text_grid(set.get(), file);
  if (!grid.wrong.empty() || grid.beyond.empty()) return grid.wrong;
  const auto type = [&] { return gdal().GDALGetRasterDataType(gdal().GDALGetRasterBand(set.get(), 1)); };
  const std::string chosen = gdal().GDALGetDataTypeName(type());
  static const char* const kDoubles[] = {"DATATYPE=Float64", nullptr};
  if (!is_source)
    if (GdalDataset again = open_as(file, GDAL_OF_RASTER, kDoubles)) set = std::move(again);
  if (type() == GDT_Float64) return "";
  return grid.beyond + " by GDAL, which takes the file's for " + chosen +
         "; write it as GeoTIFF of doubles (gdal_translate -oo DATATYPE=Float64 -ot Float64)";
}

OpenedByGdal open_at_depth(const std::string& file, unsigned kinds, int depth, Sources& sources) {
  const QuietGdal quiet;
  OpenedByGdal out;
  if (depth == 0)  // which looks at sources of sources, too
    if (const std::string special = special_around(file); !special.empty()) {
      out.wrong = "it needs " + special, out.refused = true;
      return out;
    }
  out.set = open_as(file, kinds, nullptr);
  if (!out.set) {
    out.wrong = gdal_message();
    if (out.wrong.empty()) out.wrong = "no message";
    return out;
  }
  if (gdal().GDALGetRasterCount(out.set.get()) == 0) return out;
  out.wrong = cut_short(out.set.get(), file);
  if (out.wrong.empty()) out.wrong = open_text_grid(out.set, file, depth > 0);
  if (out.wrong.empty() && depth == 0 && declared_by(out).complex)
    out.wrong = "it holds complex numbers, whose parts are to be written apart";
  if (out.wrong.empty()) out.wrong = sources.look(out, file, depth);
  if (!out.wrong.empty()) out.set.reset(), out.refused = true;
  return out;
}

}  // namespace

GdalBand describe_band(const OpenedByGdal& opened, GDALRasterBandH band) {
  GdalBand out = describe_band(band);
  if (!out.scaled()) out.scale = opened.shared.scale, out.offset = opened.shared.offset;
  if (out.unit.empty()) out.unit = opened.shared.unit;
  return out;
}

OpenedByGdal open_by_gdal(const std::string& file, unsigned kinds) {
  Sources sources;
  OpenedByGdal out = open_at_depth(file, kinds, 0, sources);
  out.told = sources.told();
  return out;
}

}  // namespace raycube::base
