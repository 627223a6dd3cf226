/* A model's dynamics at each state of a motion: loops over MuJoCo's own functions.
 *
 * Called state by state from Python, most of the time would go into the calls.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include <mujoco/mujoco.h>

static void (*forward)(const mjModel*, mjData*, int, int), (*inverse)(const mjModel*, mjData*);
static void (*actuation)(const mjModel*, mjData*), (*solve)(const mjModel*, mjData*, mjtNum*, const mjtNum*, int);
static void (*positions)(const mjModel*, mjData*), (*velocities)(const mjModel*, mjData*);
static void (*integrate)(const mjModel*, mjtNum*, const mjtNum*, mjtNum);
static void (*kinematics)(const mjModel*, mjData*), (*com_axes)(const mjModel*, mjData*);
static void (*tendons)(const mjModel*, mjData*), (*transmit)(const mjModel*, mjData*);

/* MuJoCo's own functions come as pointers, so that nothing is linked. */
void morph_dynamics_bind(void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h,
			 void *i, void *j, void *k)
{
	forward = a, inverse = b, actuation = c, solve = d, positions = e, velocities = f;
	integrate = g, kinematics = h, com_axes = i, tendons = j, transmit = k;
}

static void set(const mjModel *m, mjData *d, int64_t t, const double *q, const double *v,
		const double *u)
{
	memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
	memcpy(d->qvel, v + t * m->nv, sizeof(double) * m->nv);
	memcpy(d->ctrl, u + t * m->nu, sizeof(double) * m->nu);
}

/* Joints that follow others in proportion, as URDF's mimic joints do: J qacc = 0 with a row of J for
 * each, 1 at the follower and minus the ratio at its leader. MuJoCo's own constraint is soft. Those
 * tied otherwise are left out.
 * Returns how many; `joint` (neq, 2) receives both degrees of freedom and `ratio` the ratios. */
static int followers(const mjModel *m, int *joint, double *ratio)
{
	int count = 0;
	for (int e = 0; e < m->neq; e++) {
		const double *poly = m->eq_data + e * mjNEQDATA;
		if (m->eq_type[e] != mjEQ_JOINT || !m->eq_active0[e] || m->eq_obj2id[e] < 0 ||
		    poly[2] != 0.0 || poly[3] != 0.0 || poly[4] != 0.0)
			continue;
		joint[2 * count] = m->jnt_dofadr[m->eq_obj1id[e]];
		joint[2 * count + 1] = m->jnt_dofadr[m->eq_obj2id[e]];
		ratio[count++] = poly[1];
	}
	return count;
}

/* M^-1 J' (rows, n) and the Cholesky factor of J M^-1 J' (rows, rows) at the state of `d`. */
static void tie(const mjModel *m, mjData *d, int rows, const int *joint, const double *ratio,
		double *along, double *factor)
{
	int n = m->nv;
	double row[n];
	for (int r = 0; r < rows; r++) {
		memset(row, 0, sizeof row);
		row[joint[2 * r]] = 1.0;
		row[joint[2 * r + 1]] = -ratio[r];
		solve(m, d, along + r * n, row, 1);
	}
	for (int r = 0; r < rows; r++)
		for (int c = 0; c <= r; c++) {
			double sum = along[c * n + joint[2 * r]] - ratio[r] * along[c * n + joint[2 * r + 1]];
			for (int k = 0; k < c; k++)
				sum -= factor[r * rows + k] * factor[c * rows + k];
			factor[r * rows + c] = r == c ? sqrt(sum) : sum / factor[c * rows + c];
		}
}

/* Gauss's principle: the acceleration nearest to x, in the metric of M, of which J x = 0. */
static void project(int n, int rows, const int *joint, const double *ratio, const double *along,
		    const double *factor, double *x)
{
	double force[rows + 1];
	for (int r = 0; r < rows; r++) {
		force[r] = x[joint[2 * r]] - ratio[r] * x[joint[2 * r + 1]];
		for (int k = 0; k < r; k++)
			force[r] -= factor[r * rows + k] * force[k];
		force[r] /= factor[r * rows + r];
	}
	for (int r = rows - 1; r >= 0; r--) {
		for (int k = r + 1; k < rows; k++)
			force[r] -= factor[k * rows + r] * force[k];
		force[r] /= factor[r * rows + r];
	}
	for (int r = 0; r < rows; r++)
		for (int i = 0; i < n; i++)
			x[i] -= along[r * n + i] * force[r];
}

/* Accelerations (states, nv). */
void morph_forward(const mjModel *m, mjData *d, int64_t states, const double *q, const double *v,
		   const double *u, double *found)
{
	int n = m->nv, joint[2 * m->neq + 1];
	double ratio[m->neq + 1], along[m->neq * n + 1], factor[m->neq * m->neq + 1];
	int rows = followers(m, joint, ratio);
	for (int64_t t = 0; t < states; t++) {
		set(m, d, t, q, v, u);
		forward(m, d, mjSTAGE_NONE, 1);
		tie(m, d, rows, joint, ratio, along, factor);
		project(n, rows, joint, ratio, along, factor, d->qacc);
		memcpy(found + t * n, d->qacc, sizeof(double) * n);
	}
}

