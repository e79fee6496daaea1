#include "host/plan/environment_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/environment_function.h"
#include "host/base/parallel.h"
#include "host/plan/curve.h"
#include "host/plan/ground_rays.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

constexpr std::size_t kPlaces = 4096;         ///< around a node, for each environment function
constexpr int kRasterPoints = 256;            ///< of a raster, along its longer side
constexpr int kMostNodes = 128;               ///< of the map along a side
constexpr std::size_t kMostParts = 1u << 22;  ///< of the map, 24 bytes each
/// Nodes this part of the sensor's height apart, raster points a sixteenth of that: what bilinear weights then cost is
/// in docs/light.md.
constexpr double kStepOfHeight = 1.0 / 64, kPointsPerStep = 8;
/// Rasters from fine to coarse reach past the view to where this much of the aerosol's light comes from.
constexpr double kShares[] = {0.3, 0.75, 0.99};

struct Region {
  double x_lo, x_hi, y_lo, y_hi;
  double width() const { return x_hi - x_lo; }
  double height() const { return y_hi - y_lo; }
  double longer() const { return std::max(width(), height()); }
  bool operator==(const Region&) const = default;
  bool empty() const { return !(width() > 0) || !(height() > 0); }
  Region grown(double by) const { return {x_lo - by, x_hi + by, y_lo - by, y_hi + by}; }
  Region inside(const Region& o) const {
    return {std::max(x_lo, o.x_lo), std::min(x_hi, o.x_hi), std::max(y_lo, o.y_lo), std::min(y_hi, o.y_hi)};
  }
};

/// Uppermost surfaces at the centres of square cells.
class GroundRaster {
 public:
  GroundRaster(const scene::CompiledScene& scene, const Region& region, double finest_m, int most, int threads)
      : region_(region) {
    if (region.empty()) return;
    cell_ = std::max(finest_m, region.longer() / most);
    columns_ = static_cast<std::size_t>(std::ceil(region.width() / cell_ - 1e-9));
    rows_ = static_cast<std::size_t>(std::ceil(region.height() / cell_ - 1e-9));
    dx_ = region.width() / static_cast<double>(columns_), dy_ = region.height() / static_cast<double>(rows_);
    per_dx_ = 1 / dx_, per_dy_ = 1 / dy_;
    surface_.resize(rows_ * columns_);
    base::for_each_index(rows_, threads, [&](std::size_t r) {
      for (std::size_t c = 0; c < columns_; ++c)
        surface_[r * columns_ + c] = uppermost_surface(scene, region.x_lo + (static_cast<double>(c) + 0.5) * dx_,
                                                       region.y_lo + (static_cast<double>(r) + 0.5) * dy_);
    });
  }
  bool contains(double x, double y) const {
    return !surface_.empty() && x >= region_.x_lo && x <= region_.x_hi && y >= region_.y_lo && y <= region_.y_hi;
  }
  std::uint32_t at(double x, double y) const {
    const auto c = static_cast<std::size_t>(std::max(0.0, (x - region_.x_lo) * per_dx_));
    const auto r = static_cast<std::size_t>(std::max(0.0, (y - region_.y_lo) * per_dy_));
    return surface_[std::min(r, rows_ - 1) * columns_ + std::min(c, columns_ - 1)];
  }
  const std::vector<std::uint32_t>& surfaces() const { return surface_; }
  double cell_m() const { return cell_; }

 private:
  Region region_;
  double cell_ = 0, dx_ = 1, dy_ = 1, per_dx_ = 1, per_dy_ = 1;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> surface_;
};

/// Counts of surfaces become shares of materials. Only surfaces in `touched` are read, and their counts set back to
/// zero.
void add_shares(const scene::CompiledScene& scene, std::vector<std::uint32_t>& count,
                std::vector<std::uint32_t>& touched, double total, std::vector<double>& material_share) {
  std::sort(touched.begin(), touched.end());  // one order of summation, whatever was met first
  for (const auto s : touched) {
    const shared::Surface& surface = scene.surfaces[s];
    for (std::size_t k = 0; k < 4; ++k)
      if (surface.material[k] > 0)
        material_share[surface.material[k] - 1] += double{surface.fraction[k]} * count[s] / total;
    count[s] = 0;
  }
  touched.clear();
}

/// Where the pixels' rays can reach the ground between z_lo and z_hi.
Region footprint(const ViewBounds& view, double z_lo, double z_hi) {
  Region out{view.sensor_x_max, view.sensor_x_min, view.sensor_y_max, view.sensor_y_min};
  for (const double drop : {view.sensor_height_m - z_lo, view.sensor_height_m - z_hi})
    for (const double sec : {view.sec_min, view.sec_max}) {
      for (const double x : {view.x_min, view.x_max}) {
        out.x_lo = std::min(out.x_lo, view.sensor_x_min - drop * x * sec);
        out.x_hi = std::max(out.x_hi, view.sensor_x_max - drop * x * sec);
      }
      for (const double y : {view.y_min, view.y_max}) {
        out.y_lo = std::min(out.y_lo, view.sensor_y_min - drop * y * sec);
        out.y_hi = std::max(out.y_hi, view.sensor_y_max - drop * y * sec);
      }
    }
  return out;
}

