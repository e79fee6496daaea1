// What the plan makes of a LIDAR: shares of bins, sub-rays, air along height, spectral nodes, against integrals and
// closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "atmos_tables/render_table.h"
#include "host/base/error.h"
#include "host/lidar/air_column.h"
#include "host/lidar/footprint.h"
#include "host/lidar/make_lidar_plan.h"
#include "host/lidar/pulse_moments.h"
#include "host/lidar/pulse_taps.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;

namespace {

/// Share of bin `bin` of a hit at a bin position, through the table as kernels read it.
double tap(const lidar::PulseTaps& taps, double position, int bin) {
  const double whole = std::floor(position), phase = (position - whole) * taps.phases;
  const int q = std::min(static_cast<int>(phase), taps.phases - 1), i = bin - static_cast<int>(whole) - taps.first;
  if (i < 0 || i >= taps.taps) return 0;
  const auto at = [&](int row) {
    return static_cast<double>(taps.share[static_cast<std::size_t>(row * taps.taps + i)]);
  };
  return at(q) + (phase - q) * (at(q + 1) - at(q));
}

double worst_tap_error(const scene::LidarPulse& pulse, double bin_s) {
  const auto taps = lidar::make_taps(pulse, bin_s);
  double worst = 0, largest = 0;
  for (int k = 0; k < 3001; ++k) {
    const double position = 40 + k * 0.000733123;
    double sum = 0;
    for (int bin = 0; bin < 100; ++bin) {
      const double exact = lidar::pulse_share(pulse, (bin - position) * bin_s, (bin + 1 - position) * bin_s),
                   found = tap(taps, position, bin);
      worst = std::max(worst, std::abs(exact - found));
      largest = std::max(largest, exact);
      sum += found;
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-6));
  }
  return worst / largest;
}

/// The same through moments of one hit of unit energy, of the largest share; cells by the way.
double worst_moment_error(const scene::LidarPulse& pulse, double bin_s, int& cells) {
  const auto taps = lidar::make_taps(pulse, bin_s);
  const auto moments = lidar::make_moments(taps);
  cells = moments.cells;
  double worst = 0, largest = 0;
  for (int k = 0; cells && k < 3001; ++k) {
    const double position = 40 + k * 0.000733123, whole = std::floor(position), place = (position - whole) * cells;
    const int c = std::min(static_cast<int>(place), cells - 1);
    double total = 0;
    for (int i = 0; i < taps.taps; ++i) {
      double found = 0;
      for (int m = RC_MOMENTS - 1; m >= 0; --m)
        found = found * (place - c - 0.5) +
                static_cast<double>(moments.share[static_cast<std::size_t>((c * RC_MOMENTS + m) * taps.taps + i)]);
      const double begin_s = (whole + taps.first + i - position) * bin_s,
                   exact = lidar::pulse_share(pulse, begin_s, begin_s + bin_s);
      CHECK(found > -1e-9);  // no light is taken away
      worst = std::max(worst, std::abs(exact - found));
      largest = std::max(largest, exact);
      total += found;
    }
    CHECK(total == doctest::Approx(1).epsilon(1e-6));
  }
  return cells ? worst / largest : -1;
}

}  // namespace

TEST_CASE("bad input: a pulse over more bins than a device adds at every hit is refused, one below is not") {
  scene::LidarPulse pulse;
  pulse.fwhm_s = 1e-3;
  CHECK_THROWS_WITH_AS(
      lidar::make_taps(pulse, 1e-9),
      doctest::Contains("in bins of 1.000000 ns, more than 2048 bins); give wider bins (bin_ns) or a shorter pulse"),
      base::Error);
  CHECK(lidar::make_taps(pulse, 1e-4).taps < 60);
  pulse.shape = scene::PulseShape::rectangular;
  pulse.fwhm_s = 2047e-9;
  CHECK(lidar::make_taps(pulse, 1e-9).taps <= 2050);
  pulse.fwhm_s = 2049e-9;
  CHECK_THROWS_AS(lidar::make_taps(pulse, 1e-9), base::Error);
}

