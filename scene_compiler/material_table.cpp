#include "scene_compiler/material_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "kernels/shared/product_key.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/leaf_optics.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {
namespace {

using base::Problems;

// A constant spectrum holds wherever a sensor may look.
constexpr double kConstantFirstUm = 0.1, kConstantLastUm = 100.0;
constexpr double kLeafFirst_um = 0.35;

std::optional<Material> constant_material(const Record& record, Problems& problems) {
  const double r = record.number("reflectance"), t = record.number("transmittance");
  if (r + t > 1) {
    problems.add(record.place("transmittance"), "reflectance + transmittance above 1",
                 number_text(r) + " + " + number_text(t), "energy must not be gained: lower one");
    return std::nullopt;
  }
  Material out;
  out.reflectance = {{kConstantFirstUm, kConstantLastUm}, {r, r}};
  if (record.given("transmittance")) out.transmittance = {{kConstantFirstUm, kConstantLastUm}, {t, t}};
  out.source = "constant";
  return out;
}

/// A constant reflectance from the curve's end on, where nothing was measured; what transmits becomes opaque there.
void extend(Curve& curve, double value) {
  if (curve.wavelength_um.empty() || curve.wavelength_um.back() >= kConstantLastUm) return;
  curve.wavelength_um.push_back(curve.wavelength_um.back() * (1 + 1e-6));
  curve.wavelength_um.push_back(kConstantLastUm);
  curve.value.insert(curve.value.end(), 2, value);
}

/// Below its first wavelength a leaf keeps its first value.
void hold_below(Curve& curve) {
  curve.wavelength_um.insert(curve.wavelength_um.begin(), kLeafFirst_um);
  curve.value.insert(curve.value.begin(), curve.value.front());
}

/// PROSPECT's leaf, held from 0.4 down to 0.35 um: piles of leaves reflect there as at 0.4 um within 0.004 (maple,
/// aspen and spruce of USGS splib07 and ASTER, scenes/park/spectra).
Material leaf_material(const Record& made_of) {
  LeafContent leaf;
  leaf.structure = made_of.number("n");
  leaf.chlorophyll_ug_cm2 = made_of.number("cab_ug_cm2"), leaf.carotenoids_ug_cm2 = made_of.number("car_ug_cm2");
  leaf.anthocyanins_ug_cm2 = made_of.number("cant_ug_cm2"), leaf.brown = made_of.number("cbrown");
  leaf.water_cm = made_of.number("cw_cm"), leaf.dry_matter_g_cm2 = made_of.number("cm_g_cm2");
  LeafOptics optics = leaf_optics(leaf);
  Material out;
  out.reflectance = std::move(optics.reflectance), out.transmittance = std::move(optics.transmittance);
  hold_below(out.reflectance), hold_below(out.transmittance);
  out.source = "PROSPECT-D (Feret et al. 2017)";
  return out;
}

SpectrumRequest request_of(const Record& record) {
  SpectrumRequest request;
  request.file = record.text(record.given("family") ? "family" : "file");
  request.spectrum = record.text("spectrum");
  request.reflectance_column = record.text("reflectance_column");
  request.transmittance_column = record.text("transmittance_column");
  if (record.given("scale")) request.scale = record.number("scale");
  request.medium = record.text("medium");
  request.asked_by = record.place(record.given("family") ? "family" : record.given("spectrum") ? "spectrum" : "file");
  return request;
}

/// Whether the material's spectrum has one source, and no key of another.
bool has_one_source(const Record& record, Problems& problems) {
  std::vector<std::string> sources;
  for (const char* key : {"file", "family", "reflectance", "leaf"})
    if (record.given(key)) sources.push_back(key);
  if (sources.size() != 1) {
    problems.add(record.where,
                 "material '" + record.text("name") + "' needs exactly one of file, family, reflectance and leaf",
                 sources.empty() ? "none" : sources[0] + " and " + sources[1], "remove or add one");
    return false;
  }
  if (record.given("family") != record.given("texture")) {
    problems.add(record.where, "material '" + record.text("name") + "': a family and a texture go together",
                 "only " + std::string(record.given("family") ? "family" : "texture"), "add the other, or remove it");
    return false;
  }
  const bool family = sources[0] == "family";
  const std::string of = family                 ? "a family"
                         : sources[0] == "leaf" ? "a leaf of its content"
                                                : "a constant reflectance";
  for (const char* key : {"spectrum", "reflectance_column", "transmittance_column", "scale", "medium"}) {
    const bool of_a_file = family && (key == std::string_view("scale") || key == std::string_view("medium"));
    if (sources[0] != "file" && !of_a_file && record.given(key)) {
      problems.add(record.place(key), std::string("'") + key + "' means nothing for " + of, "",
                   "remove it, or give file");
      return false;
    }
  }
  if (sources[0] == "reflectance" && record.given("reflectance_beyond")) {
    problems.add(record.place("reflectance_beyond"), "'reflectance_beyond' means nothing for " + of, "", "remove it");
    return false;
  }
  if (sources[0] == "reflectance" || !record.given("transmittance")) return true;
  problems.add(record.place("transmittance"), "'transmittance' goes with a constant reflectance",
               number_text(record.number("transmittance")),
               family                 ? "remove it: members of a family are opaque"
               : sources[0] == "file" ? "give the file a transmittance column"
                                      : "remove it: the leaf has its own");
  return false;
}

/// The one material of a record, or the members of its family; none after reporting.
std::vector<Material> read_spectra(const Record& record, Problems& problems) {
  if (!has_one_source(record, problems)) return {};
  if (record.given("family")) return read_family(request_of(record), problems);
  const Record* leaf = record.table("leaf");
  auto material = record.given("reflectance") ? constant_material(record, problems)
                  : leaf                      ? leaf_material(*leaf->table("prospect"))
                                              : read_spectrum(request_of(record), problems);
  if (!material) return {};
  return {std::move(*material)};
}

/// The shape that a material's table of its name asks for; none where it has none.
std::optional<Shape> read_shape(const Record& record, const ShapeEntry& entry) {
  const Record* table = entry.table ? record.table(std::string(entry.name)) : nullptr;
  if (table == nullptr) return std::nullopt;
  Shape out{entry.number};
  for (std::size_t i = 0; i < entry.parameters.size(); ++i)
    out.parameter[i] = table->number(std::string(entry.parameters[i].key));
  return out;
}

/// Refuses a shape that sends more light back than comes, of a material whose curves are known.
void check_energy(const Record& record, const Material& material, Problems& problems) {
  const auto& reflected = material.reflectance.value;
  const auto& through = material.transmittance.value;
  const MostAlbedo most = most_albedo(material.front);
  const double mirrored = material.gloss.number == RC_SHAPE_none ? 0 : material.gloss.parameter[1];
  for (std::size_t i = 0; i < reflected.size(); ++i) {
    const double sent = reflected[i] * most.albedo, passed = i < through.size() ? through[i] : 0;
    if (sent + passed + mirrored <= 1) continue;
    const std::string name(shape_entry(material.front.number).name);
    problems.add(
        record.place(name), "more light would leave than comes",
        fmt::format("albedo {:.3g}{} at {:.6g} nm of light from {:g} degrees off the normal, reflectance {:.4g}", sent,
                    (passed > 0 ? fmt::format(" and transmittance {:.3g}", passed) : "") +
                        (mirrored > 0 ? fmt::format(" and gloss {:.3g}", mirrored) : ""),
                    1000 * material.reflectance.wavelength_um[i], most.zenith_deg, reflected[i]),
        fmt::format("the shape sends {:.3g} times the reflectance: lower that, or give another {}", most.albedo, name));
    return;
  }
}

/// How its reflectance is spread over directions: by one shape of those with a table, else by Lambert's law.
void read_front(const Record& record, Material& out, Problems& problems) {
  for (const ShapeEntry& entry : shape_entries()) {
    if (entry.role != ShapeRole::front) continue;
    const auto shape = read_shape(record, entry);
    if (shape && out.front.number != RC_SHAPE_lambert)
      problems.add(record.place(std::string(entry.name)), "a material reflects by one shape",
                   std::string(shape_entry(out.front.number).name) + " and " + std::string(entry.name), "remove one");
    if (shape) out.front = *shape;
  }
}

/// The way of transmitted light, and gloss.
void read_lobes(const Record& record, Material& out, Problems& problems) {
  out.behind.number = find_shape(record.text("transmission"), ShapeRole::behind)->number;
  if (record.given("transmission") && out.transmittance.wavelength_um.empty())
    problems.add(record.place("transmission"), "'transmission' needs a transmittance", "an opaque material",
                 "remove it, or give transmittance");
  const Record* gloss = record.table("gloss");
  if (gloss == nullptr) return;
  const double f0 = gloss->number("f0");
  if (f0 > 0) out.gloss = *read_shape(record, shape_entry(RC_SHAPE_gloss));
  double most = 0;
  for (std::size_t i = 0; i < out.reflectance.value.size(); ++i)
    most = std::max(most,
                    out.reflectance.value[i] + (i < out.transmittance.value.size() ? out.transmittance.value[i] : 0));
  if (most + f0 > 1)
    problems.add(gloss->place("f0"), "reflectance + transmittance + f0 above 1",
                 number_text(most) + " + " + number_text(f0), "energy must not be gained: lower one");
}

}  // namespace

