#include "host/cli/info_spectra.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/text.h"
#include "host/cli/info_statistics.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::cli {
namespace {

constexpr std::array kSpectrumEndings = {".csv", ".txt", ".asc", ".asd", ".sig"};

products::BandStatistics statistics_of(const scene::Curve& curve) {
  products::BandStatistics out;
  for (const double value : curve.value) out.add(value);
  return out;
}

nlohmann::ordered_json curve_json(const scene::Curve& curve) {
  return {{"wavelength_um", curve.wavelength_um},
          {"value", curve.value},
          {"statistics", statistics_json(statistics_of(curve))}};
}

nlohmann::ordered_json spectra_json(const std::string& path, const std::vector<scene::Material>& spectra) {
  nlohmann::ordered_json out = {{"kind", "spectra"}, {"file", path}, {"spectra", nlohmann::ordered_json::array()}};
  for (const scene::Material& spectrum : spectra) {
    out["spectra"].push_back({{"name", spectrum.name},
                              {"source", spectrum.source},
                              {"points", spectrum.reflectance.value.size()},
                              {"reflectance", curve_json(spectrum.reflectance)}});
    if (!spectrum.transmittance.value.empty())
      out["spectra"].back()["transmittance"] = curve_json(spectrum.transmittance);
  }
  return out;
}

void print_spectra(std::ostream& out, const std::string& path, const std::vector<scene::Material>& spectra) {
  out << fmt::format("{}: {} of reflectance, in vacuum um\n", path,
                     spectra.size() == 1 ? "a spectrum" : fmt::format("{} spectra", spectra.size()));
  for (const scene::Material& spectrum : spectra) {
    const auto& um = spectrum.reflectance.wavelength_um;
    out << fmt::format("  {}{}: {}, {:.6g} to {:.6g} um\n", spectrum.name.empty() ? "" : spectrum.name + ", ",
                       spectrum.source, base::counted(um.size(), "point"), um.front(), um.back());
    out << statistics_title() << statistics_line("reflectance", statistics_of(spectrum.reflectance));
    if (!spectrum.transmittance.value.empty())
      out << statistics_line("transmittance", statistics_of(spectrum.transmittance));
  }
}

}  // namespace

bool is_spectrum_file(const std::string& path) {
  const std::string ending = scene::lower_case(std::filesystem::path(path).extension().string());
  if (std::find(kSpectrumEndings.begin(), kSpectrumEndings.end(), ending) == kSpectrumEndings.end()) return false;
  return !std::filesystem::exists(path + ".hdr") &&
         !std::filesystem::exists(std::filesystem::path(path).replace_extension(".hdr"));
}

void print_spectra_info(Invocation& invocation, const std::string& path) {
  base::Problems problems;
  scene::SpectrumRequest request;
  request.file = path, request.asked_by = {path, 0, 0, ""};
  const std::vector<scene::Material> spectra = scene::read_spectra(request, problems);
  problems.throw_if_any();
  for (const std::string& notice : problems.notices()) invocation.log.warning(notice);
  if (invocation.common.json)
    invocation.out << spectra_json(path, spectra).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
                   << "\n";
  else
    print_spectra(invocation.out, path, spectra);
}

}  // namespace raycube::cli
