#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/lines/hitran_par.h"
#include "atmos_tables/lines/molecules.h"
#include "atmos_tables/lines/tabulated_absorber.h"
#include "atmos_tables/optics/profile_csv.h"
#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/base/image_orientation.h"
#include "host/base/sha256.h"
#include "host/products/envi_reader.h"
#include "host/products/las_reader.h"
#include "scene_compiler/band_list.h"
#include "scene_compiler/compiled_file.h"
#include "scene_compiler/envi_library.h"
#include "scene_compiler/ies_file.h"
#include "scene_compiler/index_file.h"
#include "scene_compiler/load_simulation.h"
#include "scene_compiler/measured_file.h"
#include "scene_compiler/mesh_file.h"
#include "scene_compiler/raster.h"
#include "scene_compiler/solar_file.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::fuzz {
namespace {

namespace fs = std::filesystem;

void write(const std::string& path, const void* data, std::size_t bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
}
void write(const std::string& path, const std::string& text) { write(path, text.data(), text.size()); }

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Readers that collect problems throw them, as the program does.
template <typename F>
void reported(const F& read) {
  base::Problems problems;
  read(problems);
  problems.throw_if_any();
}

/// A simulation that names the file under test; validated and, for what only compiling reads, compiled.
void in_simulation(const std::string& path, const std::string& text, bool compile) {
  const std::string file = path + ".toml";
  write(file,
        "format = 1\ntime = { sun = { zenith_deg = 30 } }\natmosphere = { model = \"none\" }\nmaterial = [ { name = "
        "\"m\", reflectance = 0.5 } ]\n" +
            text);
  scene::load_simulation(file, {.compile = compile});
}

std::string quoted(const std::string& path) { return "\"" + path + "\""; }

void simulation(const std::string& path) { scene::load_simulation(path, {.compile = false}); }
void spectrum(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_spectrum({.file = path}, p); });
}
void bands(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_band_file(path, "", {}, p); });
}
/// The header; its data are 64 bytes of a ramp.
void envi_library(const std::string& path) {
  const std::string data = path.substr(0, path.size() - std::strlen(".hdr"));
  std::string ramp(64, '\0');
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<char>(i);
  write(data, ramp);
  reported([&](base::Problems& p) { scene::read_envi_library(data, {}, p); });
}
void envi_image(const std::string& path) {
  const std::string data = path.substr(0, path.size() - std::strlen(".hdr"));
  write(data, std::string(64, '\1'));
  const products::EnviReader reader(path);
  reader.header().wavelength_um();
  reader.header().fwhm_um();
  reader.read_lines_scaled(0, 1);
  reader.read_pixel(0, 0);
}
/// Lengths and hash are made right, for else nothing but their check would be reached.
void compiled_scene(const std::string& path) {
  std::string data = content(path);
  constexpr std::size_t kHead = 32, kHash = 32;
  if (data.size() >= kHead + kHash) {
    const std::uint64_t payload = data.size() - kHead - kHash;
    std::memcpy(data.data() + 24, &payload, sizeof payload);
    const auto digest = base::Sha256().add(data.data(), data.size() - kHash).digest();
    std::memcpy(data.data() + data.size() - kHash, digest.data(), kHash);
    write(path, data);
  }
  scene::load_compiled(path);
}
void render_table(const std::string& path) {
  std::string data = content(path);
  constexpr std::size_t kHead = 64;
  if (data.size() >= kHead) {
    const std::uint64_t bytes = data.size();
    std::memcpy(data.data() + 24, &bytes, sizeof bytes);
    const auto digest = base::Sha256().add(data.data() + kHead, data.size() - kHead).digest();
    std::memcpy(data.data() + 32, digest.data(), digest.size());
    write(path, data);
  }
  atmos::read_rct(path);
}
void las(const std::string& path) { products::read_las_info(path); }
void mesh(const std::string& path) {
  reported([&](base::Problems& p) { scene::check_obj_text(content(path), path, p); });
}
void poses(const std::string& path) {
  in_simulation(path,
                "[[instrument]]\nname = \"c\"\nkind = \"pushbroom\"\nposes = " + quoted(path) +
                    "\nifov_mrad = 1.0\npixels = 4\nlines = 2\nbands = { first_nm = 500.0, step_nm = 10.0, count = 1, "
                    "fwhm_nm = 5.0 }\n",
                false);
}
void trajectory(const std::string& path) {
  in_simulation(
      path,
      "[[lidar]]\nname = \"l\"\nprf_khz = 1.0\ntrajectory = " + quoted(path) +
          "\n[lidar.pulse]\nenergy_J = 1e-5\nwavelength_nm = 1064.0\nfwhm_ns = 4.0\ndivergence_mrad = 0.5\n"
          "divergence_is = \"full angle at 1/e^2\"\n[lidar.receiver]\naperture_diameter_m = 0.1\nfov_mrad = 1.0\n"
          "[lidar.gate]\nstart_range_m = 0.0\nstop_range_m = 100.0\nbin_ns = 1.0\n",
      false);
}
void pulse_shape(const std::string& path) {
  in_simulation(path,
                "[[lidar]]\nname = \"l\"\nprf_khz = 1.0\npulses = 1\nposition_m = [0.0, 0.0, "
                "50.0]\n[lidar.pulse]\nenergy_J = 1e-5\n"
                "wavelength_nm = 1064.0\nshape = \"tabulated\"\nzero_at = \"peak\"\nshape_file = " +
                    quoted(path) +
                    "\ndivergence_mrad = 0.5\ndivergence_is = \"full angle at "
                    "1/e^2\"\n[lidar.receiver]\naperture_diameter_m = 0.1\n"
                    "fov_mrad = 1.0\n[lidar.gate]\nstart_range_m = 0.0\nstop_range_m = 100.0\nbin_ns = 1.0\n",
                false);
}
void scatter(const std::string& path) {
  in_simulation(path,
                "mesh = [ { name = \"t\", file = " + quoted(scratch_folder() + "/t.obj") +
                    ", material = \"m\" } ]\nscatter = [ { mesh = \"t\", positions = " + quoted(path) + " } ]\n",
                true);
}
void volume_grid(const std::string& path) {
  in_simulation(path,
                "[[volume]]\nname = \"v\"\nshape = \"grid\"\nvalues = " + quoted(path) +
                    "\ncells = [2, 3, 2]\nsize_m = [4.0, 4.0, 4.0]\ngas = \"methane\"\nconcentration_ppm = 1.0\nline = "
                    "[ { center_per_cm = 3000.0, "
                    "strength_cm = 1e-20, half_width_per_cm = 0.1 } ]\n",
                true);
}
void volume_gas(const std::string& path) {
  in_simulation(path,
                "[[volume]]\nname = \"v\"\nshape = \"box\"\nsize_m = [1.0, 1.0, 1.0]\ngas = "
                "\"methane\"\nconcentration_ppm = 1.0\ncross_section = " +
                    quoted(path) + "\n",
                true);
}
void profile(const std::string& path) { atmos::read_profile_csv(path); }
void line_list(const std::string& path) { atmos::read_hitran_par(path, 0, 1e5); }
void partition_sums(const std::string& path) { atmos::PartitionSums::read_csv(path).ratio(6, 1, 250); }
void cross_section(const std::string& path) {
  atmos::TabulatedAbsorber::read_csv(path).cross_section_cm2({2999.9, 3000.0, 3010.0}, {1000, 290, 0});
}
template <const char* (*Format)()>
void import(const std::string& path) {
  const auto imported = atmos::imported::import_file(path, Format());
  atmos::imported::imported_text(imported);
  atmos::imported::imported_json(imported);
}
/// Output of uvspec with an input of its own: two levels, three directions.
void uvspec(const std::string& path) {
  const std::string input = scratch_folder() + "/uvspec.inp";
  atmos::imported::import_file(path, "uvspec", input);
}
void uvspec_input(const std::string& path) {
  atmos::imported::import_file(scratch_folder() + "/uvspec.out", "uvspec", path);
}

