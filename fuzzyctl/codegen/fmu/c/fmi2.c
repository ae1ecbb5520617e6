// The functions of FMI 2.0 for co-simulation. Their names and types are those of the standard.
#include <stddef.h>

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String instanceName, fmi2Status, fmi2String category,
                                   fmi2String message, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t count, size_t size);
typedef void (*fmi2CallbackFreeMemory)(void *memory);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment, fmi2Status);
typedef struct {
    fmi2CallbackLogger logger;
    fmi2CallbackAllocateMemory allocateMemory;
    fmi2CallbackFreeMemory freeMemory;
    fmi2StepFinished stepFinished;
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2CallbackLogger log;
    fmi2ComponentEnvironment environment;
    char name[128]; // of the instance, cut where it is longer
} fmu_Host;

#ifdef FMI2_FUNCTION_PREFIX
#define FMU_PREFIX FMI2_FUNCTION_PREFIX
#endif
#include "fmu_core.h"

// Messages are complete, so that the logger has nothing to print into them; no message has a percent sign.
static void fmu_send(const fmu_Host *host, fmu_Status status, const char *category, const char *message)
{
    if (host->log != NULL) {
        host->log(host->environment, host->name, (fmi2Status)status, category, message);
    }
}

FMU_FUNCTION(const char *, fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMU_FUNCTION(const char *, fmi2GetVersion)(void)
{
    return "2.0";
}

FMU_FUNCTION(fmi2Status, fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                                              const fmi2String categories[])
{
    fmu_Instance *own = c;
    if (own == NULL) {
        return fmi2Error;
    }
    own->events = fmu_wants_events(nCategories, categories) ? loggingOn != 0 : own->events;
    return fmi2OK;
}

// Instances

FMU_FUNCTION(fmi2Component, fmi2Instantiate)(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                                             fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                                             fmi2Boolean visible, fmi2Boolean loggingOn)
{
    static const char call[] = "fmi2Instantiate";
    fmu_Instance stranger = {.now.phase = FMU_FAILED};
    (void)fmuResourceLocation, (void)visible;
    if (functions != NULL) {
        stranger.host.log = functions->logger;
        stranger.host.environment = functions->componentEnvironment;
    }
    (void)snprintf(stranger.host.name, sizeof stranger.host.name, "%s", instanceName != NULL ? instanceName : "");
    if (fmuType != fmi2CoSimulation) {
        (void)fmu_log(&stranger, FMU_ERROR, "%s: this FMU is for co-simulation", call);
        return NULL;
    }
    return fmu_instantiate(&stranger.host, call, fmuGUID, loggingOn != 0);
}

FMU_FUNCTION(void, fmi2FreeInstance)(fmi2Component c)
{
    free(c);
}

// Phases

FMU_FUNCTION(fmi2Status, fmi2SetupExperiment)(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                                              fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    static const char call[] = "fmi2SetupExperiment";
    (void)toleranceDefined, (void)tolerance, (void)stopTimeDefined, (void)stopTime;
    if (!fmu_allows(c, call, FMU_INSTANTIATED)) {
        return fmi2Error;
    }
    return (fmi2Status)fmu_initialize(c, call, startTime);
}

FMU_FUNCTION(fmi2Status, fmi2EnterInitializationMode)(fmi2Component c)
{
    fmu_Instance *own = c;
    if (!fmu_allows(own, "fmi2EnterInitializationMode", FMU_INSTANTIATED)) {
        return fmi2Error;
    }
    own->now.phase = FMU_INITIALIZATION;
    return fmi2OK;
}

FMU_FUNCTION(fmi2Status, fmi2ExitInitializationMode)(fmi2Component c)
{
    return (fmi2Status)fmu_begin_steps(c, "fmi2ExitInitializationMode");
}

FMU_FUNCTION(fmi2Status, fmi2Terminate)(fmi2Component c)
{
    return (fmi2Status)fmu_terminate(c, "fmi2Terminate");
}

FMU_FUNCTION(fmi2Status, fmi2Reset)(fmi2Component c)
{
    return (fmi2Status)fmu_reset(c);
}

// Variables

FMU_FUNCTION(fmi2Status, fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    return (fmi2Status)fmu_get(c, "fmi2GetReal", vr, nvr, value);
}

FMU_FUNCTION(fmi2Status, fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                      const fmi2Real value[])
{
    return (fmi2Status)fmu_set(c, "fmi2SetReal", vr, nvr, value);
}

#define FMU_NO_VARIABLES(type)                                                                                         \
    FMU_FUNCTION(fmi2Status, fmi2Get##type)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                \
                                            fmi2##type value[])                                                        \
    {                                                                                                                  \
        (void)vr, (void)value;                                                                                         \
        return (fmi2Status)fmu_none(c, "fmi2Get" #type, nvr);                                                          \
    }                                                                                                                  \
    FMU_FUNCTION(fmi2Status, fmi2Set##type)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                \
                                            const fmi2##type value[])                                                  \
    {                                                                                                                  \
        (void)vr, (void)value;                                                                                         \
        return (fmi2Status)fmu_none(c, "fmi2Set" #type, nvr);                                                          \
    }

FMU_NO_VARIABLES(Integer)
FMU_NO_VARIABLES(Boolean)
FMU_NO_VARIABLES(String)

// State

FMU_FUNCTION(fmi2Status, fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status)fmu_save(c, "fmi2GetFMUstate", FMUstate);
}

FMU_FUNCTION(fmi2Status, fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate FMUstate)
{
    return (fmi2Status)fmu_load(c, "fmi2SetFMUstate", FMUstate);
}

FMU_FUNCTION(fmi2Status, fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    free(*FMUstate);
    *FMUstate = NULL;
    return fmi2OK;
}

FMU_FUNCTION(fmi2Status, fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    (void)c, (void)FMUstate;
    *size = sizeof(fmu_Snapshot);
    return fmi2OK;
}

FMU_FUNCTION(fmi2Status, fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                                size_t size)
{
    return (fmi2Status)fmu_write(c, "fmi2SerializeFMUstate", FMUstate, serializedState, size);
}

FMU_FUNCTION(fmi2Status, fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                                  fmi2FMUstate *FMUstate)
{
    return (fmi2Status)fmu_read(c, "fmi2DeSerializeFMUstate", serializedState, size, FMUstate);
}

// Steps

FMU_FUNCTION(fmi2Status, fmi2DoStep)(fmi2Component c, fmi2Real currentCommunicationPoint,
                                     fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!fmu_allows(c, "fmi2DoStep", FMU_STEPPING)) {
        return fmi2Error;
    }
    return (fmi2Status)fmu_step(c, "fmi2DoStep", currentCommunicationPoint, communicationStepSize);
}

FMU_FUNCTION(fmi2Status, fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    const fmu_Instance *own = c;
    if (own == NULL || s != fmi2LastSuccessfulTime) {
        return (fmi2Status)fmu_unable(own, "fmi2GetRealStatus");
    }
    *value = own->now.time;
    return fmi2OK;
}

FMU_FUNCTION(fmi2Status, fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    if (c == NULL || s != fmi2Terminated) {
        return (fmi2Status)fmu_unable(c, "fmi2GetBooleanStatus");
    }
    *value = 0;
    return fmi2OK;
}

// Functions of the standard for what this FMU does not have

FMU_FUNCTION(fmi2Status, fmi2CancelStep)(fmi2Component c)
{
    return (fmi2Status)fmu_unable(c, "fmi2CancelStep");
}

FMU_FUNCTION(fmi2Status, fmi2GetStatus)(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    (void)s, (void)value;
    return (fmi2Status)fmu_unable(c, "fmi2GetStatus");
}

FMU_FUNCTION(fmi2Status, fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)s, (void)value;
    return (fmi2Status)fmu_unable(c, "fmi2GetIntegerStatus");
}

FMU_FUNCTION(fmi2Status, fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)s, (void)value;
    return (fmi2Status)fmu_unable(c, "fmi2GetStringStatus");
}

FMU_FUNCTION(fmi2Status, fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                                      const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return (fmi2Status)fmu_unable(c, "fmi2SetRealInputDerivatives");
}

FMU_FUNCTION(fmi2Status, fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                                       const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return (fmi2Status)fmu_unable(c, "fmi2GetRealOutputDerivatives");
}

FMU_FUNCTION(fmi2Status, fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                                       size_t nUnknown, const fmi2ValueReference vKnown_ref[],
                                                       size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    (void)vUnknown_ref, (void)nUnknown, (void)vKnown_ref, (void)nKnown, (void)dvKnown, (void)dvUnknown;
    return (fmi2Status)fmu_unable(c, "fmi2GetDirectionalDerivative");
}
