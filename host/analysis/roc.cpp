#include "host/analysis/roc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"
#include "scene_compiler/counter_random.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr double kInterval = 0.95;
constexpr std::uint64_t kBootstrapStream = 0x726f63;

/// What is counted as found or not: a pixel, or a target by its best.
struct Positive {
  double score;
  std::uint32_t target;
};

/// Pixels, or targets, to be found; scores turned so that higher is more like a target.
std::vector<Positive> positives_of(const std::vector<double>& score, const std::vector<double>& share,
                                   const std::vector<std::uint32_t>& target, const RocOptions& options) {
  const std::uint32_t count = *std::max_element(target.begin(), target.end());
  std::vector<double> whole(count + 1, 0.0);
  for (std::size_t p = 0; p < share.size(); ++p)
    if (target[p] > 0) whole[target[p]] += share[p];
  std::vector<Positive> out;
  for (std::size_t p = 0; p < share.size(); ++p) {
    if (target[p] == 0) continue;
    const double part = options.share_of == ShareOf::pixel ? share[p] : share[p] / whole[target[p]];
    if (part >= options.least_share) out.push_back({std::isnan(score[p]) ? -HUGE_VAL : score[p], target[p]});
  }
  if (!options.per_target) return out;
  std::sort(out.begin(), out.end(),
            [](auto& a, auto& b) { return a.target != b.target ? a.target < b.target : a.score > b.score; });
  out.erase(std::unique(out.begin(), out.end(), [](auto& a, auto& b) { return a.target == b.target; }), out.end());
  return out;
}

/// Where false alarms may be.
std::vector<std::uint8_t> negatives_of(const std::vector<std::uint32_t>& target, std::int64_t samples,
                                       std::int64_t lines, const RocOptions& options) {
  std::vector<std::uint8_t> out(target.size(), 1);
  const std::int64_t buffer = options.buffer_px;
  std::int64_t left = samples, right = -1, top = lines, bottom = -1;
  const auto clear = [&](std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) {
    for (std::int64_t y = std::max<std::int64_t>(0, y0); y <= std::min(lines - 1, y1); ++y)
      for (std::int64_t x = std::max<std::int64_t>(0, x0); x <= std::min(samples - 1, x1); ++x)
        out[static_cast<std::size_t>(y * samples + x)] = 0;
  };
  for (std::int64_t y = 0; y < lines; ++y)
    for (std::int64_t x = 0; x < samples; ++x) {
      if (target[static_cast<std::size_t>(y * samples + x)] == 0) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
      if (options.false_alarms == FalseAlarms::exact) clear(x - buffer, x + buffer, y - buffer, y + buffer);
    }
  if (options.false_alarms == FalseAlarms::outside_area)
    clear(left - buffer, right + buffer, top - buffer, bottom + buffer);
  return out;
}

/// Share of positives above a threshold, with targets drawn again; quantiles of many draws.
void bootstrap(const std::vector<Positive>& positives, double highest_negative, const RocOptions& options, Roc& out) {
  std::vector<std::uint32_t> targets;
  for (const Positive& p : positives) targets.push_back(p.target);
  std::sort(targets.begin(), targets.end());
  targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
  std::vector<double> found(targets.size(), 0.0), all(targets.size(), 0.0);
  for (const Positive& p : positives) {
    const auto t =
        static_cast<std::size_t>(std::lower_bound(targets.begin(), targets.end(), p.target) - targets.begin());
    ++all[t], found[t] += p.score > highest_negative;
  }
  std::vector<double> rates;
  for (int k = 0; k < options.bootstrap; ++k) {
    double hits = 0, total = 0;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const double u = scene::counter_uniform(options.seed, kBootstrapStream, static_cast<std::uint64_t>(k), i);
      const auto t = static_cast<std::size_t>(u * static_cast<double>(targets.size()));
      hits += found[t], total += all[t];
    }
    rates.push_back(hits / total);
  }
  std::sort(rates.begin(), rates.end());
  const auto quantile = [&](double q) {
    return rates.empty() ? std::numeric_limits<double>::quiet_NaN()
                         : rates[static_cast<std::size_t>(std::lround(q * static_cast<double>(rates.size() - 1)))];
  };
  out.interval_low = quantile((1 - kInterval) / 2), out.interval_high = quantile((1 + kInterval) / 2);
}

}  // namespace

