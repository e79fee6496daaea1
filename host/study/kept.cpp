#include "host/study/kept.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/base/sha256.h"

namespace raycube::study {

namespace {

constexpr char kMagic[] = "raycube converged 1\n";
constexpr std::size_t kKeyBytes = 64, kDigestBytes = 32;

/// Feeds plain values to a hash. Sizes go in too, so that two lists cannot pass for one.
class Digest {
 public:
  template <class T>
  requires std::is_arithmetic_v<T> Digest& add(T value) {
    hash_.add(&value, sizeof value);
    return *this;
  }
  Digest& add(const std::string& text) {
    add(text.size());
    hash_.add(text);
    return *this;
  }
  template <class T>
  requires std::is_arithmetic_v<T> Digest& add(const std::vector<T>& values) {
    add(values.size());
    hash_.add(values.data(), values.size() * sizeof(T));
    return *this;
  }
  std::string hex() const { return hash_.hex(); }

 private:
  base::Sha256 hash_;
};

void add_table(Digest& digest, const atmos::RenderTable& table) {
  digest.add(table.sun_zenith_deg).add(table.sun_azimuth_deg).add(table.sensor_height_m);
  for (const auto& [name, axis] : table.axes) digest.add(name).add(axis.nodes);
  for (const auto& [name, row] : table.rows) digest.add(name).add(row.values);
}

void add_instrument(Digest& digest, const scene::Instrument& i) {
  digest.add(static_cast<int>(i.kind))
      .add(i.pixels)
      .add(i.lines)
      .add(i.ifov_along_rad)
      .add(i.ifov_across_rad)
      .add(static_cast<int>(i.motion));
  digest.add(i.nominal_agl_m).add(i.psf_sigma_px).add(i.psf_support_px).add(i.poses.size());
  for (const scene::Pose& p : i.poses)
    digest.add(p.x_m).add(p.y_m).add(p.z_m).add(p.roll_deg).add(p.pitch_deg).add(p.heading_deg);
}

/// What the converged solution takes from a plan.
void add_plan(Digest& digest, const plan::Plan& plan) {
  digest.add(plan.wavelength_um).add(plan.bands.size());
  for (const plan::BandQuadrature& band : plan.bands) digest.add(band.first).add(band.weight);
  for (const float part : plan.sun_direction) digest.add(part);
  digest.add(plan.sun_up).add(plan.height.first).add(plan.thermal.on).add(plan.thermal.surroundings_K);
  const plan::EnvironmentMap& map = plan.environment;
  digest.add(map.columns).add(map.rows).add(map.first_x_m).add(map.first_y_m).add(map.step_m).add(map.mean);
  for (int axis = 0; axis < 2; ++axis)
    digest.add(map.mean_lo_m[static_cast<std::size_t>(axis)]).add(map.mean_hi_m[static_cast<std::size_t>(axis)]);
  digest.add(map.height_m).add(map.cos_view).add(map.sensor_z_m).add(map.pressure_hPa).add(map.local).add(map.raster_m);
}

std::string packed(const std::string& key, const Converged& result) {
  std::string out = kMagic + key;
  const auto number = [&](std::uint64_t value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  number(result.bands), number(result.radiance.size());
  for (const auto* values : {&result.radiance, &result.half})
    out.append(reinterpret_cast<const char*>(values->data()), values->size() * sizeof(double));
  const auto digest = base::Sha256().add(out).digest();
  return out.append(reinterpret_cast<const char*>(digest.data()), digest.size());
}

/// Throws Error(input) on anything but a whole file of this key.
Converged unpacked(const std::string& file, const std::string& key, const std::string& bytes) {
  const auto damaged = [&](const std::string& how) {
    return base::Error(base::Fault::input, file + ": a kept reference that " + how);
  };
  const std::size_t head = sizeof kMagic - 1 + kKeyBytes + 2 * sizeof(std::uint64_t);
  if (bytes.size() < head + kDigestBytes) throw damaged("is cut short");
  const std::size_t body = bytes.size() - kDigestBytes;
  const auto digest = base::Sha256().add(bytes.data(), body).digest();
  if (std::memcmp(digest.data(), bytes.data() + body, kDigestBytes) != 0) throw damaged("is damaged");
  if (bytes.compare(0, sizeof kMagic - 1, kMagic) != 0 || bytes.compare(sizeof kMagic - 1, kKeyBytes, key) != 0)
    throw damaged("is of something else");
  std::uint64_t bands = 0, values = 0;
  std::memcpy(&bands, bytes.data() + head - 2 * sizeof bands, sizeof bands);
  std::memcpy(&values, bytes.data() + head - sizeof values, sizeof values);
  if (body != head + 2 * values * sizeof(double)) throw damaged("is damaged");
  Converged out;
  out.bands = bands;
  out.radiance.resize(values), out.half.resize(values);
  std::memcpy(out.radiance.data(), bytes.data() + head, values * sizeof(double));
  std::memcpy(out.half.data(), bytes.data() + head + values * sizeof(double), values * sizeof(double));
  return out;
}

}  // namespace

std::string key_of(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                   const atmos::RenderTable& table, const std::vector<render::Tile>& tiles,
                   const ConvergedSettings& settings) {
  if (simulation.scene.content_hash.empty()) return "";
  Digest digest;
  digest.add(base::program_hash())
      .add(simulation.scene.content_hash)
      .add(simulation.seed)
      .add(simulation.atmosphere.none);
  add_instrument(digest, instrument);
  add_table(digest, table);
  add_plan(digest, plan);
  for (const render::Tile& tile : tiles)
    digest.add(tile.first_line).add(tile.lines).add(tile.first_column).add(tile.columns);
  digest.add(settings.grid).add(settings.directions).add(settings.per_sample);
  if (settings.levels > 0) digest.add(settings.levels).add(settings.paths);
  return digest.hex();
}

std::string key_of(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                   const std::vector<std::int64_t>& pulses) {
  if (simulation.scene.content_hash.empty()) return "";
  Digest digest;
  // The file's text has the platform, the scan and the optics; the air, matter and gases come from files and models of
  // their own.
  digest.add(base::program_hash())
      .add(simulation.scene.content_hash)
      .add(simulation.resolved_json)
      .add(plan.lidar.name)
      .add(plan.seed)
      .add(pulses);
  const scene::LidarTransport& transport = plan.lidar.transport;
  digest.add(transport.max_bounces)
      .add(plan.lidar.gate.bin_s)
      .add(plan.lidar.gate.bins)
      .add(plan.photons)
      .add(plan.cross_section_cm2);
  digest.add(plan.air.z0_m)
      .add(plan.air.dz_m)
      .add(plan.air.depth)
      .add(plan.air.backscatter_per_m_sr)
      .add(plan.footprint.a)
      .add(plan.footprint.b);
  for (const auto& node : plan.nodes) digest.add(node.line).add(node.wavelength_um).add(node.weight);
  for (const auto& matter : plan.matter) digest.add(matter.reflectance).add(matter.transmittance);
  return digest.hex();
}

Converged kept_or(const std::string& folder, const std::string& key, const std::function<Converged()>& compute,
                  Kept* what) {
  if (folder.empty() || key.empty()) return compute();
  const std::string file = (std::filesystem::path(folder) / (key + ".ref")).string();
  std::error_code error;
  if (std::filesystem::exists(file, error)) {
    try {
      std::ifstream in(file, std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(in), {}};
      Converged out = unpacked(file, key, bytes);
      if (what) what->found = true;
      return out;
    } catch (const base::Error& damaged) {
      if (what) what->warning = std::string(damaged.what()) + "; it is computed anew";
    }
  }
  Converged out = compute();
  try {
    std::filesystem::create_directories(folder);
    base::write_output_file(file, packed(key, out), base::IfExists::replace);
  } catch (const std::exception& failed) {
    if (what && what->warning.empty())
      what->warning = std::string("the reference could not be kept for the next run: ") + failed.what();
  }
  return out;
}

}  // namespace raycube::study
