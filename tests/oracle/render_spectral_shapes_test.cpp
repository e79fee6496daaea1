// Matter as a sum of lobes, seen by cameras (S21): a tilted plane under the sun and under an even sky, and light
// between planes. Oracles: what is linear in wavelength between the closed forms of the nodes, the forms at each band's
// own albedo and index, and the same scene with one shape, to which nodes that are all alike must make no difference.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "kernels/materials/shapes.h"
#include "scene_compiler/fresnel.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kReflectance = 0.3, kSunIrradiance = 1500, kSkyRadiance = 30;
constexpr double kHeight_m = 1000, kGsd_m = 40;

/// At 500, 620 and 800 nm.
const std::vector<scene::ShapeNode> kFront = {{0.5, {RC_SHAPE_rpv, {0.7, -0.25, 0.4}}},
                                              {0.62, {RC_SHAPE_rpv, {0.9, -0.05, 0.8}}},
                                              {0.8, {RC_SHAPE_rpv, {1.1, 0.1, 1.0}}}};
const std::vector<scene::ShapeNode> kGloss = {{0.55, {RC_SHAPE_gloss, {0.3, 0.1}}},
                                              {0.75, {RC_SHAPE_gloss, {0.45, 0.5}}}};
/// Before the first node, on its way to the second, half way, near the last, behind it.
const std::vector<double> kCentres = {0.45, 0.53, 0.6, 0.685, 0.78, 0.9};

double eval(const scene::Shape& shape, const RcAngles& angles) {
  return rc_shape_eval(shape.number, 1, shape.parameters(), angles);
}

/// Linear between the nodes, by a search of its own.
double between(const std::vector<scene::ShapeNode>& nodes, double l, const RcAngles& angles) {
  if (l <= nodes.front().wavelength_um) return eval(nodes.front().shape, angles);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const double a = nodes[i - 1].wavelength_um, b = nodes[i].wavelength_um;
    if (l < b) return ((b - l) * eval(nodes[i - 1].shape, angles) + (l - a) * eval(nodes[i].shape, angles)) / (b - a);
  }
  return eval(nodes.back().shape, angles);
}

/// A reflectance that falls with wavelength.
double reflectance(double l) { return kReflectance * (1.4 - l); }

/// A plane through the origin that rises towards the east by 40 degrees, seen over a field of +- 7 degrees.
struct Tilted {
  double tilt = 40 * kPi / 180;
  RcLocal normal{-std::sin(tilt), 0, std::cos(tilt)};
  scene::Simulation simulation;
  explicit Tilted(int pixels, bool glossy) {
    const auto surface = test::add_material(simulation.scene, "changing", kReflectance);
    scene::Material& material = simulation.scene.materials[0];
    material.reflectance = {{0.3, 1.0}, {reflectance(0.3), reflectance(1.0)}};
    material.front = kFront[0].shape, material.front_nodes = kFront;
    if (glossy) material.gloss = kGloss[0].shape, material.gloss_nodes = kGloss;
    scene::make_lobes(material);
    const double c = std::cos(tilt), s = std::sin(tilt), half = 2000;
    test::place(simulation.scene, test::rectangle({-half * c, -half, -half * s}, {2 * half * c, 0, 2 * half * s},
                                                  {0, 2 * half, 0}, surface));
    finish_top_tree(simulation.scene);
    simulation.instruments = {test::nadir_camera(pixels, pixels, kHeight_m, kGsd_m * 6 / pixels)};
    simulation.instruments[0].bands = test::gaussian_bands(kCentres, 0.005);
    simulation.bounces = 0, simulation.bounces_given = true;
  }
  /// Towards the sensor from where the centre of a pixel, or of a block of pixels, meets the plane.
  RcLocal viewer(double line, double pixel) const {
    const auto& camera = simulation.instruments[0];
    const double gsd = kGsd_m * 6 / camera.pixels;
    const double x = (pixel + 0.5 - camera.pixels / 2.0) * gsd, y = (camera.lines / 2.0 - line - 0.5) * gsd;
    const double over = 1 / std::sqrt(x * x + y * y + kHeight_m * kHeight_m);
    return {-x * over, -y * over, kHeight_m * over};
  }
  /// Radiance of unit irradiance on the plane.
  double sent(double l, const RcAngles& angles, bool glossy) const {
    return reflectance(l) * between(kFront, l, angles) + (glossy ? between(kGloss, l, angles) : 0);
  }
};