/* Generalized forces (states, nv): those of the actuators less those that a motion needs. */
void morph_supplied(const mjModel *m, mjData *d, int64_t states, const double *q, const double *v,
		    const double *a, const double *u, double *found)
{
	int n = m->nv;
	for (int64_t t = 0; t < states; t++) {
		set(m, d, t, q, v, u);
		memcpy(d->qacc, a + t * n, sizeof(double) * n);
		inverse(m, d);
		actuation(m, d);
		for (int i = 0; i < n; i++)
			found[t * n + i] = d->qfrc_actuator[i] - d->qfrc_inverse[i];
	}
}

/* [dqacc/dq, dqacc/dv, M^-1] (states, n, 3n) by central differences, dq a move as of qvel. */
void morph_jacobians(const mjModel *m, mjData *d, int64_t states, double nudge, const double *q,
		     const double *v, const double *u, double *found)
{
	int n = m->nv, joint[2 * m->neq + 1];
	double above[n], axis[n], column[n];
	double ratio[m->neq + 1], along[m->neq * n + 1], factor[m->neq * m->neq + 1];
	int rows = followers(m, joint, ratio);
	for (int64_t t = 0; t < states; t++) {
		double *to = found + t * n * 3 * n;
		set(m, d, t, q, v, u);
		forward(m, d, mjSTAGE_NONE, 1);
		tie(m, d, rows, joint, ratio, along, factor);
		for (int k = 0; k < n; k++) {
			memset(axis, 0, sizeof axis);
			axis[k] = 1.0;
			solve(m, d, column, axis, 1);
			project(n, rows, joint, ratio, along, factor, column);
			for (int i = 0; i < n; i++)
				to[i * 3 * n + 2 * n + k] = column[i];
		}
		/* Velocities first: what depends on positions alone is still that of the state. */
		for (int k = 2 * n - 1; k >= 0; k--) {
			int skipped = k < n ? mjSTAGE_NONE : mjSTAGE_POS;
			for (int side = 1; side >= -1; side -= 2) {
				if (k < n) {
					memset(axis, 0, sizeof axis);
					axis[k] = 1.0;
					integrate(m, d->qpos, axis, side * nudge);
				} else
					d->qvel[k - n] += side * nudge;
				forward(m, d, skipped, 1);
				if (k < n)
					tie(m, d, rows, joint, ratio, along, factor);
				project(n, rows, joint, ratio, along, factor, d->qacc);
				if (side > 0)
					memcpy(above, d->qacc, sizeof above);
				memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
				memcpy(d->qvel, v + t * n, sizeof(double) * n);
			}
			for (int i = 0; i < n; i++)
				to[i * 3 * n + k] = (above[i] - d->qacc[i]) / (2.0 * nudge);
		}
	}
}

/* Lengths of actuators (states, nu) and their moments (states, nu, nv). */
void morph_transmissions(const mjModel *m, mjData *d, int64_t states, const double *q,
			 double *length, double *moment)
{
	memset(moment, 0, sizeof(double) * states * m->nu * m->nv);
	for (int64_t t = 0; t < states; t++) {
		memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
		kinematics(m, d);
		com_axes(m, d);
		tendons(m, d);
		transmit(m, d);
		memcpy(length + t * m->nu, d->actuator_length, sizeof(double) * m->nu);
		for (int i = 0; i < m->nu; i++) {
			double *row = moment + (t * m->nu + i) * m->nv;
			for (int k = 0; k < d->moment_rownnz[i]; k++) {
				int at = d->moment_rowadr[i] + k;
				row[d->moment_colind[at]] = d->actuator_moment[at];
			}
		}
	}
}

/* How bodies lie and move: spatial axes of joints and their rates (states, nv, 6); and of each
 * body its axes (states, bodies, 9), origin and the point about which the axes are (.., 3). */
void morph_kinematics(const mjModel *m, mjData *d, int64_t states, int bodies, const int *ids,
		      const double *q, const double *v, double *axes, double *rates, double *turned,
		      double *origin, double *about)
{
	int n = m->nv;
	for (int64_t t = 0; t < states; t++) {
		memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
		memcpy(d->qvel, v + t * n, sizeof(double) * n);
		positions(m, d);
		velocities(m, d);
		memcpy(axes + t * n * 6, d->cdof, sizeof(double) * n * 6);
		memcpy(rates + t * n * 6, d->cdof_dot, sizeof(double) * n * 6);
		for (int k = 0; k < bodies; k++) {
			int64_t at = t * bodies + k;
			memcpy(turned + at * 9, d->xmat + ids[k] * 9, sizeof(double) * 9);
			memcpy(origin + at * 3, d->xpos + ids[k] * 3, sizeof(double) * 3);
			memcpy(about + at * 3, d->subtree_com + m->body_rootid[ids[k]] * 3,
			       sizeof(double) * 3);
		}
	}
}
