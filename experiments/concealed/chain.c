/* Rigid-body trees of hinges and slides with drives, friction and fluid forces.
 *
 * Dynamics: recursive Newton-Euler and composite rigid bodies (Featherstone 2008, tables 5.1 and
 * 6.2), every spatial vector [angular; linear] at the world's origin in world axes.
 * Time stepping: Moreau's midpoint rule (Moreau 1988): half a drift, forces at the middle with the
 * velocity extrapolated there, dry friction as set-valued impulses by projected Gauss-Seidel, half
 * a drift. A joint that its friction can hold has velocity exactly 0.
 *
 * `fields.py` writes the indices J_* (per joint), B_* (per body), S_* (states) and N_* in front.
 */
#include <math.h>
#include <string.h>

#define MOST 16
#define JOINT(f, i) (w->joint[(f) * w->n + (i)])
#define BODY(f, i) (w->body[(f) * w->n + (i)])
#define STATE(f, i) (s[(f) * w->n + (i)])

typedef struct {
  int n;
  const int *parent, *slide;
  const double *rotation; /* n x 9, of each frame in its parent's at q = 0 */
  const double *origin;   /* n x 3, in the parent's frame */
  const double *axis;     /* n x 3, in the body's frame */
  const double *inertia;  /* n x 9, about the centre of mass, in the body's frame */
  const double *gravity;  /* 3 */
  const double *current;  /* 3, velocity of the fluid */
  const double *joint, *body;
} World;

typedef struct {
  double R[MOST][9], p[MOST][3], S[MOST][6], v[MOST][6], I[MOST][36], A[MOST][36];
  double M[MOST * MOST], bias[MOST];
} Work;

static void matmul(const double *a, const double *b, double *c) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}
static void rotate(const double *R, const double *x, double *y) {
  for (int i = 0; i < 3; i++) y[i] = R[3 * i] * x[0] + R[3 * i + 1] * x[1] + R[3 * i + 2] * x[2];
}
static void unrotate(const double *R, const double *x, double *y) {
  for (int i = 0; i < 3; i++) y[i] = R[i] * x[0] + R[3 + i] * x[1] + R[6 + i] * x[2];
}
static void cross(const double *a, const double *b, double *c) {
  double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
  c[0] = x;
  c[1] = y;
}
static double dot(const double *a, const double *b, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}
static double sign(double x) { return (x > 0) - (x < 0); }
static double clip(double x, double most) { return x > most ? most : x < -most ? -most : x; }

/* Add to the spatial matrix `out` the inertia of a diagonal mass matrix m and a moment of inertia J
 * (both world axes, 3 x 3) that refer to the point c. */
static void add_inertia(const double *m, const double *J, const double *c, double *out) {
  double X[9] = {0, -c[2], c[1], c[2], 0, -c[0], -c[1], c[0], 0}, Xm[9], XmX[9];
  matmul(X, m, Xm);
  matmul(Xm, X, XmX);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      out[6 * i + j] += J[3 * i + j] - XmX[3 * i + j];
      out[6 * i + 3 + j] += Xm[3 * i + j];
      out[6 * (3 + j) + i] += Xm[3 * i + j];
      out[6 * (3 + i) + 3 + j] += m[3 * i + j];
    }
}

static void turned_diagonal(const double *R, const double *d, double *out) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int k = 0; k < 3; k++) sum += R[3 * i + k] * d[k] * R[3 * j + k];
      out[3 * i + j] = sum;
    }
}

/* v x* f: the rate of change of a spatial force carried along with v. */
static void cross_force(const double *v, const double *f, double *out) {
  double a[3], b[3], c[3];
  cross(v, f, a);
  cross(v + 3, f + 3, b);
  cross(v, f + 3, c);
  for (int k = 0; k < 3; k++) {
    out[k] = a[k] + b[k];
    out[3 + k] = c[k];
  }
}

static void add_force(double *f, const double *point, const double *force, const double *moment) {
  double m[3];
  cross(point, force, m);
  for (int k = 0; k < 3; k++) {
    f[k] += m[k] + (moment ? moment[k] : 0);
    f[3 + k] += force[k];
  }
}

static int has_fluid(const World *w, int i) {
  for (int k = B_linear; k < B_buoyancy + 1; k++)
    if (BODY(k, i) != 0) return 1;
  return BODY(B_thrust, i) != 0;
}

