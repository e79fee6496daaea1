#include "scene_compiler/texture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <span>

#include "host/base/text.h"
#include "host/base/units.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/raster.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr std::size_t kColoursKnown = 100000;
/// Of an image: more than any face shows, which is cut into 1e7 squares at most, or a mesh, into 4e7.
constexpr double kMostTexels = 1 << 26;
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
template <class Values>
std::pair<double, double> moments(const Values& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += values[i];
  const double mean = sum / count;
  for (std::size_t i = 0; i < values.size(); ++i) square += (values[i] - mean) * (values[i] - mean);
  return {mean, std::sqrt(square / count)};
}

/// Members that share texels evenly by rank, darkest first.
class Ranks {
 public:
  Ranks(std::size_t texels, std::size_t members) : texels_(texels), members_(members) {}
  /// Which member the texel of a rank has, and the first rank that has one.
  std::size_t member(std::size_t rank) const { return (2 * rank + 1) * members_ / (2 * texels_); }
  std::size_t first(std::size_t member) const { return (2 * texels_ * member + members_ - 1) / members_ / 2; }

 private:
  std::size_t texels_, members_;
};

/// Puts equal texels, whose ranks start at `rank`, in an order by chance as far as that decides on their members.
void order_by_chance(std::span<std::uint32_t> texels, std::size_t rank, const Ranks& ranks) {
  constexpr std::uint64_t kSeed = 0x7e97;
  if (texels.empty()) return;
  const std::size_t darkest = ranks.member(rank), brightest = ranks.member(rank + texels.size() - 1);
  if (darkest == brightest) return;
  const std::size_t cut = ranks.first((darkest + brightest + 1) / 2) - rank;
  std::nth_element(texels.begin(), texels.begin() + static_cast<std::ptrdiff_t>(cut), texels.end(),
                   [](std::uint32_t a, std::uint32_t b) {
                     const double chance_a = counter_uniform(kSeed, 0, a, 0),
                                  chance_b = counter_uniform(kSeed, 0, b, 0);
                     return chance_a != chance_b ? chance_a < chance_b : a < b;
                   });
  order_by_chance(texels.first(cut), rank, ranks);
  order_by_chance(texels.subspan(cut), rank + cut, ranks);
}

std::vector<std::uint16_t> by_rank(const BandValues& texels, const std::vector<std::size_t>& darkest_first) {
  std::vector<std::uint32_t> places = texels.ascending();
  const Ranks ranks(places.size(), darkest_first.size());
  for (std::size_t first = 0, end = 0; first < places.size(); first = end) {
    while (end < places.size() && texels[places[end]] == texels[places[first]]) ++end;
    order_by_chance(std::span(places).subspan(first, end - first), first, ranks);
  }
  std::vector<std::uint16_t> out(places.size());
  for (std::size_t rank = 0; rank < places.size(); ++rank)
    out[places[rank]] = static_cast<std::uint16_t>(darkest_first[ranks.member(rank)]);
  return out;
}

