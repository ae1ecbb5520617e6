/* The workloads of workloads.py written by hand, each specialised as far as it goes: what a kernel is measured against.

   Points lie in memory as x, y, x, y, ... NaN goes in and comes out. Compile with
   -O3 -march=native -fno-math-errno -fno-trapping-math; finite-math-only would delete the tests for NaN. */

#include <math.h>

static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double held(double x, double a, double b) { return x < a ? a : (x > b ? b : x); }

/* W1: one polynomial for each cell of the 5 x 5 knots. */

static const double W1_VALUES[5][5] = {{-1.0, -0.66, -0.66, -0.33, -0.33},
                                       {-0.66, -0.33, 0.0, 0.09, 0.0},
                                       {0.0, 0.09, 0.18, 0.09, 0.0},
                                       {0.0, 0.09, 0.0, -0.33, -0.66},
                                       {-0.33, -0.33, -0.66, -0.66, -1.0}};
static double w1_cells[4][4][4];

void w1_prepare(void)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double a = W1_VALUES[i][j], b = W1_VALUES[i][j + 1], c = W1_VALUES[i + 1][j], d = W1_VALUES[i + 1][j + 1];
            w1_cells[i][j][0] = a;
            w1_cells[i][j][1] = (c - a) / 0.015;
            w1_cells[i][j][2] = (b - a) / 0.25;
            w1_cells[i][j][3] = (d - b - c + a) / (0.015 * 0.25);
        }
}

static inline double w1(double x, double y)
{
    static const double KX[4] = {-0.03, -0.015, 0.0, 0.015}, KY[4] = {-0.5, -0.25, 0.0, 0.25};
    double hx = held(x, -0.03, 0.03), hy = held(y, -0.5, 0.5);
    int i = (hx >= -0.015) + (hx >= 0.0) + (hx >= 0.015), j = (hy >= -0.25) + (hy >= 0.0) + (hy >= 0.25);
    const double *c = w1_cells[i][j];
    double X = hx - KX[i], Y = hy - KY[j];
    return c[0] + c[1] * X + (c[2] + c[3] * X) * Y;
}

/* For loops over points: no tables, each interval's part below x times the differences of the corners. */
static inline double w1_many(double x, double y)
{
    double r[4], s[4], total = W1_VALUES[0][0];
    for (int k = 0; k < 4; k++) {
        r[k] = held((x - (-0.03 + 0.015 * k)) * (1 / 0.015), 0.0, 1.0);
        s[k] = held((y - (-0.5 + 0.25 * k)) * 4.0, 0.0, 1.0);
    }
    for (int j = 0; j < 4; j++)
        total += s[j] * (W1_VALUES[0][j + 1] - W1_VALUES[0][j]);
    for (int i = 0; i < 4; i++) {
        double row = W1_VALUES[i + 1][0] - W1_VALUES[i][0];
        for (int j = 0; j < 4; j++)
            row += s[j] * (W1_VALUES[i + 1][j + 1] - W1_VALUES[i + 1][j] - W1_VALUES[i][j + 1] + W1_VALUES[i][j]);
        total += r[i] * row;
    }
    return total;
}

/* W2: seven triangles 1/3 apart on each input and on the output; rule (i, j) says term i + j - 3. */

#define STEP (1.0 / 3.0)

static inline double w2_union(const double *h)
{
    double area = 0.0, moment = 0.0;
    for (int k = 0; k < 6; k++) {
        double a = h[k], b = h[k + 1], m = smaller(smaller(a, b), 0.5), left = (k - 3) * STEP;
        double part = a + b - m - 0.5 * (a * a + b * b) + m * m;
        double own = 0.5 * (a + b - m - a * a + m * m) + (a * a * a - b * b * b) * (1.0 / 6.0);
        area += part;
        moment += left * part + STEP * own;
    }
    return moment / area;
}

static inline double w2(double x, double y)
{
    double cx = held(x, -1.0, 1.0), cy = held(y, -1.0, 1.0);
    int i = (int)((cx + 1.0) * 3.0), j = (int)((cy + 1.0) * 3.0);
    i = i > 5 ? 5 : (i < 0 ? 0 : i);
    j = j > 5 ? 5 : (j < 0 ? 0 : j);
    double b = (cx + 1.0) * 3.0 - i, d = (cy + 1.0) * 3.0 - j, a = 1.0 - b, c = 1.0 - d;
    double w[4] = {smaller(a, c), smaller(a, d), smaller(b, c), smaller(b, d)}, h[7] = {0};
    for (int r = 0; r < 4; r++) {
        int t = i + j - 3 + (r >> 1) + (r & 1);
        t = t < 0 ? 0 : (t > 6 ? 6 : t);
        h[t] = larger(h[t], w[r]);
    }
    double u = w2_union(h);
    return x != x || y != y ? NAN : u;
}

