#include "scene_compiler/matter.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "scene_compiler/spectral_shape.h"

namespace raycube::scene {

std::vector<std::uint32_t> named_materials(const CompiledScene& scene) {
  std::vector<std::uint32_t> out;
  std::uint32_t named = 0;
  for (const Material& material : scene.materials) {
    if (material.in_family == 0) ++named;
    out.push_back(named - 1);
  }
  return out;
}

std::size_t named_count(const CompiledScene& scene) {
  return static_cast<std::size_t>(std::count_if(scene.materials.begin(), scene.materials.end(),
                                                [](const Material& material) { return material.in_family == 0; }));
}

std::vector<std::uint32_t> used_materials(const CompiledScene& scene) {
  std::vector<char> placed(scene.trees.size(), 0), seen(scene.blocks.size(), 1);
  for (const auto& instance : scene.instances)
    if (instance.tree < placed.size()) placed[instance.tree] = 1;
  for (std::size_t t = 0; t < placed.size(); ++t)
    if (!placed[t]) std::fill_n(seen.begin() + scene.trees[t].first_block, scene.trees[t].block_count, char{0});
  std::vector<char> surface_used(scene.surfaces.size(), 0);
  std::uint32_t last = RC_NONE;  // a tree's triangles follow one another surface by surface, more or less
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    if (!seen[b]) continue;
    for (const auto surface : scene.blocks[b].surface)
      if (surface != last && surface < surface_used.size()) surface_used[surface] = 1, last = surface;
  }
  std::vector<char> used(scene.materials.size(), scene.blocks.empty() ? 1 : 0);
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s)
    if (surface_used[s])
      for_each_material(scene.surfaces[s], [&](std::size_t material, float) {
        if (material < used.size()) used[material] = 1;
      });
  std::vector<std::uint32_t> out;
  for (std::uint32_t m = 0; m < used.size(); ++m)
    if (used[m]) out.push_back(m);
  return out;
}

std::vector<std::uint32_t> used_families(const CompiledScene& scene) {
  std::vector<std::uint32_t> out;
  std::uint32_t last = RC_NONE;  // a family's members follow one another
  for (const auto index : used_materials(scene))
    if (const std::uint32_t family = index - scene.materials[index].in_family; family != last)
      out.push_back(index), last = family;
  return out;
}

namespace {

shared::Lobe lobe_of(const Shape& shape, float share) {
  shared::Lobe out{};
  out.shape = shape.number, out.share = share;
  for (std::size_t i = 0; i < shape.parameter.size(); ++i) out.parameter[i] = static_cast<float>(shape.parameter[i]);
  return out;
}

/// Tables of shapes, put behind the records.
class Tables {
 public:
  explicit Tables(std::size_t records) : records_(records) {}

  /// Tells a record where its shape's table begins, in floats from the records' beginning: 2^20 times its first
  /// parameter and the second, which floats count exactly.
  void tell(shared::Lobe& lobe, const Shape& shape) {
    const auto [found, fresh] = place_.emplace(shape.table, records_ * kFloats + numbers_.size());
    if (fresh) numbers_.insert(numbers_.end(), shape.table->begin(), shape.table->end());
    lobe.parameter[0] = static_cast<float>(found->second >> 20);
    lobe.parameter[1] = static_cast<float>(found->second & 0xfffffu);
  }

  void put_behind(std::vector<shared::Lobe>& records) const {
    records.resize(records_ + (numbers_.size() + kFloats - 1) / kFloats);
    if (!numbers_.empty()) std::memcpy(records.data() + records_, numbers_.data(), numbers_.size() * sizeof(float));
  }

 private:
  static constexpr std::size_t kFloats = sizeof(shared::Lobe) / sizeof(float);
  std::size_t records_;
  struct ByContent {
    bool operator()(const ShapeTable& a, const ShapeTable& b) const { return a != b && *a < *b; }
  };
  std::map<ShapeTable, std::size_t, ByContent> place_;
  std::vector<float> numbers_;
};

}  // namespace

std::size_t further_records(const CompiledScene& scene) { return (most_further(scene) + 7) / 8 * 8; }

std::size_t lobe_records(const CompiledScene& scene) { return RC_LOBES + further_records(scene); }

void for_each_lobe(const CompiledScene& scene, const shared::Surface& surface,
                   const std::function<void(std::size_t, const Shape&, double)>& place) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (surface.material[i] == 0) continue;
    const Material& material = scene.materials[surface.material[i] - 1];
    const auto fraction = static_cast<double>(surface.fraction[i]);
    place(0, material.front, 1);
    if (material.gloss.number != RC_SHAPE_none) place(1 + i, material.gloss, fraction);
    for (std::size_t t = 0; t < material.further.size(); ++t) place(RC_LOBES + t, material.further[t].shape, 1);
    if (lets_light_through(material) || is_plate(material)) place(RC_LOBE_BEHIND, material.behind, fraction);
  }
}

