/* The quadratic program of one step, stage by stage:

     minimise    sum_k 1/2 z_k' W_k z_k + q_k' z_k  (+ soft rows: w s + w s^2 / 2),  z_k = (dx_k, du_k)
     subject to  dx_0 = 0,  dx_{k+1} = F_k z_k,  lower_k - s <= C z_k <= upper_k + s

   The same two methods as active_set.py and interior_point.py, step for step; where those factor a
   dense condensed Hessian, a Riccati recursion here costs N (nx + nu)^3 and no condensing.
   N, NX, NU, M (rows a stage) are defined by the code generated for a problem. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NZ (NX + NU)
#define EACH_ROW(k, j) for (int k = 0; k <= N; k++) for (int j = 0; j < M; j++) if (qp->on[k][j])
#define EACH_SIDE(s, k, j) for (int s = 0; s < 2; s++) EACH_ROW(k, j)

enum { INSIDE, AT_BOUND, BEYOND };  /* where a row ends; positive above, negative below */

static const double STIFFNESS = 1e7, BROKEN = 1e-10;           /* of active_set.py */
static const int PASSES = 3, MAX_ROUNDS = 6;
static const double START_SLACK = 0.1, TO_BOUNDARY = 0.995;    /* of interior_point.py */
static const double GAP = 1e-9, ROW_ERROR = 1e-9;
static const int MAX_STEPS = 50;

typedef double Row[N + 1][M];
typedef double Side[2][N + 1][M];
typedef double Trajectory[N + 1][NZ];  /* the last input does not exist and stays zero */

typedef struct {
    Row z;
    Trajectory v;
    int place[N + 1][M];
} Answer;

typedef struct {
    double F[N][NX][NZ], W[N + 1][NZ][NZ];
    Trajectory q;
    double C[M + 1][NZ], softness[M + 1];  /* softness 0: a hard row */
    int on[N + 1][M];
    Row lower, upper;
    double K[N][NU][NX], L[N][NU][NU];  /* the factor: feedback, and Cholesky of the input block */
    double largest;                     /* curvature by an input, in the last factor without rows */
    int factorizations;
    Answer answer;
} Qp;

typedef struct {
    Side t, z, s, nu;
    Trajectory v;
} Point;

static double row_of(const Qp *qp, Trajectory v, int k, int j) {
    double sum = 0.0;
    for (int i = 0; i < NZ; i++) sum += qp->C[j][i] * v[k][i];
    return sum;
}

static void add_outer(double H[NZ][NZ], double weight, const double *c) {
    for (int i = 0; i < NZ; i++)
        for (int l = 0; l < NZ; l++) H[i][l] += weight * c[i] * c[l];
}

/* Cholesky of the input block of H, its feedback K, and the cost-to-go P; 0 if not convex. */
static int eliminate_input(double H[NZ][NZ], double K[NU][NX], double L[NU][NU], double P[NX][NX]) {
    double Y[NU][NX];
    for (int a = 0; a < NU; a++) {
        for (int b = 0; b <= a; b++) {
            double sum = H[NX + a][NX + b];
            for (int c = 0; c < b; c++) sum -= L[a][c] * L[b][c];
            if (a == b && !(sum > 0.0)) return 0;
            L[a][b] = a == b ? sqrt(sum) : sum / L[b][b];
        }
        for (int i = 0; i < NX; i++) Y[a][i] = H[NX + a][i];
        for (int b = 0; b < a; b++)
            for (int i = 0; i < NX; i++) Y[a][i] -= L[a][b] * Y[b][i];
        for (int i = 0; i < NX; i++) Y[a][i] /= L[a][a];
    }
    for (int i = 0; i < NX; i++)
        for (int l = 0; l < NX; l++) {
            P[i][l] = H[i][l];
            for (int a = 0; a < NU; a++) P[i][l] -= Y[a][i] * Y[a][l];
        }
    for (int a = NU - 1; a >= 0; a--) {
        for (int i = 0; i < NX; i++) K[a][i] = -Y[a][i];
        for (int b = a + 1; b < NU; b++)
            for (int i = 0; i < NX; i++) K[a][i] -= L[b][a] * K[b][i];
        for (int i = 0; i < NX; i++) K[a][i] /= L[a][a];
    }
    return 1;
}

