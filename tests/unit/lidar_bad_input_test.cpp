// Bad input of [[lidar]] tables: one clear message per fault, all faults of a file in one run.
#include <vector>

#include "tests/unit/lidar_files.h"

using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

struct Fault {
  std::map<std::string, std::string> parts;
  std::string says;
};

const std::string kPlace = "position_m = [0, 0, 1000]\nprf_khz = 10\n";
const std::string kDivergence = "divergence_mrad = 0.5\ndivergence_is = \"full angle at 1/e^2\"\n";
const std::string kAperture = "aperture_diameter_m = 0.1\n";
const std::string kArray = "array = { columns = 4, rows = 4, pitch_um = 50, focal_length_mm = 400 }\n";

}  // namespace

TEST_CASE("bad input, LIDAR: one message per fault, with the place and the way out") {
  const Folder folder;
  folder.write("negative.csv", "time_ns,power\n0,0\n1,-2\n2,0\n");
  folder.write("backwards.csv", "time_s,x_m,y_m,z_m\n1,0,0,9\n1,0,0,9\n");
  folder.write("extra.csv", "time_s,x_m,y_m,z_m,yaw\n1,0,0,9,0\n");
  const std::string tabulated = "energy_J = 1\nwavelength_nm = 532\n" + kDivergence + "shape = \"tabulated\"\n";
  const std::vector<Fault> faults = {
      {{{"pulse", std::string(kBeam) + "divergence_mrad = 0.5\n"}},
       "a divergence without its definition says nothing (found 0.5 mrad); add divergence_is"},
      {{{"pulse", std::string(kBeam)}}, "'divergence_mrad' is missing in [lidar.pulse]"},
      {{{"pulse", std::string(kBeam) + "divergence_mrad = 0.5\ndivergence_is = \"full angle\"\n"}},
       "'divergence_is' wants one of full angle at 1/e^2"},
      {{{"pulse", std::string(kBeam) + "divergence_mrad = 0.5\ndivergence_is = \"half angle edge\"\n"}},
       "a Gaussian beam has no edge"},
      {{{"pulse", std::string(kBeam) + kDivergence + "profile = \"uniform\"\n"}}, "a uniform beam has edges alone"},
      {{{"pulse", std::string(kBeam) + kDivergence + "exit_diameter_mm = 5\n"}},
       "a diameter without its definition says nothing"},
      {{{"pulse", std::string(kBeam) + "divergence_mrad = 2990\ndivergence_is = \"half angle at 1/e^2\"\n"}},
       "above 1.4 rad"},
      {{{"pulse", tabulated + "zero_at = \"peak\"\n"}}, "'shape_file' is missing for shape = \"tabulated\""},
      {{{"pulse", tabulated + "shape_file = \"negative.csv\"\n"}}, "'zero_at' is missing for shape = \"tabulated\""},
      {{{"pulse", tabulated + "shape_file = \"negative.csv\"\nzero_at = \"peak\"\n"}},
       "negative.csv:3: column 'power': power is negative (found -2)"},
      {{{"pulse", "energy_J = 1\n" + kDivergence + "fwhm_ns = 4\n"}},
       "'wavelength_nm' is missing for a pulse without [[lidar.pulse.line]]"},
      {{{"pulse", "wavelength_nm = 3300\nfwhm_ns = 4\n" + kDivergence +
                      "line = [{ name = \"on\", wavelength_nm = 3300, energy_J = 1 }]\n"}},
       "'wavelength_nm' means nothing for a pulse with [[lidar.pulse.line]]"},
      {{{"pulse", kDivergence + "fwhm_ns = 4\nline = [{ name = \"on\", wavelength_nm = 3300, energy_J = 1 }, { name = "
                                "\"on\", wavelength_nm = 3301, energy_J = 1 }]\n"}},
       "two lines of a pulse have one name"},
      {{{"pulse", "energy_J = 1\nwavelength_nm = 532\n" + kDivergence}},
       "'fwhm_ns' is missing for shape = \"gaussian\""},
      {{{"receiver", kAperture + kArray + "fov_mrad = 1\n"}},
       "receiver needs exactly one of fov_mrad and array (found both)"},
      {{{"receiver", kAperture}}, "receiver needs exactly one of fov_mrad and array (found neither)"},
      {{{"receiver", kAperture + "fov_mrad = 1\nobscuration_diameter_m = 0.1\n"}},
       "the obscuration covers the aperture (found 0.1 m of 0.1 m)"},
      {{{"receiver", kAperture + "fov_mrad = 1\ncamera_factor = \"tangent\"\n"}}, "needs the focal length"},
      {{{"receiver", kAperture + "fov_mrad = 1\ntilt_along_deg = 1\ntilt_along_mrad = 17\n"}},
       "'tilt_along_deg' and 'tilt_along_mrad' exclude each other"},
      {{{"receiver", kAperture + kArray}, {"sampling", "bounces = 3\n"}},
       "sampling from the receiver follows one scattering (found 3 bounces)"},
      {{{"receiver", kAperture + "array = { columns = 1, rows = 1, pitch_um = 50, focal_length_mm = 400 }\n"}},
       "an array has at least two pixels (found 1 x 1); give fov_mrad"},
      {{{"sampling", "from = \"receiver\"\n"}},
       "sampling from the receiver samples the pixels of an array (found a single round detector (fov_mrad)); set from "
       "= \"transmitter\""},
      {{{"gate", "bins = 0\n"}}, "'bins' is out of range (found 0)"},
      {{{"gate", "start_range_m = 900\nstop_range_m = 800\n"}}, "the gate is empty: it stops before it starts"},
      {{{"gate", "start_ns = -500\nbins = 100\n"}},
       "the gate is empty: it ends before light from minimum_range_m is back"},
      {{{"gate", "bin_ns = 2\n"}}, "gate needs exactly one of bins and stop_range_m (found neither)"},
      {{{"gate", "bins = 10\nstart_ns = 1\nstart_range_m = 1\n"}}, "'start_ns' and 'start_range_m' exclude each other"},
      {{{"top", kPlace + "pulses = 1\nfold_ambiguous = true\n"}}, "'fold_ambiguous' needs more than one pulse"},
      {{{"top", kPlace}}, "LIDAR needs exactly one of pulses and duration_s (found none)"},
      {{{"top", kPlace + "pulses = 5\nduration_s = 1\n"}}, "'pulses' and 'duration_s' exclude each other"},
      {{{"top", kPlace + "duration_s = 1e-6\n"}}, "the time fired for holds no pulse"},
      {{{"top", "prf_khz = 1\npulses = 5\n"}},
       "LIDAR needs exactly one of altitude_agl_m, position_m, trajectory (found 0)"},
      {{{"top", kPlace + "pulses = 5\nlook_at_m = [0, 0, 0]\nspeed_m_s = 3\n"}},
       "'speed_m_s' means nothing for a platform with look_at_m"},
      {{{"top", "trajectory = \"backwards.csv\"\nprf_khz = 1\npulses = 3\n"}},
       "backwards.csv:3: column 'time_s': times must ascend"},
      {{{"top", "trajectory = \"extra.csv\"\nprf_khz = 1\npulses = 3\n"}}, "unknown column (found 'yaw')"},
      {{{"top", "trajectory = \"none.csv\"\nprf_khz = 1\npulses = 3\n"}}, "cannot read file (found none.csv)"},
      {{{"scan", "pattern = \"palmer\"\nrate_hz = 10\n"}}, "'half_angle_deg' is missing for pattern = \"palmer\""},
      {{{"scan", "pattern = \"fixed\"\nrate_hz = 10\n"}}, "'rate_hz' means nothing for pattern = \"fixed\""},
      {{{"scan", "pattern = \"line\"\nrate_hz = 10\nhalf_angle_deg = 120\n"}},
       "'half_angle_deg' is out of range for pattern = \"line\" (found 120)"},
      {{{"scan", "pattern = \"raster\"\ncolumns = 1000\nrows = 2\nstep_deg = 1\n"}},
       "the raster reaches beyond 89 degrees"},
      {{{"turbulence", "profile = \"constant\"\n"}}, "'cn2' is missing for profile = \"constant\""},
      {{{"turbulence", "cn2 = 1e-14\n"}}, "'cn2' means nothing for profile = \"none\""},
      {{{"detector", "gain = 20\n"}}, "'gain' means nothing for mode = \"photons\""},
      {{{"detector", "mode = \"linear\"\ndead_time_ns = 20\n"}}, "'dead_time_ns' means nothing for mode = \"linear\""},
      {{{"detector", "solar_background = true\n"}}, "background light needs the sun's place (found no [time])"},
      {{{"sampling", "range_limit_m = 0.05\n"}}, "'range_limit_m' is not above minimum_range_m"},
      {{{"sampling", "rays = 3\n"}}, "unknown key in [lidar.sampling] (found 'rays')"},
  };
  for (const auto& fault : faults) {
    const std::string message = refusal(folder, lidar_text(fault.parts));
    CHECK_SAYS(message, fault.says);
    CHECK_MESSAGE(line_count(message) == 1, message);
  }
  CHECK(faults.size() >= 15);
}

