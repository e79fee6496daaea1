#include "host/products/coverage.h"

#include <algorithm>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::products {

using base::Error;
using base::Fault;

Coverage::Coverage(std::string name, std::int64_t samples, std::int64_t lines)
    : name_(std::move(name)),
      samples_(samples),
      lines_(lines),
      missing_(samples * lines),
      spans_(static_cast<std::size_t>(std::max<std::int64_t>(0, lines))) {}

void Coverage::add(const Piece& piece) {
  const std::int64_t last_line = piece.first_line + piece.lines, last_sample = piece.first_sample + piece.samples;
  if (piece.first_line < 0 || piece.lines < 0 || last_line > lines_ || piece.first_sample < 0 || piece.samples < 1 ||
      last_sample > samples_)
    throw Error(Fault::bug,
                fmt::format("{}: lines {} to {}, samples {} to {} came for an image of {} x {}", name_,
                            piece.first_line, last_line, piece.first_sample, last_sample, samples_, lines_));
  const Span span{piece.first_sample, last_sample};
  const auto next_of = [&](std::vector<Span>& line) { return std::lower_bound(line.begin(), line.end(), span); };
  for (std::int64_t l = piece.first_line; l < last_line; ++l) {
    auto& line = spans_[static_cast<std::size_t>(l)];
    const auto next = next_of(line);
    if ((next != line.end() && next->first < span.second) ||
        (next != line.begin() && std::prev(next)->second > span.first))
      throw Error(Fault::bug,
                  fmt::format("{}: samples {} to {} of line {} came twice", name_, span.first, span.second, l));
  }
  for (std::int64_t l = piece.first_line; l < last_line; ++l) {
    auto& line = spans_[static_cast<std::size_t>(l)];
    auto at = line.insert(next_of(line), span);
    if (std::next(at) != line.end() && std::next(at)->first == at->second) {
      at->second = std::next(at)->second;
      line.erase(std::next(at));
    }
    if (at != line.begin() && std::prev(at)->second == at->first) {
      std::prev(at)->second = at->second;
      line.erase(at);
    }
  }
  missing_ -= piece.lines * piece.samples;
}

bool Coverage::has(std::int64_t first_line, std::int64_t lines) const {
  if (first_line < 0 || lines < 0 || first_line + lines > lines_) return false;
  return std::all_of(spans_.begin() + first_line, spans_.begin() + first_line + lines, [&](const auto& line) {
    return line == std::vector<Span>{{0, samples_}};
  });
}

void Coverage::require_whole() const {
  if (whole()) return;
  std::int64_t line = 0;
  while (has(line, 1)) ++line;
  const auto& spans = spans_[static_cast<std::size_t>(line)];
  const std::int64_t sample = spans.empty() || spans[0].first > 0 ? 0 : spans[0].second;
  throw Error(Fault::bug, fmt::format("{}: {} of {} pixels are missing, the first in line {}, sample {}", name_,
                                      missing_, samples_ * lines_, line, sample));
}

}  // namespace raycube::products
