// Runs of uvspec as samples. What it computes at levels (zout) becomes paths between them: the direct beam of sunlight
// at two levels gives the transmission, Beer's law along another slant, and L_up(sensor) - T L_up(target) is the light
// the path itself sends, scattered or emitted. A thermal run has no beam; a run by sunlight gives it the transmission.
#include <algorithm>
#include <cmath>
#include <set>

#include "atmos_tables/import/sample_book.h"
#include "atmos_tables/import/text_lines.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

bool same_level(const Place& a, const Place& b) { return a.top_of_air == b.top_of_air && a.height_m == b.height_m; }

class SolverRun {
 public:
  SolverRun(const Source& source, SampleBook& book) : source_(source), run_(*source.run), book_(book) {
    for (const Column& column : run_.columns)
      if (std::none_of(levels_.begin(), levels_.end(), [&](const Place& p) { return same_level(p, column.place); }))
        levels_.push_back({column.place.height_m, column.place.top_of_air, {}, {}, {}});
    std::sort(levels_.begin(), levels_.end(),
              [](const Place& a, const Place& b) { return a.height_m.value_or(1e9) < b.height_m.value_or(1e9); });
    for (const std::string& said : run_.notes) note(said);  // what the numbers are means over
  }

  void by_sunlight() {
    book_.sun_and_sensor(source_);
    if (!run_.find("irradiance_down_direct") || !run_.geometry.sun_zenith_deg) {
      book_.problems.add({source_.file->file, 0, 0, ""}, "a uvspec run needs sza and the column edir to become a table",
                         "", "ask for output_user lambda edir edn uu");
      return;
    }
    mu0_ = std::cos(base::rad_from_deg(*run_.geometry.sun_zenith_deg));
    if (top().top_of_air) {
      Spectrum e0 = at("irradiance_down_direct", top());
      for (double& e : e0) e /= mu0_;
      book_.add("solar_irradiance", {}, std::move(e0));
    }
    if (!find_sensor()) return;
    for (const Place& level : levels_)
      if (&level != sensor_)
        sunlit_level(level);
      else
        break;
    note(
        "view transmission is that of the direct beam between the levels, exp((mu0/mu) ln(edir(target)/edir(sensor)))");
    say_ground("path, sky and irradiance hold its light");
  }

  void by_emission() {
    if (!find_sensor()) return;
    for (const Place& level : levels_)
      if (&level != sensor_)
        emitting_level(level);
      else
        break;
    say_ground("the sky holds what comes back of the ground's light");
  }

 private:
  const Place& top() const { return levels_.back(); }
  void note(const std::string& text) { book_.out.notices.push_back(source_.file->file + ": " + text); }
  void say_ground(const char* what) {
    if (run_.geometry.ground_albedo.value_or(0) > 0)
      note("computed over ground of albedo " + shown(*run_.geometry.ground_albedo) + "; " + what);
  }

  /// Empty where the run has no such column there; a direction that a column does not name is any.
  Spectrum at(const std::string& name, const Place& level, double zenith = 0, double azimuth = 0) const {
    for (const Column& c : run_.columns)
      if (c.name == name && same_level(c.place, level) &&
          std::abs(c.place.zenith_deg.value_or(zenith) - zenith) < 1e-6 &&
          std::abs(c.place.relative_azimuth_deg.value_or(azimuth) - azimuth) < 1e-6)
        return book_.on_grid(run_, c);
    return {};
  }

  /// The sensor's level: the one asked for, else the highest with a height, else the top of the air.
  bool find_sensor() {
    const auto& asked = book_.request.sensor_height_m;
    for (const Place& level : levels_)
      if (level.height_m && (!asked || std::abs(*level.height_m - book_.ground_m - *asked) < 0.5)) sensor_ = &level;
    if ((!sensor_ || sensor_ == &levels_.front()) && top().top_of_air) sensor_ = &top();
    if (!sensor_ || sensor_ == &levels_.front()) {
      book_.problems.add({source_.file->file, 0, 0, ""}, "no level of zout is the sensor's",
                         asked ? shown(*asked) + " m" : "", "run uvspec with zout at ground, sensor and TOA");
      return false;
    }
    if (sensor_->height_m)
      book_.agree(book_.out.sensor_height_m, *sensor_->height_m - book_.ground_m, 0.5, "the sensor's height", source_);
    return true;
  }

  /// Directions of columns of a name at a level: zenith and azimuth.
  std::set<std::pair<double, double>> directions(const std::string& name, const Place& level) const {
    std::set<std::pair<double, double>> out;
    for (const Column& c : run_.columns)
      if (c.name == name && same_level(c.place, level))
        out.insert({*c.place.zenith_deg, c.place.relative_azimuth_deg.value_or(0)});
    return out;
  }

