#include "host/reference/first_hits.h"

#include <algorithm>
#include <tuple>

#include "host/base/error.h"
#include "host/base/parallel.h"

namespace raycube::reference {

std::uint64_t HitReport::explained() const {
  std::uint64_t sum = 0;
  for (std::uint64_t count : hits) sum += count;
  return sum - of(Cause::agree) - of(Cause::unexplained);
}

void HitReport::add(const HitReport& other) {
  rays += other.rays;
  for (std::size_t c = 0; c < hits.size(); ++c) hits[c] += other.hits[c];
  device_right += other.device_right;
  embree_right += other.embree_right;
  hit_miss += other.hit_miss;
  hit_miss_double += other.hit_miss_double;
  unexplained.insert(unexplained.end(), other.unexplained.begin(), other.unexplained.end());
  std::sort(unexplained.begin(), unexplained.end(), [](const UnexplainedRay& a, const UnexplainedRay& b) {
    return std::tie(a.line, a.sample, a.ray) < std::tie(b.line, b.sample, b.ray);
  });
  if (unexplained.size() > kMostNamed) unexplained.resize(kMostNamed);
}

HitComparison::HitComparison(const scene::CompiledScene& scene, const scene::Instrument& instrument, std::uint64_t seed,
                             int threads)
    : instrument_(instrument), seed_(seed), threads_(threads), scene_(scene) {}

HitReport HitComparison::compare(const PixelHits& pixel) const {
  const auto samples =
      static_cast<std::size_t>(instrument_.samples_u) * static_cast<std::size_t>(instrument_.samples_v);
  if (pixel.hits.size() != samples)
    throw base::Error(base::Fault::bug, "check: the device handed over " + std::to_string(pixel.hits.size()) +
                                            " hits of a pixel with " + std::to_string(samples) + " samples");
  HitReport report;
  report.rays = samples;
  for (std::size_t s = 0; s < samples; ++s) {
    const Ray ray = pixel_ray(instrument_, seed_, pixel.address, static_cast<int>(s));
    const Hit device = pixel.hits[s], embree = scene_.embree.intersect(ray);
    Cause cause = scene_.tracer.explain(ray, device, embree);
    report.hit_miss += device.miss() != embree.miss();
    if (scene_.tracer.hits_anything(ray, device) == device.miss()) {
      ++report.hit_miss_double;
      if (scene_.tracer.explain(ray, device, scene_.tracer.trace(ray).hit) == Cause::unexplained)
        cause = Cause::unexplained;
    }
    ++report.hits[static_cast<std::size_t>(cause)];
    if (cause == Cause::agree) continue;
    const Hit exact = scene_.tracer.trace(ray).hit;
    if (cause != Cause::unexplained) {
      report.device_right += device == exact;
      report.embree_right += embree == exact;
    } else if (report.unexplained.size() < HitReport::kMostNamed) {
      report.unexplained.push_back(
          {pixel.address.line, pixel.address.sample, static_cast<std::uint32_t>(s), device, embree, exact});
    }
  }
  return report;
}

void HitComparison::add(const std::vector<PixelHits>& pixels) {
  std::vector<HitReport> reports(pixels.size());
  base::for_each_index(pixels.size(), threads_, [&](std::size_t i) { reports[i] = compare(pixels[i]); });
  for (const HitReport& report : reports) report_.add(report);
}

}  // namespace raycube::reference