/// Rasters of growing reach and spacing; a place is looked up in the first that holds it.
class Ground {
 public:
  Ground(const scene::CompiledScene& scene, const std::vector<Region>& regions, double finest_m, int threads) {
    for (const Region& region : regions)
      if (rasters_.empty() || !(region == last_))
        rasters_.emplace_back(scene, last_ = region, finest_m, kRasterPoints, threads);
  }
  std::uint32_t at(double x, double y) const {
    for (const auto& raster : rasters_)
      if (raster.contains(x, y)) return raster.at(x, y);
    return RC_NONE;
  }
  const GroundRaster& finest() const { return rasters_.front(); }
  const GroundRaster& widest() const { return rasters_.back(); }

 private:
  Region last_{};
  std::vector<GroundRaster> rasters_;
};

struct Offset {
  double x, y;
};

/// Places around a node: equal shares of the environment function, golden angle from one to the next (Vogel's spiral),
/// each moved within a cell of the map (additive recurrence of the plastic number): a node speaks for its cell, so that
/// rows and roofs do not beat against the nodes.
std::vector<Offset> spiral(atmos::Scatterer scatterer, double height_m, double cos_view, double step_m) {
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Offset> out;
  for (std::size_t k = 0; k < kPlaces; ++k) {
    const double share = (static_cast<double>(k) + 0.5) / kPlaces;
    const double r = 1000 * atmos::environment_radius_km(scatterer, share, height_m / 1000, cos_view);
    const double n = static_cast<double>(k) + 1, a = std::fmod(0.7548776662466927 * n, 1.0),
                 b = std::fmod(0.5698402909980532 * n, 1.0);
    out.push_back({r * std::sin(turn * n) + (a - 0.5) * step_m, r * std::cos(turn * n) + (b - 0.5) * step_m});
  }
  return out;
}

}  // namespace

EnvironmentMap make_environment(const scene::CompiledScene& scene, const ViewBounds& view, double z_lo, double z_hi,
                                bool local, int threads) {
  EnvironmentMap map;
  map.height_m = std::max(1.0, view.sensor_height_m - 0.5 * (z_lo + z_hi));
  map.sensor_z_m = view.sensor_height_m;
  map.local = local;
  map.cos_view = 2 / (view.sec_min + view.sec_max);
  const Region world{scene.lo[0], scene.hi[0], scene.lo[1], scene.hi[1]};
  const Region seen = footprint(view, z_lo, z_hi).inside(world);
  const double step = map.height_m * kStepOfHeight;
  std::vector<Region> regions;
  for (const double share : kShares) {
    const double reach =
        1000 * atmos::environment_radius_km(atmos::Scatterer::aerosol, share, map.height_m / 1000, map.cos_view);
    regions.push_back(footprint(view, z_lo, z_hi).grown(reach).inside(world));
  }
  if (!local) regions.erase(regions.begin(), regions.end() - 1);
  map.mean_lo_m = {regions.back().x_lo, regions.back().y_lo};
  map.mean_hi_m = {regions.back().x_hi, regions.back().y_hi};
  const Ground ground(scene, regions, step / kPointsPerStep, threads);

  std::vector<std::uint32_t> count(scene.surfaces.size(), 0), touched;
  const auto meet = [&](std::uint32_t surface) {
    if (count[surface]++ == 0) touched.push_back(surface);
  };
  double seen_points = 0;
  for (const auto surface : ground.widest().surfaces())
    if (surface != RC_NONE) meet(surface), ++seen_points;
  map.mean.assign(scene.materials.size(), 0.0);
  add_shares(scene, count, touched, std::max(1.0, seen_points), map.mean);

  map.columns = map.rows = 1;
  map.first_part = {0};
  const auto close_node = [&] { map.first_part.push_back(map.part.size()); };
  const auto only_mean = [&] {
    for (std::size_t c = 0; c < map.mean.size(); ++c)
      if (map.mean[c] > 0) map.part.push_back({static_cast<std::uint32_t>(c), map.mean[c], map.mean[c]});
    close_node();
  };
  if (!local || seen_points == 0 || seen.width() < 0 || seen.height() < 0) {
    only_mean();
    return map;
  }

  const auto curves =
      static_cast<std::size_t>(std::count_if(map.mean.begin(), map.mean.end(), [](double m) { return m > 0; }));
  const double most =
      std::min<double>(kMostNodes, std::sqrt(static_cast<double>(kMostParts / std::max<std::size_t>(1, curves))));
  map.step_m = std::max(step, seen.longer() / (most - 1));
  map.first_x_m = seen.x_lo;
  map.first_y_m = seen.y_lo;
  map.columns = static_cast<int>(std::ceil(seen.width() / map.step_m)) + 1;
  map.rows = static_cast<int>(std::ceil(seen.height() / map.step_m)) + 1;
  map.raster_m = ground.finest().cell_m();

  const std::vector<Offset> places[2] = {spiral(atmos::Scatterer::molecules, map.height_m, map.cos_view, map.step_m),
                                         spiral(atmos::Scatterer::aerosol, map.height_m, map.cos_view, map.step_m)};
  std::vector<double> share[2];
  bool all_alike = true;
  for (int r = 0; r < map.rows; ++r)
    for (int c = 0; c < map.columns; ++c) {
      const double x = map.first_x_m + c * map.step_m, y = map.first_y_m + r * map.step_m;
      for (std::size_t f = 0; f < 2; ++f) {
        std::size_t unknown = 0;
        for (const Offset& offset : places[f]) {
          const std::uint32_t surface = ground.at(x + offset.x, y + offset.y);
          if (surface == RC_NONE)
            ++unknown;
          else
            meet(surface);
        }
        share[f] = map.mean;
        for (double& s : share[f]) s *= static_cast<double>(unknown) / kPlaces;
        add_shares(scene, count, touched, kPlaces, share[f]);
      }
      const std::size_t begin = map.part.size();
      for (std::size_t k = 0; k < share[0].size(); ++k)
        if (share[0][k] > 0 || share[1][k] > 0)
          map.part.push_back({static_cast<std::uint32_t>(k), share[0][k], share[1][k]});
      close_node();
      all_alike = all_alike && map.part.size() - begin == map.first_part[1] &&
                  std::equal(map.part.begin(), map.part.begin() + static_cast<std::ptrdiff_t>(map.first_part[1]),
                             map.part.begin() + static_cast<std::ptrdiff_t>(begin));
    }
  if (all_alike) {  // one material everywhere: one node says it
    map.columns = map.rows = 1;
    map.part.resize(map.first_part[1]);
    map.first_part.resize(2);
  }
  return map;
}