static inline double w2_many(double x, double y)
{
    double p[7], q[7], h[7] = {0};
    for (int k = 0; k < 7; k++) {
        double s = (x + 1.0) * 3.0 - k, t = (y + 1.0) * 3.0 - k;
        p[k] = held(smaller(k == 0 ? 1.0 : 1.0 + s, k == 6 ? 1.0 : 1.0 - s), 0.0, 1.0);
        q[k] = held(smaller(k == 0 ? 1.0 : 1.0 + t, k == 6 ? 1.0 : 1.0 - t), 0.0, 1.0);
    }
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < 7; j++) {
            int t = i + j - 3;
            t = t < 0 ? 0 : (t > 6 ? 6 : t);
            h[t] = larger(h[t], smaller(p[i], q[j]));
        }
    double u = w2_union(h);
    return x != x || y != y ? NAN : u;
}

/* W3: three disjoint symmetric triangles 10 wide; a clipped one has the area h (2 - h) * 5. */

static inline double w3(double x, double y)
{
    double s = held(x, 0.0, 10.0), f = held(y, 0.0, 10.0);
    double z0 = s / 1.5, z1 = (s - 5.0) / 1.5, z2 = (s - 10.0) / 1.5;
    double rancid = held((3.0 - f) * 0.5, 0.0, 1.0), delicious = held((f - 7.0) * 0.5, 0.0, 1.0);
    double a = larger(exp(-0.5 * z0 * z0), rancid), b = exp(-0.5 * z1 * z1), c = larger(exp(-0.5 * z2 * z2), delicious);
    a *= 2.0 - a;
    b *= 2.0 - b;
    c *= 2.0 - c;
    double u = (5.0 * a + 15.0 * b + 25.0 * c) / (a + b + c);
    return y != y ? NAN : u;
}

/* W4: nine products of Gaussians, nine lines. */

static const double W4_LINES[9][3] = {{1.0, 2.0, 0.5},   {-1.0, 0.2, 0.1}, {0.3, -2.0, 0.0},   {0.7, 0.5, -0.5}, {0.1, 0.1, 0.0},
                                      {-0.4, 1.2, 0.2},  {2.0, -0.5, 0.3}, {-1.5, 0.7, -0.1}, {0.9, 0.9, 0.9}};

static inline double w4(double x, double y)
{
    double p[3], q[3], above = 0.0, below = 0.0;
    double cx = held(x, -2.0, 2.0), cy = held(y, -2.0, 2.0);
    for (int k = 0; k < 3; k++) {
        double s = (cx - (k - 1)) * 2.0, t = (cy - (k - 1)) * 2.0;
        p[k] = exp(-0.5 * s * s);
        q[k] = exp(-0.5 * t * t);
    }
    for (int r = 0; r < 9; r++) {
        double w = p[r / 3] * q[r % 3];
        above += w * (W4_LINES[r][0] * cx + W4_LINES[r][1] * cy + W4_LINES[r][2]);
        below += w;
    }
    return above / below;
}

/* Loops: over points into an array, and one in which each call waits for the last. */

#define LOOPS(name, one, many)                                                                                         \
    void name##_batch(const double *restrict p, double *restrict out, long n)                                         \
    {                                                                                                                  \
        for (long k = 0; k < n; k++)                                                                                   \
            out[k] = many(p[2 * k], p[2 * k + 1]);                                                                     \
    }                                                                                                                  \
    void name##_points(const double *restrict p, double *restrict out, long n)                                        \
    {                                                                                                                  \
        for (long k = 0; k < n; k++)                                                                                   \
            out[k] = one(p[2 * k], p[2 * k + 1]);                                                                      \
    }                                                                                                                  \
    double name##_waiting(const double *p, long n)                                                                     \
    {                                                                                                                  \
        double last = 0.0;                                                                                             \
        for (long k = 0; k < n; k++)                                                                                   \
            last = one(p[2 * k] + 1e-9 * last, p[2 * k + 1]);                                                          \
        return last;                                                                                                   \
    }

LOOPS(w1, w1, w1_many)
LOOPS(w2, w2, w2_many)
LOOPS(w3, w3, w3)
LOOPS(w4, w4, w4)
