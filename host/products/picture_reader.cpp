#include "host/products/picture_reader.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <ImfChannelList.h>
#include <ImfCompressionAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImathBox.h>

#include "host/base/error.h"
#include "host/base/gdal_band.h"
#include "host/base/gdal_library.h"
#include "host/base/gdal_open.h"
#include "host/base/text.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;
using base::gdal;

constexpr std::int64_t kValuesAtOnce = 1 << 22;

const std::string kExrMagic("\x76\x2f\x31\x01", 4);
/// Of PNG, JPEG, TIFF of either order, and large TIFF.
const std::vector<std::string>& raster_magics() {
  static const std::vector<std::string> all = {"\x89PNG",
                                               "\xff\xd8\xff",
                                               std::string("II*\0", 4),
                                               std::string("MM\0*", 4),
                                               std::string("II+\0", 4),
                                               std::string("MM\0+", 4)};
  return all;
}

std::string first_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string out(4, '\0');
  in.read(out.data(), 4);
  out.resize(static_cast<std::size_t>(in.gcount()));
  return out;
}

/// So many lines of `values_per_line` at once.
std::int64_t lines_at_once(std::int64_t values_per_line) {
  return std::max<std::int64_t>(1, kValuesAtOnce / std::max<std::int64_t>(1, values_per_line));
}

void add_value(BandStatistics& to, double value) {
  if (std::isfinite(value))
    to.add(value);
  else
    ++to.not_finite;
}

const char* pixel_type_name(Imf::PixelType type) {
  return type == Imf::HALF ? "half" : type == Imf::FLOAT ? "float" : "uint";
}

const char* compression_name(Imf::Compression compression) {
  constexpr const char* names[] = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  const auto number = static_cast<std::size_t>(compression);
  return number < std::size(names) ? names[number] : "unknown";
}

PicturePart part_of(const Imf::Header& header) {
  PicturePart out;
  if (header.hasName()) out.name = header.name();
  const Imath::Box2i window = header.dataWindow();
  out.width = std::int64_t{window.max.x} - window.min.x + 1, out.height = std::int64_t{window.max.y} - window.min.y + 1;
  out.compression = compression_name(header.compression());
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
    out.channels.push_back({c.name(), pixel_type_name(c.channel().type), {}});
  for (auto a = header.begin(); a != header.end(); ++a)
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
        text && a.name() != std::string("name") && a.name() != std::string("type"))
      out.texts[a.name()] = text->value();
  return out;
}

bool is_full(const Imf::Header& header) {
  if (header.hasType() && Imf::isDeepData(header.type())) return false;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1) return false;
  return true;
}

void add_statistics(Imf::InputPart in, PicturePart& part, const std::function<void(std::int64_t)>& after_lines) {
  const Imath::Box2i window = in.header().dataWindow();
  const auto channels = static_cast<std::int64_t>(part.channels.size());
  if (channels == 0) return;
  const std::int64_t step = std::min(part.height, lines_at_once(part.width * channels));
  std::vector<float> values(static_cast<std::size_t>(step * part.width * channels));
  for (PictureChannel& channel : part.channels) channel.statistics.emplace();
  for (std::int64_t line = 0; line < part.height; line += step) {
    const std::int64_t lines = std::min(step, part.height - line);
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < part.channels.size(); ++c) {
      // A slice's base is where pixel (0, 0) of the whole window's plane would lie; only these lines are touched.
      const std::int64_t first = -(window.min.x + (window.min.y + line) * part.width) * channels + std::int64_t(c);
      buffer.insert(part.channels[c].name,
                    Imf::Slice(Imf::FLOAT,
                               reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(values.data()) +
                                                       static_cast<std::uintptr_t>(first) * sizeof(float)),
                               static_cast<std::size_t>(channels) * sizeof(float),
                               static_cast<std::size_t>(part.width * channels) * sizeof(float)));
    }
    in.setFrameBuffer(buffer);
    in.readPixels(static_cast<int>(window.min.y + line), static_cast<int>(window.min.y + line + lines - 1));
    for (std::size_t i = 0; i < static_cast<std::size_t>(lines * part.width * channels); ++i)
      add_value(*part.channels[i % part.channels.size()].statistics, values[i]);
    if (after_lines) after_lines(lines);
  }
}

