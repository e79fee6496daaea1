#include "host/cli/info_cube.h"

#include <algorithm>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/base/progress.h"
#include "host/cli/info_statistics.h"
#include "host/products/cube_statistics.h"

namespace raycube::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace products;

std::string band_text(const EnviHeader& h, std::size_t band) {
  std::string text = fmt::format("{}", band + 1);
  if (band < h.band_names.size())
    text += " " + h.band_names[band];
  else if (const auto um = h.wavelength_um(); band < um.size() && !h.spectral_library)
    text += fmt::format(" {:.6g} um", um[band]);
  return text;
}

Json header_json(const EnviHeader& h) {
  Json out = {{"samples", h.samples},
              {"lines", h.lines},
              {"bands", h.bands},
              {"data_type", h.type().name},
              {"interleave", to_string(h.interleave)},
              {"byte_order", h.byte_order},
              {"header_offset", h.header_offset},
              {"data_bytes", h.data_bytes()},
              {"file_type", h.file_type}};
  const auto text = [&](const char* key, const std::string& value) {
    if (!value.empty()) out[key] = value;
  };
  text("description", h.description);
  text("sensor_type", h.sensor_type);
  text("acquisition_time", h.acquisition_time);
  text("data_units", h.data_units);
  text("wavelength_units", h.wavelength_units);
  if (const auto um = h.wavelength_um(); !um.empty()) out["wavelength_um"] = um;
  if (const auto um = h.fwhm_um(); !um.empty()) out["fwhm_um"] = um;
  if (!h.band_names.empty()) out["band_names"] = h.band_names;
  if (!h.spectra_names.empty()) out["spectra_names"] = h.spectra_names;
  if (!h.map_info.empty()) out["map_info"] = h.map_info;
  if (h.sun_azimuth_deg) out["sun_azimuth_deg"] = *h.sun_azimuth_deg;
  if (h.sun_elevation_deg) out["sun_elevation_deg"] = *h.sun_elevation_deg;
  if (h.data_ignore_value) out["data_ignore_value"] = *h.data_ignore_value;
  return out;
}

void print_header(std::ostream& out, const EnviPaths& paths, const EnviHeader& h) {
  out << fmt::format("{}: {}\n", paths.data.empty() ? paths.header : paths.data,
                     h.spectral_library ? "ENVI spectral library" : "ENVI image");
  out << fmt::format("  size          {} samples x {} lines x {} bands, {}, {}, {}\n", h.samples, h.lines, h.bands,
                     h.type().name, to_string(h.interleave), h.byte_order == 1 ? "big endian" : "little endian");
  out << fmt::format("  data          {}\n",
                     paths.data.empty() ? "no data file beside this header" : base::format_bytes(h.data_bytes()));
  const auto line = [&](const char* name, const std::string& value) {
    if (!value.empty()) out << fmt::format("  {:<13} {}\n", name, value);
  };
  std::string description = h.description;
  std::replace(description.begin(), description.end(), '\n', ' ');
  line("description", description);
  if (const auto um = h.wavelength_um(); !um.empty()) {
    const bool ascending = std::is_sorted(um.begin(), um.end());
    line("wavelengths",
         fmt::format("{:.6g} to {:.6g} um{}, in the file as {}", *std::min_element(um.begin(), um.end()),
                     *std::max_element(um.begin(), um.end()), ascending ? "" : " (not ascending)", h.wavelength_units));
  }
  line("unit", h.data_units);
  line("sensor", h.sensor_type);
  line("time", h.acquisition_time);
  if (h.sun_azimuth_deg && h.sun_elevation_deg)
    line("sun", fmt::format("azimuth {:.6g} deg, elevation {:.6g} deg", *h.sun_azimuth_deg, *h.sun_elevation_deg));
  if (!h.map_info.empty()) line("map", fmt::format("{}", fmt::join(h.map_info, ", ")));
  if (!h.spectra_names.empty())
    line("spectra", fmt::format("{}: {} ...", h.spectra_names.size(), h.spectra_names.front()));
}

}  // namespace

void print_cube_info(Invocation& invocation, const std::string& path, bool header_only, bool every_band) {
  const EnviPaths paths = find_envi_pair(path);
  EnviHeader h = read_envi_header(paths.header);
  std::vector<BandStatistics> bands;
  if (paths.data.empty()) {
    invocation.log.warning(paths.header + ": no data file lies beside this header; only the header is shown");
  } else {
    const EnviReader reader(path);  // refuses a data file that is too short
    h = reader.header();
    if (!header_only) {
      base::Progress progress(invocation.log, "reading", static_cast<std::uint64_t>(h.lines), "lines");
      bands = band_statistics(reader, [&](std::int64_t lines) {
        base::throw_if_interrupted();
        if (invocation.log.on_terminal()) progress.advance(static_cast<std::uint64_t>(lines));
      });
    }
  }
  for (const auto& warning : h.warnings) invocation.log.warning(warning);
  if (invocation.common.json) {
    Json out = {{"kind", "envi"}, {"header_file", paths.header}};
    if (!paths.data.empty()) out["data_file"] = paths.data;
    out["header"] = header_json(h);
    if (!bands.empty()) {
      out["statistics"] = statistics_json(merged(bands));
      for (const auto& band : bands) out["band_statistics"].push_back(statistics_json(band));
    }
    invocation.out << out.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
    return;
  }
  print_header(invocation.out, paths, h);
  if (bands.empty()) return;
  invocation.out << statistics_title();
  if (every_band || bands.size() <= 12)
    for (std::size_t b = 0; b < bands.size(); ++b) invocation.out << statistics_line(band_text(h, b), bands[b]);
  if (bands.size() > 1) invocation.out << statistics_line("all bands", merged(bands));
}

}  // namespace raycube::cli
