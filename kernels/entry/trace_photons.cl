/* Reads: photons, the scene, how its surfaces scatter. Sixteen an item.
 * Writes: what each photon's ray met, where light goes on from there, by which side and in which direction: by the
 * cosine about a side that is chosen by chance, straight on through a plate, mirrored by a gloss. Where shapes change
 * with wavelength, their forms are left to the host. Next: the host counts what is absorbed and launches it again. */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/light/path_ends.h"
#include "kernels/shared/photon_arguments.h"

#define RC_PHOTON_DIMENSION 29u /* of rc_hash, and the next three */

static inline float rc_photon_draw(uint seed, uint number, uint level, uint what) {
  return rc_unit_float(rc_hash(seed, number, level, RC_PHOTON_DIMENSION + what));
}

/* Lets light go on from where a photon ended. */
static inline void rc_send_on(global const Lobe* lobes, global const float4* scattering, Ends16* ends, uint k,
                              uint level, uint seed, global Photon* photon) {
  const uint surface = ends->surface[k], number = photon->number;
  const float near = scattering[surface].x, gloss = RC_GLOSSY ? scattering[surface].z : 0.0f;
  const float draw = rc_photon_draw(seed, number, level, 0u);
  const bool mirrored = draw < gloss, through = !mirrored && near < 1.0f && draw - gloss >= near * (1.0f - gloss);
  float reach = photon->origin.w * (mirrored ? 1.0f : scattering[surface].y), survival = reach > 0.0f ? 1.0f : 0.0f;
  if (level > 2u) {
    survival = fmin(survival, reach);
    if (rc_photon_draw(seed, number, level, 1u) >= survival) survival = 0.0f;
    if (survival > 0.0f) reach /= survival;
  }
  float shaped;
  const float u = rc_photon_draw(seed, number, level, 2u), v = rc_photon_draw(seed, number, level, 3u);
  const float4 normal = rc_lane_of(ends->normal, k), came = photon->way;
  float4 way = rc_way_on(lobes, surface, through, normal, came, u, v, &shaped);
  if (RC_FURTHER_RECORDS > 0) shaped = 1.0f;
  if (through && rc_is_plate(lobes, surface)) way = came;
#if RC_GLOSSY
  if (mirrored) {
    const Lobe lobe = rc_gloss_of(lobes, surface);
    way = rc_way_mirrored(lobes, lobe, normal, -came, u, v, &shaped);
    if (shaped > 0.0f)
      shaped *= RC_FURTHER_RECORDS > 0 ? 1.0f : rc_gloss_factor(lobes, lobe, normal, way, -came);
    else
      survival = 0.0f; /* into the surface: what is kept is right in the mean */
  }
#endif
  const float front_z = ends->front[2][k], behind_z = fma(-2.0f * ends->lift[k], ends->normal[2][k], front_z);
  photon->met_z = fmin(front_z, behind_z);
  photon->origin = rc_lane_of(through ? ends->back : ends->front, k);
  photon->origin.w = reach;
  photon->way = way;
  photon->side = mirrored ? RC_GLOSS_SIDE : through ? RC_FAR_SIDE : RC_NEAR_SIDE;
  photon->factor = shaped / (mirrored ? gloss : (through ? 1.0f - near : near) * (1.0f - gloss));
  photon->survival = survival;
}

kernel void trace_photons(RC_PARAMETERS(RC_TRACE_PHOTONS_ARGUMENTS)) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint first = 16u * (uint)get_global_id(0), used = min(16u, count - first);
  Rays16 rays;
  Ends16 ends;
  uint live = 0;
  for (uint k = 0; k < 16u; ++k) {
    global Photon* photon = photons + first + min(k, used - 1u);
    rc_put_ray(&rays, k, photon->origin, photon->way);
    if (k >= used) continue;
    const float4 origin = (float4)(photon->origin.xyz, 0.0f);
    const Hit hit = rc_trace_ray(scene, origin, photon->way);
    ends.instance[k] = photon->instance = hit.instance;
    ends.primitive[k] = photon->primitive = hit.primitive;
    if (hit.instance != RC_NONE) live |= 1u << k;
  }
  if (!live) return;
  rc_stand(scene, lobes, &rays, live, &ends);
  for (; live; live &= live - 1u) {
    const uint k = rc_lowest(live);
    rc_send_on(lobes, scattering, &ends, k, level, seed, photons + first + k);
  }
}
