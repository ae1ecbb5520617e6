// The functions of FMI 3.0 for co-simulation. Their names and types are those of the standard.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

typedef struct {
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} fmu_Host;

#ifdef FMI3_FUNCTION_PREFIX
#define FMU_PREFIX FMI3_FUNCTION_PREFIX
#endif
#include "fmu_core.h"

static void fmu_send(const fmu_Host *host, fmu_Status status, const char *category, const char *message)
{
    if (host->log != NULL) {
        host->log(host->environment, (fmi3Status)status, category, message);
    }
}

FMU_FUNCTION(const char *, fmi3GetVersion)(void)
{
    return "3.0";
}

FMU_FUNCTION(fmi3Status, fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                                              const fmi3String categories[])
{
    fmu_Instance *own = instance;
    if (own == NULL) {
        return fmi3Error;
    }
    own->events = fmu_wants_events(nCategories, categories) ? loggingOn : own->events;
    return fmi3OK;
}

// Instances

FMU_FUNCTION(fmi3Instance, fmi3InstantiateCoSimulation)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate)
{
    static const char call[] = "fmi3InstantiateCoSimulation";
    const fmu_Host host = {logMessage, instanceEnvironment};
    (void)instanceName, (void)resourcePath, (void)visible, (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables, (void)intermediateUpdate;
    if (eventModeUsed || nRequiredIntermediateVariables > 0U) {
        const fmu_Instance stranger = {.host = host};
        (void)fmu_log(&stranger, FMU_ERROR, "%s: this FMU has no event mode and no intermediate variables", call);
        return NULL;
    }
    return fmu_instantiate(&host, call, instantiationToken, loggingOn);
}

FMU_FUNCTION(fmi3Instance, fmi3InstantiateModelExchange)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    const fmu_Instance stranger = {.host = {logMessage, instanceEnvironment}};
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)fmu_log(&stranger, FMU_ERROR, "fmi3InstantiateModelExchange: this FMU is for co-simulation");
    return NULL;
}

FMU_FUNCTION(fmi3Instance, fmi3InstantiateScheduledExecution)(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption)
{
    const fmu_Instance stranger = {.host = {logMessage, instanceEnvironment}};
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    (void)fmu_log(&stranger, FMU_ERROR, "fmi3InstantiateScheduledExecution: this FMU is for co-simulation");
    return NULL;
}

FMU_FUNCTION(void, fmi3FreeInstance)(fmi3Instance instance)
{
    free(instance);
}

// Phases

FMU_FUNCTION(fmi3Status, fmi3EnterInitializationMode)(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                                      fmi3Float64 tolerance, fmi3Float64 startTime,
                                                      fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    static const char call[] = "fmi3EnterInitializationMode";
    fmu_Instance *own = instance;
    (void)toleranceDefined, (void)tolerance, (void)stopTimeDefined, (void)stopTime;
    if (!fmu_allows(own, call, FMU_INSTANTIATED)) {
        return fmi3Error;
    }
    own->now.phase = FMU_INITIALIZATION;
    return (fmi3Status)fmu_initialize(own, call, startTime);
}

FMU_FUNCTION(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_begin_steps(instance, "fmi3ExitInitializationMode");
}

FMU_FUNCTION(fmi3Status, fmi3Terminate)(fmi3Instance instance)
{
    return (fmi3Status)fmu_terminate(instance, "fmi3Terminate");
}

FMU_FUNCTION(fmi3Status, fmi3Reset)(fmi3Instance instance)
{
    return (fmi3Status)fmu_reset(instance);
}

// Variables

FMU_FUNCTION(fmi3Status, fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                         size_t nValueReferences, fmi3Float64 values[], size_t nValues)
{
    if (nValues != nValueReferences) {
        return instance == NULL ? fmi3Error : (fmi3Status)fmu_fail(instance, "fmi3GetFloat64", "all are scalars");
    }
    return (fmi3Status)fmu_get(instance, "fmi3GetFloat64", valueReferences, nValueReferences, values);
}

