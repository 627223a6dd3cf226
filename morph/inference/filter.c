/* Kalman filter and smoother of a robot linearised along a motion.
 *
 * State x = (dq, dv, f, g): errors of position and velocity, a generalized force that the model
 * leaves out, and vibration, by which e channels' readings differ from the model's; both are
 * Ornstein-Uhlenbeck processes. One semi-implicit step of length h:
 *
 *   a   = J (dq, dv, f) + input,   J = [dqacc/dq, dqacc/dv, M^-1]
 *   dv' = dv + h a + jolt,   dq' = dq + h dv'
 *   f'  = keep f + w,   g' = fade g + u,   keep = exp(-h / time), fade likewise
 *
 * The gain does not depend on the readings, so one gain serves many columns, each a reading and an
 * input of its own. Per column the filter carries delta = (response to the input) - (estimate of x);
 * the innovation is reading + C delta, where `reading` is the column's direct part alone.
 * Readings are processed one at a time, which is exact where their noise is independent.
 * Source: Simon 2006, Optimal State Estimation, sections 6.1 (sequential updates) and 9.4.2.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

/* y = J x of `width` columns side by side; J (n, 3n), x (3n, width). */
INLINE void accelerate(int n, int width, const double *restrict J,
		       const double *restrict x, double *restrict y)
{
	int N = 3 * n;
	memset(y, 0, sizeof(double) * (size_t)n * width);
	for (int i = 0; i < n; i++)
		for (int k = 0; k < N; k++) {
			double g = J[i * N + k];
			if (g == 0.0)
				continue;
			const double *from = x + (size_t)k * width;
			double *to = y + (size_t)i * width;
			for (int c = 0; c < width; c++)
				to[c] += g * from[c];
		}
}

/* x <- F x of `width` columns, input (n, width) or NULL added to the acceleration. */
INLINE void advance(int n, int e, int width, double h, double keep, double fade,
		    const double *restrict J, const double *restrict input, double *restrict x,
		    double *restrict a)
{
	accelerate(n, width, J, x, a);
	size_t block = (size_t)n * width;
	if (input)
		for (size_t i = 0; i < block; i++)
			a[i] += input[i];
	double *q = x, *v = x + block, *f = v + block;
	for (size_t i = 0; i < block; i++) {
		v[i] += h * a[i];
		q[i] += h * v[i];
		f[i] *= keep;
	}
	for (size_t i = 0; i < (size_t)e * width; i++)
		f[block + i] *= fade;
}

INLINE void transpose(int N, double *P)
{
	for (int i = 0; i < N; i++)
		for (int j = 0; j < i; j++) {
			double kept = P[i * N + j];
			P[i * N + j] = P[j * N + i];
			P[j * N + i] = kept;
		}
}

/* Filter `steps` samples of `width` columns, for n degrees of freedom, m channels and N states.
 *
 * In: J (steps, n, 3n), input (steps, n, width) or NULL, C (m, N), valid (steps, m), reading
 * (steps, m, width); variances noise (m) of readings, added (n + e) of w and u, jolt (steps, n) or
 * NULL. In and out, from one call to the next: delta (N, width) and covariance P (N, N).
 * Out: white (steps, m, width), the innovations over their standard deviation.
 * Out for the smoother, all NULL or none: covariance (steps, N, N) and state predicted
 * (steps, N) before each sample's readings, gain (steps, m, N), innovation variance (steps, m).
 * Scratch: work, n * max(width, N) numbers.
 * Returns the sum of the logarithms of the innovations' variances.
 */
