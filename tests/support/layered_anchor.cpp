#include "tests/support/layered_anchor.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace raycube::testing {

scene::AtmosphereSpec summer_rural_air() {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  spec.layered->profile = "midlatitude_summer";
  spec.layered->co2_ppmv = 330;
  return spec;
}

scene::Sun sun_at(double zenith_deg, int day_of_year) {
  scene::Sun sun;
  sun.zenith_deg = zenith_deg;
  sun.day_of_year = day_of_year;
  return sun;
}

void Errors::add(double error) {
  mean += error, rms += error * error, ++count;
  if (!(std::abs(error) <= std::abs(worst))) worst = error;
}

void Errors::close() {
  if (count == 0) return;
  mean /= count, rms = std::sqrt(rms / count);
}

ChartRows::ChartRows(const std::string& name, const std::string& labels) {
  const char* folder = std::getenv("RAYCUBE_CHARTS");
  if (folder) file_ = std::string(folder) + "/" + name + ".csv", text_ = labels + "\n";
}

ChartRows::~ChartRows() {
  if (!file_.empty()) std::ofstream(file_) << text_;
}

void ChartRows::add(const std::vector<double>& values) {
  if (file_.empty()) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    char cell[40];
    std::snprintf(cell, sizeof cell, "%s%.7g", i > 0 ? "," : "", values[i]);
    text_ += cell;
  }
  text_ += "\n";
}

}  // namespace raycube::testing
