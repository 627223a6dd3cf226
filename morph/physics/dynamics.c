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
static void (*jacobian)(const mjModel*, const mjData*, mjtNum*, mjtNum*, const mjtNum*, int);
static void (*jacobian_rate)(const mjModel*, const mjData*, mjtNum*, mjtNum*, const mjtNum*, int);

/* Share of a row's pivot below which other constraints imply the row. */
#define IMPLIED 1e-8

/* MuJoCo's own functions come as pointers, so that nothing is linked. */
void morph_dynamics_bind(void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h,
			 void *i, void *j, void *k, void *l, void *o)
{
	forward = a, inverse = b, actuation = c, solve = d, positions = e, velocities = f;
	integrate = g, kinematics = h, com_axes = i, tendons = j, transmit = k;
	jacobian = l, jacobian_rate = o;
}

static void set(const mjModel *m, mjData *d, int64_t t, const double *q, const double *v,
		const double *u)
{
	memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
	memcpy(d->qvel, v + t * m->nv, sizeof(double) * m->nv);
	memcpy(d->ctrl, u + t * m->nu, sizeof(double) * m->nu);
}

/* Rows of J and right sides b of the constraints J qacc = b that hold joints together, at the state
 * of `d`, whose positions and velocities have been passed. A joint that follows another in
 * proportion, as URDF's mimic joints do, has one row: 1, and minus the ratio at its leader. Two
 * points held together (`connect`) have three. MuJoCo's own constraints are soft springs; these
 * are rigid, and what they are off returns critically damped at `RETURN` rad/s.
 * Source: Baumgarte 1972, Computer Methods in Applied Mechanics and Engineering 1(1), 1-16.
 * Those of other kinds are left out. `part` receives the constraint of each row, `off` (or NULL) by how much it is off. */
#define RETURN 50.0

static int most_rows(const mjModel *m)
{
	return 3 * m->neq;
}

static void point_of(const mjModel *m, const mjData *d, int e, int side, mjtNum point[3], int *body)
{
	int id = side ? m->eq_obj2id[e] : m->eq_obj1id[e];
	if (m->eq_objtype[e] == mjOBJ_SITE) {
		*body = m->site_bodyid[id];
		memcpy(point, d->site_xpos + 3 * id, 3 * sizeof(mjtNum));
		return;
	}
	const mjtNum *local = m->eq_data + e * mjNEQDATA + 3 * side, *turn = d->xmat + 9 * id;
	*body = id;
	for (int i = 0; i < 3; i++)
		point[i] = d->xpos[3 * id + i] + turn[3 * i] * local[0] + turn[3 * i + 1] * local[1] +
			   turn[3 * i + 2] * local[2];
}

static int constraints(const mjModel *m, mjData *d, double *J, int *part, double *b, double *off)
{
	int n = m->nv, rows = 0;
	mjtNum one[3 * n + 1], other[3 * n + 1], here[3], there[3];
	for (int e = 0; e < m->neq; e++) {
		const double *poly = m->eq_data + e * mjNEQDATA;
		if (!m->eq_active0[e])
			continue;
		if (m->eq_type[e] == mjEQ_JOINT) {
			int first = m->eq_obj1id[e], second = m->eq_obj2id[e];
			if (second < 0 || poly[2] != 0.0 || poly[3] != 0.0 || poly[4] != 0.0)
				continue;
			memset(J + rows * n, 0, sizeof(double) * n);
			J[rows * n + m->jnt_dofadr[first]] = 1.0;
			J[rows * n + m->jnt_dofadr[second]] = -poly[1];
			/* Its place is not a state of its own: it is put where its leader puts it. */
			b[rows] = 0.0;
			if (off)
				off[rows] = 0.0;
			part[rows++] = e;
		} else if (m->eq_type[e] == mjEQ_CONNECT) {
			int first, second;
			point_of(m, d, e, 0, here, &first);
			point_of(m, d, e, 1, there, &second);
			jacobian_rate(m, d, one, NULL, here, first);
			jacobian_rate(m, d, other, NULL, there, second);
			for (int i = 0; i < 3; i++) {
				double sum = -RETURN * RETURN * (here[i] - there[i]);
				for (int k = 0; k < n; k++)
					sum -= (one[i * n + k] - other[i * n + k]) * d->qvel[k];
				b[rows + i] = sum;
				if (off)
					off[rows + i] = here[i] - there[i];
			}
			jacobian(m, d, one, NULL, here, first);
			jacobian(m, d, other, NULL, there, second);
			for (int i = 0; i < 3; i++, rows++) {
				double speed = 0.0;
				part[rows] = e;
				for (int k = 0; k < n; k++) {
					J[rows * n + k] = one[i * n + k] - other[i * n + k];
					speed += J[rows * n + k] * d->qvel[k];
				}
				b[rows] -= 2.0 * RETURN * speed;
			}
		}
	}
	return rows;
}

/* M^-1 J' (rows, n) and the Cholesky factor (rows, rows) of J M^-1 J' at the state of `d`. Returns
 * how many rows count, in the order of `order`: those that the others imply, as one of the three of
 * a planar chain, are left out. The row of which most is left comes next, in units of the largest
 * of its constraint: taken in turn, one that is nearly implied would magnify what contradicts it. */
