#include "host/run/lidar_background.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <numeric>
#include <span>

#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/plan/quadrature.h"
#include "host/run/camera_job.h"
#include "host/render/lidar_owners.h"
#include "host/render/renderer.h"
#include "scene_compiler/matter.h"

namespace raycube::run {

namespace {

constexpr double kPlanck_J_s = 6.62607015e-34;

/// Pose of a camera that looks along `axis` with its columns along `u`: nose = u x axis, then yaw, pitch and roll of
/// these axes.
scene::Pose pose_towards(const lidar::Vec3& at, const lidar::Vec3& axis, const lidar::Vec3& u) {
  const glm::dvec3 right(u[0], u[1], u[2]), nose = glm::cross(right, glm::dvec3(axis[0], axis[1], axis[2]));
  const double heading = std::atan2(nose.x, nose.y);
  const glm::dvec3 level(std::cos(heading), -std::sin(heading), 0), down = glm::cross(nose, level);
  return {at[0],
          at[1],
          at[2],
          base::deg_from_rad(std::atan2(glm::dot(right, down), glm::dot(right, level))),
          base::deg_from_rad(std::asin(std::clamp(nose.z, -1.0, 1.0))),
          base::deg_from_rad(heading)};
}

/// Radiance below which nothing is a LIDAR's background: 2000 photons / s in a receiver of 10 cm and 2 mrad behind 1 nm
/// at 1.5 um.
constexpr double kDark_W_m2_sr_um = 1e-5;

/// Whether the scene is bright in a laser's light of itself: by night too.
bool emits_light(const scene::CompiledScene& scene, const scene::Lidar& lidar) {
  double hottest_K = 0;
  for (const auto material : scene::used_materials(scene))
    hottest_K = std::max(hottest_K, double{scene.materials[material].temperature_K});
  return std::any_of(lidar.pulse.lines.begin(), lidar.pulse.lines.end(), [&](const scene::LidarLine& line) {
    return line.wavelength_um > 2.5 ||
           (hottest_K > 0 && base::planck_radiance(line.wavelength_um, hottest_K) > kDark_W_m2_sr_um);
  });
}

/// Lines by wavelength, as an instrument's bands must ascend.
std::vector<std::size_t> ascending_lines(const scene::Lidar& lidar) {
  std::vector<std::size_t> order(lidar.pulse.lines.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return lidar.pulse.lines[a].wavelength_um < lidar.pulse.lines[b].wavelength_um;
  });
  return order;
}

/// Whether any lamp sends light that the receiver's filter lets through: looked for at 33 places of each passband, and
/// at the nodes of the lamp's spectrum in it.
bool lamps_send(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  const double half_um = plan::kGaussianCutFwhm * lidar.receiver.filter_fwhm_um;
  const auto sends = [&](const scene::LampSpectrum& spectrum, double um) {
    for (int i = -16; i <= 16; ++i)
      if (spectrum.at(um + i * half_um / 16) > 0) return true;
    return std::any_of(spectrum.wavelength_um.begin(), spectrum.wavelength_um.end(),
                       [&](double node) { return std::abs(node - um) < half_um && spectrum.at(node) > 0; });
  };
  return std::any_of(simulation.lamps.begin(), simulation.lamps.end(), [&](const scene::Lamp& lamp) {
    return std::any_of(lidar.pulse.lines.begin(), lidar.pulse.lines.end(),
                       [&](const auto& line) { return sends(lamp.spectrum, line.wavelength_um); });
  });
}

}  // namespace

bool has_background(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  return lidar.detector.solar_background &&
         (simulation.sun.zenith_deg < 90 || lamps_send(simulation, lidar) || emits_light(simulation.scene, lidar));
}

scene::Instrument background_camera(const lidar::LidarPlan& plan, std::span<const lidar::Shot> shots) {
  const scene::LidarReceiver& receiver = plan.lidar.receiver;
  const bool array = plan.pixels() > 1;
  scene::Instrument camera;
  camera.name = plan.lidar.name + " (solar_background)";
  camera.kind = array ? scene::InstrumentKind::framing : scene::InstrumentKind::pushbroom;
  camera.pixels = array ? receiver.columns : 1, camera.lines = array ? receiver.rows : static_cast<int>(shots.size());
  camera.ifov_along_rad = camera.ifov_across_rad =
      array ? receiver.pixel_pitch_rad : std::sqrt(std::numbers::pi) * std::max(receiver.half_fov_rad, 1e-9);
  camera.samples_u = camera.samples_v = 3;
  camera.auto_bounces = false;
  for (const std::size_t l : ascending_lines(plan.lidar)) {
    scene::Band band;
    band.center_um = plan.lidar.pulse.lines[l].wavelength_um;
    band.fwhm_um = receiver.filter_fwhm_um;
    camera.bands.push_back(band);
  }
  for (const auto& shot : array ? shots.first(1) : shots)
    camera.poses.push_back(pose_towards(shot.pupil_m, shot.pupil_axis, shot.pupil_u));
  return camera;
}