/// The plane under the sun, and its largest difference from `sent`, radiance of unit irradiance on it, over pixels and
/// bands.
struct Sunlit {
  test::Image image;
  double worst = 0;
};
template <class Sent>
Sunlit sunlit(Tilted& scene, Sent&& sent) {
  const double z = 50 * kPi / 180, a = 200 * kPi / 180;
  const RcLocal sun{std::sin(z) * std::sin(a), std::sin(z) * std::cos(a), std::cos(z)};
  scene.simulation.sun.zenith_deg = 50, scene.simulation.sun.azimuth_deg = 200;
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSunIrradiance; };
  air.sun_zenith_deg = 50, air.sun_azimuth_deg = 200;
  scene.simulation.instruments[0].samples_u = scene.simulation.instruments[0].samples_v = 1;
  Sunlit out{test::render_image(scene.simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.4, 0.95, 0.01)))};
  for (int line = 0; line < out.image.lines; ++line)
    for (int pixel = 0; pixel < out.image.pixels; ++pixel) {
      const RcAngles angles = rc_angles(scene.normal, sun, scene.viewer(line, pixel));
      for (std::size_t b = 0; b < kCentres.size(); ++b) {
        const double want = sent(kCentres[b], angles) * kSunIrradiance * angles.cos_in;
        out.worst = std::max(out.worst, std::abs(out.image.at(line, pixel, static_cast<int>(b)) / want - 1));
      }
    }
  return out;
}

}  // namespace

// 1e-4: by as much a curve times a share may differ from what is linear (spectral_shape.cpp).
TEST_CASE("S21 shapes by wavelength: sunlight is linear between the nodes' closed forms, and held beyond") {
  for (const bool glossy : {false, true}) {
    Tilted scene(6, glossy);
    CHECK(scene::camera_matter(scene.simulation.scene).sides() == (glossy ? 5 : 3));
    const auto [image, worst] =
        sunlit(scene, [&](double l, const RcAngles& angles) { return scene.sent(l, angles, glossy); });
    CAPTURE(glossy);
    CAPTURE(worst);
    CHECK(worst < 1e-4);
    CHECK(image.layer(1, 1, render::truth::abundance) == doctest::Approx(1).epsilon(1e-6));
  }
}

// 6e-4: what polynomials between nodes of the curve may be off by (spectral_shape.h), and a band of 5 nm. Of Fresnel's
// law the four functions' own sum, which test materials holds against the law.
TEST_CASE("S21 hapke, fresnel: sunlight is the closed form at each band's own albedo and index") {
  for (const bool mirror : {false, true}) {
    Tilted scene(6, false);
    scene::Material& material = scene.simulation.scene.materials[0];
    material.front_nodes.clear();
    const auto albedo = [](double l) { return 0.25 + 0.75 * (l - 0.3); };  // single scattering, 0.25 to 0.775
    const auto n = [](double l) { return 1.4 - l; };
    const auto k = [](double l) { return 2 + 2 * l; };
    if (mirror) {
      material.front = {RC_SHAPE_lambert};
      material.reflectance = {{0.3, 1.0}, {0.02, 0.02}};
      material.gloss = {RC_SHAPE_gloss, {0.4, 0.9, 1}};
      for (double l = 0.3; l < 1.005; l += 0.01) {
        for (auto* curve : {&material.index_n, &material.index_k}) curve->wavelength_um.push_back(l);
        material.index_n.value.push_back(n(l)), material.index_k.value.push_back(k(l));
      }
    } else {
      material.front = {RC_SHAPE_hapke, {0.4, 0.3, 15, 0.6, 0.1, 0}};
      // Two wavelengths: w is linear between them, and nothing else is.
      material.reflectance = {{0.3, 1.0}, {albedo(0.3), albedo(1.0)}};
      scene::take_nodes_of_curve(material);
    }
    scene::make_lobes(material);
    CHECK(scene::camera_matter(scene.simulation.scene).sides() ==
          (mirror ? 5 : static_cast<int>(material.front_nodes.size())));
    const double worst =
        sunlit(scene, [&](double l, const RcAngles& angles) {
          if (!mirror) {
            const double w = albedo(l), gamma = std::sqrt(1 - w);
            return (1 - gamma) / (1 + gamma) * eval({RC_SHAPE_hapke, {0.4, 0.3, 15, 0.6, 0.1, w}}, angles);
          }
          const auto factor = scene::fresnel_factors(n(l), k(l));
          double f = 0.02 / kPi;
          for (std::size_t i = 0; i < 4; ++i)
            f += factor[i] * eval({RC_SHAPE_gloss, {0.4, 0, static_cast<double>(i + 1)}}, angles);
          return f;
        }).worst;
    CAPTURE(mirror);
    CAPTURE(worst);
    CHECK(worst < 6e-4);
  }
}