#define RC_FORMAT(function, text) \
  const char* function() { return text; }
RC_FORMAT(tape7, "tape7")
RC_FORMAT(tape6, "tape6")
RC_FORMAT(chn, "chn")
RC_FORMAT(json, "json")
RC_FORMAT(csv, "csv")
RC_FORMAT(acd, "acd")
RC_FORMAT(acd_binary, "acd-binary")
RC_FORMAT(sixs, "6s")
RC_FORMAT(plain_csv, "plain-csv")
#undef RC_FORMAT

void raster(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_raster(path, {.count = 0}, {}, p); });
}
/// The header; its data are 50 bytes.
void raster_header(const std::string& path) {
  const std::string data = path.substr(0, path.size() - std::strlen(".hdr"));
  write(data, std::string(50, '\1'));
  raster(data);
}
void any_mesh(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_mesh_file(path, {}, {}, p); });
}
void lamp(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_ies(path, {}, p); });
}
void index_table(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_index(path, {}, p); });
}
void measured(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_measured(path, {}, p); });
}
void solar(const std::string& path) {
  reported([&](base::Problems& p) { scene::read_solar_spectrum(path, {}, p); });
}
void orientation(const std::string& path) { base::image_orientation(path); }

std::size_t after_cell_size(const std::string& text);
std::size_t after_columns(const std::string& text);
std::size_t after_nine_words(const std::string& text);
std::size_t after_ply_head(const std::string& text);
std::size_t after_additional(const std::string& text);
std::size_t after_tilt(const std::string& text);

