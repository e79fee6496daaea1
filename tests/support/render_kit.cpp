#include "tests/support/render_kit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "atmos_tables/table_rows.h"
#include "host/render/truth.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/kept_programs.h"
#include "tests/support/seeds.h"

namespace raycube::test {

std::uint32_t add_material(scene::CompiledScene& scene, const std::string& name, double reflectance) {
  scene::Material material;
  material.name = name;
  material.source = "constant";
  material.reflectance = {{0.3, 4.0}, {reflectance, reflectance}};
  scene.materials.push_back(material);
  shared::Surface surface{};
  surface.material[0] = static_cast<std::uint32_t>(scene.materials.size());
  surface.fraction[0] = 1.0f;
  scene.surfaces.push_back(surface);
  return static_cast<std::uint32_t>(scene.surfaces.size() - 1);
}

scene::TriangleMesh rectangle(const std::array<double, 3>& corner, const std::array<double, 3>& a,
                              const std::array<double, 3>& b, std::uint32_t surface) {
  scene::TriangleMesh mesh;
  for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    mesh.vertices.push_back({float(corner[0] + s * a[0] + t * b[0]), float(corner[1] + s * a[1] + t * b[1]),
                             float(corner[2] + s * a[2] + t * b[2])});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.surface = {surface, surface};
  mesh.user_face = {0, 1};
  return mesh;
}

scene::TriangleMesh join(const std::vector<scene::TriangleMesh>& parts) {
  scene::TriangleMesh all;
  for (const auto& part : parts) {
    const auto base = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const auto& t : part.triangles) all.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    all.surface.insert(all.surface.end(), part.surface.begin(), part.surface.end());
    for (std::size_t i = 0; i < part.triangles.size(); ++i)
      all.user_face.push_back(static_cast<std::uint32_t>(all.user_face.size()));
  }
  return all;
}

scene::TriangleMesh box(const std::array<double, 3>& lo, const std::array<double, 3>& hi, std::uint32_t surface) {
  const double x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
  return join({rectangle({lo[0], lo[1], hi[2]}, {x, 0, 0}, {0, y, 0}, surface),
               rectangle({lo[0], lo[1], lo[2]}, {0, y, 0}, {x, 0, 0}, surface),
               rectangle({lo[0], lo[1], lo[2]}, {x, 0, 0}, {0, 0, z}, surface),
               rectangle({lo[0], hi[1], lo[2]}, {0, 0, z}, {x, 0, 0}, surface),
               rectangle({lo[0], lo[1], lo[2]}, {0, 0, z}, {0, y, 0}, surface),
               rectangle({hi[0], lo[1], lo[2]}, {0, y, 0}, {0, 0, z}, surface)});
}

void place(scene::CompiledScene& scene, const scene::TriangleMesh& mesh) {
  const std::uint32_t index = append_mesh(scene, "mesh " + std::to_string(scene.meshes.size()), mesh);
  append_instance(scene, index, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, index);
}

scene::Instrument nadir_camera(int pixels, int lines, double height_m, double gsd_m, double x_m, double y_m) {
  scene::Instrument camera;
  camera.name = "camera";
  camera.kind = scene::InstrumentKind::framing;
  camera.pixels = pixels;
  camera.lines = lines;
  camera.ifov_along_rad = camera.ifov_across_rad = gsd_m / height_m;
  camera.poses = {{x_m, y_m, height_m, 0, 0, 0}};
  camera.samples_u = camera.samples_v = 4;
  camera.bands = gaussian_bands({0.5, 0.7, 0.9}, 0.01);
  return camera;
}

double worst_relative(const Image& image, const std::vector<double>& expected) {
  double worst = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel)
      for (int band = 0; band < image.bands; ++band)
        worst = std::max(worst, std::abs(image.at(line, pixel, band) / expected[band] - 1));
  return worst;
}