INLINE double filter(int n, int m, int e, int width, int64_t steps, double h, double keep,
		    double fade, const double *J, const double *input, const double *C,
		    const uint8_t *valid, const double *reading, const double *noise,
		    const double *added, const double *jolt, double *delta,
		    double *P, double *white, double *covariance, double *predicted, double *gain,
		    double *variance, double *work)
{
	int N = 3 * n + e;
	double logarithm = 0.0, column[N], k[N];
	for (int64_t t = 0; t < steps; t++) {
		if (covariance) {
			memcpy(covariance + t * N * N, P, sizeof(double) * N * N);
			for (int i = 0; i < N; i++)
				predicted[t * N + i] = -delta[(size_t)i * width];
		}
		for (int r = 0; r < m; r++) {
			const double *row = C + r * N;
			double *out = white + ((size_t)t * m + r) * width;
			if (!valid[t * m + r]) {
				memset(out, 0, sizeof(double) * width);
				continue;
			}
			memcpy(out, reading + ((size_t)t * m + r) * width, sizeof(double) * width);
			double s = noise[r];
			/* Rows of P serve as columns: it is symmetric. */
			memset(column, 0, sizeof column);
			for (int j = 0; j < N; j++)
				if (row[j] != 0.0)
					for (int i = 0; i < N; i++)
						column[i] += row[j] * P[j * N + i];
			for (int j = 0; j < N; j++)
				if (row[j] != 0.0) {
					s += row[j] * column[j];
					const double *from = delta + (size_t)j * width;
					for (int c = 0; c < width; c++)
						out[c] += row[j] * from[c];
				}
			for (int i = 0; i < N; i++) {
				k[i] = column[i] / s;
				double *to = delta + (size_t)i * width;
				for (int c = 0; c < width; c++)
					to[c] -= k[i] * out[c];
			}
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					P[i * N + j] -= k[i] * column[j];
			if (covariance) {
				memcpy(gain + (t * m + r) * N, k, sizeof(double) * N);
				variance[t * m + r] = s;
			}
			double one = 1.0 / sqrt(s);
			for (int c = 0; c < width; c++)
				out[c] *= one;
			logarithm += log(s);
		}
		const double *now = J + t * n * 3 * n;
		advance(n, e, width, h, keep, fade, now,
			input ? input + (size_t)t * n * width : NULL, delta, work);
		/* F P F' = F (F P)' as P is symmetric. */
		advance(n, e, N, h, keep, fade, now, NULL, P, work);
		transpose(N, P);
		advance(n, e, N, h, keep, fade, now, NULL, P, work);
		for (int i = 0; i < n + e; i++)
			P[(2 * n + i) * N + 2 * n + i] += added[i];
		for (int i = 0; jolt && i < n; i++) {
			double s = jolt[t * n + i];
			P[i * N + i] += h * h * s;
			P[i * N + n + i] += h * s;
			P[(n + i) * N + i] += h * s;
			P[(n + i) * N + n + i] += s;
		}
		for (int i = 0; i < N; i++)
			for (int j = 0; j < i; j++)
				P[i * N + j] = P[j * N + i] = 0.5 * (P[i * N + j] + P[j * N + i]);
	}
	return logarithm;
}

#define FILTER(N, E, WIDTH) \
	filter(N, m, E, WIDTH, steps, h, keep, fade, J, input, C, valid, reading, noise, added, jolt, \
	       delta, P, white, covariance, predicted, gain, variance, work)

/* `filter`, compiled for each small n and one column: loops of known length are several times as
 * fast, and a likelihood is evaluated thousands of times. */
double morph_filter(int n, int m, int e, int width, int64_t steps, double h, double keep,
		    double fade, const double *J, const double *input, const double *C,
		    const uint8_t *valid, const double *reading, const double *noise,
		    const double *added, const double *jolt, double *delta,
		    double *P, double *white, double *covariance, double *predicted, double *gain,
		    double *variance, double *work)
{
	switch (width > 1 || (e && e != n) ? 0 : e ? 10 + n : n) {
	case 1: return FILTER(1, 0, 1);
	case 2: return FILTER(2, 0, 1);
	case 3: return FILTER(3, 0, 1);
	case 4: return FILTER(4, 0, 1);
	case 5: return FILTER(5, 0, 1);
	case 6: return FILTER(6, 0, 1);
	case 7: return FILTER(7, 0, 1);
	case 11: return FILTER(1, 1, 1);
	case 12: return FILTER(2, 2, 1);
	case 13: return FILTER(3, 3, 1);
	case 14: return FILTER(4, 4, 1);
	case 15: return FILTER(5, 5, 1);
	case 16: return FILTER(6, 6, 1);
	case 17: return FILTER(7, 7, 1);
	default: return FILTER(n, e, width);
	}
}