struct LidarBackground::State {
  const scene::Simulation& simulation;
  const lidar::LidarPlan& plan;
  Services& services;
  render::Renderer renderer;
  std::vector<std::size_t> order;  ///< of the camera's bands: the plan's lines

  std::vector<float> radiance(const scene::Instrument& camera) {
    const CameraJob job = prepare_camera(simulation, camera, services);
    std::vector<float> out;
    renderer.render(camera, job.plan, simulation.sun, simulation.seed, [&](const render::Strip& strip) {
      out.insert(out.end(), strip.radiance,
                 strip.radiance + static_cast<std::size_t>(strip.lines) * static_cast<std::size_t>(camera.pixels) *
                                      camera.bands.size());
    });
    return out;
  }

  /// Photons / s for a radiance in W m-2 sr-1 um-1 in line l.
  double rate(double value, std::size_t l, std::size_t pixel) const {
    const scene::LidarReceiver& r = plan.lidar.receiver;
    const double area = std::numbers::pi *
                        (r.aperture_radius_m * r.aperture_radius_m - r.obscuration_radius_m * r.obscuration_radius_m);
    const double solid_angle =
        plan.pixels() > 1 ? r.pixel_pitch_rad * r.pixel_pitch_rad : std::numbers::pi * r.half_fov_rad * r.half_fov_rad;
    const double photon_J = kPlanck_J_s * base::kLightSpeed_m_s / (plan.lidar.pulse.lines[l].wavelength_um * 1e-6);
    // Off the axis pixels of a plane take in cos^4 less, as they do of the signal.
    const double u = plan.pixels() > 1
                         ? r.pixel_pitch_rad * (static_cast<double>(pixel % static_cast<std::size_t>(r.columns)) -
                                                0.5 * (r.columns - 1))
                         : 0;
    const double v = plan.pixels() > 1
                         ? r.pixel_pitch_rad *
                               (static_cast<double>(pixel / static_cast<std::size_t>(r.columns)) - 0.5 * (r.rows - 1))
                         : 0;
    const double cos2 = 1 / (1 + u * u + v * v);
    return std::max(0.0, value) * area * solid_angle * cos2 * cos2 * render::camera_factor(r) * r.efficiency *
           r.filter_fwhm_um / photon_J;
  }
};

LidarBackground::LidarBackground(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                                 const render::RenderOptions& options, Services& services)
    : state_(new State{simulation, plan, services, render::Renderer(simulation.scene, options),
                       ascending_lines(plan.lidar)}) {}
LidarBackground::~LidarBackground() = default;

std::vector<std::vector<double>> LidarBackground::rates(const std::vector<lidar::Shot>& shots) {
  State& s = *state_;
  const auto pixels = static_cast<std::size_t>(s.plan.pixels()), lines = static_cast<std::size_t>(s.plan.lines());
  std::vector<std::vector<double>> out(shots.size(), std::vector<double>(pixels * lines));
  const auto take = [&](const std::vector<float>& radiance, std::size_t from, std::vector<double>& to) {
    for (std::size_t p = 0; p < pixels; ++p)
      for (std::size_t i = 0; i < lines; ++i)
        to[p * lines + s.order[i]] = s.rate(radiance[(from + p) * lines + i], s.order[i], p);
  };
  if (pixels > 1) {
    for (std::size_t i = 0; i < shots.size(); ++i) {
      if (i > 0 && shots[i].pupil_m == shots[i - 1].pupil_m && shots[i].pupil_axis == shots[i - 1].pupil_axis) {
        out[i] = out[i - 1];
        continue;
      }
      take(s.radiance(background_camera(s.plan, std::span(shots).subspan(i, 1))), 0, out[i]);
    }
    return out;
  }
  const auto radiance = s.radiance(background_camera(s.plan, shots));
  for (std::size_t i = 0; i < shots.size(); ++i) take(radiance, i, out[i]);
  return out;
}

}  // namespace raycube::run
