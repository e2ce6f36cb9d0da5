/* A host in C: loads the library of an unpacked FMU and answers each line of inputs with a line of outputs.
 *
 *   host cs|me LIBRARY GUID RESOURCES-URI STEP INPUTS REFERENCE... OUTPUTS REFERENCE... < in > out
 *
 * A line of `in` holds one number for each input; a line of `out` what belongs to it: by Co-Simulation (cs),
 * fmi2SetReal, fmi2DoStep, fmi2GetReal, or by Model Exchange (me), where a solver would stand around
 * fmi2SetTime, fmi2SetReal, fmi2GetReal. */
#include "unit.h"

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
    int exchange = *arguments[1] == 'm';
    load(arguments[2]);
    char **at = arguments + 6;
    size_t ins, outs;
    unsigned *inputs = references(&at, &ins), *outputs = references(&at, &outs);
    double *u = calloc(ins + 1, sizeof *u), *y = calloc(outs + 1, sizeof *y);
    double h = strtod(arguments[5], NULL);

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
        if (exchange) need(set_time(mesh, t));
        need(set(mesh, inputs, ins, u));
        if (!exchange) need(step(mesh, t, h, 1));
        need(get(mesh, outputs, outs, y));
        for (size_t i = 0; i < outs; i++) printf("%.17g%c", y[i], i + 1 < outs ? ' ' : '\n');
    } while (line(u, ins));
    need(terminate(mesh));
    destroy(mesh);
    return 0;
}
