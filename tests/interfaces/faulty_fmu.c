/* A mass (ROLE 0) or a spring (ROLE 1) as an FMU for FMI 2.0 (V 2) or 3.0 (V 3), co-simulation.
   A fault is switched on by -DNAME; make.py lists them. Value references:
   0 x, 1 v, 2 f, 3 parameter m or k, 4 parameter d, 5 x0 (mass) or rest (spring), 6 steps taken, 7 whole number, 8 truth, 9 text (its number is taken for 3). */
#define _GNU_SOURCE
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#ifdef FTZ
#include <xmmintrin.h>
#endif
typedef void *C;
typedef unsigned VR;
typedef double D;
#ifndef H_INT
#define H_INT 1e-5
#endif
/* What it tells and takes by these: a sign, a unit, a size. */
#ifndef X_TIMES
#define X_TIMES 1
#endif
#ifdef STEADY
#define OWN (STEADY)
#elif defined SETTLES
#define OWN (SETTLES)
#endif
#ifndef V_TIMES
#define V_TIMES 1
#endif
#ifndef F_TIMES
#define F_TIMES 1
#endif
typedef struct {
    D x, v, f, p, d, x0, n, t, rest, own;
    D table[3], before[2], held, length;
    int undone;
    int whole, truth, begun, stop, place;
    char home[4096];
    void *env;
    void (*say)();
#if V == 2
    void *cb[5];
#endif
} S;
#if V == 3
typedef _Bool B;
typedef void (*Log3)(void *, int, const char *, const char *);
#else
typedef void (*Log2)(void *, const char *, int, const char *, const char *, ...);
#endif
#ifdef SHARED
static D shared_x, shared_v; /* state in globals, as generated code often has it */
#endif
#ifdef FTZ
__attribute__((constructor)) static void ftz(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
#endif
static int say(S *s, int status, D t, const char *why) {
#if V == 3
    char text[200];
    snprintf(text, sizeof text, "step refused at t = %g: %s", t, why);
    ((Log3)s->say)(s->env, status, "logStatusError", text);
#else
    ((Log2)s->say)(s->env, "guest", status, "logStatusError", "step refused at t = %g: %s", t, why);
#endif
    return status;
}
static int fail(S *s, D t, const char *why) { return say(s, 3, t, why); }
#ifdef UNIQUE_NAME
static char *taken[64]; /* names of the instances that there are, as the standard has them unique */
#endif
static S *named(S *s, const char *name) {
    (void)name;
#ifdef UNIQUE_NAME
    for (int i = 0; i < 64; i++) if (taken[i] && !strcmp(taken[i], name)) { free(s); return 0; }
    for (int i = 0; i < 64; i++) if (!taken[i]) { taken[i] = strdup(name); s->place = i + 1; break; }
#endif
#ifdef NO_INSTANCE
    return 0;
#endif
    return s;
}
static S *make(void) {
    S *s = calloc(1, sizeof *s);
#ifdef CHDIR
    if (chdir("/")) return 0;
#endif
#ifdef AT_HOME
    if (!getcwd(s->home, sizeof s->home)) return 0;
#endif
#ifdef FPE
    feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
#endif
#ifdef LOCALE
    setlocale(LC_ALL, "de_DE.UTF-8");
#endif
#if ROLE == 0
    s->p = 1.0;
    s->x0 = 0.1;
#else
    s->p = 100.0;
#endif
    return s;
}
static int start(S *s, int stop_known) {
    (void)stop_known;
#ifdef NEEDS_STOP
    if (!stop_known) return fail(s, 0, "a stop time is needed to make room for results");
#endif
#if ROLE == 0
    s->x = s->x0; /* known as soon as initialisation begins */
#endif
    return 0;
}
static int begin(S *s) {
    s->begun = 1;
#ifdef SETTLES /* as STEADY, and it is there when initialisation ends, not before */
    s->x = s->x0 + s->f / (SETTLES);
#endif
#if ROLE == 1
    s->rest = s->x0;
#ifdef REST_AT_START
    s->rest = s->x; /* unstretched where it is when initialisation ends */
#endif
#endif
    return 0;
}
#ifdef NEEDS
extern D stiffness(void);
#endif
static D force_now(S *s) {
#ifdef NEEDS
    s->p = stiffness();
#endif
    return -s->p * (s->x - s->rest) - s->d * s->v;
}
static D force(S *s) {
#ifdef LATCH
    return s->held; /* what it puts out is of its last step */
#else
    return force_now(s);
#endif
}
#ifdef THREADS_EXIT
static void *ends(void *x) { exit(0); }
#endif
static int step(S *s, D t, D h, int for_good) {
    (void)for_good;
#ifdef REPEATS /* as long as one may go back, a step is only tried */
    if (s->undone) s->x = s->before[0], s->v = s->before[1];
    s->before[0] = s->x, s->before[1] = s->v, s->undone = !for_good;
#endif
#ifdef TIME_MS
    h /= 1000; /* its independent variable is in ms */
#endif
#ifdef WANDERS_AT
    if (t > WANDERS_AT && chdir("/")) return 3; /* to where its data are, say */
#endif
#ifdef AT_HOME
    char here[4096];
    if (!getcwd(here, sizeof here) || strcmp(here, s->home)) return fail(s, t, "not the folder that it began in");
#endif
#ifdef EQUAL_STEPS /* its solver was set up for the first */
    if (s->length == 0) s->length = h;
    if (fabs(h / s->length - 1) > 1e-9) return fail(s, t, "a step of another length");
#endif
#ifdef SLOW_US
    usleep(SLOW_US);
#endif
#ifdef PRINT
    printf("step at %g\n", t);
    fflush(stdout);
#endif
#ifdef EXACT_TIME
    if (t != s->t) return fail(s, t, "not the end of the last step");
#endif
#ifdef START
    if (s->n == 0 && t != START) return fail(s, t, "its data begin later");
#endif
#ifdef THREADS_EXIT
    static int once;
    if (t > 0.1 && !once++) { pthread_t p; for (int i = 0; i < THREADS_EXIT; i++) pthread_create(&p, 0, ends, 0); usleep(100000); }
#endif
#ifdef EXIT_ABOVE
    if (t > 0.1 && h > EXIT_ABOVE) exit(0);
#endif
#ifdef EXIT_AT
    if (t > EXIT_AT) exit(0);
#endif
#ifdef SILENT_AT
    if (t > SILENT_AT) return 3;
#endif
#ifdef FAIL_AT
    if (t > FAIL_AT) return fail(s, t, "no solution");
#endif
#ifdef WARNS_AT
    if (t > WARNS_AT) return say(s, 1, t, "not the time that was expected"); /* Warning, and nothing moves */
#endif
#ifdef LONGEST
    if (h > LONGEST * (1 + 1e-9)) return 2; /* Discard: the master is to try a shorter one */
#endif
#ifdef SHARED
    if (s->n > 0) s->x = shared_x, s->v = shared_v;
#endif
#ifdef LAGS
    long n = (long)floor((t + h - s->own) / H_INT + 1e-6); /* as far as whole steps of its own reach */
#elif defined TRUNCATES
    long n = (long)(h / H_INT); /* whole steps of its own; what is left over is lost */
#else
    long n = lround(h / H_INT);
    if (n < 1) n = 1;
#endif
    D dt = n ? h / n : h;
#if defined TRUNCATES || defined LAGS
    dt = H_INT;
    s->own += n * dt;
#endif
    (void)dt;
#if ROLE == 0
    for (long i = 0; i < n; i++) {
#if defined STEADY || defined SETTLES
        s->v += dt * OWN * (s->x0 - s->x) / s->p;
#endif
        s->v += dt * s->f / s->p;
        s->x += dt * s->v;
    }
#endif
    s->t = t + h;
    s->n += 1;
#ifdef LATCH
    s->held = force_now(s);
#endif
#ifdef NAN_BELOW
    if (h < NAN_BELOW) s->v = NAN; /* no solution at short steps, and no word of it */
#endif
#ifdef HUGE_BELOW
    if (h < HUGE_BELOW) s->v = 1e208; /* a number, and no velocity of anything */
#endif
#ifdef NAN_AT
    if (s->t > NAN_AT) s->v = NAN;
#endif
#ifdef INF_AT
    if (s->t > INF_AT) s->x = INFINITY;
#endif
#ifdef SHARED
    shared_x = s->x, shared_v = s->v;
#endif
    return 0;
}
static int get(S *s, const VR *r, size_t n, D *y) {
#ifdef STEADY
    if (!s->begun) s->x = s->x0 + s->f / (STEADY); /* at rest, where a spring of its own carries the force */
#endif
    for (size_t i = 0; i < n; i++) switch (r[i]) {
#ifdef WRAPS
        case 0: y[i] = remainder(s->x, WRAPS); break; /* an angle from -pi to pi, or an encoder */
#else
        case 0: y[i] = s->x * X_TIMES; break;
#endif
        case 1: y[i] = s->v * V_TIMES; break;
#if ROLE == 0
        case 2: y[i] = s->f; break;
#else
        case 2: y[i] = force(s) * F_TIMES; break;
#endif
        case 3: y[i] = s->p; break;
        case 4: y[i] = s->d; break;
        case 5: y[i] = s->x0; break;
        case 6: y[i] = s->n; break;
        case 10: y[i] = s->x * 1000; break;
        case 11: y[i] = s->v * 1000; break;
        case 12: memcpy(y, s->table, sizeof s->table); break; /* an array, asked for alone */
        default: return 3;
        }
    return 0;
}
static int set(S *s, const VR *r, size_t n, const D *y) {
    for (size_t i = 0; i < n; i++) switch (r[i]) {
        case 0: s->x = y[i]; break;
        case 1: s->v = y[i]; break;
        case 2: s->f = y[i] * F_TIMES; break;
        case 3: s->p = y[i]; break;
        case 4: s->d = y[i]; break;
        case 5: s->x0 = y[i]; break;
        case 12: memcpy(s->table, y, sizeof s->table); break;
        default: return 3;
        }
    return 0;
}
static int keep(S *s, void **k) {
#ifdef SHALLOW
    *k = s; /* the instance itself */
#else
    if (!*k) *k = malloc(sizeof *s);
    memcpy(*k, s, sizeof *s);
#endif
    return 0;
}
static int put_back(S *s, void *k) {
#ifdef SHALLOW
    (void)s, (void)k;
#else
#ifdef FORGETS_V
    D v = s->v;
#endif
    memcpy(s, k, sizeof *s);
#ifdef FORGETS_V
    s->v = v; /* one state is not among what is kept */
#endif
#endif
    return 0;
}
static int drop(void **k) {
#ifndef SHALLOW
    free(*k);
#endif
    *k = 0;
    return 0;
}
#if V == 2
#define P(name) fmi2##name
C P(Instantiate)(const char *n, int k, const char *g, const char *r, void **cb, int a, int b) {
    (void)k, (void)g, (void)r, (void)a, (void)b;
    S *s = named(make(), n);
    if (!s) return 0;
    s->say = (void (*)())cb[0], s->env = cb[4];
    return s;
}
int P(SetupExperiment)(C s, int a, D b, D c, int stop, D e) { (void)a, (void)b, (void)c, (void)e; ((S *)s)->stop = stop; return 0; }
int P(EnterInitializationMode)(C s) { return start(s, ((S *)s)->stop); }
int P(GetReal)(C s, const VR *r, size_t n, D *y) { return get(s, r, n, y); }
int P(SetReal)(C s, const VR *r, size_t n, const D *y) { return set(s, r, n, y); }
int P(SetInteger)(C s, const VR *r, size_t n, const int *y) { (void)r; if (n) ((S *)s)->whole = y[0]; return 0; }
int P(SetBoolean)(C s, const VR *r, size_t n, const int *y) { (void)r; if (n) ((S *)s)->truth = y[0]; return 0; }
int P(SetString)(C s, const VR *r, size_t n, const char *const *y) { (void)r; if (n) ((S *)s)->p = atof(y[0]); return 0; }
int P(DoStep)(C s, D t, D h, int q) { return step(s, t, h, q); }
int P(GetFMUstate)(C s, void **k) { return keep(s, k); }
int P(SetFMUstate)(C s, void *k) { return put_back(s, k); }
int P(FreeFMUstate)(C s, void **k) { (void)s; return drop(k); }
#else
#define P(name) fmi3##name
C P(InstantiateCoSimulation)(const char *n, const char *g, const char *r, B a, B b, B c, B d, const VR *e, size_t f, void *env, Log3 log, void *i) {
    (void)g, (void)r, (void)a, (void)b, (void)c, (void)d, (void)e, (void)f, (void)i;
    S *s = named(make(), n);
    if (!s) return 0;
    s->say = (void (*)())log, s->env = env;
    return s;
}
int P(EnterInitializationMode)(C s, B a, D b, D c, B stop, D e) { (void)a, (void)b, (void)c, (void)e; return start(s, stop); }
int P(GetFloat64)(C s, const VR *r, size_t n, D *y, size_t m) { (void)m; return get(s, r, n, y); }
int P(SetFloat64)(C s, const VR *r, size_t n, const D *y, size_t m) { (void)m; return set(s, r, n, y); }
int P(SetInt32)(C s, const VR *r, size_t n, const int *y, size_t m) { (void)r, (void)m; if (n) ((S *)s)->whole = y[0]; return 0; }
int P(SetInt64)(C s, const VR *r, size_t n, const long *y, size_t m) { (void)r, (void)m; if (n) ((S *)s)->whole = (int)y[0]; return 0; }
int P(GetInt64)(C s, const VR *r, size_t n, long *y, size_t m) { (void)r, (void)n, (void)m; y[0] = ((S *)s)->whole; return 0; }
int P(SetString)(C s, const VR *r, size_t n, const char *const *y, size_t m) { (void)r, (void)m; if (n) ((S *)s)->p = atof(y[0]); return 0; }
int P(GetFloat32)(C s, const VR *r, size_t n, float *y, size_t m) { (void)m; D z; int status = get(s, r, n, &z); y[0] = z; return status; }
int P(SetFloat32)(C s, const VR *r, size_t n, const float *y, size_t m) { (void)m; D z = y[0]; return set(s, r, n, &z); }
int P(DoStep)(C s, D t, D h, B q, B *ev, B *term, B *early, D *last) {
    *ev = *early = 0;
    *term = 0;
    int status = step(s, t, h, q);
    *last = t + h;
#ifdef LAGS
    *last = ((S *)s)->own; /* and it says so, as FMI 3.0 has it */
#endif
#ifdef ENDS_AT
    if (*last > ENDS_AT) *term = 1;
#endif
    return status;
}
int P(GetFMUState)(C s, void **k) { return keep(s, k); }
int P(SetFMUState)(C s, void *k) { return put_back(s, k); }
int P(FreeFMUState)(C s, void **k) { (void)s; return drop(k); }
#endif
int P(ExitInitializationMode)(C s) { return begin(s); }
int P(Terminate)(C s) { (void)s; return 0; }
void P(FreeInstance)(C s) {
#ifdef UNIQUE_NAME
    if (((S *)s)->place) free(taken[((S *)s)->place - 1]), taken[((S *)s)->place - 1] = 0;
#endif
    free(s);
}
/* What a master may ask for although it is of no use here. */
#define STUB(name) int P(name)(void) { return 3; }
#if V == 2
const char *P(GetTypesPlatform)(void) { return "default"; }
const char *P(GetVersion)(void) { return "2.0"; }
STUB(GetInteger) STUB(GetBoolean) STUB(GetString) STUB(SerializedFMUstateSize) STUB(SerializeFMUstate)
STUB(DeSerializeFMUstate) STUB(GetDirectionalDerivative) STUB(SetRealInputDerivatives)
STUB(GetRealOutputDerivatives) STUB(CancelStep) STUB(GetStatus) STUB(GetRealStatus) STUB(GetIntegerStatus)
STUB(GetBooleanStatus) STUB(GetStringStatus)
#else
const char *P(GetVersion)(void) { return "3.0"; }
STUB(ActivateModelPartition) STUB(CompletedIntegratorStep) STUB(DeserializeFMUState)
STUB(EnterConfigurationMode) STUB(EnterContinuousTimeMode) STUB(EnterEventMode) STUB(EnterStepMode)
STUB(EvaluateDiscreteStates) STUB(ExitConfigurationMode) STUB(GetAdjointDerivative) STUB(GetBinary)
STUB(GetBoolean) STUB(GetClock) STUB(GetContinuousStateDerivatives) STUB(GetContinuousStates)
STUB(GetDirectionalDerivative) STUB(GetEventIndicators) STUB(GetInt16) STUB(GetInt32)
STUB(GetInt8) STUB(GetIntervalDecimal) STUB(GetIntervalFraction)
STUB(GetNominalsOfContinuousStates) STUB(GetNumberOfContinuousStates) STUB(GetNumberOfEventIndicators)
STUB(GetNumberOfVariableDependencies) STUB(GetOutputDerivatives) STUB(GetShiftDecimal) STUB(GetShiftFraction)
STUB(GetString) STUB(GetUInt16) STUB(GetUInt32) STUB(GetUInt64) STUB(GetUInt8) STUB(GetVariableDependencies)
STUB(InstantiateModelExchange) STUB(InstantiateScheduledExecution) STUB(SerializeFMUState)
STUB(SerializedFMUStateSize) STUB(SetBinary) STUB(SetBoolean) STUB(SetClock) STUB(SetContinuousStates)
STUB(SetInt16) STUB(SetInt8) STUB(SetIntervalDecimal) STUB(SetIntervalFraction) STUB(SetShiftDecimal)
STUB(SetShiftFraction) STUB(SetTime) STUB(SetUInt16) STUB(SetUInt32) STUB(SetUInt64) STUB(SetUInt8)
STUB(UpdateDiscreteStates)
#endif
int P(SetDebugLogging)(void) { return 0; }
int P(Reset)(void) { return 0; }
