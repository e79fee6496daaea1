#include "host/lidar/return_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "host/base/units.h"
#include "host/lidar/detector.h"
#include "host/lidar/overlap.h"
#include "host/lidar/pulse_lobes.h"
#include "host/lidar/pulse_taps.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/owner.h"

namespace raycube::lidar {

namespace {

Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
Vec3 unit(const Vec3& a) { return (1 / length(a)) * a; }
double row(const shared::rc_float4& r, const Vec3& p) { return r.x * p[0] + r.y * p[1] + r.z * p[2] + r.w; }
Vec3 place(const shared::Instance& instance, const Vec3& p) {
  return {row(instance.world_from_local_0, p), row(instance.world_from_local_1, p),
          row(instance.world_from_local_2, p)};
}

/// Depth of a node's air along a segment: mean extinction between its heights.
double air_depth(const AirColumn& air, std::size_t node, const Vec3& a, const Vec3& b) {
  if (air.posts == 0) return 0;
  const double* depth = air.depth.data() + node * static_cast<std::size_t>(air.posts);
  const auto at = [&](double z) {
    const double x = (z - air.z0_m) / air.dz_m;
    if (x >= air.posts - 1) return depth[air.posts - 1];
    const auto i = static_cast<std::size_t>(std::max(0.0, std::floor(x)));
    return depth[i] + (x - static_cast<double>(i)) * (depth[i + 1] - depth[i]);
  };
  double low = std::min(a[2], b[2]), high = std::max(a[2], b[2]);
  if (high - low < 1e-3) low -= 0.5, high += 0.5;
  return (at(high) - at(low)) / (high - low) * length(b - a);
}

/// What air and volumes let through of a line on the way from the exit over a point to the pupil: nodes are averaged
/// after the exponential.
double transmission(const LidarPlan& plan, const FlatVolumes& volumes, int line, const Shot& shot, const Vec3& point) {
  const std::size_t nodes = plan.nodes.size(),
                    first = static_cast<std::size_t>(plan.first_node[static_cast<std::size_t>(line)]);
  const std::size_t last = static_cast<std::size_t>(plan.first_node[static_cast<std::size_t>(line) + 1]);
  if (plan.air.posts == 0 && volumes.volumes.empty()) return 1;
  std::vector<double> fields;
  for (std::size_t v = 0; v < volumes.volumes.size(); ++v)
    fields.push_back(volume_path(volumes, v, shot.exit_m, point) + volume_path(volumes, v, shot.pupil_m, point));
  double sum = 0;
  for (std::size_t n = first; n < last; ++n) {
    double depth = air_depth(plan.air, n, shot.exit_m, point) + air_depth(plan.air, n, point, shot.pupil_m);
    for (std::size_t v = 0; v < fields.size(); ++v) {
      const double per_ppm_m =
          v * nodes + n < plan.cross_section_cm2.size() ? plan.cross_section_cm2[v * nodes + n] * kMoleculesPerPpmM : 0;
      depth += fields[v] * (static_cast<double>(volumes.volumes[v].strength.x) * per_ppm_m +
                            static_cast<double>(volumes.volumes[v].particles.x));
    }
    sum += plan.nodes[n].weight * std::exp(-depth);
  }
  return sum;
}

/// Clear aperture, m2; a thin camera's is pi / (1 + 4 F^2) in place of pi / (4 F^2) of it.
double collecting_area_m2(const scene::LidarReceiver& receiver) {
  const double area = M_PI * (receiver.aperture_radius_m * receiver.aperture_radius_m -
                              receiver.obscuration_radius_m * receiver.obscuration_radius_m);
  if (!receiver.tangent_aperture || receiver.focal_length_m == 0) return area;
  const double f_number = receiver.focal_length_m / (2 * receiver.aperture_radius_m), square = 4 * f_number * f_number;
  return area * square / (1 + square);
}

/// Share of the beam's photons that a square metre across its axis gets at a place `along` the axis, `aside` off it.
double fluence_per_m2(const scene::LidarPulse& pulse, double half_divergence_rad, double along, double aside) {
  const double grown = along * std::tan(half_divergence_rad);
  if (pulse.profile == scene::BeamProfile::uniform) {
    const double radius = pulse.exit_radius_m + grown;
    return aside <= radius && radius > 0 ? 1 / (M_PI * radius * radius) : 0;
  }
  const double spot = std::max(pulse.exit_radius_m * pulse.exit_radius_m + grown * grown, 1e-30);
  return 2 / (M_PI * spot) * std::exp(-2 * aside * aside / spot);
}

/// Pixel of an array that a point falls on, pixels lying on a plane of tangents; -1: beside it.
int pixel_of(const scene::LidarReceiver& receiver, const Shot& shot, const Vec3& point) {
  const Vec3 v = point - shot.pupil_m;
  const double along = dot(v, shot.pupil_axis);
  if (!(along > 0)) return -1;
  const double step = 1 / (along * receiver.pixel_pitch_rad);
  const double column = std::floor(dot(v, shot.pupil_u) * step + 0.5 * receiver.columns);
  const double row = std::floor(dot(v, cross(shot.pupil_axis, shot.pupil_u)) * step + 0.5 * receiver.rows);
  if (column < 0 || column >= receiver.columns || row < 0 || row >= receiver.rows) return -1;
  return static_cast<int>(row) * receiver.columns + static_cast<int>(column);
}

/// Diffuse matter of a surface at a line.
struct Diffuse {
  double reflectance = 0, through = 0;  ///< through: leaves
  std::uint32_t material = RC_NONE;     ///< with the largest share
  bool lambert = true;                  ///< all of it, as far as it reflects
};

Diffuse diffuse(const scene::CompiledScene& scene, const LidarPlan& plan, std::uint32_t surface_number, int line) {
  const auto& surface = scene.surfaces[surface_number];
  Diffuse out;
  float largest = 0;
  for (int m = 0; m < 4; ++m) {
    if (surface.material[m] == 0) continue;
    const std::size_t number = surface.material[m] - 1;
    const Matter& matter =
        plan.matter[number * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line)];
    const double share = static_cast<double>(surface.fraction[m]);
    out.reflectance += share * matter.reflectance;
    if (scene.materials[number].behind.number == RC_SHAPE_leaf) out.through += share * matter.transmittance;
    out.lambert = out.lambert && scene.materials[number].front.number == RC_SHAPE_lambert &&
                  scene.materials[number].further.empty();
    if (surface.fraction[m] > largest)
      largest = surface.fraction[m], out.material = scene::family_surface(scene, surface.material[m] - 1);
  }
  return out;
}

/// Between `in` and `out`, unit vectors away from the surface.
RcAngles angles_between(const Vec3& normal, const Vec3& in, const Vec3& out) {
  const auto local = [](const Vec3& v) { return RcLocal{v[0], v[1], v[2]}; };
  return rc_angles(local(normal), local(in), local(out));
}

/// Of what surfaces send to an echo.
struct OfEcho {
  double window_m = 0;           ///< so far from it
  double weight = 0, range = 0;  ///< photo-electrons, and times half their path
};

/// Distances from each echo within which a surface's return explains it: the recorded pulse's width and a bin.
/// The first photons of a strong return fire a Geiger cell before its power has come: where surfaces send more
/// to an echo's own bins (three, for the jitter of its time) than air and background do, the pulse's whole span.
void set_windows(const LidarPlan& plan, const ShotResult& result, int pixel, int line, const std::vector<Echo>& echoes,
                 std::vector<OfEcho>& out) {
  const scene::Lidar& lidar = plan.lidar;
  const double m_per_s = 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index;
  out.assign(echoes.size(), {m_per_s * (base::kFwhmOfSigma * recorded_sigma_s(lidar) + lidar.gate.bin_s)});
  if (lidar.detector.mode != scene::DetectorMode::geiger || result.first.empty()) return;
  const auto bins = static_cast<std::ptrdiff_t>(lidar.gate.bins);
  const std::size_t row = static_cast<std::size_t>(pixel * plan.lines() + line);
  const PulseSpan span = pulse_span(lidar.pulse);
  const double centre_s = pulse_centroid_s(lidar.pulse),
               wide_m = m_per_s * (std::max(centre_s - span.begin_s, span.end_s - centre_s) + lidar.gate.bin_s);
  const double light_hz =
      lidar.detector.solar_background && !result.background_hz.empty() ? result.background_hz[row] : 0;
  const double background =
      lidar.detector.dark_rate_hz * lidar.gate.bin_s + lidar.receiver.quantum_efficiency * light_hz * lidar.gate.bin_s;
  for (std::size_t e = 0; e < echoes.size(); ++e) {
    const auto own =
        static_cast<std::ptrdiff_t>(std::floor((echoes[e].time_s - lidar.gate.start_s) / lidar.gate.bin_s));
    double surfaces = 0, others = 0;
    for (std::ptrdiff_t bin = std::max<std::ptrdiff_t>(0, own - 1); bin <= std::min(bins - 1, own + 1); ++bin) {
      const std::size_t at = row * static_cast<std::size_t>(bins) + static_cast<std::size_t>(bin);
      surfaces += lidar.receiver.quantum_efficiency * static_cast<double>(result.first[at]);
      others += background +
                (result.air.empty() ? 0 : lidar.receiver.quantum_efficiency * static_cast<double>(result.air[at]));
    }
    if (surfaces > others) out[e].window_m = std::max(out[e].window_m, wide_m);
  }
}

/// Arc cosine of 0 .. 1, rad, to 2e-8: Abramowitz & Stegun (1964), 4.4.46. A return's many angles are averaged.
double angle_of(double cosine) {
  constexpr double kTerms[] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                               0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
  double sum = 0;
  for (int k = 7; k >= 0; --k) sum = sum * cosine + kTerms[k];
  return std::sqrt(1 - cosine) * sum;
}

/// Light that surfaces of one placement and material send to an echo.
struct Sender {
  std::size_t echo = 0;
  std::uint32_t placement = RC_NONE, material = RC_NONE;
  double sent = 0;
  auto key() const { return std::tuple(echo, placement, material); }
  bool same(const Sender& other) const { return key() == other.key(); }
};

/// Of each echo's senders the strongest names its object and material.
void name_senders(std::vector<Sender>& senders, std::vector<ReturnTruth>& out) {
  if (senders.size() > 1)
    std::stable_sort(senders.begin(), senders.end(),
                     [](const Sender& a, const Sender& b) { return a.key() < b.key(); });
  std::vector<double> most(out.size(), -1.0);
  for (std::size_t first = 0; first < senders.size();) {
    Sender sum = senders[first];
    std::size_t next = first + 1;
    for (; next < senders.size() && senders[next].same(sum); ++next) sum.sent += senders[next].sent;
    if (sum.sent > most[sum.echo]) {
      most[sum.echo] = sum.sent;
      out[sum.echo].object = sum.placement, out[sum.echo].material = sum.material;
    }
    first = next;
  }
}

}  // namespace

