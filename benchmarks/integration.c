/* The paper's equations 1 to 8 with constant head angle, in C as one would write them by hand:
   classical Runge-Kutta of fixed step, one simulation at a time (scalar) and sixteen at a time
   (lanes). Compiled on the spot by benchmarks/integration.py, which it is the yardstick of. */
#include <math.h>

enum { RHO, A, ARM, MASS, INERTIA, PHI, FLAP, C_T, C_D0, C_DA, C_LA, C_MA, C_MD, CONSTANTS };
enum { X, Y, PSI, U, V, R, STATES };
#define LANES 16
#define REST 1e-12

/* one right-hand side; p and s are read, d is written, each with the given stride */
#define RIGHT_HAND_SIDE(p, s, d, c, n, cp, sp)                                                 \
    {                                                                                          \
        double u = s(U), v = s(V), r = s(R);                                                   \
        double uh = u * cp - v * sp, vh = u * sp + v * cp;                                     \
        double W = sqrt(u * u + v * v + REST), k = 0.5 * p(RHO) * p(A);                        \
        double L = -2.0 * k * p(C_LA) * uh * vh / W;                                           \
        double D = k * (p(C_D0) * W * W + 2.0 * p(C_DA) * vh * vh) / W;                        \
        double Xh = -L * vh - D * uh, Yh = L * uh - D * vh;                                    \
        double M = -2.0 * k * p(C_MA) * uh * vh - p(C_MD) * r * fabs(r);                       \
        double T = p(C_T) * k * p(FLAP) * p(FLAP);                                             \
        d(X) = u * c - v * n;                                                                  \
        d(Y) = u * n + v * c;                                                                  \
        d(PSI) = r;                                                                            \
        d(U) = (T + Xh * cp + Yh * sp) / p(MASS) + v * r;                                      \
        d(V) = (Yh * cp - Xh * sp) / p(MASS) - u * r;                                          \
        d(R) = (M + Yh * p(ARM)) / p(INERTIA);                                                 \
    }

static const double PART[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, REACH[3] = {0.5, 0.5, 1.0};

/* parameters (count, 13), states from rest; paths (count, frames, 3) = x, y, core heading */
void scalar(long count, long frames, long substeps, double h, const double *parameters,
            double *paths)
{
    for (long i = 0; i < count; i++) {
        const double *q = parameters + i * CONSTANTS;
        double s0[STATES] = {0}, s[STATES] = {0}, d[STATES], sum[STATES];
        double cp = cos(q[PHI]), sp = sin(q[PHI]);
#define P(k) q[k]
#define S(k) s[k]
#define G(k) d[k]
        for (long frame = 0; frame < frames; frame++) {
            for (long step = 0; frame && step < substeps; step++) {
                for (int k = 0; k < STATES; k++) { s0[k] = s[k]; sum[k] = 0; }
                for (int stage = 0; stage < 4; stage++) {
                    double c = cos(s[PSI]), n = sin(s[PSI]);
                    RIGHT_HAND_SIDE(P, S, G, c, n, cp, sp)
                    for (int k = 0; k < STATES; k++) {
                        sum[k] += PART[stage] * d[k];
                        if (stage < 3) s[k] = s0[k] + h * REACH[stage] * d[k];
                    }
                }
                for (int k = 0; k < STATES; k++) s[k] = s0[k] + h * sum[k];
            }
            for (int k = 0; k < 3; k++) paths[(i * frames + frame) * 3 + k] = s[k];
        }
    }
}
#undef P
#undef S
#undef G

/* parameters (blocks, 13, 16); paths (blocks, frames, 3, 16) */
void lanes(long blocks, long frames, long substeps, double h, const double *parameters,
           double *paths)
{
    for (long b = 0; b < blocks; b++) {
        double q[CONSTANTS][LANES], cp[LANES], sp[LANES], c[LANES], n[LANES];
        double s0[STATES][LANES], s[STATES][LANES], d[STATES][LANES], sum[STATES][LANES];
        for (int k = 0; k < CONSTANTS; k++)
            for (int j = 0; j < LANES; j++) q[k][j] = parameters[(b * CONSTANTS + k) * LANES + j];
        for (int j = 0; j < LANES; j++) { cp[j] = cos(q[PHI][j]); sp[j] = sin(q[PHI][j]); }
        for (int k = 0; k < STATES; k++)
            for (int j = 0; j < LANES; j++) s[k][j] = 0;
#define P(k) q[k][j]
#define S(k) s[k][j]
#define G(k) d[k][j]
        for (long frame = 0; frame < frames; frame++) {
            for (long step = 0; frame && step < substeps; step++) {
                for (int k = 0; k < STATES; k++)
                    for (int j = 0; j < LANES; j++) { s0[k][j] = s[k][j]; sum[k][j] = 0; }
                for (int stage = 0; stage < 4; stage++) {
                    /* apart, or gcc makes one sincos of them, which it cannot vectorise */
                    for (int j = 0; j < LANES; j++) c[j] = cos(s[PSI][j]);
                    for (int j = 0; j < LANES; j++) n[j] = sin(s[PSI][j]);
                    for (int j = 0; j < LANES; j++)
                        RIGHT_HAND_SIDE(P, S, G, c[j], n[j], cp[j], sp[j])
                    double reach = h * (stage < 3 ? REACH[stage] : 0), part = PART[stage];
                    for (int k = 0; k < STATES; k++)
                        for (int j = 0; j < LANES; j++) {
                            sum[k][j] += part * d[k][j];
                            s[k][j] = s0[k][j] + reach * d[k][j];
                        }
                }
                for (int k = 0; k < STATES; k++)
                    for (int j = 0; j < LANES; j++) s[k][j] = s0[k][j] + h * sum[k][j];
            }
            for (int k = 0; k < 3; k++)
                for (int j = 0; j < LANES; j++)
                    paths[((b * frames + frame) * 3 + k) * LANES + j] = s[k][j];
        }
    }
}