/* Riccati recursion with the rows' weights added (NULL: none); 0 if the program isn't convex. */
static int factor(Qp *qp, Row weight) {
    double P[NX][NX], PF[NX][NZ], H[NZ][NZ];
    if (weight)
        qp->factorizations++;
    else
        qp->largest = 0.0;
    for (int k = N; k >= 0; k--) {
        memcpy(H, qp->W[k], sizeof H);
        if (weight)
            for (int j = 0; j < M; j++)
                if (qp->on[k][j] && weight[k][j] != 0.0) add_outer(H, weight[k][j], qp->C[j]);
        if (k == N) {
            for (int i = 0; i < NX; i++) memcpy(P[i], H[i], sizeof P[i]);
            continue;
        }
        memset(PF, 0, sizeof PF);
        for (int i = 0; i < NX; i++)
            for (int l = 0; l < NX; l++)
                for (int c = 0; c < NZ; c++) PF[i][c] += P[i][l] * qp->F[k][l][c];
        for (int l = 0; l < NX; l++)
            for (int i = 0; i < NZ; i++)
                for (int c = 0; c < NZ; c++) H[i][c] += qp->F[k][l][i] * PF[l][c];
        if (!weight)
            for (int a = NX; a < NZ; a++) qp->largest = fmax(qp->largest, H[a][a]);
        if (!eliminate_input(H, qp->K[k], qp->L[k], P)) return 0;
    }
    return 1;
}

/* The step that minimises the factored program with gradient g. */
static void newton(const Qp *qp, Trajectory g, Trajectory step) {
    double p[NX], d[N][NU];
    memcpy(p, g[N], sizeof p);
    for (int k = N - 1; k >= 0; k--) {
        double h[NZ];
        memcpy(h, g[k], sizeof h);
        for (int l = 0; l < NX; l++)
            for (int i = 0; i < NZ; i++) h[i] += qp->F[k][l][i] * p[l];
        for (int i = 0; i < NX; i++) {
            p[i] = h[i];
            for (int a = 0; a < NU; a++) p[i] += qp->K[k][a][i] * h[NX + a];
        }
        for (int a = 0; a < NU; a++) {
            d[k][a] = -h[NX + a];
            for (int b = 0; b < a; b++) d[k][a] -= qp->L[k][a][b] * d[k][b];
            d[k][a] /= qp->L[k][a][a];
        }
        for (int a = NU - 1; a >= 0; a--) {
            for (int b = a + 1; b < NU; b++) d[k][a] -= qp->L[k][b][a] * d[k][b];
            d[k][a] /= qp->L[k][a][a];
        }
    }
    memset(step, 0, sizeof(Trajectory));
    for (int k = 0; k < N; k++) {
        for (int a = 0; a < NU; a++) {
            step[k][NX + a] = d[k][a];
            for (int i = 0; i < NX; i++) step[k][NX + a] += qp->K[k][a][i] * step[k][i];
        }
        for (int i = 0; i < NX; i++)
            for (int l = 0; l < NZ; l++) step[k + 1][i] += qp->F[k][i][l] * step[k][l];
    }
}

/* Gradient of the Lagrangian at v, with the rows' multipliers. */
static void gradient(const Qp *qp, Trajectory v, Row multiplier, Trajectory g) {
    memcpy(g, qp->q, sizeof(Trajectory));
    for (int k = 0; k <= N; k++)
        for (int l = 0; l < NZ; l++)
            for (int i = 0; i < NZ; i++) g[k][i] += qp->W[k][l][i] * v[k][l];
    EACH_ROW(k, j)
        if (multiplier[k][j] != 0.0)
            for (int i = 0; i < NZ; i++) g[k][i] += multiplier[k][j] * qp->C[j][i];
}

/* ---- active set ------------------------------------------------------------------------- */

static int solve_supposing(Qp *qp, Answer *at) {
    Row weight, push;
    Trajectory g, step;
    EACH_ROW(k, j) {
        int where = at->place[k][j];
        weight[k][j] = where == INSIDE        ? 0.0
                       : abs(where) == BEYOND ? qp->softness[j]
                                              : STIFFNESS * qp->largest;
        at->z[k][j] = push[k][j] = 0.0;
    }
    if (!factor(qp, weight)) return 0;
    for (int pass = 0; pass < PASSES; pass++) {
        EACH_ROW(k, j) {
            int where = at->place[k][j], side = where > 0 ? 1 : -1;
            if (where == INSIDE) continue;
            double bound = side > 0 ? qp->upper[k][j] : qp->lower[k][j];
            push[k][j] = abs(where) == BEYOND ? side * weight[k][j] : at->z[k][j];
            push[k][j] += weight[k][j] * (row_of(qp, at->v, k, j) - bound);
        }
        gradient(qp, at->v, push, g);
        newton(qp, g, step);
        for (int k = 0; k <= N; k++)
            for (int i = 0; i < NZ; i++) at->v[k][i] += step[k][i];
        EACH_ROW(k, j)
            at->z[k][j] = push[k][j] + weight[k][j] * row_of(qp, step, k, j);
    }
    return 1;
}

