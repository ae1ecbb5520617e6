/* Runs a self-test, compiled with -Dmain=selftest, on an AVR: prints through the first serial port, and stops. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdio.h>

int selftest(void);

static int put(char c, FILE *stream)
{
    (void)stream;
    while ((UCSR0A & (1 << UDRE0)) == 0) {
    }
    UDR0 = c;
    return 0;
}

static FILE port = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);

int main(void)
{
    UCSR0B = 1 << TXEN0;
    stdout = &port;
    stderr = &port;
    printf("exit %d\n", selftest());
    /* The emulator ends where the core sleeps and nothing can wake it. */
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
