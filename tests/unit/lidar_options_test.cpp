// [[lidar]] tables: every key arrives in SI units, every width by its definition.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/lidar_files.h"
#include "scene_compiler/lidar_builder.h"

using namespace raycube::scene;
using namespace raycube::scene::testing;
using doctest::Approx;

namespace {

Approx exactly(double value) { return Approx(value).epsilon(1e-12); }

}  // namespace

TEST_CASE("S27 LIDAR.md 2.1: every definition of a Gaussian's width, against the encircled energy it stands for") {
  // F(r) = 2E/(pi w^2) exp(-2 r^2/w^2), so the share within r is 1 - exp(-2 r^2/w^2): the four radii hold these shares.
  const auto share = [](const char* definition) {
    return 1 - std::exp(-2 / std::pow(*beam_width_factor(definition), 2));
  };
  CHECK(share("1 sigma") == exactly(1 - std::exp(-0.5)));
  CHECK(share("FWHM") == exactly(0.5));
  CHECK(share("1/e") == exactly(1 - std::exp(-1.0)));
  CHECK(share("1/e^2") == exactly(1 - std::exp(-2.0)));
  // The specification's table, six figures.
  CHECK(1 / *beam_width_factor("1 sigma") == Approx(0.5).epsilon(1e-6));
  CHECK(1 / *beam_width_factor("FWHM") == Approx(0.588705).epsilon(1e-6));
  CHECK(1 / *beam_width_factor("1/e") == Approx(0.707107).epsilon(1e-6));
  CHECK(*beam_width_factor("edge") == 1);
  CHECK(!beam_width_factor("1 %"));

  // One beam of 1 mrad half angle at 1/e^2, told in every way.
  CHECK(*half_divergence(2.0, "full angle at 1/e^2") == exactly(1));
  CHECK(*half_divergence(1.0, "half angle at 1/e^2") == exactly(1));
  CHECK(*half_divergence(std::sqrt(2.0), "full angle at 1/e") == exactly(1));
  CHECK(*half_divergence(std::sqrt(0.5), "half angle at 1/e") == exactly(1));
  CHECK(*half_divergence(std::sqrt(2 * std::log(2.0)), "full angle FWHM") == exactly(1));
  CHECK(*half_divergence(std::sqrt(std::log(2.0) / 2), "half angle FWHM") == exactly(1));
  CHECK(*half_divergence(1.0, "full angle 1 sigma") == exactly(1));
  CHECK(*half_divergence(0.5, "half angle 1 sigma") == exactly(1));
  CHECK(*half_divergence(2.0, "full angle edge") == exactly(1));
  CHECK(*half_divergence(1.0, "half angle edge") == exactly(1));
  CHECK(!half_divergence(1.0, "full width"));
  CHECK(!half_divergence(1.0, "1/e^2"));
}

TEST_CASE("S27: the option table offers no definition that is not converted") {
  const auto each = [](const char* table, const char* key, auto check) {
    std::string rest(find_key(table, key)->shape);
    for (std::size_t bar = 0; bar != std::string::npos; rest.erase(0, bar + 1)) {
      bar = rest.find('|');
      check(rest.substr(0, bar));
      if (bar == std::string::npos) break;
    }
  };
  each("lidar.pulse", "divergence_is",
       [](const std::string& is) { CHECK_MESSAGE(half_divergence(1, is).has_value(), is); });
  each("lidar.pulse", "exit_is", [](const std::string& is) { CHECK_MESSAGE(beam_width_factor(is).has_value(), is); });
}

TEST_CASE("S27: the smallest LIDAR, no instrument beside it, gets its defaults") {
  const Folder folder;
  LoadOptions options;
  options.need_instruments = true;
  const auto simulation = load(folder, lidar_text(), options);
  CHECK(simulation.instruments.empty());
  REQUIRE(simulation.lidars.size() == 1);
  const Lidar& l = simulation.lidars[0];
  CHECK(l.name == "l");
  CHECK(l.prf_hz == exactly(1e4));
  CHECK(l.pulses == 100);
  REQUIRE(l.trajectory.size() == 1);
  CHECK(l.trajectory[0].z_m == 1000);
  REQUIRE(l.pulse.lines.size() == 1);
  CHECK(l.pulse.lines[0].wavelength_um == exactly(1.064));
  CHECK(l.pulse.half_divergence_rad == exactly(0.25e-3));
  CHECK(l.pulse.fwhm_s == exactly(4e-9));
  CHECK(l.receiver.aperture_radius_m == exactly(0.05));
  CHECK(l.receiver.half_fov_rad == exactly(0.5e-3));
  CHECK(l.gate.bins == 8000);
  CHECK(l.gate.bin_s == exactly(1e-9));
  CHECK(l.transport.sampling == LidarSampling::transmitter);
  CHECK(l.transport.overlap == LidarOverlap::exact);
  CHECK(l.turbulence.profile == TurbulenceProfile::none);
  CHECK_FALSE(l.speckle.on);
  CHECK_FALSE(l.detector.solar_background);  // no [time]
  CHECK(l.echoes.method == EchoMethod::gaussian);
  CHECK(l.products.las);

  const auto json = nlohmann::json::parse(simulation.resolved_json)["lidar"][0];
  CHECK(json["pulse"]["divergence_is"] == "full angle at 1/e^2");
  CHECK_FALSE(l.transport.subrays_given);   // left to the planner
  CHECK(json["sampling"]["bounces"] == 1);  // of a table the file does not name
  CHECK(json["turbulence"]["wind_m_s"] == 21);
  CHECK(json["scan"]["pattern"] == "fixed");
}

