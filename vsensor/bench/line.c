/* The march, the observer's step and its corrections (vsensor/estimator/line.py, load.py, along.py and
 * observe.py) as a C programmer would write them: the same arithmetic in the same order on arrays of the
 * same layout. The yardstick of `vsensor bench kernel`. FADE_SPEED and SPARE come by the command line. */

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

/* As vsensor/estimator/ring.py. */
static inline int64_t mask_of(int64_t length)
{
    return length - SPARE - 1;
}

static inline double rubbing(const struct line *line, int64_t junction, double speed)
{
    double share = speed / FADE_SPEED;
    if (share < -1.0)
        share = -1.0;
    if (share > 1.0)
        share = 1.0;
    return line->viscous[junction] * speed + line->kinetic[junction] * share;
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
    double x = drive * (1.0 / resistance);
    const double fall = load->held - load->kinetic;
    if (x <= 0 || fall == 0)
        return x > 0 ? x : 0;
    const double rate = 1.0 / load->stribeck;
    for (int k = 0; k < 50; k++) {
        const double gone = fall * exp(-x * rate), slope = gone * rate, steep = resistance - slope;
        if (steep <= 0)
            return 0;
        const double change = (resistance * x + gone - drive) / steep;
        x -= change;
        if (x <= 0)
            return 0;
        if (slope * rate * change * change <= 1e-12 * x * steep)
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
    return copysign(fabs(drive) - kinetic, drive) * (1.0 / resistance);
}

/* Waves are rings of length `size`, one a section; told: four of them; ahead: two of length `room`. */
struct string {
    double *waves, *returned, *junctions, *balances, *rock, *told, *ahead;
    int64_t size, room;
};

struct drive {
    double rate, fade;
};

static double march(const struct line *line, const struct load *load, double *waves, int64_t size,
                    int64_t known, int64_t steps, int64_t heard, int64_t reach, double external, double fade,
                    double *speeds, double *balance, double *told, int64_t room)
{
    const int64_t mask = mask_of(size), last = line->sections - 1;
    const double foot = line->impedance[last];
    int64_t highest = 0, matters = reach;
    double g = 0;
    for (int64_t i = 1; i <= last; i++)
        matters -= line->round_trip[i];
    for (int64_t ahead = 1; ahead <= steps; ahead++) {
        while (ahead > matters && highest < last)
            matters += line->round_trip[++highest];
        const int64_t step = known + ahead;
        int64_t left = step - line->round_trip[last];
        if (last == 0 && left > heard)
            left = heard;
        double f = waves[last * size + (left & mask)] - external;
        double w = turn_bit(load, line, f, speeds[last + 1], balance);
        speeds[last + 1] = w;
        told[step & mask_of(room)] = w;
        told[room + (step & mask_of(room))] = external + (w != 0 ? law(load, w) : f);
        g = f + external - 2 * foot * w;
        external *= fade;
        for (int64_t i = last - 1; i >= highest; i--) {
            left = step - line->round_trip[i];
            if (i == 0 && left > heard)
                left = heard;
            f = waves[i * size + (left & mask)];
            const double z = line->impedance[i], below = line->impedance[i + 1];
            w = contact(f - g, z + below + line->viscous[i + 1], line->kinetic[i + 1], line->held[i + 1],
                        speeds[i + 1]);
            speeds[i + 1] = w;
            waves[(i + 1) * size + (step & mask)] = g + 2 * below * w;
            g = f - 2 * z * w;
        }
    }
    return g;
}

/* `times` marches of `steps` steps after step `known`, each from the string as it stands */
void foretell(const struct line *line, const struct load *load, struct string *s, int64_t known, int64_t steps,
              double fade, double *marching, int64_t times)
{
    for (int64_t time = 0; time < times; time++) {
        double balance = s->balances[1];
        for (int64_t i = 0; i <= line->sections; i++)
            marching[i] = s->junctions[i];
        march(line, load, s->waves, s->size, known, steps, known, steps, *s->rock * fade, fade, marching,
              &balance, s->ahead, s->room);
    }
}

/* `n` steps of the whole string from step `first` on, by the motor's torque */
void turn(const struct line *line, const struct load *load, const struct drive *drive, struct string *s,
          int64_t first, const double *torque, int64_t n)
{
    const int64_t size = s->size, mask = mask_of(size);
    const double z = line->impedance[0];
    for (int64_t k = 0; k < n; k++) {
        const int64_t step = first + k, now = step & mask;
        *s->rock *= drive->fade;
        const double g = march(line, load, s->waves, size, step - 1, 1, step - 1, INT64_C(1) << 60, *s->rock,
                               1.0, s->junctions, s->balances + 1, s->told, size);
        const double pull = torque[k] - g, before = s->junctions[0];
        const double w = contact(pull + drive->rate * before + s->balances[0],
                                 drive->rate + z + line->viscous[0], line->kinetic[0], line->held[0], before);
        s->balances[0] = w != 0 ? drive->rate * (w - before) - s->balances[0] : 0;
        s->junctions[0] = w;
        s->waves[now] = g + 2 * z * w;
        s->told[2 * size + now] = w;
        s->told[3 * size + now] = g + z * w + rubbing(line, 0, w);
        for (int64_t i = 0; i < line->sections; i++) {
            const double arrived = s->waves[i * size + ((step - line->round_trip[i]) & mask)];
            s->returned[i * size + now] = arrived - 2 * line->impedance[i] * s->junctions[i + 1];
        }
    }
}

static void correct_waves(const double *gains, const int64_t *inside, int64_t sections, int64_t lag,
                          double *waves, int64_t size, int64_t last, double innovation)
{
    const int64_t mask = mask_of(size);
    for (int64_t i = 0; i < sections; i++)
        for (int64_t ago = 0; ago < lag && ago < inside[i]; ago++)
            waves[i * size + ((last - ago) & mask)] += gains[(i + 1) * lag - 1 - ago] * innovation;
}

/* Corrections by `n` innovations; gains: state (5), waves (sections × lag), told (4 × lag), newest last */
void correct(const double *state, const double *waves, const double *told, const int64_t *inside,
             int64_t sections, int64_t lag, struct string *s, int64_t last, const double *innovation, int64_t n)
{
    const int64_t size = s->size, mask = mask_of(size);
    for (int64_t k = 0; k < n; k++) {
        const double by = innovation[k];
        if (s->junctions[0] != 0) {
            s->junctions[0] += state[0] * by;
            s->balances[0] += state[1] * by;
        }
        if (s->junctions[sections] != 0) {
            s->junctions[sections] += state[2] * by;
            s->balances[1] += state[3] * by;
        }
        *s->rock += state[4] * by;
        correct_waves(waves, inside, sections, lag, s->waves, size, last, by);
        for (int64_t ago = 0; ago < lag; ago++) {
            const int64_t at = (last - ago) & mask;
            if (s->told[at] != 0) {
                s->told[at] += told[lag - 1 - ago] * by;
                s->told[size + at] += told[2 * lag - 1 - ago] * by;
            }
            s->told[2 * size + at] += told[3 * lag - 1 - ago] * by;
            s->told[3 * size + at] += told[4 * lag - 1 - ago] * by;
        }
    }
}
