/* Time of one step of an unpacked unit from C: set all inputs, do the step, get all main outputs.
 *
 * fmu_step LIBRARY GUID RESOURCES-URI STEPS FIRST-INPUT INPUTS FIRST-OUTPUT OUTPUTS
 * prints the median over batches in nanoseconds. FMI 2.0.5; prototypes as in fmi2FunctionTypes.h. */
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef void *component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

enum { BATCHES = 41, MOST = 64 };

static void say(void *e, const char *name, int status, const char *category, const char *text, ...) {
    (void)e;
    (void)category;
    fprintf(stderr, "%s: status %d: %s\n", name, status, text);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

static void *need(void *library, const char *name) {
    void *f = dlsym(library, name);
    if (!f) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
    return f;
}

#define TRY(call) do { if ((call) > 1) { fprintf(stderr, "%s failed\n", #call); return 1; } } while (0)

int main(int count, char **arguments) {
    if (count != 9) {
        fprintf(stderr, "fmu_step LIBRARY GUID URI STEPS FIRST-INPUT INPUTS FIRST-OUTPUT OUTPUTS\n");
        return 2;
    }
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    component (*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int);
    int (*setup)(component, int, double, double, int, double);
    int (*enter)(component), (*leave)(component), (*terminate)(component);
    int (*set)(component, const unsigned *, size_t, const double *);
    int (*get)(component, const unsigned *, size_t, double *);
    int (*step)(component, double, double, int);
    void (*destroy)(component);
    /* Through a pointer to a pointer, as POSIX suggests: ISO C has no such cast for functions. */
    *(void **)&instantiate = need(library, "fmi2Instantiate");
    *(void **)&setup = need(library, "fmi2SetupExperiment");
    *(void **)&enter = need(library, "fmi2EnterInitializationMode");
    *(void **)&leave = need(library, "fmi2ExitInitializationMode");
    *(void **)&terminate = need(library, "fmi2Terminate");
    *(void **)&set = need(library, "fmi2SetReal");
    *(void **)&get = need(library, "fmi2GetReal");
    *(void **)&step = need(library, "fmi2DoStep");
    *(void **)&destroy = need(library, "fmi2FreeInstance");

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

    callbacks host = {say, calloc, free, NULL, NULL};
    component c = instantiate("mesh", 1, arguments[2], arguments[3], &host, 0, 0);
    if (!c)
        return 1;
    TRY(setup(c, 0, 0.0, 0.0, 0, 0.0));
    TRY(enter(c));
    TRY(leave(c));
    TRY(get(c, in, ins, u));
    const double h = 1e-6;
    double t = 0, sum = 0;
    /* Input 6 is gear1.angles[3]: loaded by about 5 um on the line of action, it goes to and fro. */
    for (int batch = 0; batch < BATCHES; batch++) {
        double begin = now();
        for (int i = 0; i < steps; i++) {
            u[5] = 1.3e-4 + 1e-8 * (i % 1000);
            TRY(set(c, in, ins, u));
            TRY(step(c, t, h, 1));
            TRY(get(c, out, outs, y));
            t += h;
            sum += y[5];
        }
        times[batch] = (now() - begin) / steps;
    }
    qsort(times, BATCHES, sizeof *times, ascending);
    printf("%.1f %.6g\n", times[BATCHES / 2], sum / BATCHES / steps);
    terminate(c);
    destroy(c);
    dlclose(library);
    return 0;
}
