// Band integrals against closed forms: what the plan's weights make of spectra whose band value is known.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include "host/base/error.h"
#include "host/plan/quadrature.h"
#include "host/plan/spectral_plan.h"
#include "scene_compiler/matter.h"

using namespace raycube;

namespace {

constexpr double kLn2 = std::numbers::ln2;

scene::Band gaussian(double center_um, double fwhm_um) {
  scene::Band band;
  band.center_um = center_um;
  band.fwhm_um = fwhm_um;
  band.name = "b" + std::to_string(static_cast<int>(std::lround(1000 * center_um)));
  return band;
}

scene::Band tabulated(std::vector<double> wavelength_um, std::vector<double> response) {
  scene::Band band;
  band.wavelength_um = std::move(wavelength_um);
  band.response = std::move(response);
  band.name = "tab";
  return band;
}

std::vector<double> steps(double first, double last, double step) {
  std::vector<double> out;
  for (int i = 0; first + i * step <= last + 1e-12; ++i) out.push_back(first + i * step);
  return out;
}

/// sum_i w_i f(l_i)
template <class F>
double band_value(const plan::BandQuadrature& q, const plan::SpectralGrid& grid, F f) {
  double sum = 0;
  for (std::size_t i = 0; i < q.weight.size(); ++i) sum += q.weight[i] * f(grid.wavelength_um[q.first + i]);
  return sum;
}

/// Piecewise linear through f at the nodes of `x`.
template <class F>
auto linear_on(std::vector<double> x, F f) {
  return [x, f](double l) {
    std::size_t i = 0;
    while (i + 2 < x.size() && x[i + 1] <= l) ++i;
    const double t = (l - x[i]) / (x[i + 1] - x[i]);
    return (1 - t) * f(x[i]) + t * f(x[i + 1]);
  };
}

/// Fine reference: midpoint rule with n points over the support.
template <class F>
double fine(const scene::Band& band, F f, int n = 400000) {
  const auto [lo, hi] = plan::band_support(band);
  double sum = 0, norm = 0;
  for (int i = 0; i < n; ++i) {
    const double l = lo + (hi - lo) * (i + 0.5) / n, r = plan::band_response(band, l);
    sum += r * f(l);
    norm += r;
  }
  return sum / norm;
}

}  // namespace

TEST_CASE("S11 Gauss-Legendre rules integrate polynomials of degree 2n - 1 exactly") {
  for (const int n : {1, 2, 3, 4, 8}) {
    const auto rule = plan::gauss_legendre(n);
    for (int power = 0; power < 2 * n; ++power) {
      double sum = 0;
      for (const auto& [x, w] : rule) sum += w * std::pow(x, power);
      CHECK(sum == doctest::Approx(power % 2 ? 0.0 : 2.0 / (power + 1)).epsilon(1e-14));
    }
  }
}

TEST_CASE("S11 Gaussian band times a linear spectrum is the spectrum at the centre") {
  // closed form: the first moment of a symmetric response; the cut is symmetric too
  for (const double step : {0.0005, 0.001, 0.02}) {
    const std::vector<scene::Band> bands = {gaussian(0.5503, 0.0061), gaussian(0.6, 0.0003)};
    const auto grid = plan::make_spectral_grid(steps(0.4, 0.7, step), bands);
    for (const auto& band : bands) {
      const auto q = plan::band_quadrature(band, grid);
      CHECK(band_value(q, grid, [](double) { return 1.0; }) == doctest::Approx(1).epsilon(1e-13));
      CHECK(band_value(q, grid, [](double l) { return 3 - 2 * l; }) ==
            doctest::Approx(3 - 2 * band.center_um).epsilon(1e-11));
    }
  }
}

TEST_CASE("S11 product of two linear curves inside one interval is exact: l^2 gives centre^2 + sigma^2") {
  const double fwhm = 0.004, sigma = fwhm / std::sqrt(8 * kLn2);
  const std::vector<scene::Band> bands = {gaussian(0.5013, fwhm)};
  const auto grid = plan::make_spectral_grid(steps(0.4, 0.6, 0.02), bands);
  const auto q = plan::band_quadrature(bands[0], grid);
  // the cut at 2.5 FWHM takes 4e-9 of the area and 1.3e-7 of the second moment sigma^2 ~ 3e-6
  CHECK(band_value(q, grid, [](double l) { return l * l; }) ==
        doctest::Approx(0.5013 * 0.5013 + sigma * sigma).epsilon(1e-11));
}

TEST_CASE("S11 Gaussian absorption line of 0.01 nm inside a 5 nm band, to 1e-4 of the closed form") {
  // product of two Gaussians: mean line = s_l / sqrt(s_l^2 + s_b^2) exp(-4 ln2 d^2 / (w_l^2 + w_b^2)); depth 0.9
  const double wl = 1e-5, wb = 5e-3, line = 0.76053, depth = 0.9;
  auto axis = steps(0.74, 0.78, 0.001);
  for (const double l : steps(line - 5e-5, line + 5e-5, 5e-7)) axis.push_back(l);
  std::sort(axis.begin(), axis.end());
  const auto spectrum = [&](double l) { return 1 - depth * std::exp(-4 * kLn2 * (l - line) * (l - line) / (wl * wl)); };
  for (const double center : {0.7605, 0.7585, 0.7631}) {
    const std::vector<scene::Band> bands = {gaussian(center, wb)};
    const auto grid = plan::make_spectral_grid(axis, bands);
    const auto q = plan::band_quadrature(bands[0], grid);
    const double d = center - line;
    const double want = depth * wl / std::hypot(wl, wb) * std::exp(-4 * kLn2 * d * d / (wl * wl + wb * wb));
    const double found = 1 - band_value(q, grid, linear_on(axis, spectrum));
    CHECK(found == doctest::Approx(want).epsilon(1e-3));  // of the absorption itself: the axis' 20 steps per width
    CHECK(std::abs(found - want) < 1e-4);                 // of the band value
  }
}

