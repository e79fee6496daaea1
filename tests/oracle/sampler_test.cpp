// Samplers: error on edges against the exact area; points spread evenly; weights of a point spread against moments.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "host/base/error.h"
#include "host/sensors/psf.h"
#include "kernels/sampling/sampler.h"
#include "tests/support/chance_checks.h"

using namespace raycube;

namespace {

// Area of {p in the unit square about 0: n.p < c}, closed form: differences of squared ramps at the corners.
double area_below(double nx, double ny, double c) {
  nx = std::abs(nx);
  ny = std::abs(ny);
  if (nx * ny < 1e-12) return std::clamp(c / std::max(nx, ny) + 0.5, 0.0, 1.0);
  const auto ramp2 = [](double t) { return t > 0 ? t * t : 0.0; };
  const double s = c + 0.5 * (nx + ny);
  return (ramp2(s) - ramp2(s - nx) - ramp2(s - ny) + ramp2(s - nx - ny)) / (2 * nx * ny);
}

struct EdgeError {
  double rms, max;
};

// Half-planes whose edge passes through a random point of the pixel, at a random angle or parallel to the lines.
EdgeError edge_error(int kind, int n, bool axis_aligned) {
  std::mt19937_64 random(raycube::testing::seed(7));
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr int kEdges = 20000;
  double sum = 0, worst = 0;
  std::vector<float> u(n * n), v(n * n);
  for (int edge = 0; edge < kEdges; ++edge) {
    const double angle = axis_aligned ? 0.0 : 2 * M_PI * unit(random);
    const double nx = std::cos(angle), ny = std::sin(angle);
    const double x = unit(random) - 0.5, c = nx * x + ny * (unit(random) - 0.5);
    if (edge == 0 || kind != RC_SAMPLER_GRID)
      for (int s = 0; s < n * n; ++s)
        rc_sample_uv(kind, n, n, 1.0f, raycube::testing::seed32(1), static_cast<rc_u32>(edge), s, &u[s], &v[s]);
    int inside = 0;
    for (int s = 0; s < n * n; ++s) inside += nx * u[s] + ny * v[s] < c;
    const double error = static_cast<double>(inside) / (n * n) - area_below(nx, ny, c);
    sum += error * error;
    worst = std::max(worst, std::abs(error));
  }
  return {std::sqrt(sum / kEdges), worst};
}

}  // namespace

// Section 3 of the requirements: published to two digits from an unstated number and distribution of edges; 20 000
// edges leave 0.7 % (grid errors are far from Gaussian: 1 %). Ours reproduce them to 5 %, 6 % is asked.
TEST_CASE("S43 samplers: rms area error of a random half-plane edge, regular grid") {
  struct Published {
    int n;
    double rms;
  };
  for (const Published& p : {Published{1, 0.286}, {4, 0.0343}, {7, 0.0152}, {11, 0.0073}, {16, 0.0040}, {31, 0.0015}}) {
    const EdgeError e = edge_error(RC_SAMPLER_GRID, p.n, false);
    MESSAGE(p.n << " x " << p.n << ": rms " << e.rms << " (published " << p.rms << "), max " << e.max);
    CHECK_WITHIN(e.rms - p.rms, 0.06 * p.rms + 5e-5);
    if (p.n == 11) CHECK_BELOW(e.max, 0.046);  // published 0.044 as the largest of its own edges
  }
}

TEST_CASE("S43 samplers: jittered cells, and the grid's weakness on edges parallel to it") {
  CHECK_WITHIN(edge_error(RC_SAMPLER_JITTERED, 11, false).rms - 0.0108, 0.06 * 0.0108);
  const double aligned = edge_error(RC_SAMPLER_GRID, 11, true).rms;
  CHECK(std::abs(aligned - 0.0267) < 0.03 * 0.0267);
  CHECK_WITHIN(aligned - 1 / (11 * std::sqrt(12.0)), 0.02 * aligned);  // closed form: uniform error in one row
  // A golden-ratio lattice has no rows: random and parallel edges alike, and better than the grid on the latter.
  const double lattice = edge_error(RC_SAMPLER_LATTICE, 11, false).rms,
               lattice_aligned = edge_error(RC_SAMPLER_LATTICE, 11, true).rms;
  MESSAGE("lattice 121: " << lattice << ", axis-aligned " << lattice_aligned);
  CHECK_BELOW(lattice, 1.5 * 0.0073);
  CHECK_BELOW(lattice_aligned, 0.5 * aligned);
}

