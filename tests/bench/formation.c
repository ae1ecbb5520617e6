/* The paper's formation under AIFQSMC, written by hand: the floor that the compiled loop of dwmr is measured against.
 *
 * The same model as apps/dwmr/loop.py, for a robot on the figure eight and its followers, without measurement noise.
 * The types `robot` and `disturbance` come from a header that the test writes from the numpy records.
 */
#include <math.h>
#include <stdint.h>
#include "records.h"

typedef struct { double x, y, theta, v, omega, right, left; } state;
typedef struct { double x_e, y_e, theta_e, drift_x, drift_y, drift_theta; } tracking;
typedef struct { double v, omega, force, torque; } push;

static const double PI = 3.14159265358979323846;

static double wrap(double a) { return a - 2.0 * PI * ceil((a - PI) / (2.0 * PI)); }
static double clamp(double x, double limit) { return fmax(-limit, fmin(limit, x)); }
static double sign(double x) { return (x > 0.0) - (x < 0.0); }

/* ---- gain kernels: Tables 2, 3, 6, 7, 8 */

static const double TABLE_2[5][5] = {
    {-1.0, -0.66, -0.66, -0.33, -0.33},
    {-0.66, -0.33, 0.0, 0.09, 0.0},
    {0.0, 0.09, 0.18, 0.09, 0.0},
    {0.0, 0.09, 0.0, -0.33, -0.66},
    {-0.33, -0.33, -0.66, -0.66, -1.0},
};

static double reaction(double sigma, double rate)
{
    double x = fmin(fmax(sigma / 0.015, -2.0), 2.0) + 2.0, y = fmin(fmax(rate / 0.25, -2.0), 2.0) + 2.0;
    int i = x < 3.999999999 ? (int)x : 3, j = y < 3.999999999 ? (int)y : 3;
    double p = x - i, q = y - j;
    return (1.0 - p) * ((1.0 - q) * TABLE_2[i][j] + q * TABLE_2[i][j + 1])
        + p * ((1.0 - q) * TABLE_2[i + 1][j] + q * TABLE_2[i + 1][j + 1]);
}

static double boundary_layer(double size)
{
    static const double knots[5] = {0.0050, 0.0162, 0.0275, 0.0387, 0.0500};
    if (size <= knots[0]) return knots[4];
    if (size >= knots[4]) return knots[0];
    int k = (size > knots[1]) + (size > knots[2]) + (size > knots[3]);
    double p = (size - knots[k]) / (knots[k + 1] - knots[k]);
    return (1.0 - p) * knots[4 - k] + p * knots[3 - k];
}

/* ---- references, formation, avoidance */

static void eight(double t, const double *shape, double *out)
{
    double w = 2.0 * PI / shape[2], w_x = shape[3] * w, w_y = shape[4] * w;
    double x_dot = w_x * shape[0] * cos(w_x * t), y_dot = w_y * shape[1] * cos(w_y * t);
    out[0] = shape[0] * sin(w_x * t);
    out[1] = shape[1] * sin(w_y * t);
    out[2] = atan2(y_dot, x_dot);
    out[3] = hypot(x_dot, y_dot);
}

static push disturbances(double began, double t, const disturbance *acting, int m)
{
    push sum = {0.0, 0.0, 0.0, 0.0};
    for (int k = 0; k < m; k++) {
        const disturbance *one = &acting[k];
        if (began < one->start || began >= one->stop) continue;
        double shape = one->angular_frequency != 0.0 ? sin(one->angular_frequency * t + one->phase) : 1.0;
        sum.v += shape * one->v;
        sum.omega += shape * one->omega;
        sum.force += shape * one->force;
        sum.torque += shape * one->torque;
    }
    return sum;
}

static int avoid(const state *s, double radius, int n, const double *obstacles, double *sides, const double *p,
                 double *direction, double *reach_there)
{
    int nearest = -1;
    double least = INFINITY;
    for (int a = 0; a < n; a++) {
        double l_x = obstacles[3 * a] - s->x, l_y = obstacles[3 * a + 1] - s->y, r_a = obstacles[3 * a + 2];
        double gap = hypot(l_x, l_y), angle = atan2(l_y, l_x);
        double reach = r_a + radius + p[0] + p[2] * fabs(s->v * cos(s->theta - angle)) / (p[3] * exp(p[4] * gap));
        reach = fmin(p[1], reach);
        if (!(r_a < gap && gap <= reach)) { sides[a] = 0.0; continue; }
        if (sides[a] == 0.0) sides[a] = wrap(s->theta - angle) >= 0.0 ? 1.0 : -1.0;
        if (gap < least) {
            double back = 1.0 - reach / gap;
            nearest = a; least = gap; *reach_there = reach;
            *direction = atan2(back * l_y + sides[a] * l_x, back * l_x - sides[a] * l_y);
        }
    }
    return nearest;
}

