/* Propagation of a plan: interpreted.py, interval by interval, in C.

   Before this file stand the functions of an interval and of the end (interval.py) as CasADi's
   generated C, and their sizes: NX states, NU wheels, NE conditions, CasADi's work space WORK,
   IWORK, ARGS. All memory is the caller's or on the stack: plans may be propagated on several
   threads at once. */

enum { NZ = NX + NU };

typedef int (*PlanFunction)(const double **, double **, casadi_int *, double *, int);

static void plan_call(PlanFunction f, const double *const in[5], double *first, double *second) {
    const double *arg[ARGS + 5] = {in[0], in[1], in[2], in[3], in[4]};
    double *res[ARGS + 2] = {first, second}, w[WORK + 1];
    casadi_int iw[IWORK + 1];
    f(arg, res, iw, w, 0);
}

/* x holds K + 1 states, the first of which is given; u K torques, h the intervals' lengths. */
void plan_propagate(int K, double (*x)[NX], const double (*u)[NU], const double *h,
                    const double *known, const double *numbers, const double *goal, double *end) {
    for (int k = 0; k < K; k++)
        plan_call(plan_step, (const double *const[5]){x[k], u[k], &h[k], known, numbers}, x[k + 1], 0);
    plan_call(plan_end, (const double *const[5]){x[K], goal, known, numbers}, end, 0);
}

/* Also the slope of the end by all torques; F is work space for K matrices. CasADi stores matrices
   by columns: F[k][j] is the derivative of the next state by component j of (x, u). */
void plan_linearize(int K, double (*x)[NX], const double (*u)[NU], const double *h,
                    const double *known, const double *numbers, const double *goal, double *end,
                    double *slope, double (*F)[NZ][NX]) {
    double along[NX][NE], before[NX][NE];
    for (int k = 0; k < K; k++)
        plan_call(plan_step_slope, (const double *const[5]){x[k], u[k], &h[k], known, numbers},
                  x[k + 1], F[k][0]);
    plan_call(plan_end_slope, (const double *const[5]){x[K], goal, known, numbers}, end, along[0]);
    for (int k = K - 1; k >= 0; k--) {
        for (int j = 0; j < NZ; j++) {
            double by[NE] = {0.0};
            for (int i = 0; i < NX; i++)
                for (int e = 0; e < NE; e++) by[e] += along[i][e] * F[k][j][i];
            for (int e = 0; e < NE; e++) {
                if (j < NX) before[j][e] = by[e];
                else slope[(e * K + k) * NU + j - NX] = by[e];
            }
        }
        memcpy(along, before, sizeof along);
    }
}
