#include "scene_compiler/detector_builder.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;

std::vector<NoisePoint> read_noise(const Record& record, Problems& problems) {
  const auto csv = read_csv(record.text("noise"), record.place("noise"), problems);
  if (!csv) return {};
  const auto wavelength = csv->column("wavelength_nm"), nedl = csv->column("nedl"), radiance = csv->column("radiance"),
             snr = csv->column("snr"), a = csv->column("a"), b = csv->column("b"), c = csv->column("c");
  const int forms = int(nedl.has_value()) + int(radiance && snr) + int(a && b && c);
  if (!wavelength || forms != 1) {
    problems.add({csv->file, csv->header_line, 0, ""},
                 "a table of noise has columns wavelength_nm and nedl, or wavelength_nm, radiance and snr, or "
                 "wavelength_nm, a, b and c",
                 csv->columns_text(), "name them so");
    return {};
  }
  // Files of ISOFIT say how well their a, b and c fit, as rmse: nothing that is drawn.
  csv->refuse_other_columns(nedl ? std::vector<std::string>{"wavelength_nm", "nedl"}
                            : a  ? std::vector<std::string>{"wavelength_nm", "a", "b", "c", "rmse"}
                                 : std::vector<std::string>{"wavelength_nm", "radiance", "snr"},
                            problems);
  std::vector<NoisePoint> out;
  for (std::size_t row = 0; row < csv->rows.size(); ++row) {
    const auto number = [&](std::size_t column, const char* what) {
      const double value = csv->number(row, column, problems).value_or(1);
      if (!(value > 0)) problems.add(csv->at(row, column), what, number_text(value), "give a number above 0");
      return value;
    };
    NoisePoint point;
    point.wavelength_um = 1e-3 * number(*wavelength, "a wavelength must be above 0");
    point.function = nedl || a;
    if (nedl) {
      point.c = number(*nedl, "nedl must be above 0");
    } else if (a) {  // in uW cm-2 sr-1 nm-1, of which one is 10 W m-2 sr-1 um-1
      const auto any = [&](std::size_t column) { return csv->number(row, column, problems).value_or(0); };
      point.a = std::sqrt(10.0) * any(*a), point.b = 10 * any(*b), point.c = 10 * any(*c);
      if (point.b < 0) problems.add(csv->at(row, *b), "b must not be below 0", number_text(point.b / 10), "correct it");
    } else {
      point.radiance = number(*radiance, "a radiance must be above 0");
      point.snr = number(*snr, "a ratio must be above 0");
    }
    out.push_back(point);
  }
  std::stable_sort(out.begin(), out.end(), [](const NoisePoint& x, const NoisePoint& y) {
    return x.wavelength_um != y.wavelength_um ? x.wavelength_um < y.wavelength_um : x.radiance < y.radiance;
  });
  for (std::size_t i = 1; !radiance && i < out.size(); ++i)
    if (out[i].wavelength_um == out[i - 1].wavelength_um)
      problems.add({csv->file, 0, 0, ""}, "a wavelength of the table of noise is there twice",
                   number_text(1e3 * out[i].wavelength_um) + " nm", "keep one of the rows");
  for (std::size_t i = 0; radiance && i < out.size();) {
    std::size_t end = i + 1;
    while (end < out.size() && out[end].wavelength_um == out[i].wavelength_um) ++end;
    if (end - i < 2 || !(out[end - 1].radiance > out[i].radiance))
      problems.add({csv->file, 0, 0, ""}, "a table of radiance and snr needs two radiances at each wavelength",
                   std::to_string(end - i) + " at " + number_text(1e3 * out[i].wavelength_um) + " nm", "add another");
    i = end;
  }
  return out;
}

/// Keys that say nothing beside another choice of how large noise is.
void refuse_idle(const Record& record, std::initializer_list<const char*> keys, const char* with, Problems& problems) {
  for (const char* key : keys)
    if (record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' means nothing with " + with, "", "remove it");
}

}  // namespace

