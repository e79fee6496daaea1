#include "host/render/tuner.h"

#include <algorithm>
#include <functional>

namespace raycube::render {

namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::map<std::string, SizeChoice> choose_sizes(const std::vector<std::size_t>& sizes, std::size_t preset, int rounds,
                                               const TimedRun& run) {
  for (const std::size_t size : sizes) run(size);
  std::map<std::string, std::map<std::size_t, std::vector<double>>> times;
  for (int round = 0; round < rounds; ++round)
    for (const std::size_t size : sizes)
      for (const auto& [what, seconds] : run(size)) times[what][size].push_back(seconds);
  std::map<std::string, SizeChoice> choices;
  for (const auto& [what, of_size] : times) {
    if (!of_size.contains(preset)) continue;
    SizeChoice choice;
    for (const auto& [size, seconds] : of_size) choice.candidates[size] = median(seconds);
    const auto best = std::min_element(choice.candidates.begin(), choice.candidates.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    choice.preset_seconds = choice.candidates.at(preset);
    const auto& of_best = of_size.at(best->first);
    const auto& of_preset = of_size.at(preset);
    const bool every_round =
        std::equal(of_best.begin(), of_best.end(), of_preset.begin(), of_preset.end(), std::less<>());
    choice.size =
        choice.preset_seconds >= kLeast_s && every_round && best->second < (1 - kWorthwhile) * choice.preset_seconds
            ? best->first
            : preset;
    choice.seconds = choice.candidates.at(choice.size);
    choices.emplace(what, std::move(choice));
  }
  return choices;
}

}  // namespace raycube::render