TEST_CASE("S11 a band narrower than the table's step takes the table's straight line") {
  const std::vector<scene::Band> bands = {gaussian(0.5062, 0.00001)};
  const auto axis = steps(0.4, 0.6, 0.02);
  const auto grid = plan::make_spectral_grid(axis, bands);
  const auto q = plan::band_quadrature(bands[0], grid);
  const auto f = [](double l) { return std::sin(40 * l); };
  CHECK(band_value(q, grid, linear_on(axis, f)) == doctest::Approx(linear_on(axis, f)(0.5062)).epsilon(1e-10));
}

TEST_CASE("S11 box and triangle responses, closed forms of a quadratic") {
  // box a..b: mean of l^2 = (a^2 + ab + b^2)/3; triangle a..b with its peak in the middle m: m^2 + (b-a)^2/24
  const std::vector<scene::Band> bands = {tabulated({0.5013, 0.5531}, {0.7, 0.7}),
                                          tabulated({0.5013, 0.5272, 0.5531}, {0, 2, 0}),
                                          tabulated({0.5, 0.5, 0.52, 0.52}, {0, 1, 1, 0})};
  const auto grid = plan::make_spectral_grid(steps(0.4, 0.6, 0.007), bands);
  const auto square = [](double l) { return l * l; };
  const double a = 0.5013, b = 0.5531, m = 0.5272;
  CHECK(band_value(plan::band_quadrature(bands[0], grid), grid, square) ==
        doctest::Approx((a * a + a * b + b * b) / 3).epsilon(1e-12));
  CHECK(band_value(plan::band_quadrature(bands[1], grid), grid, square) ==
        doctest::Approx(m * m + (b - a) * (b - a) / 24).epsilon(1e-12));
  CHECK(band_value(plan::band_quadrature(bands[2], grid), grid, square) ==
        doctest::Approx((0.25 + 0.26 + 0.2704) / 3).epsilon(1e-12));
}

TEST_CASE("S11 products of two curves on different axes match fine quadrature to 1e-6, gate 1e-4") {
  const auto x1 = steps(0.38, 0.92, 0.0013), x2 = steps(0.379, 0.93, 0.0101);
  const auto f1 = linear_on(x1, [](double l) { return 1 + 0.9 * std::sin(900 * l); });
  const auto f2 = linear_on(x2, [](double l) { return 0.5 + 0.4 * std::cos(70 * l); });
  auto nodes = x1;
  nodes.insert(nodes.end(), x2.begin(), x2.end());
  const std::vector<scene::Band> bands = {gaussian(0.45, 0.005), gaussian(0.7, 0.0007), gaussian(0.8, 0.03),
                                          tabulated({0.5, 0.51, 0.513, 0.55}, {0.1, 1, 0.4, 0})};
  const auto grid = plan::make_spectral_grid(nodes, bands);
  for (const auto& band : bands) {
    const auto product = [&](double l) { return f1(l) * f2(l); };
    const double want = fine(band, product), found = band_value(plan::band_quadrature(band, grid), grid, product);
    CHECK(std::abs(found / want - 1) < 1e-6);
  }
}

TEST_CASE("S11 bands outside the table or a used curve are refused, all in one message") {
  scene::Instrument instrument;
  instrument.name = "cam";
  instrument.bands = {gaussian(0.352, 0.005), gaussian(0.6, 0.005), gaussian(0.999, 0.005)};
  scene::CompiledScene scene;
  scene::Material grass;
  grass.name = "grass";
  grass.source = "grass.csv";
  grass.reflectance = {{0.4, 2.5}, {0.1, 0.3}};
  scene.materials = {grass};
  std::string message;
  try {
    plan::make_spectral_plan(scene, instrument, steps(0.35, 1.0, 0.001), "'air.rct'");
  } catch (const base::Error& error) {
    message = error.what();
    CHECK(error.fault() == base::Fault::input);
  }
  for (const char* part : {"cam", "'air.rct'", "350 to 1000 nm", "'b352'", "339.5", "'b999'", "grass", "400 to 2500 nm",
                           "grass.csv", "take these bands out"})
    CHECK_MESSAGE(message.find(part) != std::string::npos, part << " in: " << message);
  CHECK(message.find("'b600'") == std::string::npos);
}

TEST_CASE("S11 only curves that a triangle carries must cover the bands") {
  scene::CompiledScene scene;
  scene.materials.resize(3);
  for (std::size_t m = 0; m < 3; ++m) {
    shared::Surface surface{};
    surface.material[0] = static_cast<std::uint32_t>(m + 1);
    surface.fraction[0] = 1;
    scene.surfaces.push_back(surface);
  }
  CHECK(scene::used_materials(scene) == std::vector<std::uint32_t>{0, 1, 2});  // no triangles: any may be asked for
  shared::TriBlock block{};
  for (auto& surface : block.surface) surface = RC_NONE;
  block.surface[0] = 2;
  shared::Surface mixed{};
  mixed.material[0] = 1;
  mixed.material[1] = 3;
  scene.surfaces.push_back(mixed);
  scene.blocks = {block};
  CHECK(scene::used_materials(scene) == std::vector<std::uint32_t>{2});
  scene.blocks[0].surface[5] = 3;
  CHECK(scene::used_materials(scene) == std::vector<std::uint32_t>{0, 2});
}