/* Poses, axes, inertias and velocities of all bodies. */
static void kinematics(const World *w, const double *q, const double *v, Work *k) {
  for (int i = 0; i < w->n; i++) {
    int up = w->parent[i];
    const double *a = w->axis + 3 * i;
    double fixed[9], turn[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, o[3] = {0, 0, 0}, axis[3];
    if (up >= 0) {
      matmul(k->R[up], w->rotation + 9 * i, fixed);
      rotate(k->R[up], w->origin + 3 * i, o);
      for (int c = 0; c < 3; c++) o[c] += k->p[up][c];
    } else {
      memcpy(fixed, w->rotation + 9 * i, sizeof fixed);
      memcpy(o, w->origin + 3 * i, sizeof o);
    }
    rotate(fixed, a, axis);
    if (w->slide[i]) {
      for (int c = 0; c < 3; c++) {
        o[c] += axis[c] * q[i];
        k->S[i][c] = 0;
        k->S[i][3 + c] = axis[c];
      }
    } else {
      double x = cos(q[i]), y = sin(q[i]), z = 1 - x; /* Rodrigues */
      for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) turn[3 * r + c] = z * a[r] * a[c] + (r == c) * x;
      turn[1] -= y * a[2]; turn[2] += y * a[1]; turn[3] += y * a[2];
      turn[5] -= y * a[0]; turn[6] -= y * a[1]; turn[7] += y * a[0];
      memcpy(k->S[i], axis, sizeof axis);
      cross(o, axis, k->S[i] + 3);
    }
    matmul(fixed, turn, k->R[i]);
    memcpy(k->p[i], o, sizeof o);
    for (int c = 0; c < 6; c++) k->v[i][c] = (up >= 0 ? k->v[up][c] : 0) + k->S[i][c] * v[i];
    double com[3], local[3] = {BODY(B_cx, i), BODY(B_cy, i), BODY(B_cz, i)}, m[9] = {0}, T[9], J[9];
    rotate(k->R[i], local, com);
    for (int c = 0; c < 3; c++) com[c] += o[c];
    m[0] = m[4] = m[8] = BODY(B_mass, i);
    matmul(k->R[i], w->inertia + 9 * i, T);
    for (int r = 0; r < 3; r++)
      for (int c = 0; c < 3; c++) J[3 * r + c] = dot(T + 3 * r, k->R[i] + 3 * c, 3);
    memset(k->I[i], 0, sizeof k->I[i]);
    add_inertia(m, J, com, k->I[i]);
  }
}

/* Forces of the world on body i, but gravity: fluid, thrust, tether, push, flywheel. */
static void outer_force(const World *w, const Work *k, int i, double t, double *f) {
  double point[3], local[3] = {BODY(B_fx, i), BODY(B_fy, i), BODY(B_fz, i)}, u[3], x[3];
  rotate(k->R[i], local, point);
  for (int c = 0; c < 3; c++) point[c] += k->p[i][c];
  cross(k->v[i], point, u);
  for (int c = 0; c < 3; c++) u[c] += k->v[i][3 + c];
  if (has_fluid(w, i)) {
    double slip[3], turn[3], force[3], moment[3], F[3], T[3];
    for (int c = 0; c < 3; c++) x[c] = u[c] - w->current[c];
    unrotate(k->R[i], x, slip);
    unrotate(k->R[i], k->v[i], turn);
    for (int c = 0; c < 3; c++) {
      force[c] = -(BODY(B_linear + c, i) + BODY(B_quadratic + c, i) * fabs(slip[c])) * slip[c];
      moment[c] =
          -(BODY(B_linear + 3 + c, i) + BODY(B_quadratic + 3 + c, i) * fabs(turn[c])) * turn[c];
    }
    if (BODY(B_thrust, i) != 0) {
      /* Lighthill 1971, the terms at the tail: m w^2 / 2 along the chord and -m w u across; the
       * chord is the direction from the edge to the body's origin, the normal is the axis. */
      double chord[3], normal[3], length = sqrt(dot(local, local, 3));
      for (int c = 0; c < 3; c++) chord[c] = -local[c] / length;
      cross(w->axis + 3 * i, chord, normal);
      double along = dot(slip, chord, 3), across = dot(slip, normal, 3), m = BODY(B_thrust, i);
      for (int c = 0; c < 3; c++)
        force[c] += 0.5 * m * across * across * chord[c] -
                    m * across * (along > 0 ? along : 0) * normal[c];
    }
    rotate(k->R[i], force, F);
    rotate(k->R[i], moment, T);
    F[2] += BODY(B_buoyancy, i);
    add_force(f, point, F, T);
  }
  if (BODY(B_tether_k, i) != 0) {
    double pull[3];
    for (int c = 0; c < 3; c++) pull[c] = BODY(B_anchor + c, i) - point[c];
    double distance = sqrt(dot(pull, pull, 3)), past = distance - BODY(B_tether_length, i);
    if (past > 0) {
      for (int c = 0; c < 3; c++) pull[c] *= BODY(B_tether_k, i) * past / distance;
      add_force(f, point, pull, 0);
    }
  }
  if (t >= BODY(B_push_start, i) && t < BODY(B_push_end, i)) {
    double com[3], c0[3] = {BODY(B_cx, i), BODY(B_cy, i), BODY(B_cz, i)}, push[3];
    rotate(k->R[i], c0, com);
    for (int c = 0; c < 3; c++) {
      com[c] += k->p[i][c];
      push[c] = BODY(B_push + c, i);
    }
    add_force(f, com, push, 0);
  }
  if (BODY(B_spin, i) != 0) {
    /* A flywheel of constant spin h along the body's z: the body feels -w x h. */
    double h[3] = {k->R[i][2] * BODY(B_spin, i), k->R[i][5] * BODY(B_spin, i),
                   k->R[i][8] * BODY(B_spin, i)}, moment[3], none[3] = {0, 0, 0};
    cross(h, k->v[i], moment);
    add_force(f, point, none, moment);
  }
}