/* x <- F' x, with F = I + ... of the semi-implicit step. */
INLINE void retreat(int n, int e, double h, double keep, double fade, const double *restrict J,
		    double *restrict x)
{
	double next[n];
	for (int i = 0; i < n; i++)
		next[i] = h * (x[n + i] + h * x[i]);
	for (int j = 0; j < n; j++) {
		x[n + j] += h * x[j];
		x[2 * n + j] *= keep;
	}
	for (int j = 0; j < e; j++)
		x[3 * n + j] *= fade;
	for (int i = 0; i < n; i++)
		for (int j = 0; j < 3 * n; j++)
			x[j] += J[i * 3 * n + j] * next[i];
}

/* Smooth the first column of a filter's run: the modified Bryson-Frazier form.
 *
 * white (steps, m) is that of the first column; covariance, predicted, gain and variance as the
 * filter left them; x (steps, N) is the smoothed state and spread (steps, n) the smoothed variance
 * of velocities. `adjoint` is Bierman's lambda and L (N, N), zero at first, its covariance, his capital
 * Lambda.
 * Source: Bierman 1973, Automatica 9(5), 503-511.
 */
void morph_smooth(int n, int m, int e, int64_t steps, double h, double keep, double fade,
		  const double *J, const double *C, const uint8_t *valid, const double *white,
		  const double *covariance, const double *predicted, const double *gain, const double *variance, double *x,
		  double *spread, double *L)
{
	int N = 3 * n + e;
	double adjoint[N], along[N];
	memset(adjoint, 0, sizeof adjoint);
	for (int64_t t = steps - 1; t >= 0; t--) {
		const double *now = J + t * n * 3 * n;
		retreat(n, e, h, keep, fade, now, adjoint);
		for (int side = 0; side < 2; side++) {
			for (int i = 0; i < N; i++)
				retreat(n, e, h, keep, fade, now, L + (size_t)i * N);
			transpose(N, L);
		}
		for (int r = m - 1; r >= 0; r--) {
			if (!valid[t * m + r])
				continue;
			const double *row = C + r * N, *k = gain + (t * m + r) * N;
			double moved = white[t * m + r] / sqrt(variance[t * m + r]);
			double both = 1.0 / variance[t * m + r];
			for (int i = 0; i < N; i++)
				moved -= k[i] * adjoint[i];
			for (int j = 0; j < N; j++)
				adjoint[j] += row[j] * moved;
			/* (1 - k row)' L (1 - k row) + row' row / variance */
			memset(along, 0, sizeof along);
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					along[j] += k[i] * L[i * N + j];
			for (int i = 0; i < N; i++)
				both += along[i] * k[i];
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					L[i * N + j] += row[i] * row[j] * both - row[i] * along[j] - along[i] * row[j];
		}
		for (int i = 0; i < N; i++) {
			double moved = predicted[t * N + i];
			for (int j = 0; j < N; j++)
				moved += covariance[((size_t)t * N + i) * N + j] * adjoint[j];
			x[t * N + i] = moved;
		}
		for (int i = 0; i < n; i++) {
			const double *P = covariance + ((size_t)t * N + n + i) * N;
			double left = P[n + i];
			for (int j = 0; j < N; j++) {
				double seen = 0.0;
				for (int k = 0; k < N; k++)
					seen += L[j * N + k] * P[k];
				left -= P[j] * seen;
			}
			spread[t * n + i] = left;
		}
	}
}