TEST_CASE("S28, L-31: the pulse's shares of bins, between phases too, equal its integral") {
  scene::LidarPulse pulse;
  // Linear interpolation, float shares, and 2e-9 beyond 6 standard deviations.
  pulse.fwhm_s = 4e-9;
  CHECK(worst_tap_error(pulse, 1e-9) < 2.5e-6);
  CHECK(worst_tap_error(pulse, 4e-9) < 2.5e-6);
  pulse.fwhm_s = 1e-9;
  CHECK(worst_tap_error(pulse, 1e-9) < 2.5e-6);
  pulse.fwhm_s = 0.1e-9;  // 4096 phases, s = 0.042 bin: h^2 / 8 * 0.49 / s^2
  CHECK(worst_tap_error(pulse, 1e-9) < 5e-6);
  pulse.shape = scene::PulseShape::rectangular;
  pulse.fwhm_s = 2e-9;
  CHECK(worst_tap_error(pulse, 1e-9) < 1e-6);
  pulse.fwhm_s = 2.7e-9;
  CHECK(worst_tap_error(pulse, 1e-9) < 1e-6);
}

TEST_CASE("S28: moments of smooth pulses equal their integral; those with corners have none") {
  scene::LidarPulse pulse;
  int cells = 0;
  for (const auto& [fwhm_s, wanted] : {std::pair{4e-9, 1}, {20e-9, 1}, {2e-9, 2}, {1e-9, 4}, {0.3e-9, 8}}) {
    pulse.fwhm_s = fwhm_s;
    CAPTURE(fwhm_s);
    CHECK(worst_moment_error(pulse, 1e-9, cells) < 4.5e-6);  // 2e-6 of the table, and what the table is off
    CHECK(cells == wanted);
  }
  pulse.fwhm_s = 0.1e-9;
  CHECK(worst_moment_error(pulse, 1e-9, cells) == -1);
  pulse.shape = scene::PulseShape::rectangular;
  pulse.fwhm_s = 2e-9;  // corners at the ends of bins: straight between
  CHECK(worst_moment_error(pulse, 1e-9, cells) < 1e-6);
  pulse.fwhm_s = 2.7e-9;
  CHECK(worst_moment_error(pulse, 1e-9, cells) == -1);
  pulse.shape = scene::PulseShape::tabulated;  // sin^2 over 8.5 bins: smooth, but its ends are not
  for (int k = 0; k <= 64; ++k) {
    pulse.shape_time_s.push_back(8.5e-9 * (k / 64.0 - 0.5));
    pulse.shape_power.push_back(2 / 8.5e-9 * std::pow(std::sin(M_PI * k / 64.0), 2));
  }
  CHECK(worst_moment_error(pulse, 1e-9, cells) < 4.5e-6);
  pulse.fwhm_s = 0;
  pulse.shape = scene::PulseShape::gaussian;
  CHECK(worst_moment_error(pulse, 1e-9, cells) == -1);
}

TEST_CASE("L-31: an impulse on an edge goes to the later bin, a symmetric pulse splits in halves") {
  scene::LidarPulse pulse;
  const auto impulse = lidar::make_taps(pulse, 1e-9);
  CHECK(tap(impulse, 7.0, 7) == 1);
  CHECK(tap(impulse, 7.0, 6) == 0);
  CHECK(tap(impulse, 7.999, 7) == 1);
  pulse.fwhm_s = 0.1e-9;
  const auto narrow = lidar::make_taps(pulse, 1e-9);
  CHECK(tap(narrow, 7.0, 6) == doctest::Approx(0.5).epsilon(1e-6));
  CHECK(tap(narrow, 7.0, 7) == doctest::Approx(0.5).epsilon(1e-6));
}

