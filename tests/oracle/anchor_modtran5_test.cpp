// whole tables against MODTRAN 5.2.1 (anchors/modtran521_pybsm_mls_rural.csv: US Air Force Research Laboratory
// runs published with pyBSM). Scene: midlatitude summer, rural aerosol of 23 or 5 km, CO2 360 ppmv, sun at 50 degrees
// on day 236, 90 degrees beside the view, forest around (its albedo is in the file's header) at 297 K; triangular slit,
// 20 nm wide, every 10 nm.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "host/base/planck.h"
#include "tests/support/full.h"
#include "tests/support/layered_anchor.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

constexpr double kPi = 3.14159265358979;
const char* const kFile = "anchors/modtran521_pybsm_mls_rural.csv";

struct Path {
  const char* name;
  double sensor_m, zenith_deg, visibility_km;
  /// 2 km has the gases of 1 km and 20 km between them: of all cases.
  bool looked_at() const { return sensor_m != 2000 || testing::full(); }
};
const Path kPaths[] = {{"h1000_g0_v23", 1000, 0, 23},
                       {"h2000_g0_v23", 2000, 0, 23},
                       {"h20000_g0p3_v23", 20000, 0, 23},
                       {"h1000_g500_v23", 1000, 26.565, 23},
                       {"h1000_g0_v5", 1000, 0, 5}};

scene::AtmosphereSpec scene_of(const Path& path) {
  auto spec = testing::summer_rural_air();
  spec.layered->co2_ppmv = 360;
  spec.layered->visibility_km = path.visibility_km;
  return spec;
}

/// The forest around the target, from the header of the reference.
double forest_albedo(double um) {
  const std::pair<double, double> nodes[] = {
      {0.2, .025},   {0.5, .036}, {0.7, .032},  {0.725, .097}, {0.75, .254}, {0.775, .314}, {0.9, .31},
      {0.925, .419}, {1, .4},     {1.25, .384}, {1.3, .337},   {1.35, .287}, {1.4, .236},   {1.45, .191},
      {1.5, .162},   {1.55, .19}, {1.6, .216},  {1.65, .24},   {1.7, .265},  {1.75, .321},  {1.8, .238},
      {1.85, .185},  {1.9, .135}, {1.95, .098}, {2, .058},     {2.5, .05},   {3, .057},     {3.5, .062},
      {4, .054},     {4.5, .048}, {5, .042},    {5.5, .036},   {6, .034},    {6.5, .033},   {7, .031},
      {7.5, .03},    {8, .03},    {11, .03},    {12, .038},    {13, .03},    {14, .016}};
  std::size_t i = 1;
  while (i + 1 < std::size(nodes) && nodes[i].first < um) ++i;
  const auto [a, low] = nodes[i - 1];
  const auto [b, high] = nodes[i];
  return low + (high - low) * (um - a) / (b - a);
}

std::vector<double> grid(double from_um, double to_um, double step_um) {
  std::vector<double> out;
  for (int i = 0; from_um + i * step_um < to_um + 1e-9; ++i) out.push_back(from_um + i * step_um);
  return out;
}

/// The reference's mean over a box, its points 10 nm apart.
double reference_mean(std::vector<testing::AnchorRow>& rows, double um, double half_um, const std::string& column) {
  static const std::vector<double> at = [&] {  // of the one file
    std::vector<double> out;
    for (testing::AnchorRow& row : rows) out.push_back(row["wavelength_um"]);
    return out;
  }();
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double off = std::abs(at[i] - um);
    const double weight = off < half_um - 1e-6 ? 1 : off < half_um + 1e-6 ? 0.5 : 0;
    if (weight > 0) sum += weight * rows[i].at(column), weights += weight;
  }
  return sum / weights;
}

struct Band {
  double from_um, to_um;
};

}  // namespace