std::vector<std::uint32_t> number_targets(const std::vector<double>& share, std::int64_t samples, std::int64_t lines) {
  std::vector<std::uint32_t> out(share.size(), 0);
  std::uint32_t count = 0;
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < share.size(); ++start) {
    if (!(share[start] > 0) || out[start] > 0) continue;
    out[start] = ++count;
    open.assign(1, start);
    while (!open.empty()) {
      const auto at = static_cast<std::int64_t>(open.back());
      open.pop_back();
      for (std::int64_t y = std::max<std::int64_t>(0, at / samples - 1); y <= std::min(lines - 1, at / samples + 1);
           ++y)
        for (std::int64_t x = std::max<std::int64_t>(0, at % samples - 1); x <= std::min(samples - 1, at % samples + 1);
             ++x) {
          const auto next = static_cast<std::size_t>(y * samples + x);
          if (share[next] > 0 && out[next] == 0) out[next] = count, open.push_back(next);
        }
    }
  }
  return out;
}

Roc roc(const std::vector<double>& score, const std::vector<double>& share, std::int64_t samples, std::int64_t lines,
        const RocOptions& options) {
  for (const double s : share)
    if (s > 1 + 1e-6)
      throw Error(Fault::input, fmt::format("a share of {:g} in the truth: shares are parts of a pixel, at most 1", s));
  std::vector<double> turned = score;
  if (options.lower_is_target)
    for (double& s : turned) s = -s;
  const std::vector<std::uint32_t> target = number_targets(share, samples, lines);
  if (target.empty() || *std::max_element(target.begin(), target.end()) == 0)
    throw Error(Fault::input, "the truth has no target: no pixel has a share above 0");
  std::vector<Positive> positives = positives_of(turned, share, target, options);
  const std::vector<std::uint8_t> may_be_false = negatives_of(target, samples, lines, options);
  std::vector<double> negatives;
  for (std::size_t p = 0; p < turned.size(); ++p)
    if (may_be_false[p] && !std::isnan(turned[p]) && !std::isnan(share[p])) negatives.push_back(turned[p]);
  if (positives.empty()) throw Error(Fault::input, "no target pixel has as large a share as is asked for");
  if (negatives.empty())
    throw Error(Fault::input, "no pixel is left for false alarms: all are targets, or within the buffer around them");
  std::sort(positives.begin(), positives.end(), [](auto& a, auto& b) { return a.score > b.score; });
  std::sort(negatives.begin(), negatives.end(), std::greater<>());
  Roc out;
  out.positives = positives.size(), out.negatives = negatives.size();
  for (const Positive& p : positives) out.not_scored += p.score == -HUGE_VAL;
  out.targets = *std::max_element(target.begin(), target.end());
  const double all = static_cast<double>(positives.size()), none = static_cast<double>(negatives.size());
  const double sign = options.lower_is_target ? -1 : 1;
  out.point.push_back({sign * std::numeric_limits<double>::infinity(), 0, 0});
  for (std::size_t i = 0, j = 0; i < positives.size() || j < negatives.size();) {
    const double threshold = std::max(i < positives.size() ? positives[i].score : -HUGE_VAL,
                                      j < negatives.size() ? negatives[j] : -HUGE_VAL);
    while (i < positives.size() && positives[i].score >= threshold) ++i;
    while (j < negatives.size() && negatives[j] >= threshold) ++j;
    const RocPoint next{sign * threshold, static_cast<double>(j) / none, static_cast<double>(i) / all};
    const RocPoint& last = out.point.back();
    out.area += 0.5 * (next.detection_rate + last.detection_rate) * (next.false_alarm_rate - last.false_alarm_rate);
    out.point.push_back(next);
  }
  out.before_first_false_alarm =
      static_cast<double>(std::count_if(positives.begin(), positives.end(),
                                        [&](const Positive& p) { return p.score > negatives.front(); })) /
      all;
  bootstrap(positives, negatives.front(), options, out);
  return out;
}

}  // namespace raycube::analysis