SubRays::SubRays(const LidarPlan& plan, const Shot& shot, int pixel) : plan_(plan), shot_(shot) {
  const auto& receiver = plan.lidar.receiver;
  if (plan.lidar.transport.sampling == scene::LidarSampling::receiver) {
    backwards_ = true;
    column_ = pixel % receiver.columns - 0.5 * (receiver.columns - 1);
    row_ = pixel / receiver.columns - 0.5 * (receiver.rows - 1);
    scale_ = plan.pixels() > 1 ? receiver.pixel_pitch_rad : std::sqrt(M_PI) * receiver.half_fov_rad;
    u_ = shot.pupil_u, v_ = cross(shot.pupil_axis, shot.pupil_u);
  } else {
    scale_ = std::tan(shot.half_divergence_rad);
    u_ = shot.exit_u, v_ = cross(shot.exit_axis, shot.exit_u);
  }
}

SubRay SubRays::ray(int k) const {
  const auto i = static_cast<std::size_t>(k);
  const Footprint& footprint = plan_.footprint;
  const double a = (column_ + static_cast<double>(footprint.a[i])) * scale_,
               b = (row_ + static_cast<double>(footprint.b[i])) * scale_;
  if (backwards_) return {shot_.pupil_m, unit(shot_.pupil_axis + a * u_ + b * v_)};
  SubRay out{shot_.exit_m, unit(shot_.exit_axis + a * u_ + b * v_)};
  if (!footprint.exit_a.empty())
    out.from_m = out.from_m + plan_.lidar.pulse.exit_radius_m * (static_cast<double>(footprint.exit_a[i]) * u_ +
                                                                 static_cast<double>(footprint.exit_b[i]) * v_);
  return out;
}

