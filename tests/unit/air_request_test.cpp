// The name under which a table of the built-in models is kept: whatever the table follows from changes it, and
// nothing else does.
#include "host/run/air_request.h"

#include <map>
#include <set>

#include "scene_compiler/option_table.h"
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

const std::vector<double> kWavelengths = {0.5, 0.6}, kHeights = {0, 100};

std::string hash_of(const AtmosphereSpec& spec, const Sun& sun = {}, double sensor_m = 610,
                    const std::vector<double>& um = kWavelengths, const std::vector<double>& heights = kHeights) {
  run::AirRequest request;
  request.spec = &spec;
  request.sun = sun;
  request.sensor_height_m = sensor_m;
  return run::request_hash(request, um, heights);
}

/// Another value of the same kind.
template <class Number>
void change(Number& value) {
  value = static_cast<Number>(value + 1);
}
void change(bool& value) { value = !value; }
void change(std::string& value) { value += "x"; }
void change(std::vector<CloudSpec>& value) { value.push_back({"stratus", 1, 2, 5}); }
void change(std::vector<CrossSectionSpec>& value) { value.push_back({"xy", "", 1}); }
void change(std::vector<OwnAerosolSpec>& value) { value.emplace_back(); }
void change(std::vector<double>& value) { value.push_back(1); }
void change(std::vector<std::vector<double>>& value) { value.push_back({1, 0.5}); }

AtmosphereSpec layered() {
  AtmosphereSpec spec;
  spec.layered.emplace();
  return spec;
}

}  // namespace