static int corrected(const Qp *qp, const Answer *at, int k, int j, double row) {
    int where = at->place[k][j], side = where > 0 ? 1 : -1;
    int outside = (row > qp->upper[k][j] + BROKEN) - (row < qp->lower[k][j] - BROKEN);
    double pull = at->z[k][j] * side;
    if (where == INSIDE) return outside;
    if (abs(where) == BEYOND) return side * (outside == side ? BEYOND : AT_BOUND);
    if (pull < 0.0) return INSIDE;
    return side * (qp->softness[j] > 0.0 && pull > qp->softness[j] ? BEYOND : AT_BOUND);
}

/* Starts from the answer's places; 0 if the suppositions go round. */
static int active_set(Qp *qp) {
    Answer *at = &qp->answer;
    memset(at->v, 0, sizeof at->v);
    for (int round = 0; round < MAX_ROUNDS; round++) {
        int changes = 0;
        if (!solve_supposing(qp, at)) return 0;
        EACH_ROW(k, j) {
            int where = corrected(qp, at, k, j, row_of(qp, at->v, k, j));
            changes += where != at->place[k][j];
            at->place[k][j] = where;
        }
        if (!changes) return 1;
    }
    return 0;
}

/* ---- interior point --------------------------------------------------------------------- */

static double give(const Qp *qp, const Point *at, int s, int k, int j) {
    double w = qp->softness[j];
    return w > 0.0 ? 1.0 / (at->nu[s][k][j] + w * at->s[s][k][j]) : 0.0;
}

static double row_error(const Qp *qp, Point *at, int s, int k, int j) {
    double row = row_of(qp, at->v, k, j);
    double distance = s == 0 ? qp->upper[k][j] - row : row - qp->lower[k][j];
    return distance + at->s[s][k][j] - at->t[s][k][j];
}

/* The step towards t z = aim - dt dz and s nu = aim - ds dnu of the previous step (NULL: none). */
static void interior_step(Qp *qp, Point *at, Side weight, double aim, const Point *previous,
                          Point *step) {
    Row push;
    Side rest, soft_rest;
    Trajectory g;
    memset(push, 0, sizeof push);
    EACH_SIDE(s, k, j) {
        double cross = 0.0, soft_cross = 0.0;
        if (previous) {
            cross = previous->t[s][k][j] * previous->z[s][k][j];
            soft_cross = previous->s[s][k][j] * previous->nu[s][k][j];
        }
        step->t[s][k][j] = aim - cross;
        soft_rest[s][k][j] = give(qp, at, s, k, j) *
                             (aim - soft_cross - at->s[s][k][j] * at->nu[s][k][j]);
        rest[s][k][j] = row_error(qp, at, s, k, j) + at->t[s][k][j] -
                        (aim - cross) / at->z[s][k][j] + soft_rest[s][k][j];
        push[k][j] += (s == 0 ? 1.0 : -1.0) *
                      (at->z[s][k][j] - weight[s][k][j] * rest[s][k][j]);
    }
    gradient(qp, at->v, push, g);
    newton(qp, g, step->v);
    EACH_SIDE(s, k, j) {
        double row = (s == 0 ? 1.0 : -1.0) * row_of(qp, step->v, k, j);
        double z = weight[s][k][j] * (row - rest[s][k][j]);
        double soft = soft_rest[s][k][j] + give(qp, at, s, k, j) * at->s[s][k][j] * z;
        step->z[s][k][j] = z;
        step->t[s][k][j] = (step->t[s][k][j] - at->t[s][k][j] * z) / at->z[s][k][j] -
                           at->t[s][k][j];
        step->s[s][k][j] = soft;
        step->nu[s][k][j] = qp->softness[j] > 0.0 ? qp->softness[j] * soft - z : 0.0;
    }
}

/* Mean complementarity after a length of a step. */
static double gap(const Qp *qp, const Point *at, const Point *step, double length) {
    double sum = 0.0;
    int products = 0;
    EACH_SIDE(s, k, j) {
        sum += (at->t[s][k][j] + length * step->t[s][k][j]) *
               (at->z[s][k][j] + length * step->z[s][k][j]);
        sum += (at->s[s][k][j] + length * step->s[s][k][j]) *
               (at->nu[s][k][j] + length * step->nu[s][k][j]);
        products += 1 + (qp->softness[j] > 0.0);
    }
    return sum / products;
}