/* Mass matrix (without rotors) and bias force at (q, v), less the world's forces. */
static void dynamics(const World *w, const double *q, const double *v, double t, Work *k) {
  int n = w->n;
  double acc[MOST][6], f[MOST][6];
  kinematics(w, q, v, k);
  for (int i = 0; i < n; i++) {
    int up = w->parent[i];
    double rate[6], h[6], a[3], b[3], c[3], pull[6] = {0};
    for (int r = 0; r < 6; r++) rate[r] = k->S[i][r] * v[i];
    cross(k->v[i], rate, a);
    cross(k->v[i], rate + 3, b);
    cross(k->v[i] + 3, rate, c);
    for (int r = 0; r < 3; r++) {
      acc[i][r] = (up >= 0 ? acc[up][r] : 0) + a[r];
      acc[i][3 + r] = (up >= 0 ? acc[up][3 + r] : -w->gravity[r]) + b[r] + c[r];
    }
    for (int r = 0; r < 6; r++) h[r] = dot(k->I[i] + 6 * r, k->v[i], 6);
    cross_force(k->v[i], h, f[i]);
    for (int r = 0; r < 6; r++) f[i][r] += dot(k->I[i] + 6 * r, acc[i], 6);
    if (BODY(B_added, i) != 0 || BODY(B_added + 1, i) != 0 || BODY(B_added + 2, i) != 0) {
      /* Kirchhoff: inertia of the fluid moved along; gravity does not pull on it. */
      double d[6], m[9], J[9], point[3], local[3] = {BODY(B_fx, i), BODY(B_fy, i), BODY(B_fz, i)};
      double slip[6], extra[6], still[6];
      for (int r = 0; r < 6; r++) d[r] = BODY(B_added + r, i);
      turned_diagonal(k->R[i], d, m);
      turned_diagonal(k->R[i], d + 3, J);
      rotate(k->R[i], local, point);
      for (int r = 0; r < 3; r++) point[r] += k->p[i][r];
      memset(k->A[i], 0, sizeof k->A[i]);
      add_inertia(m, J, point, k->A[i]);
      for (int r = 0; r < 6; r++) {
        slip[r] = k->v[i][r] - (r < 3 ? 0 : w->current[r - 3]);
        still[r] = acc[i][r] + (r < 3 ? 0 : w->gravity[r - 3]);
      }
      for (int r = 0; r < 6; r++) h[r] = dot(k->A[i] + 6 * r, slip, 6);
      cross_force(slip, h, extra);
      for (int r = 0; r < 6; r++) f[i][r] += extra[r] + dot(k->A[i] + 6 * r, still, 6);
      for (int r = 0; r < 36; r++) k->I[i][r] += k->A[i][r];
    }
    outer_force(w, k, i, t, pull);
    for (int r = 0; r < 6; r++) f[i][r] -= pull[r];
  }
  memset(k->M, 0, sizeof(double) * n * n);
  for (int i = n - 1; i >= 0; i--) {
    int up = w->parent[i];
    double column[6];
    k->bias[i] = dot(k->S[i], f[i], 6);
    for (int r = 0; r < 6; r++) column[r] = dot(k->I[i] + 6 * r, k->S[i], 6);
    for (int j = i; j >= 0; j = w->parent[j])
      k->M[n * i + j] = k->M[n * j + i] = dot(k->S[j], column, 6);
    if (up >= 0) {
      for (int r = 0; r < 36; r++) k->I[up][r] += k->I[i][r];
      for (int r = 0; r < 6; r++) f[up][r] += f[i][r];
    }
  }
}