  Sample at_height(const Place& level) const {
    Sample out;
    out.height_m = book_.ground(level.height_m);
    return out;
  }
  /// -ln of the direct beam's share from `above` down to `level`, along the vertical; infinite where none is left.
  Spectrum vertical_depth(const Place& level, const Place& above) const {
    const Spectrum below = at("irradiance_down_direct", level), over = at("irradiance_down_direct", above);
    Spectrum out;
    for (std::size_t i = 0; i < below.size() && i < over.size(); ++i)
      out.push_back(over[i] > 0 ? -mu0_ * std::log(std::min(1.0, below[i] / over[i])) : HUGE_VAL);
    return out;
  }
  static Spectrum through(const Spectrum& depth, double cosine) {
    Spectrum out;
    for (const double d : depth) out.push_back(std::exp(-d / cosine));
    return out;
  }
  /// L_up(sensor) - T L_up(target), rounding below 0 taken off; empty where a level lacks the direction.
  static Spectrum of_the_path(const Spectrum& at_sensor, const Spectrum& t, const Spectrum& at_target) {
    Spectrum out;
    for (std::size_t i = 0; i < at_sensor.size() && i < at_target.size(); ++i)
      out.push_back(std::max(0.0, at_sensor[i] - t[i] * at_target[i]));
    return out;
  }

  void sunlit_level(const Place& level) {
    const Sample here = at_height(level);
    book_.add("direct_irradiance", here, at("irradiance_down_direct", level));
    book_.add("diffuse_irradiance", here, at("irradiance_down_diffuse", level));
    if (top().top_of_air) book_.add("sun_transmission", here, through(vertical_depth(level, top()), mu0_));
    for (const Column& c : run_.columns)
      if (c.name == "radiance_downward" && same_level(c.place, level)) {
        Sample place = here;
        place.zenith_deg = c.place.zenith_deg;
        if (*place.zenith_deg > 0.01) place.azimuth_deg = c.place.relative_azimuth_deg;
        book_.add("sky_radiance_solar", place, book_.on_grid(run_, c));
      }
    const Spectrum depth = vertical_depth(level, *sensor_);
    book_.depths.push_back({*here.height_m, depth});
    for (const auto& [zenith, azimuth] : directions("radiance_upward", *sensor_)) {
      Sample place = here;
      place.zenith_deg = zenith;
      const Spectrum t = through(depth, std::cos(base::rad_from_deg(zenith)));
      book_.add("view_transmission", place, t);
      if (zenith > 0.01) place.azimuth_deg = azimuth;
      book_.add("path_radiance_solar", place,
                of_the_path(at("radiance_upward", *sensor_, zenith, azimuth), t,
                            at("radiance_upward", level, zenith, azimuth)));
    }
  }

  /// uu, else u0u: emitted light is the same all around.
  std::string emitted(const std::string& name) const { return run_.find(name) ? name : name + "_azimuth_mean"; }
  std::set<double> zeniths(const std::string& name, const Place& level) const {
    std::set<double> out;
    for (const auto& [zenith, azimuth] : directions(name, level)) out.insert(zenith);
    return out;
  }

  void emitting_level(const Place& level) {
    const std::string up = emitted("radiance_upward"), down = emitted("radiance_downward");
    Sample place = at_height(level);
    for (const double zenith : zeniths(down, level)) {
      place.zenith_deg = zenith;
      book_.add("sky_radiance_thermal", place, first_azimuth(down, level, zenith));
    }
    for (const double zenith : zeniths(up, *sensor_)) {
      place.zenith_deg = zenith;
      const Spectrum t = transmission(place);
      if (t.empty()) {
        lacks_transmission(zenith);
        continue;
      }
      book_.add("path_radiance_thermal", place,
                of_the_path(first_azimuth(up, *sensor_, zenith), t, first_azimuth(up, level, zenith)));
    }
  }
  Spectrum first_azimuth(const std::string& name, const Place& level, double zenith) const {
    for (const auto& [z, azimuth] : directions(name, level))
      if (z == zenith) return at(name, level, z, azimuth);
    return {};
  }

  /// From target to sensor as the other runs have it: at this zenith, or by Beer's law of the beam between the levels.
  Spectrum transmission(const Sample& place) {
    for (const Sample& s : book_.out.all)
      if (s.row == "view_transmission" && std::abs(s.height_m.value_or(*place.height_m) - *place.height_m) < 0.5 &&
          std::abs(s.zenith_deg.value_or(*place.zenith_deg) - *place.zenith_deg) < 0.01)
        return s.values;
    for (const auto& [height, depth] : book_.depths)
      if (std::abs(height - *place.height_m) < 0.5) {
        Spectrum t = through(depth, std::cos(base::rad_from_deg(*place.zenith_deg)));
        book_.add("view_transmission", place, t);
        return t;
      }
    return {};
  }
  void lacks_transmission(double zenith) {
    const std::string what = "light that the path emits is L_up(sensor) - T L_up(target), and no run says what T is";
    const std::string way_out =
        "add a uvspec run with source solar, the same zout and wavelengths and the column edir, or a CSV column "
        "view_transmission";
    if (book_.request.partial)
      note(what + "; " + way_out);
    else
      book_.problems.add({source_.file->file, 0, 0, ""}, what, "view zenith " + shown(zenith) + " deg", way_out);
  }

  const Source& source_;
  const Run& run_;
  SampleBook& book_;
  std::vector<Place> levels_;
  const Place* sensor_ = nullptr;
  double mu0_ = 1;
};

}  // namespace

void add_solver_samples(const Source& source, SampleBook& book) {
  SolverRun run(source, book);
  if (source.role == Role::emission)
    run.by_emission();
  else
    run.by_sunlight();
}

}  // namespace raycube::atmos::imported