TEST_CASE("S43 samplers: every sample in its cell or, lattice, one per stratum; any pixel, seed and support") {
  for (rc_u32 pixel : {0u, 1u, 12345u, 4000000000u})
    for (float support : {1.0f, 3.0f}) {
      const int nu = 11, nv = 7, count = nu * nv;
      std::set<int> strata;
      for (int s = 0; s < count; ++s) {
        float u = 9, v = 9;
        for (int kind : {RC_SAMPLER_GRID, RC_SAMPLER_JITTERED}) {
          rc_sample_uv(kind, nu, nv, support, 5u, pixel, s, &u, &v);
          const double x = (u / support + 0.5) * nu - s % nu, y = (v / support + 0.5) * nv - s / nu;
          CHECK(x > -1e-5);
          CHECK(x < 1 + 1e-5);
          CHECK(y > -1e-5);
          CHECK(y < 1 + 1e-5);
          if (kind == RC_SAMPLER_GRID) CHECK(std::abs(x - 0.5) + std::abs(y - 0.5) < 1e-5);
        }
        rc_sample_uv(RC_SAMPLER_LATTICE, nu, nv, support, 5u, pixel, s, &u, &v);
        CHECK(std::abs(u) <= 0.5f * support);
        CHECK(std::abs(v) <= 0.5f * support);
        // Shifted as a whole: relative to sample 0, x advances by exactly 1 / N, so N distinct places modulo 1.
        float u0, v0;
        rc_sample_uv(RC_SAMPLER_LATTICE, nu, nv, support, 5u, pixel, 0, &u0, &v0);
        strata.insert(static_cast<int>(std::lround((u - u0) / support * count + count)) % count);
      }
      CHECK(strata.size() == static_cast<std::size_t>(count));
    }
}

TEST_CASE("S43 samplers: the random bits are uniform (chi-square) and differ between pixels, samples and seeds") {
  std::vector<int> bins(256, 0);
  constexpr int kDraws = 1 << 18;
  std::set<rc_u32> seen;
  for (int i = 0; i < kDraws; ++i) {
    const rc_u32 bits =
        rc_hash(raycube::testing::seed32(3), static_cast<rc_u32>(i >> 7), static_cast<rc_u32>(i & 127), 12u);
    ++bins[static_cast<int>(rc_unit_float(bits) * 256)];
    seen.insert(bits);
  }
  double chi2 = 0;
  for (int n : bins) chi2 += (n - kDraws / 256.0) * (n - kDraws / 256.0) / (kDraws / 256.0);
  CHECK_BELOW(chi2, 255 + 5 * std::sqrt(2 * 255.0));  // 5 standard deviations of chi-square with 255 degrees of freedom
  CHECK_ABOVE(chi2, 255 - 5 * std::sqrt(2 * 255.0));
  // 2^18 draws of 32 bits: 8 coincidences expected (n^2 / 2^33); 30 would be 7 standard deviations
  CHECK_ABOVE(seen.size(), kDraws - 30);
  CHECK(rc_hash(1u, 2u, 3u, 4u) != rc_hash(2u, 2u, 3u, 4u));
  CHECK(rc_hash(1u, 2u, 3u, 4u) != rc_hash(1u, 2u, 3u, 5u));
}

TEST_CASE("S43 samplers: jitter along and across the line is independent") {
  double product = 0;
  constexpr int kCells = 1 << 16;  // of one sample each: jitter is the position itself
  for (int pixel = 0; pixel < kCells; ++pixel) {
    float u, v;
    rc_sample_uv(RC_SAMPLER_JITTERED, 1, 1, 1.0f, raycube::testing::seed32(5), static_cast<rc_u32>(pixel), 0, &u, &v);
    product += 12.0 * u * v / kCells;  // the correlation of two uniform numbers about 0, of variance 1/12 each
  }
  CHECK_WITHIN(product, 5 / std::sqrt(double(kCells)));  // 5 standard errors
}

