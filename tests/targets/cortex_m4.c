/* Start of a Cortex-M4 in an emulator: vectors, floating-point unit, then newlib's start, which prints by semihosting. */
#include <stdint.h>

extern uint32_t stack_top;
extern void _start(void);
void reset(void);
void stop(void);
void _init(void);
void _fini(void);

/* CPACR: full access to the coprocessors 10 and 11, which are the floating-point unit. */
#define CPACR (*(volatile uint32_t *)0xE000ED88u)

/* What newlib calls before and after main besides constructors, which C does not have. */
void _init(void) {}
void _fini(void) {}

void reset(void)
{
    CPACR |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    _start();
}

/* A fault is no hang: semihosting's SYS_EXIT (0x18) with another reason than ADP_Stopped_ApplicationExit. */
void stop(void)
{
    __asm volatile("mov r0, #0x18\n\tmov r1, #0x20000\n\tbkpt 0xAB");
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    (uintptr_t)&stack_top, (uintptr_t)reset, (uintptr_t)stop, (uintptr_t)stop,
    (uintptr_t)stop,       (uintptr_t)stop,  (uintptr_t)stop,
};
