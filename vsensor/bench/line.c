/* The descent and the march of vsensor/estimator/line.py and load.py as a C programmer would write
 * them: the same arithmetic in the same order on arrays of the same layout. The yardstick of
 * `vsensor bench kernel`. FADE_SPEED comes by the command line. */

#include <math.h>
#include <stdint.h>

struct line {
    int64_t sections;
    const double *impedance;
    const int64_t *round_trip;
    const double *viscous, *kinetic, *held;
};

struct load {
    double viscous, kinetic, held, stribeck, inertia_rate;
};

static inline double rubbing(const struct line *line, int64_t junction, double speed)
{
    double share = speed / FADE_SPEED;
    if (share < -1.0)
        share = -1.0;
    if (share > 1.0)
        share = 1.0;
    return line->viscous[junction] * speed + line->kinetic[junction] * share;
}

/* waves, returned: sections rings of `size` (a power of two) one behind the other; bottom: n torques, n speeds */
void descend(const struct line *line, double *waves, double *returned, int64_t size, double *speeds,
             const double *torque, const double *speed, int64_t n, double *bottom)
{
    const int64_t mask = size - 1;
    for (int64_t step = 0; step < n; step++) {
        double w = speed[step];
        double t = torque[step] - rubbing(line, 0, w);
        speeds[0] = w;
        for (int64_t i = 0; i < line->sections; i++) {
            double *ring = waves + i * size;
            const double z = line->impedance[i];
            const double f = t + z * w, g = t - z * w;
            ring[step & mask] = f;
            returned[i * size + (step & mask)] = g;
            const double arrived = ring[(step - line->round_trip[i]) & mask];
            t = 0.5 * (arrived + g);
            w = 0.5 * (arrived - g) / z;
            t -= rubbing(line, i + 1, w);
            speeds[i + 1] = w;
        }
        bottom[step] = t;
        bottom[n + step] = w;
    }
}

static double law(const struct load *load, double speed)
{
    if (speed == 0)
        return 0;
    double coulomb = load->kinetic + (load->held - load->kinetic) * exp(-fabs(speed) / load->stribeck);
    return load->viscous * speed + copysign(coulomb, speed);
}

static double sliding(const struct load *load, double drive, double resistance)
{
    double x = drive / resistance;
    const double fall = load->held - load->kinetic;
    if (x <= 0 || fall == 0)
        return x > 0 ? x : 0;
    for (int k = 0; k < 50; k++) {
        const double gone = fall * exp(-x / load->stribeck);
        const double steep = resistance - gone / load->stribeck;
        if (steep <= 0)
            return 0;
        const double change = (resistance * x + gone - drive) / steep;
        x -= change;
        if (x <= 0)
            return 0;
        if (fabs(change) <= 1e-12 * x)
            break;
    }
    return x;
}

static double turn_bit(const struct load *load, const struct line *line, double f, double before,
                       double *balance)
{
    const int64_t end = line->sections;
    const double drive = f + load->inertia_rate * before + *balance;
    if (before == 0 && fabs(drive) <= load->held + line->held[end]) {
        *balance = 0;
        return 0;
    }
    const double resistance =
        load->inertia_rate + line->impedance[end - 1] + line->viscous[end] + load->viscous;
    const double x = sliding(load, fabs(drive) - load->kinetic - line->kinetic[end], resistance);
    if (x == 0) {
        *balance = 0;
        return 0;
    }
    const double w = copysign(x, drive);
    *balance = load->inertia_rate * (w - before) - *balance;
    return w;
}

static inline double contact(double drive, double resistance, double kinetic, double held, double before)
{
    if (fabs(drive) <= (before == 0 ? held : kinetic))
        return 0;
    return copysign(fabs(drive) - kinetic, drive) / resistance;
}

/* `times` marches of `steps` steps after step `known`, each from the speeds in `start` */
void march(const struct line *line, const struct load *load, double *waves, int64_t size, int64_t known,
           int64_t steps, const double *start, double *speeds, double *told, int64_t times)
{
    const int64_t mask = size - 1, last = line->sections - 1;
    const double foot = line->impedance[last];
    for (int64_t time = 0; time < times; time++) {
        int64_t highest = 0, matters = steps;
        double balance = 0;
        for (int64_t i = 0; i <= last + 1; i++)
            speeds[i] = start[i];
        for (int64_t i = 1; i <= last; i++)
            matters -= line->round_trip[i];
        for (int64_t ahead = 1; ahead <= steps; ahead++) {
            while (ahead > matters && highest < last)
                matters += line->round_trip[++highest];
            const int64_t step = known + ahead;
            int64_t left = step - line->round_trip[last];
            if (last == 0 && left > known)
                left = known;
            double f = waves[last * size + (left & mask)];
            double w = turn_bit(load, line, f, speeds[last + 1], &balance);
            speeds[last + 1] = w;
            told[ahead - 1] = w;
            told[steps + ahead - 1] = w != 0 ? law(load, w) : f;
            double g = f - 2 * foot * w;
            for (int64_t i = last - 1; i >= highest; i--) {
                left = step - line->round_trip[i];
                if (i == 0 && left > known)
                    left = known;
                f = waves[i * size + (left & mask)];
                const double z = line->impedance[i], below = line->impedance[i + 1];
                w = contact(f - g, z + below + line->viscous[i + 1], line->kinetic[i + 1],
                            line->held[i + 1], speeds[i + 1]);
                speeds[i + 1] = w;
                waves[(i + 1) * size + (step & mask)] = g + 2 * below * w;
                g = f - 2 * z * w;
            }
        }
    }
}
