#include "host/products/geolocated_vrt.h"

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/text.h"

namespace raycube::products {
namespace {

const char* gdal_type(int envi_code) {
  switch (envi_code) {
    case 1:
      return "Byte";
    case 2:
      return "Int16";
    case 3:
      return "Int32";
    case 13:
      return "UInt32";
    case 14:
      return "Int64";
    case 15:
      return "UInt64";
    case 4:
      return "Float32";
    case 5:
      return "Float64";
    case 12:
      return "UInt16";
    default:
      throw base::Error(base::Fault::bug, "a virtual raster of a type that GDAL has not");
  }
}

std::string name_of(const EnviHeader& header, std::size_t band) {
  if (band < header.band_names.size()) return header.band_names[band];
  if (band < header.wavelength.size())
    return fmt::format("{:g} {}", header.wavelength[band], header.wavelength_units == "Nanometers" ? "nm" : "um");
  return fmt::format("band {}", band + 1);
}

}  // namespace

std::string geolocated_vrt(const EnviHeader& header, const std::string& image, const std::string& location,
                           const std::string& wkt) {
  std::string out =
      fmt::format("<VRTDataset rasterXSize=\"{}\" rasterYSize=\"{}\">\n  <Metadata domain=\"GEOLOCATION\">\n",
                  header.samples, header.lines);
  const auto item = [&](const char* key, const std::string& value) {
    out += fmt::format("    <MDI key=\"{}\">{}</MDI>\n", key, base::escaped_markup(value));
  };
  item("SRS", wkt);
  for (const char axis : {'X', 'Y'}) {
    item(fmt::format("{}_DATASET", axis).c_str(), location);
    item(fmt::format("{}_DATASET_RELATIVE_TO_SOURCE", axis).c_str(), "YES");
    item(fmt::format("{}_BAND", axis).c_str(), axis == 'X' ? "1" : "2");
  }
  for (const char* key : {"PIXEL_OFFSET", "LINE_OFFSET"}) item(key, "0");
  for (const char* key : {"PIXEL_STEP", "LINE_STEP"}) item(key, "1");
  item("GEOREFERENCING_CONVENTION", "PIXEL_CENTER");
  out += "  </Metadata>\n";
  for (std::size_t b = 0; b < static_cast<std::size_t>(header.bands); ++b) {
    out += fmt::format("  <VRTRasterBand dataType=\"{}\" band=\"{}\">\n    <Description>{}</Description>\n",
                       gdal_type(header.data_type), b + 1, base::escaped_markup(name_of(header, b)));
    if (b < header.data_gain.size()) out += fmt::format("    <Scale>{:.17g}</Scale>\n", header.data_gain[b]);
    if (b < header.data_offset.size()) out += fmt::format("    <Offset>{:.17g}</Offset>\n", header.data_offset[b]);
    out += fmt::format(
        "    <SimpleSource><SourceFilename relativeToVRT=\"1\">{}</SourceFilename><SourceBand>{}</SourceBand>"
        "</SimpleSource>\n  </VRTRasterBand>\n",
        base::escaped_markup(image), b + 1);
  }
  return out + "</VRTDataset>\n";
}

}  // namespace raycube::products
