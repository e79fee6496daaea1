#include "host/plan/irradiance_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/base/parallel.h"
#include "host/base/units.h"
#include "host/plan/quadrature.h"
#include "kernels/atmosphere/nodes.h"

namespace raycube::plan {

namespace {

using Four = std::array<double, 4>;

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

/// A ring of zenith angle between two rings of nodes: its pieces, mixed when they are first asked for, since one plane
/// meets two of them and a hundred planes of one tilt meet all.
class SkyIrradiance::Ring {
 public:
  explicit Ring(const SkyIrradiance& sky) : sky_(sky), piece_(sky.cells()), known_(sky.cells()) {}

  /// The ring at `fraction` of the way from ring number `lower` to the next.
  void move_to(std::size_t lower, double fraction) {
    lower_ = lower, f_ = fraction, g_ = 1 - fraction;
    std::fill(known_.begin(), known_.end(), std::uint8_t{0});
    for (std::size_t m = 0; m < 4; ++m) {
      one[m] = g_ * sky_.circle_one_[lower][m] + f_ * sky_.circle_one_[lower + 1][m];
      cosine[m] = g_ * sky_.circle_cosine_[lower][m] + f_ * sky_.circle_cosine_[lower + 1][m];
    }
  }

  /// Integrals of A, A cos, A sin from azimuth 0 to phi, -pi <= phi <= 2 pi. A is even about 0 and pi. c, s: cosine and
  /// sine of phi. cell: where the search for phi's cell begins, and where it ends; any cell will do.
  Moments moments_to(double phi, double c, double s, std::size_t& cell) {
    const double folded = phi > base::kPi ? 2 * base::kPi - phi : std::abs(phi);
    const std::vector<double>& azimuth = sky_.azimuth_;
    while (cell + 2 < azimuth.size() && azimuth[cell + 1] <= folded) ++cell;
    while (cell > 0 && azimuth[cell] > folded) --cell;
    const Piece& p = piece(cell);
    const double t = folded - azimuth[cell];
    s = std::abs(s);  // of the folded angle, whose cosine is phi's
    Moments out;
    for (std::size_t m = 0; m < 4; ++m) {
      const double a = p.a0[m] + p.a1[m] * t;
      out.one[m] = p.one[m] + t * (p.a0[m] + 0.5 * p.a1[m] * t);
      out.cosine[m] = p.cosine[m] + a * s + p.a1[m] * c;
      out.sine[m] = p.sine[m] - a * c + p.a1[m] * s;
    }
    if (phi < 0) {
      for (std::size_t m = 0; m < 4; ++m) out.one[m] = -out.one[m], out.cosine[m] = -out.cosine[m];
    } else if (phi > base::kPi) {
      for (std::size_t m = 0; m < 4; ++m) out.one[m] = one[m] - out.one[m], out.cosine[m] = cosine[m] - out.cosine[m];
    }
    return out;
  }

  Four one{}, cosine{};  ///< of the whole ring

 private:
  const Piece& piece(std::size_t cell) {
    Piece& out = piece_[cell];
    if (known_[cell]) return out;
    known_[cell] = 1;
    const Piece &p = sky_.piece_[lower_ * sky_.cells() + cell], &q = sky_.piece_[(lower_ + 1) * sky_.cells() + cell];
    const auto mix = [&](const Four& a, const Four& b, Four& to) {
      for (std::size_t m = 0; m < 4; ++m) to[m] = g_ * a[m] + f_ * b[m];
    };
    mix(p.a0, q.a0, out.a0), mix(p.a1, q.a1, out.a1);
    mix(p.one, q.one, out.one), mix(p.cosine, q.cosine, out.cosine), mix(p.sine, q.sine, out.sine);
    return out;
  }

