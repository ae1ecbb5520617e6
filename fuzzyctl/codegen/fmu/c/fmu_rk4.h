// The equations of a plant over a communication step: the classical method of Runge and Kutta, with inputs held.
#ifndef FMU_RK4_H
#define FMU_RK4_H

#include <math.h>

#include "fmu_model.h"

static const char *fmu_integrate(fmu_Model *model, double dt)
{
    const double begin = model->value[0];
    const double steps = ceil((dt / model->value[FMU_INTEGRATION_STEP]) * (1.0 - 1e-9));
    const double step = steps > 0.0 ? dt / steps : 0.0;
    const char *why = NULL;
    double rate[FMU_STATES];
    for (double s = 0.0; s < steps && why == NULL; s += 1.0) {
        double stage_state[FMU_STATES];
        double next[FMU_STATES];
        for (size_t k = 0; k < FMU_STATES; ++k) {
            stage_state[k] = next[k] = model->state[k];
        }
        for (int stage = 0; stage < 4; ++stage) {
            const int half = (stage + 1) / 2; // at the begin, twice in the middle, at the end of the step
            const double part = half == 1 ? step / 3.0 : step / 6.0;
            const double ahead = stage < 2 ? 0.5 * step : step;
            const char *found = fmu_rates(model, begin + ((s + (0.5 * half)) * step), stage_state, rate);
            why = why == NULL ? found : why;
            for (size_t k = 0; k < FMU_STATES; ++k) {
                next[k] += part * rate[k];
                stage_state[k] = model->state[k] + (ahead * rate[k]);
            }
        }
        for (size_t k = 0; k < FMU_STATES; ++k) {
            model->state[k] = next[k];
        }
    }
    for (size_t k = 0; k < FMU_STATES && why == NULL; ++k) {
        if (!(model->state[k] >= fmu_lowest[k] && model->state[k] <= fmu_highest[k])) {
            why = fmu_left[k];
        }
    }
    // The outputs are those at the end.
    const char *found = fmu_rates(model, begin + dt, model->state, rate);
    return why == NULL ? found : why;
}

#endif // FMU_RK4_H