namespace {

/// Every key of a LIDAR that samples from the transmitter and detects linearly.
constexpr const char* kEveryKey = R"(format = 1
time = { sun = { zenith_deg = 40 } }
[[plane]]
material = "grey"
size_m = [4000, 4000]
position_m = [0, 0, 50]
[[material]]
name = "grey"
reflectance = 0.5
[[instrument]]
name = "camera"
kind = "framing"
pixels = 2
lines = 2
position_m = [0, 0, 100]
ifov_mrad = 1
bands = { first_nm = 500, step_nm = 10, count = 1, fwhm_nm = 10 }
[[lidar]]
name = "dial-1"
altitude_agl_m = 800
center_m = [10, -20]
speed_m_s = 60
heading_deg = 90
pitch_deg = 1
roll_deg = -2
prf_khz = 0.5
duration_s = 2
first_pulse_s = 100
gps_start_s = 4.5e8
strip = 17
fold_ambiguous = true
[lidar.pulse]
separation_s = 1e-4
profile = "gaussian"
exit_diameter_mm = 10
exit_is = "1/e"
divergence_mrad = 1
divergence_is = "full angle FWHM"
shape = "rectangular"
length_ns = 7
transmit_efficiency = 0.9
[[lidar.pulse.line]]
name = "on"
wavelength_nm = 3300
fwhm_nm = 0.1
energy_J = 0.02
[[lidar.pulse.line]]
name = "off"
wavelength_nm = 3310
energy_J = 0.03
[lidar.scan]
pattern = "oscillating"
rate_hz = 40
half_angle_deg = 15
[lidar.transmitter]
offset_m = [0.5, 1, -0.25]
tilt_along_mrad = 2
tilt_across_deg = 3
[lidar.receiver]
offset_m = [-0.5, 0, 0]
tilt_along_deg = 1
tilt_across_mrad = -4
aperture_diameter_m = 0.2
obscuration_diameter_m = 0.08
fov_mrad = 0.4
focal_length_mm = 400
focus_m = 500
efficiency = 0.5
quantum_efficiency = 0.3
filter_fwhm_nm = 2
camera_factor = "tangent"
scans_with_beam = false
[lidar.gate]
start_range_m = 600
stop_range_m = 900
bin_ns = 2
[lidar.sampling]
from = "transmitter"
subrays = 1024
bounces = 4
line_nodes = 64
group_index = 1.0002
overlap = "off"
air_return = false
minimum_range_m = 5
range_limit_m = 2000
[lidar.turbulence]
profile = "constant"
cn2 = 1e-14
spread = false
wander = false
scintillation = false
blur = false
broadening = false
outer_scale_m = 3
wander_convention = "andrews"
[lidar.speckle]
on = true
polarization_modes = 1
[lidar.detector]
mode = "linear"
dark_rate_hz = 1e5
solar_background = true
gain = 20
ionization_ratio = 0.2
readout_noise_e = 300
response_fwhm_ns = 3
bits = 12
full_scale_e = 1e4
[lidar.echoes]
method = "constant_fraction"
threshold_sigma = 5
threshold_pe = 3
fraction = 0.4
max_returns = 6
[lidar.products]
waveforms = false
cube = false
las = false
csv = false
png = false
laz = true
internal_waveforms = true
orders = true
)";

Lidar lidar_of_every_key() {
  const Folder folder;
  return load(folder, kEveryKey).lidars.at(0);
}

}  // namespace

