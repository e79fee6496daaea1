#include "atmos_tables/import/sample_book.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/told_geometry.h"
#include "atmos_tables/interpolate.h"

namespace raycube::atmos::imported {

namespace {

constexpr double kSameAngle_deg = 0.05;  ///< digits of the codes
constexpr double kPathEnds_deg = 1.0;    ///< suns at the ends of a scan's paths

}  // namespace

Spectrum SampleBook::sorted(const Run& run, const Spectrum& values) {
  std::vector<std::size_t> order(run.wavelength_um.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return run.wavelength_um[a] < run.wavelength_um[b]; });
  Spectrum out;
  for (const std::size_t i : order) out.push_back(values[i]);
  return out;
}

Spectrum SampleBook::on_grid(const Run& run, const Spectrum& values) const {
  const Spectrum from = sorted(run, run.wavelength_um), y = sorted(run, values);
  if (from.size() == 1) return Spectrum(out.wavelength_um.size(), y[0]);
  Spectrum to = out.wavelength_um;
  for (double& l : to) l = std::clamp(l, from.front(), from.back());
  return resample_linear(from, y, to);
}

Spectrum SampleBook::optional(const Run& run, const std::string& name) const {
  const Column* column = run.find(name);
  return column ? on_grid(run, *column) : Spectrum{};
}

void SampleBook::add(const std::string& row, const Sample& place, Spectrum values) {
  if (values.empty()) return;
  Sample sample = place;
  sample.row = row, sample.values = std::move(values);
  out.all.push_back(std::move(sample));
}

void SampleBook::agree(std::optional<double>& standing, std::optional<double> found, double tolerance, const char* what,
                       const Source& source) {
  if (!found) return;
  if (standing && std::abs(*standing - *found) > tolerance)
    problems.add({source.file->file, 0, 0, source.run->mode}, std::string(what) + " is not that of the runs before",
                 shown(*found) + " after " + shown(*standing), "make one table per sun and sensor");
  if (!standing) standing = found;
}

void SampleBook::sun_and_sensor(const Source& source) {
  const Geometry& g = source.run->geometry;
  if (g.sensor_height_m) agree(out.sensor_height_m, *g.sensor_height_m - ground_m, 0.5, "the sensor's height", source);
  // Of runs by place and time it is the sun at each path's end, which lies elsewhere for each line of sight.
  if (out.sun_zenith_deg && g.sun_zenith_deg && std::abs(*out.sun_zenith_deg - *g.sun_zenith_deg) > kSameAngle_deg)
    out.notices.push_back(source.file->file + ": the sun's zenith is " + shown(*g.sun_zenith_deg) +
                          " deg where the path ends; that of the first run, " + shown(*out.sun_zenith_deg) +
                          " deg, is taken");
  agree(out.sun_zenith_deg, g.sun_zenith_deg, kPathEnds_deg, "the sun's zenith", source);
  std::optional<double> azimuth = g.sun_azimuth_deg;
  if (azimuth && out.sun_azimuth_deg)
    azimuth = *out.sun_azimuth_deg + std::remainder(*azimuth - *out.sun_azimuth_deg, 360.0);
  agree(out.sun_azimuth_deg, azimuth, kPathEnds_deg, "the sun's azimuth", source);
  agree(out.earth_sun_factor, g.earth_sun_factor, 1e-3, "the earth-sun factor", source);
  if (g.day_of_year && out.day_of_year && *g.day_of_year != *out.day_of_year)
    problems.add({source.file->file, 0, 0, source.run->mode}, "the day of the year is not that of the runs before",
                 std::to_string(*g.day_of_year) + " after " + std::to_string(*out.day_of_year),
                 "make one table per day");
  if (!out.day_of_year) out.day_of_year = g.day_of_year;
  for (const std::string& note : source.run->notes)
    if (note.rfind(kToldBy, 0) == 0) out.notices.push_back(source.file->file + ": " + note);
}

}  // namespace raycube::atmos::imported