FMU_FUNCTION(fmi3Status, fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                         size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    if (nValues != nValueReferences) {
        return instance == NULL ? fmi3Error : (fmi3Status)fmu_fail(instance, "fmi3SetFloat64", "all are scalars");
    }
    return (fmi3Status)fmu_set(instance, "fmi3SetFloat64", valueReferences, nValueReferences, values);
}

#define FMU_NO_VARIABLES(type)                                                                                         \
    FMU_FUNCTION(fmi3Status, fmi3Get##type)(fmi3Instance instance, const fmi3ValueReference valueReferences[],         \
                                            size_t nValueReferences, fmi3##type values[], size_t nValues)              \
    {                                                                                                                  \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        return (fmi3Status)fmu_none(instance, "fmi3Get" #type, nValueReferences);                                      \
    }                                                                                                                  \
    FMU_FUNCTION(fmi3Status, fmi3Set##type)(fmi3Instance instance, const fmi3ValueReference valueReferences[],         \
                                            size_t nValueReferences, const fmi3##type values[], size_t nValues)        \
    {                                                                                                                  \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        return (fmi3Status)fmu_none(instance, "fmi3Set" #type, nValueReferences);                                      \
    }

FMU_NO_VARIABLES(Float32)
FMU_NO_VARIABLES(Int8)
FMU_NO_VARIABLES(UInt8)
FMU_NO_VARIABLES(Int16)
FMU_NO_VARIABLES(UInt16)
FMU_NO_VARIABLES(Int32)
FMU_NO_VARIABLES(UInt32)
FMU_NO_VARIABLES(Int64)
FMU_NO_VARIABLES(UInt64)
FMU_NO_VARIABLES(Boolean)
FMU_NO_VARIABLES(String)

FMU_FUNCTION(fmi3Status, fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                        size_t nValueReferences, size_t valueSizes[], fmi3Binary values[],
                                        size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return (fmi3Status)fmu_none(instance, "fmi3GetBinary", nValueReferences);
}

FMU_FUNCTION(fmi3Status, fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                        size_t nValueReferences, const size_t valueSizes[], const fmi3Binary values[],
                                        size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return (fmi3Status)fmu_none(instance, "fmi3SetBinary", nValueReferences);
}

FMU_FUNCTION(fmi3Status, fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                       size_t nValueReferences, fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return (fmi3Status)fmu_none(instance, "fmi3GetClock", nValueReferences);
}

FMU_FUNCTION(fmi3Status, fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                       size_t nValueReferences, const fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return (fmi3Status)fmu_none(instance, "fmi3SetClock", nValueReferences);
}

// State

FMU_FUNCTION(fmi3Status, fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return (fmi3Status)fmu_save(instance, "fmi3GetFMUState", FMUState);
}

FMU_FUNCTION(fmi3Status, fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState FMUState)
{
    return (fmi3Status)fmu_load(instance, "fmi3SetFMUState", FMUState);
}

FMU_FUNCTION(fmi3Status, fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    free(*FMUState);
    *FMUState = NULL;
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    (void)instance, (void)FMUState;
    *size = sizeof(fmu_Snapshot);
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState FMUState,
                                                fmi3Byte serializedState[], size_t size)
{
    return (fmi3Status)fmu_write(instance, "fmi3SerializeFMUState", FMUState, serializedState, size);
}

FMU_FUNCTION(fmi3Status, fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                                  fmi3FMUState *FMUState)
{
    return (fmi3Status)fmu_read(instance, "fmi3DeserializeFMUState", serializedState, size, FMUState);
}

// Steps

FMU_FUNCTION(fmi3Status, fmi3DoStep)(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                                     fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                     fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                                     fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    static const char call[] = "fmi3DoStep";
    fmu_Instance *own = instance;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!fmu_allows(own, call, FMU_STEPPING)) {
        return fmi3Error;
    }
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = false;
    const fmu_Status status = communicationStepSize > 0.0
                                  ? fmu_step(own, call, currentCommunicationPoint, communicationStepSize)
                                  : fmu_fail(own, call, "expected a positive step");
    *lastSuccessfulTime = own->now.time;
    return (fmi3Status)status;
}

// Functions of the standard for what this FMU does not have

FMU_FUNCTION(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3EnterEventMode");
}

FMU_FUNCTION(fmi3Status, fmi3EnterStepMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3EnterStepMode");
}

FMU_FUNCTION(fmi3Status, fmi3EnterConfigurationMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3EnterConfigurationMode");
}

FMU_FUNCTION(fmi3Status, fmi3ExitConfigurationMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3ExitConfigurationMode");
}

FMU_FUNCTION(fmi3Status, fmi3GetOutputDerivatives)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                                   size_t nValueReferences, const fmi3Int32 orders[],
                                                   fmi3Float64 values[], size_t nValues)
{
    (void)valueReferences, (void)nValueReferences, (void)orders, (void)values, (void)nValues;
    return (fmi3Status)fmu_unable(instance, "fmi3GetOutputDerivatives");
}

FMU_FUNCTION(fmi3Status, fmi3GetDirectionalDerivative)(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                       size_t nUnknowns, const fmi3ValueReference knowns[],
                                                       size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                                       fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)unknowns, (void)nUnknowns, (void)knowns, (void)nKnowns, (void)seed, (void)nSeed;
    (void)sensitivity, (void)nSensitivity;
    return (fmi3Status)fmu_unable(instance, "fmi3GetDirectionalDerivative");
}

FMU_FUNCTION(fmi3Status, fmi3GetAdjointDerivative)(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                   size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns,
                                                   const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                                   size_t nSensitivity)
{
    (void)unknowns, (void)nUnknowns, (void)knowns, (void)nKnowns, (void)seed, (void)nSeed;
    (void)sensitivity, (void)nSensitivity;
    return (fmi3Status)fmu_unable(instance, "fmi3GetAdjointDerivative");
}

FMU_FUNCTION(fmi3Status, fmi3GetNumberOfVariableDependencies)(fmi3Instance instance, fmi3ValueReference valueReference,
                                                              size_t *nDependencies)
{
    (void)valueReference, (void)nDependencies;
    return (fmi3Status)fmu_unable(instance, "fmi3GetNumberOfVariableDependencies");
}

FMU_FUNCTION(fmi3Status, fmi3GetVariableDependencies)(fmi3Instance instance, fmi3ValueReference dependent,
                                                      size_t elementIndicesOfDependent[],
                                                      fmi3ValueReference independents[],
                                                      size_t elementIndicesOfIndependents[],
                                                      fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    (void)dependent, (void)elementIndicesOfDependent, (void)independents, (void)elementIndicesOfIndependents;
    (void)dependencyKinds, (void)nDependencies;
    return (fmi3Status)fmu_unable(instance, "fmi3GetVariableDependencies");
}

FMU_FUNCTION(fmi3Status, fmi3GetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                                 size_t nValueReferences, fmi3Float64 intervals[],
                                                 fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)nValueReferences, (void)intervals, (void)qualifiers;
    return (fmi3Status)fmu_unable(instance, "fmi3GetIntervalDecimal");
}

