#include "host/cli/atmos_import.h"

#include <cmath>
#include <memory>
#include <optional>
#include <ostream>

#include <nlohmann/json.hpp>

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/table_of_runs.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/told_geometry.h"
#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/cli/verb.h"
#include "host/cli/typed.h"

namespace raycube::cli {

namespace {

struct ImportRequest {
  std::vector<std::string> files;
  std::string format = "auto", uvspec_input, albedo;
  double sun_zenith = kUnset, sun_azimuth = kUnset, sensor = kUnset, ground = kUnset;
  bool even_sky = false, partial = false;
};

std::vector<double> albedos(const std::string& typed) {
  base::Problems problems;
  std::vector<double> out;
  for (const auto& field : atmos::imported::split_commas(typed)) {
    const auto number = atmos::imported::need_number(field, {"", 0, 0, "--albedo"}, "an albedo", problems);
    if (number.good() && number.value > 1)
      problems.add({"", 0, 0, "--albedo"}, "an albedo is above 1", std::string(field), "give 0 to 1");
    out.push_back(number.value);
  }
  problems.throw_if_any();
  return out;
}

int write_table(const ImportRequest& o, const std::vector<atmos::imported::Imported>& files, Invocation& invocation) {
  atmos::imported::TableRequest request;
  const auto asked = [](double value) { return std::isnan(value) ? std::nullopt : std::optional<double>(value); };
  request.sun_zenith_deg = asked(o.sun_zenith), request.sun_azimuth_deg = asked(o.sun_azimuth);
  request.sensor_height_m = asked(o.sensor), request.ground_height_m = asked(o.ground);
  if (!o.albedo.empty()) request.albedo = albedos(o.albedo);
  request.even_sky = o.even_sky, request.partial = o.partial;
  const auto made = atmos::imported::table_of_runs(files, request);
  for (const auto& notice : made.notices) invocation.log.warning(notice);
  const std::string& output = invocation.common.output;
  const std::string hash = atmos::write_rct(
      made.table, output, invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse);
  if (invocation.common.json)
    invocation.out << nlohmann::json{{"table", output}, {"content_hash", hash}, {"notices", made.notices}}.dump(
                          -1, ' ', false, nlohmann::json::error_handler_t::replace)
                   << "\n";
  else
    invocation.out << "table: " << output << "\n";
  return 0;
}

int run(const ImportRequest& o, Invocation& invocation) {
  std::vector<atmos::imported::Imported> files;
  for (const auto& file : o.files)
    files.push_back(atmos::imported::import_file(file, o.format == "auto" ? "" : o.format, o.uvspec_input));
  atmos::imported::tell_geometry(files);
  if (!invocation.common.output.empty()) return write_table(o, files, invocation);
  // One document: of one file as it is, of several a list.
  if (invocation.common.json && files.size() > 1) {
    auto all = nlohmann::ordered_json::array();
    for (const auto& file : files) all.push_back(nlohmann::ordered_json::parse(atmos::imported::imported_json(file)));
    invocation.out << all.dump(-1, ' ', false, decltype(all)::error_handler_t::replace) << "\n";
    return 0;
  }
  for (const auto& file : files)
    invocation.out << (invocation.common.json ? atmos::imported::imported_json(file)
                                              : atmos::imported::imported_text(file));
  return 0;
}

}  // namespace

Verb verb_atmos_import() {
  auto o = std::make_shared<ImportRequest>();
  Verb verb("import", "Read the output of MODTRAN, uvspec or 6S: say what it holds, or make a render table of it");
  verb.description =
      "Units and angles are converted to the project's; damaged rows are refused with file and line; sums that the "
      "code prints "
      "must hold to the printed digits. docs/import_formats.md lists formats and columns.\n\n"
      "With -o TABLE.rct the runs of all FILEs become one render table: paths down give transmission and path "
      "radiance, runs that "
      "look up give the sky, runs over several albedos or the columns A, B and S of a .chn give the light between "
      "ground and air. "
      "The listing (.tp6) or input JSON of a MODTRAN run, given or beside it under its name, tells sun, heights and "
      "day. "
      "What a render needs and the runs lack is listed; directions must form full grids, and one direction alone "
      "serves what is near it: renders that look elsewhere are warned or refused.";
  verb.examples = {"raycube atmos import tape7",
                   "raycube atmos import uvspec.out --uvspec-input uvspec.inp --json",
                   "raycube atmos import down.tp7 sky.tp7 -o flight.rct",
                   "raycube atmos import run.chn run.tp6 --even-sky -o flight.rct",
                   "raycube atmos import 0.55.txt 0.65.txt 0.85.txt --sensor-height 700e3 --even-sky -o 6s.rct",
                   "raycube atmos import run.chn --sun-zenith 52 --sensor-height 2000 --even-sky -o flight.rct"};
  verb.common = kOutput;
  verb.output_default = "FILEs are described, no table is made";
  verb.add_options = [o](base::OptionTable& table) {
    std::vector<std::string> formats{"auto"};
    for (const auto& name : atmos::imported::format_names()) formats.push_back(name);
    auto& files = table.texts("FILE", "FILE", "What the other code wrote", o->files);
    files.positional = files.required = true;
    table.choice("--format", formats, "Format of the FILEs; auto: by name and first lines", o->format);
    table.text("--uvspec-input", "FILE", "Input file of a uvspec run", o->uvspec_input).default_text =
        "FILE with the ending .inp";
    table.number("--sun-zenith", "deg", 0, 180, "Table: sun zenith angle", o->sun_zenith).default_text = "the runs'";
    table.number("--sun-azimuth", "deg", -360, 360, "Table: sun azimuth, clockwise from north", o->sun_azimuth)
        .default_text = "the runs', else 0";
    table.number("--sensor-height", "m", -1000, 1e9, "Table: sensor height above z = 0", o->sensor).default_text =
        "the runs'";
    table.number("--ground-height", "m", -1000, 1e5, "Table: height of z = 0 in the runs' heights", o->ground)
        .default_text = "the runs' ground, else 0";
    table.text("--albedo", "LIST", "Table: ground albedo of each run that looks down, as 0,0.3,0.8", o->albedo)
        .default_text = "1 - the runs' emissivity";
    table.flag("--even-sky", "Table: where no sky was computed, spread the diffuse irradiance evenly over it",
               o->even_sky);
    table.flag("--partial", "Table: write what there is, though a render needs more (for plot and compare)",
               o->partial);
  };
  verb.run = [o](Invocation& invocation) { return run(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
