#include "host/run/measured_cube.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/products/csv_writer.h"
#include "host/products/envi_writer.h"
#include "host/sensors/detector.h"

namespace raycube::run {
namespace {

constexpr std::size_t kNumbersAtOnce = std::size_t{1} << 20;
constexpr double kNedtKelvin = 300, kWarm_um = 2.5;  ///< noise is told as a temperature from this wavelength on

/// Lines that are worked on at once.
std::int64_t lines_at_once(const scene::Instrument& instrument) {
  const auto line = static_cast<std::size_t>(instrument.pixels) * instrument.bands.size();
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(kNumbersAtOnce / line));
}

/// Means of the bands over the pixels of the image that are finite, line by line, so that the order of work says
/// nothing.
std::vector<double> band_means(const scene::Instrument& instrument, const ReadsRadiance& read) {
  const std::size_t bands = instrument.bands.size();
  std::vector<double> sum(bands, 0.0), count(bands, 0.0);
  std::vector<float> line(static_cast<std::size_t>(instrument.pixels) * bands);
  for (std::int64_t l = 0; l < instrument.lines; ++l) {
    read(l, 1, line.data());
    for (std::size_t i = 0; i < line.size(); ++i)
      if (std::isfinite(line[i])) sum[i % bands] += static_cast<double>(line[i]), ++count[i % bands];
  }
  for (std::size_t b = 0; b < bands; ++b) sum[b] = count[b] > 0 ? sum[b] / count[b] : 0;
  return sum;
}

void write_bands(const scene::Instrument& instrument, const sensors::Detector& detector,
                 const std::vector<double>& mean, base::OutputFile& file) {
  products::CsvWriter table(
      file, {"band", "wavelength_nm", "electrons_per_radiance", "dark_e", "read_e", "mean_radiance", "sigma_at_mean",
             "snr_at_mean", "nedl_dark", "nedt_300K_K", "gain", "offset"});
  for (int b = 0; b < static_cast<int>(instrument.bands.size()); ++b) {
    const auto i = static_cast<std::size_t>(b);
    const sensors::BandNoise& band = detector.bands()[i];
    const double um = instrument.bands[i].center_um;
    const sensors::Expected at_mean = detector.expected(b, mean[i]);
    table.add(b + 1).add(1e3 * um).add(band.electrons_per_radiance).add(band.dark_e).add(band.read_e);
    table.add(mean[i]).add(at_mean.sigma).add(mean[i] / at_mean.sigma).add(detector.expected(b, 0).sigma);
    table.add(um >= kWarm_um ? detector.nedt_K(b, kNedtKelvin) : std::nan("")).add(band.gain).add(band.offset);
    table.end_row();
  }
  table.finish();
}

bool write_bad_elements(const sensors::Detector& detector, base::OutputSet& set) {
  const std::vector<sensors::BadElement> bad = detector.bad_elements();
  if (bad.empty()) return false;
  products::CsvWriter table(set.add("bad_elements.csv"), {"band", "line", "sample", "says"});
  for (const sensors::BadElement& one : bad) {
    table.add(one.band + 1);
    for (const std::int64_t place : {one.line, one.sample})
      place < 0 ? table.add(std::string_view("all")) : table.add(place);
    table.add(std::string_view(one.full ? "full" : "0")).end_row();
  }
  table.finish();
  return true;
}

}  // namespace

std::string MeasuredCube::warning() const {
  return fmt::format("the detector is saturated in {} of {} values ({:.3g} %)", saturated, values,
                     100.0 * static_cast<double>(saturated) / static_cast<double>(values));
}

MeasuredCube measure_cube(const scene::Instrument& instrument, std::uint64_t seed, const ReadsRadiance& read,
                          const products::EnviHeader& header, base::OutputSet& set, const Services& services) {
  const std::vector<double> mean = band_means(instrument, read);
  const sensors::Detector detector(instrument, seed, mean);
  MeasuredCube out;
  out.values = static_cast<std::uint64_t>(instrument.pixels) * static_cast<std::uint64_t>(instrument.lines) *
               instrument.bands.size();
  out.files = {{"measured.img", detector.digital() ? "digital numbers of the detector, ENVI"
                                                   : "radiance as the detector measures it, ENVI"},
               {"detector.csv", "electrons, noise and calibration of each band"}};
  products::EnviHeader measured = header;
  measured.description = detector.digital() ? "digital numbers of the detector; gains and offsets make radiance of them"
                                            : "radiance as the detector measures it";
  products::EnviWriter writer(set, "measured.img", measured,
                              detector.digital() ? std::optional<double>(1.0) : std::nullopt);
  if (detector.digital())
    for (std::size_t b = 0; b < detector.bands().size(); ++b) {
      writer.header().data_gain[b] = detector.bands()[b].gain;
      writer.header().data_offset[b] = detector.bands()[b].offset;
    }
  const std::int64_t step = lines_at_once(instrument);
  const auto count = static_cast<std::size_t>((instrument.lines + step - 1) / step);
  const Step shown(services, "detector", static_cast<std::uint64_t>(instrument.lines), "lines");
  std::mutex alone;
  base::for_each_index(count, services.threads, [&](std::size_t part) {
    const std::int64_t first = static_cast<std::int64_t>(part) * step, lines = std::min(step, instrument.lines - first);
    const auto line = static_cast<std::size_t>(instrument.pixels) * instrument.bands.size();
    std::vector<float> light(static_cast<std::size_t>(lines) * line), stored(light.size());
    read(first, lines, light.data());
    if (detector.digital() && !std::all_of(light.begin(), light.end(), [](float v) { return std::isfinite(v); }))
      throw base::Error(base::Fault::input,
                        fmt::format("lines {} to {}: some radiance is no number, or the header's ignore value, which "
                                    "digital numbers cannot hold; take out detector.bits, or such pixels",
                                    first, first + lines - 1));
    std::uint64_t cut = 0;
    for (std::int64_t l = 0; l < lines; ++l) {
      const std::size_t at = static_cast<std::size_t>(l) * line;
      cut += detector.measure(first + l, 0, instrument.pixels, light.data() + at, stored.data() + at);
    }
    const std::lock_guard lock(alone);
    products::Strip strip;
    strip.first_line = first, strip.lines = lines, strip.values = stored.data();
    writer.write(strip), out.saturated += cut;
    shown.advance(static_cast<std::uint64_t>(lines));
  });
  writer.finish();
  write_bands(instrument, detector, mean, set.add("detector.csv"));
  if (write_bad_elements(detector, set)) out.files.emplace_back("bad_elements.csv", "elements that say nothing");
  return out;
}

}  // namespace raycube::run
