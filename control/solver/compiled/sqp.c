/* Sequential quadratic programming on roll-outs: interpreted.py, step for step, in C.

   Before this file stand the stage functions (evaluate, linearize, curvature and their _end) as
   CasADi's generated C, the problem's sizes (N, NX, NU, NP, NC coefficients, NR residuals a stage,
   NE at the end, M rows, CasADi's work space WORK, IWORK, ARGS), riccati.h, active_set.h and
   interior_point.h. */

static const double PRESSURE = 20.0, ON_BOUND = 1e-9;
static const int FULL_STEPS = 8, HALVINGS = 6;

enum { SOLVED, ITERATION_LIMIT, FAILED };

typedef struct {
    double u[N][NU], x[N + 1][NX], cost;
    Row z;
    int place[N + 1][M];
} Iterate;

typedef struct {
    Qp qp;
    Iterate now, before, best;
    double upper[M + 1], lower[M + 1];
    double rr[N + 1][NZ];              /* R'r: the residuals' pull on state and input */
    double gauss_newton[N + 1][NZ][NZ];
    double p[N + 1][NP + 1];
    double c[NC + 1];                  /* the stage functions' coefficients */
    double w[WORK + 1];
    casadi_int iw[IWORK + 1];
} Solver;

typedef struct {
    double cost, stationarity, feasibility, complementarity;
    int iterations, factorizations, status;
} Report;

typedef int (*Function)(const double **, double **, casadi_int *, double *, int);

static void call(Solver *s, Function f, const double *in[5], double *out[3]) {
    const double *arg[ARGS + 5] = {in[0], in[1], in[2], in[3], in[4]};
    double *res[ARGS + 4] = {out[0], out[1], out[2]};
    f(arg, res, s->iw, s->w, 0);
}

static double value_of(const Solver *s, const Iterate *at, int k, int j) {
    double sum = 0.0;
    for (int i = 0; i < NX; i++) sum += s->qp.C[j][i] * at->x[k][i];
    if (k < N)
        for (int i = 0; i < NU; i++) sum += s->qp.C[j][NX + i] * at->u[k][i];
    return sum;
}

static double violation(const Solver *s, const Iterate *at, int k, int j) {
    double value = value_of(s, at, k, j);
    return fmax(fmax(value - s->upper[j], s->lower[j] - value), 0.0);
}

static void roll_out(Solver *s, Iterate *at) {
    const Qp *qp = &s->qp;
    double r[NR + NE], cost = 0.0;
    for (int k = 0; k < N; k++) {
        call(s, evaluate, (const double *[]){at->x[k], at->u[k], s->p[k], s->c, 0},
             (double *[]){at->x[k + 1], r, 0});
        for (int i = 0; i < NR; i++) cost += 0.5 * r[i] * r[i];
    }
    call(s, evaluate_end, (const double *[]){at->x[N], s->p[N], s->c, 0, 0},
         (double *[]){r, 0, 0});
    for (int i = 0; i < NE; i++) cost += 0.5 * r[i] * r[i];
    EACH_ROW(k, j)
        if (qp->softness[j] > 0.0) {
            double v = violation(s, at, k, j);
            cost += qp->softness[j] * (v + 0.5 * v * v);
        }
    at->cost = cost;
}

/* R'r and the Gauss-Newton Hessian R'R of a stage, R stored by columns. */
static void square(int rows, int columns, const double *R, const double *r, double *pull,
                   double H[NZ][NZ]) {
    double by_row[columns];
    memset(H, 0, sizeof(double[NZ][NZ]));
    memset(pull, 0, sizeof(double[NZ]));
    for (int a = 0; a < rows; a++) {
        for (int i = 0; i < columns; i++) by_row[i] = R[i * rows + a];
        for (int i = 0; i < columns; i++) {
            pull[i] += r[a] * by_row[i];
            if (by_row[i] == 0.0) continue;
            for (int l = 0; l < columns; l++) H[i][l] += by_row[i] * by_row[l];
        }
    }
}