TEST_CASE("bad input, LIDAR: names are unique over instruments and LIDARs, and fit a folder") {
  const Folder folder;
  const std::string second =
      "[[lidar]]\nname = \"l\"\nposition_m = [0, 0, 1000]\nprf_khz = 10\npulses = 100\n[lidar.pulse]\n" +
      std::string(kBeam) + kDivergence +
      "[lidar.receiver]\naperture_diameter_m = 0.1\nfov_mrad = 1\n[lidar.gate]\nbins = 10\n";
  CHECK_SAYS(refusal(folder, lidar_text() + second), "the name 'l' is taken (found first in scene.toml:2:1)");
  std::string odd = lidar_text();
  odd.replace(odd.find("\"l\""), 3, "\"a/b\"");
  CHECK_SAYS(refusal(folder, odd), "a LIDAR's name is a folder's (found 'a/b')");
}

TEST_CASE("bad input, LIDAR: every fault of a file is reported in one run") {
  const Folder folder;
  const std::string message =
      refusal(folder, lidar_text({{"top", "prf_khz = 10\npulses = 3\n"},
                                  {"pulse", std::string(kBeam) + "divergence_mrad = 1\nexit_diameter_mm = 3\n"},
                                  {"receiver", kAperture + "obscuration_diameter_m = 0.2\n"},
                                  {"gate", "bin_ns = -1\nbins = 3\n"},
                                  {"turbulence", "profile = \"constant\"\n"}}));
  for (const char* part :
       {"exactly one of altitude_agl_m", "a divergence without", "a diameter without", "the obscuration covers",
        "fov_mrad and array", "'bin_ns' is out of range", "'cn2' is missing"})
    CHECK_SAYS(message, part);
  CHECK(line_count(message) == 7);
}

TEST_CASE("a file that looks at nothing names both ways to look") {
  const Folder folder;
  LoadOptions options;
  options.need_instruments = true;
  CHECK_THROWS_WITH_AS(load(folder, kHead, options),
                       doctest::Contains("no [[instrument]] or [[lidar]] looks at the scene"), raycube::base::Error);
}
