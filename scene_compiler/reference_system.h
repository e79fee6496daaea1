// Coordinate reference systems, by PROJ through GDAL: whether a file's is the scene's, and where on earth a point of it
// lies.
#pragma once

#include <optional>
#include <string>

typedef void* OGRSpatialReferenceH;  // as ogr_srs_api.h has it, which few need

namespace raycube::scene {

/// A file's system, as its definition says.
struct ReferenceSystem {
  std::string wkt;           ///< of all of it, WKT 2; empty: the file names no system
  std::string name;          ///< of the horizontal part
  int epsg = 0;              ///< of the horizontal part; 0: it has no code
  bool geographic = false;   ///< degrees
  double unit_m = 1;         ///< of eastings and northings
  std::string height_name;   ///< of the vertical part; empty: none
  double height_unit_m = 0;  ///< of the vertical part; 0: none
};

ReferenceSystem describe_system(OGRSpatialReferenceH system);

/// Whether the horizontal part of a definition is the system of the code: compared by PROJ as definitions, names apart.
bool is_system(const std::string& wkt, int epsg);

/// Longitude, latitude (degrees, WGS 84) of a point of a projected system, the azimuth of its grid north against true
/// north (degrees, clockwise positive), and how long a metre of the ground is on its map, to north and to east.
struct GeoPlace {
  double longitude_deg = 0, latitude_deg = 0, grid_north_azimuth_deg = 0;
  double scale_north = 1, scale_east = 1;
};
/// Of a projected system in metres. nullopt with the reason in `why`: no such code, not projected, in another unit, or
/// the point lies outside of it.
std::optional<GeoPlace> geographic_place(int epsg, double easting_m, double northing_m, std::string* why = nullptr);

/// EPSG code of the UTM zone (WGS 84) of a place.
int utm_zone(const GeoPlace& place);

}  // namespace raycube::scene
