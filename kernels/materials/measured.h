/* A measured form: pi f, times the curve, at zenith angles of light and of viewer and at their relative azimuth, linear
 * in these three between what was measured and beyond the last angles as there. Left and right of the principal plane
 * are alike. The table of p, from number 2^20 p[0] + p[1] on: counts of the three, the angles of each ascending, rad,
 * then the values [light][viewer][azimuth]; azimuth 0 is the light's own side. */
#ifdef RC_SHAPE
RC_SHAPE(measured, front, 0, 0, "A table over angles of light and viewer.")
#elif !defined(RAYCUBE_KERNELS_MATERIALS_MEASURED_H)
#define RAYCUBE_KERNELS_MATERIALS_MEASURED_H

#include "kernels/materials/angles.h"

/* Number of the last of the ascending angles that is not above `at`, the last but one at most; part: how far on to the
 * next. */
static inline int rc_measured_cell(RC_TABLE_SPACE const float* angle, int count, rc_real at, rc_real* part) {
  int low = 0;
  *part = 0;
  if (count < 2) return 0;
  for (int high = count - 1; high - low > 1;) {
    const int middle = (low + high) / 2;
    if (at < angle[middle])
      high = middle;
    else
      low = middle;
  }
  const rc_real begin = angle[low];
  *part = fmin(fmax((at - begin) / (angle[low + 1] - begin), RC_REAL(0.0)), RC_REAL(1.0));
  return low;
}

/* Between the azimuths of a row. */
static inline rc_real rc_measured_row(RC_TABLE_SPACE const float* row, int count, int low, rc_real part) {
  const int next = low + 1 < count ? low + 1 : low;
  return (RC_REAL(1.0) - part) * row[low] + part * row[next];
}

static inline rc_real rc_measured_eval(rc_real scale, RcParameters p, RcAngles a) {
  if (!(a.cos_in > 0 && a.cos_out > 0)) return 0;
  RC_TABLE_SPACE const float* table = p.table + (((size_t)p.of[0] << 20) + (size_t)p.of[1]);
  const int in_count = (int)table[0], out_count = (int)table[1], turn_count = (int)table[2];
  RC_TABLE_SPACE const float* angle = table + 3;
  RC_TABLE_SPACE const float* value = angle + in_count + out_count + turn_count;
  rc_real in, out, turn;
  const int i = rc_measured_cell(angle, in_count, atan2(a.sin_in, a.cos_in), &in);
  const int j = rc_measured_cell(angle + in_count, out_count, atan2(a.sin_out, a.cos_out), &out);
  const int k = rc_measured_cell(angle + in_count + out_count, turn_count, atan2(a.across, a.along), &turn);
  rc_real sum = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const int row = i + corner / 2 < in_count ? i + corner / 2 : i,
              column = j + corner % 2 < out_count ? j + corner % 2 : j;
    const rc_real share = (corner / 2 ? in : RC_REAL(1.0) - in) * (corner % 2 ? out : RC_REAL(1.0) - out);
    sum += share * rc_measured_row(value + (row * out_count + column) * turn_count, turn_count, k, turn);
  }
  return scale * RC_INVERSE_PI * sum;
}
static inline RcLocal rc_measured_sample(RcParameters p, RcLocal in, rc_real u, rc_real v) {
  (void)p, (void)in;
  return rc_cosine_law(u, v);
}
static inline rc_real rc_measured_pdf(RcParameters p, RcAngles a) {
  (void)p;
  return a.cos_out > 0 ? a.cos_out * RC_INVERSE_PI : 0;
}

#endif