static tracking leader_error(const state *s, const double *target, double star, double d)
{
    double c = cos(s->theta), n = sin(s->theta), x = target[0] - s->x, y = target[1] - s->y;
    double theta_e = target[2] - s->theta;
    return (tracking){c * x + n * y, -n * x + c * y, wrap(star - s->theta), target[3] * cos(theta_e),
                      target[3] * sin(theta_e), -target[3] / d * sin(star - target[2])};
}

static tracking follower_error(const state *l, double v, double omega, double d_i, const state *s, double star,
                               const robot *r, const edge *g)
{
    double between = l->theta - s->theta, turn = l->theta - star;
    double l_x = l->x - d_i * cos(l->theta) - s->x, l_y = l->y - d_i * sin(l->theta) - s->y;
    double measured = hypot(l_x, l_y), bearing = wrap(atan2(l_y, l_x) - l->theta + PI);
    double wanted_c = g->separation * cos(g->bearing + between), wanted_s = g->separation * sin(g->bearing + between);
    return (tracking){wanted_c - measured * cos(bearing + between), wanted_s - measured * sin(bearing + between),
                      wrap(star - s->theta), v * cos(between) - omega * wanted_s, v * sin(between) + omega * wanted_c,
                      (v * sin(turn) + g->separation * omega * cos(g->bearing + turn)) / r->d};
}

/* ---- AIFQSMC, Eqs. (19)-(22); gains p, k_s, k_h_min, gamma, epsilon */

static double channel(double sigma, double rate, double k_h, const double *g, double dt, double *k_h_next, double *out)
{
    double f = reaction(sigma, rate), size = fabs(sigma), beta = boundary_layer(size), g_ais = k_h - g[1] * f;
    double grows = sign(size - g[4]);
    double k_h_rate = k_h <= g[2] ? g[2] : g[3] * size * (size > beta ? 1.0 : size / beta) * grows;
    out[0] = sigma; out[1] = rate; out[2] = k_h; out[3] = f; out[4] = beta; out[5] = g_ais; out[6] = g[1] / k_h;
    *k_h_next = fmax(g[2], k_h + dt * k_h_rate);
    return g_ais * (size > beta ? sign(sigma) : sigma / beta) + g[0] * sigma;
}

static void aifqsmc(const tracking *e, double d, double dt, const double *g, const double *law, double *next,
                    double *out, double *v_c, double *omega_c)
{
    double reach = g[1] * (d + e->x_e) + g[2], sigma_v = g[0] * e->x_e;
    double sigma_omega = g[1] * e->y_e + g[2] * e->theta_e;
    double star_v = -g[0] * sigma_v, star_omega = g[0] * e->y_e * sigma_v - reach * sigma_omega;
    double safe = fabs(reach) >= 0.05 ? reach : copysign(0.05, reach);
    double omega = (g[1] * e->drift_y + g[2] * e->drift_theta) / safe, v = e->drift_x + e->y_e * omega;
    double rate_v = law[4] > 0.0 ? (star_v - law[0]) / dt : 0.0;
    double rate_omega = law[4] > 0.0 ? (star_omega - law[1]) / dt : 0.0;
    *v_c = v - channel(star_v, rate_v, law[2], g + 3, dt, &next[2], out);
    *omega_c = omega - channel(star_omega, rate_omega, law[3], g + 8, dt, &next[3], out + 7);
    next[0] = star_v; next[1] = star_omega; next[4] = 1.0;
}

/* ---- the plant: Eqs. (1), (46), with actuator lag and friction */

typedef struct { double per_mass, per_inertia, moment, force, torque, per_lag; } body;

static state derivative(const state *s, push now, const robot *r, const body *b, double right, double left)
{
    double v = s->v + now.v, omega = s->omega + now.omega, c = cos(s->theta), n = sin(s->theta);
    double force = (s->right + s->left) * b->force + now.force, torque = (s->right - s->left) * b->torque + now.torque;
    force -= r->coulomb_force * s->v / (fabs(s->v) + r->stick_v) + r->viscous_force * s->v;
    torque -= r->coulomb_torque * s->omega / (fabs(s->omega) + r->stick_omega) + r->viscous_torque * s->omega;
    double coupling = b->moment * s->omega;
    return (state){v * c - r->d * omega * n, v * n + r->d * omega * c, omega, (force + coupling * s->omega) * b->per_mass,
                   (torque - coupling * s->v) * b->per_inertia, (right - s->right) * b->per_lag,
                   (left - s->left) * b->per_lag};
}

static state add(const state *s, const state *k, double h)
{
    return (state){s->x + h * k->x, s->y + h * k->y, s->theta + h * k->theta, s->v + h * k->v, s->omega + h * k->omega,
                   s->right + h * k->right, s->left + h * k->left};
}

