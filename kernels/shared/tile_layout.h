/* What the stages of a camera hand to one another for a tile of its image: planes, strides and sizes of every buffer
 * that host and kernels share, each number under one name. Valid C++20 and OpenCL C 1.2.
 *
 * A stage handles a chunk of every pixel's samples, at most RC_CHUNK_SAMPLES of them. A plane holds one number of each
 * sample of a pixel in RC_PADDED_SAMPLES slots, whole words of 16: sample s lies in slot s - first_sample. Where matter
 * lets light through (RC_THROUGH), a sample has a second slot, RC_NEAR_SAMPLES further, for the side of its surface
 * that the viewer does not see: the same hit and weight, the point beyond the surface, the normal turned round; zero,
 * as where nothing was hit, on surfaces that are opaque. Hits have slots of the near side alone. Where
 * matter is glossy (RC_GLOSSY), it has one more, for what comes by its gloss: the near side's point and
 * normal, zero on surfaces without, and the gloss as the shape. Where shapes change with wavelength, each further lobe
 * (RC_FURTHER) has a slot after them, likewise with its own shape. Pixel i of a tile is (line in the tile) * columns +
 * (column in the tile). By pixel, one after the other:
 *   hits      uint    [RC_HIT_PLANES][near slots]  planes RC_HIT_*, RC_HIT_PLANE apart; RC_NONE in both where nothing
 *                                               was hit
 *   surface   float   [RC_POINT_PLANES][padded]  planes RC_POINT_* and RC_NORMAL_*; zero where nothing was
 *                                               hit; then those of shapes
 *   lift      float   [padded]                   m, how far along its normal the point was moved
 *   sun       ushort  [words]                    bit s % 16 of word s / 16: the sample sees the sun
 *   met_sky   float   [RC_SKY_PLANES][padded]    irradiance, by component: what the sample's rays into the sky add to
 *                                               the share of the open sky that is taken for granted; zero where it
 *                                               sends none. With shapes (RC_SHAPED) open sky counts pi f times. Then
 *                                               that of lamps, by their sources, likewise
 *   glow      float   [RC_PATH_PARTS][1 + RC_LAMPS][RC_SKELETON]  where light goes on from surface to surface
 *                                               (trace_bounce): by part of the samples, what it adds at the skeleton
 *                                               wavelengths, per light of sun, skies and heat together, then per
 *                                               light of each source of lamps; the parts' sum is the pixel's
 *   path_log  PathStep  [numbered path][levels + 1]  where a probe asks for it (RC_PATH_LOG)
 *   opaque    uint    [near slots]               where it is asked for (RC_FIRST_OPAQUE): the first primitive on the
 *                                               sample's ray that lets no light through, or RC_NONE
 * Once for all pixels: chunk weights, float [RC_NEAR_SAMPLES], zero where there is no sample.
 *
 * A row is what shading leaves of a pixel. By item of a launch (a pixel of the tile, or of a list):
 *   count     uint                               keys of the row, or RC_ROW_OVERFLOW
 *   keys      ulong   [capacity]                 product keys, in the order in which they came up
 *   sums      float   [capacity][carried][RC_ROW_ACCUMULATORS]
 *     [source * heights + h]  the direct sun where the plan has it (weight * visibility * max(0, n.s); with shapes
 *                             times pi f), then the components of sky and surroundings and the sources of lamps
 *                             (weight * their irradiance), then the temperature nodes of emission (weight * node
 *                             weight of the material's temperature), each split over the height nodes by linear
 *                             weights. Of matter that is not Lambert's the node weights are times what its lobe
 *                             sends back of an even light towards the viewer (RC_LOBE_ALBEDO), so that a front has a
 *                             key more, RC_CURVE_LEANING, with what that is beyond 1
 *     [last]                  coverage: sum of sample weights (the material's abundance in the pixel)
 *   path      float   [carried][heights]         weight of all samples at the height nodes
 *   truth     float   [carried][RC_TRUTH_SUMS]   sums RC_TRUTH_*, of the samples that hit, times their weight
 * where `carried` is 1, or 2 when sums are carried from chunk to chunk: the sums, then their rounding errors. */
#ifndef RAYCUBE_KERNELS_SHARED_TILE_LAYOUT_H
#define RAYCUBE_KERNELS_SHARED_TILE_LAYOUT_H

#include "kernels/shared/product_key.h"
#include "kernels/shared/structs.h"

