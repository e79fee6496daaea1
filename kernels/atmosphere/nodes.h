/* How a scalar finds its plan nodes: linear weights on a uniform axis, and the octahedral map of unoccluded irradiance.
 * Valid C++20 and OpenCL C 1.2; only exactly rounded operations, so host and device agree to the bit (contraction off).
 * */
#ifndef RAYCUBE_KERNELS_ATMOSPHERE_NODES_H
#define RAYCUBE_KERNELS_ATMOSPHERE_NODES_H

/* Weights of `value` on the axis first, first + step, ... of `count` nodes: (1 - *fraction) on node *index and
 * *fraction on node *index + 1. Outside the axis the end node takes all; with one node *index = 0 and *fraction = 0
 * (never read + 1). A value that is not a number goes to the first node. */
static inline void rc_node_weights(float value, float first, float step, int count, int* index, float* fraction) {
  const float last = (float)(count - 1);
  float t = count > 1 ? (value - first) / step : 0.0f;
  t = t > 0.0f ? t : 0.0f;
  t = t < last ? t : last;
  int i = (int)t;
  i = i < count - 1 ? i : count - 2;
  i = i > 0 ? i : 0;
  *index = i;
  *fraction = t - (float)i;
}

/* Nodes of a table over the vertical component of a normal, -1 .. 1: what a sky without azimuth sends onto a tilted
 * plane. Where the horizon is brighter or darker than the rest, that has c (1 - nz^2)^1.5 in it, |c| < 0.3: the error
 * between nodes is largest at the ends, 0.4 c h^1.5 = 1.3e-6 of the irradiance. */
#define RC_TILT_NODES 4097

/* The three map nodes around a direction and their weights (sum 1). Map: octahedron |x|+|y|+|z| = 1 unfolded on the
 * square [-1,1]^2, upper half inside the diamond |u|+|v| <= 1; size x size nodes, node (0,0) at (-1,-1), index = v *
 * size + u. `size` is odd, so the folds u = 0, v = 0 and |u|+|v| = 1 run along node lines and cell diagonals; each cell
 * is cut along the diagonal parallel to its quadrant's fold and interpolated linearly on the triangle: a plain bilinear
 * cell would cross the fold at the horizon of the normals (walls), where the map has a kink. (x,y,z) need not be
 * normalised; not all zero. Map: Meyer et al., "On floating-point normal vectors", EGSR 2010; Cigolle et al., JCGT
 * 3(2), 2014. */
static inline void rc_octahedral_nodes(float x, float y, float z, int size, int index[3], float weight[3]) {
  const float ax = x < 0.0f ? -x : x, ay = y < 0.0f ? -y : y, az = z < 0.0f ? -z : z;
  const float s = ax + ay + az;
  /* a, b: distance from the map's centre lines, 0..1; below the horizon the triangle is folded outwards */
  const float pa = ax / s, pb = ay / s;
  const float a = z < 0.0f ? 1.0f - pb : pa, b = z < 0.0f ? 1.0f - pa : pb;
  const int middle = (size - 1) / 2;
  const float ga = a * (float)middle, gb = b * (float)middle;
  int ia = (int)ga, ib = (int)gb;
  ia = ia < middle ? ia : middle - 1;
  ib = ib < middle ? ib : middle - 1;
  const float fa = ga - (float)ia, fb = gb - (float)ib;
  const int inner = fa + fb <= 1.0f;
  /* node (middle + sign_x a, middle + sign_y b) */
  const int step_u = x < 0.0f ? -1 : 1, step_v = y < 0.0f ? -size : size;
  const int base = middle * size + middle + ia * step_u + ib * step_v;
  index[0] = inner ? base : base + step_u + step_v;
  index[1] = base + step_u;
  index[2] = base + step_v;
  weight[0] = inner ? 1.0f - fa - fb : fa + fb - 1.0f;
  weight[1] = inner ? fa : 1.0f - fb;
  weight[2] = inner ? fb : 1.0f - fa;
}

#endif
