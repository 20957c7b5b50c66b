/* The quadratic program by a primal-dual active set: active_set.py, step for step. */

static const double STIFFNESS = 1e7, BROKEN = 1e-10;
static const int PASSES = 3, MAX_ROUNDS = 6;

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