#define RC_WORD 16 /* samples that are handled side by side */
/* A count rounded up to whole words. */
#define RC_PADDED(count) (((count) + RC_WORD - 1) / RC_WORD * RC_WORD)

#define RC_HIT_INSTANCE 0  /* index of the instance */
#define RC_HIT_PRIMITIVE 1 /* block * RC_BLOCK + lane */
#define RC_HIT_PLANES 2

#define RC_POINT_X 0 /* m, scene frame, off the surface on the viewer's side: where shadow rays start */
#define RC_POINT_Y 1
#define RC_POINT_Z 2
#define RC_NORMAL_X 3 /* unit geometric normal, facing the viewer */
#define RC_NORMAL_Y 4
#define RC_NORMAL_Z 5
/* Where some material does not reflect by Lambert's law (RC_SHAPED): */
#define RC_VIEWER_X 6 /* unit, from the point to the viewer */
#define RC_VIEWER_Y 7
#define RC_VIEWER_Z 8
#define RC_LOBE_AT 9 /* bits of which Lobe record its shape is, from 1; 0: Lambert's law */
#define RC_POINT_PLANES_OF(shaped) ((shaped) ? 10 : 6)

/* Planes of met sky, whole float4s: components of the sky, and sources of lamps. */
#define RC_SKY_PLANES_OF(sources) ((sources) > 8 ? 12 : (sources) > 4 ? 8 : 4)

#define RC_ROW_ACCUMULATORS(sources, heights) ((sources) * (heights) + 1)
#define RC_ROW_OVERFLOW 0xFFFFFFFFu /* count of a pixel that needs more keys than its row holds */
/* Floats of a sum: itself and, where it is carried from chunk to chunk, its rounding error. */
#define RC_CARRIED(chunked) ((chunked) ? 2 : 1)

#define RC_TRUTH_HIT 0 /* weight of samples that hit something */
#define RC_TRUTH_SUN 1 /* weight of hit samples that see the sun */
#define RC_TRUTH_X 2   /* hit point, m, scene frame */
#define RC_TRUTH_Y 3
#define RC_TRUTH_Z 4
#define RC_TRUTH_RANGE 5     /* m, sensor to hit */
#define RC_TRUTH_INCIDENCE 6 /* cosine between the normal (facing the viewer) and the sun */
#define RC_TRUTH_VIEW 7      /* cosine between it and the direction to the sensor */
#define RC_TRUTH_SUMS 8

#define RC_PATH_PARTS 4 /* of a pixel's samples, whose paths are summed apart: their spread tells a standard error */

/* Paths of a pixel as they are numbered, part by part (rc_sky_number): some numbers may be nobody's. */
#define RC_NUMBERED_PATHS(paths) (((paths) + RC_PATH_PARTS - 1) / RC_PATH_PARTS * RC_PATH_PARTS)

/* Nodes of a lobe's albedo (scene_compiler/lobe_albedo.h): of the viewer's zenith angle on the surface, 0 to pi / 2,
 * and of its azimuth, 0 to pi; what is turned half round is the same. */
#define RC_ALBEDO_ZENITHS 129
#define RC_ALBEDO_AZIMUTHS 17

#define RC_ENVIRONMENT_NODES 4 /* nodes of the ground around that a pixel takes light from */

#ifdef __OPENCL_C_VERSION__
/* Build options (host/render/tile_shape.h gives a camera's programs those that they read; first rays know of the chunk
 * and the group alone) and what follows from them. */
