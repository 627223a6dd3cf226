/* The fluid of thesis eq. 7, installed as MuJoCo's mjcb_passive.
 *
 * For every wet body with added-mass tensor K (6x6, body frame, about a point r of the body):
 * K is added to the joint-space inertia d->M by a composite-body pass, as Featherstone 2008
 * adds rigid inertias (section 6.2), and what remains of Kirchhoff's equations (Lamb 1932,
 * section 124), buoyancy, drag and thrust go to d->qfrc_passive by a pass from leaves to roots.
 * A spatial vector here is MuJoCo's: rotation first, about the centre of mass of the whole tree,
 * in world axes. The readable account is reference.py, which the tests hold this file against.
 */
#include <math.h>

#include <mujoco/mujoco.h>

/* Where each quantity stands in body_user; numbers.py has the same table. */
enum { MARK = 0, SCALE = 1, ADDED = 2, POINT = 23, DISPLACED = 26, CENTRE = 27, LINEAR = 30,
       QUADRATIC = 36, CURRENT = 42, EDGE = 45, CHORD = 48, NORMAL = 51, SHED = 54,
       APART = 55, WIDTH = 58, FEWER = 55 };

#define SIGNATURE (-0.71875) /* no description of a robot puts this number first of so many */
#define WETTED 1.0       /* d->crb of the world, which MuJoCo sets to 0 with every new M */

typedef void (*factor_function)(const mjModel*, mjData*);
typedef mjtNum* (*allocate_function)(mjData*, size_t);
typedef void (*mark_function)(mjData*);

static factor_function factor;
static allocate_function allocate;
static mark_function mark, release;

/* MuJoCo's own functions come as pointers, so that nothing is linked. */
void morph_fluid_bind(factor_function f, allocate_function a, mark_function m, mark_function r) {
  factor = f; allocate = a; mark = m; release = r;
}

int morph_fluid_version(void) { return mjVERSION_HEADER; }
int morph_fluid_width(void) { return WIDTH; }
double morph_fluid_signature(void) { return SIGNATURE; }

/* Three numbers at once: in one register where the processor has one for four, else one by one. */
#ifdef __AVX__
typedef mjtNum Row __attribute__((vector_size(4 * sizeof(mjtNum)), aligned(sizeof(mjtNum))));
static inline Row row(mjtNum x, mjtNum y, mjtNum z) { return (Row){x, y, z, 0}; }
static inline Row scaled(mjtNum s, Row a) { return s * a; }
static inline Row sum(Row a, Row b) { return a + b; }
#define ENTRY(a, i) ((a)[i])
#else
typedef struct { mjtNum x[3]; } Row;
static inline Row row(mjtNum x, mjtNum y, mjtNum z) { return (Row){{x, y, z}}; }
static inline Row scaled(mjtNum s, Row a) { return row(s * a.x[0], s * a.x[1], s * a.x[2]); }
static inline Row sum(Row a, Row b) { return row(a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2]); }
#define ENTRY(a, i) ((a).x[i])
#endif

static inline Row mixed(mjtNum r, Row a, mjtNum s, Row b, mjtNum t, Row c) { /* r a + s b + t c */
  return sum(sum(scaled(r, a), scaled(s, b)), scaled(t, c));
}

/* A symmetric 6x6 inertia by rows: p = A v + B w, h = B' v + C w; T is B'. */
typedef struct { Row A[3], B[3], T[3], C[3]; } Inertia;

static void cross(mjtNum* out, const mjtNum* a, const mjtNum* b) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static void add_cross(mjtNum* out, const mjtNum* a, const mjtNum* b) {
  out[0] += a[1] * b[2] - a[2] * b[1];
  out[1] += a[2] * b[0] - a[0] * b[2];
  out[2] += a[0] * b[1] - a[1] * b[0];
}

static void turn(mjtNum* out, const mjtNum* R, const mjtNum* x) { /* R x */
  for (int i = 0; i < 3; i++) out[i] = R[3*i] * x[0] + R[3*i+1] * x[1] + R[3*i+2] * x[2];
}