TEST_CASE("A-13 S3.2 tables' transmission 0.58 to 3.96 um against MODTRAN 5.2.1") {
  auto rows = testing::anchor_rows(kFile, "tables were not compared with MODTRAN 5.2.1");
  if (rows.empty()) return;
  testing::ChartRows chart("modtran5_transmission", "um,t1,r1,t2,r2,t20,r20,t5,r5");
  const std::vector<double> um = grid(0.41, 4.0, 0.005);
  const auto columns = std::array{0, 1, 2, 4};
  std::vector<std::vector<double>> found;
  for (int p : columns) {
    if (!kPaths[p].looked_at()) {
      found.emplace_back();
      continue;
    }
    auto spec = scene_of(kPaths[p]);
    // Transmissions are the band model's: neither k-terms nor streams nor the sun touch them.
    spec.layered->k_terms = 1, spec.layered->streams = 2;
    const RenderTable table = build_layered(spec, testing::sun_at(testing::kNight_deg), kPaths[p].sensor_m, um, {0});
    const auto t = view_transmission(table, 0, kPaths[p].zenith_deg);
    std::vector<double>& slit = found.emplace_back(um.size(), -1.0);  // triangle of 20 nm
    for (std::size_t k = 4; k + 4 < um.size(); ++k) {
      slit[k] = 0;
      for (int d = -3; d <= 3; ++d) slit[k] += (4 - std::abs(d)) / 16.0 * t[k + static_cast<std::size_t>(d + 4) - 4];
    }
  }
  struct Limit {
    Band band;
    std::array<double, 4> rms;  ///< S3.2 at 1, 2, 20 km; the last is 1 km in haze, which has 1 km's gases
  };
  const Limit limits[] = {{{0.58, 0.70}, {.0015, .002, .003, .0015}}, {{0.7, 1.0}, {.004, .005, .007, .004}},
                          {{1.0, 1.3}, {.006, .007, .014, .006}},     {{1.3, 1.5}, {.014, .015, .017, .014}},
                          {{1.45, 1.75}, {.009, .012, .015, .009}},   {{1.75, 2.0}, {.012, .012, .015, .012}},
                          {{2.0, 2.4}, {.011, .016, .022, .011}},     {{2.4, 3.0}, {.013, .011, .010, .013}},
                          {{3.0, 3.4}, {.030, .028, .026, .030}},     {{3.4, 3.96}, {.026, .028, .029, .026}}};
  std::printf("rms of T at 1, 2, 20 km and at 1 km in 5 km haze, each with its bar\n");
  for (const Limit& limit : limits) {
    std::printf("%4.2f-%4.2f um:", limit.band.from_um, limit.band.to_um);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (found[c].empty()) continue;
      testing::Errors error;
      for (std::size_t k = 4; k + 4 < um.size(); ++k) {
        if (um[k] < limit.band.from_um - 1e-6 || um[k] > limit.band.to_um - 1e-6 || k % 2 != 0) continue;
        error.add(found[c][k] - reference_mean(rows, um[k], 0.001, std::string("T_") + kPaths[columns[c]].name));
      }
      error.close();
      std::printf("  %.4f / %.4f", error.rms, 1.3 * limit.rms[c]);
      CAPTURE(limit.band.from_um);
      CAPTURE(kPaths[columns[c]].name);
      CHECK(error.rms <= 1.3 * limit.rms[c]);
    }
    std::printf("\n");
  }
  for (std::size_t k = 4; k + 4 < um.size() && testing::full(); k += 2) {
    std::vector<double> line = {um[k]};
    for (std::size_t c = 0; c < columns.size(); ++c)
      line.insert(line.end(),
                  {found[c][k], reference_mean(rows, um[k], 0.001, std::string("T_") + kPaths[columns[c]].name)});
    chart.add(line);
  }
}