atmos::UniformAir uniform_air(const GreyAir& air, const scene::Sun& sun) {
  const auto constant = [](double value) { return [value](double) { return value; }; };
  atmos::UniformAir out;
  out.solar_irradiance = constant(air.solar_irradiance);
  out.sun_transmission = constant(air.sun_transmission);
  out.view_transmission = constant(air.view_transmission);
  out.two_way_factor = constant(air.two_way_factor);
  out.sky_radiance = constant(air.sky_radiance);
  out.path_radiance = constant(air.path_radiance);
  out.sun_zenith_deg = sun.zenith_deg, out.sun_azimuth_deg = sun.azimuth_deg;
  return out;
}

std::vector<scene::Band> gaussian_bands(const std::vector<double>& centers_um, double fwhm_um) {
  std::vector<scene::Band> bands;
  for (const double center : centers_um) {
    scene::Band band;
    band.center_um = center;
    band.fwhm_um = fwhm_um;
    bands.push_back(band);
  }
  return bands;
}

Image render_image(const scene::Simulation& simulation, const atmos::RenderTable& table,
                   const render::RenderOptions& options, const std::function<void(plan::Plan&)>& adjust) {
  const scene::Instrument& instrument = simulation.instruments.at(0);
  plan::Plan plan = plan::make_plan(simulation, instrument, table, sensors::view_bounds(instrument));
  if (adjust) adjust(plan);
  return render_planned(simulation, std::move(plan), options);
}

Image render_planned(const scene::Simulation& simulation, plan::Plan plan, const render::RenderOptions& options) {
  const scene::Instrument& instrument = simulation.instruments.at(0);
  Image image;
  image.plan = std::move(plan);
  image.lines = instrument.lines;
  image.pixels = instrument.pixels;
  image.bands = static_cast<int>(instrument.bands.size());
  image.layers = static_cast<int>(render::truth_layer_names(simulation.scene, instrument).size());
  render::Renderer renderer(simulation.scene, options);
  image.statistics = renderer.render(
      instrument, image.plan, simulation.sun, testing::seed(simulation.seed), [&](const render::Strip& strip) {
        const std::size_t pixels = std::size_t(strip.lines) * image.pixels;
        image.radiance.insert(image.radiance.end(), strip.radiance, strip.radiance + pixels * image.bands);
        if (strip.band_error)
          image.band_error.insert(image.band_error.end(), strip.band_error, strip.band_error + pixels * image.bands);
        image.truth.insert(image.truth.end(), strip.truth, strip.truth + pixels * image.layers);
      });
  return image;
}

void add_ground_coupling(atmos::RenderTable& table) {
  atmos::Row& albedo = atmos::add_row(table, "spherical_albedo", "test");
  atmos::Row& up = atmos::add_row(table, "diffuse_view_transmission", "test");
  atmos::Row& back = atmos::add_row(table, "diffuse_return", "test");
  const auto& wavelength = table.axis("wavelength").nodes;
  const auto& height = table.axis("target_height").nodes;
  const auto& view = table.axis("view_zenith").nodes;
  const auto& sky = table.axis("sky_zenith").nodes;
  const double degree = std::numbers::pi / 180;
  for (std::size_t i = 0, u = 0, b = 0; i < wavelength.size(); ++i)
    for (std::size_t h = 0; h < height.size(); ++h) {
      const double depth = 0.12 * std::pow(0.55 / wavelength[i], 2) * std::exp(-height[h] / 2000);
      // t = a + c sin^2(zenith): S = 2 int t mu dmu = a + c / 2
      albedo.values[i * height.size() + h] = static_cast<float>(0.75 * depth);
      for (const double z : view)
        up.values[u++] =
            static_cast<float>(-0.6 * std::expm1(-depth * std::exp(-height[h] / 500) / std::cos(z * degree)));
      for (const double z : sky)
        back.values[b++] = static_cast<float>(depth * (0.5 + 0.5 * std::pow(std::sin(z * degree), 2)));
    }
}

}  // namespace raycube::test
