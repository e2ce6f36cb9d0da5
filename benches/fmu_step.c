/* Time of one step of an unpacked unit from C: set all inputs, do the step, get all main outputs.
 *
 * fmu_step LIBRARY GUID RESOURCES-URI STEPS FIRST-INPUT INPUTS FIRST-OUTPUT OUTPUTS
 * prints the median over batches in nanoseconds, and the mean of output 6. */
#define _POSIX_C_SOURCE 199309L
#include "../examples/hosts/c_program/unit.h"
#include <time.h>

enum { BATCHES = 41, MOST = 64 };

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

int main(int count, char **arguments) {
    if (count != 9) {
        fprintf(stderr, "fmu_step LIBRARY GUID URI STEPS FIRST-INPUT INPUTS FIRST-OUTPUT OUTPUTS\n");
        return 2;
    }
    load(arguments[1]);
    unsigned first_in = (unsigned)atoi(arguments[5]), first_out = (unsigned)atoi(arguments[7]);
    size_t ins = (size_t)atoi(arguments[6]), outs = (size_t)atoi(arguments[8]);
    int steps = atoi(arguments[4]);
    unsigned in[MOST], out[MOST];
    double u[MOST], y[MOST], times[BATCHES];
    if (ins > MOST || outs > MOST || steps < 1)
        return 2;
    for (size_t i = 0; i < ins; i++)
        in[i] = first_in + (unsigned)i;
    for (size_t i = 0; i < outs; i++)
        out[i] = first_out + (unsigned)i;

    component mesh = instantiate("mesh", 1, arguments[2], arguments[3], &own, 0, 0);
    if (!mesh)
        return 1;
    need(setup(mesh, 0, 0.0, 0.0, 0, 0.0));
    need(enter(mesh));
    need(leave(mesh));
    need(get(mesh, in, ins, u));
    const double h = 1e-6;
    double t = 0, sum = 0;
    /* Input 6 is gear1.angles[3]: loaded by about 5 um on the line of action, it goes to and fro. */
    for (int batch = 0; batch < BATCHES; batch++) {
        double begin = now();
        for (int i = 0; i < steps; i++) {
            u[5] = 1.3e-4 + 1e-8 * (i % 1000);
            need(set(mesh, in, ins, u));
            need(step(mesh, t, h, 1));
            need(get(mesh, out, outs, y));
            t += h;
            sum += y[5];
        }
        times[batch] = (now() - begin) / steps;
    }
    qsort(times, BATCHES, sizeof *times, ascending);
    printf("%.1f %.6g\n", times[BATCHES / 2], sum / BATCHES / steps);
    need(terminate(mesh));
    destroy(mesh);
    return 0;
}