#ifndef RC_PIXELS_PER_GROUP
#define RC_PIXELS_PER_GROUP RC_GROUP_WIDTH
#endif
#ifndef RC_SKY_PLANES
#define RC_SKY_PLANES RC_SKY_PLANES_OF(0)
#endif
#ifndef RC_SHAPED
#define RC_SHAPED 0 /* 1: some material does not reflect by Lambert's law */
#endif
#define RC_POINT_PLANES RC_POINT_PLANES_OF(RC_SHAPED)
#ifndef RC_THROUGH
#define RC_THROUGH 0 /* 1: some material lets light through */
#endif
#ifndef RC_PLATES
#define RC_PLATES 0 /* 1: through some material light goes straight on, which paths see; then RC_SHAPED is 1 too */
#endif
#ifndef RC_GLOSSY
#define RC_GLOSSY 0 /* 1: some material is glossy; then RC_SHAPED is 1 too */
#endif
#ifndef RC_FURTHER
#define RC_FURTHER 0 /* further lobes of shapes that change with wavelength; then RC_SHAPED is 1 too */
#endif
#define RC_OWN_SIDES (1 + RC_THROUGH + RC_GLOSSY) /* slots of a sample that send rays; further lobes share theirs */
#define RC_SIDES (RC_OWN_SIDES + RC_FURTHER)      /* slots of a sample */
#ifndef RC_MATERIALS
#define RC_MATERIALS 0 /* of the scene; asked for where a sample has more than one slot */
#endif
#ifndef RC_CHUNKED
#define RC_CHUNKED 0 /* 1: sums are carried from chunk to chunk of a pixel's samples */
#endif
#ifndef RC_SUN
#define RC_SUN 1 /* 1: the sun is a source of its own */
#endif
#ifndef RC_COMPONENTS
#define RC_COMPONENTS 0 /* of the sky, surroundings included */
#endif
#ifndef RC_THERMAL_COMPONENTS
#define RC_THERMAL_COMPONENTS 0 /* the last of RC_COMPONENTS */
#endif
#ifndef RC_LAMPS
#define RC_LAMPS 0 /* sources of lamps */
#endif
#ifndef RC_TEMPERATURES
#define RC_TEMPERATURES 0 /* nodes of emission */
#endif
#ifndef RC_LOBE_ALBEDO
#define RC_LOBE_ALBEDO 0 /* 1: emission goes by the angle (kernels/light/lobe_albedo.h); then RC_SHAPED is 1 too */
#endif
#ifndef RC_COVERS
#define RC_COVERS 0 /* 1: what covers a pixel is a term of its own: there is truth per band */
#endif
#ifndef RC_FIRST_OPAQUE
#define RC_FIRST_OPAQUE 0 /* 1: what is opaque behind leaves and plates is asked for */
#endif
#ifndef RC_SKELETON
#define RC_SKELETON 16 /* wavelengths along paths, whole words; asked for where there are bounces */
#endif
#ifndef RC_PATH_LOG
#define RC_PATH_LOG 0 /* 1: every step of every path is handed over */
#endif
#define RC_GLOW_WIDTH ((1 + RC_LAMPS) * RC_SKELETON) /* of a part */
#define RC_NEAR_SAMPLES RC_PADDED(RC_CHUNK_SAMPLES)
#define RC_NEAR_WORDS (RC_NEAR_SAMPLES / RC_WORD)
#define RC_PADDED_SAMPLES (RC_SIDES * RC_NEAR_SAMPLES)
#define RC_WORDS (RC_PADDED_SAMPLES / RC_WORD)
/* Sample of a chunk that a slot belongs to, which side of its surface the slot is (product_key.h), and the reverse. */
#define RC_SAMPLE_OF(slot) (RC_SIDES > 1 ? (slot) % RC_NEAR_SAMPLES : (slot))
#define RC_SIDE_OF(slot)                                        \
  (RC_SIDES == 1 || (slot) < RC_NEAR_SAMPLES    ? RC_NEAR_SIDE  \
   : RC_THROUGH && (slot) < 2 * RC_NEAR_SAMPLES ? RC_FAR_SIDE   \
   : (slot) < RC_OWN_SIDES * RC_NEAR_SAMPLES    ? RC_GLOSS_SIDE \
                                                : RC_FURTHER_SIDE + (slot) / RC_NEAR_SAMPLES - RC_OWN_SIDES)
#define RC_SLOT_OF(sample, side)                                                   \
  ((sample) + ((side) == RC_GLOSS_SIDE     ? 1u + RC_THROUGH                       \
               : (side) >= RC_FURTHER_SIDE ? RC_OWN_SIDES + (side)-RC_FURTHER_SIDE \
                                           : (side)) *                             \
                  RC_NEAR_SAMPLES)
