// Instances of the model: their variables, their steps, their state. fmi2.c and fmi3.c give it the names of the standard.
//
// All data is in the instance, so that there may be several. The model is in fmu_model.h.
#ifndef FMU_CORE_H
#define FMU_CORE_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu_model.h"

// Functions of the standard: a source FMU is linked with others under a prefix, a shared library shows their own names.
#ifdef FMU_PREFIX
#define FMU_JOINED(a, b) a##b
#define FMU_JOIN(a, b) FMU_JOINED(a, b)
#define FMU_FUNCTION(type, name) type FMU_JOIN(FMU_PREFIX, name)
#elif defined _WIN32 || defined __CYGWIN__
#define FMU_FUNCTION(type, name) __declspec(dllexport) type name
#elif defined __GNUC__
#define FMU_FUNCTION(type, name) __attribute__((visibility("default"))) type name
#else
#define FMU_FUNCTION(type, name) type name
#endif

// Communication points agree with the time of an instance, and with its samples, up to this part of a step.
#define FMU_ALIGNED 1e-6

typedef enum { FMU_OK, FMU_WARNING, FMU_DISCARD, FMU_ERROR, FMU_FATAL } fmu_Status;

typedef enum {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_STEPPING = 4,
    FMU_TERMINATED = 8,
    FMU_FAILED = 16
} fmu_Phase;

// All that a run changes: a copy of it is a state of the FMU.
typedef struct {
    char token[sizeof FMU_TOKEN];
    fmu_Model model;
    double start;
    double time;
    double samples;
    int phase;
    bool stale;   // whether outputs are older than inputs or params; before the first step only
    bool missing; // whether an input was NaN in the step before
} fmu_Snapshot;

typedef struct {
    fmu_Snapshot now;
    fmu_Host host; // of the version of FMI: where messages go
    bool events;   // whether samples are logged
} fmu_Instance;

// Defined for each version of FMI.
static void fmu_send(const fmu_Host *host, fmu_Status status, const char *category, const char *message);

static fmu_Status fmu_log(const fmu_Instance *own, fmu_Status status, const char *format, ...)
{
    static const char *const categories[] = {"logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"};
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fmu_send(&own->host, status, categories[status], text);
    return status;
}

static fmu_Status fmu_fail(fmu_Instance *own, const char *call, const char *why)
{
    own->now.phase = FMU_FAILED;
    return fmu_log(own, FMU_ERROR, "%s: %s", call, why);
}

static const char *fmu_phase(int phase)
{
    switch (phase) {
    case FMU_INSTANTIATED: return "before initialization";
    case FMU_INITIALIZATION: return "during initialization";
    case FMU_STEPPING: return "between steps";
    case FMU_TERMINATED: return "after termination";
    default: return "after an error";
    }
}

// Whether a call is allowed at this time; a call that is not is reported.
static bool fmu_allows(const fmu_Instance *own, const char *call, int phases)
{
    if (own == NULL) {
        return false;
    }
    if ((own->now.phase & phases) == 0) {
        (void)fmu_log(own, FMU_ERROR, "%s: not allowed %s", call, fmu_phase(own->now.phase));
        return false;
    }
    return true;
}

static void fmu_restart(fmu_Instance *own)
{
    memset(&own->now, 0, sizeof own->now);
    memcpy(own->now.token, FMU_TOKEN, sizeof FMU_TOKEN);
    for (size_t k = 0; k < FMU_VALUES; ++k) {
        own->now.model.value[k] = fmu_variables[k].start;
    }
    fmu_begin(&own->now.model);
    own->now.phase = FMU_INSTANTIATED;
    own->now.stale = true;
}

static fmu_Instance *fmu_instantiate(const fmu_Host *host, const char *call, const char *token, bool events)
{
    const fmu_Instance stranger = {.host = *host};
    if (token == NULL || strcmp(token, FMU_TOKEN) != 0) {
        (void)fmu_log(&stranger, FMU_ERROR, "%s: expected the token %s, as in modelDescription.xml", call, FMU_TOKEN);
        return NULL;
    }
    fmu_Instance *own = calloc(1, sizeof *own);
    if (own == NULL) {
        (void)fmu_log(&stranger, FMU_ERROR, "%s: out of memory", call);
        return NULL;
    }
    own->host = *host;
    own->events = events;
    fmu_restart(own);
    return own;
}

static fmu_Status fmu_initialize(fmu_Instance *own, const char *call, double start)
{
    if (!isfinite(start)) {
        return fmu_fail(own, call, "expected a finite start time");
    }
    own->now.start = own->now.time = own->now.model.value[0] = start;
    return FMU_OK;
}

