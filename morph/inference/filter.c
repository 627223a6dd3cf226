/* Kalman filter and smoother of a robot linearised along a motion.
 *
 * State x = (dq, dv, f, g): errors of position and velocity, p forces that the model leaves out, one
 * on each joint and those of contact, and vibration, by which e channels' readings differ from the
 * model's; all are Ornstein-Uhlenbeck processes. One semi-implicit step of length h:
 *
 *   a   = J (dq, dv, f) + input,   J = [dqacc/dq, dqacc/dv, dqacc/df]
 *   dv' = dv + h a + jolt,   dq' = dq + h dv'
 *   (f, g)' = keep (f, g) + w,   keep = exp(-h / time) of each
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
#define TILE 64

/* y = J x of `width` columns side by side; J (n, N), x (N, width) in rows `stride` apart. */
INLINE void accelerate(int n, int N, int width, int stride, const double *restrict J,
		       const double *restrict x, double *restrict y)
{
	for (int i = 0; i < n; i++) {
		double sum[width];
		for (int c = 0; c < width; c++)
			sum[c] = 0.0;
		for (int k = 0; k < N; k++) {
			double g = J[i * N + k];
			const double *from = x + (size_t)k * stride;
			for (int c = 0; c < width; c++)
				sum[c] += g * from[c];
		}
		memcpy(y + (size_t)i * width, sum, sizeof sum);
	}
}

/* x <- F x of `width` columns, input (n, width) or NULL added to the acceleration; rows of both are
 * `stride` apart. */
