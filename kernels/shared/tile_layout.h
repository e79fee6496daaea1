/* What the stages of a camera hand to one another for a tile of its image: planes, strides and sizes of every buffer
 * that host and kernels share, each number under one name. Valid C++20 and OpenCL C 1.2.
 *
 * A stage handles a chunk of every pixel's samples. Each sample has a slot, sample s slot s - first_sample, and a pixel
 * TileShape::near of them, whole words of 16. Where matter lets light through (TileShape::through), a sample has a
 * second slot, `near` further, for the side of its surface that the viewer does not see: the same hit and weight, the
 * point beyond the surface, the normal turned round; zero, as where nothing was hit, on surfaces that are opaque. Hits
 * have slots of the near side alone. Where matter is glossy, it has one more, for what comes by its gloss: the near
 * side's point and normal, zero on surfaces without, and the gloss as the shape. Where shapes change with wavelength,
 * each further lobe (TileShape::further) has a slot after them, likewise with its own shape. Pixel i of a tile is (line
 * in the tile) * columns + (column in the tile).
 * Where a slot has several numbers, each of them is a plane, and a word's planes lie side by side, 16 numbers each, so
 * that how many samples there are moves no plane. By pixel, one after the other:
 *   hits      uint    [near words][RC_HIT_PLANES][16]  planes RC_HIT_*; RC_NONE in both where nothing was hit
 *   surface   float   [words][RC_POINT_PLANES][16]  planes RC_POINT_* and RC_NORMAL_*; zero where nothing was hit; then
 *                                               those of shapes
 *   lift      float   [slots]                    m, how far along its normal the point was moved
 *   sun       ushort  [words]                    bit s % 16 of word s / 16: the sample sees the sun
 *   met_sky   float   [words][sky_planes][16]    irradiance, by component: what the sample's rays into the sky add to
 *                                               the share of the open sky that is taken for granted; zero where it
 *                                               sends none. With shapes (RC_SHAPED) open sky counts pi f times. Then
 *                                               that of lamps, by their sources, likewise
 *   glow      float   [RC_PATH_PARTS][1 + lamps][skeleton]  where light goes on from surface to surface
 *                                               (trace_bounce): by part of the samples, what it adds at the skeleton
 *                                               wavelengths, per light of sun, skies and heat together, then per
 *                                               light of each source of lamps; the parts' sum is the pixel's
 *   path_log  PathStep  [numbered path][levels + 1]  where a probe asks for it
 *   opaque    uint    [near slots]               where it is asked for: the first primitive on the sample's ray that
 *                                               lets no light through, or RC_NONE
 * Once for all pixels: chunk weights, float [near slots], zero where there is no sample.
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
 *                             sends back of an even light towards the viewer (lobe_albedo), so that a front has a
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
/* Build options (host/render/tile_shape.h), few: how much a kernel's own arrays hold, and what matter there may be,
 * since what a scene does not contain costs nothing. Everything else is in TileShape. */
#ifndef RC_CHUNK_SAMPLES
#define RC_CHUNK_SAMPLES 1024 /* most samples of a pixel that one launch handles */
#endif
#ifndef RC_MOST_LIGHTS
#define RC_MOST_LIGHTS 16 /* most sources that have a value for each sample */
#endif
#ifndef RC_SHAPED
#define RC_SHAPED 0 /* 1: some material may not reflect by Lambert's law */
#endif
#define RC_POINT_PLANES RC_POINT_PLANES_OF(RC_SHAPED)
#ifndef RC_THROUGH
#define RC_THROUGH 0 /* 1: some material may let light through */
#endif
#ifndef RC_PLATES
#define RC_PLATES 0 /* 1: through some material light may go straight on, which paths see; then RC_SHAPED is 1 too */
#endif
#ifndef RC_GLOSSY
#define RC_GLOSSY 0 /* 1: some material may be glossy; then RC_SHAPED is 1 too */
#endif
#ifndef RC_FURTHER
#define RC_FURTHER 0 /* most further lobes of shapes that change with wavelength; then RC_SHAPED is 1 too */
#endif
#ifndef RC_SKELETON
#define RC_SKELETON 16 /* most wavelengths along paths, whole words */
#endif
#define RC_MOST_OWN_SIDES (1 + RC_THROUGH + RC_GLOSSY)
#define RC_MOST_SIDES (RC_MOST_OWN_SIDES + RC_FURTHER)
#define RC_NEAR_SAMPLES RC_PADDED(RC_CHUNK_SAMPLES) /* most near slots of a pixel */
#define RC_MOST_SLOTS (RC_MOST_SIDES * RC_NEAR_SAMPLES)

