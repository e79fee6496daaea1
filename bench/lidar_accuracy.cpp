// Settings of a LIDAR against error and time, one JSON file for bench/lidar_accuracy.py: sub-rays, bins of the pulse's
// shape, bounces, spectral nodes, and ranges at which plain floats fail. Every error is against a closed form or a
// converged run named beside it.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/scenes/scenes.h"
#include "host/base/standard_streams.h"
#include "host/lidar/gauss_hermite.h"
#include "host/lidar/pulse_taps.h"
#include "host/render/lidar_renderer.h"
#include "tests/support/lidar_kit.h"

namespace {

using namespace raycube;
using nlohmann::json;

std::vector<float> rows(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                        const std::vector<lidar::Shot>& shots, double* seconds = nullptr) {
  render::LidarRenderer renderer(scene, {});
  std::vector<float> out;
  double best = 1e30;
  double spent = 0;
  for (int repeat = 0; repeat < (seconds ? 40 : 1) && (repeat < 5 || spent < 0.3);
       ++repeat) {  // the first builds the program
    out.clear();
    renderer.render(plan, shots, [&](lidar::ShotResult&& r) {
      for (std::size_t i = 0; i < r.first.size(); ++i)
        out.push_back(r.first[i] + (r.multiple.empty() ? 0.0f : r.multiple[i]));
    });
    if (repeat > 0) best = std::min(best, renderer.launch_s()), spent += renderer.launch_s();
  }
  if (seconds) *seconds = best;
  return out;
}

/// rms difference over the rms of the shots' peaks.
double waveform_error(const std::vector<float>& found, const std::vector<float>& exact, std::size_t bins) {
  double square = 0, peaks = 0;
  for (std::size_t s = 0; s < exact.size(); s += bins) {
    double peak = 0;
    for (std::size_t i = s; i < s + bins; ++i)
      square += std::pow(found[i] - exact[i], 2), peak = std::max<double>(peak, exact[i]);
    peaks += peak * peak;
  }
  return std::sqrt(square / peaks);
}

scene::Lidar over_ground(int subrays) {
  scene::Lidar lidar = test::topographic_lidar();
  lidar.pulse.half_divergence_rad = 0.5 / 600;
  lidar.gate = {2 * 560 / test::kLightSpeed, 1e-9, 400};
  lidar.transport.subrays = subrays;
  return lidar;
}

std::vector<lidar::Shot> raster(const scene::Lidar& lidar) {
  std::vector<lidar::Shot> shots;
  for (int i = 0; i < 400; ++i)
    shots.push_back(
        test::shot_from(lidar, {0, 0, 600}, {-90 + 9.0 * (i % 20) + 0.37, -90 + 9.0 * (i / 20) + 0.11, -600}, i));
  return shots;
}

json subrays() {
  const scene::CompiledScene terrain = bench::compile({bench::terrain_mesh()}, {{bench::kIdentity}});
  scene::CompiledScene slope = test::scene_of({0.3});
  test::add_plane(slope, 0, {0, 0, 0}, 400, M_PI / 4);
  scene::finish_top_tree(slope);
  json out = json::array();
  for (const auto& [name, scene] :
       {std::pair<const char*, const scene::CompiledScene*>{"terrain with spheres and boxes", &terrain},
        {"plane at 45 degrees", &slope}}) {
    const auto at = [&](int n, double* seconds) {
      const scene::Lidar lidar = over_ground(n);
      return rows(*scene, test::hand_plan(lidar, *scene), raster(lidar), seconds);
    };
    const auto exact = at(32768, nullptr);
    for (const int n : {1, 4, 16, 64, 256, 1024, 4096}) {
      double seconds = 0;
      const auto found = at(n, &seconds);
      out.push_back({{"scene", name},
                     {"setting", n},
                     {"error", waveform_error(found, exact, 400)},
                     {"us_per_pulse", 1e6 * seconds / 400}});
    }
  }
  return out;
}

/// Bin values of one return at many places, against the pulse's integral: our shares between phases, and counting in
/// sub-bins.
json shape() {
  scene::LidarPulse pulse;
  pulse.fwhm_s = 4e-9;
  json out = json::array();
  const auto error_of = [&](const auto& share) {
    double worst = 0, largest = 0;
    for (int k = 0; k < 997; ++k)
      for (int bin = 0; bin < 40; ++bin) {
        const double at = 20 + k * 0.0010030090270812437,
                     exact = lidar::pulse_share(pulse, (bin - at) * 1e-9, (bin + 1 - at) * 1e-9);
        worst = std::max(worst, std::abs(share(at, bin) - exact)), largest = std::max(largest, exact);
      }
    return worst / largest;
  };
  for (const int cells : {1, 2, 4, 10, 20, 100}) {  // to the middle of its sub-bin
    const auto counted = [&](double at, int bin) {
      const double moved = (std::floor(at * cells) + 0.5) / cells;
      return lidar::pulse_share(pulse, (bin - moved) * 1e-9, (bin + 1 - moved) * 1e-9);
    };
    out.push_back({{"method", "counted in sub-bins"}, {"setting", cells}, {"error", error_of(counted)}});
  }
  for (const int phases : {1, 2, 4, 16, 64, 256}) {
    const auto taps = test::make_taps(pulse, 1e-9, phases);
    const auto linear = [&](double at, int bin) {
      const double whole = std::floor(at), phase = (at - whole) * phases;
      const int q = std::min(static_cast<int>(phase), phases - 1), i = bin - static_cast<int>(whole) - taps.first;
      if (i < 0 || i >= taps.taps) return 0.0;
      const float *low = taps.share.data() + q * taps.taps + i, *high = low + taps.taps;
      return *low + (phase - q) * (*high - *low);
    };
    out.push_back({{"method", "shares between phases"}, {"setting", phases}, {"error", error_of(linear)}});
  }
  return out;
}

/// Light of a right-angled corner at up to n bounces, against the sum of all orders (LIDAR specification, 7.4).
json bounces() {
  scene::CompiledScene corner = test::scene_of({0.5, 0.4});
  test::add_corner(corner, 0, 1, 20000, 20000, 20000);
  scene::finish_top_tree(corner);
  json out = json::array();
  for (const int n : {1, 2, 3, 4, 6, 8}) {
    scene::Lidar lidar = test::topographic_lidar();
    lidar.pulse.half_divergence_rad = 1e-9;
    lidar.transport.subrays = 4096;
    lidar.transport.max_bounces = n;
    lidar.gate = {2 * 990 / test::kLightSpeed, 1e-6, 400};
    std::vector<lidar::Shot> shots;
    const double s = 1000 / M_SQRT2;
    for (int i = 0; i < 64; ++i) shots.push_back(test::shot_from(lidar, {1 + s, 0, s}, {-s, 0, -s}, i));
    double seconds = 0, sum = 0;
    for (const float value : rows(corner, test::hand_plan(lidar, corner), shots, &seconds)) sum += value;
    scene::Lidar once = lidar;
    once.transport.max_bounces = 1;
    double single = 0;
    for (const float value : rows(corner, test::hand_plan(once, corner), shots)) single += value;
    const double all = (1 + 0.4 / 2) / (1 - 0.5 * 0.4 / 4);
    out.push_back({{"setting", n}, {"error", std::abs(sum / single / all - 1)}, {"us_per_pulse", 1e6 * seconds / 64}});
  }
  return out;
}

/// Two-way transmission of a Lorentz line for a Gaussian laser line (LIDAR specification, 2.3), against a fine sum.
json line_nodes() {
  json out = json::array();
  const double gamma = 0.06, peak = 1.061032954e-18;
  for (const auto& [ppm_m, fwhm] : {std::pair{100.0, 0.05}, {1000.0, 0.10}, {10000.0, 0.10}}) {
    const double column = ppm_m * 2.479371580e15, sigma = 0.42466090014400953 * fwhm;
    const auto transmission = [&](double x) {
      return std::exp(-2 * column * peak * gamma * gamma / (gamma * gamma + x * x));
    };
    double exact = 0;
    const double step = 1e-4;
    for (double z = -12; z <= 12; z += step)
      exact += step * std::exp(-z * z / 2) / std::sqrt(2 * M_PI) * transmission(sigma * z);
    for (const int n : {1, 2, 4, 8, 16, 32, 64}) {
      const auto rule = lidar::gauss_hermite(n);
      double found = 0;
      for (std::size_t i = 0; i < rule.x.size(); ++i) found += rule.w[i] * transmission(sigma * rule.x[i]);
      out.push_back({{"case", std::to_string(static_cast<int>(ppm_m)) + " ppm m, " + json(fwhm).dump() + " cm-1"},
                     {"setting", n},
                     {"error", std::abs(found / exact - 1)}});
    }
  }
  return out;
}

/// Device time of a pulse with n nodes in the air.
json node_times() {
  scene::CompiledScene plane = test::scene_of({0.3});
  test::add_plane(plane, 0, {0, 0, 0}, 400);
  scene::finish_top_tree(plane);
  json out = json::array();
  for (const int n : {1, 2, 4, 8, 16, 32, 64}) {
    const scene::Lidar lidar = over_ground(64);
    auto plan = test::hand_plan(lidar, plane);
    plan.nodes.assign(static_cast<std::size_t>(n), {0, 1.064, 1.0 / n});
    plan.first_node = {0, n};
    test::set_air(plan, 1e-4, 0, 0, 700);
    double seconds = 0;
    rows(plane, plan, raster(lidar), &seconds);
    out.push_back({{"setting", n}, {"us_per_pulse", 1e6 * seconds / 400}});
  }
  return out;
}

/// Mean range of a plane's return along a row of shots 10 m long, slope 1e-3, 0.1 ns bins: ours, and what float seconds
/// would say.
json ranges() {
  json out = json::array();
  const double slope = 1e-3;
  scene::CompiledScene plane = test::scene_of({0.3});
  test::add_plane(plane, 0, {0, 0, 0}, 100, -std::atan(slope));  // rises towards +x
  scene::finish_top_tree(plane);
  for (const double height : {600.0, 20e3, 400e3}) {
    scene::Lidar lidar = test::topographic_lidar();
    lidar.pulse.half_divergence_rad = 0.1 / height;
    lidar.pulse.fwhm_s = 0.5e-9;
    lidar.transport.subrays = 256;
    lidar.gate = {2 * (height - 3) / test::kLightSpeed, 0.1e-9, 400};
    std::vector<lidar::Shot> shots;
    for (int i = 0; i < 200; ++i) shots.push_back(test::shot_from(lidar, {-5 + 0.05 * i, 0, height}, {0, 0, -1}, i));
    const auto found = rows(plane, test::hand_plan(lidar, plane), shots);
    double ours = 0, floats = 0;
    for (std::size_t s = 0; s < shots.size(); ++s) {
      const auto m = test::moments({found.begin() + static_cast<std::ptrdiff_t>(s * 400),
                                    found.begin() + static_cast<std::ptrdiff_t>((s + 1) * 400)});
      const double exact = height - slope * shots[s].exit_m[0];
      ours = std::max(ours, std::abs(0.5 * test::kLightSpeed * (lidar.gate.start_s + m.mean_bin * 0.1e-9) - exact));
      const float time = static_cast<float>(2 * exact / test::kLightSpeed);
      floats = std::max(floats, std::abs(0.5 * test::kLightSpeed * static_cast<double>(time) - exact));
    }
    out.push_back({{"range_m", height}, {"ours_m", ours}, {"float_seconds_m", floats}});
  }
  return out;
}

}  // namespace

int main(int count, char** arguments) {
  raycube::base::claim_standard_descriptors();
  if (count != 2) {
    std::cerr << "usage: raycube_lidar_accuracy FILE.json\n";
    return 2;
  }
  const json all = {{"subrays", subrays()},       {"shape", shape()},           {"bounces", bounces()},
                    {"line_nodes", line_nodes()}, {"node_times", node_times()}, {"ranges", ranges()}};
  std::ofstream file(arguments[1]);
  file << all.dump(1) << "\n";
  return file.good() ? 0 : 1;
}
