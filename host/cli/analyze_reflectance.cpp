// raycube analyze reflectance: a cube of reflectance by panels that are in it.
#include <limits>
#include <memory>
#include <mutex>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/empirical_line.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"
#include "host/products/envi_writer.h"

namespace raycube::cli {
namespace {

struct ReflectanceRequest : AnalyzeRequest {
  std::vector<std::string> panels, reflectances;
};

/// Reflectance of each panel: a number, or a file's curve.
std::vector<Eigen::VectorXd> reflectances_of(const ReflectanceRequest& request, const analysis::Cube& cube,
                                             const std::vector<analysis::NamedSpectrum>& panels) {
  std::vector<Eigen::VectorXd> out(panels.size());
  for (const std::string& text : request.reflectances) {
    const auto equals = text.find('=');
    std::size_t k = 0;
    while (k < panels.size() && panels[k].name != text.substr(0, equals)) ++k;
    if (equals == std::string::npos || k == panels.size())
      throw base::Error(base::Fault::input,
                        fmt::format("reflectance \"{}\": give PANEL=0.1 or PANEL=FILE.csv of a --panel", text));
    char* end = nullptr;
    const std::string what = text.substr(equals + 1);
    const double number = std::strtod(what.c_str(), &end);
    if (!what.empty() && *end == '\0') {
      if (!(number >= 0 && number <= 2))
        throw base::Error(base::Fault::input, fmt::format("reflectance \"{}\": is a number from 0 to 2", text));
      out[k] = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(cube.bands()), number);
    } else if (analysis::is_curve_file(what)) {
      out[k] = analysis::read_spectra({text}, cube, {}).front().value;
    } else {
      throw base::Error(base::Fault::input,
                        fmt::format("reflectance \"{}\": give a number, FILE.csv or FILE.sli@NAME", text));
    }
  }
  for (std::size_t k = 0; k < panels.size(); ++k)
    if (out[k].size() == 0)
      throw base::Error(base::Fault::input, fmt::format("panel \"{}\" has no reflectance; give --reflectance {}=0.1",
                                                        panels[k].name, panels[k].name));
  return out;
}

void write_cube(const analysis::Cube& cube, const analysis::EmpiricalLine& line, AnalysisFolder& folder,
                const run::Services& services) {
  products::EnviHeader header = analysis::header_like(cube, "Reflectance of " + cube.path() + " by an empirical line");
  header.bands = static_cast<std::int64_t>(cube.bands()), header.interleave = cube.header().interleave;
  header.data_units = "reflectance";
  if (!cube.wavelength_um().empty()) {
    header.wavelength_units = "Micrometers";
    header.wavelength = cube.wavelength_um(), header.fwhm = cube.fwhm_um();
  }
  if (!line.dark.empty()) header.bad_bands.assign(cube.bands(), 1);
  for (const std::size_t b : line.dark) header.bad_bands[b] = 0;
  products::EnviWriter writer(folder.set(), "reflectance.img", header);
  std::mutex alone;
  analysis::for_each_part(
      cube, ShownPass(services, "reflectance", cube), [&](std::size_t, const analysis::Pixels& pixels) {
        std::vector<float> out(pixels.value.size());
        for (std::size_t p = 0; p < pixels.count(); ++p)
          for (std::size_t b = 0; b < pixels.bands; ++b) {
            const auto i = static_cast<Eigen::Index>(b);
            const double value = line.gain[i] * pixels.at(p)[b] + line.offset[i];
            out[p * pixels.bands + b] =
                static_cast<float>(pixels.counts[p] ? value : std::numeric_limits<double>::quiet_NaN());
          }
        for (const std::size_t b : line.dark)
          for (std::size_t p = 0; p < pixels.count(); ++p) out[p * pixels.bands + b] = 0;
        const std::lock_guard lock(alone);
        products::Strip strip;
        strip.first_line = pixels.first_line, strip.lines = pixels.lines, strip.values = out.data();
        writer.write(strip);
      });
  writer.finish();
}

int reflectance(const ReflectanceRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  for (const std::string& text : request.panels)
    if (const auto equals = text.find('=');
        equals != std::string::npos && analysis::is_curve_file(text.substr(equals + 1)))
      throw base::Error(base::Fault::input, fmt::format("panel \"{}\": is a region of the cube; its curve goes to "
                                                        "--reflectance",
                                                        text));
  AnalysisFolder folder(invocation, request, "reflectance");
  const auto means = analysis::read_spectra(request.panels, cube, ShownPass(services, "panels", cube));
  const std::vector<Eigen::VectorXd> known = reflectances_of(request, cube, means);
  std::vector<analysis::Panel> panels;
  for (std::size_t k = 0; k < means.size(); ++k) panels.push_back({means[k].name, means[k].value, known[k]});
  const analysis::EmpiricalLine line = analysis::empirical_line(panels);
  write_cube(cube, line, folder, services);
  if (!line.dark.empty())
    services.log.warning(
        fmt::format("{} bands, the first {}, see the panels alike and tell no reflectance: they are 0 "
                    "and called bad in the header",
                    line.dark.size(), cube.band_text(line.dark.front())));
  std::vector<std::string> columns = {"gain", "offset", "rms"};
  std::vector<std::vector<double>> values = {list_of(line.gain), list_of(line.offset), list_of(line.rms)};
  folder.numbers()["gain"] = values[0], folder.numbers()["offset"] = values[1], folder.numbers()["rms"] = values[2];
  for (const analysis::Panel& panel : panels) {
    columns.push_back(panel.name + "_in_cube"), values.push_back(list_of(panel.radiance));
    columns.push_back(panel.name + "_reflectance"), values.push_back(list_of(panel.reflectance));
    folder.numbers()["panels"].push_back(
        {{"name", panel.name}, {"in_cube", list_of(panel.radiance)}, {"reflectance", list_of(panel.reflectance)}});
  }
  write_spectra_table(folder.table("line.csv"), cube, columns, values);
  double worst = 0;
  for (Eigen::Index b = 0; b < line.rms.size(); ++b)
    if (line.rms[b] > worst) worst = line.rms[b];
  return folder.finish(
      cube,
      fmt::format("{}, {} ({} tell nothing), worst rms of the line {:.3g}\n", base::counted(panels.size(), "panel"),
                  base::counted(static_cast<std::size_t>(cube.bands()), "band"), line.dark.size(), worst));
}

}  // namespace

