#include "host/reference/sampled_pixel.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/mat3x3.hpp>

#include "host/base/error.h"
#include "kernels/sampling/sampler.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::reference {

namespace {

double phi(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

/// Response of the detector's box blurred by a Gaussian at x pixels from the centre.
double line_response(double x, double sigma) { return phi((x + 0.5) / sigma) - phi((x - 0.5) / sigma); }

/// Its integral over [lo, hi], by Simpson's rule on pieces of sigma / 8 or finer.
double response_integral(double lo, double hi, double sigma) {
  if (sigma == 0) return std::max(0.0, std::min(hi, 0.5) - std::max(lo, -0.5));
  const int n = 2 * std::max(8, static_cast<int>(std::ceil(8 * (hi - lo) / sigma)));
  double sum = line_response(lo, sigma) + line_response(hi, sigma);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * line_response(lo + (hi - lo) * i / n, sigma);
  return sum * (hi - lo) / (3.0 * n);
}

std::vector<double> line_weights(int cells, double support, double sigma) {
  std::vector<double> out;
  for (int i = 0; i < cells; ++i)
    out.push_back(response_integral((static_cast<double>(i) / cells - 0.5) * support,
                                    (static_cast<double>(i + 1) / cells - 0.5) * support, sigma));
  return out;
}

int sampler_code(scene::SamplerKind kind) {
  switch (kind) {
    case scene::SamplerKind::lattice:
      return RC_SAMPLER_LATTICE;
    case scene::SamplerKind::jittered:
      return RC_SAMPLER_JITTERED;
    case scene::SamplerKind::grid:
      break;
  }
  return RC_SAMPLER_GRID;
}

}  // namespace

void append_addresses(std::vector<PixelAddress>& to, int line, int first, int count, const shared::RayGroup* groups,
                      int width) {
  for (int column = first; column < first + count; ++column)
    to.push_back({static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(column), groups[column / width],
                  column % width, width});
}

Ray pixel_ray(const scene::Instrument& instrument, std::uint64_t seed, const PixelAddress& address, int sample) {
  float u = 0, v = 0;
  rc_sample_uv(sampler_code(instrument.sampler), instrument.samples_u, instrument.samples_v,
               static_cast<float>(instrument.psf_support_px), static_cast<rc_u32>(seed),
               address.line * static_cast<std::uint32_t>(instrument.pixels) + address.sample, sample, &u, &v);
  return sample_ray(address.group, address.lane, address.group_width, u, v);
}

std::vector<double> sample_weights(const scene::Instrument& instrument) {
  const std::size_t count =
      static_cast<std::size_t>(instrument.samples_u) * static_cast<std::size_t>(instrument.samples_v);
  if (instrument.sampler == scene::SamplerKind::lattice)
    return std::vector<double>(count, 1.0 / static_cast<double>(count));
  const auto along = line_weights(instrument.samples_u, instrument.psf_support_px, instrument.psf_sigma_px);
  const auto across = line_weights(instrument.samples_v, instrument.psf_support_px, instrument.psf_sigma_px);
  std::vector<double> weights;
  double sum = 0;
  for (double v : across)
    for (double u : along) sum += weights.emplace_back(u * v);
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Distance from a sample's point to the farthest corner of its triangle, m, scene frame.
double ReferenceScene::farthest_corner_m(const Sample& sample) const {
  const shared::Instance& placed = compiled.instances[sample.hit.instance];
  const glm::dvec3 translation(placed.world_from_local_0.w, placed.world_from_local_1.w, placed.world_from_local_2.w);
  const glm::dmat3 linear(placed.world_from_local_0.x, placed.world_from_local_1.x, placed.world_from_local_2.x,
                          placed.world_from_local_0.y, placed.world_from_local_1.y, placed.world_from_local_2.y,
                          placed.world_from_local_0.z, placed.world_from_local_1.z, placed.world_from_local_2.z);
  double corner = 0;
  for (int i = 0; i < 3; ++i)
    corner =
        std::max(corner, glm::length(linear * vertex(compiled, sample.hit.primitive, i) + translation - sample.point));
  return corner;
}

double ReferenceScene::point_ulp_m(const Sample& sample) const {
  const shared::Instance& placed = compiled.instances[sample.hit.instance];
  const glm::dvec3 translation(placed.world_from_local_0.w, placed.world_from_local_1.w, placed.world_from_local_2.w);
  return kUlp * (glm::length(sample.point) + glm::length(translation) + farthest_corner_m(sample));
}

bool ReferenceScene::sees(const Sample& sample, const glm::dvec3& direction, double t_far) const {
  const glm::dvec3 origin = sample.point + sample.normal * (kOffsetUlp * point_ulp_m(sample));
  return !embree.occluded({rounded(origin), rounded(direction)}, static_cast<float>(t_far));
}

Hit ReferenceScene::meets(const Sample& sample, const glm::dvec3& direction) const {
  const glm::dvec3 origin = sample.point + sample.normal * (kOffsetUlp * point_ulp_m(sample));
  return embree.intersect({rounded(origin), rounded(direction)});
}

Visibility ReferenceScene::sees_in_double(const Sample& sample, const glm::dvec3& direction, double t_far) const {
  const double ulp_m = point_ulp_m(sample);
  double slack_m = kOriginSlackUlp * ulp_m;
  if (!(compiled.instances[sample.hit.instance].flags & 1u)) {
    const glm::dvec3 origin = start_of(sample.ray);
    slack_m += kSlideUlp * kUlp * (glm::length(origin) + glm::length(sample.point - origin));
  }
  // Seen edge-on, the point slides along the surface by more than it is off: 1 / cosine, though never off its triangle.
  const double cosine = std::abs(glm::dot(sample.normal, glm::normalize(to_double(sample.ray.direction))));
  slack_m = std::min(slack_m / std::max(cosine, 1e-9), slack_m + farthest_corner_m(sample));
  return tracer.visibility({sample.point + sample.normal * (kOffsetUlp * ulp_m), direction, slack_m}, sample.hit,
                           t_far);
}

void ReferenceScene::place(Sample& sample, const plan::Plan& plan) const {
  sample.sun_visible = false;
  sample.cos_sun = 0;
  if (sample.hit.miss()) return;
  sample.point = hit_point(compiled, sample.ray, sample.hit);
  sample.normal = world_normal(compiled, sample.hit);
  if (glm::dot(sample.normal, to_double(sample.ray.direction)) > 0) sample.normal = -sample.normal;
  const glm::dvec3 sun = to_double(plan.sun_direction);
  sample.cos_sun = glm::dot(sample.normal, sun);
  sample.sun_visible = plan.sun_up && sample.cos_sun > 0 && sees(sample, sun);
}

void ReferenceScene::place(SampledPixel& pixel, std::size_t sample, const plan::Plan& plan) const {
  place(pixel.samples[sample], plan);
  const Sample& near = pixel.samples[sample];
  if (!pixel.glosses.empty()) {
    Sample& gloss = pixel.glosses[sample];
    gloss = near;
    gloss.side = gloss.rays = RC_GLOSS_SIDE;
    if (!near.hit.miss() && scene::gloss_of(compiled, near.hit.primitive) == nullptr) gloss.hit = {};
  }
  const auto lobes = static_cast<std::size_t>(plan.matter.further);
  for (std::size_t number = 0; number < lobes && !pixel.further.empty(); ++number) {
    Sample& lobe = pixel.further[number * (pixel.further.size() / lobes) + sample];
    lobe = near;
    lobe.side = RC_FURTHER_SIDE + static_cast<rc_id>(number);
    const scene::FurtherLobe* of = near.hit.miss() ? nullptr : scene::further_of(compiled, near.hit.primitive, number);
    if (of == nullptr)
      lobe.hit = {};
    else
      lobe.rays = scene::is_gloss(of->shape) ? RC_GLOSS_SIDE : RC_NEAR_SIDE;
  }
  if (pixel.far_sides.empty()) return;
  Sample& far = pixel.far_sides[sample];
  far = near;
  far.side = far.rays = RC_FAR_SIDE;
  far.sun_visible = false;
  if (near.hit.miss()) return;
  if (!scene::lets_light_through(compiled, near.hit.primitive)) {
    far.hit = {};
    return;
  }
  const glm::dvec3 sun = to_double(plan.sun_direction);
  far.normal = -near.normal;
  far.cos_sun = -near.cos_sun;
  far.sun_visible = plan.sun_up && far.cos_sun > 0 && sees(far, sun);
}

SampledPixel ReferenceScene::sample_pixel(const scene::Instrument& instrument, const plan::Plan& plan,
                                          std::uint64_t seed, const PixelAddress& address) const {
  SampledPixel pixel;
  pixel.number = address.line * static_cast<std::uint32_t>(instrument.pixels) + address.sample;
  const Ray center = sample_ray(address.group, address.lane, address.group_width, 0, 0);
  pixel.sensor = sensor_of(address.group, center);
  pixel.to_sensor = -glm::normalize(to_double(center.direction));
  if (!(pixel.to_sensor.z > 0))
    throw base::Error(base::Fault::input, "instrument '" + instrument.name + "', line " + std::to_string(address.line) +
                                              ", sample " + std::to_string(address.sample) +
                                              ": the pixel looks up or along the horizon; point the instrument down");
  const std::vector<double> weights = sample_weights(instrument);
  if (plan.matter.through) pixel.far_sides.resize(weights.size());
  if (plan.matter.glossy) pixel.glosses.resize(weights.size());
  pixel.further.resize(weights.size() * static_cast<std::size_t>(plan.matter.further));
  for (std::size_t s = 0; s < weights.size(); ++s) {
    Sample sample;
    sample.ray = pixel_ray(instrument, seed, address, static_cast<int>(s));
    sample.weight = weights[s];
    sample.hit = embree.intersect(sample.ray);
    pixel.samples.push_back(sample);
    place(pixel, s, plan);
  }
  return pixel;
}

}  // namespace raycube::reference