Picture read_exr(const std::string& path, bool header_only, const std::function<void(std::int64_t)>& after_lines) {
  Picture out{"OpenEXR", {}, {}};
  try {
    Imf::MultiPartInputFile file(path.c_str());
    for (int p = 0; p < file.parts(); ++p) {
      out.parts.push_back(part_of(file.header(p)));
      if (!header_only && is_full(file.header(p)))
        add_statistics(Imf::InputPart(file, p), out.parts.back(), after_lines);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& failure) {
    throw Error(Fault::input, path + ": OpenEXR cannot read it: " + failure.what());
  }
  return out;
}

/// GDAL's word on what it could not do.
Error gdal_error(const std::string& path) {
  const std::string said = base::gdal_message();
  return {Fault::input, path + ": GDAL cannot read it: " + (said.empty() ? "no message" : said)};
}

BandStatistics statistics_of(const base::OpenedByGdal& opened, GDALRasterBandH band, const std::string& path,
                             const std::function<void(std::int64_t)>& after_lines) {
  BandStatistics out;
  const int width = gdal().GDALGetRasterBandXSize(band), height = gdal().GDALGetRasterBandYSize(band);
  const int step = static_cast<int>(std::min<std::int64_t>(height, lines_at_once(width)));
  const base::GdalBand described = base::describe_band(opened, band);
  std::vector<double> values;
  std::vector<base::Pixel> known;
  for (int line = 0; line < height; line += step) {
    const int lines = std::min(step, height - line);
    if (!base::read_rows(band, described, line, lines, values, known)) throw gdal_error(path);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (known[i] == base::Pixel::missing && std::isfinite(values[i]))
        ++out.ignored;
      else
        add_value(out, values[i]);
    }
    if (after_lines) after_lines(lines);
  }
  return out;
}

Picture read_raster_picture(const std::string& path, bool header_only,
                            const std::function<void(std::int64_t)>& after_lines) {
  const base::OpenedByGdal opened = base::open_by_gdal(path);
  const GDALDatasetH set = opened.set.get();
  if (!set) throw Error(Fault::input, path + ": GDAL cannot read it: " + opened.wrong);
  const base::QuietGdal quiet;
  Picture out;
  const GDALDriverH driver = gdal().GDALGetDatasetDriver(set);
  const char* format = gdal().GDALGetMetadataItem(driver, GDAL_DMD_LONGNAME, "");
  out.format = format ? format : gdal().GDALGetDriverShortName(driver);
  PicturePart& part = out.parts.emplace_back();
  part.width = gdal().GDALGetRasterXSize(set), part.height = gdal().GDALGetRasterYSize(set);
  if (const char* how = gdal().GDALGetMetadataItem(set, "COMPRESSION", "IMAGE_STRUCTURE")) part.compression = how;
  char* const* const texts = gdal().GDALGetMetadata(set, "");
  for (int i = 0; texts && texts[i]; ++i) {
    const std::string entry = texts[i];
    if (const auto equals = entry.find('='); equals != std::string::npos)
      part.texts[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  std::array<double, 6> transform{};
  if (gdal().GDALGetGeoTransform(set, transform.data()) == CE_None) out.transform = transform;
  for (int b = 1; b <= gdal().GDALGetRasterCount(set); ++b) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(set, b);
    const std::string named = gdal().GDALGetDescription(band),
                      colour = gdal().GDALGetColorInterpretationName(gdal().GDALGetRasterColorInterpretation(band));
    part.channels.push_back(
        {named.empty() ? colour : named, gdal().GDALGetDataTypeName(gdal().GDALGetRasterDataType(band)), {}});
    if (!header_only) part.channels.back().statistics = statistics_of(opened, band, path, after_lines);
  }
  return out;
}

}  // namespace

bool is_picture(const std::string& path) {
  const std::string bytes = first_bytes(path);
  return base::lower_case(path).ends_with(".exr") || bytes == kExrMagic ||
         std::any_of(raster_magics().begin(), raster_magics().end(),
                     [&](const std::string& magic) { return bytes.starts_with(magic); });
}

Picture read_picture(const std::string& path, bool header_only, const std::function<void(std::int64_t)>& after_lines) {
  if (first_bytes(path) == kExrMagic) return read_exr(path, header_only, after_lines);
  return read_raster_picture(path, header_only, after_lines);
}

}  // namespace raycube::products