INLINE void advance(int n, int p, int e, int width, int stride, double h, const double *keep,
		    const double *restrict J, const double *restrict input, double *restrict x)
{
	double a[n * width];
	accelerate(n, 2 * n + p, width, stride, J, x, a);
	for (int i = 0; i < n; i++) {
		double *q = x + (size_t)i * stride, *v = q + (size_t)n * stride;
		for (int c = 0; c < width; c++) {
			double with = a[i * width + c] + (input ? input[(size_t)i * stride + c] : 0.0);
			v[c] += h * with;
			q[c] += h * v[c];
		}
	}
	for (int i = 0; i < p + e; i++)
		for (int c = 0; c < width; c++)
			x[(size_t)(2 * n + i) * stride + c] *= keep[i];
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

/* P <- F P F' for a symmetric P. Force and vibration decay alone, so that of F P only the rows of
 * position and velocity are multiplied by J again. The half below the diagonal mirrors the other. */
INLINE void propagate(int n, int p, int e, double h, const double *keep,
		      const double *restrict J, double *restrict P)
{
	int N = 2 * n + p + e, both = 2 * n;
	double turned[(2 * n + p) * both], a[n * both];
	advance(n, p, e, N, N, h, keep, J, NULL, P);
	for (int k = 0; k < 2 * n + p; k++)
		for (int i = 0; i < both; i++)
			turned[k * both + i] = P[i * N + k];
	accelerate(n, 2 * n + p, both, both, J, turned, a);
	for (int i = 0; i < both; i++)
		for (int j = 0; j < n; j++) {
			P[i * N + n + j] += h * a[j * both + i];
			P[i * N + j] += h * P[i * N + n + j];
		}
	for (int i = 0; i < N; i++)
		for (int j = both; j < N; j++)
			P[i * N + j] *= keep[j - both];
	for (int i = 0; i < N; i++)
		for (int j = 0; j < i; j++)
			P[i * N + j] = P[j * N + i];
}

/* Update `width` columns by one sample's readings and advance them; rows are `stride` apart.
 *
 * gain (m, N) and variance (m) are those of the readings that are `valid`; white (m, stride). */
INLINE void columns(int n, int m, int p, int e, int width, int stride, double h,
		    const double *keep, const double *J, const double *input, const double *C, const uint8_t *valid,
		    const double *reading, const double *gain, const double *variance,
		    double *delta, double *white)
{
	int N = 2 * n + p + e;
	for (int r = 0; r < m; r++) {
		const double *row = C + r * N, *k = gain + r * N;
		double *out = white + (size_t)r * stride, seen[width];
		if (!valid[r]) {
			memset(out, 0, sizeof(double) * width);
			continue;
		}
		memcpy(seen, reading + (size_t)r * stride, sizeof(double) * width);
		for (int j = 0; j < N; j++)
			if (row[j] != 0.0) {
				const double *from = delta + (size_t)j * stride;
				for (int c = 0; c < width; c++)
					seen[c] += row[j] * from[c];
			}
		for (int i = 0; i < N; i++) {
			double *to = delta + (size_t)i * stride;
			for (int c = 0; c < width; c++)
				to[c] -= k[i] * seen[c];
		}
		double one = 1.0 / sqrt(variance[r]);
		for (int c = 0; c < width; c++)
			out[c] = one * seen[c];
	}
	advance(n, p, e, width, stride, h, keep, J, input, delta);
}

/* P <- P + [h G; G] [h G; G]', G (n, k): velocities change, and positions with them. */
INLINE void jolted(int n, int k, int N, double h, const double *restrict G, double *restrict P)
{
	for (int i = 0; i < n; i++)
		for (int j = 0; k && j < n; j++) {
			double s = 0.0;
			for (int c = 0; c < k; c++)
				s += G[i * k + c] * G[j * k + c];
			P[i * N + j] += h * h * s;
			P[i * N + n + j] += h * s;
			P[(n + i) * N + j] += h * s;
			P[(n + i) * N + n + j] += s;
		}
}

/* Filter `steps` samples of `width` columns, for n degrees of freedom, m channels and N states.
 *
 * In: keep (p + e), J (steps, n, 2n + p), input (steps, n, width) or NULL, C (m, N), valid (steps,
 * m), reading (steps, m, width); variances noise (m) of readings, added (p + e) of w; jolt (steps, n,
 * k), changes of velocity by k sources of unit variance, or NULL. In and out, from one call to the next: delta (N, width) and covariance P (N, N).
 * Out: white (steps, m, width), the innovations over their standard deviation.
 * Out for the smoother: gain (steps, m, N) and innovation variance (steps, m), or NULL; for its
 * state also covariance (steps, N, N) and state predicted (steps, N) before each sample's readings,
 * or NULL.
 * Returns the sum of the logarithms of the innovations' variances.
 */
INLINE double filter(int n, int m, int p, int e, int k, int width, int64_t steps, double h,
		    const double *keep, const double *J, const double *input, const double *C,
		    const uint8_t *valid, const double *reading, const double *noise,
		    const double *added, const double *jolt, double *delta,
		    double *P, double *white, double *covariance, double *predicted, double *gain,
		    double *variance)
{
	int N = 2 * n + p + e;
	double logarithm = 0.0, column[N], g[m * N], s[m];
	for (int64_t t = 0; t < steps; t++) {
		if (covariance) {
			memcpy(covariance + t * N * N, P, sizeof(double) * N * N);
			for (int i = 0; i < N; i++)
				predicted[t * N + i] = -delta[(size_t)i * width];
		}
		for (int r = 0; r < m; r++) {
			const double *row = C + r * N;
			if (!valid[t * m + r])
				continue;
			s[r] = noise[r];
			/* Rows of P serve as columns: it is symmetric. */
			memset(column, 0, sizeof column);
			for (int j = 0; j < N; j++)
				if (row[j] != 0.0)
					for (int i = 0; i < N; i++)
						column[i] += row[j] * P[j * N + i];
			for (int j = 0; j < N; j++)
				s[r] += row[j] * column[j];
			for (int i = 0; i < N; i++)
				g[r * N + i] = column[i] / s[r];
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					P[i * N + j] -= g[r * N + i] * column[j];
			logarithm += log(s[r]);
		}
		if (gain) {
			memcpy(gain + t * m * N, g, sizeof g);
			memcpy(variance + t * m, s, sizeof s);
		}
		const double *now = J + t * n * (2 * n + p);
		/* So many columns at once as a processor's first cache holds. */
		int c = 0;
#define COLUMNS(WIDTH) \
	columns(n, m, p, e, WIDTH, width, h, keep, now, \
		input ? input + (size_t)t * n * width + c : NULL, C, valid + t * m, \
		reading + (size_t)t * m * width + c, g, s, delta + c, \
		white + (size_t)t * m * width + c)
		if (width == 1)
			COLUMNS(1);
		else {
			for (; c + TILE <= width; c += TILE)
				COLUMNS(TILE);
			if (c < width)
				COLUMNS(width - c);
		}
		propagate(n, p, e, h, keep, now, P);
		for (int i = 0; i < p + e; i++)
			P[(2 * n + i) * N + 2 * n + i] += added[i];
		jolted(n, k, N, h, jolt + (size_t)t * n * k, P);
	}
	return logarithm;
}

/* `CALL(n, p, e, width)` with numbers known to the compiler where they are small: loops of known length
 * are several times as fast, and a likelihood is evaluated thousands of times. */
#define DISPATCH(CALL, alone) \
	switch (!(alone) || n > 7 || (p != n && (p != 2 * n || !e)) || (e && e != n) \
			? 0 : (e ? 10 : 0) + (p > n ? 10 : 0) + n) { \
	case 1: CALL(1, 1, 0, 1); break; \
	case 2: CALL(2, 2, 0, 1); break; \
	case 3: CALL(3, 3, 0, 1); break; \
	case 4: CALL(4, 4, 0, 1); break; \
	case 5: CALL(5, 5, 0, 1); break; \
	case 6: CALL(6, 6, 0, 1); break; \
	case 7: CALL(7, 7, 0, 1); break; \
	case 11: CALL(1, 1, 1, 1); break; \
	case 12: CALL(2, 2, 2, 1); break; \
	case 13: CALL(3, 3, 3, 1); break; \
	case 14: CALL(4, 4, 4, 1); break; \
	case 15: CALL(5, 5, 5, 1); break; \
	case 16: CALL(6, 6, 6, 1); break; \
	case 17: CALL(7, 7, 7, 1); break; \
	case 21: CALL(1, 2, 1, 1); break; \
	case 22: CALL(2, 4, 2, 1); break; \
	case 23: CALL(3, 6, 3, 1); break; \
	case 24: CALL(4, 8, 4, 1); break; \
	case 25: CALL(5, 10, 5, 1); break; \
	case 26: CALL(6, 12, 6, 1); break; \
	case 27: CALL(7, 14, 7, 1); break; \
	default: CALL(n, p, e, width); \
	}

#define FILTER(N, P_, E, WIDTH) \
	logarithm = filter(N, m, P_, E, k, WIDTH, steps, h, keep, J, input, C, valid, reading, noise, added, jolt, \
	       delta, P, white, covariance, predicted, gain, variance)

double morph_filter(int n, int m, int p, int e, int k, int width, int64_t steps, double h,
		    const double *keep, const double *J, const double *input, const double *C,
		    const uint8_t *valid, const double *reading, const double *noise,
		    const double *added, const double *jolt, double *delta,
		    double *P, double *white, double *covariance, double *predicted, double *gain,
		    double *variance)
{
	double logarithm;
	DISPATCH(FILTER, width == 1)
	return logarithm;
}

/* x <- F' x of `width` columns, with F = I + ... of the semi-implicit step; rows of x (N, width) are
 * side by side. */
INLINE void retreat(int n, int p, int e, int width, double h, const double *keep,
		    const double *restrict J, double *restrict x)
{
	double next[n * width];
	for (int i = 0; i < n; i++) {
		const double *q = x + i * width;
		double *v = x + (n + i) * width;
		for (int c = 0; c < width; c++) {
			v[c] += h * q[c];
			next[i * width + c] = h * v[c];
		}
	}
	for (int i = 0; i < (p + e) * width; i++)
		x[2 * n * width + i] *= keep[i / width];
	for (int k = 0; k < 2 * n + p; k++)
		for (int i = 0; i < n; i++) {
			double g = J[i * (2 * n + p) + k];
			for (int c = 0; c < width; c++)
				x[k * width + c] += g * next[i * width + c];
		}
}

/* Smooth the first column of a filter's run: the modified Bryson-Frazier form.
 *
 * white (steps, m) is that of the first column; covariance, predicted, gain and variance as the
 * filter left them. x (steps, N) is the smoothed state and spread (steps, n) the smoothed variance
 * of velocities; they, covariance and predicted may be NULL. score (2 N + m) is twice the derivative
 * of the log likelihood by the variances of what each step adds to the state, of the initial state
 * and of the readings' noise. L (N, N), zero at first, is the covariance of the adjoint, Bierman's
 * lambda.
 * Source: Bierman 1973, Automatica 9(5), 503-511; Koopman and Shephard 1992, Biometrika 79(4),
 * 823-826 (the score).
 */
INLINE void smooth(int n, int m, int p, int e, int64_t steps, double h, const double *keep,
		   const double *J, const double *C, const uint8_t *valid, const double *white,
		   const double *covariance, const double *predicted, const double *gain,
		   const double *variance, double *x, double *spread, double *score, double *L)
{
	int N = 2 * n + p + e;
	double adjoint[N], along[N];
	memset(adjoint, 0, sizeof adjoint);
	memset(score, 0, sizeof(double) * (2 * N + m));
	for (int64_t t = steps - 1; t >= 0; t--) {
		const double *now = J + t * n * (2 * n + p);
		for (int i = 0; i < N; i++)
			score[i] += adjoint[i] * adjoint[i] - L[i * N + i];
		retreat(n, p, e, 1, h, keep, now, adjoint);
		/* F' L F = F' (F' L)' as L is symmetric: without the mirror a rounding that is not would
		 * grow from step to step where the robot is in contact. */
		for (int side = 0; side < 2; side++) {
			retreat(n, p, e, N, h, keep, now, L);
			transpose(N, L);
		}
		for (int i = 0; i < N; i++)
			for (int j = 0; j < i; j++)
				L[i * N + j] = L[j * N + i];
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
			/* (1 - k row)' L (1 - k row) + row' row / variance, and most of row is zero. */
			memset(along, 0, sizeof along);
			for (int i = 0; i < N; i++)
				for (int j = 0; j < N; j++)
					along[j] += k[i] * L[i * N + j];
			for (int i = 0; i < N; i++)
				both += along[i] * k[i];
			score[2 * N + r] += moved * moved - both;
			for (int i = 0; i < N; i++) {
				if (row[i] == 0.0)
					continue;
				for (int j = 0; j < N; j++)
					L[i * N + j] -= row[i] * (along[j] - 0.5 * both * row[j]);
				for (int j = 0; j < N; j++)
					L[j * N + i] -= row[i] * (along[j] - 0.5 * both * row[j]);
			}
		}
		for (int i = 0; x && i < N; i++) {
			double moved = predicted[t * N + i];
			for (int j = 0; j < N; j++)
				moved += covariance[((size_t)t * N + i) * N + j] * adjoint[j];
			x[t * N + i] = moved;
		}
		for (int i = 0; x && i < n; i++) {
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
	for (int i = 0; i < N; i++)
		score[N + i] = adjoint[i] * adjoint[i] - L[i * N + i];
}

#define SMOOTH(N, P_, E, WIDTH) \
	smooth(N, m, P_, E, steps, h, keep, J, C, valid, white, covariance, predicted, gain, \
	       variance, x, spread, score, L)

void morph_smooth(int n, int m, int p, int e, int64_t steps, double h, const double *keep,
		  const double *J, const double *C, const uint8_t *valid, const double *white,
		  const double *covariance, const double *predicted, const double *gain,
		  const double *variance, double *x, double *spread, double *score, double *L)
{
	DISPATCH(SMOOTH, 1)
}