MaterialTable::MaterialTable(const Record& root, Problems& problems) {
  std::map<std::string, base::Where> places;
  const Record* thermal = root.table("thermal");
  const double default_K =
      thermal && thermal->given("default_temperature_K") ? thermal->number("default_temperature_K") : 0;
  for (const auto& record : root.records("material")) {
    const std::string& name = record.text("name");
    std::vector<Material> members = record.sound ? read_spectra(record, problems) : std::vector<Material>();
    std::optional<Texture> texture;
    if (!members.empty() && record.given("texture"))
      texture = read_texture(*record.table("texture"), members, problems);
    std::optional<Texture> mask;
    if (record.sound && record.given("mask")) mask = read_mask(*record.table("mask"), problems);
    if (members.empty()) members.emplace_back();  // of its name, so that what names it is not reported again
    const std::size_t before = problems.lines().size();
    for (Material& material : members) {
      if (problems.lines().size() > before) break;  // once for all of a family
      if (record.given("reflectance_beyond") && !material.reflectance.value.empty()) {
        extend(material.reflectance, record.number("reflectance_beyond"));
        extend(material.transmittance, 0);
      }
      if (record.sound && !material.reflectance.value.empty()) {
        read_front(record, material, problems);
        read_lobes(record, material, problems);
        if (!shape_entry(material.front.number).conserves) check_energy(record, material, problems);
      }
      material.temperature_K = record.given("temperature_K") ? record.number("temperature_K") : default_K;
      if (record.given("source")) material.source = record.text("source");
    }
    if (name.empty()) continue;
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh) {
      problems.add(record.where, "material '" + name + "' is defined twice", "first in " + place->second.text(),
                   "rename or remove one");
      continue;
    }
    if (std::uint64_t{RC_CURVE_ROLES} * (materials_.size() + members.size()) > RC_KEY_MASK) {
      problems.add(record.where, "more spectra than a scene can hold",
                   std::to_string(materials_.size() + members.size()) + " with those of '" + name + "'",
                   "at most " + std::to_string(RC_KEY_MASK / RC_CURVE_ROLES) + ": give smaller families");
      continue;
    }
    if (texture) textures_.emplace(static_cast<std::uint32_t>(materials_.size()), std::move(*texture));
    if (mask) masks_.emplace(static_cast<std::uint32_t>(materials_.size()), std::move(*mask));
    add(name, std::move(members));
  }
}

