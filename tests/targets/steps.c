/* Makes 10,000 steps of the controller of valve.fz and prints outputs and their sums; run.py compares them. */
#include "valve.h"

#include <stdint.h>
#include <stdio.h>

static uint32_t seed = 1U;

/* The next number from [0, 2), the same on each machine. */
static double drawn(void)
{
    seed = (seed * UINT32_C(1664525)) + UINT32_C(1013904223);
    return (double)(seed >> 8) / 8388608.0;
}

int main(void)
{
    static valve_state state;
    double sum = 0.0;

    valve_init(&state);
    for (uint32_t k = 1U; k <= 10000U; ++k) {
        const double reference = drawn();
        const double level = drawn();
        valve_outputs outputs;
        valve_step(&state, reference, level, &outputs);
        sum += outputs.opening + outputs.alarm;
        if ((k % 100U) == 0U) {
            (void)printf("%.17g %.17g %.17g\n", outputs.opening, outputs.alarm, sum);
        }
    }
    return 0;
}
