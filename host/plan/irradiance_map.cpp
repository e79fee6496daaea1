#include "host/plan/irradiance_map.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/plan/quadrature.h"
#include "kernels/atmosphere/nodes.h"

namespace raycube::plan {

namespace {

using Four = std::array<double, 4>;
constexpr std::size_t kTilts = 201, kAzimuths = 101;

/// Lagrange weights of the four nodes around `at` on the axis 0, 1, ... count - 1; one-sided at both ends.
std::size_t cubic_weights(double at, std::size_t count, std::array<double, 4>& weight) {
  const auto last = static_cast<double>(count - 4);
  const double first = std::clamp(std::floor(at) - 1, 0.0, last), t = at - first;
  weight = {-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2, -t * (t - 1) * (t - 3) / 2,
            t * (t - 1) * (t - 2) / 6};
  return static_cast<std::size_t>(first);
}

}  // namespace

SkyIrradiance::SkyIrradiance(const SkyBasis& basis) : zenith_(basis.zenith_rad), azimuth_(basis.azimuth_rad) {
  const std::size_t cells = azimuth_.size() - 1;
  for (std::size_t ring = 0; ring < zenith_.size(); ++ring) {
    Four one{}, cosine{}, sine{};
    for (std::size_t j = 0; j < cells; ++j) {
      const Four &lo = basis.value[ring * azimuth_.size() + j], &hi = basis.value[ring * azimuth_.size() + j + 1];
      const double a = azimuth_[j], b = azimuth_[j + 1];
      Piece p;
      for (std::size_t m = 0; m < 4; ++m) {
        p.a0[m] = lo[m];
        p.a1[m] = (hi[m] - lo[m]) / (b - a);
        p.one[m] = one[m];
        p.cosine[m] = cosine[m] - (lo[m] * std::sin(a) + p.a1[m] * std::cos(a));
        p.sine[m] = sine[m] - (-lo[m] * std::cos(a) + p.a1[m] * std::sin(a));
        one[m] += 0.5 * (b - a) * (lo[m] + hi[m]);
        cosine[m] = p.cosine[m] + hi[m] * std::sin(b) + p.a1[m] * std::cos(b);
        sine[m] = p.sine[m] - hi[m] * std::cos(b) + p.a1[m] * std::sin(b);
      }
      piece_.push_back(p);
    }
    for (std::size_t m = 0; m < 4; ++m) one[m] *= 2, cosine[m] *= 2;  // both sides of the sun's vertical plane
    circle_one_.push_back(one);
    circle_cosine_.push_back(cosine);
  }
}

/// Integrals of A, A cos, A sin from azimuth 0 to phi, -pi <= phi <= 2 pi, between two rings. A is even about 0 and pi.
SkyIrradiance::Moments SkyIrradiance::moments_to(std::size_t ring, double fraction, double phi) const {
  const double folded = phi > base::kPi ? 2 * base::kPi - phi : std::abs(phi);
  const std::size_t cells = azimuth_.size() - 1;
  const auto upper = std::upper_bound(azimuth_.begin() + 1, azimuth_.end() - 1, folded);
  const auto j = static_cast<std::size_t>(upper - azimuth_.begin()) - 1;
  const Piece &p = piece_[ring * cells + j], &q = piece_[(ring + 1) * cells + j];
  const double t = folded - azimuth_[j], c = std::cos(folded), s = std::sin(folded), f = fraction, g = 1 - fraction;
  Moments out;
  for (std::size_t m = 0; m < 4; ++m) {
    const double a0 = g * p.a0[m] + f * q.a0[m], a1 = g * p.a1[m] + f * q.a1[m], a = a0 + a1 * t;
    double one = g * p.one[m] + f * q.one[m] + t * (a0 + 0.5 * a1 * t);
    double cosine = g * p.cosine[m] + f * q.cosine[m] + a * s + a1 * c;
    const double sine = g * p.sine[m] + f * q.sine[m] - a * c + a1 * s;
    if (phi < 0) {
      one = -one;
      cosine = -cosine;
    } else if (phi > base::kPi) {
      one = g * circle_one_[ring][m] + f * circle_one_[ring + 1][m] - one;
      cosine = g * circle_cosine_[ring][m] + f * circle_cosine_[ring + 1][m] - cosine;
    }
    out.one[m] = one;
    out.cosine[m] = cosine;
    out.sine[m] = sine;
  }
  return out;
}

std::array<double, 4> SkyIrradiance::at(double tilt_rad, double azimuth_rad, int points) const {
  static const std::array<std::vector<std::pair<double, double>>, 9> rules = [] {
    std::array<std::vector<std::pair<double, double>>, 9> all;
    for (int n = 1; n < 9; ++n) all[static_cast<std::size_t>(n)] = gauss_legendre(n);
    return all;
  }();
  const auto& rule = rules.at(static_cast<std::size_t>(points));
  const double psi = std::abs(std::remainder(azimuth_rad, 2 * base::kPi));
  const double cos_tilt = std::cos(tilt_rad), sin_tilt = std::sin(tilt_rad), cos_psi = std::cos(psi),
               sin_psi = std::sin(psi);
  const double cut =
      std::abs(base::kPi / 2 - tilt_rad);  // rings beyond this zenith angle are cut by the surface's plane
  Four sum{};
  for (std::size_t ring = 0; ring + 1 < zenith_.size(); ++ring) {
    const double lo = zenith_[ring], hi = zenith_[ring + 1];
    const bool split = lo < cut && cut < hi;
    for (int part = 0; part < (split ? 2 : 1); ++part) {
      const double a = part == 1 ? cut : lo, b = split && part == 0 ? cut : hi;
      const bool whole = b <= cut;
      if (whole && tilt_rad > base::kPi / 2) continue;  // behind the surface
      for (const auto& [node, gauss] : rule) {
        // theta = a + (b - a) r^2 in the interval where the cut begins: takes the square root out of the integrand
        const double r = 0.5 * (1 + node);
        const bool rooted = !whole && a <= cut + 1e-12;
        const double theta = rooted ? a + (b - a) * r * r : a + (b - a) * r;
        const double weight = 0.5 * gauss * (b - a) * (rooted ? 2 * r : 1.0);
        const double f = (theta - lo) / (hi - lo), sin_theta = std::sin(theta), cos_theta = std::cos(theta);
        const double across = weight * sin_theta * sin_tilt * sin_theta, up = weight * sin_theta * cos_tilt * cos_theta;
        if (whole) {
          for (std::size_t m = 0; m < 4; ++m)
            sum[m] += across * cos_psi * ((1 - f) * circle_cosine_[ring][m] + f * circle_cosine_[ring + 1][m]) +
                      up * ((1 - f) * circle_one_[ring][m] + f * circle_one_[ring + 1][m]);
          continue;
        }
        const double half = std::acos(std::clamp(-(cos_tilt * cos_theta) / (sin_tilt * sin_theta), -1.0, 1.0));
        const Moments from = moments_to(ring, f, psi - half), to = moments_to(ring, f, psi + half);
        for (std::size_t m = 0; m < 4; ++m)
          sum[m] += across * (cos_psi * (to.cosine[m] - from.cosine[m]) + sin_psi * (to.sine[m] - from.sine[m])) +
                    up * (to.one[m] - from.one[m]);
      }
    }
  }
  return sum;
}

IrradianceGrid::IrradianceGrid(const SkyIrradiance& exact, double sun_azimuth_rad)
    : sun_azimuth_(sun_azimuth_rad), value_(kTilts * kAzimuths) {
  for (std::size_t i = 0; i < kTilts; ++i)
    for (std::size_t j = 0; j < kAzimuths; ++j)
      value_[i * kAzimuths + j] = exact.at(base::kPi * static_cast<double>(i) / (kTilts - 1),
                                           base::kPi * static_cast<double>(j) / (kAzimuths - 1));
}

std::array<double, 4> IrradianceGrid::at(double x, double y, double z) const {
  const double tilt = std::atan2(std::sqrt(x * x + y * y), z);
  const double psi = std::abs(std::remainder(std::atan2(x, y) - sun_azimuth_, 2 * base::kPi));
  std::array<double, 4> wt, wp;
  const std::size_t i = cubic_weights(tilt / base::kPi * (kTilts - 1), kTilts, wt),
                    j = cubic_weights(psi / base::kPi * (kAzimuths - 1), kAzimuths, wp);
  Four sum{};
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b) {
      const Four& value = value_[(i + a) * kAzimuths + j + b];
      for (std::size_t m = 0; m < 4; ++m) sum[m] += wt[a] * wp[b] * value[m];
    }
  return sum;
}

