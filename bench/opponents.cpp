#include "bench/opponents.h"

#include <algorithm>

#include "host/sensors/ray_groups.h"

namespace raycube::bench {
namespace {

constexpr std::size_t kMostMerged = 40'000'000;  // placed triangles: Embree needs about 200 bytes of each

}  // namespace

std::vector<std::pair<EmbreeForm, std::unique_ptr<EmbreeBaseline>>> embree_forms(const scene::CompiledScene& scene,
                                                                                 const std::string& label) {
  std::vector<std::pair<EmbreeForm, std::unique_ptr<EmbreeBaseline>>> forms;
  const std::size_t placed = placed_triangles(scene);
  for (const EmbreeForm form : kEmbreeForms) {
    if (form == EmbreeForm::merged && placed > kMostMerged) {
      std::printf("  %s: %.3g placed triangles: too many to merge for Embree\n", label.c_str(),
                  static_cast<double>(placed));
      continue;
    }
    forms.emplace_back(form, std::make_unique<EmbreeBaseline>(scene, form));
  }
  return forms;
}

std::vector<shared::RayGroup> some_lines(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                         double most) {
  const auto all = sensors::make_ray_groups(instrument, scene, 0, instrument.lines);
  const auto per_line = static_cast<std::size_t>(sensors::groups_per_line(instrument));
  const double line = static_cast<double>(per_line) * RC_GROUP_WIDTH * instrument.samples_u * instrument.samples_v;
  const double lines = std::clamp(most / line, 1.0, static_cast<double>(instrument.lines));
  const auto step = static_cast<std::size_t>(static_cast<double>(instrument.lines) / lines + 0.999);
  std::vector<shared::RayGroup> chosen;
  for (std::size_t first = step / 2 * per_line; first + per_line <= all.size(); first += step * per_line)
    chosen.insert(chosen.end(), all.begin() + static_cast<std::ptrdiff_t>(first),
                  all.begin() + static_cast<std::ptrdiff_t>(first + per_line));
  return chosen;
}

const Opponent& best_of(const std::vector<Opponent>& opponents) {
  return *std::min_element(opponents.begin(), opponents.end(), [](const Opponent& a, const Opponent& b) {
    return a.times.ratio().median < b.times.ratio().median;
  });
}

}  // namespace raycube::bench