TEST_CASE("S27 to S41: a file with every key of a LIDAR is one LIDAR and nothing to notice") {
  const Folder folder;
  const auto simulation = load(folder, kEveryKey);
  CHECK(simulation.notices.empty());
  CHECK(simulation.lidars.size() == 1);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the platform, its clock and its path") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.pulses == 1000);
  CHECK(l.first_pulse_s == 100);
  CHECK(l.gps_start_s == 4.5e8);
  CHECK(l.strip == 17);
  CHECK(l.fold_ambiguous);
  // 999 periods of 2 ms at 60 m/s, east, centred over (10, -20); the height counts from z = 0: a plane is no terrain.
  REQUIRE(l.trajectory.size() == 2);
  CHECK(l.trajectory[0].x_m == exactly(10 - 0.5 * 60 * 999 * 0.002));
  CHECK(l.trajectory[1].x_m == exactly(10 + 0.5 * 60 * 999 * 0.002));
  CHECK(l.trajectory[1].y_m == exactly(-20));
  CHECK(l.trajectory[1].z_m == 800);
  CHECK(l.trajectory[0].time_s == 100);
  CHECK(l.trajectory[1].time_s == exactly(100 + 999 * 0.002));
  CHECK(l.trajectory[0].roll_deg == -2);
  CHECK(l.trajectory[1].pitch_deg == 1);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the pulse and its lines") {
  const Lidar l = lidar_of_every_key();
  REQUIRE(l.pulse.lines.size() == 2);
  CHECK(l.pulse.lines[0].name == "on");
  CHECK(l.pulse.lines[0].fwhm_um == exactly(1e-4));
  CHECK(l.pulse.lines[1].wavelength_um == exactly(3.31));
  CHECK(l.pulse.lines[1].energy_J == 0.03);
  CHECK(l.pulse.separation_s == 1e-4);
  CHECK(l.pulse.exit_radius_m == exactly(0.005 * std::sqrt(2.0)));
  CHECK(l.pulse.half_divergence_rad == exactly(0.5e-3 * std::sqrt(2 / std::log(2.0))));
  CHECK(l.pulse.shape == PulseShape::rectangular);
  CHECK(l.pulse.fwhm_s == exactly(7e-9));
  CHECK(l.pulse.transmit_efficiency == 0.9);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the scan and the mounts") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.scan.pattern == ScanPattern::oscillating);
  CHECK(l.scan.scan_rate_hz == 40);
  CHECK(l.scan.half_angle_rad == exactly(15 * M_PI / 180));
  CHECK(l.transmitter.offset_m[0] == 0.5);
  CHECK(l.transmitter.offset_m[2] == -0.25);
  CHECK(l.transmitter.tilt_along_rad == exactly(2e-3));
  CHECK(l.transmitter.tilt_across_rad == exactly(3 * M_PI / 180));
  CHECK(l.receiver_mount.offset_m[0] == -0.5);
  CHECK(l.receiver_mount.tilt_along_rad == exactly(M_PI / 180));
  CHECK(l.receiver_mount.tilt_across_rad == exactly(-4e-3));
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the receiver") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.receiver.aperture_radius_m == exactly(0.1));
  CHECK(l.receiver.obscuration_radius_m == exactly(0.04));
  CHECK(l.receiver.half_fov_rad == exactly(0.2e-3));
  CHECK(l.receiver.focal_length_m == exactly(0.4));
  CHECK(l.receiver.focus_m == 500);
  CHECK(l.receiver.efficiency == 0.5);
  CHECK(l.receiver.quantum_efficiency == 0.3);
  CHECK(l.receiver.filter_fwhm_um == exactly(2e-3));
  CHECK(l.receiver.tangent_aperture);
  CHECK_FALSE(l.receiver.scans_with_beam);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the gate and the sampling") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.gate.start_s == exactly(2 * 1.0002 * 600 / 299792458.0));
  CHECK(l.gate.bin_s == exactly(2e-9));
  CHECK(l.gate.bins == 1001);  // 2 * 1.0002 * 300 m / c = 2001.79 ns
  CHECK(l.transport.subrays == 1024);
  CHECK(l.transport.max_bounces == 4);
  CHECK(l.transport.line_nodes == 64);
  CHECK(l.transport.group_index == 1.0002);
  CHECK(l.transport.overlap == LidarOverlap::off);
  CHECK_FALSE(l.transport.air_return);
  CHECK(l.transport.minimum_range_m == 5);
  CHECK(l.transport.range_limit_m == 2000);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: turbulence and speckle") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.turbulence.profile == TurbulenceProfile::constant);
  CHECK(l.turbulence.cn2 == 1e-14);
  CHECK_FALSE((l.turbulence.spread || l.turbulence.wander || l.turbulence.scintillation || l.turbulence.blur ||
               l.turbulence.broadening));
  CHECK(l.turbulence.outer_scale_m == 3);
  CHECK(l.turbulence.andrews_wander);
  CHECK(l.speckle.on);
  CHECK(l.speckle.polarization_modes == 1);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: the detector") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.detector.mode == DetectorMode::linear);
  CHECK(l.detector.dark_rate_hz == 1e5);
  CHECK(l.detector.solar_background);
  CHECK(l.detector.gain == 20);
  CHECK(l.detector.ionization_ratio == 0.2);
  CHECK(l.detector.readout_noise_e == 300);
  CHECK(l.detector.response_fwhm_s == exactly(3e-9));
  CHECK(l.detector.bits == 12);
  CHECK(l.detector.full_scale_e == 1e4);
}

