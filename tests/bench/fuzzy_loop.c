/* The loop of loops.py written by hand: a fuzzy PI controller of 7 x 7 rules (product, centre average) and a tank,
   integrated by the classical method of Runge and Kutta. Compile like limits.c.

   It records what a run records: reference, leak, inputs and outputs of both blocks, the state. */

#include <math.h>

static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double held(double x, double a, double b) { return x < a ? a : (x > b ? b : x); }

static double cells[6][6][4];

void fuzzy_loop_prepare(void)
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            double v[2][2];
            for (int r = 0; r < 2; r++)
                for (int s = 0; s < 2; s++)
                    v[r][s] = held((i + r + j + s - 6) / 3.0, -1.0, 1.0);
            cells[i][j][0] = v[0][0];
            cells[i][j][1] = (v[1][0] - v[0][0]) * 3.0;
            cells[i][j][2] = (v[0][1] - v[0][0]) * 3.0;
            cells[i][j][3] = (v[1][1] - v[0][1] - v[1][0] + v[0][0]) * 9.0;
        }
}

static inline double surface(double x, double y)
{
    double cx = held(x, -1.0, 1.0), cy = held(y, -1.0, 1.0);
    int i = (int)((cx + 1.0) * 3.0), j = (int)((cy + 1.0) * 3.0);
    i = i > 5 ? 5 : (i < 0 ? 0 : i);
    j = j > 5 ? 5 : (j < 0 ? 0 : j);
    double X = cx - (i - 3) / 3.0, Y = cy - (j - 3) / 3.0;
    const double *c = cells[i][j];
    return c[0] + c[1] * X + (c[2] + c[3] * X) * Y;
}

static inline double rate(double h, double v) { return (5.0 * v - 2.0 * sqrt(larger(h, 0.0))) / 20.0; }

long fuzzy_loop(double *record, long count)
{
    double h = 0.5, valve = 0.0, before = 0.0, filtered = 0.0, dt = 0.01;
    for (long k = 0; k < count; k++) {
        double t = k * dt, reference = t >= 30.0 ? 0.6 : 1.0, leak = t >= 10.0 && t < 15.0 ? 0.3 : 0.0;
        if (!(h >= 0.0 && h < 1e300))
            return k;
        double e = reference - h;
        filtered = (0.2 * filtered + (k ? e - before : 0.0)) / (0.2 + dt);
        before = e;
        valve = smaller(larger(valve + dt * 8.0 * surface(2.0 * e, 4.0 * filtered), 0.0), 10.0);
        double v = valve - leak, *row = record + 8 * k;
        row[0] = reference, row[1] = leak, row[2] = reference, row[3] = h, row[4] = valve, row[5] = v, row[6] = h, row[7] = h;
        /* The leak jumps at samples only: it is constant here. */
        double a = rate(h, valve - leak), b = rate(h + 0.5 * dt * a, valve - leak);
        double c = rate(h + 0.5 * dt * b, valve - leak), d = rate(h + dt * c, valve - leak);
        h += dt / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    return -1;
}