constexpr Target kTargets[] = {
    {"simulation", "in.toml", simulation},
    {"spectrum", "in.csv", spectrum},
    {"bands", "in.csv", bands},
    {"envi_library", "in.sli.hdr", envi_library},
    {"envi_image", "in.img.hdr", envi_image},
    {"compiled_scene", "in.rcs", compiled_scene},
    {"render_table", "in.rct", render_table},
    {"las", "in.las", las},
    {"mesh_obj", "in.obj", mesh},
    {"poses", "in.csv", poses},
    {"trajectory", "in.csv", trajectory},
    {"pulse_shape", "in.csv", pulse_shape},
    {"scatter", "in.csv", scatter},
    {"volume_grid", "in.csv", volume_grid},
    {"volume_gas", "in.csv", volume_gas},
    {"profile", "in.csv", profile},
    {"line_list", "in.par", line_list},
    {"partition_sums", "in.csv", partition_sums},
    {"cross_section", "in.csv", cross_section},
    {"import_tape7", "in.tp7", import <tape7>},
    {"import_tape6", "in.tp6", import <tape6>},
    {"import_chn", "in.chn", import <chn>},
    {"import_json", "in.json", import <json>},
    {"import_csv", "in.csv", import <csv>},
    {"import_acd", "in.acd", import <acd>},
    {"import_acd_binary", "in.acd", import <acd_binary>},
    {"import_6s", "in.txt", import <sixs>},
    {"import_plain_csv", "in.csv", import <plain_csv>},
    {"import_uvspec", "in.out", uvspec},
    {"import_uvspec_input", "in.inp", uvspec_input},
    {"spectrum_ecostress", "in.txt", spectrum, after_additional},
    {"spectrum_splib06", "in.asc", spectrum},
    {"spectrum_asd_text", "in.txt", spectrum},
    {"spectrum_asd", "in.asd", spectrum},
    {"spectrum_svc", "in.sig", spectrum},
    {"lamp_ies", "in.ies", lamp, after_tilt},
    {"refractive_index", "in.csv", index_table},
    {"measured", "in.csv", measured},
    {"solar", "in.csv", solar},
    {"orientation", "in.tif", orientation},
    {"mesh_ply", "in.ply", any_mesh, after_ply_head},
    {"mesh_any_obj", "in.obj", any_mesh, nullptr, true},
    {"mesh_gltf", "in.gltf", any_mesh, nullptr, true},
    {"mesh_collada", "in.dae", any_mesh, nullptr, true},
    {"mesh_stl", "in.stl", any_mesh, nullptr, true},
    {"mesh_off", "in.off", any_mesh, nullptr, true},
    {"mesh_dxf", "in.dxf", any_mesh, nullptr, true},
    {"raster_esri", "in.asc", raster, after_cell_size, true},
    {"raster_grass", "in.asc", raster, after_columns, true},
    {"raster_surfer", "in.grd", raster, after_nine_words, true},
    {"raster_envi", "in.dat.hdr", raster_header, nullptr, true},
    {"raster_vrt", "in.vrt", raster, nullptr, true},
    {"raster_tiff", "in.tif", raster, nullptr, true},
    {"raster_png", "in.png", raster, nullptr, true},
    {"raster_jpeg", "in.jpg", raster, nullptr, true},
};

