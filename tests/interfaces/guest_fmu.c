/* Both sides of a small case as an FMU for FMI 3.0 that is none of ours: a mass on a floor, and a spring with a damper that pulls at it.
   The instantiation token says which side it is, parameter `fault` what goes wrong with it. Only what rimbench calls is here. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { X, V, F, A, MASS, FAULT, RIM_H, RIM_A, RIM_W, RIM_POSITION, RIM_GAP, RIM_OWN, RIM_GAMMA, RIM_E, RIM_K, RIM_C, RIM_STEP, RIM_AT_BOUND };
static const double STIFFNESS = 400.0, DAMPING = 3.0;

typedef struct {
    bool spring;
    double value[RIM_AT_BOUND + 1];
} Guest;

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events,
                                  bool early, const uint32_t *intermediate, size_t n, void *environment, void *log, void *update) {
    Guest *guest = calloc(1, sizeof *guest);
    guest->spring = !strcmp(token, "spring");
    guest->value[MASS] = 2.0;
    guest->value[X] = guest->spring ? 0.0 : 0.01;
    /* A velocity whose sign is all that there is of it. */
    guest->value[V] = -0.0;
    return guest;
}
void fmi3FreeInstance(void *guest) { free(guest); }
int fmi3EnterInitializationMode(void *g, bool tolerant, double tolerance, double t, bool stops, double end) { return 0; }
int fmi3ExitInitializationMode(void *g) { return 0; }
int fmi3Terminate(void *g) { return 0; }

static double acceleration(const Guest *g) { return (g->value[F] - 50.0 * g->value[X]) / g->value[MASS]; }

int fmi3GetFloat64(void *instance, const uint32_t *refs, size_t n, double *values, size_t count) {
    Guest *g = instance;
    double *v = g->value;
    for (size_t i = 0; i < n; i++) switch (refs[i]) {
        case F: *values++ = g->spring ? -STIFFNESS * v[X] - DAMPING * v[V] : v[F]; break;
        /* With fault 8 in mm/s², which it declares as m/s². */
        case A: *values++ = acceleration(g) * (v[FAULT] == 8.0 ? 1000.0 : 1.0); break;
        case RIM_H: for (int k = 0; k < 4; k++) *values++ = 1.0 / v[MASS]; break;
        case RIM_A: for (int k = 0; k < 2; k++) *values++ = -50.0 * v[X] / v[MASS]; break;
        case RIM_W: for (int k = 0; k < 2; k++) *values++ = v[V]; break;
        case RIM_POSITION: *values++ = v[X]; break;
        /* The floor lies a little below where it comes to. */
        case RIM_GAP: *values++ = v[X] + 0.02; break;
        default: *values++ = v[refs[i]];
        }
    return 0;
}
int fmi3SetFloat64(void *instance, const uint32_t *refs, size_t n, const double *values, size_t count) {
    for (size_t i = 0; i < n; i++) ((Guest *)instance)->value[refs[i]] = values[i];
    return 0;
}
/* A truth of C is any number but 0; with fault 3 it is 1, with fault 4 there is none. */
int fmi3GetBoolean(void *instance, const uint32_t *refs, size_t n, unsigned char *values, size_t count) {
    const double *v = ((Guest *)instance)->value;
    memset(values, v[X] > 0.0 || v[FAULT] == 4.0 ? 0 : v[FAULT] == 3.0 ? 1 : 6, count);
    return 0;
}
int fmi3DoStep(void *instance, double t, double h, bool no_way_back, bool *event, bool *terminate, bool *early, double *last) {
    Guest *g = instance;
    double *v = g->value;
    if ((v[FAULT] == 1.0 || v[FAULT] == 2.0) && t > 0.0095) {
        printf("/home/somebody/model.c: fault %g\n", v[FAULT]);
        fflush(stdout);
        const char *mark = getenv("GUEST_MARK");
        if (mark) fclose(fopen(mark, "w"));
        if (v[FAULT] == 1.0) for (;;) pause();
        abort();
    }
    if (!g->spring) {
        v[X] += 0.5 * h * v[V];
        v[V] += h * acceleration(g);
        v[X] += 0.5 * h * v[V];
    }
    *last = t + h;
    return 0;
}
int fmi3GetDirectionalDerivative(void *instance, const uint32_t *unknowns, size_t n, const uint32_t *knowns, size_t m, const double *seed,
                                 size_t seeds, double *out, size_t outs) {
    Guest *g = instance;
    /* With fault 6 it writes nothing, with fault 7 ten times as much, with fault 9 the other way round. */
    double fault = g->value[FAULT], times = fault == 7.0 ? 10.0 : fault == 9.0 ? -1.0 : fault == 8.0 ? 1000.0 : 1.0;
    if (fault == 6.0) return 0;
    for (size_t i = 0; i < n; i++) {
        out[i] = 0.0;
        for (size_t j = 0; j < m; j++)
            if (unknowns[i] == A && knowns[j] == F) out[i] += times * seed[j] / g->value[MASS];
    }
    return 0;
}
int fmi3GetFMUState(void *g, void **state) {
    if (!*state) *state = malloc(sizeof(Guest));
    memcpy(*state, g, sizeof(Guest));
    return 0;
}
int fmi3SetFMUState(void *g, void *state) {
    memcpy(g, state, sizeof(Guest));
    return 0;
}
int fmi3FreeFMUState(void *g, void **state) {
    free(*state);
    *state = NULL;
    return 0;
}
