/* A co-simulation unit that computes nothing, for the cost of the interface itself: 48 Real inputs (value references
 * from 0) and up to 32 Real outputs behind them, each set and got through a switch with a check of the state, as the
 * Reference FMUs of the FMI project do. FMI 2.0.5; prototypes as in fmi2FunctionTypes.h. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

typedef enum { OK, WARNING, DISCARD, ERROR } status;
typedef enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 } state;
typedef struct {
    state state;
    double time;
    double value[80];
} unit;

#define EACH_INPUT(X) \
    X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15) X(16) X(17) X(18) X(19) \
    X(20) X(21) X(22) X(23) X(24) X(25) X(26) X(27) X(28) X(29) X(30) X(31) X(32) X(33) X(34) X(35) X(36) X(37) \
    X(38) X(39) X(40) X(41) X(42) X(43) X(44) X(45) X(46) X(47)
#define EACH_OUTPUT(X) \
    X(48) X(49) X(50) X(51) X(52) X(53) X(54) X(55) X(56) X(57) X(58) X(59) X(60) X(61) X(62) X(63) X(64) X(65) \
    X(66) X(67) X(68) X(69) X(70) X(71) X(72) X(73) X(74) X(75) X(76) X(77) X(78) X(79)

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *uri, const void *callbacks,
                      int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)uri, (void)callbacks, (void)visible, (void)logging;
    unit *u = calloc(1, sizeof *u);
    if (u)
        u->state = INSTANTIATED;
    return u;
}

void fmi2FreeInstance(void *c) { free(c); }

static status move(unit *u, state from, state to) {
    if (!u || !(u->state & from))
        return ERROR;
    u->state = to;
    return OK;
}

int fmi2SetupExperiment(void *c, int tolerance_defined, double tolerance, double start, int stop_defined, double stop) {
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    ((unit *)c)->time = start;
    return OK;
}

int fmi2EnterInitializationMode(void *c) { return (int)move(c, INSTANTIATED, INITIALIZATION); }
int fmi2ExitInitializationMode(void *c) { return (int)move(c, INITIALIZATION, STEPPING); }
int fmi2Terminate(void *c) { return (int)move(c, STEPPING, TERMINATED); }

/* One variable at a time, out of line as there, where a file of its own holds it. */
__attribute__((noinline)) static status set_one(unit *u, unsigned reference, const double *value, size_t *next) {
    switch (reference) {
#define X(r) \
    case r: \
        if (!(u->state & (INSTANTIATED | INITIALIZATION | STEPPING))) \
            return ERROR; \
        u->value[r] = value[(*next)++]; \
        return OK;
        EACH_INPUT(X)
#undef X
    default:
        return ERROR;
    }
}

__attribute__((noinline)) static status get_one(const unit *u, unsigned reference, double *value, size_t *next) {
    switch (reference) {
#define X(r) \
    case r: \
        value[(*next)++] = u->value[r]; \
        return OK;
        EACH_INPUT(X)
        EACH_OUTPUT(X)
#undef X
    default:
        return ERROR;
    }
}

int fmi2SetReal(void *c, const unsigned *references, size_t count, const double *value) {
    unit *u = c;
    size_t next = 0;
    if (!u || !references || !value)
        return ERROR;
    for (size_t i = 0; i < count; i++) {
        status s = set_one(u, references[i], value, &next);
        if (s > WARNING)
            return (int)s;
    }
    return OK;
}

int fmi2GetReal(void *c, const unsigned *references, size_t count, double *value) {
    unit *u = c;
    size_t next = 0;
    if (!u || !references || !value || !(u->state & (INITIALIZATION | STEPPING | TERMINATED)))
        return ERROR;
    for (size_t i = 0; i < count; i++) {
        status s = get_one(u, references[i], value, &next);
        if (s > WARNING)
            return (int)s;
    }
    return OK;
}

int fmi2DoStep(void *c, double point, double step, int no_set_state_prior) {
    unit *u = c;
    (void)no_set_state_prior;
    if (!u || u->state != STEPPING || step <= 0 || fabs(point - u->time) > 1e-9)
        return ERROR;
    u->time = point + step;
    return OK;
}