Verb verb_analyze_reflectance() {
  auto o = std::make_shared<ReflectanceRequest>();
  Verb verb("reflectance", "Make a cube of reflectance by panels that are in the image (empirical line)");
  verb.description =
      "Each --panel is a region of known --reflectance. Of two panels each band's line goes through both, of more it "
      "is "
      "that of least squares. reflectance.img is a cube of the bands that take part, line.csv has gains and offsets. "
      "The "
      "line holds for what lies as high as the panels, as flat, and under as much sky: a shaded or tilted surface's "
      "reflectance comes out as its apparent one.";
  verb.examples = {
      "raycube analyze reflectance cube.img --panel dark=10:14,40:44 --panel bright=20:24,40:44 "
      "--reflectance dark=0.1 --reflectance bright=0.8",
      "raycube analyze reflectance cube.img --panel a=FILE.geojson@name=a --panel b=FILE.geojson@name=b "
      "--reflectance a=a.csv --reflectance b=b.csv"};
  verb.common = kOutput | kThreads;
  verb.output_default = "reflectance";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.texts("--panel", "NAME=WHAT", "Two or more: regions, as X0:X1,Y0:Y1 or a file", o->panels);
    table.texts("--reflectance", "PANEL=WHAT", "Of each panel: a number, FILE.csv or FILE.sli@NAME", o->reflectances);
  };
  verb.run = [o](Invocation& invocation) { return reflectance(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