// Each pixel's lattice is shifted by a hash of its own, so that over many pixels the mean has no preference for any
// phase of a pattern that keeps step with the pixels: 1e6 of them leave 1e-3 / sqrt(samples) or less, and 4 standard
// errors are allowed. What is left in one image of 64 x 64 pixels is chance: one sample a pixel has a standard error of
// 1.6 % there.
TEST_CASE("S43 samplers: lattices of a few samples do not shift the mean of checkers in step with the pixels") {
  constexpr rc_u32 kPixels = 1000000;
  for (const int side : {1, 2, 4})
    for (const int cells : {2, 4, 8}) {  // along a pixel's side
      double sum = 0, squares = 0;
      for (rc_u32 pixel = 0; pixel < kPixels; ++pixel) {
        int white = 0;
        for (int s = 0; s < side * side; ++s) {
          float u, v;
          rc_sample_uv(RC_SAMPLER_LATTICE, side, side, 1.0f, raycube::testing::seed32(3), pixel, s, &u, &v);
          const auto cell = [&](float x) {
            return static_cast<int>(std::floor((x + 0.5f) * static_cast<float>(cells)));
          };
          white += (cell(u) + cell(v)) % 2 == 0;
        }
        const double share = static_cast<double>(white) / (side * side);
        sum += share;
        squares += share * share;
      }
      const double mean = sum / kPixels, error = std::sqrt((squares / kPixels - mean * mean) / kPixels);
      CAPTURE(side);
      CAPTURE(cells);
      CHECK_WITHIN(mean - 0.5, 4 * error + 1e-9);
      CHECK_BELOW(error, 1e-3 / side);
    }
}

TEST_CASE("S48 point spread weights: sum, second moment of box and Gaussian, plain box") {
  scene::Instrument instrument;
  instrument.name = "psf";
  instrument.samples_u = 61;
  instrument.samples_v = 31;
  instrument.psf_sigma_px = 0.5;
  instrument.psf_support_px = 6;
  const auto weights = sensors::psf_weights(instrument);
  double sum = 0, moment_u = 0, moment_v = 0;
  for (int s = 0; s < 61 * 31; ++s) {
    float u, v;
    rc_sample_uv(RC_SAMPLER_GRID, 61, 31, 6.0f, 1u, 0u, s, &u, &v);
    sum += weights[s];
    moment_u += double(weights[s]) * u * u;
    moment_v += double(weights[s]) * v * v;
  }
  CHECK(std::abs(sum - 1) < 1e-6);
  // Variances add: 1/12 of the box plus sigma^2; midpoint cells of width h read h^2 / 12 less; cut at 6 sigma: nothing.
  CHECK(std::abs(moment_u - (1.0 / 12 + 0.25 + std::pow(6.0 / 61, 2) / 12)) < 2e-4);
  CHECK(std::abs(moment_v - (1.0 / 12 + 0.25 + std::pow(6.0 / 31, 2) / 12)) < 2e-4);

  instrument.psf_support_px = 3.5;  // holds 99.6 % of the response: the weights still sum to 1
  sum = 0;
  for (float w : sensors::psf_weights(instrument)) sum += w;
  CHECK(std::abs(sum - 1) < 1e-6);

  instrument.psf_sigma_px = 0;
  instrument.psf_support_px = 1;
  for (float w : sensors::psf_weights(instrument)) CHECK(w == static_cast<float>(1.0 / (61 * 31)));
  instrument.psf_support_px = 3;  // a box inside a wide square: cells outside the pixel weigh nothing
  instrument.samples_u = instrument.samples_v = 3;
  const auto box = sensors::psf_weights(instrument);
  for (int s = 0; s < 9; ++s) CHECK(std::abs(box[s] - (s == 4 ? 1.0 : 0.0)) < 1e-7);
}

TEST_CASE("S48 point spread weights: a support that cuts the response and a lattice are refused with the way out") {
  scene::Instrument instrument;
  instrument.name = "narrow";
  instrument.psf_sigma_px = 1;
  instrument.psf_support_px = 2;
  CHECK_THROWS_WITH_AS(sensors::psf_weights(instrument), doctest::Contains("try 6"), base::Error);
  instrument.psf_support_px = 8;
  instrument.sampler = scene::SamplerKind::lattice;
  CHECK_THROWS_WITH_AS(sensors::psf_weights(instrument), doctest::Contains("lattice"), base::Error);
}
