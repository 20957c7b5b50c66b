/* The quadratic program of one step, stage by stage, and the Riccati recursion that solves it:

     minimise    sum_k 1/2 z_k' W_k z_k + q_k' z_k  (+ soft rows: w s + w s^2 / 2),  z_k = (dx_k, du_k)
     subject to  dx_0 = 0,  dx_{k+1} = F_k z_k,  lower_k - s <= C z_k <= upper_k + s

   Its rows are the business of active_set.h and interior_point.h, which are active_set.py and
   interior_point.py step for step; where those factor a dense condensed Hessian, the recursion
   costs N (nx + nu)^3 and no condensing. N, NX, NU and M (rows a stage) are defined by the code
   that is generated for a problem and stands before this file. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NZ (NX + NU)
#define EACH_ROW(k, j) for (int k = 0; k <= N; k++) for (int j = 0; j < M; j++) if (qp->on[k][j])
#define EACH_SIDE(s, k, j) for (int s = 0; s < 2; s++) EACH_ROW(k, j)

enum { INSIDE, AT_BOUND, BEYOND };  /* where a row ends; positive above, negative below */

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