DetectorSpec read_detector(const Record& record, Problems& problems) {
  DetectorSpec out;
  const bool snr = record.given("snr"), noise = record.given("noise"), optics = record.given("aperture_diameter_mm");
  if (const int ways = int(snr) + int(noise) + int(optics); ways != 1) {
    problems.add(record.where, "a detector needs exactly one of snr, noise, aperture_diameter_mm", std::to_string(ways),
                 "remove or add one");
    return out;
  }
  out.prnu = record.number("prnu_percent") / 100, out.bad_share = record.number("bad_pixels_percent") / 100;
  if (snr) {
    out.snr = record.number("snr");
    refuse_idle(record,
                {"integration_time_ms", "at_nm", "transmission", "quantum_efficiency", "dark_e_s", "read_noise_e",
                 "dsnu_e", "full_well_e", "bits", "gain_e_dn", "offset_dn"},
                "snr", problems);
    return out;
  }
  if (noise) {
    out.noise = read_noise(record, problems);
    refuse_idle(record,
                {"integration_time_ms", "at_nm", "transmission", "quantum_efficiency", "dark_e_s", "read_noise_e"},
                "noise, which has it all", problems);
    if (!out.noise.empty() && out.noise.front().function)
      refuse_idle(record, {"dsnu_e", "full_well_e", "bits", "gain_e_dn", "offset_dn"},
                  "a noise that knows no electrons; give radiance and snr instead", problems);
  } else {
    out.aperture_diameter_m = 1e-3 * record.number("aperture_diameter_mm");
    if (!record.given("integration_time_ms") || !record.given("quantum_efficiency")) {
      problems.add(record.where, "aperture_diameter_mm goes with integration_time_ms and quantum_efficiency", "",
                   "give both");
      return out;
    }
    out.integration_time_s = 1e-3 * record.number("integration_time_ms");
    for (const double nm : record.numbers("at_nm")) out.at_um.push_back(1e-3 * nm);
    if (!std::is_sorted(out.at_um.begin(), out.at_um.end(), std::less_equal<>()))
      problems.add(record.place("at_nm"), "at_nm must ascend", "", "sort it");
    const auto list = [&](const char* key) {
      const std::vector<double>& values = record.numbers(key);
      if (values.size() > 1 && values.size() != out.at_um.size())
        problems.add(record.place(key), std::string(key) + " needs one value, or one for each of at_nm",
                     std::to_string(values.size()) + " for " + std::to_string(out.at_um.size()), "make them as many");
      return values;
    };
    out.transmission = list("transmission"), out.quantum_efficiency = list("quantum_efficiency");
    out.dark_e_s = record.number("dark_e_s"), out.read_noise_e = record.number("read_noise_e");
  }
  out.dsnu_e = record.number("dsnu_e");
  if (record.given("full_well_e")) out.full_well_e = record.number("full_well_e");
  out.bits = record.given("bits") ? static_cast<int>(record.integer("bits")) : 0;
  out.offset_dn = record.number("offset_dn");
  if (out.bits == 0) {
    refuse_idle(record, {"gain_e_dn", "offset_dn"}, "no bits", problems);
  } else if (record.given("gain_e_dn")) {
    out.gain_e_dn = record.number("gain_e_dn");
  } else if (out.full_well_e) {
    out.gain_e_dn = *out.full_well_e / std::ldexp(1.0, out.bits);
  } else {
    problems.add(record.place("bits"), "digital numbers need gain_e_dn, or full_well_e", "neither", "add one");
  }
  if (out.bits > 0 && out.offset_dn >= std::ldexp(1.0, out.bits))
    problems.add(record.place("offset_dn"), "offset_dn lies past the last digital number",
                 number_text(out.offset_dn) + " of " + number_text(std::ldexp(1.0, out.bits)), "lower it");
  return out;
}

}  // namespace raycube::scene