  const SkyIrradiance& sky_;
  std::size_t lower_ = 0;
  double f_ = 0, g_ = 1;
  std::vector<Piece> piece_;
  std::vector<std::uint8_t> known_;  ///< pieces that are mixed
};

std::array<double, 4> SkyIrradiance::at(double tilt_rad, double azimuth_rad, int points) const {
  Four out{};
  at(tilt_rad, std::span(&azimuth_rad, 1), std::span(&out, 1), points);
  return out;
}

void SkyIrradiance::at(double tilt_rad, std::span<const double> azimuth_rad, std::span<std::array<double, 4>> out,
                       int points) const {
  static const std::array<std::vector<std::pair<double, double>>, 9> rules = [] {
    std::array<std::vector<std::pair<double, double>>, 9> all;
    for (int n = 1; n < 9; ++n) all[static_cast<std::size_t>(n)] = gauss_legendre(n);
    return all;
  }();
  const auto& rule = rules.at(static_cast<std::size_t>(points));
  struct Side {
    double psi, cos_psi, sin_psi;  ///< azimuth of the plane's normal, 0 .. pi from the sun
    std::size_t from = 0, to = 0;  ///< cells where its half ring was seen to begin and end
  };
  std::vector<Side> sides;
  for (const double azimuth : azimuth_rad) {
    const double psi = std::abs(std::remainder(azimuth, 2 * base::kPi));
    sides.push_back({psi, std::cos(psi), std::sin(psi)});
  }
  std::fill(out.begin(), out.end(), Four{});
  const double cos_tilt = std::cos(tilt_rad), sin_tilt = std::sin(tilt_rad);
  const double cut =
      std::abs(base::kPi / 2 - tilt_rad);  // rings beyond this zenith angle are cut by the surface's plane
  Ring at_theta(*this);
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
        at_theta.move_to(ring, f);
        const double c = whole ? -1 : std::clamp(-(cos_tilt * cos_theta) / (sin_tilt * sin_theta), -1.0, 1.0),
                     s = std::sqrt(1 - c * c), half = std::acos(c);
        for (std::size_t i = 0; i < sides.size(); ++i) {
          Side& side = sides[i];
          Four& sum = out[i];
          if (whole) {
            for (std::size_t m = 0; m < 4; ++m)
              sum[m] += across * side.cos_psi * at_theta.cosine[m] + up * at_theta.one[m];
            continue;
          }
          const double cc = side.cos_psi * c, ss = side.sin_psi * s, sc = side.sin_psi * c, cs = side.cos_psi * s;
          const Moments from = at_theta.moments_to(side.psi - half, cc + ss, sc - cs, side.from),
                        to = at_theta.moments_to(side.psi + half, cc - ss, sc + cs, side.to);
          for (std::size_t m = 0; m < 4; ++m)
            sum[m] +=
                across * (side.cos_psi * (to.cosine[m] - from.cosine[m]) + side.sin_psi * (to.sine[m] - from.sine[m])) +
                up * (to.one[m] - from.one[m]);
        }
      }
    }
  }
}

IrradianceGrid::IrradianceGrid(const SkyIrradiance& exact, double sun_azimuth_rad, std::size_t tilts, int threads)
    : sun_azimuth_(sun_azimuth_rad), tilts_(tilts), azimuths_(tilts / 2 + 1), value_(tilts_ * azimuths_) {
  std::vector<double> azimuth_rad;
  for (std::size_t j = 0; j < azimuths_; ++j)
    azimuth_rad.push_back(base::kPi * static_cast<double>(j) / static_cast<double>(azimuths_ - 1));
  base::for_each_index(tilts_, threads, [&](std::size_t i) {
    exact.at(base::kPi * static_cast<double>(i) / static_cast<double>(tilts_ - 1), azimuth_rad,
             std::span(value_).subspan(i * azimuths_, azimuths_));
  });
}

std::array<double, 4> IrradianceGrid::at(double x, double y, double z) const {
  const double tilt = std::atan2(std::sqrt(x * x + y * y), z);
  const double psi = std::abs(std::remainder(std::atan2(x, y) - sun_azimuth_, 2 * base::kPi));
  std::array<double, 4> wt, wp;
  const std::size_t i = cubic_weights(tilt / base::kPi * static_cast<double>(tilts_ - 1), tilts_, wt),
                    j = cubic_weights(psi / base::kPi * static_cast<double>(azimuths_ - 1), azimuths_, wp);
  Four sum{};
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b) {
      const Four& value = value_[(i + a) * azimuths_ + j + b];
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

IrradianceMap make_irradiance_map(const IrradianceGrid& grid, int size, int threads) {
  IrradianceMap map;
  map.size = size;
  const auto row = static_cast<std::size_t>(size);
  map.value.resize(row * row);
  base::for_each_index(row, threads, [&](std::size_t v) {
    for (std::size_t u = 0; u < row; ++u) {
      const auto [x, y, z] = node_direction(size, static_cast<int>(u), static_cast<int>(v));
      const Four e = grid.at(x, y, z);
      map.value[v * row + u] = {static_cast<float>(e[0]), static_cast<float>(e[1]), static_cast<float>(e[2]),
                                static_cast<float>(e[3])};
    }
  });
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
