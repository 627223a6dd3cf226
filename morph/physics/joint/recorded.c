/* Laws with a memory, followed along a recorded motion: the steps of hysteresis.py and backlash.py,
 * which act in simulations, for one joint and several values of a parameter. */
#include <math.h>
#include <stdint.h>

/* held (samples, width): hysteresis along positions `place` (samples) for displacements z (width). */
void morph_hysteresis(int64_t samples, int width, const double *place, const double *z, double *held)
{
	for (int c = 0; c < width; c++) {
		double h = 0.0;
		held[c] = 0.0;
		for (int64_t t = 1; t < samples; t++) {
			double move = (place[t] - place[t - 1]) / z[c];
			double sense = move < 0.0 ? -1.0 : 1.0, ahead = sense * h;
			double left = fabs(move) + fmin(ahead, 0.0);
			if (move != 0.0)
				h = sense * (left > 0.0 ? 1.0 - (1.0 - fmax(ahead, 0.0)) * exp(-left) : left);
			held[t * width + c] = h;
		}
	}
}

/* change (samples, width): by how much play of `gap` (width) changes the force on the link.
 *
 * effort, late, speed, slope, step (samples): what the motors produce, the link's mean velocity since
 * the sample before, its velocity, acceleration, and seconds to the next sample; stiffness and damping
 * of the motors, inertia of the rotor, and `light`, the least that it has. */
void morph_backlash(int64_t samples, int width, const double *effort, const double *late,
		    const double *speed, const double *slope, const double *step, double stiffness,
		    double damping, double inertia, double light, const double *gap, double *change)
{
	double heavy = fmax(inertia, light);
	for (int c = 0; c < width; c++) {
		double half = 0.5 * gap[c], side = effort[0] < 0.0 ? -1.0 : 1.0;
		double ahead = side * half, rate = late[0];
		int met = 0;
		for (int64_t t = 0; t < samples; t++) {
			double h = step[t], lead = side != 0.0 ? 0.0 : rate - speed[t];
			double u = effort[t] - stiffness * ahead - damping * lead;
			double past = met || t == 0 ? 0.0 : slope[t - 1];
			int pushes = side != 0.0 && side * (u - inertia * past) >= 0.0;
			double from = side != 0.0 ? late[t] : rate;
			rate = from + h * u / (heavy + h * damping + h * h * stiffness);
			double place = ahead + h * (rate - (late[t] + h * past));
			int meets = !pushes && fabs(place) >= half;
			double felt = pushes ? u : meets ? heavy * (rate - late[t]) / h : 0.0;
			if (!pushes) {
				side = !meets ? 0.0 : place < 0.0 ? -1.0 : 1.0;
				ahead = fmin(fmax(place, -half), half);
			}
			met = meets;
			change[t * width + c] = felt - effort[t]
				+ (!pushes && !meets ? inertia * slope[t] : 0.0);
		}
	}
}