FMU_FUNCTION(fmi3Status, fmi3GetIntervalFraction)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                                  size_t nValueReferences, fmi3UInt64 counters[],
                                                  fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)nValueReferences, (void)counters, (void)resolutions, (void)qualifiers;
    return (fmi3Status)fmu_unable(instance, "fmi3GetIntervalFraction");
}

FMU_FUNCTION(fmi3Status, fmi3GetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                              size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)valueReferences, (void)nValueReferences, (void)shifts;
    return (fmi3Status)fmu_unable(instance, "fmi3GetShiftDecimal");
}

FMU_FUNCTION(fmi3Status, fmi3GetShiftFraction)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                               size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)nValueReferences, (void)counters, (void)resolutions;
    return (fmi3Status)fmu_unable(instance, "fmi3GetShiftFraction");
}

FMU_FUNCTION(fmi3Status, fmi3SetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                                 size_t nValueReferences, const fmi3Float64 intervals[])
{
    (void)valueReferences, (void)nValueReferences, (void)intervals;
    return (fmi3Status)fmu_unable(instance, "fmi3SetIntervalDecimal");
}

FMU_FUNCTION(fmi3Status, fmi3SetIntervalFraction)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                                  size_t nValueReferences, const fmi3UInt64 counters[],
                                                  const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)nValueReferences, (void)counters, (void)resolutions;
    return (fmi3Status)fmu_unable(instance, "fmi3SetIntervalFraction");
}