TEST_CASE("A-13 S3.1 tables' transmission and thermal path radiance 3.4 to 13 um against MODTRAN 5.2.1") {
  auto rows = testing::anchor_rows(kFile, "thermal tables were not compared with MODTRAN 5.2.1");
  if (rows.empty()) return;
  testing::ChartRows chart("modtran5_thermal", "um,t1,rt1,l1,rl1,t20,rt20,l20,rl20,t5,rt5,l5,rl5");
  const std::vector<double> um = grid(3.4, 13.04, 0.04);
  std::vector<std::vector<double>> drawn = {um};
  struct Limit {
    Band band;
    std::array<double, 3> t, ratio;  ///< S3.1 at 1, 2, 20 km
  };
  const Limit limits[] = {
      {{3.4, 3.6}, {-.082, -.086, -.072}, {1.70, 1.45, 1.19}}, {{3.6, 3.8}, {-.081, -.087, -.085}, {1.80, 1.53, 1.29}},
      {{3.8, 4.0}, {-.044, -.052, -.039}, {1.79, 1.53, 1.24}}, {{4.4, 4.6}, {-.023, -.014, -.006}, {1.06, 1.03, 1.06}},
      {{4.6, 4.8}, {-.028, -.026, -.012}, {1.11, 1.06, 1.01}}, {{8.0, 8.5}, {-.047, -.051, -.048}, {1.15, 1.12, 1.06}},
      {{8.5, 9.0}, {-.002, -.007, -.015}, {1.02, 1.03, 1.03}}, {{9.0, 9.4}, {-.003, -.004, -.006}, {1.02, 1.02, 0.98}},
      {{9.4, 10}, {-.021, -.022, .059}, {1.13, 1.09, 1.00}},   {{10, 10.5}, {-.006, -.002, -.007}, {1.04, 1.01, 0.97}},
      {{10.5, 11}, {.012, .019, .023}, {0.94, 0.93, 0.91}},    {{11, 11.5}, {.018, .024, .026}, {0.93, 0.92, 0.92}},
      {{11.5, 12}, {.020, .024, .027}, {0.93, 0.94, 0.93}},    {{12, 12.5}, {-.001, .001, -.003}, {1.00, 1.00, 0.98}},
      {{12.5, 13}, {.036, .038, .030}, {0.93, 0.94, 0.92}},    {{8, 13}, {-.005, -.005, .005}, {1.00, 1.00, 0.97}}};
  for (const Path& path : kPaths) {
    if (!path.looked_at()) continue;
    auto spec = scene_of(path);
    spec.layered->streams =
        8;  // the solver gives what is scattered, a tenth of this light at most: 1e-3 of it from 16 streams
    const RenderTable table = build_layered(spec, testing::sun_at(testing::kNight_deg), path.sensor_m, um, {0});
    const auto t = view_transmission(table, 0, path.zenith_deg);
    auto light = path_radiance_thermal(table, 0, path.zenith_deg);
    // MODTRAN's path radiance holds what the air scatters of the forest's light: T_dif times what leaves the ground
    // (S4.9).
    const auto through = diffuse_view_transmission(table, 0, path.zenith_deg), albedo = spherical_albedo(table, 0);
    const auto sky =
        sky_radiance_thermal(table, 0, 53);  // stands for its hemisphere; the forest reflects 3 to 6 % of it
    for (std::size_t k = 0; k < um.size(); ++k) {
      const double reflects = forest_albedo(um[k]);
      const double ground =
          ((1 - reflects) * base::planck_radiance(um[k], 297) + reflects * sky[k]) / (1 - reflects * albedo[k]);
      light[k] += through[k] * ground;
    }
    std::vector<double> rt, rl;
    for (double at : um) {
      rt.push_back(reference_mean(rows, at, 0.02, std::string("T_") + path.name));
      rl.push_back(reference_mean(rows, at, 0.02, std::string("Lthermal_") + path.name));
    }
    std::printf("%s: error of T, ratio of path radiance, each with S3.1's figure\n", path.name);
    const std::size_t column = path.sensor_m < 1500 ? 0 : path.sensor_m < 3000 ? 1 : 2;
    for (const Limit& limit : limits) {
      double mean = 0, weights = 0, ours = 0, theirs = 0;
      for (std::size_t k = 0; k < um.size(); ++k) {
        const double off = std::max(limit.band.from_um - um[k], um[k] - limit.band.to_um);
        if (off > 1e-6) continue;
        const double weight = off < -1e-6 ? 1 : 0.5;  // bins on the band's ends reach half into it
        mean += weight * (t[k] - rt[k]), weights += weight, ours += weight * light[k], theirs += weight * rl[k];
      }
      mean /= weights;
      const double ratio = ours / theirs;
      std::printf("  %4.1f-%4.1f um: T %+.4f (%+.3f)  L %.3f (%.2f)\n", limit.band.from_um, limit.band.to_um, mean,
                  limit.t[column], ratio, limit.ratio[column]);
      CAPTURE(path.name);
      CAPTURE(limit.band.from_um);
      CHECK(std::abs(mean) <= std::abs(limit.t[column]) + 0.01);
      // S3.1 prints two digits: half of the last is added to 0.01. Its ratios are LOWTRAN7's at nadir (the slant path
      // is 1.12 times as long), with layers of one temperature. These tables miss them where T does: 4.4 to 4.8 um
      // (LOWTRAN7's N2O and CO bands: T -0.034 at 1 km) and 12 to 12.5 um (between its water lines T is 0.007 too high,
      // of an emissivity of 0.3).
      const bool known = limit.band.from_um < 4.7 && limit.band.from_um > 4.3;
      const double more = known ? 0.03 : limit.band.from_um == 12 || path.zenith_deg > 0 ? 0.025 : 0.015;
      CHECK(std::abs(ratio - 1) <= std::abs(limit.ratio[column] - 1) + more);
    }
    if (path.zenith_deg == 0 && path.sensor_m != 2000)
      for (const auto& values : {t, rt, light, rl}) drawn.push_back(values);
  }
  for (std::size_t k = 0; k < um.size(); ++k) {
    std::vector<double> line;
    for (const auto& values : drawn) line.push_back(values[k]);
    chart.add(line);
  }
}