static void turn_back(mjtNum* out, const mjtNum* R, const mjtNum* x) { /* R' x */
  for (int i = 0; i < 3; i++) out[i] = R[i] * x[0] + R[3+i] * x[1] + R[6+i] * x[2];
}

static void turn_both(Row* out, const mjtNum* R, const Row* X) { /* R X R' */
  const Row x = row(R[0], R[3], R[6]), y = row(R[1], R[4], R[7]), z = row(R[2], R[5], R[8]);
  for (int i = 0; i < 3; i++) {
    Row t = mixed(R[3*i], X[0], R[3*i+1], X[1], R[3*i+2], X[2]);
    out[i] = mixed(ENTRY(t, 0), x, ENTRY(t, 1), y, ENTRY(t, 2), z);
  }
}

static void transposed(Row* out, const Row* X) {
  for (int i = 0; i < 3; i++) out[i] = row(ENTRY(X[0], i), ENTRY(X[1], i), ENTRY(X[2], i));
}

static void columns_cross(Row* out, const mjtNum* d, const Row* X) { /* [d] X */
  out[0] = sum(scaled(d[1], X[2]), scaled(-d[2], X[1]));
  out[1] = sum(scaled(d[2], X[0]), scaled(-d[0], X[2]));
  out[2] = sum(scaled(d[0], X[1]), scaled(-d[1], X[0]));
}

static void add(Row* out, const Row* X) {
  for (int i = 0; i < 3; i++) out[i] = sum(out[i], X[i]);
}

/* The 21 upper entries of K in body axes become an inertia in world axes about the point at -d. */
static void placed(Inertia* out, const mjtNum* k, mjtNum scale, const mjtNum* R, const mjtNum* d) {
  const Row a[3] = {row(k[0], k[1], k[2]), row(k[1], k[6], k[7]), row(k[2], k[7], k[11])};
  const Row t[3] = {row(k[3], k[8], k[12]), row(k[4], k[9], k[13]), row(k[5], k[10], k[14])};
  const Row c[3] = {row(k[15], k[16], k[17]), row(k[16], k[18], k[19]), row(k[17], k[19], k[20])};
  Row DA[3], DB[3], DBt[3];
  turn_both(out->A, R, a);
  turn_both(out->T, R, t);
  turn_both(out->C, R, c);
  /* With D = [d]: B <- B - A D, C <- C - B' D + D (B - A D); A D = -(D A)' and B' D = -(D B)'. */
  columns_cross(DA, d, out->A);
  transposed(out->B, out->T);
  columns_cross(DB, d, out->B);
  transposed(DBt, DB);
  add(out->T, DA);
  transposed(out->B, out->T);
  columns_cross(DB, d, out->B);
  add(out->C, DBt);
  add(out->C, DB);
  if (scale == 1) return;
  for (int i = 0; i < 3; i++) {
    out->A[i] = scaled(scale, out->A[i]);
    out->B[i] = scaled(scale, out->B[i]);
    out->T[i] = scaled(scale, out->T[i]);
    out->C[i] = scaled(scale, out->C[i]);
  }
}

/* Momentum (angular first) of an inertia that moves as `motion` (angular first). */
static void momentum(mjtNum* out, const Inertia* K, const mjtNum* motion) {
  const mjtNum *w = motion, *v = motion + 3;
  Row h = sum(mixed(v[0], K->B[0], v[1], K->B[1], v[2], K->B[2]),
              mixed(w[0], K->C[0], w[1], K->C[1], w[2], K->C[2]));
  Row p = sum(mixed(v[0], K->A[0], v[1], K->A[1], v[2], K->A[2]),
              mixed(w[0], K->T[0], w[1], K->T[1], w[2], K->T[2]));
  for (int i = 0; i < 3; i++) { out[i] = ENTRY(h, i); out[3+i] = ENTRY(p, i); }
}

