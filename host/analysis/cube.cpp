#include "host/analysis/cube.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/products/radiance_unit.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr std::size_t kNumbersAtOnce = std::size_t{1} << 20;  ///< 8 MiB of doubles for each thread

/// Parts "a:b" or "a" of a list with commas.
std::vector<std::pair<double, double>> ranges_of(const std::string& text, const char* what) {
  std::vector<std::pair<double, double>> out;
  const auto number = [&](const std::string& word) {
    double value = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || code != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      throw Error(Fault::input,
                  fmt::format("{} \"{}\": \"{}\" is no number; give ranges as in 1:50,60", what, text, word));
    return value;
  };
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) {
    const auto colon = item.find(':');
    const double low = number(item.substr(0, colon)),
                 high = colon == std::string::npos ? low : number(item.substr(colon + 1));
    if (low > high) throw Error(Fault::input, fmt::format("{} \"{}\": {} ends before it begins", what, text, item));
    out.emplace_back(low, high);
  }
  return out;
}

constexpr double kLeast_nm = 50;  ///< no cube has shorter wavelengths

/// Numbers, from 0, of the bands that a choice names.
std::vector<std::size_t> bands_of(const BandChoice& choice, const products::EnviHeader& header,
                                  const std::string& path) {
  const auto count = static_cast<std::size_t>(header.bands);
  std::set<std::size_t> out;
  if (!choice.numbers.empty()) {
    for (const auto& [low, high] : ranges_of(choice.numbers, "--bands")) {
      if (low < 1 || high > static_cast<double>(count) || low != std::floor(low) || high != std::floor(high))
        throw Error(Fault::input, fmt::format("--bands {}: {} has bands 1 to {} (found {}:{})", choice.numbers, path,
                                              count, low, high));
      for (auto b = static_cast<std::size_t>(low); b <= static_cast<std::size_t>(high); ++b) out.insert(b - 1);
    }
  }
  const auto good = [&](std::size_t band) { return header.bad_bands.empty() || header.bad_bands[band] != 0; };
  if (!choice.wavelengths_nm.empty()) {
    const std::vector<double> um = header.wavelength_um();
    if (um.empty())
      throw Error(Fault::input,
                  path + ": its header " + header.why_no_wavelengths() + "; choose bands by --bands instead");
    const double last_um = *std::max_element(um.begin(), um.end());
    for (const auto& [low, high] : ranges_of(choice.wavelengths_nm, "--wavelengths")) {
      for (std::size_t b = 0; b < count; ++b)
        if (good(b) && um[b] * 1e3 >= low && um[b] * 1e3 <= high) out.insert(b);
      // Below 50 nm no band lies, and the whole range may be of micrometres.
      if (high < kLeast_nm && low <= last_um)
        throw Error(Fault::input, fmt::format("--wavelengths {}: is in nm, and {:g}:{:g} looks like micrometres; give "
                                              "{:g}:{:g}",
                                              choice.wavelengths_nm, low, high, 1e3 * low, 1e3 * high));
    }
  }
  if (choice.numbers.empty() && choice.wavelengths_nm.empty())
    for (std::size_t b = 0; b < count; ++b)
      if (good(b)) out.insert(b);
  if (out.empty() && !choice.wavelengths_nm.empty()) {
    const std::vector<double> um = header.wavelength_um();
    throw Error(Fault::input,
                fmt::format("--wavelengths {}: in nm, and {} has no good band there (its bands lie at {:.6g} "
                            "to {:.6g} nm)",
                            choice.wavelengths_nm, path, 1e3 * *std::min_element(um.begin(), um.end()),
                            1e3 * *std::max_element(um.begin(), um.end())));
  }
  if (out.empty()) throw Error(Fault::input, path + ": no band is left of what is asked for");
  return {out.begin(), out.end()};
}

}  // namespace

Cube::Cube(const std::string& path, const BandChoice& choice) : path_(path), reader_(path) {
  const products::EnviHeader& h = header();
  if (h.spectral_library)
    throw Error(Fault::input, path + ": is a spectral library, not a cube; libraries go to --target and --endmember");
  if (h.type().components != 1) throw Error(Fault::input, path + ": holds complex numbers, which no analysis takes");
  band_ = bands_of(choice, h, path);
  const double scale = h.reflectance_scale_factor.value_or(1);
  if (!(scale > 0)) throw Error(Fault::input, fmt::format("{}: a reflectance scale factor of {} is none", path, scale));
  for (const std::size_t b : band_) {
    gain_.push_back((h.data_gain.empty() ? 1 : h.data_gain[b]) / scale);
    offset_.push_back((h.data_offset.empty() ? 0 : h.data_offset[b]) / scale);
  }
}

std::vector<double> Cube::of_chosen(const std::vector<double>& all) const {
  std::vector<double> out;
  if (all.empty()) return out;
  for (const std::size_t b : band_) out.push_back(all[b]);
  return out;
}

