#include "host/run/photon_ledger.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/materials/shapes.h"
#include "scene_compiler/matter.h"

namespace raycube::run {

namespace {

constexpr double kEndless_m = std::numeric_limits<double>::infinity();

/// How far above a level light is counted, at least and over its height: more than single precision rounds.
constexpr double kOffLevel_m = 1e-6, kOffLevel = 1e-6;

void add_to(Spectrum& sum, double factor, const Spectrum& more) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += factor * more[i];
}

/// Height at which a ray leaves the scene's bounds through a side; infinity: it does not.
double side_height_m(const scene::CompiledScene& scene, const shared::Photon& photon) {
  const double from[2] = {double{photon.origin.x}, double{photon.origin.y}},
               way[2] = {double{photon.way.x}, double{photon.way.y}};
  double nearest = kEndless_m;
  for (std::size_t k = 0; k < 2; ++k)
    if (way[k] != 0) nearest = std::min(nearest, (double{way[k] > 0 ? scene.hi[k] : scene.lo[k]} - from[k]) / way[k]);
  return double{photon.origin.z} + nearest * double{photon.way.z};
}

/// Unit normal of what a photon met, in the scene's frame, on the side that `in` points to.
RcLocal normal_towards(const scene::CompiledScene& scene, const shared::Photon& photon, const RcLocal& in) {
  const shared::TriBlock& block = scene.blocks[photon.primitive / RC_BLOCK];
  const std::uint32_t k = photon.primitive % RC_BLOCK;
  const shared::Instance& placed = scene.instances[photon.instance];
  const auto turned = [&](double x, double y, double z) {
    const auto row = [&](const shared::rc_float4& r) { return double{r.x} * x + double{r.y} * y + double{r.z} * z; };
    return RcLocal{row(placed.world_from_local_0), row(placed.world_from_local_1), row(placed.world_from_local_2)};
  };
  const double x = double{block.v0_x[k]}, y = double{block.v0_y[k]}, z = double{block.v0_z[k]};
  const RcLocal a = turned(double{block.v1_x[k]} - x, double{block.v1_y[k]} - y, double{block.v1_z[k]} - z),
                b = turned(double{block.v2_x[k]} - x, double{block.v2_y[k]} - y, double{block.v2_z[k]} - z);
  RcLocal n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  const double to = n.x * in.x + n.y * in.y + n.z * in.z,
               scale = std::copysign(1 / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z), to);
  return {scale * n.x, scale * n.y, scale * n.z};
}

}  // namespace

PhotonLedger::PhotonLedger(const PhotonScene& scene)
    : reflected(scene.wavelengths, 0.0),
      lost(reflected),
      unfinished(reflected),
      ground(reflected),
      ground_first(reflected),
      arrived(scene.named, reflected),
      absorbed(arrived),
      down(scene.levels.size(), reflected),
      up(down) {}

void PhotonLedger::add(const PhotonLedger& other) {
  const auto one = [](Spectrum& sum, const Spectrum& more) { add_to(sum, 1, more); };
  const auto each = [&](std::vector<Spectrum>& sum, const std::vector<Spectrum>& more) {
    for (std::size_t k = 0; k < sum.size(); ++k) one(sum[k], more[k]);
  };
  one(reflected, other.reflected), one(lost, other.lost), one(unfinished, other.unfinished);
  one(ground, other.ground), one(ground_first, other.ground_first);
  each(arrived, other.arrived), each(absorbed, other.absorbed), each(down, other.down), each(up, other.up);
}

PhotonCount::PhotonCount(const PhotonScene& scene, bool facets)
    : ledger(scene), scene_(scene), facets_(facets), level_(scene.levels) {
  for (double& level : level_) level += std::max(kOffLevel_m, kOffLevel * std::abs(level));
}

void PhotonCount::start(std::size_t count) {
  carried_.assign(count, Spectrum(scene_.wavelengths, 1.0));
  from_z_m_.assign(count, kEndless_m);
}

void PhotonCount::set_off(const std::vector<shared::Photon>& photons) {
  came_.clear();
  for (const shared::Photon& photon : photons) came_.push_back(photon.way);
}

