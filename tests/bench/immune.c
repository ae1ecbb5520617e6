/* The immune reaction function by hand: cells with their coefficients, knots found by comparisons, NaN in NaN out.
 * `even` finds the cell by arithmetic instead, which only evenly spaced knots allow. */
#include <stddef.h>
#include <string.h>
#include <time.h>

double ais_reaction(double sigma, double dsigma);

static double cell[4][4][4]; /* p + q x + (r + t x) y from the cell's corner */
static const double at_knots[5][5] = {{-1, -.66, -.66, -.33, -.33},
                                      {-.66, -.33, 0, .09, 0},
                                      {0, .09, .18, .09, 0},
                                      {0, .09, 0, -.33, -.66},
                                      {-.33, -.33, -.66, -.66, -1}};

void prepare(void)
{
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double a = at_knots[i][j], b = at_knots[i + 1][j], c = at_knots[i][j + 1], d = at_knots[i + 1][j + 1];
            cell[i][j][0] = a;
            cell[i][j][1] = (b - a) / 0.015;
            cell[i][j][2] = (c - a) / 0.25;
            cell[i][j][3] = (a - b - c + d) / (0.015 * 0.25);
        }
}

__attribute__((noinline)) double by_hand(double x, double y)
{
    static const double kx[4] = {-0.03, -0.015, 0.0, 0.015}, ky[4] = {-0.5, -0.25, 0.0, 0.25};
    if (x != x || y != y)
        return x + y;
    x = x < -0.03 ? -0.03 : x > 0.03 ? 0.03 : x;
    y = y < -0.5 ? -0.5 : y > 0.5 ? 0.5 : y;
    const int i = (x >= -0.015) + (x >= 0.0) + (x >= 0.015);
    const int j = (y >= -0.25) + (y >= 0.0) + (y >= 0.25);
    const double u = x - kx[i], v = y - ky[j], *c = cell[i][j];
    return c[0] + c[1] * u + (c[2] + c[3] * u) * v;
}

__attribute__((noinline)) double even(double x, double y)
{
    if (x != x || y != y)
        return x + y;
    x = x < -0.03 ? -0.03 : x > 0.03 ? 0.03 : x;
    y = y < -0.5 ? -0.5 : y > 0.5 ? 0.5 : y;
    int i = (int)((x + 0.03) * (1.0 / 0.015)), j = (int)((y + 0.5) * 4.0);
    i = i > 3 ? 3 : i;
    j = j > 3 ? 3 : j;
    const double u = x - (i * 0.015 - 0.03), v = y - (j * 0.25 - 0.5), *c = cell[i][j];
    return c[0] + c[1] * u + (c[2] + c[3] * u) * v;
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Time of n calls [s]; which: 0 generated, 1 by hand, 2 even. The sum keeps the calls alive. */
double timed(int which, const double *points, size_t n, double *sum)
{
    double (*const kernel)(double, double) = which == 0 ? ais_reaction : which == 1 ? by_hand : even;
    double total = 0.0;
    const double begin = seconds();
    for (size_t k = 0; k < n; ++k)
        total += kernel(points[2 * k], points[2 * k + 1]);
    *sum = total;
    return seconds() - begin;
}