/* M becomes its inverse, by Cholesky. */
static void invert(double *M, int n) {
  double L[MOST * MOST] = {0}, X[MOST * MOST] = {0};
  for (int j = 0; j < n; j++) {
    L[n * j + j] = sqrt(M[n * j + j] - dot(L + n * j, L + n * j, j));
    for (int i = j + 1; i < n; i++)
      L[n * i + j] = (M[n * i + j] - dot(L + n * i, L + n * j, j)) / L[n * j + j];
  }
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++) {
      double sum = i == j;
      for (int k = j; k < i; k++) sum -= L[n * i + k] * X[n * k + j];
      X[n * i + j] = sum / L[n * i + i];
    }
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double sum = 0;
      for (int k = i; k < n; k++) sum += X[n * k + i] * X[n * k + j];
      M[n * i + j] = M[n * j + i] = sum;
    }
}

/* Torque of motor i at its speed, after what its drive does to it; `demand` from `demanded`. */
static double produced(const World *w, int i, const double *s, double demand, double total,
                       double speed, double command, double t) {
  double x = demand;
  x *= JOINT(J_gain, i) * (1 - (1 - JOINT(J_heat_floor, i)) * STATE(S_heat, i));
  x /= 1 + JOINT(J_sag, i) * total;
  x *= 1 + JOINT(J_supply, i) * sin(6.283185307179586 * JOINT(J_supply_rate, i) * t);
  x = clip(x, JOINT(J_limit, i));
  if (JOINT(J_no_load, i) > 0 && x * speed > 0) {
    double left = JOINT(J_stall, i) * (1 - fabs(speed) / JOINT(J_no_load, i));
    x = clip(x, left > 0 ? left : 0);
  }
  if (command != 0) x -= JOINT(J_emf, i) * speed;
  return x;
}

static double demanded(const World *w, int i, double u, double q, double v) {
  double x = u;
  if (JOINT(J_drive, i) == 0) return 0;
  if (JOINT(J_drive, i) == 2) x = JOINT(J_kp, i) * (u - q) - JOINT(J_kv, i) * v;
  return x - clip(x, JOINT(J_dead, i));
}

/* Dry friction that joint i can hold at a speed, load and position. */
static double level(const World *w, int i, const double *s, double q, double v, double load) {
  double c = JOINT(J_coulomb, i), x = c;
  if (JOINT(J_stiction, i) > c) {
    double r = v / JOINT(J_stribeck, i);
    x += (JOINT(J_stiction, i) - c) * exp(-r * r);
  }
  if (JOINT(J_load_k, i) != 0) x += JOINT(J_load_c, i) + JOINT(J_load_k, i) * fabs(load);
  if (JOINT(J_patch, i) != 0)
    x += JOINT(J_patch, i) *
         (1 + JOINT(J_patch_depth, i) * sin(JOINT(J_patch_n, i) * q + JOINT(J_patch_phase, i)));
  if (JOINT(J_memory, i) != 0) x *= 1 + JOINT(J_memory, i) * sign(v) * STATE(S_memory, i);
  return x;
}

