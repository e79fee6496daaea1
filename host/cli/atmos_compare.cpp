#include "host/cli/atmos_compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <ostream>

#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/table_difference.h"
#include "host/base/error.h"
#include "host/run/python_chart.h"

namespace raycube::cli {

namespace {

struct CompareRequest {
  std::string a, b, bands;
  double step_nm = 0, height = std::numeric_limits<double>::quiet_NaN();
  atmos::DifferenceChoice choice;
};

/// Rows `center_nm,fwhm_nm` below a header of these names; # comments.
std::vector<atmos::DifferenceBand> bands_of(const std::string& path) {
  base::Problems problems;
  std::vector<atmos::DifferenceBand> bands;
  bool header = false;
  const auto lines = atmos::imported::read_lines(path);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = atmos::imported::trimmed(lines[i]);
    if (line.empty() || line.front() == '#') continue;
    const base::Where where{path, static_cast<int>(i) + 1, 0, ""};
    const auto cells = atmos::imported::split_commas(line);
    if (!header) {
      header = cells.size() >= 2 && cells[0] == "center_nm" && cells[1] == "fwhm_nm";
      if (!header) {
        problems.add(where, "the first row must name the columns center_nm,fwhm_nm", std::string(line.substr(0, 40)),
                     "write that row first");
        break;
      }
      continue;
    }
    if (cells.size() < 2) {
      problems.add(where, "a band is center_nm,fwhm_nm", std::string(line.substr(0, 40)), "give two numbers");
      continue;
    }
    const auto center = atmos::imported::need_number(cells[0], where, "center_nm", problems);
    const auto fwhm = atmos::imported::need_number(cells[1], where, "fwhm_nm", problems);
    if (!center.good() || !fwhm.good()) continue;
    if (!(center.value >= 50 && center.value <= 1e6))
      problems.add(where, "center_nm must lie in 50 to 1e6", std::string(cells[0]), "give nm");
    else if (!(fwhm.value > 0))
      problems.add(where, "fwhm_nm must be above 0", std::string(cells[1]), "give nm");
    else
      bands.push_back(atmos::gaussian_band(center.value / 1000, fwhm.value / 1000));
  }
  if (bands.empty() && problems.empty()) problems.add({path, 0, 0, ""}, "no bands", "", "write rows center_nm,fwhm_nm");
  problems.throw_if_any();
  return bands;
}

int compare(const CompareRequest& o, Invocation& invocation) {
  const atmos::RenderTable a = atmos::read_rct(o.a), b = atmos::read_rct(o.b);
  atmos::DifferenceChoice choice = o.choice;
  if (!std::isnan(o.height)) choice.height_m = o.height;
  if (!o.bands.empty() && o.step_nm > 0)
    throw base::Error(base::Fault::input, "--bands and --step both say what the bands are; give one of them");
  if (!o.bands.empty()) choice.bands = bands_of(o.bands);
  if (o.step_nm > 0) {
    const auto &l = a.axis("wavelength").nodes, &m = b.axis("wavelength").nodes;
    const double first = std::max(l.front(), m.front()), last = std::min(l.back(), m.back());
    if (first < last) choice.bands = atmos::even_bands(first, last, o.step_nm / 1000);
  }
  const auto difference = atmos::table_difference(a, b, choice);
  const atmos::TableNames names{o.a, o.b};
  const std::string& chart = invocation.common.output;
  if (!chart.empty())
    run::draw_chart("atmos_compare.py", atmos::difference_json(difference, names, true), chart,
                    invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse);
  invocation.out << (invocation.common.json ? atmos::difference_json(difference, names, false)
                                            : atmos::difference_text(difference, names));
  if (!chart.empty() && !invocation.common.json) invocation.out << "\nchart: " << chart << "\n";
  return 0;
}

}  // namespace

Verb verb_atmos_compare() {
  auto o = std::make_shared<CompareRequest>();
  Verb verb("compare", "Print band-wise differences of two render tables");
  verb.description =
      "Reads both tables at one target height, straight and slanted, over the wavelengths both cover, and says mean, "
      "rms and worst "
      "of B - A per band, absolute and, for radiances and irradiances, over A's mean. What differs in sun, sensor or "
      "axes is said "
      "first, and rows that only one table has are named. With -o the spectra and their differences are drawn as PNG, "
      "with the "
      "figures in a .json beside it. Bands without option: the atmosphere's windows.";
  verb.examples = {"raycube atmos compare mine.rct theirs.rct",
                   "raycube atmos compare a.rct b.rct --step 100 -o difference.png"};
  verb.common = kOutput;
  verb.output_default = "no chart";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("A", "A render table (.rct)", o->a);
    table.argument("B", "The render table compared with it", o->b);
    table.text("--bands", "FILE", "CSV of Gaussian bands: center_nm,fwhm_nm", o->bands).default_text =
        "windows of the atmosphere";
    table.number("--step", "nm", 0, 1e5, "Width of even bands over the common range; 0: windows of the atmosphere",
                 o->step_nm);
    table.number("--height", "m", -1000, 1e5, "Target height", o->height).default_text = "the lowest both have";
    table.number("--view-zenith", "deg", 0, 89, "Zenith of the sensor seen from the target, slant path",
                 o->choice.view_zenith_deg);
    table.number("--sky-zenith", "deg", 0, 90, "Zenith of the slant sky", o->choice.sky_zenith_deg);
    table.number("--azimuth", "deg", -360, 360, "Azimuth of sensor and sky point minus the sun's",
                 o->choice.relative_azimuth_deg);
  };
  verb.run = [o](Invocation& invocation) { return compare(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
