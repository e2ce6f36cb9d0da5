/* The library of an unpacked FMU, for host.c and benches/fmu_step.c. Prototypes as in fmi2FunctionTypes.h of FMI 2.0. */
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
typedef struct {
    int needed, terminate, nominals, values, defined;
    double next;
} event_info;

static component (*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int);
static int (*setup)(component, int, double, double, int, double);
static int (*enter)(component), (*leave)(component), (*terminate)(component);
static int (*set)(component, const unsigned *, size_t, const double *);
static int (*get)(component, const unsigned *, size_t, double *);
static int (*step)(component, double, double, int);
static int (*set_time)(component, double), (*events)(component, event_info *), (*integrate)(component);
static void (*destroy)(component);

static void say(void *e, const char *name, int status, const char *category, const char *format, ...) {
    va_list rest;
    (void)e;
    fprintf(stderr, "%s (%s, status %d): ", name, category, status);
    va_start(rest, format);
    vfprintf(stderr, format, rest);
    va_end(rest);
    fputc('\n', stderr);
}

static const callbacks own = {say, NULL, NULL, NULL, NULL}; /* the FMU allocates by itself */

/* The FMU has said why, through the logger. */
static void need(int status) {
    if (status > 1) exit(1);
}

static void load(const char *path) {
    /* Through a pointer to a pointer, as POSIX suggests: ISO C has no such cast for functions. */
    struct {
        const char *name;
        void **place;
    } all[] = {
        {"fmi2Instantiate", (void **)&instantiate},
        {"fmi2SetupExperiment", (void **)&setup},
        {"fmi2EnterInitializationMode", (void **)&enter},
        {"fmi2ExitInitializationMode", (void **)&leave},
        {"fmi2SetReal", (void **)&set},
        {"fmi2DoStep", (void **)&step},
        {"fmi2GetReal", (void **)&get},
        {"fmi2SetTime", (void **)&set_time},
        {"fmi2NewDiscreteStates", (void **)&events},
        {"fmi2EnterContinuousTimeMode", (void **)&integrate},
        {"fmi2Terminate", (void **)&terminate},
        {"fmi2FreeInstance", (void **)&destroy},
    };
    void *library = dlopen(path, RTLD_NOW);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        *all[i].place = dlsym(library, all[i].name);
        if (!*all[i].place) {
            fprintf(stderr, "%s is missing\n", all[i].name);
            exit(1);
        }
    }
}