std::vector<shared::Lobe> surface_lobes(const CompiledScene& scene, std::size_t copies, const LobeFactor& factor) {
  std::vector<shared::Lobe> out;
  const std::size_t records = lobe_records(scene);
  Tables tables(scene.surfaces.size() * copies * records);
  const auto add = [&](const shared::Surface& surface, std::size_t copy) {
    const std::size_t first = out.size();
    const auto place = [&](std::size_t record, const Shape& shape, double share) {
      const double part = factor && record != RC_LOBE_BEHIND ? factor(copy, surface, record, shape) : 1;
      out[first + record] = lobe_of(shape, static_cast<float>(share * part));
      if (shape.table) tables.tell(out[first + record], shape);
    };
    out.resize(first + records, lobe_of({}, 0));
    out[first] = lobe_of({RC_SHAPE_lambert}, 1);
    for_each_lobe(scene, surface, [&](std::size_t record, const Shape& shape, double share) {
      const double others = record == RC_LOBE_BEHIND ? static_cast<double>(out[first + record].share) : 0;
      place(record, shape, others + share);
    });
  };
  for (const auto& surface : scene.surfaces)
    for (std::size_t copy = 0; copy < copies; ++copy) add(surface, copy);
  tables.put_behind(out);
  return out;
}

namespace {

const Material* first_shaped_of(const CompiledScene& scene, const std::vector<std::uint32_t>& used) {
  for (const auto material : used)
    if (scene.materials[material].front.number != RC_SHAPE_lambert) return &scene.materials[material];
  return nullptr;
}

CameraMatter matter_of_used(const CompiledScene& scene, const std::vector<std::uint32_t>& used) {
  const auto any = [&](auto&& has) {
    return std::any_of(used.begin(), used.end(), [&](std::uint32_t m) { return has(scene.materials[m]); });
  };
  CameraMatter out;
  out.through = any([](const Material& material) { return lets_light_through(material); });
  out.glossy = any([](const Material& material) { return material.gloss.number != RC_SHAPE_none; });
  out.plates = any([](const Material& material) { return is_plate(material); });
  out.shaped = out.glossy || out.plates || first_shaped_of(scene, used) != nullptr;
  for (const auto material : used)
    out.further = std::max(out.further, static_cast<int>(scene.materials[material].further.size()));
  out.further_records = static_cast<int>(further_records(scene));
  out.materials = material_count(scene);
  return out;
}

}  // namespace

CameraMatter camera_matter(const CompiledScene& scene) { return matter_of_used(scene, used_materials(scene)); }

std::vector<shared::Lobe> camera_lobes(const CompiledScene& scene) {
  const auto matter = camera_matter(scene);
  if (!matter.shaped && !matter.through) return std::vector<shared::Lobe>(1);
  auto lobes = surface_lobes(scene);
  const std::size_t records = scene.surfaces.size() * lobe_records(scene);  // then tables
  for (std::size_t i = 0; i < records; ++i) {
    Shape shape{lobes[i].shape};
    std::copy(std::begin(lobes[i].parameter), std::end(lobes[i].parameter), shape.parameter.begin());
    shape = as_cameras_see(shape);
    for (std::size_t k = 0; k < 6; ++k) lobes[i].parameter[k] = static_cast<float>(shape.parameter[k]);
  }
  return lobes;
}

Shape as_cameras_see(Shape shape) {
  const RcParameters wide =
      rc_shape_widened(shape.number, shape.parameters(), static_cast<double>(static_cast<float>(kLeastRoughness)));
  std::copy(std::begin(wide.of), std::end(wide.of), shape.parameter.begin());
  return shape;
}

const Shape* gloss_of(const CompiledScene& scene, std::uint32_t primitive) {
  const Shape* gloss = nullptr;
  for_each_material(matter_of(scene, primitive), [&](std::size_t material, float) {
    if (scene.materials[material].gloss.number != RC_SHAPE_none) gloss = &scene.materials[material].gloss;
  });
  return gloss;
}

const FurtherLobe* further_of(const CompiledScene& scene, std::uint32_t primitive, std::size_t number) {
  const FurtherLobe* found = nullptr;
  for_each_material(matter_of(scene, primitive), [&](std::size_t material, float) {
    if (number < scene.materials[material].further.size()) found = &scene.materials[material].further[number];
  });
  return found;
}

