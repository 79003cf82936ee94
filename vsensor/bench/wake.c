/* A bare loop: sleeps until each slot of an absolute grid and notes how late it woke. The yardstick of
 * `vsensor bench live`; slots that have passed are skipped by the rule of vsensor/service/pace.py.
 *
 *     wake RATE_HZ SECONDS PRIORITY
 *
 * PRIORITY is SCHED_FIFO's, 0 for none; timers are exact, as the daemon's are (PR_SET_TIMERSLACK). It
 * writes the slot's number and the lateness in ns, two int64 a slot, when all is over. */

#define _GNU_SOURCE
#include <math.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <time.h>

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

static void sleep_until(int64_t ns)
{
    const struct timespec t = {ns / 1000000000, ns % 1000000000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 2;
    const struct sched_param priority = {.sched_priority = atoi(argv[3])};
    if (priority.sched_priority && sched_setscheduler(0, SCHED_FIFO, &priority))
        return 3;
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    const double rate = atof(argv[1]);
    const int64_t slots = llround(rate * atof(argv[2]));
    int64_t *noted = calloc(2 * slots + 2, sizeof *noted), count = 0;
    if (!noted)
        return 1;
    const int64_t start = now_ns();
    for (int64_t number = 0;;) {
        const int64_t due = number + 1, current = (now_ns() - start) * rate / 1e9;
        number = current > due ? current : due;
        if (number > slots)
            break;
        const int64_t deadline = start + llround(number * 1e9 / rate);
        sleep_until(deadline);
        noted[2 * count] = number;
        noted[2 * count + 1] = now_ns() - deadline;
        count++;
    }
    fwrite(noted, 2 * sizeof *noted, count, stdout);
    return 0;
}