/* Minus the rate of momentum that the fluid has without joint acceleration. */
static void inertial(mjtNum* force, const Inertia* K, const mjtNum* motion, const mjtNum* rate) {
  mjtNum p[6], dp[6], gyro[6];
  momentum(p, K, motion);
  momentum(dp, K, rate);
  cross(gyro, motion, p);
  add_cross(gyro, motion + 3, p + 3);
  cross(gyro + 3, motion, p + 3);
  for (int i = 0; i < 6; i++) force[i] -= dp[i] + gyro[i];
}

static void push(mjtNum* force, const mjtNum* at, const mjtNum* f) { /* f acts at `at` from the centre */
  add_cross(force, at, f);
  for (int i = 0; i < 3; i++) force[3+i] += f[i];
}

static void buoyancy(mjtNum* force, const mjtNum* u, const mjtNum* R, const mjtNum* body,
                     const mjtNum* gravity) {
  mjtNum at[3], f[3];
  turn(at, R, u + CENTRE);
  for (int i = 0; i < 3; i++) {
    at[i] += body[i];
    f[i] = -u[SCALE] * u[DISPLACED] * gravity[i];
  }
  push(force, at, f);
}

static int any(const mjtNum* six) {
  for (int i = 0; i < 6; i++) if (six[i] != 0) return 1;
  return 0;
}

static void drag(mjtNum* force, const mjtNum* u, int linear, int quadratic, const mjtNum* R,
                 const mjtNum* d, const mjtNum* motion) {
  mjtNum world[3], here[6], load[6], f[3], torque[3];
  cross(world, motion, d);
  for (int i = 0; i < 3; i++) world[i] += motion[3+i];
  turn_back(here, R, world);
  turn_back(here + 3, R, motion);
  for (int i = 0; i < 6; i++)
    load[i] = -u[SCALE] * ((linear ? u[LINEAR+i] : 0) + (quadratic ? u[QUADRATIC+i] * fabs(here[i]) : 0))
              * here[i];
  turn(f, R, load);
  turn(torque, R, load + 3);
  push(force, d, f);
  for (int i = 0; i < 3; i++) force[i] += torque[i];
}

/* Momentum that leaves at a trailing edge: m w^2 / 2 along the chord, less m w u+ along the normal. */
static void thrust(mjtNum* force, const mjtNum* u, const mjtNum* R, const mjtNum* body,
                   const mjtNum* motion) {
  mjtNum at[3], chord[3], normal[3], speed[3], f[3], along = 0, across = 0;
  turn(at, R, u + EDGE);
  turn(chord, R, u + CHORD);
  turn(normal, R, u + NORMAL);
  for (int i = 0; i < 3; i++) at[i] += body[i];
  cross(speed, motion, at);
  for (int i = 0; i < 3; i++) {
    along += chord[i] * (speed[i] + motion[3+i]);
    across += normal[i] * (speed[i] + motion[3+i]);
  }
  mjtNum m = u[SCALE] * u[SHED], shed = along > 0 ? along : 0;
  for (int i = 0; i < 3; i++)
    f[i] = m * across * (0.5 * across * chord[i] - shed * normal[i]);
  push(force, at, f);
}

static mjtNum along(const mjtNum* axis, const mjtNum* f) {
  mjtNum turning = axis[0]*f[0] + axis[1]*f[1] + axis[2]*f[2];
  return turning + (axis[3]*f[3] + axis[4]*f[4] + axis[5]*f[5]);
}

static void add_inertia(const mjModel* m, mjData* d, Inertia* K, mjtNum* wet) {
  for (int b = m->nbody - 1; b > 0; b--) {
    int up = m->body_parentid[b];
    if (wet[b] == 0 || up == 0) continue;
    if (wet[up] == 0) K[up] = K[b];
    else {
      add(K[up].A, K[b].A);
      add(K[up].B, K[b].B);
      add(K[up].T, K[b].T);
      add(K[up].C, K[b].C);
    }
    wet[up] = 1;
  }
  for (int i = 0; i < m->nv; i++) {
    int b = m->dof_bodyid[i];
    if (wet[b] == 0) continue;
    mjtNum p[6];
    momentum(p, K + b, d->cdof + 6*i);
    int first = m->M_rowadr[i];
    for (int k = 0; k < m->M_rownnz[i]; k++) {
      const mjtNum* axis = d->cdof + 6*m->M_colind[first+k];
      d->M[first+k] += along(axis, p);
    }
  }
  d->crb[0] = WETTED;
  factor(m, d);
}