namespace {

/// Direction of a map node, not normalised.
std::array<double, 3> node_direction(int size, int u, int v) {
  const double half = 0.5 * (size - 1), x = u / half - 1, y = v / half - 1, z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return {x, y, z};
  return {(1 - std::abs(y)) * (x < 0 ? -1 : 1), (1 - std::abs(x)) * (y < 0 ? -1 : 1), z};
}

template <class NodeValue>
Four between_nodes(int size, double x, double y, double z, NodeValue node_value) {
  int index[3];
  float weight[3];
  rc_octahedral_nodes(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), size, index, weight);
  Four out{};
  for (int k = 0; k < 3; ++k) {
    const Four value = node_value(index[k]);
    for (std::size_t m = 0; m < 4; ++m) out[m] += static_cast<double>(weight[k]) * value[m];
  }
  return out;
}

}  // namespace

IrradianceMap make_irradiance_map(const IrradianceGrid& grid, int size) {
  IrradianceMap map;
  map.size = size;
  map.value.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  for (int v = 0; v < size; ++v)
    for (int u = 0; u < size; ++u) {
      const auto [x, y, z] = node_direction(size, u, v);
      const Four e = grid.at(x, y, z);
      map.value.push_back(
          {static_cast<float>(e[0]), static_cast<float>(e[1]), static_cast<float>(e[2]), static_cast<float>(e[3])});
    }
  return map;
}

std::array<double, 4> read_between_nodes(const IrradianceGrid& grid, int size, double x, double y, double z) {
  return between_nodes(size, x, y, z, [&](int index) {
    const auto [nx, ny, nz] = node_direction(size, index % size, index / size);
    return grid.at(nx, ny, nz);
  });
}

std::array<double, 4> read_map(const IrradianceMap& map, double x, double y, double z) {
  return between_nodes(map.size, x, y, z, [&](int index) -> Four {
    const auto& e = map.value[static_cast<std::size_t>(index)];
    return {e.x, e.y, e.z, e.w};
  });
}

}  // namespace raycube::plan