static void advance(double t, state *s, const double *torques, const robot *r, const disturbance *acting, int m,
                    const double *load, double dt, int substeps)
{
    double loaded = load[0] <= t && t < load[1], mass = r->mass * (loaded ? load[2] : 1.0);
    body b = {1.0 / mass, 1.0 / (r->inertia * (loaded ? load[3] : 1.0)), mass * r->com_offset, 1.0 / r->wheel_radius,
              r->half_track / r->wheel_radius, 1.0 / r->lag};
    double h = dt / substeps;
    for (int k = 0; k < substeps; k++) {
        double at = t + k * h;
        push middle = disturbances(t, at + 0.5 * h, acting, m);
        state k1 = derivative(s, disturbances(t, at, acting, m), r, &b, torques[0], torques[1]), s2 = add(s, &k1, 0.5 * h);
        state k2 = derivative(&s2, middle, r, &b, torques[0], torques[1]), s3 = add(s, &k2, 0.5 * h);
        state k3 = derivative(&s3, middle, r, &b, torques[0], torques[1]), s4 = add(s, &k3, h);
        state k4 = derivative(&s4, disturbances(t, at + h, acting, m), r, &b, torques[0], torques[1]);
        *s = add(s, &k1, h / 6.0);
        *s = add(s, &k2, h / 3.0);
        *s = add(s, &k3, h / 3.0);
        *s = add(s, &k4, h / 6.0);
    }
}

static void pd(const robot *r, double e_v, double e_omega, double dt, double *filter, double *torques)
{
    double force = r->pd_mass * (r->k_p_v * e_v + r->k_d_v * r->n_v * (e_v - filter[0]));
    double torque = r->pd_inertia * (r->k_p_omega * e_omega + r->k_d_omega * r->n_omega * (e_omega - filter[1]));
    double common = 0.5 * r->wheel_radius * force, difference = 0.5 * r->wheel_radius * torque / r->half_track;
    torques[0] = clamp(common + difference, r->torque_limit);
    torques[1] = clamp(common - difference, r->torque_limit);
    filter[0] += (1.0 - exp(-r->n_v * dt)) * (e_v - filter[0]);
    filter[1] += (1.0 - exp(-r->n_omega * dt)) * (e_omega - filter[1]);
}

/* ---- the loop; 0 when it ran to its end, else the number of the robot whose command is not finite, from 1 */

int run(int samples, double dt, int substeps, const double *shape, int n, const robot *robots, const edge *edges, int m,
        const disturbance *acting, const double *load, int obstacles, const double *places, const double *avoidance,
        const double *gains, state *plant, double *star, double *filters, double *sides, double *law, double *next,
        double *torques, double *record, double *law_record)
{
    for (int k = 0; k < samples; k++) {
        double t = k * dt;
        for (int i = 0; i < n; i++) {
            const robot *r = &robots[i];
            const state *s = &plant[i];
            double *row = record + 20 * (k * n + i), target[4], reach = 0.0, v_c, omega_c;
            int near = -1;
            tracking e;
            if (r->first == r->last) {
                double direction = 0.0;
                eight(t - r->delay, shape, target);
                if (r->avoids) near = avoid(s, r->radius, obstacles, places, sides + obstacles * i, avoidance, &direction,
                                            &reach);
                if (near >= 0) { target[2] = direction; target[3] *= avoidance[5]; }
                e = leader_error(s, target, star[i], r->d);
            } else {
                const edge *g = &edges[r->first];
                const state *l = &plant[g->leader];
                push now = disturbances(t, t, acting + m * g->leader, m);
                double d_i = robots[g->leader].d, angle = g->bearing + l->theta;
                target[0] = l->x - d_i * cos(l->theta) + g->separation * cos(angle);
                target[1] = l->y - d_i * sin(l->theta) + g->separation * sin(angle);
                target[2] = star[i];
                target[3] = l->v + now.v;
                e = follower_error(l, l->v + now.v, l->omega + now.omega, d_i, s, star[i], r, g);
            }
            aifqsmc(&e, r->d, dt, gains + 13 * i, law + 5 * i, next + 5 * i, law_record + 14 * (k * n + i), &v_c, &omega_c);
            push now = disturbances(t, t, acting + m * i, m);
            pd(r, clamp(v_c, r->v_limit) - s->v, clamp(omega_c, r->omega_limit) - s->omega, dt, filters + 2 * i,
               torques + 2 * i);
            double out[20] = {s->x, s->y, s->theta, s->v, s->omega, target[0], target[1], target[2], target[3], star[i],
                              e.x_e, e.y_e, v_c, omega_c, torques[2 * i], torques[2 * i + 1], now.v, now.omega, near, reach};
            for (int c = 0; c < 20; c++) row[c] = out[c];
            star[i] += dt * e.drift_theta;
            if (!isfinite(v_c) || !isfinite(omega_c)) return i + 1;
        }
        for (int i = 0; i < n; i++) {
            advance(t, &plant[i], torques + 2 * i, &robots[i], acting + m * i, m, load, dt, substeps);
            for (int c = 0; c < 5; c++) law[5 * i + c] = next[5 * i + c];
        }
    }
    return 0;
}