static int any_wet(const mjModel* m) {
  if (m->nuser_body < FEWER) return 0;
  for (int b = 1; b < m->nbody; b++) {
    const mjtNum* u = m->body_user + (size_t)b * m->nuser_body;
    if (u[MARK] == SIGNATURE && u[SCALE] != 0) return 1;
  }
  return 0;
}

void morph_fluid(const mjModel* m, mjData* d) {
  static const mjtNum still[3] = {0, 0, 0};
  if (!any_wet(m)) return;
  mark(d);
  size_t n = m->nbody;
  mjtNum* memory = allocate(d, n * (48 + 6 + 6 + 1));
  Inertia* K = (Inertia*)memory;
  mjtNum *rate = memory + 48*n, *force = rate + 6*n, *wet = force + 6*n;
  const mjtNum* gravity = (m->opt.disableflags & mjDSBL_GRAVITY) ? still : m->opt.gravity;

  for (int i = 0; i < 6; i++) rate[i] = 0;
  for (int b = 1; b < m->nbody; b++) {
    const mjtNum* u = m->body_user + (size_t)b * m->nuser_body;
    mjtNum *a = rate + 6*b, *f = force + 6*b;
    for (int i = 0; i < 6; i++) { a[i] = rate[6*m->body_parentid[b]+i]; f[i] = 0; }
    for (int k = m->body_dofadr[b]; k < m->body_dofadr[b] + m->body_dofnum[b]; k++)
      for (int i = 0; i < 6; i++) a[i] += d->cdof_dot[6*k+i] * d->qvel[k];
    wet[b] = u[MARK] == SIGNATURE && u[SCALE] != 0;
    if (wet[b] == 0) continue;

    /* In axes that move with the current: v - U, and a + w x U, as the point of reference stays. */
    const mjtNum *R = d->xmat + 9*b, *centre = d->subtree_com + 3*m->body_rootid[b];
    mjtNum body[3], point[3], motion[6], slope[6];
    turn(point, R, u + POINT);
    for (int i = 0; i < 3; i++) {
      body[i] = d->xpos[3*b+i] - centre[i];
      point[i] += body[i];
      motion[i] = d->cvel[6*b+i];
      motion[3+i] = d->cvel[6*b+3+i] - u[CURRENT+i];
    }
    for (int i = 0; i < 6; i++) slope[i] = a[i];
    add_cross(slope + 3, motion, u + CURRENT);
    placed(K + b, u + ADDED, u[SCALE], R, point);
    inertial(f, K + b, motion, slope);
    if (u[DISPLACED] != 0) buoyancy(f, u, R, body, gravity);
    const mjtNum* apart = m->nuser_body < WIDTH ? still : u + APART;
    int same = apart[0] == 0 && apart[1] == 0 && apart[2] == 0;
    if (same || any(u + LINEAR)) drag(f, u, 1, same, R, point, motion);
    if (!same && any(u + QUADRATIC)) {
      mjtNum other[3];
      turn(other, R, apart);
      for (int i = 0; i < 3; i++) other[i] += point[i];
      drag(f, u, 0, 1, R, other, motion);
    }
    if (u[SHED] != 0) thrust(f, u, R, body, motion);
  }
  for (int b = m->nbody - 1; b > 0; b--) {
    const mjtNum* f = force + 6*b;
    for (int k = m->body_dofadr[b]; k < m->body_dofadr[b] + m->body_dofnum[b]; k++) {
      const mjtNum* axis = d->cdof + 6*k;
      d->qfrc_passive[k] += along(axis, f);
    }
    int up = m->body_parentid[b];
    if (up > 0)
      for (int i = 0; i < 6; i++) force[6*up+i] += f[i];
  }
  if (d->crb[0] != WETTED) add_inertia(m, d, K, wet);
  release(d);
}