void MaterialTable::add(const std::string& name, std::vector<Material> members) {
  index_.emplace(name, static_cast<std::uint32_t>(materials_.size()));
  for (std::size_t place = 0; place < members.size(); ++place) {
    members[place].name = name, members[place].in_family = static_cast<std::uint32_t>(place);
    shared::Surface surface{};
    surface.material[0] = static_cast<std::uint32_t>(materials_.size()) + 1;
    surface.fraction[0] = 1.0f;
    materials_.push_back(std::move(members[place]));
    surfaces_.push_back(surface);
  }
}

std::uint32_t MaterialTable::at(std::uint32_t surface, double u_m, double v_m) {
  if (textures_.empty()) return surface;
  const shared::Surface of = surfaces_[surface];
  std::vector<std::pair<std::uint32_t, double>> parts;
  bool textured = false;
  for (int i = 0; i < 4; ++i) {
    if (of.material[i] == 0) continue;
    const auto texture = textures_.find(of.material[i] - 1);
    const bool has = texture != textures_.end();
    parts.emplace_back(of.material[i] - 1 + (has ? texture->second.at(u_m, v_m) : 0), of.fraction[i]);
    textured |= has;
  }
  return textured ? mix(parts) : surface;
}

double MaterialTable::texel_m(std::uint32_t surface) const {
  if (textures_.empty()) return 0;
  double out = 0;
  for (const std::uint32_t material : surfaces_[surface].material)
    if (const auto texture = textures_.find(material - 1); material > 0 && texture != textures_.end())
      out = out > 0 ? std::min(out, texture->second.texel_m()) : texture->second.texel_m();
  return out;
}