std::string Cube::band_text(std::size_t band) const {
  const std::size_t number = band_.at(band);
  const auto um = header().wavelength_um();
  if (!um.empty()) return fmt::format("{} ({:.6g} nm)", number + 1, 1e3 * um[number]);
  return number < header().band_names.size() ? header().band_names[number] : std::to_string(number + 1);
}

std::int64_t Cube::lines_at_once() const {
  // Of a file that keeps a pixel's or a line's bands together all are read.
  const bool all = header().interleave != products::Interleave::bsq;
  const auto line = static_cast<std::size_t>(samples()) * (all ? static_cast<std::size_t>(header().bands) : bands());
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(kNumbersAtOnce / std::max<std::size_t>(line, 1)));
}

void Cube::read(std::int64_t first_line, std::int64_t lines, Pixels& out) const {
  out.first_line = first_line, out.lines = lines, out.samples = samples(), out.bands = bands();
  reader_.read_bands(first_line, lines, band_, out.value);
  out.counts.assign(out.count(), 1);
  const products::EnviHeader& h = header();
  const bool scaled = !h.data_gain.empty() || !h.data_offset.empty() || h.reflectance_scale_factor;
  for (std::size_t p = 0; p < out.count(); ++p) {
    double* const value = out.value.data() + p * out.bands;
    if (h.data_ignore_value && std::any_of(value, value + out.bands, [&](double v) { return h.ignores(v); }))
      out.counts[p] = 0;
    if (scaled)
      for (std::size_t b = 0; b < out.bands; ++b) value[b] = value[b] * gain_[b] + offset_[b];
    double nothing = 0;  // stays 0 unless a number is not finite
    for (std::size_t b = 0; b < out.bands; ++b) nothing += 0 * value[b];
    if (!(nothing == 0)) out.counts[p] = 0;
  }
}

bool Cube::plain_floats() const {
  const products::EnviHeader& h = header();
  return h.data_gain.empty() && h.data_offset.empty() && !h.reflectance_scale_factor &&
         bands() == static_cast<std::size_t>(h.bands) && reader_.holds_plain_floats();
}

std::vector<PartRange> parts_of(const Cube& cube, int most) {
  const std::int64_t parts = std::min<std::int64_t>(most, cube.lines());
  std::vector<PartRange> out;
  for (std::int64_t p = 0; p < parts; ++p) out.push_back({p * cube.lines() / parts, (p + 1) * cube.lines() / parts});
  return out;
}

void for_each_part(const Cube& cube, const Pass& pass,
                   const std::function<void(std::size_t part, const Pixels& pixels)>& work) {
  const std::vector<PartRange> parts = parts_of(cube, pass.most_parts);
  base::for_each_index(parts.size(), pass.threads, [&](std::size_t p) {
    thread_local Pixels pixels;
    for (std::int64_t line = parts[p].first_line; line < parts[p].end_line; line += pixels.lines) {
      base::throw_if_interrupted();
      cube.read(line, std::min(cube.lines_at_once(), parts[p].end_line - line), pixels);
      work(p, pixels);
      if (pass.after_lines) pass.after_lines(pixels.lines);
    }
  });
}

void require_same_bands(const Cube& a, const Cube& b) {
  constexpr double kMostApart = 0.01;  ///< of a wavelength
  if (a.bands() != b.bands())
    throw Error(Fault::input,
                fmt::format("{} has {} bands, {} {}; they must be the same", a.path(), a.bands(), b.path(), b.bands()));
  const std::vector<double> um = a.wavelength_um(), other = b.wavelength_um();
  for (std::size_t i = 0; i < a.bands(); ++i) {
    const bool apart = !um.empty() && !other.empty() ? std::abs(um[i] - other[i]) > kMostApart * um[i]
                                                     : a.chosen()[i] != b.chosen()[i];
    if (apart)
      throw Error(Fault::input,
                  fmt::format("band {} of {} is compared with band {} of {}; choose --bands that are alike",
                              a.band_text(i), a.path(), b.band_text(i), b.path()));
  }
  const auto unit = products::radiance_of(a.header().data_units),
             other_unit = products::radiance_of(b.header().data_units);
  if (a.header().data_units.empty() || b.header().data_units.empty()) return;
  if (unit.has_value() != other_unit.has_value() || (unit && std::abs(*unit - *other_unit) > 1e-9 * *unit))
    throw Error(Fault::input,
                fmt::format("{} is in {}, {} in {}; correct 'data units' in a header, or bring the numbers to one unit",
                            a.path(), a.header().data_units, b.path(), b.header().data_units));
}

void require_same_size(const Cube& a, std::int64_t samples, std::int64_t lines, const std::string& other) {
  if (a.samples() != samples || a.lines() != lines)
    throw Error(Fault::input, fmt::format("{} has {} samples x {} lines, {} {} x {}; they must be of one size",
                                          a.path(), a.samples(), a.lines(), other, samples, lines));
}

}  // namespace raycube::analysis