/* Forces of joint i itself that are smooth in its state. */
static double passive(const World *w, int i, const double *s, double q, double v) {
  double x = -(JOINT(J_viscous, i) + JOINT(J_quadratic, i) * fabs(v)) * v;
  x -= JOINT(J_stiffness, i) * (q - JOINT(J_rest, i));
  x += JOINT(J_cog, i) * sin(JOINT(J_cog_n, i) * q + JOINT(J_cog_phase, i));
  x -= JOINT(J_loop, i) * STATE(S_loop, i);
  x -= JOINT(J_warm, i) * exp(-STATE(S_warm, i)) * v;
  if (JOINT(J_stop_side, i) != 0) {
    double side = JOINT(J_stop_side, i), depth = side * (q - JOINT(J_stop, i));
    if (depth > 0) {
      double push = JOINT(J_stop_k, i) * depth + JOINT(J_stop_d, i) * side * v;
      if (push > 0) x -= side * push;
    }
  }
  return x;
}

static double coupling(const World *w, double strain, double rate, int i) {
  double half = 0.5 * JOINT(J_gap, i), past = strain - clip(strain, half), x;
  if (half > 0 && past == 0) return 0;
  x = JOINT(J_spring_k, i) * past + JOINT(J_spring_d, i) * rate;
  /* With play, teeth push and never pull. */
  return half > 0 && x * past < 0 ? 0 : x;
}

/* One step of length h from state s at time t under the commands u. */
static void step(const World *w, double *s, const double *u, double t, double h, Work *k) {
  int n = w->n;
  double q[MOST], v[MOST], force[MOST], most[MOST], free_v[MOST], demand[MOST], total = 0;
  double rotor_v[MOST];
  for (int i = 0; i < n; i++) {
    q[i] = STATE(S_q, i) + 0.5 * h * STATE(S_v, i);
    v[i] = 1.5 * STATE(S_v, i) - 0.5 * STATE(S_before, i);
    double T = JOINT(J_lag, i);
    if (T > 0 && !isnan(STATE(S_lag, i))) STATE(S_lag, i) += (u[i] - STATE(S_lag, i)) * -expm1(-h / T);
    else STATE(S_lag, i) = u[i];
  }
  dynamics(w, q, v, t + 0.5 * h, k);
  for (int i = 0; i < n; i++) {
    int split = JOINT(J_split, i) != 0;
    double x = split ? STATE(S_rotor_q, i) + 0.5 * h * STATE(S_rotor_v, i) : q[i];
    rotor_v[i] = split ? 1.5 * STATE(S_rotor_v, i) - 0.5 * STATE(S_rotor_before, i) : v[i];
    demand[i] = demanded(w, i, STATE(S_lag, i), x, rotor_v[i]);
    total += fabs(demand[i]);
  }
  for (int i = 0; i < n; i++) {
    double load = produced(w, i, s, demand[i], total, rotor_v[i], u[i], t);
    if (JOINT(J_drive, i) != 0) {
      double e = load / JOINT(J_heat_level, i);
      STATE(S_heat, i) += h * JOINT(J_heat_rate, i) * e * e * (1 - STATE(S_heat, i));
    }
    load *= 1 + JOINT(J_drum, i) * q[i] +
            JOINT(J_tooth, i) * JOINT(J_tooth_n, i) * cos(JOINT(J_tooth_n, i) * q[i]);
    if (JOINT(J_split, i) != 0) {
      double rotor_q = STATE(S_rotor_q, i) + 0.5 * h * STATE(S_rotor_v, i);
      double pull = coupling(w, rotor_q - q[i], rotor_v[i] - v[i], i);
      double next = STATE(S_rotor_v, i) + h * (load - pull) / JOINT(J_rotor, i);
      STATE(S_rotor_before, i) = STATE(S_rotor_v, i);
      STATE(S_rotor_v, i) = next;
      STATE(S_rotor_q, i) = rotor_q + 0.5 * h * next;
      load = pull;
    } else {
      k->M[n * i + i] += JOINT(J_rotor, i);
    }
    force[i] = load + passive(w, i, s, q[i], v[i]) - k->bias[i];
    most[i] = h * level(w, i, s, q[i], STATE(S_v, i), load);
  }
  for (int i = 0; i + 1 < n; i++) {
    if (JOINT(J_detent, i) == 0) continue;
    double pull = JOINT(J_detent, i) * sin(JOINT(J_detent_n, i) * (q[i] - q[i + 1]));
    force[i] -= pull;
    force[i + 1] += pull;
  }
  invert(k->M, n);
  double *W = k->M;
  for (int i = 0; i < n; i++) free_v[i] = STATE(S_v, i) + h * dot(W + n * i, force, n);
  int rubbing = 0, held[MOST] = {0};
  for (int i = 0; i < n; i++) rubbing += most[i] > 0;
  if (rubbing) {
    double impulse[MOST];
    /* The impulses of the last step, per unit time, are a good first guess. */
    for (int i = 0; i < n; i++) {
      impulse[i] = clip(h * STATE(S_rub, i), most[i]);
      for (int j = 0; j < n; j++) free_v[j] += W[n * j + i] * impulse[i];
    }
    for (int sweep = 0; sweep < (rubbing > 1 ? 100 : 1); sweep++) {
      double largest = 0;
      for (int i = 0; i < n; i++) {
        if (most[i] <= 0) continue;
        double wanted = impulse[i] - free_v[i] / W[n * i + i], next = clip(wanted, most[i]);
        double change = next - impulse[i];
        held[i] = fabs(wanted) <= most[i];
        impulse[i] = next;
        for (int j = 0; j < n; j++) free_v[j] += W[n * j + i] * change;
        if (fabs(change) > 1e-9 * most[i]) largest = 1;
      }
      if (largest == 0) break;
    }
    for (int i = 0; i < n; i++) STATE(S_rub, i) = impulse[i] / h;
  }
  for (int i = 0; i < n; i++) {
    if (held[i]) free_v[i] = 0;
    STATE(S_before, i) = STATE(S_v, i);
    STATE(S_v, i) = free_v[i];
    double mean = free_v[i];
    STATE(S_q, i) = q[i] + 0.5 * h * mean;
    if (JOINT(J_loop, i) != 0) {
      /* Dahl 1976: dz/dx = (1 - z sign v) / d, exact over the step's path. */
      double way = STATE(S_q, i) - (q[i] - 0.5 * h * STATE(S_before, i));
      STATE(S_loop, i) = sign(way) + (STATE(S_loop, i) - sign(way)) *
                                         exp(-fabs(way) / JOINT(J_loop_way, i));
    }
    if (JOINT(J_warm, i) != 0)
      STATE(S_warm, i) += h * JOINT(J_warm_rate, i) * mean * mean * (3 - STATE(S_warm, i));
    if (JOINT(J_memory, i) != 0)
      STATE(S_memory, i) += h / JOINT(J_memory_time, i) * (sign(mean) - STATE(S_memory, i));
  }
}