// Outputs before the first step: those that it would have with these inputs.
static fmu_Status fmu_refresh(fmu_Instance *own, const char *call)
{
    if (own->now.stale) {
        fmu_Model preview = own->now.model;
        const char *why = fmu_make(&preview, FMU_PREVIEW);
        for (size_t k = FMU_FIRST_OUTPUT; k < FMU_FIRST_PARAM; ++k) {
            own->now.model.value[k] = preview.value[k];
        }
        own->now.stale = false;
        if (why != NULL) {
            return fmu_log(own, FMU_WARNING, "%s: %s", call, why);
        }
    }
    return FMU_OK;
}

static fmu_Status fmu_begin_steps(fmu_Instance *own, const char *call)
{
    if (!fmu_allows(own, call, FMU_INITIALIZATION)) {
        return FMU_ERROR;
    }
    const fmu_Status status = fmu_refresh(own, call);
    own->now.phase = FMU_STEPPING;
    return status;
}

static fmu_Status fmu_terminate(fmu_Instance *own, const char *call)
{
    if (!fmu_allows(own, call, FMU_STEPPING)) {
        return FMU_ERROR;
    }
    own->now.phase = FMU_TERMINATED;
    return FMU_OK;
}

static fmu_Status fmu_reset(fmu_Instance *own)
{
    if (own == NULL) {
        return FMU_ERROR;
    }
    fmu_restart(own);
    return FMU_OK;
}

static fmu_Status fmu_get(fmu_Instance *own, const char *call, const uint32_t *references, size_t count, double *values)
{
    if (!fmu_allows(own, call, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEPPING | FMU_TERMINATED | FMU_FAILED)) {
        return FMU_ERROR;
    }
    const fmu_Status status = fmu_refresh(own, call);
    for (size_t k = 0; k < count; ++k) {
        if (references[k] >= FMU_VALUES) {
            return fmu_log(own, FMU_ERROR, "%s: no variable has the reference %lu", call, (unsigned long)references[k]);
        }
        values[k] = own->now.model.value[references[k]];
    }
    return status;
}

static fmu_Status fmu_refuse(const fmu_Instance *own, const char *call, uint32_t reference, double value)
{
    if (reference >= FMU_VALUES) {
        return fmu_log(own, FMU_ERROR, "%s: no variable has the reference %lu", call, (unsigned long)reference);
    }
    const fmu_Variable *variable = &fmu_variables[reference];
    const bool input = reference >= FMU_FIRST_INPUT && reference < FMU_FIRST_OUTPUT;
    const bool param = reference >= FMU_FIRST_PARAM && reference < FMU_FIRST_CONSTANT;
    if (!input && !param) {
        return fmu_log(own, FMU_ERROR, "%s: '%s' is no input and no parameter", call, variable->name);
    }
    // The inputs themselves may leave their ranges, and be NaN: what then follows is the model's part.
    if (param && !(value >= variable->lower && value <= variable->upper)) {
        return fmu_log(own, FMU_ERROR, "%s: parameter '%s' must be from %.9g to %.9g, got %.9g", call,
                       variable->name, variable->lower, variable->upper, value);
    }
    return FMU_OK;
}

// Set all variables, or none.
static fmu_Status fmu_set(fmu_Instance *own, const char *call, const uint32_t *references, size_t count,
                          const double *values)
{
    if (!fmu_allows(own, call, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEPPING)) {
        return FMU_ERROR;
    }
    for (size_t k = 0; k < count; ++k) {
        if (fmu_refuse(own, call, references[k], values[k]) != FMU_OK) {
            return FMU_ERROR;
        }
    }
    for (size_t k = 0; k < count; ++k) {
        own->now.model.value[references[k]] = values[k];
    }
    own->now.stale = (own->now.phase & (FMU_INSTANTIATED | FMU_INITIALIZATION)) != 0;
    return FMU_OK;
}

// The numbers of variables of a type that the model has none of.
static fmu_Status fmu_none(const fmu_Instance *own, const char *call, size_t count)
{
    if (own == NULL || count > 0U) {
        return own == NULL ? FMU_ERROR : fmu_log(own, FMU_ERROR, "%s: there is no variable of this type", call);
    }
    return FMU_OK;
}

static fmu_Status fmu_unable(const fmu_Instance *own, const char *call)
{
    return own == NULL ? FMU_ERROR : fmu_log(own, FMU_ERROR, "%s: this FMU has no such function", call);
}