static double to_boundary(const Qp *qp, const Point *at, const Point *step) {
    double worst = TO_BOUNDARY;
    EACH_SIDE(s, k, j) {
        worst = fmax(worst, -step->t[s][k][j] / at->t[s][k][j]);
        worst = fmax(worst, -step->z[s][k][j] / at->z[s][k][j]);
        if (qp->softness[j] > 0.0) {
            worst = fmax(worst, -step->s[s][k][j] / at->s[s][k][j]);
            worst = fmax(worst, -step->nu[s][k][j] / at->nu[s][k][j]);
        }
    }
    return 1.0 / worst;
}

static void move(Point *at, const Point *step, double length) {
    double *to = (double *)at;
    const double *by = (const double *)step;
    for (size_t i = 0; i < sizeof(Point) / sizeof(double); i++) to[i] += length * by[i];
}

static void start(const Qp *qp, double scale, Point *at) {
    int sides = 0;
    EACH_SIDE(s, k, j) sides++;
    memset(at, 0, sizeof *at);
    EACH_SIDE(s, k, j) {
        double limit = s == 0 ? qp->upper[k][j] : -qp->lower[k][j], w = qp->softness[j];
        double soft = w > 0.0 ? START_SLACK + fmax(-limit, 0.0) : 0.0;
        double t = fmax(limit + soft, START_SLACK), z = scale / (sides * t);
        if (w > 0.0) z = fmin(z, 0.5 * w);
        at->s[s][k][j] = soft;
        at->t[s][k][j] = t;
        at->z[s][k][j] = z;
        at->nu[s][k][j] = w > 0.0 ? w + w * soft - z : 1.0;
    }
}

/* Value of the unconstrained minimum below the start: the scale of the program's cost. */
static double free_decrease(Qp *qp) {
    Row none;
    Trajectory v, g, step;
    double sum = 0.0;
    memset(v, 0, sizeof v);
    memset(none, 0, sizeof none);
    factor(qp, NULL);
    gradient(qp, v, none, g);
    newton(qp, g, step);
    for (int k = 0; k <= N; k++)
        for (int i = 0; i < NZ; i++) sum -= 0.5 * g[k][i] * step[k][i];
    return sum;
}

static void interior_point(Qp *qp) {
    static const Point still;
    Point at, affine, step;
    Side weight;
    Row both;
    double scale = free_decrease(qp);
    start(qp, scale, &at);
    memset(&affine, 0, sizeof affine);
    memset(&step, 0, sizeof step);
    for (int count = 0; count < MAX_STEPS; count++) {
        double error = 0.0;
        memset(both, 0, sizeof both);
        EACH_SIDE(s, k, j) {
            weight[s][k][j] = 1.0 / (at.t[s][k][j] / at.z[s][k][j] +
                                     at.s[s][k][j] * give(qp, &at, s, k, j));
            both[k][j] += weight[s][k][j];
            error = fmax(error, fabs(row_error(qp, &at, s, k, j)));
        }
        if (!factor(qp, both)) break;
        double mu = gap(qp, &at, &still, 0.0);
        interior_step(qp, &at, weight, 0.0, NULL, &affine);
        double reached = gap(qp, &at, &affine, to_boundary(qp, &at, &affine));
        interior_step(qp, &at, weight, mu * pow(reached / mu, 3.0), &affine, &step);
        double length = fmin(1.0, TO_BOUNDARY * to_boundary(qp, &at, &step));
        move(&at, &step, length);
        if (gap(qp, &at, &still, 0.0) <= GAP * scale && (1.0 - length) * error <= ROW_ERROR) break;
    }
    memcpy(qp->answer.v, at.v, sizeof at.v);
    EACH_ROW(k, j) qp->answer.place[k][j] = 0;
    EACH_SIDE(s, k, j) {
        double w = qp->softness[j];
        int beyond = w > 0.0 && at.s[s][k][j] * w > at.nu[s][k][j];
        int sign = s == 0 ? 1 : -1;
        if (at.t[s][k][j] * scale < at.z[s][k][j])
            qp->answer.place[k][j] += sign * (beyond ? BEYOND : AT_BOUND);
        qp->answer.z[k][j] = at.z[0][k][j] - at.z[1][k][j];
    }
}

/* ---- both ------------------------------------------------------------------------------- */

static void solve_qp(Qp *qp) {
    if (active_set(qp)) return;
    interior_point(qp);
    Answer rough = qp->answer;
    if (!active_set(qp)) qp->answer = rough;
}
