#include "scene_compiler/texture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/base/units.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/raster.h"

namespace raycube::scene {
namespace {

using base::Problems;

/// i modulo n, 0 .. n - 1 for negative i too, of a place in texels.
std::size_t wrapped(double place, int n) {
  const double turns = std::floor(place / n);
  return static_cast<std::size_t>(std::clamp(std::floor(place - turns * n), 0.0, n - 1.0));
}

/// 0, 1, 2, ... put in order by what comes before what.
template <class Before>
std::vector<std::size_t> ordered(std::size_t count, Before before) {
  std::vector<std::size_t> out(count);
  std::iota(out.begin(), out.end(), std::size_t{0});
  std::sort(out.begin(), out.end(), before);
  return out;
}

/// Mean and standard deviation of all.
std::pair<double, double> moments(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double square = 0;
  for (const double value : values) square += (value - mean) * (value - mean);
  return {mean, std::sqrt(square / count)};
}

std::vector<std::uint16_t> by_rank(const std::vector<double>& texels, const std::vector<std::size_t>& darkest_first) {
  constexpr std::uint64_t kSeed = 0x7e97;
  const auto places = ordered(texels.size(), [&](std::size_t a, std::size_t b) {
    if (texels[a] != texels[b]) return texels[a] < texels[b];
    const double chance_a = counter_uniform(kSeed, 0, a, 0), chance_b = counter_uniform(kSeed, 0, b, 0);
    return chance_a != chance_b ? chance_a < chance_b : a < b;
  });
  std::vector<std::uint16_t> out(texels.size());
  for (std::size_t rank = 0; rank < places.size(); ++rank)
    out[places[rank]] =
        static_cast<std::uint16_t>(darkest_first[(2 * rank + 1) * darkest_first.size() / (2 * texels.size())]);
  return out;
}

std::vector<std::uint16_t> by_deviations(const std::vector<double>& texels, const std::vector<double>& brightness,
                                         const std::vector<std::size_t>& darkest_first) {
  const auto [texel_mean, texel_sd] = moments(texels);
  const auto [mean, sd] = moments(brightness);
  std::vector<std::uint16_t> out;
  for (const double texel : texels) {
    const double wanted = mean + (texel_sd > 0 ? (texel - texel_mean) / texel_sd : 0) * sd;
    auto next = std::lower_bound(darkest_first.begin(), darkest_first.end(), wanted,
                                 [&](std::size_t member, double value) { return brightness[member] < value; });
    if (next == darkest_first.end() ||
        (next != darkest_first.begin() && wanted - brightness[*(next - 1)] <= brightness[*next] - wanted))
      --next;
    out.push_back(static_cast<std::uint16_t>(*next));
  }
  return out;
}

}  // namespace

Texture::Texture(int columns, int rows, double texel_m, std::vector<std::uint16_t> member)
    : columns_(columns), rows_(rows), texel_m_(texel_m), member_(std::move(member)) {}

std::uint32_t Texture::member(double u_m, double v_m) const {
  const std::size_t column = wrapped(u_m / texel_m_, columns_), up = wrapped(v_m / texel_m_, rows_);
  return member_[(static_cast<std::size_t>(rows_) - 1 - up) * static_cast<std::size_t>(columns_) + column];
}

std::vector<std::uint16_t> choose_members(const std::vector<double>& texels, const std::vector<double>& brightness,
                                          TexelChoice choice) {
  const auto darkest_first = ordered(brightness.size(), [&](std::size_t a, std::size_t b) {
    return brightness[a] != brightness[b] ? brightness[a] < brightness[b] : a < b;
  });
  return choice == TexelChoice::rank ? by_rank(texels, darkest_first)
                                     : by_deviations(texels, brightness, darkest_first);
}

double mean_between(const Curve& curve, double from_um, double to_um) {
  const auto at = [&](double um) {
    const auto& w = curve.wavelength_um;
    const auto above = std::clamp<std::ptrdiff_t>(std::upper_bound(w.begin(), w.end(), um) - w.begin(), 1,
                                                  static_cast<std::ptrdiff_t>(w.size()) - 1);
    const auto i = static_cast<std::size_t>(above);
    const double f = (um - w[i - 1]) / (w[i] - w[i - 1]);
    return (1 - f) * curve.value[i - 1] + f * curve.value[i];
  };
  double sum = 0, last_um = from_um, last = at(from_um);
  const auto go_to = [&](double um, double value) {
    sum += 0.5 * (last + value) * (um - last_um);
    last_um = um, last = value;
  };
  for (std::size_t i = 0; i < curve.wavelength_um.size(); ++i)
    if (curve.wavelength_um[i] > from_um && curve.wavelength_um[i] < to_um)
      go_to(curve.wavelength_um[i], curve.value[i]);
  go_to(to_um, at(to_um));
  return sum / (to_um - from_um);
}

std::optional<Texture> read_texture(const Record& texture, const std::vector<Material>& members, Problems& problems) {
  const std::vector<double>& band_nm = texture.numbers("band_nm");
  const double from_um = base::um_from_nm(band_nm[0]), to_um = base::um_from_nm(band_nm[1]);
  if (!(from_um < to_um)) {
    problems.add(texture.place("band_nm"), "a band goes from a shorter to a longer wavelength",
                 number_text(band_nm[0]) + ", " + number_text(band_nm[1]), "give them in that order");
    return std::nullopt;
  }
  std::vector<double> brightness;
  for (const Material& member : members) {
    const auto& um = member.reflectance.wavelength_um;
    if (um.front() > from_um || um.back() < to_um) {
      problems.add(texture.place("band_nm"), "the texture's band reaches beyond " + member.source,
                   number_text(band_nm[0]) + " .. " + number_text(band_nm[1]) + " nm; it has " +
                       number_text(1e3 * um.front()) + " .. " + number_text(1e3 * um.back()),
                   "give a band in which all spectra of the family are known");
      return std::nullopt;
    }
    brightness.push_back(mean_between(member.reflectance, from_um, to_um));
  }
  const auto image = read_raster(texture.text("image"), static_cast<int>(texture.integer("band")), 1, NoData::mark,
                                 texture.place("image"), problems);
  if (!image) return std::nullopt;
  if (const auto hole = std::find(image->valid[0].begin(), image->valid[0].end(), false);
      hole != image->valid[0].end()) {
    const auto at = hole - image->valid[0].begin();
    problems.add({image->file, 0, 0, ""}, "texel without a value",
                 "column " + std::to_string(at % image->columns) + ", row " + std::to_string(at / image->columns),
                 "fill it (gdal_fillnodata.py)");
    return std::nullopt;
  }
  const auto choice = texture.text("choose") == "rank" ? TexelChoice::rank : TexelChoice::deviations;
  return Texture(image->columns, image->rows, texture.number("texel_m"),
                 choose_members(image->bands[0], brightness, choice));
}

}  // namespace raycube::scene