TEST_CASE("S27 to S41: every key of a LIDAR, each in SI units: echoes and products") {
  const Lidar l = lidar_of_every_key();
  CHECK(l.echoes.method == EchoMethod::constant_fraction);
  CHECK(l.echoes.threshold_sigma == 5);
  CHECK(l.echoes.threshold_pe == 3);
  CHECK(l.echoes.fraction == 0.4);
  CHECK(l.echoes.max_returns == 6);
  CHECK_FALSE((l.products.waveforms || l.products.cube || l.products.las || l.products.csv || l.products.png));
  CHECK((l.products.laz && l.products.internal_waveforms && l.products.orders));
}

TEST_CASE("S27: an array samples from the receiver, a Geiger detector has its keys, Hufnagel-Valley its own") {
  const Folder folder;
  const auto simulation = load(
      folder,
      lidar_text(
          {{"receiver",
            "aperture_diameter_m = 0.2\narray = { columns = 128, rows = 64, pitch_um = 50, focal_length_mm = 400 }\n"},
           {"detector",
            "mode = \"geiger\"\ndead_time_ns = 50\njitter_fwhm_ns = 0.3\nafterpulse_probability = "
            "0.01\nafterpulse_time_ns = 80\ncells = 4\n"},
           {"turbulence", "profile = \"hufnagel_valley\"\nwind_m_s = 35\nground_cn2 = 1e-15\nground_z_m = 120\n"}}));
  const Lidar& l = simulation.lidars.at(0);
  CHECK(l.transport.sampling == LidarSampling::receiver);
  CHECK(l.receiver.columns == 128);
  CHECK(l.receiver.rows == 64);
  CHECK(l.receiver.pixel_pitch_rad == exactly(50e-6 / 0.4));
  CHECK(l.receiver.half_fov_rad == 0);
  CHECK(l.receiver.focal_length_m == exactly(0.4));
  CHECK(l.detector.mode == DetectorMode::geiger);
  CHECK(l.detector.dead_time_s == exactly(50e-9));
  CHECK(l.detector.jitter_fwhm_s == exactly(0.3e-9));
  CHECK(l.detector.afterpulse_probability == 0.01);
  CHECK(l.detector.afterpulse_time_s == exactly(80e-9));
  CHECK(l.detector.cells == 4);
  CHECK(l.turbulence.profile == TurbulenceProfile::hufnagel_valley);
  CHECK(l.turbulence.wind_m_s == 35);
  CHECK(l.turbulence.ground_cn2 == 1e-15);
  CHECK(l.turbulence.ground_z_m == 120);
}

TEST_CASE("S40: thresholds by false returns of a record, air as background, and the class of noise") {
  const Folder folder;
  const auto echoes = [&](const std::string& text) {
    return load(folder, lidar_text({{"echoes", text}})).lidars.at(0).echoes;
  };
  const auto plain = echoes("method = \"peak\"\n");
  CHECK(plain.false_returns == 0.01);
  CHECK(plain.air_is_background);
  CHECK(plain.noise_class_above == 0.001);
  const auto given =
      echoes("method = \"peak\"\nfalse_returns = 0.5\nair_is_background = false\nnoise_class_above = 0\n");
  CHECK(given.false_returns == 0.5);
  CHECK_FALSE(given.air_is_background);
  CHECK(given.noise_class_above == 0);
}

TEST_CASE("S27 to S41: the shipped LIDAR scenes that need no generated files load") {
  const auto dial = load_simulation(RAYCUBE_SOURCE_DIR "/scenes/lidar/pipeline_dial.toml");
  CHECK(dial.lidars.at(0).pulse.lines.size() == 2);
  CHECK(dial.scene.volumes.size() == 2);
  const auto flash = load_simulation(RAYCUBE_SOURCE_DIR "/scenes/lidar/geiger_array.toml");
  CHECK(flash.lidars.at(0).receiver.columns == 64);
  CHECK(flash.lidars.at(0).detector.solar_background);  // it has [time]
  CHECK(dial.notices.empty());
  CHECK(flash.notices.empty());
}