static int tie(const mjModel *m, mjData *d, int rows, const double *J, const int *part,
	       double *along, double *factor, int *order)
{
	int n = m->nv, rank = 0;
	double most[m->neq + 1], left[rows + 1];
	memset(most, 0, sizeof most);
	for (int r = 0; r < rows; r++) {
		left[r] = 0.0;
		order[r] = r;
		solve(m, d, along + r * n, J + r * n, 1);
		for (int i = 0; i < n; i++)
			left[r] += J[r * n + i] * along[r * n + i];
		if (left[r] > most[part[r]])
			most[part[r]] = left[r];
	}
	for (; rank < rows; rank++) {
		int best = rank;
		for (int k = rank + 1; k < rows; k++)
			if (left[order[k]] * most[part[order[best]]] >
			    left[order[best]] * most[part[order[k]]])
				best = k;
		int row = order[best];
		if (!(left[row] > IMPLIED * most[part[row]]))
			break;
		order[best] = order[rank];
		order[rank] = row;
		/* Rows of the factor keep the number of their constraint's row, columns their turn. */
		double pivot = sqrt(left[row]);
		factor[row * rows + rank] = pivot;
		for (int k = rank + 1; k < rows; k++) {
			int other = order[k];
			double sum = 0.0;
			for (int i = 0; i < n; i++)
				sum += J[other * n + i] * along[row * n + i];
			for (int c = 0; c < rank; c++)
				sum -= factor[other * rows + c] * factor[row * rows + c];
			factor[other * rows + rank] = sum / pivot;
			left[other] -= factor[other * rows + rank] * factor[other * rows + rank];
		}
	}
	return rank;
}

/* Gauss's principle: the vector nearest to x, in the metric of M, of which J x = b (0 if NULL). */
static void project(int n, int rows, int rank, const double *J, const double *b,
		    const double *along, const double *factor, const int *order, double *x)
{
	double force[rank + 1];
	for (int r = 0; r < rank; r++) {
		int row = order[r];
		force[r] = b ? -b[row] : 0.0;
		for (int i = 0; i < n; i++)
			force[r] += J[row * n + i] * x[i];
		for (int k = 0; k < r; k++)
			force[r] -= factor[row * rows + k] * force[k];
		force[r] /= factor[row * rows + r];
	}
	for (int r = rank - 1; r >= 0; r--) {
		for (int k = r + 1; k < rank; k++)
			force[r] -= factor[order[k] * rows + r] * force[k];
		force[r] /= factor[order[r] * rows + r];
	}
	for (int r = 0; r < rank; r++)
		for (int i = 0; i < n; i++)
			x[i] -= along[order[r] * n + i] * force[r];
}

/* Accelerations (states, nv). */
void morph_forward(const mjModel *m, mjData *d, int64_t states, const double *q, const double *v,
		   const double *u, double *found)
{
	int n = m->nv, most = most_rows(m), part[most + 1], order[most + 1];
	double J[most * n + 1], b[most + 1], along[most * n + 1], factor[most * most + 1];
	for (int64_t t = 0; t < states; t++) {
		set(m, d, t, q, v, u);
		forward(m, d, mjSTAGE_NONE, 1);
		int rows = constraints(m, d, J, part, b, NULL);
		int rank = tie(m, d, rows, J, part, along, factor, order);
		project(n, rows, rank, J, b, along, factor, order, d->qacc);
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
	int n = m->nv, most = most_rows(m), part[most + 1], order[most + 1];
	double above[n], axis[n], column[n];
	double J[most * n + 1], b[most + 1], along[most * n + 1], factor[most * most + 1];
	for (int64_t t = 0; t < states; t++) {
		double *to = found + t * n * 3 * n;
		set(m, d, t, q, v, u);
		forward(m, d, mjSTAGE_NONE, 1);
		int rows = constraints(m, d, J, part, b, NULL);
		int rank = tie(m, d, rows, J, part, along, factor, order);
		for (int k = 0; k < n; k++) {
			memset(axis, 0, sizeof axis);
			axis[k] = 1.0;
			solve(m, d, column, axis, 1);
			project(n, rows, rank, J, NULL, along, factor, order, column);
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
				if (rows)
					constraints(m, d, J, part, b, NULL);
				if (k < n)
					rank = tie(m, d, rows, J, part, along, factor, order);
				project(n, rows, rank, J, b, along, factor, order, d->qacc);
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

/* Positions (states, nq) moved to where chains close, by Gauss-Newton steps in the metric of M. */
void morph_closed(const mjModel *m, mjData *d, int64_t states, int steps, double *q)
{
	int n = m->nv, most = most_rows(m), part[most + 1], order[most + 1];
	double J[most * n + 1], b[most + 1], along[most * n + 1], factor[most * most + 1];
	double off[most + 1], step[n];
	memset(d->qvel, 0, sizeof(double) * n);
	for (int64_t t = 0; t < states; t++)
		for (int k = 0; k < steps; k++) {
			memcpy(d->qpos, q + t * m->nq, sizeof(double) * m->nq);
			positions(m, d);
			velocities(m, d);
			int rows = constraints(m, d, J, part, b, off);
			int rank = tie(m, d, rows, J, part, along, factor, order);
			for (int r = 0; r < rows; r++)
				off[r] = -off[r];
			memset(step, 0, sizeof step);
			project(n, rows, rank, J, off, along, factor, order, step);
			integrate(m, q + t * m->nq, step, 1.0);
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