// MODTRAN's own solar spectrum is not in the figures; it and the table's differ by up to 2 %. Found: within 5 % below
// 0.7 um and 7.7 % beyond, in haze too. From 0.72 to 0.76 um the forest's red edge inside a bin of 40 nm decides, in
// the bands of water, CO2 and O2 (1.27 um, which the model lacks) the absorption; they are left out.
TEST_CASE("A-13 tables' solar path radiance in the windows from 0.4 to 2.4 um against MODTRAN 5.2.1") {
  auto rows = testing::anchor_rows(kFile, "solar path radiance was not compared with MODTRAN 5.2.1");
  if (rows.empty()) return;
  testing::ChartRows chart("modtran5_path", "um,l1,r1,l20,r20,l5,r5");
  for (const Band& window :
       {Band{0.40, 0.68}, Band{0.80, 0.88}, Band{1.00, 1.08}, Band{1.56, 1.72}, Band{2.12, 2.36}}) {
    const std::vector<double> um = grid(window.from_um, window.to_um, 0.04);
    std::vector<std::vector<double>> drawn = {um};
    for (const Path& path : {kPaths[0], kPaths[2], kPaths[4]}) {
      const RenderTable table = build_layered(scene_of(path), testing::sun_at(50, 236), path.sensor_m, um, {0});
      auto light = path_radiance(table, 0, path.zenith_deg, 90);
      // The reference scatters the forest's light into the path: T_dif times what leaves the ground (S4.9).
      const auto through = diffuse_view_transmission(table, 0, path.zenith_deg), albedo = spherical_albedo(table, 0);
      const auto direct = direct_irradiance(table, 0), diffuse = diffuse_irradiance(table, 0);
      std::vector<double> reference;
      testing::Errors error;
      for (std::size_t k = 0; k < um.size(); ++k) {
        const double reflects = forest_albedo(um[k]);
        light[k] += through[k] * reflects * (direct[k] + diffuse[k]) / kPi / (1 - reflects * albedo[k]);
        reference.push_back(reference_mean(rows, um[k], 0.02, std::string("Lsolscat_") + path.name));
        error.add(light[k] / reference[k] - 1);
      }
      error.close();
      std::printf("%-16s %.2f-%.2f um: path radiance %+.3f, worst %+.3f\n", path.name, window.from_um, window.to_um,
                  error.mean, error.worst);
      CAPTURE(path.name);
      CAPTURE(window.from_um);
      CHECK(std::abs(error.mean) <= 0.07);
      CHECK(std::abs(error.worst) <= 0.11);
      drawn.push_back(light), drawn.push_back(reference);
    }
    for (std::size_t k = 0; k < um.size(); ++k) {
      std::vector<double> line;
      for (const auto& values : drawn) line.push_back(values[k]);
      chart.add(line);
    }
  }
}