const Curve& white_curve() {
  static const Curve white{{0.05, 1000.0}, {1.0, 1.0}};
  return white;
}

std::uint32_t curve_roles(const CompiledScene& scene) {
  return RC_CURVE_ROLES + static_cast<std::uint32_t>(further_records(scene));
}

namespace {

/// Whose a curve is; null: the material has no such lobe, or the curve is none of a further one.
const FurtherLobe* further_of_curve(const CompiledScene& scene, std::uint32_t curve) {
  const std::uint32_t role = rc_curve_role(curve, material_count(scene));
  const auto& further = scene.materials[material_of_curve(scene, curve)].further;
  return role >= RC_CURVE_FURTHER && role - RC_CURVE_FURTHER < further.size() ? &further[role - RC_CURVE_FURTHER]
                                                                              : nullptr;
}

}  // namespace

const Curve& curve_of(const CompiledScene& scene, std::uint32_t curve) {
  static const Curve none;
  const Material& owner = scene.materials[material_of_curve(scene, curve)];
  switch (rc_curve_role(curve, material_count(scene))) {
    case RC_CURVE_REFLECTANCE:
      return owner.front_curve.value.empty() ? owner.reflectance : owner.front_curve;
    case RC_CURVE_TRANSMITTANCE:
      return owner.transmittance;
    case RC_CURVE_GLOSS:
      return owner.gloss_curve.value.empty() ? white_curve() : owner.gloss_curve;
    default:
      const FurtherLobe* lobe = further_of_curve(scene, curve);
      return lobe ? lobe->curve : none;
  }
}

bool is_of_front(const CompiledScene& scene, std::uint32_t curve) {
  const FurtherLobe* lobe = further_of_curve(scene, curve);
  return lobe ? !is_gloss(lobe->shape) : rc_curve_role(curve, material_count(scene)) == RC_CURVE_REFLECTANCE;
}

bool is_of_gloss(const CompiledScene& scene, std::uint32_t curve) {
  const FurtherLobe* lobe = further_of_curve(scene, curve);
  return lobe ? is_gloss(lobe->shape) : rc_curve_role(curve, material_count(scene)) == RC_CURVE_GLOSS;
}

bool carries_light(const CompiledScene& scene, std::uint32_t curve) {
  const Material& owner = scene.materials[material_of_curve(scene, curve)];
  switch (rc_curve_role(curve, material_count(scene))) {
    case RC_CURVE_TRANSMITTANCE:
      return lets_light_through(owner) || is_plate(owner);
    case RC_CURVE_GLOSS:
      return owner.gloss.number != RC_SHAPE_none;
    case RC_CURVE_REFLECTANCE:
      return true;
    default:
      return further_of_curve(scene, curve) != nullptr;
  }
}

bool lets_light_through(const Material& material) {
  return material.behind.number == RC_SHAPE_leaf && !material.transmittance.value.empty();
}

bool is_plate(const Material& material) {
  return material.behind.number == RC_SHAPE_plate && !material.transmittance.value.empty();
}

namespace {

template <class Has>
bool any_of_primitive(const CompiledScene& scene, std::uint32_t primitive, Has&& has) {
  bool found = false;
  for_each_material(matter_of(scene, primitive),
                    [&](std::size_t material, float) { found = found || has(scene.materials[material]); });
  return found;
}

}  // namespace

bool lets_light_through(const CompiledScene& scene, std::uint32_t primitive) {
  return any_of_primitive(scene, primitive, [](const Material& material) { return lets_light_through(material); });
}

bool is_plate(const CompiledScene& scene, std::uint32_t primitive) {
  return any_of_primitive(scene, primitive, [](const Material& material) { return is_plate(material); });
}

std::vector<std::uint32_t> seen_curves(const CompiledScene& scene) {
  std::vector<std::uint32_t> out;
  const auto used = used_materials(scene);
  for (const auto material : used) out.push_back(reflectance_curve(scene, material));
  const CameraMatter matter = matter_of_used(scene, used);
  for (const auto material : used)
    if (matter.through || matter.plates) out.push_back(transmittance_curve(scene, material));
  for (const auto material : used)
    if (matter.glossy) out.push_back(gloss_curve(scene, material));
  const bool mixed = scene.surfaces.size() > scene.materials.size();
  for (std::size_t number = 0; number < static_cast<std::size_t>(matter.further); ++number)
    for (const auto material : used)
      if (mixed || number < scene.materials[material].further.size())
        out.push_back(further_curve(scene, material, number));
  return out;
}

const Material* first_shaped(const CompiledScene& scene) { return first_shaped_of(scene, used_materials(scene)); }

}  // namespace raycube::scene