FMU_FUNCTION(fmi3Status, fmi3SetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                              size_t nValueReferences, const fmi3Float64 shifts[])
{
    (void)valueReferences, (void)nValueReferences, (void)shifts;
    return (fmi3Status)fmu_unable(instance, "fmi3SetShiftDecimal");
}

FMU_FUNCTION(fmi3Status, fmi3SetShiftFraction)(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                               size_t nValueReferences, const fmi3UInt64 counters[],
                                               const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)nValueReferences, (void)counters, (void)resolutions;
    return (fmi3Status)fmu_unable(instance, "fmi3SetShiftFraction");
}

FMU_FUNCTION(fmi3Status, fmi3EvaluateDiscreteStates)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3EvaluateDiscreteStates");
}

FMU_FUNCTION(fmi3Status, fmi3UpdateDiscreteStates)(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                                   fmi3Boolean *terminateSimulation,
                                                   fmi3Boolean *nominalsOfContinuousStatesChanged,
                                                   fmi3Boolean *valuesOfContinuousStatesChanged,
                                                   fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    (void)discreteStatesNeedUpdate, (void)terminateSimulation, (void)nominalsOfContinuousStatesChanged;
    (void)valuesOfContinuousStatesChanged, (void)nextEventTimeDefined, (void)nextEventTime;
    return (fmi3Status)fmu_unable(instance, "fmi3UpdateDiscreteStates");
}

// Functions of model exchange and scheduled execution, which some importers look up in any FMU

FMU_FUNCTION(fmi3Status, fmi3EnterContinuousTimeMode)(fmi3Instance instance)
{
    return (fmi3Status)fmu_unable(instance, "fmi3EnterContinuousTimeMode");
}

FMU_FUNCTION(fmi3Status, fmi3CompletedIntegratorStep)(fmi3Instance instance,
                                                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                                      fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint, (void)enterEventMode, (void)terminateSimulation;
    return (fmi3Status)fmu_unable(instance, "fmi3CompletedIntegratorStep");
}

FMU_FUNCTION(fmi3Status, fmi3SetTime)(fmi3Instance instance, fmi3Float64 time)
{
    (void)time;
    return (fmi3Status)fmu_unable(instance, "fmi3SetTime");
}

FMU_FUNCTION(fmi3Status, fmi3SetContinuousStates)(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                                  size_t nContinuousStates)
{
    (void)continuousStates, (void)nContinuousStates;
    return (fmi3Status)fmu_unable(instance, "fmi3SetContinuousStates");
}

#define FMU_NO_STATES(name)                                                                                            \
    FMU_FUNCTION(fmi3Status, name)(fmi3Instance instance, fmi3Float64 values[], size_t count)                          \
    {                                                                                                                  \
        (void)values, (void)count;                                                                                     \
        return (fmi3Status)fmu_unable(instance, #name);                                                                \
    }

FMU_NO_STATES(fmi3GetContinuousStateDerivatives)
FMU_NO_STATES(fmi3GetEventIndicators)
FMU_NO_STATES(fmi3GetContinuousStates)
FMU_NO_STATES(fmi3GetNominalsOfContinuousStates)

#define FMU_NO_NUMBER(name)                                                                                            \
    FMU_FUNCTION(fmi3Status, name)(fmi3Instance instance, size_t *count)                                               \
    {                                                                                                                  \
        (void)count;                                                                                                   \
        return (fmi3Status)fmu_unable(instance, #name);                                                                \
    }

FMU_NO_NUMBER(fmi3GetNumberOfEventIndicators)
FMU_NO_NUMBER(fmi3GetNumberOfContinuousStates)

FMU_FUNCTION(fmi3Status, fmi3ActivateModelPartition)(fmi3Instance instance, fmi3ValueReference clockReference,
                                                     fmi3Float64 activationTime)
{
    (void)clockReference, (void)activationTime;
    return (fmi3Status)fmu_unable(instance, "fmi3ActivateModelPartition");
}