static void linearize_all(Solver *s, const Iterate *at) {
    double F[NZ * NX], r[NR + NE], R[(NR + NE) * NZ];
    for (int k = 0; k < N; k++) {
        call(s, linearize, (const double *[]){at->x[k], at->u[k], s->p[k], s->c, 0},
             (double *[]){F, r, R});
        for (int i = 0; i < NX; i++)
            for (int l = 0; l < NZ; l++) s->qp.F[k][i][l] = F[l * NX + i];
        square(NR, NZ, R, r, s->rr[k], s->gauss_newton[k]);
    }
    call(s, linearize_end, (const double *[]){at->x[N], s->p[N], s->c, 0, 0},
         (double *[]){r, R, 0});
    square(NE, NX, R, r, s->rr[N], s->gauss_newton[N]);
}

/* Derivative of the Lagrangian by every state through all that follows. */
static void costate(const Solver *s, const Iterate *at, double adjoint[N + 1][NX]) {
    const Qp *qp = &s->qp;
    for (int k = N; k >= 1; k--) {
        memcpy(adjoint[k], s->rr[k], sizeof adjoint[k]);
        for (int j = 0; j < M; j++)
            if (qp->on[k][j])
                for (int i = 0; i < NX; i++) adjoint[k][i] += at->z[k][j] * qp->C[j][i];
        if (k < N)
            for (int l = 0; l < NX; l++)
                for (int i = 0; i < NX; i++) adjoint[k][i] += qp->F[k][l][i] * adjoint[k + 1][l];
    }
}

static void add_damping(Qp *qp, double damping) {
    for (int k = 0; k < N; k++)
        for (int a = NX; a < NZ; a++) qp->W[k][a][a] += damping;
}

/* Hessian of the Lagrangian and the curvature along pressed rows. */
static void exact_hessian(Solver *s, const Iterate *at) {
    Qp *qp = &s->qp;
    double adjoint[N + 1][NX], end[NX * NX];
    costate(s, at, adjoint);
    for (int k = 0; k < N; k++)
        call(s, curvature, (const double *[]){at->x[k], at->u[k], s->p[k], s->c, adjoint[k + 1]},
             (double *[]){&qp->W[k][0][0], 0, 0});
    call(s, curvature_end, (const double *[]){at->x[N], s->p[N], s->c, 0, 0},
         (double *[]){end, 0, 0});
    memset(qp->W[N], 0, sizeof qp->W[N]);
    for (int i = 0; i < NX; i++) memcpy(qp->W[N][i], end + i * NX, NX * sizeof(double));
    EACH_ROW(k, j)
        if (abs(at->place[k][j]) == AT_BOUND)
            add_outer(qp->W[k], PRESSURE * fabs(at->z[k][j]), qp->C[j]);
}

/* The quadratic program at an iterate, solved. */
static void solve_step(Solver *s, const Iterate *at, int exact, double damping) {
    Qp *qp = &s->qp;
    linearize_all(s, at);
    memcpy(qp->q, s->rr, sizeof qp->q);
    if (exact) {
        exact_hessian(s, at);
        add_damping(qp, damping);
        exact = factor(qp, NULL);
    }
    if (!exact) {
        memcpy(qp->W, s->gauss_newton, sizeof qp->W);
        add_damping(qp, damping);
        factor(qp, NULL);
    }
    EACH_ROW(k, j) {
        double value = value_of(s, at, k, j);
        qp->lower[k][j] = s->lower[j] - value;
        qp->upper[k][j] = s->upper[j] - value;
    }
    memcpy(qp->answer.place, at->place, sizeof at->place);
    solve_qp(qp);
}

static void take_step(Solver *s, const Iterate *from, Iterate *to, int careful) {
    double length = 1.0;
    for (int halving = 0; halving <= HALVINGS; halving++, length *= 0.5) {
        for (int k = 0; k < N; k++)
            for (int a = 0; a < NU; a++)
                to->u[k][a] = from->u[k][a] + length * s->qp.answer.v[k][NX + a];
        roll_out(s, to);
        if (!careful || to->cost <= from->cost) break;
    }
    memcpy(to->z, s->qp.answer.z, sizeof to->z);
    memcpy(to->place, s->qp.answer.place, sizeof to->place);
}