HitPlane::HitPlane(const scene::CompiledScene& scene, const FirstHit& hit) : hit_(hit) {
  const shared::TriBlock& block = scene.blocks[hit.primitive / RC_BLOCK];
  const std::size_t lane = hit.primitive % RC_BLOCK;
  const shared::Instance& instance = scene.instances[hit.instance];
  corner_ = place(instance, {block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]});
  const Vec3 b = place(instance, {block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]});
  const Vec3 c = place(instance, {block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]});
  const Vec3 across = cross(b - corner_, c - corner_);
  if (dot(across, across) > 0) normal_ = unit(across);
  surface_ = block.surface[lane];
  placement_ = scene::owner_of(scene, hit.instance, hit.primitive).placement;
}

SurfacePoint HitPlane::met_by(const SubRay& ray) const {
  SurfacePoint out;
  const double facing = dot(normal_, ray.direction);
  if (facing == 0) return out;
  out.at_m = ray.from_m + dot(normal_, corner_ - ray.from_m) / facing * ray.direction;
  out.normal = (facing > 0 ? -1.0 : 1.0) * normal_;
  out.surface = surface_, out.placement = placement_;
  out.hit = true;
  return out;
}

namespace {

/// Of one pulse's light in echoes whose ranges count from when it was sent.
std::vector<ReturnTruth> truth_of_pulse(const scene::CompiledScene& scene, const FlatVolumes& volumes,
                                        const LidarPlan& plan, const Shot& shot, const std::vector<FirstHit>& hits,
                                        int pixel, int line, const std::vector<Echo>& echoes,
                                        std::vector<OfEcho> of_echo) {
  std::vector<ReturnTruth> out(echoes.size());
  const scene::Lidar& lidar = plan.lidar;
  const auto& receiver = lidar.receiver;
  const bool backwards = lidar.transport.sampling == scene::LidarSampling::receiver, array = plan.pixels() > 1;
  const int samples = static_cast<int>(plan.footprint.a.size());
  const double m_per_s = 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index,
               late_m = m_per_s * pulse_centroid_s(lidar.pulse);
  const double each = plan.photons[static_cast<std::size_t>(line)] / samples * collecting_area_m2(receiver) *
                      receiver.efficiency * receiver.quantum_efficiency * shot.gain *
                      (shot.line_gain.empty() ? 1 : shot.line_gain[static_cast<std::size_t>(line)]);
  const Stop stop{receiver.aperture_radius_m, receiver.obscuration_radius_m, receiver.half_fov_rad, receiver.focus_m};
  const bool vignetted = lidar.transport.overlap == scene::LidarOverlap::exact && !array && !backwards;
  std::vector<Sender> senders;
  const SubRays rays(plan, shot, pixel);
  HitPlane plane;
  Diffuse matter;
  std::uint32_t surface = RC_NONE;  ///< of matter
  for (int k = 0; k < samples; ++k) {
    const auto& hit = hits[static_cast<std::size_t>(backwards ? pixel * samples + k : k)];
    if (hit.instance == RC_NONE) continue;
    if (!plane.is_of(hit)) plane = HitPlane(scene, hit);  // neighbours mostly meet the same triangle
    const SurfacePoint point = plane.met_by(rays.ray(k));
    if (!point.hit) continue;
    if (array && !backwards && pixel_of(receiver, shot, point.at_m) != pixel) continue;
    const Vec3 there = point.at_m - shot.exit_m, back = shot.pupil_m - point.at_m;
    const double out_m = length(there), home = length(back), half_path = 0.5 * (out_m + home);
    std::size_t nearest = echoes.size();
    double off = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < echoes.size(); ++e) {
      const double away = std::abs(echoes[e].range_m - late_m - half_path);
      if (away <= of_echo[e].window_m && away <= off) off = away, nearest = e;
    }
    if (nearest == echoes.size()) continue;
    if (point.surface != surface) matter = diffuse(scene, plan, surface = point.surface, line);
    const double passed = transmission(plan, volumes, line, shot, point.at_m),
                 off_axis = dot(-1.0 * shot.pupil_axis, (1 / home) * back);
    // Angle with the way to the end of the path: the pupil, or back to the exit. Behind a leaf: what it lets through.
    const double facing = backwards ? -dot(point.normal, (1 / out_m) * there) : dot(point.normal, (1 / home) * back);
    const auto form = [&] {
      if (matter.lambert) return M_1_PI;
      return front_form(plan, scene, point.surface, line,
                        angles_between(point.normal, (-1 / out_m) * there, (1 / home) * back));
    };
    const double scattered = (facing > 0 ? matter.reflectance * form() : matter.through * M_1_PI) * std::abs(facing);
    double eta = 1, geometry = 0;
    if (backwards) {
      const double along = dot(there, shot.exit_axis), aside = std::sqrt(std::max(0.0, out_m * out_m - along * along));
      const double solid_angle = receiver.pixel_pitch_rad * receiver.pixel_pitch_rad * off_axis * off_axis * off_axis;
      if (along > 0)
        geometry = off_axis * solid_angle * fluence_per_m2(lidar.pulse, shot.half_divergence_rad, along, aside) *
                   out_m / along;
    } else {
      const double along = home * off_axis, aside = std::sqrt(std::max(0.0, home * home - along * along));
      if (vignetted) eta = vignetting(stop, along, aside);
      geometry = std::max(0.0, off_axis) / (home * home) * eta;
    }
    const double sent = each * scattered * geometry * passed;
    ReturnTruth& truth = out[nearest];
    truth.order = 1;
    truth.expected_pe += static_cast<float>(sent);
    truth.incidence_deg +=
        static_cast<float>(base::deg_from_rad(angle_of(std::min(1.0, std::abs(dot(point.normal, there)) / out_m))));
    truth.overlap += static_cast<float>(eta);
    truth.transmission_2way += static_cast<float>(passed);
    truth.subray_share += 1;
    of_echo[nearest].weight += sent;
    of_echo[nearest].range += sent * half_path;
    const Sender sender{nearest, point.placement, matter.material, sent};
    if (!senders.empty() && senders.back().same(sender))
      senders.back().sent += sent;
    else
      senders.push_back(sender);
  }
  for (std::size_t e = 0; e < echoes.size(); ++e) {
    ReturnTruth& truth = out[e];
    truth.range_m =
        of_echo[e].weight > 0 ? of_echo[e].range / of_echo[e].weight : std::numeric_limits<double>::quiet_NaN();
    if (truth.order == 0) continue;
    const float count = truth.subray_share;
    truth.incidence_deg /= count, truth.overlap /= count, truth.transmission_2way /= count,
        truth.subray_share /= static_cast<float>(samples);
  }
  name_senders(senders, out);
  return out;
}

}  // namespace