/* Sources that have a value per sample, sun, sky, surroundings and lamps; emission follows them in a row. */
#define RC_LIT (RC_SUN + RC_COMPONENTS + RC_LAMPS)
#define RC_SOURCES (RC_LIT + RC_TEMPERATURES)
#define RC_ACCUMULATORS RC_ROW_ACCUMULATORS(RC_SOURCES, RC_HEIGHTS)
/* A pixel's first element in each buffer; planes begin RC_PLANE further, those of hits RC_HIT_PLANE. */
#define RC_HITS_AT(pixel) ((size_t)(pixel) * (RC_HIT_PLANES * RC_NEAR_SAMPLES))
#define RC_SURFACE_AT(pixel) ((size_t)(pixel) * (RC_POINT_PLANES * RC_PADDED_SAMPLES))
#define RC_LIFT_AT(pixel) ((size_t)(pixel)*RC_PADDED_SAMPLES)
#define RC_SUN_AT(pixel) ((size_t)(pixel)*RC_WORDS)
#define RC_MET_SKY_AT(pixel) ((size_t)(pixel) * (RC_SKY_PLANES * RC_PADDED_SAMPLES))
#define RC_GLOW_AT(pixel, part) (((size_t)(pixel)*RC_PATH_PARTS + (part)) * RC_GLOW_WIDTH) /* a part's first element */
#define RC_FIRST_OPAQUE_AT(pixel) ((size_t)(pixel)*RC_NEAR_SAMPLES)
#define RC_PLANE(plane) ((plane)*RC_PADDED_SAMPLES)
#define RC_HIT_PLANE(plane) ((plane)*RC_NEAR_SAMPLES)
/* An item's first element, and a key's sums from there. */
#define RC_SUMS_AT(item, capacity) ((size_t)(item) * (capacity) * (RC_ACCUMULATORS * RC_CARRIED(RC_CHUNKED)))
#define RC_SUMS_OF_KEY(key) ((size_t)(key) * (RC_ACCUMULATORS * RC_CARRIED(RC_CHUNKED)))
#define RC_PATH_AT(item) ((size_t)(item) * (RC_HEIGHTS * RC_CARRIED(RC_CHUNKED)))
#define RC_TRUTH_AT(item) ((size_t)(item) * (RC_TRUTH_SUMS * RC_CARRIED(RC_CHUNKED)))
#else
#include <cstddef>
namespace raycube::shared {

/// Elements of a pixel in the buffers of one chunk of its samples.
struct TileElements {
  std::size_t near, padded, words;  ///< slots of the near side; of a plane, and 16-bit words of them
  std::size_t hits, surface, lift, sun, met_sky, glow;
  constexpr TileElements(std::size_t chunk_samples, std::size_t sky_planes, bool shaped = false, std::size_t sides = 1,
                         std::size_t glow_of_part = 0)
      : near(RC_PADDED(chunk_samples)),
        padded(sides * near),
        words(padded / RC_WORD),
        hits(RC_HIT_PLANES * near),
        surface(RC_POINT_PLANES_OF(shaped) * padded),
        lift(padded),
        sun(words),
        met_sky(sky_planes * padded),
        glow(RC_PATH_PARTS * glow_of_part) {}
  constexpr std::size_t bytes() const {
    return hits * sizeof(rc_uint) + (surface + lift + met_sky + glow) * sizeof(rc_float) + sun * sizeof(std::uint16_t);
  }
};

/// Elements of an item in the buffers of rows.
struct RowElements {
  std::size_t keys, sums_of_key, sums, path, truth;
  constexpr RowElements(std::size_t capacity, std::size_t accumulators, std::size_t heights, bool chunked)
      : keys(capacity),
        sums_of_key(accumulators * RC_CARRIED(chunked)),
        sums(capacity * sums_of_key),
        path(heights * RC_CARRIED(chunked)),
        truth(RC_TRUTH_SUMS * RC_CARRIED(chunked)) {}
  /// Of the count, the keys and their sums.
  constexpr std::size_t row_bytes() const {
    return sizeof(rc_uint) + keys * sizeof(std::uint64_t) + sums * sizeof(rc_float);
  }
  /// Of the sums that a pixel has once.
  constexpr std::size_t pixel_bytes() const { return (path + truth) * sizeof(rc_float); }
};
#endif

/* Groups of rays that a line of a tile takes, and where a pixel of the tile lies: its group, counted line by line, and
 * its place along that, in pixels from the group's middle. */
static inline rc_uint rc_groups_per_line(rc_uint columns, rc_uint pixels_per_group) {
  return (columns + pixels_per_group - 1u) / pixels_per_group;
}
static inline rc_uint rc_group_of(rc_uint pixel, rc_uint columns, rc_uint pixels_per_group) {
  const rc_uint line = pixel / columns, column = pixel - line * columns;
  return line * rc_groups_per_line(columns, pixels_per_group) + column / pixels_per_group;
}
static inline float rc_place_in_group(rc_uint pixel, rc_uint columns, rc_uint pixels_per_group) {
  return (float)(pixel % columns % pixels_per_group) - 0.5f * (float)(pixels_per_group - 1u);
}

#ifndef __OPENCL_C_VERSION__
} /* namespace raycube::shared */
#endif
#endif