/// Files that targets need beside the one under test.
void write_companions(const std::string& folder) {
  write(folder + "/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n");
  write(folder + "/uvspec.inp",
        "source solar\nwavelength 500 501\nsza 30\nphi0 0\nzout 0 TOA\numu -1 0.5 1\nphi 0 90\nrte_solver disort\n");
  write(folder + "/grid.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n");
  write(folder + "/uvspec.out", " 500.000  1.0e+02  2.0e+01  3.0e+00  1.0e+01  2.0e+00  3.0e-01 \n");
}

/// Where bodies of texts begin: behind the first line that ends a head.
std::size_t behind(const std::string& text, const std::string& mark) {
  const auto at = text.find(mark);
  return at == std::string::npos ? at : text.find('\n', at);
}
std::size_t after_cell_size(const std::string& text) { return behind(text, "cellsize"); }
std::size_t after_columns(const std::string& text) { return behind(text, "cols:"); }
std::size_t after_nine_words(const std::string& text) {
  std::size_t at = 0;
  for (int line = 0; line < 5 && at != std::string::npos; ++line) at = text.find('\n', at + (line > 0));
  return at;
}
std::size_t after_ply_head(const std::string& text) {
  return text.find("format ascii") == std::string::npos ? std::string::npos : behind(text, "end_header");
}
std::size_t after_additional(const std::string& text) { return behind(text, "Additional Information"); }
std::size_t after_tilt(const std::string& text) { return behind(text, "TILT="); }

struct Scratch {
  std::string path;
  pid_t owner = ::getpid();
  Scratch() {
    const fs::path root = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    path = (root / ("raycube-fuzz-" + std::to_string(owner))).string();
    fs::create_directories(path);
    write_companions(path);
  }
  ~Scratch() {
    std::error_code ignored;
    if (owner == ::getpid()) fs::remove_all(path, ignored);
  }
};

}  // namespace

std::span<const Target> targets() { return kTargets; }

const Target* find_target(const std::string& name) {
  for (const Target& target : kTargets)
    if (name == target.name) return &target;
  return nullptr;
}

const std::string& scratch_folder() {
  static const Scratch scratch;
  return scratch.path;
}

void remove_scratch() {
  std::error_code ignored;
  fs::remove_all(scratch_folder(), ignored);
}

bool feed(const Target& target, const std::uint8_t* data, std::size_t bytes) {
  const std::string path = scratch_folder() + "/" + target.file;
  write(path, data, bytes);
  try {
    target.read(path);
    return true;
  } catch (const base::Error& error) {
    if (error.fault() == base::Fault::bug) throw;
    return false;
  }
}

}  // namespace raycube::fuzz
