// `raycube ortho`: an image over relief, put on a north-up map.
#include <memory>
#include <optional>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/analysis/orthorectify.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"

namespace raycube::cli {
namespace {

int ortho(const analysis::OrthoRequest& request, Invocation& invocation) {
  std::optional<base::OutputSet> kept;
  const analysis::Ortho made = analysis::orthorectify(request, [&]() -> base::OutputSet& {
    kept.emplace(invocation.common.output.empty() ? "ortho" : invocation.common.output, if_exists(invocation.common));
    if (invocation.common.overwrite) kept->replaces({"ortho.img", "ortho.hdr"});
    return *kept;
  });
  base::OutputSet& set = *kept;
  set.publish();
  if (invocation.common.json) {
    const nlohmann::ordered_json out = {{"file", set.folder() + "/ortho.img"},
                                        {"samples", made.samples},
                                        {"lines", made.lines},
                                        {"bands", made.bands},
                                        {"easting_m", made.easting_m},
                                        {"northing_m", made.northing_m},
                                        {"pixel_m", made.pixel_m},
                                        {"epsg", made.epsg}};
    invocation.out << out.dump(2) << "\n";
  } else {
    invocation.out << fmt::format("{}/ortho.img: {} x {} pixels of {:.6g} m in EPSG:{}, {} bands\n", set.folder(),
                                  made.samples, made.lines, made.pixel_m, made.epsg, made.bands);
  }
  return 0;
}

}  // namespace

Verb verb_ortho() {
  auto o = std::make_shared<analysis::OrthoRequest>();
  auto pixel_m = std::make_shared<double>(0);
  Verb verb("ortho", "Put an image that a render left on a north-up map");
  verb.description =
      "Any image of a render's folder (radiance, measured, truth ...) by the location.img beside it, which says where "
      "on "
      "the ground each pixel looks: relief, tilt and turns are taken out. ortho.img is float32 with map info, NaN "
      "where "
      "no pixel looks. GDAL does the same of radiance.vrt: gdalwarp -geoloc.";
  verb.examples = {"raycube ortho out/camera/radiance.img --pixel 0.5 -o map"};
  verb.common = kOutput;
  verb.output_default = "ortho";
  verb.add_options = [o, pixel_m](base::OptionTable& table) {
    table.argument("IMAGE", "An ENVI image with location.img beside it: its data file or its header", o->image);
    table.number("--pixel", "m", 1e-6, 1e6, "Size of the map's pixels", *pixel_m).default_text = "about the image's";
    table.choice("--resampling", {"nearest", "bilinear", "cubic", "average"},
                 "Value of a map's pixel: that of the nearest pixel, or mixed of several", o->resampling);
  };
  verb.run = [o, pixel_m](Invocation& invocation) {
    if (*pixel_m > 0) o->pixel_m = *pixel_m;
    return ortho(*o, invocation);
  };
  return verb;
}

}  // namespace raycube::cli