TEST_CASE("LIDAR 2.2: a tabulated pulse integrates exactly") {
  scene::LidarPulse pulse;
  pulse.shape = scene::PulseShape::tabulated;
  pulse.shape_time_s = {-1e-9, 0, 2e-9};
  pulse.shape_power = {0, 2.0 / 3e-9, 0};
  CHECK(lidar::pulse_share(pulse, -1e-9, 0) == doctest::Approx(1.0 / 3).epsilon(1e-12));
  CHECK(lidar::pulse_share(pulse, 1e-9, 5e-9) == doctest::Approx(2.0 / 3 / 4).epsilon(1e-12));
  CHECK(worst_tap_error(pulse, 0.5e-9) < 1e-6);
}

TEST_CASE("LIDAR 2.1: sub-rays of a Gaussian beam past a straight edge, rms error of the table in the specification") {
  scene::Lidar lidar;
  const double w = 0.25, edge = 0.08, exact = 0.5 * std::erfc(M_SQRT2 * edge / w);
  const auto rms = [&](int n) {
    lidar.transport.subrays = n;
    const auto footprint = lidar::make_footprint(lidar, false);
    double sum = 0;
    for (int turn = 0; turn < 720; ++turn) {
      const double c = std::cos(turn * M_PI / 360), s = std::sin(turn * M_PI / 360);
      int beyond = 0;
      for (std::size_t i = 0; i < footprint.a.size(); ++i)
        beyond += w * (c * footprint.a[i] + s * footprint.b[i]) > edge;
      sum += std::pow(static_cast<double>(beyond) / n - exact, 2);
    }
    return std::sqrt(sum / 720);
  };
  // Published to three digits for random turns; 720 turns estimate an rms to 3 %.
  CHECK(rms(19) == doctest::Approx(0.0392).epsilon(0.05));
  CHECK(rms(64) == doctest::Approx(0.0151).epsilon(0.05));
  CHECK(rms(256) == doctest::Approx(0.00525).epsilon(0.05));
  CHECK(rms(1024) == doctest::Approx(0.00161).epsilon(0.05));
}

TEST_CASE("LIDAR 2.1: a distributed exit widens the spot to w^2 = exit^2 + (divergence R)^2") {
  scene::Lidar lidar;
  lidar.transport.subrays = 4096;
  const auto footprint = lidar::make_footprint(lidar, true);
  REQUIRE(footprint.exit_a.size() == 4096);
  double a2 = 0, exit2 = 0, mixed = 0;
  for (std::size_t i = 0; i < 4096; ++i) {
    a2 += footprint.a[i] * footprint.a[i];
    exit2 += footprint.exit_a[i] * footprint.exit_a[i];
    mixed += footprint.a[i] * footprint.exit_a[i];
  }
  // Variance per axis is a quarter of the 1/e2 radius squared; the last ring of N stops the tail: 0.1 %.
  CHECK(a2 / 4096 == doctest::Approx(0.25).epsilon(2e-3));
  CHECK(exit2 / 4096 == doctest::Approx(0.25).epsilon(2e-3));
  CHECK(std::abs(mixed / 4096) < 0.01 * 0.25);
}