CoordinateImages MaterialTable::images(std::uint32_t surface) const {
  const auto lying = [&](const std::map<std::uint32_t, Texture>& images) -> const Texture* {
    const auto found = images.find(surfaces_[surface].material[0] - 1);
    return found != images.end() && found->second.by_coordinates() ? &found->second : nullptr;
  };
  return {lying(textures_), lying(masks_)};
}

std::uint32_t MaterialTable::surface(const std::string& name, const base::Where& where, Problems& problems,
                                     Covers covers) const {
  if (const auto found = index_.find(name); found != index_.end()) {
    if (const CoordinateImages images = this->images(found->second); covers == Covers::shape && images.any())
      problems.add(
          where, "material '" + name + "' lies by the texture coordinates of a mesh, which this is not",
          images.mask != nullptr ? "a mask" : "a texture without texel_m",
          images.mask != nullptr ? "give it to a mesh" : "give its texture a texel_m, or the material to a mesh");
    return found->second;
  }
  std::string known;
  for (const auto& [other, index] : index_) known += (known.empty() ? "" : ", ") + other;
  problems.add(where, "unknown material", "'" + name + "'",
               known.empty() ? "define it with [[material]]" : "define it with [[material]], or use one of: " + known);
  return 0;
}

bool MaterialTable::reflect_alike(const std::vector<std::pair<std::uint32_t, double>>& parts) const {
  return std::all_of(parts.begin(), parts.end(), [&](const auto& part) {
    return materials_[part.first].front == materials_[parts.front().first].front;
  });
}

std::uint32_t MaterialTable::mix(const std::vector<std::pair<std::uint32_t, double>>& parts) {
  if (parts.size() == 1) return parts.front().first;
  shared::Surface surface{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    surface.material[i] = surfaces_[parts[i].first].material[0];
    surface.fraction[i] = static_cast<float>(parts[i].second);
  }
  std::array<std::uint32_t, 8> key{};
  for (std::size_t i = 0; i < 4; ++i)
    key[i] = surface.material[i], key[4 + i] = std::bit_cast<std::uint32_t>(surface.fraction[i]);
  const auto [entry, fresh] = mixes_.emplace(key, static_cast<std::uint32_t>(surfaces_.size()));
  if (fresh) surfaces_.push_back(surface);
  return entry->second;
}

void MaterialTable::move_to(CompiledScene& scene) {
  scene.materials = std::move(materials_);
  scene.surfaces = std::move(surfaces_);
}

}  // namespace raycube::scene