/* A slot's sample, and which side of its surface the slot is (product_key.h), and the reverse. */
static inline uint rc_sample_of(const TileShape* tile, uint slot) {
  return RC_MOST_SIDES > 1 ? slot % tile->near : slot;
}
static inline uint rc_side_of(const TileShape* tile, uint slot) {
  const uint number = RC_MOST_SIDES > 1 ? slot / tile->near : 0u;
  return number == 0u                    ? RC_NEAR_SIDE
         : number == 1u && tile->through ? RC_FAR_SIDE
         : number < tile->own_sides      ? RC_GLOSS_SIDE
                                         : RC_FURTHER_SIDE + number - tile->own_sides;
}
static inline uint rc_slot_of_side(const TileShape* tile, uint sample, uint side) {
  return sample + tile->near * (side == RC_GLOSS_SIDE     ? 1u + tile->through
                                : side >= RC_FURTHER_SIDE ? tile->own_sides + side - RC_FURTHER_SIDE
                                                          : side);
}
/* Words of a pixel's near slots, and of all slots that send rays. */
static inline uint rc_near_words(const TileShape* tile) { return tile->near / RC_WORD; }
static inline uint rc_own_words(const TileShape* tile) { return tile->own_sides * (tile->near / RC_WORD); }
/* Sources that have a value per sample, sun, sky, surroundings and lamps; emission follows them in a row. */
static inline uint rc_lights(const TileShape* tile) { return tile->sun + tile->components + tile->lamps; }
static inline uint rc_sources(const TileShape* tile) { return rc_lights(tile) + tile->temperatures; }
static inline uint rc_accumulators(const TileShape* tile) {
  return RC_ROW_ACCUMULATORS(rc_sources(tile), tile->heights);
}
/* A word's planes in hits and surface, and how far its planes lie apart. */
#define RC_PLANE(plane) ((plane)*RC_WORD)
#define RC_HIT_WORD (RC_HIT_PLANES * RC_WORD)
#define RC_SURFACE_WORD (RC_POINT_PLANES * RC_WORD)
static inline uint rc_met_word(const TileShape* tile) { return tile->sky_planes * RC_WORD; }
/* Where the first plane of a pixel's slot lies, from the pixel's first element. */
static inline uint rc_hits_slot(uint slot) { return slot / RC_WORD * RC_HIT_WORD + slot % RC_WORD; }
static inline uint rc_surface_slot(uint slot) { return slot / RC_WORD * RC_SURFACE_WORD + slot % RC_WORD; }
static inline uint rc_met_slot(const TileShape* tile, uint slot) {
  return slot / RC_WORD * rc_met_word(tile) + slot % RC_WORD;
}
/* A pixel's first element in each buffer. */
static inline size_t rc_hits_at(const TileShape* tile, uint pixel) {
  return (size_t)pixel * (RC_HIT_PLANES * tile->near);
}
static inline size_t rc_surface_at(const TileShape* tile, uint pixel) {
  return (size_t)pixel * (RC_SURFACE_WORD * tile->words);
}
static inline size_t rc_lift_at(const TileShape* tile, uint pixel) { return (size_t)pixel * (RC_WORD * tile->words); }
static inline size_t rc_sun_at(const TileShape* tile, uint pixel) { return (size_t)pixel * tile->words; }
static inline size_t rc_met_sky_at(const TileShape* tile, uint pixel) {
  return (size_t)pixel * (rc_met_word(tile) * tile->words);
}
static inline uint rc_glow_width(const TileShape* tile) { return (1u + tile->lamps) * tile->skeleton; } /* of a part */
static inline size_t rc_glow_at(const TileShape* tile, uint pixel, uint part) {
  return ((size_t)pixel * RC_PATH_PARTS + part) * rc_glow_width(tile);
}
static inline size_t rc_first_opaque_at(const TileShape* tile, uint pixel) { return (size_t)pixel * tile->near; }
/* An item's first element, and a key's sums from there. */
static inline size_t rc_sums_of_key(const TileShape* tile, uint key) {
  return (size_t)key * (rc_accumulators(tile) * RC_CARRIED(tile->chunked));
}
static inline size_t rc_sums_at(const TileShape* tile, uint item, uint capacity) {
  return (size_t)item * capacity * (rc_accumulators(tile) * RC_CARRIED(tile->chunked));
}
static inline size_t rc_path_at(const TileShape* tile, uint item) {
  return (size_t)item * (tile->heights * RC_CARRIED(tile->chunked));
}
static inline size_t rc_truth_at(const TileShape* tile, uint item) {
  return (size_t)item * (RC_TRUTH_SUMS * RC_CARRIED(tile->chunked));
}
#else
#include <cstddef>
namespace raycube::shared {

/// Elements of a pixel in the buffers of one chunk of its samples.
struct TileElements {
  std::size_t near, padded, words;  ///< slots of the near side; of all sides, and words of 16 of them
  std::size_t point_planes, sky_planes;
  std::size_t hits, surface, lift, sun, met_sky, glow;
  constexpr TileElements(std::size_t chunk_samples, std::size_t met_planes, bool shaped = false, std::size_t sides = 1,
                         std::size_t glow_of_part = 0)
      : near(RC_PADDED(chunk_samples)),
        padded(sides * near),
        words(padded / RC_WORD),
        point_planes(RC_POINT_PLANES_OF(shaped)),
        sky_planes(met_planes),
        hits(RC_HIT_PLANES * near),
        surface(RC_POINT_PLANES_OF(shaped) * padded),
        lift(padded),
        sun(words),
        met_sky(met_planes * padded),
        glow(RC_PATH_PARTS * glow_of_part) {}
  /// A plane of a slot, from the pixel's first element.
  static constexpr std::size_t hits_at(std::size_t plane, std::size_t slot) { return at(RC_HIT_PLANES, plane, slot); }
  constexpr std::size_t surface_at(std::size_t plane, std::size_t slot) const { return at(point_planes, plane, slot); }
  constexpr std::size_t met_sky_at(std::size_t plane, std::size_t slot) const { return at(sky_planes, plane, slot); }
  constexpr std::size_t bytes() const {
    return hits * sizeof(rc_uint) + (surface + lift + met_sky + glow) * sizeof(rc_float) + sun * sizeof(std::uint16_t);
  }

 private:
  static constexpr std::size_t at(std::size_t planes, std::size_t plane, std::size_t slot) {
    return (slot / RC_WORD * planes + plane) * RC_WORD + slot % RC_WORD;
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
