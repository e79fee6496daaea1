#include "scene_compiler/leaf_optics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "scene_compiler/air_wavelength.h"

namespace raycube::scene {

namespace {

struct Constants {
  double refractive_index, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter;
};
constexpr Constants kConstants[] = {
#include "scene_compiler/data/prospect_d.inc"
};
constexpr double kFirstUm = 0.4, kStepUm = 1e-3;
static_assert(std::size(kConstants) == 2101);

/// Light falls onto a leaf from within this angle of its normal (Jacquemoud & Baret 1990).
constexpr double kCone_rad = 40 * std::numbers::pi / 180;

struct Layer {
  double reflectance, transmittance;
};

double square(double x) { return x * x; }

/// Of one plate's width for diffuse light; k: absorption depth along the normal.
double plate_transmissivity(double k) {
  if (!(k > 0)) return 1;
  return (1 - k) * std::exp(-k) - k * k * std::expint(-k);  // -Ei(-k) = E1(k)
}

/// A plate whose upper face has this transmissivity from outside, the lower one that of diffuse light.
Layer plate(double face, double refractive_index, double tau) {
  const double diffuse = mean_face_transmissivity(std::numbers::pi / 2, refractive_index);
  const double out = diffuse / square(refractive_index), back = 1 - out;  // from inside
  const double through = face * tau * out / (1 - square(back * tau));
  return {1 - face + back * tau * through, through};
}

/// A pile of `count` equal plates, a real number of them (Stokes 1862).
Layer pile(Layer one, double count) {
  const double r = one.reflectance, t = one.transmittance;
  if (r + t >= 1) {  // nothing is absorbed
    const double through = t / (t + (1 - t) * count);
    return {1 - through, through};
  }
  const double root = std::sqrt((1 + r + t) * (1 + r - t) * (1 - r + t) * (1 - r - t));
  const double a = (1 + r * r - t * t + root) / (2 * r), b = (1 - r * r + t * t + root) / (2 * t);
  const double power = std::pow(b, count), below = square(a * power) - 1;
  return {a * (square(power) - 1) / below, power * (a * a - 1) / below};
}

Layer leaf_at(const LeafContent& leaf, const Constants& at) {
  const double absorbed = leaf.chlorophyll_ug_cm2 * at.chlorophyll + leaf.carotenoids_ug_cm2 * at.carotenoids +
                          leaf.anthocyanins_ug_cm2 * at.anthocyanins + leaf.brown * at.brown +
                          leaf.water_cm * at.water + leaf.dry_matter_g_cm2 * at.dry_matter;
  const double n = at.refractive_index, tau = plate_transmissivity(absorbed / leaf.structure);
  const Layer top = plate(mean_face_transmissivity(kCone_rad, n), n, tau);
  const Layer inner = plate(mean_face_transmissivity(std::numbers::pi / 2, n), n, tau);
  const Layer rest = pile(inner, leaf.structure - 1);
  const double between = 1 - rest.reflectance * inner.reflectance;
  return {top.reflectance + top.transmittance * rest.reflectance * inner.transmittance / between,
          top.transmittance * rest.transmittance / between};
}

}  // namespace

double mean_face_transmissivity(double half_angle_rad, double refractive_index) {
  const double n2 = square(refractive_index), plus = n2 + 1, minus = n2 - 1, sin2 = square(std::sin(half_angle_rad));
  const double a = square(refractive_index + 1) / 2, k = -square(minus) / 4, middle = sin2 - plus / 2;
  const double b = std::sqrt(std::max(0.0, square(middle) + k)) - middle;
  const auto across = [&](double x) { return k * k / (6 * x * x * x) + k / x - x / 2; };
  const double steep_a = 2 * plus * a - square(minus), steep_b = 2 * plus * b - square(minus);
  const double along =
      -2 * n2 * (b - a) / square(plus) - 2 * n2 * plus * std::log(b / a) / square(minus) + n2 * (1 / b - 1 / a) / 2 +
      16 * square(n2) * (square(n2) + 1) * std::log(steep_b / steep_a) / (plus * plus * plus * square(minus)) +
      16 * n2 * n2 * n2 * (1 / steep_b - 1 / steep_a) / (plus * plus * plus);
  return (across(b) - across(a) + along) / (2 * sin2);
}

LeafOptics leaf_optics(const LeafContent& leaf) {
  LeafOptics out;
  double wavelength_um = kFirstUm;
  for (const Constants& at : kConstants) {
    const auto number = static_cast<double>(&at - kConstants);
    if (number > 0) wavelength_um = vacuum_from_air_um(kFirstUm + kStepUm * number);
    const Layer whole = leaf_at(leaf, at);
    for (const auto& [curve, value] :
         {std::pair(&out.reflectance, whole.reflectance), {&out.transmittance, whole.transmittance}}) {
      curve->wavelength_um.push_back(wavelength_um);
      curve->value.push_back(value);
    }
  }
  return out;
}

}  // namespace raycube::scene
