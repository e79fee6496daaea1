// Where MODTRAN puts the sun: its own subsolar point by day of the year and time, and the sun's angles at a place of a
// spherical earth. Angles in degrees, latitudes north, longitudes west as MODTRAN counts them, azimuths clockwise from
// north. Shown by the subsolar points that MODTRAN 6.0.1 and 6.0.2 listings print, which come back to their last digit.
#pragma once

namespace raycube::atmos::imported {

struct EarthPoint {
  double latitude_deg, longitude_west_deg;
};

/// Straight lines between 25 days of declination and equation of time, as LOWTRAN 7's subroutine SUBSOL has them
/// (Kneizys et al. 1988, AFGL-TR-88-0177; public domain) and MODTRAN since: not the almanac's sun (within a degree of
/// it, the source says), but the one that the run was computed with. day 1..366, time 0..24 h UT.
EarthPoint modtran_subsolar_point(int day_of_year, double time_h);

struct SunAngles {
  double zenith_deg;   ///< 0..180, no refraction
  double azimuth_deg;  ///< 0..360
};

/// The sun as seen from `place`: cos zenith = sin p sin s + cos p cos s cos dl (p, s latitudes, dl the difference of
/// longitudes). With the sun in the zenith the azimuth is 0.
SunAngles sun_seen_from(const EarthPoint& place, const EarthPoint& subsolar);

/// The end of a great circle of `arc_deg` that leaves `from` at `azimuth_deg`, and the azimuth back to `from` there.
struct ArcEnd {
  EarthPoint point;
  double azimuth_back_deg;
};
ArcEnd along_great_circle(const EarthPoint& from, double azimuth_deg, double arc_deg);

}  // namespace raycube::atmos::imported
