#include "atmos_tables/import/uvspec_unit.h"

#include <filesystem>

#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

/// The files of libRadtran's data/solar_flux by how their names begin.
bool in_mW_per_nm(const std::string& name) {
  for (const char* known :
       {"kurudz", "kurucz", "atlas_plus_modtran", "atlas2", "atlas3", "apm_", "NewGuey2003", "Thekaekara"})
    if (name.rfind(known, 0) == 0) return true;
  return false;
}

bool starts(const std::string& text, const char* with) { return text.rfind(with, 0) == 0; }

class Unit {
 public:
  explicit Unit(const UvspecAsked& asked) : asked_(asked) {}

  UvspecTold told() {
    process();
    if (asked_.quantity != UvspecQuantity::radiometric) {
      told_.unit.per = summed() ? UvspecPer::all : UvspecPer::nm;
      return told_;
    }
    if (told_.problem.empty()) asked_.thermal ? thermal() : solar();
    if (told_.problem.empty()) filtered();
    return told_;
  }

 private:
  bool reptran() const { return asked_.gases.empty() || starts(asked_.gases, "reptran"); }
  /// Gases whose spectrum is not made of bands.
  bool spectral() const { return reptran() || asked_.gases == "lowtran" || asked_.gases == "crs"; }
  bool summed() const { return asked_.process == "integrate" || asked_.process == "sum"; }
  void refuse(const std::string& problem, const std::string& found, const std::string& way_out) {
    told_.problem = problem, told_.found = found, told_.way_out = way_out;
  }

  /// The density that output_process asks for, or `standing` where it asks for none.
  UvspecPer per(UvspecPer standing) const {
    if (asked_.process == "per_nm") return UvspecPer::nm;
    if (asked_.process == "per_cm-1") return UvspecPer::cm;
    if (asked_.process == "per_band") return UvspecPer::band;
    return summed() ? UvspecPer::all : standing;
  }

  void process() {
    if (asked_.process == "sum" && spectral() && !reptran() && asked_.quantity != UvspecQuantity::brightness)
      refuse("a sum over wavelengths is an integral only where the numbers are per band", "output_process sum",
             "run uvspec with output_process integrate");
    else if (asked_.process == "per_band" && !asked_.thermal && spectral() && !reptran())
      refuse("uvspec has no bands here", "output_process per_band with mol_abs_param " + asked_.gases,
             "run uvspec with output_process per_nm");
    else if (!asked_.filter.empty() && !summed())
      refuse("each number is multiplied by the filter function", "filter_function_file " + asked_.filter,
             "run uvspec without it, or with output_process integrate");
  }

  void thermal() {
    told_.unit.power = UvspecPower::W;
    const bool bands = !spectral() || (!reptran() && asked_.thermal_bands);
    if (!asked_.file_unit.empty())
      refuse("the unit of thermal light is uvspec's own, not that of a file", "source thermal " + asked_.file_unit,
             "give the unit by output_process");
    told_.unit.per = per(bands ? UvspecPer::band : UvspecPer::cm);
  }

  void solar() {
    const std::string name = std::filesystem::path(asked_.solar_file).filename().string();
    if (!spectral())
      own_bands();
    else if (name.empty())
      no_file();
    else if (!asked_.file_unit.empty() && asked_.file_unit != "per_nm")
      refuse("the unit of the output is that of the solar file, which is none of libRadtran's spectra per nm",
             name + " " + asked_.file_unit, kNameAFile);
    else if (starts(name, "atlas_plus_modtran_ph"))
      told_.unit = {UvspecPower::photons, per(UvspecPer::nm)};
    else if (in_mW_per_nm(name))
      told_.unit = {UvspecPower::mW, per(UvspecPer::nm)};
    else
      refuse("the unit of the output is that of the solar file, which is not known", name, kNameAFile);
    if (told_.problem.empty() && told_.unit.power == UvspecPower::photons && told_.unit.per != UvspecPer::nm)
      refuse("photons are read per nm only", "output_process " + asked_.process,
             "run uvspec with atlas_plus_modtran, which is in mW");
  }

  /// kato, fu: bands of solar files of their own, in W m-2. The file of avhrr_kratz states no unit that is known here.
  void own_bands() {
    if (!starts(asked_.gases, "kato") && asked_.gases != "fu")
      refuse("the unit of the solar file of this mol_abs_param is not known", asked_.gases,
             "run uvspec with mol_abs_param reptran, or with output_quantity transmittance");
    told_.unit = {UvspecPower::W, per(UvspecPer::band)};
  }

  void no_file() {
    if (!reptran())
      refuse("uvspec needs a solar file with this mol_abs_param", asked_.gases, kNameAFile);
    else
      told_.unit = {UvspecPower::mW, per(UvspecPer::nm)}, told_.sun_of_reptran = true;
  }

  void filtered() {
    if (asked_.filter.empty()) return;
    if (asked_.filter_normalized && asked_.thermal) {
      refuse("a filter is normalized over wavelengths, thermal light integrated over wavenumbers", asked_.filter,
             "run uvspec without `normalize`");
    } else if (asked_.filter_normalized) {
      told_.unit.per = UvspecPer::nm;
      told_.note = "means over the filter function " + asked_.filter;
    } else {
      told_.note = "integrals over the filter function " + asked_.filter;
    }
  }

  static constexpr const char* kNameAFile =
      "name kurudz_1.0nm.dat, atlas_plus_modtran, NewGuey2003.dat or another of libRadtran's data/solar_flux in "
      "`source "
      "solar`, or ask for output_quantity transmittance";
  const UvspecAsked& asked_;
  UvspecTold told_;
};

}  // namespace

UvspecTold uvspec_unit(const UvspecAsked& asked) { return Unit(asked).told(); }

}  // namespace raycube::atmos::imported
