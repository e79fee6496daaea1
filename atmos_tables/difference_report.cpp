#include <cstdio>

#include <nlohmann/json.hpp>

#include "atmos_tables/table_difference.h"

namespace raycube::atmos {

namespace {

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[160];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string band_name(const DifferenceBand& band) {
  return band.fwhm_um > 0 ? formatted("%.5g, FWHM %.3g", band.center_um, band.fwhm_um)
                          : formatted("%.5g - %.5g", band.low_um, band.high_um);
}

std::string percent(const std::optional<double>& value) {
  return value ? formatted("%+9.2f %%", 100 * *value) : formatted("%11s", "-");
}

std::string listed(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& word : words) out += " " + word;
  return out;
}

}  // namespace

std::string difference_text(const TableDifference& d, const TableNames& names) {
  std::string out = "A: " + names.a + "\nB: " + names.b + "\n";
  for (const auto& sentence : d.differs) out += "differs: " + sentence + "\n";
  if (!d.only_a.empty()) out += "only in A:" + listed(d.only_a) + "\n";
  if (!d.only_b.empty()) out += "only in B:" + listed(d.only_b) + "\n";
  out += formatted("target height %g m; common range %g to %g um; differences are B - A\n", d.height_m, d.first_um,
                   d.last_um);
  for (const auto& q : d.quantities) {
    out += "\n" + q.name + (q.where.empty() ? "" : ", " + q.where) + " [" + q.unit + "]\n";
    out += formatted("  %-18s%11s%11s%11s%11s%11s%9s", "band, um", "mean A", "mean B", "mean B-A", "rms", "worst",
                     "at um");
    out += q.ratio ? "\n" : formatted("%11s%11s%11s\n", "mean/A", "rms/A", "worst/A");
    for (const auto& band : q.bands) {
      out += formatted("  %-18s%11.4g%11.4g%+11.3g%11.3g%+11.3g%9.4g", band_name(band.band).c_str(), band.mean_a,
                       band.mean_b, band.mean, band.rms, band.worst, band.worst_um);
      out += q.ratio ? "\n"
                     : percent(band.mean_relative) + percent(band.rms_relative) + percent(band.worst_relative) + "\n";
    }
  }
  return out;
}

std::string difference_json(const TableDifference& d, const TableNames& names, bool spectra) {
  using json = nlohmann::ordered_json;
  json out{{"a", names.a},           {"b", names.b},        {"differs", d.differs},
           {"only_a", d.only_a},     {"only_b", d.only_b},  {"target_height_m", d.height_m},
           {"first_um", d.first_um}, {"last_um", d.last_um}};
  if (spectra) out["wavelength_um"] = d.wavelength_um;
  const auto or_null = [](const std::optional<double>& value) { return value ? json(*value) : json(); };
  out["quantities"] = json::array();
  for (const auto& q : d.quantities) {
    json entry{{"name", q.name}, {"where", q.where}, {"unit", q.unit}, {"ratio", q.ratio}, {"bands", json::array()}};
    for (const auto& b : q.bands) {
      json band{{"low_um", b.band.low_um}, {"high_um", b.band.high_um}};
      if (b.band.fwhm_um > 0) band["center_um"] = b.band.center_um, band["fwhm_um"] = b.band.fwhm_um;
      band.update({{"mean_a", b.mean_a},
                   {"mean_b", b.mean_b},
                   {"mean", b.mean},
                   {"rms", b.rms},
                   {"worst", b.worst},
                   {"worst_um", b.worst_um}});
      if (!q.ratio)
        band.update({{"mean_relative", or_null(b.mean_relative)},
                     {"rms_relative", or_null(b.rms_relative)},
                     {"worst_relative", or_null(b.worst_relative)}});
      entry["bands"].push_back(std::move(band));
    }
    if (spectra) entry["spectrum_a"] = q.a, entry["spectrum_b"] = q.b;
    out["quantities"].push_back(std::move(entry));
  }
  return out.dump(spectra ? -1 : 1) + "\n";
}

}  // namespace raycube::atmos