TEST_CASE("S21 shapes by wavelength: an even sky is the integral of what lies between the nodes") {
  for (const bool glossy : {false, true}) {
    Tilted scene(24, glossy);
    scene.simulation.sky_directions = 128;
    scene.simulation.instruments[0].samples_u = scene.simulation.instruments[0].samples_v = 2;
    const auto image = test::render_image(scene.simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}));
    // By blocks of pixels, as in test render_shapes.
    constexpr int kBlock = 4;
    struct Sums {
      double difference = 0, square = 0, square_of_pixels = 0;
    };
    std::vector<Sums> sums(kCentres.size());
    int count = 0;
    for (int line = 0; line < image.lines; line += kBlock)
      for (int pixel = 0; pixel < image.pixels; pixel += kBlock) {
        const RcLocal viewer = scene.viewer(line + 0.5 * (kBlock - 1), pixel + 0.5 * (kBlock - 1));
        std::vector<double> sum(kCentres.size());
        constexpr int kRows = 60, kColumns = 120;
        for (int i = 0; i < kRows; ++i)
          for (int j = 0; j < kColumns; ++j) {
            const double cosine = (i + 0.5) / kRows, sine = std::sqrt(1 - cosine * cosine);
            const double turn = 2 * kPi * (j + 0.5) / kColumns;
            const RcAngles angles =
                rc_angles(scene.normal, {sine * std::cos(turn), sine * std::sin(turn), cosine}, viewer);
            if (!(angles.cos_in > 0)) continue;
            for (std::size_t b = 0; b < sum.size(); ++b)
              sum[b] += scene.sent(kCentres[b], angles, glossy) * angles.cos_in;
          }
        for (std::size_t b = 0; b < sum.size(); ++b) {
          const double want = kSkyRadiance * sum[b] * 2 * kPi / (kRows * kColumns);
          double off = 0;
          for (int i = 0; i < kBlock; ++i)
            for (int j = 0; j < kBlock; ++j) {
              const double of_pixel = image.at(line + i, pixel + j, static_cast<int>(b)) / want - 1;
              off += of_pixel / (kBlock * kBlock), sums[b].square_of_pixels += of_pixel * of_pixel;
            }
          sums[b].difference += off, sums[b].square += off * off;
        }
        ++count;
      }
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const double difference = sums[b].difference / count;
      const double error = std::sqrt(std::max(0.0, sums[b].square / count - difference * difference) / count);
      CAPTURE(glossy);
      CAPTURE(kCentres[b]);
      CAPTURE(difference);
      CAPTURE(error);
      CHECK_WITHIN(difference, 4 * error + 1e-3);  // of the quadrature 1e-3, as in test render_shapes
      CHECK(std::sqrt(sums[b].square_of_pixels / (count * kBlock * kBlock)) < 0.15);
    }
  }
}

// Sums of shares that add up to 1 round otherwise than 1: 1e-5 of floats, many of them along paths.
TEST_CASE("S21 shapes by wavelength: nodes that are all alike are no nodes") {
  for (const bool glossy : {false, true}) {
    const auto image_of = [&](bool nodes) {
      scene::Simulation simulation;
      const auto surface = test::add_material(simulation.scene, "changing", kReflectance),
                 wall = test::add_material(simulation.scene, "wall", 0.6);
      for (scene::Material& material : simulation.scene.materials) {
        const bool first = &material == simulation.scene.materials.data();
        const scene::Shape front{first ? scene::Shape{RC_SHAPE_rpv, {0.8, -0.1, 0.5}} : scene::Shape{RC_SHAPE_lambert}};
        material.front = front;
        if (nodes) material.front_nodes = {{0.5, front}, {0.62, front}, {0.8, front}};
        if (glossy && first) material.gloss = {RC_SHAPE_gloss, {0.3, 0.4}};
        if (glossy && first && nodes) material.gloss_nodes = {{0.5, material.gloss}, {0.7, material.gloss}};
        scene::make_lobes(material);
      }
      test::place(simulation.scene, test::rectangle({-40, -40, 0}, {80, 0, 0}, {0, 80, 0}, surface));
      test::place(simulation.scene, test::box({-6, -6, 0}, {4, 12, 9}, wall));
      finish_top_tree(simulation.scene);
      simulation.sky_directions = 64, simulation.bounces = 4, simulation.bounces_given = true;
      simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 110;
      simulation.tolerance = 1e-3;
      simulation.instruments = {test::nadir_camera(8, 8, 300, 3)};
      simulation.instruments[0].bands = test::gaussian_bands(kCentres, 0.005);
      simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 4;
      return test::render_image(simulation,
                                atmos::uniform_sky_table(kSunIrradiance, kSkyRadiance, {0.3, 1.0, 4.0}, 40));
    };
    const auto one = image_of(false), many = image_of(true);
    double worst = 0;
    for (std::size_t i = 0; i < one.radiance.size(); ++i)
      worst = std::max(worst, std::abs(double{many.radiance[i]} / double{one.radiance[i]} - 1));
    CAPTURE(glossy);
    CAPTURE(worst);
    CHECK(worst < 2e-5);
  }
}
