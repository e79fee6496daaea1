#include "host/planner/sample_pattern.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace raycube::planner {

namespace {

SamplePattern lattices() {
  SamplePattern out{scene::SamplerKind::lattice, {}, 21};
  for (int fibonacci = 1, next = 2; fibonacci <= kMostSamples; fibonacci = std::exchange(next, fibonacci + next))
    out.levels.push_back(fibonacci);
  for (int lucas = 4, next = 7; lucas <= kMostSamples; lucas = std::exchange(next, lucas + next))
    out.levels.push_back(lucas);
  std::sort(out.levels.begin(), out.levels.end());
  return out;
}

/// About as many numbers as there are lattices.
SamplePattern cells() {
  SamplePattern out{scene::SamplerKind::jittered, {}, 25};
  for (int side = 1; side * side <= kMostSamples; side = std::max(side + 1, side * 8 / 7))
    out.levels.push_back(side * side);
  return out;
}

}  // namespace

int SamplePattern::along(int samples) const {
  return sampler == scene::SamplerKind::lattice ? samples : static_cast<int>(std::lround(std::sqrt(samples)));
}

std::string SamplePattern::name(int samples) const { return sampler_text(sampler, along(samples), across(samples)); }

const SamplePattern& sample_pattern(const scene::Instrument& instrument) {
  static const SamplePattern lattice = lattices(), jittered = cells();
  return instrument.box_pixels() ? lattice : jittered;
}

void give_samples(scene::Instrument& instrument, int samples) {
  const SamplePattern& pattern = sample_pattern(instrument);
  instrument.sampler = pattern.sampler;
  instrument.samples_u = pattern.along(samples), instrument.samples_v = pattern.across(samples);
}

std::string sampler_text(scene::SamplerKind sampler, int samples_u, int samples_v) {
  if (sampler == scene::SamplerKind::lattice) return fmt::format("lattice {}", samples_u * samples_v);
  return fmt::format("{} {} x {}", sampler == scene::SamplerKind::grid ? "grid" : "jittered", samples_u, samples_v);
}

}  // namespace raycube::planner
