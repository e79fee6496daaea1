#include "host/cli/atmos_plot.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <ostream>

#include <nlohmann/json.hpp>

#include "atmos_tables/rct_file.h"
#include "atmos_tables/report.h"
#include "host/cli/atmos_lidar.h"
#include "host/run/python_chart.h"

namespace raycube::cli {

Verb verb_atmos_plot() {
  struct Options {
    std::string file;
    atmos::PlotChoice choice;
    double height = std::numeric_limits<double>::quiet_NaN(), view = height;
  };
  auto o = std::make_shared<Options>();
  Verb verb("plot",
            "Draw a render table: transmission, irradiance, path radiance, sky, ground and air; or LIDAR profiles");
  verb.description =
      "Writes a PNG beside the table, and the figures in it as JSON. Panels of rows that the table lacks are left out; "
      "wavelengths are "
      "drawn on a logarithmic axis where they span more than a factor of 8. Needs python3-matplotlib.";
  verb.examples = {"raycube atmos plot park.rct -o park.png"};
  verb.common = kOutput;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A render table (.rct)", o->file);
    table.number("--height", "m", -1000, 1e5, "Target height", o->height).default_text = "the table's lowest";
    table.number("--view-zenith", "deg", 0, 89, "Zenith of the sensor seen from the target", o->view).default_text =
        "the table's lowest";
    table.number("--view-azimuth", "deg", -360, 360, "Azimuth of the sensor, and of the slant sky, minus the sun's",
                 o->choice.relative_azimuth_deg);
    table.number("--sky-wavelength", "um", 0.05, 1000, "Wavelength of the sky map, nearest of the table",
                 o->choice.sky_wavelength_um);
  };
  verb.run = [o](Invocation& invocation) {
    const atmos::RenderTable table = atmos::read_rct(o->file);
    atmos::PlotChoice choice = o->choice;
    const auto or_lowest = [&](double typed, const char* axis) {
      const auto found = table.axes.find(axis);
      return !std::isnan(typed) ? typed : found == table.axes.end() ? 0 : found->second.nodes.front();
    };
    choice.target_height_m = or_lowest(o->height, "target_height");
    choice.view_zenith_deg = or_lowest(o->view, "view_zenith");
    std::filesystem::path chart = invocation.common.output;
    if (chart.empty()) chart = std::filesystem::path(o->file).replace_extension(".png");
    const auto title = std::filesystem::path(o->file).filename().string();
    const bool lidar = table.has("lidar_extinction_molecular") && !table.has("sun_transmission");
    const std::string figures =
        run::draw_chart(lidar ? "lidar_plot.py" : "atmos_plot.py",
                        lidar ? lidar_figures_json(table, title) : atmos::plot_json(table, choice, title),
                        chart.string(), invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse);
    if (invocation.common.json)
      invocation.out << nlohmann::json{{"chart", chart.string()}, {"figures", figures}}.dump() << "\n";
    else
      invocation.out << "chart: " << chart.string() << "\n";
    return 0;
  };
  return verb;
}

}  // namespace raycube::cli