/* Wind rotors whose position is not known (NaN) by what they would carry if each turned with its
 * link: motion at rest, or smooth, before. Teeth touch on the side to which it is pushed. */
static void wind(const World *w, double *s, const double *u, double t, double h, Work *k) {
  int n = w->n, unknown = 0;
  double joint[N_JOINTS * MOST], next[N_STATES * MOST], total = 0, demand[MOST];
  for (int i = 0; i < n; i++) unknown += JOINT(J_split, i) != 0 && isnan(STATE(S_rotor_q, i));
  if (!unknown) return;
  memcpy(joint, w->joint, sizeof(double) * N_JOINTS * n);
  memcpy(next, s, sizeof(double) * N_STATES * n);
  for (int i = 0; i < n; i++) joint[J_split * n + i] = 0;
  World rigid = *w;
  rigid.joint = joint;
  step(&rigid, next, u, t, h, k);
  for (int i = 0; i < n; i++) {
    demand[i] = demanded(w, i, next[S_lag * n + i], STATE(S_q, i), STATE(S_v, i));
    total += fabs(demand[i]);
  }
  for (int i = 0; i < n; i++) {
    if (JOINT(J_split, i) == 0 || !isnan(STATE(S_rotor_q, i))) continue;
    double load = produced(w, i, s, demand[i], total, STATE(S_v, i), u[i], t);
    load -= JOINT(J_rotor, i) * (next[S_v * n + i] - STATE(S_v, i)) / h;
    STATE(S_rotor_q, i) = STATE(S_q, i) + load / JOINT(J_spring_k, i) +
                          0.5 * sign(load) * JOINT(J_gap, i);
  }
}