static void judge(Solver *s, const Iterate *at, Report *report) {
    const Qp *qp = &s->qp;
    double adjoint[N + 1][NX];
    linearize_all(s, at);
    costate(s, at, adjoint);
    report->stationarity = report->feasibility = report->complementarity = 0.0;
    for (int k = 0; k < N; k++)
        for (int a = NX; a < NZ; a++) {
            double sum = s->rr[k][a];
            for (int l = 0; l < NX; l++) sum += qp->F[k][l][a] * adjoint[k + 1][l];
            for (int j = 0; j < M; j++)
                if (qp->on[k][j]) sum += at->z[k][j] * qp->C[j][a];
            report->stationarity = fmax(report->stationarity, fabs(sum));
        }
    EACH_ROW(k, j) {
        double bound = at->place[k][j] > 0 ? s->upper[j] : s->lower[j];
        double slack = abs(at->place[k][j]) == AT_BOUND ? fabs(bound - value_of(s, at, k, j)) : 0.0;
        report->complementarity = fmax(report->complementarity, fabs(at->z[k][j]) * slack);
        if (qp->softness[j] == 0.0)
            report->feasibility = fmax(report->feasibility, violation(s, at, k, j));
    }
    report->cost = at->cost;
}

static void first(Solver *s, Iterate *at) {
    const Qp *qp = &s->qp;
    roll_out(s, at);
    memset(at->z, 0, sizeof at->z);
    EACH_ROW(k, j) {
        double value = value_of(s, at, k, j);
        at->place[k][j] = (value > s->upper[j] - ON_BOUND) - (value < s->lower[j] + ON_BOUND);
    }
}

/* ---- what Python calls ------------------------------------------------------------------ */

size_t solver_size(void) { return sizeof(Solver); }

/* What one problem has for itself. Limits: C (M x NZ) by rows; softness 0 for hard rows; on_input 1
   for rows with an input. c: coefficients. */
void solver_problem(Solver *s, const double *C, const double *lower, const double *upper,
                    const double *softness, const int *on_input, const double *c) {
    memset(s, 0, sizeof *s);
    memcpy(s->c, c, NC * sizeof(double));
    for (int j = 0; j < M; j++) {
        memcpy(s->qp.C[j], C + j * NZ, sizeof s->qp.C[j]);
        s->lower[j] = lower[j];
        s->upper[j] = upper[j];
        s->qp.softness[j] = softness[j];
        for (int k = 0; k <= N; k++) s->qp.on[k][j] = on_input[j] ? k < N : k > 0;
    }
}

static void load(Solver *s, const double *x0, const double *u, const double *p) {
    memcpy(s->now.x[0], x0, sizeof s->now.x[0]);
    memcpy(s->before.x[0], x0, sizeof s->before.x[0]);
    memcpy(s->now.u, u, sizeof s->now.u);
    for (int k = 0; k <= N; k++) memcpy(s->p[k], p + k * NP, NP * sizeof(double));
}

double solver_roll_out(Solver *s, const double *x0, const double *u, const double *p, double *x) {
    load(s, x0, u, p);
    roll_out(s, &s->now);
    memcpy(x, s->now.x, sizeof s->now.x);
    return s->now.cost;
}

/* u: the guess on entry, the solution on return. */
void solver_solve(Solver *s, const double *x0, double *u, const double *p, double *x,
                  int max_iterations, double tolerance, double damping, Report *report) {
    load(s, x0, u, p);
    first(s, &s->now);
    s->best = s->now;
    s->qp.factorizations = report->iterations = 0;
    report->status = ITERATION_LIMIT;
    while (report->iterations < max_iterations && isfinite(s->now.cost)) {
        if (report->iterations == FULL_STEPS) s->now = s->best;
        solve_step(s, &s->now, report->iterations > 0, damping);
        s->before = s->now;
        take_step(s, &s->before, &s->now, report->iterations >= FULL_STEPS);
        if (report->iterations == 0 || s->now.cost <= (1.0 + tolerance) * s->best.cost)
            s->best = s->now;  /* of equals the last: its multipliers are the truest */
        report->iterations++;
        if (fabs(s->before.cost - s->now.cost) <= tolerance * s->now.cost) {
            report->status = SOLVED;
            break;
        }
    }
    if (!isfinite(s->best.cost)) report->status = FAILED;
    judge(s, &s->best, report);
    report->factorizations = s->qp.factorizations;
    memcpy(u, s->best.u, sizeof s->best.u);
    memcpy(x, s->best.x, sizeof s->best.x);
}