std::vector<ReturnTruth> return_truth(const scene::CompiledScene& scene, const FlatVolumes& volumes,
                                      const LidarPlan& plan, const ShotResult& result, int pixel, int line,
                                      const std::vector<Echo>& echoes) {
  std::vector<OfEcho> of_echo;
  set_windows(plan, result, pixel, line, echoes, of_echo);
  auto out = truth_of_pulse(scene, volumes, plan, result.shot, result.hits, pixel, line, echoes, of_echo);
  const double period_m =
      0.5 * base::kLightSpeed_m_s / plan.lidar.transport.group_index / std::max(plan.lidar.prf_hz, 1e-300);
  for (const ShotResult::Other& other : result.others) {
    std::vector<Echo> later = echoes;
    for (Echo& echo : later) echo.range_m += static_cast<double>(other.pulses_back) * period_m;
    const auto found = truth_of_pulse(scene, volumes, plan, other.shot, other.hits, pixel, line, later, of_echo);
    for (std::size_t e = 0; e < out.size(); ++e)
      if (found[e].expected_pe > out[e].expected_pe)
        out[e] = found[e], out[e].pulses_back = static_cast<int>(other.pulses_back);
  }
  return out;
}

Vec3 apparent_point(const LidarPlan& plan, const Shot& shot, int pixel, double range_m) {
  const bool backwards = plan.lidar.transport.sampling == scene::LidarSampling::receiver;
  Vec3 from = backwards ? shot.pupil_m : shot.exit_m, direction = shot.exit_axis;
  const Vec3 other = backwards ? shot.exit_m : shot.pupil_m;
  if (plan.pixels() > 1) {
    const auto& receiver = plan.lidar.receiver;
    const double a = (pixel % receiver.columns - 0.5 * (receiver.columns - 1)) * receiver.pixel_pitch_rad;
    const double b = (pixel / receiver.columns - 0.5 * (receiver.rows - 1)) * receiver.pixel_pitch_rad;
    from = shot.pupil_m;
    direction = unit(shot.pupil_axis + a * shot.pupil_u + b * cross(shot.pupil_axis, shot.pupil_u));
  }
  // |t d| + |from + t d - other| = 2 range: squaring once leaves a linear equation in t.
  const Vec3 base = from - (plan.pixels() > 1 ? shot.exit_m : other);
  const double path = 2 * range_m, along = dot(direction, base);
  const double t = (path * path - dot(base, base)) / (2 * (path + along));
  return from + t * direction;
}

}  // namespace raycube::lidar