/* Simulate from step `first` to step `last`; return the number of the first bad step or `last`.
 *
 * ticks: step at which command c begins, ascending. feed: command planned for each tick. With
 * gains, the logger adds kp (reference - reading) - kd (change of the reading), both of its own
 * noisy and rounded readings, clips and rounds; `command` receives what was sent. `path` (of all
 * steps, q then v) holds the past already where first > 0 and is written after each step; `saved`
 * receives the state at the steps `save`. */
int march(int n, const int *parent, const int *slide, const double *rotation, const double *origin,
          const double *axis, const double *inertia, const double *gravity, const double *current,
          const double *joint, const double *body, double *s, int first, int last, double h,
          int ticks, const int *tick, const double *feed, const double *reference,
          const double *noise, double *reading, double *command, double *path, int saves,
          const int *save, double *saved) {
  World world = {n, parent, slide, rotation, origin, axis, inertia, gravity, current, joint, body};
  const World *w = &world;
  Work k;
  double u[MOST], slope[MOST] = {0};
  int next = 0, saving = 0;
  while (next < ticks && tick[next] < first) next++;
  for (int number = first; number <= last; number++) {
    for (int i = 0; i < n; i++) {
      path[2 * n * number + i] = STATE(S_q, i);
      path[2 * n * number + n + i] = STATE(S_v, i);
    }
    while (saving < saves && save[saving] < number) saving++;
    if (saving < saves && save[saving] == number)
      memcpy(saved + (size_t)N_STATES * n * saving, s, sizeof(double) * N_STATES * n);
    if (number == last) break;
    while (next < ticks && tick[next] == number) {
      for (int i = 0; i < n; i++) {
        double late = JOINT(J_shift, i) / h, x, c = feed[n * next + i];
        double place = number - late < 0 ? 0 : number - late;
        int below = place >= number ? number : (int)place;
        x = path[2 * n * below + i];
        if (below < number) x += (place - below) * (path[2 * n * (below + 1) + i] - x);
        x += JOINT(J_tooth, i) * sin(JOINT(J_tooth_n, i) * x);
        x = JOINT(J_scale, i) * x + JOINT(J_bias, i) + noise[n * next + i];
        if (JOINT(J_count, i) > 0) x = JOINT(J_count, i) * floor(x / JOINT(J_count, i) + 0.5);
        reading[n * next + i] = x;
        if (next > 0 && JOINT(J_track_d, i) != 0) {
          double raw = (x - reading[n * (next - 1) + i]) / (h * (number - tick[next - 1]));
          slope[i] += 0.3 * (raw - slope[i]);
        }
        if (JOINT(J_track_p, i) != 0 && isfinite(reference[n * next + i])) {
          c += JOINT(J_track_p, i) * (reference[n * next + i] - x) - JOINT(J_track_d, i) * slope[i];
          c = clip(c, JOINT(J_most, i));
        }
        command[n * next + i] = floor(c * 1e6 + 0.5) / 1e6;
      }
      next++;
    }
    for (int i = 0; i < n; i++) {
      /* Mean over the step of a command that acts `delay` later: a mix of two past ticks. */
      double late = JOINT(J_delay, i) / h;
      int whole = (int)late, c = next - 1;
      while (c >= 0 && tick[c] > number - whole) c--;
      double now = command[n * (c < 0 ? 0 : c) + i];
      while (c >= 0 && tick[c] > number - whole - 1) c--;
      u[i] = now + (late - whole) * (command[n * (c < 0 ? 0 : c) + i] - now);
    }
    if (number == first) wind(w, s, u, number * h, h, &k);
    step(w, s, u, number * h, h, &k);
    for (int i = 0; i < n; i++)
      if (!(fabs(STATE(S_v, i)) < 1e4)) return number;
  }
  return last;
}

/* Mass matrix and bias force, of bodies alone, at `count` states; for feedforward and tests. */
void mass_and_bias(int n, const int *parent, const int *slide, const double *rotation,
                   const double *origin, const double *axis, const double *inertia,
                   const double *gravity, const double *current, const double *joint,
                   const double *body, int count, const double *q, const double *v, double *M,
                   double *bias) {
  World w = {n, parent, slide, rotation, origin, axis, inertia, gravity, current, joint, body};
  Work k;
  for (int c = 0; c < count; c++) {
    dynamics(&w, q + n * c, v + n * c, -1.0, &k);
    memcpy(M + n * n * c, k.M, sizeof(double) * n * n);
    memcpy(bias + n * c, k.bias, sizeof(double) * n);
  }
}
