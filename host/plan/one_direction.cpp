#include "host/plan/one_direction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::plan {

namespace {

constexpr double kTold = 0.005, kRefused = 0.05;
constexpr double kScaleHeight_m = 8000;
constexpr double kToldOffNadir_deg = 5;  ///< below, an azimuth says little

/// Imported from runs of another code rather than from columns that a user named.
bool from_runs(const atmos::RenderTable& table) {
  const auto provenance = nlohmann::json::parse(table.provenance_json, nullptr, false);
  if (!provenance.is_object() || provenance.value("model", "") != "imported" || !provenance.contains("files"))
    return false;
  return std::any_of(provenance["files"].begin(), provenance["files"].end(),
                     [](const auto& file) { return file.is_object() && file.value("format", "") != "plain-csv"; });
}

/// Air between a height and the sensor, in parts of the whole above z = 0.
double air_below(double sensor_m, double height_m) {
  return std::exp(-height_m / kScaleHeight_m) - std::exp(-sensor_m / kScaleHeight_m);
}

}  // namespace

std::vector<std::string> one_direction_notices(const atmos::RenderTable& table, const std::string& instrument,
                                               const ViewBounds& view, const HeightRange& heights) {
  std::vector<std::string> notices;
  if (!from_runs(table)) return notices;
  base::Problems problems;
  const base::Where where{"", 0, 0, "instrument '" + instrument + "'"};
  const auto judge = [&](double off, const char* of, const std::string& what, const std::string& found,
                         const char* way_out) {
    const std::string away = what + fmt::format(", {:.3g} % of {} away from what is seen", 100 * std::abs(off), of);
    if (std::abs(off) > kRefused)
      problems.add(where, away, found, way_out);
    else if (std::abs(off) > kTold)
      notices.push_back(away + ": " + found);
  };
  const auto angle = [](double sec) { return base::deg_from_rad(std::acos(1 / std::max(1.0, sec))); };
  const auto farther = [](double a, double b) { return std::abs(a) > std::abs(b) ? a : b; };
  const auto &zeniths = table.axis("view_zenith").nodes, &targets = table.axis("target_height").nodes,
             &azimuths = table.axis("relative_azimuth").nodes;
  if (zeniths.size() == 1) {
    const double sec = 1 / std::cos(zeniths[0] / base::deg_from_rad(1));
    judge(farther(view.sec_max / sec - 1, view.sec_min / sec - 1), "the air on the path",
          fmt::format("the imported atmosphere table holds one view zenith, {:.4g} deg", zeniths[0]),
          fmt::format("views from {:.4g} to {:.4g} deg off nadir", angle(view.sec_min), angle(view.sec_max)),
          "import runs at several view zeniths, or narrow the view");
  }
  if (targets.size() == 1) {
    // Of the whole column, not of the path: from a hundred metres up the path is a hundredth of it, and what it adds as
    // little of the light.
    const double air = air_below(view.sensor_height_m, targets[0]);
    judge(farther(air_below(view.sensor_height_m, heights.lo_m) - air,
                  air_below(view.sensor_height_m, heights.hi_m) - air),
          "the column of air",
          fmt::format("the imported atmosphere table holds one target height, {:.5g} m", targets[0]),
          fmt::format("scene from {:.5g} to {:.5g} m", heights.lo_m, heights.hi_m),
          "import spectra of runs that end at several heights (channels of a .chn hold one), or move the scene to that "
          "height");
  }
  problems.throw_if_any();
  if (azimuths.size() == 1 && zeniths.back() > 0.01 && angle(view.sec_max) > kToldOffNadir_deg)
    notices.push_back(
        fmt::format("the imported atmosphere table holds one azimuth from the sun, {:.4g} deg, for views up "
                    "to {:.4g} deg off nadir: path radiance of other azimuths is not known",
                    azimuths[0], angle(view.sec_max)));
  return notices;
}

}  // namespace raycube::plan
