/* A host in C: loads the library of an unpacked FMU and answers each line of inputs with a line of outputs.
 *
 *   host cs|me LIBRARY GUID RESOURCES-URI STEP INPUTS REFERENCE... OUTPUTS REFERENCE... < in > out
 *
 * A line of `in` holds one number for each input; a line of `out` what belongs to it: by Co-Simulation (cs),
 * fmi2SetReal, fmi2DoStep, fmi2GetReal, or by Model Exchange (me), where a solver would stand around
 * fmi2SetTime, fmi2SetReal, fmi2GetReal. Prototypes as in fmi2FunctionTypes.h of FMI 2.0. */
#ifdef _WIN32
#include <windows.h>
#define RTLD_NOW 0
#define dlopen(path, mode) ((void *)LoadLibraryA(path))
#define dlsym(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#define dlerror() "the library cannot be loaded"
#else
#include <dlfcn.h>
#endif
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

static void say(void *e, const char *name, int status, const char *category, const char *format, ...) {
    va_list rest;
    (void)e;
    fprintf(stderr, "%s (%s, status %d): ", name, category, status);
    va_start(rest, format);
    vfprintf(stderr, format, rest);
    va_end(rest);
    fputc('\n', stderr);
}

typedef struct {
    int needed, terminate, nominals, values, defined;
    double next;
} event_info;

static void *library;

static void *function(const char *name) {
    void *f = dlsym(library, name);
    if (!f) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
    return f;
}

/* The FMU has said why, through the logger. */
static void need(int status) {
    if (status > 1) exit(1);
}

static unsigned *references(char ***at, size_t *n) {
    *n = strtoul(*(*at)++, NULL, 10);
    unsigned *out = malloc((*n + 1) * sizeof *out);
    for (size_t i = 0; out && i < *n; i++) out[i] = (unsigned)strtoul(*(*at)++, NULL, 10);
    return out;
}

static int line(double *values, size_t n) {
    size_t i = 0;
    while (i < n && scanf("%lf", &values[i]) == 1) i++;
    return i == n;
}

int main(int count, char **arguments) {
    (void)count;
    component (*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int);
    int (*setup)(component, int, double, double, int, double);
    int (*enter)(component), (*leave)(component), (*terminate)(component);
    int (*set)(component, const unsigned *, size_t, const double *);
    int (*get)(component, const unsigned *, size_t, double *);
    int (*step)(component, double, double, int);
    int (*time)(component, double), (*events)(component, event_info *), (*integrate)(component);
    void (*destroy)(component);
    int exchange = *arguments[1] == 'm';
    library = dlopen(arguments[2], RTLD_NOW);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    *(void **)&instantiate = function("fmi2Instantiate");
    *(void **)&setup = function("fmi2SetupExperiment");
    *(void **)&enter = function("fmi2EnterInitializationMode");
    *(void **)&leave = function("fmi2ExitInitializationMode");
    *(void **)&set = function("fmi2SetReal");
    *(void **)&step = function("fmi2DoStep");
    *(void **)&get = function("fmi2GetReal");
    *(void **)&time = function("fmi2SetTime");
    *(void **)&events = function("fmi2NewDiscreteStates");
    *(void **)&integrate = function("fmi2EnterContinuousTimeMode");
    *(void **)&terminate = function("fmi2Terminate");
    *(void **)&destroy = function("fmi2FreeInstance");

    char **at = arguments + 6;
    size_t ins, outs;
    unsigned *inputs = references(&at, &ins), *outputs = references(&at, &outs);
    double *u = calloc(ins + 1, sizeof *u), *y = calloc(outs + 1, sizeof *y);
    double h = strtod(arguments[5], NULL);
    const callbacks own = {say, NULL, NULL, NULL, NULL}; /* the FMU allocates by itself */

    component mesh = instantiate("mesh", exchange ? 0 : 1, arguments[3], arguments[4], &own, 0, 1);
    if (!mesh || !inputs || !outputs || !u || !y || !line(u, ins)) return 1;
    need(setup(mesh, 0, 0.0, 0.0, 0, 0.0));
    need(enter(mesh));
    need(set(mesh, inputs, ins, u)); /* the start pose sets the phase offset */
    need(leave(mesh));
    if (exchange) {
        event_info info;
        need(events(mesh, &info));
        need(integrate(mesh));
    }
    long n = 0;
    do {
        double t = (double)n++ * h;
        if (exchange) need(time(mesh, t));
        need(set(mesh, inputs, ins, u));
        if (!exchange) need(step(mesh, t, h, 1));
        need(get(mesh, outputs, outs, y));
        for (size_t i = 0; i < outs; i++) printf("%.17g%c", y[i], i + 1 < outs ? ' ' : '\n');
    } while (line(u, ins));
    need(terminate(mesh));
    destroy(mesh);
    return 0;
}