TEST_CASE("S30: air of a constant and of an exponential profile along height") {
  atmos::RenderTable table;
  table.axes["wavelength"] = {"wavelength", "um", {0.532, 1.064}};
  std::vector<double> heights;
  for (int i = 0; i <= 40; ++i) heights.push_back(100.0 * i);
  table.axes["range_height"] = {"range_height", "m", heights};
  const auto row = [&](const char* name, double at_ground, double scale_m) {
    atmos::Row& r = table.rows[name];
    r.name = name;
    r.axes = {"wavelength", "range_height"};
    for (int w = 0; w < 2; ++w)
      for (const double h : heights) r.values.push_back(at_ground * std::exp(-h / scale_m) / (1 + w));
  };
  row("lidar_extinction_molecular", 1.3e-5, 8000);
  row("lidar_extinction_aerosol", 1e-4, 1000);
  row("lidar_backscatter_molecular", 1.5e-6, 8000);
  row("lidar_backscatter_aerosol", 2e-6, 1000);
  row("lidar_depolarization", 0.01, 1e12);
  const std::vector<lidar::SpectralNode> nodes = {{0, 0.532, 0.5}, {0, 1.064, 0.5}};
  CHECK(lidar::table_wavelengths(nodes) == std::vector<double>{0.532, 1.064});
  const auto air = lidar::make_air(table, nodes, 1, -50, 3000);
  const auto depth_to = [&](std::size_t n, double z) {
    const double at = (z - air.z0_m) / air.dz_m;
    const auto i = static_cast<std::size_t>(at);
    const double* d = air.depth.data() + n * static_cast<std::size_t>(air.posts);
    return d[i] + (at - std::floor(at)) * (d[i + 1] - d[i]);
  };
  const auto exact = [](double z) {  // from the ground
    return 1.3e-5 * 8000 * (1 - std::exp(-z / 8000)) + 1e-4 * 1000 * (1 - std::exp(-z / 1000));
  };
  for (const double z : {10.0, 333.0, 1000.0, 2990.0}) {
    const double from_ground = depth_to(0, z) - depth_to(0, 0);
    CHECK(from_ground ==
          doctest::Approx(exact(z)).epsilon(1e-4 + 0.02 * 20 / z));  // dz^2/8 of the slope within one post
    CHECK(depth_to(1, z) - depth_to(1, 0) == doctest::Approx(0.5 * from_ground).epsilon(1e-9));
  }
  CHECK(depth_to(0, 0) - depth_to(0, -50) == doctest::Approx(50 * 1.13e-4).epsilon(1e-3));  // ground air goes on below
  CHECK(air.backscatter_per_m_sr[0] == doctest::Approx(0.75 * 3.5e-6).epsilon(1e-9));
}

TEST_CASE("LIDAR 2.3: nodes of a line keep its mean and width; a reflectance is the line's mean") {
  scene::Simulation simulation;
  simulation.scene = test::scene_of({0.3});
  test::add_plane(simulation.scene, 0, {0, 0, 0}, 5);
  scene::finish_top_tree(simulation.scene);
  scene::Lidar lidar = test::topographic_lidar();
  lidar.trajectory = {{0, 0, 0, 1000, 0, 0, 0}};
  lidar.pulse.lines[0].fwhm_um = 1e-4;
  lidar.transport.line_nodes = 16;
  auto& curve = simulation.scene.materials[0].reflectance;
  const double center = lidar.pulse.lines[0].wavelength_um;
  curve = {{center - 0.1, center, center + 0.1},
           {0.3, 0.3, 0.5}};  // a kink at the centre: mean 0.3 + slope sigma / sqrt(2 pi)
  const auto plan = lidar::make_lidar_plan(simulation, lidar, nullptr);
  double weight = 0, mean = 0, square = 0;
  for (const auto& node : plan.nodes) {
    weight += node.weight, mean += node.weight * (node.wavelength_um - center),
        square += node.weight * std::pow(node.wavelength_um - center, 2);
  }
  const double sigma = 1e-4 * 0.42466090014400953;
  CHECK(weight == doctest::Approx(1).epsilon(1e-12));
  CHECK(std::abs(mean) < 1e-15);
  CHECK(square == doctest::Approx(sigma * sigma).epsilon(1e-9));
  CHECK(plan.matter[0].reflectance == doctest::Approx(0.3 + 2 * sigma / std::sqrt(2 * M_PI)).epsilon(1e-6));
  lidar.pulse.lines[0].wavelength_um = 2;
  CHECK_THROWS_AS(lidar::make_lidar_plan(simulation, lidar, nullptr), base::Error);
}
