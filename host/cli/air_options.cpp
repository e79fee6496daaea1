#include "host/cli/air_options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"

namespace raycube::cli {

namespace {

bool is_model(const std::string& name) {
  return std::find(atmos::kAfglNames.begin(), atmos::kAfglNames.end(), name) != atmos::kAfglNames.end();
}

void apply_profile(const AirOptions& o, scene::AirSpec& air) {
  if (!o.profile.empty()) {
    if (is_model(o.profile))
      air.profile = o.profile, air.profile_file.clear();
    else
      air.profile_file = std::filesystem::absolute(o.profile).lexically_normal().string();
  }
  if (o.fill.empty()) return;
  if (air.profile_file.empty())
    throw base::Error(
        base::Fault::input,
        "--fill " + o.fill +
            ": there is no profile file to fill; name one with --profile, or name the model itself there");
  air.profile = o.fill;
}

/// --visibility or --aod, as typed; empty: neither.
std::string typed_amount(const AirOptions& o) {
  if (o.aod_550 > 0) return fmt::format("--aod {:g}", o.aod_550);
  if (!std::isnan(o.visibility_km)) return fmt::format("--visibility {:g}", o.visibility_km);
  return std::isnan(o.humidity_percent) ? "" : fmt::format("--humidity {:g}", o.humidity_percent);
}

void apply_aerosol(const AirOptions& o, scene::AirSpec& air) {
  if (!std::isnan(o.visibility_km) && !std::isnan(o.aod_550))
    throw base::Error(base::Fault::input,
                      fmt::format("--visibility {:g} and --aod {:g} both say how much aerosol there is; remove one",
                                  o.visibility_km, o.aod_550));
  const bool none = (o.aerosol.empty() ? air.aerosol : o.aerosol) == "none";
  const std::string amount = typed_amount(o);
  const bool zero = o.aod_550 == 0;  // which would leave the file's own as they are
  if ((zero || (none && !amount.empty())) && o.aerosol.empty() && !air.own_aerosols.empty())
    throw base::Error(base::Fault::input,
                      (zero ? "--aod 0" : amount) +
                          ": the file has aerosols of its own alone, each with its optical_depth; change that, or "
                          "name an aerosol with --aerosol in their place");
  if (none && !amount.empty())
    throw base::Error(base::Fault::input,
                      amount + ": there is no aerosol (" +
                          (o.aerosol.empty() ? "the file has aerosol = \"none\"" : "--aerosol none") +
                          "); remove it, or name an aerosol");
  if (!o.aerosol.empty()) air.aerosol = o.aerosol, air.own_aerosols.clear();
  if (none) {  // what a file said of another aerosol goes with it
    const scene::AirSpec fresh;
    air.aod_550 = fresh.aod_550, air.visibility_km = fresh.visibility_km, air.humidity_percent = fresh.humidity_percent;
  }
  if (!std::isnan(o.visibility_km)) air.visibility_km = o.visibility_km, air.aod_550 = -1;
  if (!std::isnan(o.aod_550) && !none) air.aod_550 = o.aod_550;
  if (!std::isnan(o.humidity_percent)) air.humidity_percent = o.humidity_percent;
}

}  // namespace

void add_air_options(base::OptionTable& table, AirOptions& o, const char* aod_standing) {
  table
      .text("--profile", "NAME|FILE",
            "layered: tropical, midlatitude_summer or _winter, subarctic_summer or _winter, us_standard, or "
            "a CSV profile",
            o.profile)
      .default_text = "FILE's, or us_standard";
  table
      .choice("--fill", {atmos::kAfglNames.begin(), atmos::kAfglNames.end()},
              "layered: model that gives what a CSV profile lacks: gases without a column, the air above its "
              "last level",
              o.fill)
      .default_text = "FILE's, or us_standard";
  table
      .text("--aerosol", "NAME",
            "layered: aerosol of the lowest 2 km: none, rural, urban, maritime, desert, tropospheric, "
            "fog_advective, fog_radiative",
            o.aerosol)
      .default_text = "FILE's, or rural";
  table.number("--visibility", "km", 0.02, 323, "layered: meteorological range; excluded by --aod", o.visibility_km)
      .default_text = "FILE's, or 23";
  table.number("--aod", "", 0, 5, "Aerosol optical depth at 0.55 um; excluded by --visibility", o.aod_550)
      .default_text = aod_standing;
  table.number("--humidity", "%", 0, 99, "layered: relative humidity that swells the aerosol", o.humidity_percent)
      .default_text = "FILE's, or the profile's";
}

void apply(const AirOptions& options, scene::AirSpec& air) {
  apply_profile(options, air);
  apply_aerosol(options, air);
}

}  // namespace raycube::cli