const Spectrum& PhotonCount::leaving(const MaterialLight& material, const shared::Photon& photon,
                                     const shared::rc_float4& came) {
  if (!scene_.changing || photon.side == RC_FAR_SIDE) return material.leaving(photon.side);
  const RcLocal in{-double{came.x}, -double{came.y}, -double{came.z}},
      out{double{photon.way.x}, double{photon.way.y}, double{photon.way.z}},
      normal = normal_towards(scene_.compiled, photon, in);
  by_lobes_.assign(scene_.wavelengths, 0.0);
  for (const LobeLight& lobe : photon.side == RC_NEAR_SIDE ? material.front_lobes : material.gloss_lobes)
    add_to(by_lobes_,
           rc_shape_eval(lobe.shape.number, std::numbers::pi, lobe.shape.parameters(), rc_angles(normal, in, out)),
           lobe.curve);
  return by_lobes_;
}

void PhotonCount::step(std::vector<shared::Photon>& photons, bool first) {
  std::size_t kept = 0;
  deposits.clear();
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const shared::Photon& photon = photons[i];
    Spectrum& carried = carried_[i];
    if (photon.instance == RC_NONE) {
      leave(photon, from_z_m_[i], carried);
      continue;
    }
    cross(from_z_m_[i], double{photon.met_z}, carried);
    meet(photon, came_[i], carried, first);
    if (photon.survival == 0) continue;
    go_on(photon, came_[i], carried);
    from_z_m_[kept] = double{photon.met_z};
    if (kept != i) photons[kept] = photon, std::swap(carried_[kept], carried);
    ++kept;
  }
  photons.resize(kept);
}

void PhotonCount::give_up(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) add_to(ledger.unfinished, 1, carried_[i]);
}

void PhotonCount::leave(const shared::Photon& photon, double from_z_m, const Spectrum& carried) {
  // A ray that leaves a scene that repeats by its side would have met the next cells there.
  const double endless_m = photon.way.z > 0 ? kEndless_m : -kEndless_m,
               edge_m = scene_.repeats ? side_height_m(scene_.compiled, photon) : endless_m;
  const bool out = edge_m >= double{scene_.compiled.hi[2]};
  cross(from_z_m, out ? endless_m : edge_m, carried);
  add_to(out ? ledger.reflected : ledger.lost, 1, carried);
}

void PhotonCount::cross(double from_m, double to_m, const Spectrum& carried) {
  for (std::size_t k = 0; k < level_.size(); ++k) {
    if (from_m >= level_[k] && to_m < level_[k]) add_to(ledger.down[k], 1, carried);
    if (from_m < level_[k] && to_m >= level_[k]) add_to(ledger.up[k], 1, carried);
  }
}

void PhotonCount::meet(const shared::Photon& photon, const shared::rc_float4& came, const Spectrum& carried,
                       bool first) {
  const std::uint32_t surface = scene::surface_of(scene_.compiled, photon.primitive);
  const bool shaped = scene_.shaped[surface];
  kept_.assign(scene_.wavelengths, 0.0);
  scene::for_each_material(scene_.compiled.surfaces[surface], [&](std::size_t number, float share) {
    const MaterialLight& material = scene_.material[number];
    const double fraction = double{share}, factor = double{photon.factor};
    const Spectrum& leaves = shaped ? leaving(material, photon, came) : material.reflected;
    Spectrum &arrived = ledger.arrived[material.named], &absorbed = ledger.absorbed[material.named];
    for (std::size_t i = 0; i < scene_.wavelengths; ++i) {
      const double light = fraction * carried[i];
      // Of a shape the light that leaves in the direction that was drawn stands for all that leaves.
      const double sent = shaped ? factor * leaves[i] : material.reflected[i] + material.through[i];
      arrived[i] += light, absorbed[i] += light * (1 - sent), kept_[i] += light * (1 - sent);
    }
    if (material.ground) add_to(ledger.ground, fraction, carried);
    if (material.ground && first) add_to(ledger.ground_first, fraction, carried);
  });
  if (facets_) deposits.push_back({photon.primitive, plan::in_bands(scene_.band, kept_)});
}

void PhotonCount::go_on(const shared::Photon& photon, const shared::rc_float4& came, Spectrum& carried) {
  leaves_.assign(scene_.wavelengths, 0.0);
  scene::for_each_material(scene::matter_of(scene_.compiled, photon.primitive), [&](std::size_t number, float share) {
    const MaterialLight& material = scene_.material[number];
    add_to(leaves_, double{share}, leaving(material, photon, came));
  });
  const double factor = double{photon.factor} / double{photon.survival};
  for (std::size_t i = 0; i < carried.size(); ++i) carried[i] *= factor * leaves_[i];
}

}  // namespace raycube::run