TEST_CASE("S27: a trajectory file gives the platform, its clock and the number of pulses") {
  const Folder folder;
  folder.write("t.csv", "time_s,x_m,y_m,z_m,heading_deg\n10,0,0,900,350\n12,0,120,910,10\n");
  const Lidar l =
      load(folder, lidar_text({{"top", "trajectory = \"t.csv\"\nprf_khz = 1\nroll_deg = 3\n"}})).lidars.at(0);
  REQUIRE(l.trajectory.size() == 2);
  CHECK(l.trajectory[1].time_s == 12);
  CHECK(l.trajectory[1].y_m == 120);
  CHECK(l.trajectory[0].heading_deg == 350);
  CHECK(l.trajectory[0].roll_deg == 3);
  CHECK(l.first_pulse_s == 10);
  CHECK(l.pulses == 2001);  // the first and the last instant included
}

TEST_CASE("S27: a platform at rest can look at a point; a raster scan counts its own pulses") {
  const Folder folder;
  const Lidar l =
      load(folder, lidar_text({{"top", "position_m = [100, 100, 50]\nlook_at_m = [0, 200, 50]\nprf_khz = 1\n"},
                               {"scan", "pattern = \"raster\"\ncolumns = 30\nrows = 20\nstep_deg = 0.1\n"}}))
          .lidars.at(0);
  CHECK(l.trajectory.at(0).heading_deg == exactly(-45));
  CHECK(l.trajectory.at(0).pitch_deg == exactly(90));
  CHECK(l.pulses == 600);
  CHECK(l.scan.columns == 30);
  CHECK(l.scan.step_rad == exactly(0.1 * M_PI / 180));
}

TEST_CASE("LIDAR.md 2.2: a tabulated pulse is scaled to area 1 and its zero is where the file says") {
  const Folder folder;
  // A triangle from 1 to 4 ns with its peak at 2 ns: area 6, centroid (1 + 2 + 4) / 3 ns.
  folder.write("p.csv", "time_ns,power\n1,0\n2,4\n4,0\n");
  const auto shape = [&](const std::string& zero) {
    return load(folder, lidar_text({{"pulse",
                                     "energy_J = 1\nwavelength_nm = 532\ndivergence_mrad = 1\ndivergence_is = \"half "
                                     "angle at 1/e\"\nshape = \"tabulated\"\n"
                                     "shape_file = \"p.csv\"\nzero_at = \"" +
                                         zero + "\"\n"}}))
        .lidars.at(0)
        .pulse;
  };
  const LidarPulse file = shape("file"), peak = shape("peak"), centroid = shape("centroid");
  REQUIRE(file.shape_time_s.size() == 3);
  CHECK(file.shape_time_s[0] == exactly(1e-9));
  CHECK(file.shape_power[1] == exactly(4 / 6e-9));
  CHECK(peak.shape_time_s[1] == 0);
  CHECK(centroid.shape_time_s[0] == exactly(1e-9 - 7e-9 / 3));
}

TEST_CASE("LIDAR.md 2.1, 2.3: what no laser can do is said, not refused") {
  const Folder folder;
  // w 5 mm, 0.25 mrad, 1064 nm: M2 = 3.69; a tenth of the divergence is below the diffraction limit.
  const auto notices = [&](const std::string& divergence_mrad, const std::string& line_nm) {
    return load(folder, lidar_text({{"pulse", "energy_J = 1\nwavelength_nm = 1064\nline_fwhm_nm = " + line_nm +
                                                  "\nexit_diameter_mm = 10\nexit_is = \"1/e^2\"\ndivergence_mrad = " +
                                                  divergence_mrad +
                                                  "\ndivergence_is = \"half angle at 1/e^2\"\nfwhm_ns = 4\n"}}))
        .notices;
  };
  CHECK(notices("0.25", "0.01").empty());  // 2.648 GHz * 4 ns = 10.6
  REQUIRE(notices("0.025", "0").size() == 1);
  CHECK_SAYS(notices("0.025", "0")[0], "M2 = 0.369");
  REQUIRE(notices("0.25", "0.0001").size() == 1);
  CHECK_SAYS(notices("0.25", "0.0001")[0], "below the transform limit");
  CHECK(load(folder, lidar_text({{"pulse", std::string(kBeam) +
                                               "divergence_mrad = 0\ndivergence_is = \"half angle at 1/e\"\n"}}))
            .notices.size() == 1);
}
