#include "scene_compiler/material_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <iterator>

#include "host/base/text.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/fresnel.h"
#include "scene_compiler/index_file.h"
#include "scene_compiler/leaf_optics.h"
#include "scene_compiler/measured_file.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectral_shape.h"
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

/// The same before the curve begins.
void extend_down(Curve& curve, double value) {
  if (curve.wavelength_um.empty() || curve.wavelength_um.front() <= kConstantFirstUm) return;
  const double first_um = curve.wavelength_um.front();
  curve.wavelength_um.insert(curve.wavelength_um.begin(), {kConstantFirstUm, first_um * (1 - 1e-6)});
  curve.value.insert(curve.value.begin(), 2, value);
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
  request.wavelengths = record.text("wavelengths");
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
  for (const char* key : {"spectrum", "reflectance_column", "transmittance_column", "scale", "wavelengths", "medium"}) {
    const bool of_a_file = family && (key == std::string_view("scale") || key == std::string_view("medium"));
    if (sources[0] != "file" && !of_a_file && record.given(key)) {
      problems.add(record.place(key), std::string("'") + key + "' means nothing for " + of, "",
                   "remove it, or give file");
      return false;
    }
  }
  for (const char* key : {"reflectance_beyond", "reflectance_below"})
    if (sources[0] == "reflectance" && record.given(key)) {
      problems.add(record.place(key), std::string("'") + key + "' means nothing for " + of, "", "remove it");
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

/// Whether a shape's numbers are as many as its wavelengths, and those in order.
bool fits_wavelengths(const Record& table, const ShapeEntry& entry, Problems& problems) {
  const std::vector<double>& at_nm = table.numbers("at_nm");
  for (std::size_t i = 1; i < at_nm.size(); ++i)
    if (!(at_nm[i] > at_nm[i - 1])) {
      problems.add(table.place("at_nm"), "'at_nm' must ascend",
                   number_text(at_nm[i]) + " after " + number_text(at_nm[i - 1]),
                   "order the wavelengths, and the lists with them");
      return false;
    }
  bool lists = false;
  for (const ShapeParameter& parameter : entry.parameters) {
    const std::string key(parameter.key);
    const std::size_t count = table.numbers(key).size();
    lists |= count > 1;
    if (count <= 1 || count == at_nm.size()) continue;
    problems.add(table.place(key), "'" + key + "' is not of as many wavelengths as 'at_nm'",
                 base::counted(count, "value") + ", " + base::counted(at_nm.size(), "wavelength"),
                 at_nm.empty() ? "give at_nm, or one number" : "give a value for each, or one number");
    return false;
  }
  if (at_nm.empty() || lists) return true;
  problems.add(table.place("at_nm"), "'at_nm' means nothing where no number changes with wavelength", "",
               "give a list of values, or remove it");
  return false;
}

/// A shape, and where it changes with wavelength its nodes.
struct GivenShape {
  Shape first;
  std::vector<ShapeNode> nodes;
};

/// The shape that a material's table of its name asks for; none where it has none.
std::optional<GivenShape> read_shape(const Record& record, const ShapeEntry& entry, Problems& problems) {
  const Record* table = entry.table ? record.table(std::string(entry.name)) : nullptr;
  if (table == nullptr || !fits_wavelengths(*table, entry, problems)) return std::nullopt;
  if (entry.curve_parameter >= 0 && table->given("at_nm")) {
    problems.add(table->place("at_nm"), "'at_nm' means nothing for " + std::string(entry.name), "",
                 "remove it: its shape changes with the material's curve, its numbers do not");
    return std::nullopt;
  }
  const auto shape_at = [&](std::size_t node) {
    Shape out{entry.number};
    for (std::size_t i = 0; i < entry.parameters.size(); ++i) {
      const std::vector<double>& values = table->numbers(entry.parameters[i].key);
      if (!values.empty()) out.parameter[i] = values[values.size() > 1 ? node : 0];
    }
    return out;
  };
  GivenShape out{shape_at(0), {}};
  for (const double nm : table->numbers("at_nm")) out.nodes.push_back({nm / 1000, shape_at(out.nodes.size())});
  return out;
}

/// Share of light that a gloss mirrors at normal incidence; 0 without one.
double mirrored_at(const Material& material, double wavelength_um) {
  double out = 0;
  for (const ShapeAndCurve& part : gloss_parts(material))
    out += value_at(part.curve, wavelength_um) * rc_shape_mirrored(part.shape.number, part.shape.parameters(), 1);
  return out;
}

double passed_at(const Material& material, double wavelength_um) {
  return material.transmittance.value.empty() ? 0 : value_at(material.transmittance, wavelength_um);
}

/// Refuses a shape that sends more light back than comes, of a material whose curves are known.
void check_energy(const Record& record, const Material& material, Problems& problems) {
  if (shape_entry(material.front.number).conserves) return;
  for (const double um : front_parts(material).front().curve.wavelength_um) {
    const MostAlbedo most = most_albedo(material, um);
    const double reflectance = value_at(material.reflectance, um), sent = reflectance * most.albedo;
    const double passed = passed_at(material, um), mirrored = mirrored_at(material, um);
    if (sent + passed + mirrored <= 1) continue;
    const std::string name(shape_entry(material.front.number).name);
    problems.add(
        record.place(name), "more light would leave than comes",
        fmt::format("albedo {:.3g}{} at {:.6g} nm of light from {:g} degrees off the normal, reflectance {:.4g}", sent,
                    (passed > 0 ? fmt::format(" and transmittance {:.3g}", passed) : "") +
                        (mirrored > 0 ? fmt::format(" and gloss {:.3g}", mirrored) : ""),
                    1000 * um, most.zenith_deg, reflectance),
        fmt::format("the shape sends {:.3g} times the reflectance: lower that, or give another {}", most.albedo, name));
    return;
  }
}

/// Refuses a gloss that mirrors, at normal incidence, what the rest of the material sends already.
void check_gloss(const Record& record, const Material& material, Problems& problems) {
  if (material.gloss.number == RC_SHAPE_none) return;
  const auto fronts = front_parts(material);
  std::vector<double> wavelengths_um = fronts.front().curve.wavelength_um;
  const double first = wavelengths_um.front(), last = wavelengths_um.back();
  for (const ShapeAndCurve& part : gloss_parts(material))
    std::copy_if(part.curve.wavelength_um.begin(), part.curve.wavelength_um.end(), std::back_inserter(wavelengths_um),
                 [&](double um) { return um > first && um < last; });
  double most = 0, beside = 0, mirrored = 0;
  for (const double um : wavelengths_um) {
    double sent = passed_at(material, um);
    for (const ShapeAndCurve& part : fronts) sent += value_at(part.curve, um);
    const double f0 = mirrored_at(material, um);
    if (sent + f0 > most) most = sent + f0, beside = sent, mirrored = f0;
  }
  if (most <= 1 + 1e-9) return;
  const ShapeEntry& entry = shape_entry(material.gloss.number);
  const Record* gloss = record.table(std::string(entry.name));
  const std::string key = gloss ? std::string(entry.parameters[1].key) : "f0";
  const std::string told = key == "f0" ? key : std::string(entry.name) + "'s " + key;
  problems.add(gloss ? gloss->place(key) : record.table("fresnel")->place("file"),
               "reflectance + transmittance + " + told + " above 1", fmt::format("{:.4g} + {:.4g}", beside, mirrored),
               "energy must not be gained: lower one");
}

/// The shape that was measured, at its wavelengths.
std::optional<GivenShape> read_measured_shape(const Record& table, Problems& problems) {
  const auto measured = read_measured(table.text("file"), table.place("file"), problems);
  if (!measured) return std::nullopt;
  GivenShape out{{RC_SHAPE_measured, {}, measured->table.front()}, {}};
  for (std::size_t i = 0; measured->table.size() > 1 && i < measured->table.size(); ++i)
    out.nodes.push_back({measured->wavelength_um[i], {RC_SHAPE_measured, {}, measured->table[i]}});
  return out;
}

/// How its reflectance is spread over directions: by one shape of those with a table, else by Lambert's law. first: of
/// its family, whose table of numbers it shares.
void read_front(const Record& record, Material& out, const Material& first, Problems& problems) {
  for (const ShapeEntry& entry : shape_entries()) {
    if (entry.role != ShapeRole::front) continue;
    const Record* measured = entry.number == RC_SHAPE_measured ? record.table("measured") : nullptr;
    const bool known = measured && first.front.number == entry.number;
    const auto shape = known      ? GivenShape{first.front, first.front_nodes}
                       : measured ? read_measured_shape(*measured, problems)
                                  : read_shape(record, entry, problems);
    if (shape && out.front.number != RC_SHAPE_lambert)
      problems.add(record.place(std::string(entry.name)), "a material reflects by one shape",
                   std::string(shape_entry(out.front.number).name) + " and " + std::string(entry.name), "remove one");
    if (shape) out.front = shape->first, out.front_nodes = shape->nodes;
  }
}

/// A gloss by Fresnel's law.
void read_fresnel(const Record& record, Material& out, Problems& problems) {
  auto index = read_index(record.text("file"), record.place("file"), problems);
  if (!index) return;
  double most = 0;
  for (std::size_t i = 0; i < index->n.value.size(); ++i)
    most = std::max(most, fresnel_mirrored(index->n.value[i], index->k.value[i], 1));
  out.index_n = std::move(index->n), out.index_k = std::move(index->k);
  out.gloss = {RC_SHAPE_gloss, {record.number("roughness"), most, 1}};
}

/// The way of transmitted light, and gloss.
void read_lobes(const Record& record, Material& out, Problems& problems) {
  out.behind.number = find_shape(record.text("transmission"), ShapeRole::behind)->number;
  if (record.given("transmission") && out.transmittance.wavelength_um.empty())
    problems.add(record.place("transmission"), "'transmission' needs a transmittance", "an opaque material",
                 "remove it, or give transmittance");
  std::string first = record.table("fresnel") != nullptr ? "fresnel" : "";
  if (!first.empty()) read_fresnel(*record.table("fresnel"), out, problems);
  for (const ShapeEntry& entry : shape_entries()) {
    const std::string name(entry.name);
    const Record* gloss = entry.role == ShapeRole::gloss ? record.table(name) : nullptr;
    if (gloss == nullptr) continue;
    if (!first.empty()) {
      problems.add(gloss->where, "a material has one gloss", first + " and " + name, "remove one");
      return;
    }
    first = name;
    const std::vector<double>& mirrored = gloss->numbers(std::string(entry.parameters[1].key));
    if (std::none_of(mirrored.begin(), mirrored.end(), [](double value) { return value > 0; })) continue;
    if (const auto shape = read_shape(record, entry, problems))
      out.gloss = shape->first, out.gloss_nodes = shape->nodes;
  }
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
    std::optional<Relief> relief;
    if (record.sound) relief = read_relief(record, problems);
    if (members.empty()) members.emplace_back();  // of its name, so that what names it is not reported again
    const std::size_t before = problems.count();
    for (Material& material : members) {
      if (problems.count() > before) break;  // once for all of a family
      if (record.given("reflectance_beyond") && !material.reflectance.value.empty()) {
        extend(material.reflectance, record.number("reflectance_beyond"));
        extend(material.transmittance, 0);
      }
      if (record.given("reflectance_below") && !material.reflectance.value.empty()) {
        extend_down(material.reflectance, record.number("reflectance_below"));
        extend_down(material.transmittance, 0);
      }
      if (record.sound && !material.reflectance.value.empty()) {
        read_front(record, material, members.front(), problems);
        read_lobes(record, material, problems);
        take_nodes_of_curve(material);
        make_lobes(material);
        check_energy(record, material, problems);
        check_gloss(record, material, problems);
      }
      material.temperature_K = record.given("temperature_K") ? record.number("temperature_K") : default_K;
      material.las_class = static_cast<std::int32_t>(record.integer("las_class"));
      if (record.given("source")) material.source = record.text("source");
    }
    if (name.empty()) continue;
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh) {
      problems.add(record.where, "material '" + name + "' is defined twice", "first in " + place->second.text(),
                   "rename or remove one");
      continue;
    }
    for (const Material& member : members)
      roles_ = std::max<std::uint64_t>(roles_, RC_CURVE_ROLES + member.further.size());
    if (roles_ * (materials_.size() + members.size()) > RC_KEY_MASK) {
      problems.add(record.where, "more spectra than a scene can hold",
                   std::to_string(materials_.size() + members.size()) + " with those of '" + name + "'",
                   "at most " + std::to_string(RC_KEY_MASK / roles_) + ": give smaller families");
      continue;
    }
    if (texture) textures_.emplace(static_cast<std::uint32_t>(materials_.size()), std::move(*texture));
    if (mask) masks_.emplace(static_cast<std::uint32_t>(materials_.size()), std::move(*mask));
    if (relief) reliefs_.emplace(static_cast<std::uint32_t>(materials_.size()), std::move(*relief));
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
  const Relief* relief = this->relief(surface);
  return {lying(textures_), lying(masks_), relief != nullptr && relief->by_coordinates() ? relief : nullptr};
}

const Relief* MaterialTable::relief(std::uint32_t surface) const {
  if (reliefs_.empty()) return nullptr;
  const auto found = reliefs_.find(surfaces_[surface].material[0] - 1);
  return found != reliefs_.end() ? &found->second : nullptr;
}

/// Reports images that what is covered cannot have.
void MaterialTable::check_cover(const std::string& name, std::uint32_t surface, const base::Where& where, Covers covers,
                                Problems& problems) const {
  if (covers == Covers::nothing) return;
  const CoordinateImages images = this->images(surface);
  if (covers != Covers::mesh && images.any()) {
    problems.add(where, "material '" + name + "' lies by the texture coordinates of a mesh, which this is not",
                 images.mask != nullptr      ? "a mask"
                 : images.texture != nullptr ? "a texture without texel_m"
                                             : "a relief without texel_m",
                 images.mask != nullptr      ? "give it to a mesh"
                 : images.texture != nullptr ? "give its texture a texel_m, or the material to a mesh"
                                             : "give its bump or normals a texel_m, or the material to a mesh");
    return;
  }
  const Relief* relief = this->relief(surface);
  if (relief == nullptr || relief->by_coordinates() || covers == Covers::panel) return;
  problems.add(where, "a relief with texel_m lies on planes and faces of boxes alone",
               "material '" + name + "' with texel_m = " + number_text(relief->texel_m()),
               covers == Covers::mesh ? "remove texel_m, for the mesh's texture coordinates to say where it lies"
                                      : "use a material without bump and normals here");
}

std::uint32_t MaterialTable::surface(const std::string& name, const base::Where& where, Problems& problems,
                                     Covers covers) const {
  if (const auto found = index_.find(name); found != index_.end()) {
    check_cover(name, found->second, where, covers, problems);
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
    return scene::reflect_alike(materials_[part.first], materials_[parts.front().first]);
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