std::vector<std::uint16_t> by_deviations(const BandValues& texels, const std::vector<double>& brightness,
                                         const std::vector<std::size_t>& darkest_first) {
  const auto [texel_mean, texel_sd] = moments(texels);
  const auto [mean, sd] = moments(brightness);
  std::vector<std::uint16_t> out;
  out.reserve(texels.size());
  for (std::size_t t = 0; t < texels.size(); ++t) {
    const double texel = texels[t];
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

/// One of sRGB's three values, 0 to 1, of a reflectance (IEC 61966-2-1).
double srgb(double linear) {
  const double value = std::clamp(linear, 0.0, 1.0);
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

/// Mean of every member in each of the texture's bands, [band][member]; none after reporting.
std::vector<std::vector<double>> band_means(const Record& texture, const std::vector<Material>& members,
                                            Problems& problems) {
  const std::vector<double>& band_nm = texture.numbers("band_nm");
  std::vector<std::vector<double>> out;
  for (std::size_t b = 0; b + 1 < band_nm.size(); b += 2) {
    const double from_um = base::um_from_nm(band_nm[b]), to_um = base::um_from_nm(band_nm[b + 1]);
    if (!(from_um < to_um)) {
      problems.add(texture.place("band_nm"), "a band goes from a shorter to a longer wavelength",
                   number_text(band_nm[b]) + ", " + number_text(band_nm[b + 1]), "give them in that order");
      return {};
    }
    out.emplace_back();
    for (const Material& member : members) {
      const auto& um = member.reflectance.wavelength_um;
      if (um.front() > from_um || um.back() < to_um) {
        problems.add(texture.place("band_nm"), "the texture's band reaches beyond " + member.source,
                     number_text(band_nm[b]) + " .. " + number_text(band_nm[b + 1]) + " nm; it has " +
                         number_text(1e3 * um.front()) + " .. " + number_text(1e3 * um.back()),
                     "give a band in which all spectra of the family are known");
        return {};
      }
      out.back().push_back(mean_between(member.reflectance, from_um, to_um));
    }
  }
  return out;
}

/// The members whose means are nearest to what an image of reflectances shows.
std::vector<std::uint16_t> nearest_to(const Raster& image, double white, std::vector<std::vector<double>> means,
                                      const Record& texture) {
  if (texture.text("encoding") == "srgb")  // the image has been encoded already
    for (auto& band : means) std::transform(band.begin(), band.end(), band.begin(), srgb);
  return nearest_members(image.bands, white, means);
}

/// The image's value of reflectance 1: as given, else the largest number of its bits. nullopt after reporting where its
/// values cannot be of that: an image of 0 to 1 is not one of 0 to 255 in the dark.
std::optional<double> known_white(const Record& texture, const Raster& image, Problems& problems) {
  if (texture.given("white")) return texture.number("white");
  double most = 0;
  for (const BandValues& band : image.bands) most = std::max(most, band.least_and_most().second);
  const double white = white_of(image);
  if (white > 0 && most > 0.02 * white) return white;
  problems.add(texture.place("image"), "the image's value of reflectance 1 is not known",
               "values up to " + number_text(most) +
                   (white > 0 ? "; the largest number of its bits stands for " + number_text(white)
                              : "; they are no integers of 8 or 16 bits, of which the largest would be white"),
               "give white, 1 for an image of reflectances");
  return std::nullopt;
}

/// Whether no key is there that the way of choosing has no use for.
bool asks_for_one_choice(const Record& texture, Problems& problems) {
  const bool nearest = texture.text("choose") == "nearest";
  for (const char* key : {"white", "encoding"})
    if (!nearest && texture.given(key)) {
      problems.add(texture.place(key), std::string("'") + key + "' goes with choose = \"nearest\"",
                   texture.text("choose"), "remove it, or choose the nearest");
      return false;
    }
  if (!nearest && texture.numbers("band_nm").size() != 2) {
    problems.add(texture.place("band_nm"), "one band tells how bright a texel is",
                 base::counted(texture.numbers("band_nm").size() / 2, "band"),
                 "give the first and the last wavelength of one, or choose = \"nearest\"");
    return false;
  }
  return true;
}

}  // namespace

std::optional<Raster> read_image(const Record& record, int bands, double made_bytes, Problems& problems) {
  auto image = read_raster(record.text("image"),
                           {.first_band = static_cast<int>(record.integer("band")),
                            .count = bands,
                            .transparent = Transparent::has_a_value,
                            .most_pixels = std::min(bands * kMostTexels, kMostPixels),
                            .made_bytes = made_bytes},
                           record.place("image"), problems);
  if (!image) return std::nullopt;
  if (image->declared[0].palette) {
    problems.add({image->file, 0, 0, ""}, "the picture's values are numbers of a palette's colours", "a palette",
                 "write its colours: gdal_translate -expand rgba " + image->file + " NEW.png");
    return std::nullopt;
  }
  for (const std::vector<bool>& valid : image->valid) {
    const auto hole = std::find(valid.begin(), valid.end(), false);
    if (hole == valid.end()) continue;
    const auto at = hole - valid.begin();
    problems.add({image->file, 0, 0, ""}, "texel without a value",
                 "column " + std::to_string(at % image->columns) + ", row " + std::to_string(at / image->columns),
                 "fill it (gdal_fillnodata.py)");
    return std::nullopt;
  }
  if (image->georeferenced && image->transform[5] > 0) {  // rows from south to north
    problems.tell({image->file, 0, 0, ""}, "its first row is the southern one, as its map coordinates say");
    const auto columns = static_cast<std::size_t>(image->columns), rows = static_cast<std::size_t>(image->rows);
    for (BandValues& values : image->bands)
      values.reorder([&](std::size_t i) { return (rows - 1 - i / columns) * columns + i % columns; });
  }
  return image;
}

Texture::Texture(int columns, int rows, double texel_m, std::vector<std::uint16_t> numbers)
    : columns_(columns), rows_(rows), texel_m_(texel_m), numbers_(std::move(numbers)) {}

std::uint32_t Texture::at(double u, double v) const {
  const double column_of = by_coordinates() ? u * columns_ : u / texel_m_,
               up_of = by_coordinates() ? v * rows_ : v / texel_m_;
  const std::size_t column = wrapped(column_of, columns_), up = wrapped(up_of, rows_);
  return numbers_[(static_cast<std::size_t>(rows_) - 1 - up) * static_cast<std::size_t>(columns_) + column];
}

std::vector<std::uint16_t> choose_members(const BandValues& texels, const std::vector<double>& brightness,
                                          TexelChoice choice) {
  const auto darkest_first = ordered(brightness.size(), [&](std::size_t a, std::size_t b) {
    return brightness[a] != brightness[b] ? brightness[a] < brightness[b] : a < b;
  });
  return choice == TexelChoice::rank ? by_rank(texels, darkest_first)
                                     : by_deviations(texels, brightness, darkest_first);
}

std::vector<std::uint16_t> nearest_members(const std::vector<BandValues>& bands, double white,
                                           const std::vector<std::vector<double>>& means) {
  const std::size_t members = means[0].size();
  std::vector<std::uint16_t> out;
  out.reserve(bands[0].size());
  std::map<std::vector<double>, std::uint16_t> known;  // a picture has fewer colours than texels
  std::vector<double> texel(bands.size());
  const auto nearest = [&] {
    double least = std::numeric_limits<double>::infinity();
    std::uint16_t found = 0;
    for (std::size_t m = 0; m < members; ++m) {
      double square = 0;
      for (std::size_t b = 0; b < texel.size(); ++b) square += (means[b][m] - texel[b]) * (means[b][m] - texel[b]);
      if (square < least) least = square, found = static_cast<std::uint16_t>(m);
    }
    return found;
  };
  for (std::size_t t = 0; t < bands[0].size(); ++t) {
    for (std::size_t b = 0; b < texel.size(); ++b) texel[b] = bands[b][t] / white;
    const auto entry = known.find(texel);
    out.push_back(entry != known.end() ? entry->second : nearest());
    if (entry == known.end() && known.size() < kColoursKnown) known.emplace(texel, out.back());
  }
  return out;
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
  if (!asks_for_one_choice(texture, problems)) return std::nullopt;
  const auto means = band_means(texture, members, problems);
  if (means.empty()) return std::nullopt;
  const std::string& choice = texture.text("choose");
  const double made_bytes = sizeof(std::uint16_t) + (choice == "rank" ? sizeof(std::uint32_t) : 0);
  const auto image = read_image(texture, static_cast<int>(means.size()), made_bytes, problems);
  if (!image) return std::nullopt;
  const double texel_m = texture.given("texel_m") ? texture.number("texel_m") : 0;
  if (choice == "nearest") {
    const auto white = known_white(texture, *image, problems);
    if (!white) return std::nullopt;
    return Texture(image->columns, image->rows, texel_m, nearest_to(*image, *white, means, texture));
  }
  return Texture(
      image->columns, image->rows, texel_m,
      choose_members(image->bands[0], means[0], choice == "rank" ? TexelChoice::rank : TexelChoice::deviations));
}

std::optional<Texture> read_mask(const Record& mask, Problems& problems) {
  const auto image = read_image(mask, 1, sizeof(std::uint16_t), problems);
  if (!image) return std::nullopt;
  const BandValues& values = image->bands[0];
  const double most = values.least_and_most().second;
  const double least = mask.given("least") ? mask.number("least")
                       : most > 0          ? 0.5 * most
                                           : std::numeric_limits<double>::infinity();
  std::vector<std::uint16_t> something(values.size());
  for (std::size_t t = 0; t < something.size(); ++t) something[t] = values[t] >= least ? 1 : 0;
  if (std::find(something.begin(), something.end(), 1) == something.end()) {
    problems.add(mask.place("image"), "the mask leaves nothing",
                 "values up to " + number_text(most) + " in band " + std::to_string(mask.integer("band")),
                 "give another band, or a lower 'least'");
    return std::nullopt;
  }
  return Texture(image->columns, image->rows, 0, std::move(something));
}

}  // namespace raycube::scene