TEST_CASE("S18 every field of air_spec.def changes the name of the kept table") {
  const Folder folder;
  std::set<std::string> names = {hash_of(layered())};
  const auto differs = [&](const AtmosphereSpec& spec, const std::string& field) {
    CAPTURE(field);
    CHECK(names.insert(hash_of(spec)).second);
  };
#define RC_AIR(type, name, fallback, text) \
  {                                        \
    auto spec = layered();                 \
    change(spec.layered->name);            \
    differs(spec, #name);                  \
  }
#define RC_AIR_FILE(name, text)                                  \
  {                                                              \
    auto spec = layered();                                       \
    spec.layered->name = folder.write(#name, #name);             \
    differs(spec, #name);                                        \
    std::string before = hash_of(spec);                          \
    folder.write(#name, #name "!");                              \
    CHECK(hash_of(spec) != before);                              \
    before = hash_of(spec);                                      \
    spec.layered->name = folder.write("other" #name, #name "!"); \
    CHECK(hash_of(spec) == before);                              \
  }
#include "scene_compiler/air_spec.def"
  // Those of clouds, cross-sections and own aerosols, one entry each.
  auto base = layered();
  base.layered->clouds = {{"stratus", 1, 2, 5}};
  base.layered->cross_sections = {{"xy", folder.write("xy.csv", "xy"), 1}};
  base.layered->own_aerosols.emplace_back();
  names.insert(hash_of(base));
#define RC_OWN_AEROSOL(type, name, fallback, text) \
  {                                                \
    auto spec = base;                              \
    change(spec.layered->own_aerosols[0].name);    \
    differs(spec, "own_aerosol." #name);           \
  }
#define RC_CLOUD(type, name, fallback, text) \
  {                                          \
    auto spec = base;                        \
    change(spec.layered->clouds[0].name);    \
    differs(spec, "cloud." #name);           \
  }
#define RC_CROSS_SECTION(type, name, fallback, text) \
  {                                                  \
    auto spec = base;                                \
    change(spec.layered->cross_sections[0].name);    \
    differs(spec, "cross_section." #name);           \
  }
#define RC_CROSS_SECTION_FILE(name, text)                                        \
  {                                                                              \
    auto spec = base;                                                            \
    spec.layered->cross_sections[0].name = folder.write("cross" #name, "other"); \
    differs(spec, "cross_section." #name);                                       \
  }
#include "scene_compiler/air_spec.def"
}

TEST_CASE("S18 ground, sun, moon, sensor, wavelengths and heights change it; a file that is gone is said") {
  const auto spec = layered();
  std::set<std::string> names = {hash_of(spec)};
  auto raised = spec;
  raised.ground_height_m = 180;
  CHECK(names.insert(hash_of(raised)).second);
  for (const auto& turn : {+[](Sun& s) { s.zenith_deg = 40; }, +[](Sun& s) { s.azimuth_deg = 40; },
                           +[](Sun& s) { s.day_of_year = 40; }, +[](Sun& s) { s.moon_phase_deg = 40; }}) {
    Sun sun;
    turn(sun);
    CHECK(names.insert(hash_of(spec, sun)).second);
  }
  CHECK(names.insert(hash_of(spec, {}, 611)).second);
  CHECK(names.insert(hash_of(spec, {}, 610, {0.5, 0.61})).second);
  CHECK(names.insert(hash_of(spec, {}, 610, kWavelengths, {0, 101})).second);
  CHECK(hash_of(spec) == hash_of(layered()));
  auto gone = spec;
  gone.layered->lines = "/nowhere/lines.par";
  CHECK_THROWS_WITH_AS(hash_of(gone), doctest::Contains("/nowhere/lines.par: cannot be read"), base::Error);
}

TEST_CASE(
    "S18 every key of [atmosphere] that shapes the layered model changes the name; the test knows all keys "
    "there are") {
  const Folder folder;
  const std::string csv = "\"" + folder.write("a.csv", "x") + "\"";
  const std::string sun = "\"" + folder.write("sun.csv", "wavelength_nm,irradiance_W_m2_nm\n300,1\n3000,1\n") + "\"";
  // A value that is not the default of each key; "-" belongs to another model, or to what the table does not
  // hold.
  const std::map<std::string, std::string> other = {{"model", "-"},
                                                    {"tables", "-"},
                                                    {"angstrom", "-"},
                                                    {"ssa", "-"},
                                                    {"asymmetry", "-"},
                                                    {"ground_albedo", "-"},
                                                    {"adjacency", "-"},
                                                    {"view_zenith_deg", "[0, 30]"},
                                                    {"solar_spectrum", "\"e490\""},
                                                    {"solar_spectrum_file", sun},
                                                    {"spectral_step_nm", "0.5"},
                                                    {"ground_height_m", "150"},
                                                    {"pressure_hPa", "950"},
                                                    {"water_g_cm2", "2.5"},
                                                    {"ozone_atm_cm", "0.4"},
                                                    {"aod_550", "0.3"},
                                                    {"profile", "\"tropical\""},
                                                    {"profile_file", csv},
                                                    {"co2_ppmv", "420"},
                                                    {"ch4_ppmv", "2"},
                                                    {"aerosol", "\"urban\""},
                                                    {"visibility_km", "10"},
                                                    {"humidity_percent", "50"},
                                                    {"season", "\"fall_winter\""},
                                                    {"stratosphere", "\"high_volcanic\""},
                                                    {"wind_m_s", "20"},
                                                    {"cloud", "[{ base_km = 1, top_km = 2, optical_depth_550 = 3 }]"},
                                                    {"own_aerosol",
                                                     "[{ optical_depth = 0.1, angstrom = 1, "
                                                     "single_scattering_albedo = 0.9, asymmetry = 0.6 }]"},
                                                    {"gas_bands", "\"lowtran\""},
                                                    {"streams", "8"},
                                                    {"k_terms", "2"},
                                                    {"layering", "2"},
                                                    {"lines", csv},
                                                    {"line_wing_cm1", "10"},
                                                    {"partition_sums", csv},
                                                    {"cross_section", "[{ gas = \"xy\", file = " + csv + " }]"}};
  // Keys that go with another one.
  const std::map<std::string, std::string> with = {{"wind_m_s", "aerosol = \"desert\"\n"},
                                                   {"line_wing_cm1", "lines = " + csv + "\n"},
                                                   {"partition_sums", "lines = " + csv + "\n"}};
  const LoadOptions no_instruments = [] {
    LoadOptions o;
    o.need_instruments = false;
    return o;
  }();
  const auto hash = [&](const std::string& keys) {
    return hash_of(load(folder, std::string(kHead) + kGrey + "[atmosphere]\n" + keys, no_instruments).atmosphere);
  };
  std::size_t keys = 0;
  for (const KeySpec& spec : option_keys()) {
    if (std::string(spec.table) != "atmosphere") continue;
    ++keys;
    const std::string key(spec.key);
    CAPTURE(key);
    const auto value = other.find(key);
    REQUIRE(value != other.end());
    if (value->second == "-") continue;
    const std::string company = with.count(key) ? with.at(key) : "";
    CHECK(hash(company + key + " = " + value->second + "\n") != hash(company));
  }
  CHECK(keys == other.size());
}

TEST_CASE("S18 every key of [atmosphere] that the clear sky takes changes the name; it refuses all others") {
  const Folder folder;
  const std::string sun = "\"" + folder.write("sun.csv", "wavelength_nm,irradiance_W_m2_nm\n300,1\n3000,1\n") + "\"";
  const std::map<std::string, std::string> taken = {
      {"angstrom", "1.5"},
      {"ssa", "0.9"},
      {"asymmetry", "0.6"},
      {"ground_albedo", "0.2"},
      {"pressure_hPa", "950"},
      {"water_g_cm2", "2.5"},
      {"ozone_atm_cm", "0.4"},
      {"aod_550", "0.3"},
      {"ground_height_m", "150"},
      {"view_zenith_deg", "[0, 30]"},
      {"solar_spectrum", "\"e490\""},
      {"solar_spectrum_file", sun},
  };
  const std::set<std::string> of_no_table = {"model", "tables", "adjacency"};
  LoadOptions no_instruments;
  no_instruments.need_instruments = false;
  const auto hash = [&](const std::string& key) {
    const std::string text = std::string(kHead) + kGrey + "[atmosphere]\nmodel = \"clear_sky\"\n" + key;
    return hash_of(load(folder, text, no_instruments).atmosphere);
  };
  std::set<std::string> names = {hash(""), hash_of(layered())};
  CHECK(names.size() == 2);
  std::size_t keys = 0;
  for (const KeySpec& spec : option_keys()) {
    const std::string key(spec.key);
    if (std::string(spec.table) != "atmosphere" || of_no_table.count(key)) continue;
    CAPTURE(key);
    if (const auto value = taken.find(key); value != taken.end()) {
      CHECK(names.insert(hash(key + " = " + value->second + "\n")).second);
      ++keys;
    } else {
      CHECK_THROWS_AS(hash(key + " = 1\n"), base::Error);
    }
  }
  CHECK(keys == taken.size());
}