std::array<EnvironmentWeight, 4> environment_at(const EnvironmentMap& map, double x_m, double y_m) {
  const auto place = [&](double at, double first, int count) {
    const double t = std::clamp((at - first) / map.step_m, 0.0, static_cast<double>(count - 1));
    const int low = std::clamp(static_cast<int>(t), 0, std::max(0, count - 2));
    return std::pair<int, double>{low, t - low};
  };
  const auto [c, fx] = place(x_m, map.first_x_m, map.columns);
  const auto [r, fy] = place(y_m, map.first_y_m, map.rows);
  const int right = std::min(c + 1, map.columns - 1), up = std::min(r + 1, map.rows - 1);
  const auto node = [&](int row, int column) { return static_cast<std::uint32_t>(row * map.columns + column); };
  return {{{node(r, c), (1 - fx) * (1 - fy)},
           {node(r, right), fx * (1 - fy)},
           {node(up, c), (1 - fx) * fy},
           {node(up, right), fx * fy}}};
}

namespace {

/// What a material sends back of an even sky's light.
std::vector<double> ground_albedo(const scene::Material& material, const std::vector<double>& wavelength_um) {
  std::vector<double> out(wavelength_um.size(), 0.0);
  for (const auto& part : scene::front_parts(material)) {
    const double share = scene::white_sky_albedo(part.shape);
    const std::vector<double> curve = sample_curve(material, part.curve, wavelength_um);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += share * curve[i];
  }
  return out;
}

}  // namespace

std::vector<double> mean_reflectance(const EnvironmentMap& map, const scene::CompiledScene& scene,
                                     const std::vector<double>& wavelength_um) {
  std::vector<double> out(wavelength_um.size(), 0.0);
  for (std::size_t c = 0; c < map.mean.size(); ++c) {
    if (map.mean[c] == 0) continue;
    const auto& x = scene.materials[c].reflectance.wavelength_um;
    std::vector<double> inside = wavelength_um;
    if (!x.empty())
      for (double& l : inside) l = std::clamp(l, x.front(), x.back());
    const std::vector<double> reflectance = ground_albedo(scene.materials[c], inside);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += map.mean[c] * reflectance[i];
  }
  return out;
}

void sample_environment(EnvironmentMap& map, const scene::CompiledScene& scene,
                        const std::vector<double>& wavelength_um) {
  map.reflectance.assign(scene.materials.size(), {});
  for (const auto& part : map.part)
    if (map.reflectance[part.material].empty())
      map.reflectance[part.material] = ground_albedo(scene.materials[part.material], wavelength_um);
}

}  // namespace raycube::plan