static fmu_Status fmu_missing(fmu_Instance *own, const char *call)
{
    for (size_t k = FMU_FIRST_INPUT; k < FMU_FIRST_OUTPUT; ++k) {
        if (isnan(own->now.model.value[k])) {
            const bool before = own->now.missing;
            own->now.missing = true;
            return before ? FMU_WARNING
                          : fmu_log(own, FMU_WARNING, "%s: input '%s' is NaN from t = %.9g s on", call,
                                    fmu_variables[k].name, own->now.time);
        }
    }
    own->now.missing = false;
    return FMU_OK;
}

// What happens in [begin, end): each sample of a model with a period, else one step.
static const char *fmu_advance(fmu_Instance *own, double begin, double end)
{
    fmu_Snapshot *now = &own->now;
    const char *why = NULL;
#if FMU_SAMPLED
    (void)begin;
    for (double at = now->start + (now->samples * FMU_PERIOD);
         why == NULL && at < end - (FMU_ALIGNED * FMU_PERIOD);
         at = now->start + (now->samples * FMU_PERIOD)) {
        now->model.value[0] = at;
        why = fmu_make(&now->model, FMU_PERIOD);
        now->samples += 1.0;
        if (own->events) {
            (void)fmu_log(own, FMU_OK, "sample %.0f at t = %.9g s", now->samples, at);
        }
    }
#else
    now->model.value[0] = begin;
    if (end > begin) {
        why = fmu_make(&now->model, end - begin);
        now->samples += 1.0;
    }
#endif
    now->model.value[0] = end;
    return why;
}

static fmu_Status fmu_step(fmu_Instance *own, const char *call, double begin, double size)
{
    const double end = begin + size;
    if (!isfinite(end) || size < 0.0) {
        return fmu_fail(own, call, "expected a finite time, and a step that is not negative");
    }
    if (fabs(begin - own->now.time) > (FMU_ALIGNED * size) + (1e-9 * fabs(begin))) {
        own->now.phase = FMU_FAILED;
        return fmu_log(own, FMU_ERROR, "%s: the step begins at %.9g s, the one before ended at %.9g s", call, begin,
                       own->now.time);
    }
    const fmu_Status status = fmu_missing(own, call);
    const char *why = fmu_advance(own, begin, end);
    own->now.time = end;
    if (why != NULL) {
        own->now.phase = FMU_FAILED;
        return fmu_log(own, FMU_ERROR, "%s: %s at t = %.9g s", call, why, begin);
    }
    return status;
}

// Copy the state into memory that the importer frees with the function of the standard.
static fmu_Status fmu_save(fmu_Instance *own, const char *call, void **state)
{
    if (!fmu_allows(own, call, FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_STEPPING | FMU_TERMINATED)) {
        return FMU_ERROR;
    }
    if (*state == NULL) {
        *state = calloc(1, sizeof own->now);
    }
    if (*state == NULL) {
        return fmu_fail(own, call, "out of memory");
    }
    memcpy(*state, &own->now, sizeof own->now);
    return FMU_OK;
}

static fmu_Status fmu_load(fmu_Instance *own, const char *call, const void *state)
{
    if (own == NULL) {
        return FMU_ERROR;
    }
    if (state == NULL) {
        return fmu_log(own, FMU_ERROR, "%s: there is no state", call);
    }
    memcpy(&own->now, state, sizeof own->now);
    return FMU_OK;
}

static fmu_Status fmu_read(fmu_Instance *own, const char *call, const void *bytes, size_t size, void **state)
{
    if (own == NULL) {
        return FMU_ERROR;
    }
    if (bytes == NULL || size != sizeof own->now || memcmp(bytes, FMU_TOKEN, sizeof FMU_TOKEN) != 0) {
        return fmu_log(own, FMU_ERROR, "%s: this is no state of this FMU", call);
    }
    if (*state == NULL) {
        *state = calloc(1, sizeof own->now);
    }
    if (*state == NULL) {
        return fmu_fail(own, call, "out of memory");
    }
    memcpy(*state, bytes, size);
    return FMU_OK;
}

static fmu_Status fmu_write(fmu_Instance *own, const char *call, const void *state, void *bytes, size_t size)
{
    if (own == NULL) {
        return FMU_ERROR;
    }
    if (state == NULL || bytes == NULL || size < sizeof own->now) {
        return fmu_log(own, FMU_ERROR, "%s: expected a state, and room for %lu bytes", call,
                       (unsigned long)sizeof own->now);
    }
    memcpy(bytes, state, sizeof own->now);
    return FMU_OK;
}

// Samples are logged where all messages are wanted, or those of their category.
static bool fmu_wants_events(size_t count, const char *const *categories)
{
    bool found = count == 0U;
    for (size_t k = 0; k < count; ++k) {
        found = found || (categories[k] != NULL && strcmp(categories[k], "logEvents") == 0);
    }
    return found;
}

#endif // FMU_CORE_H
