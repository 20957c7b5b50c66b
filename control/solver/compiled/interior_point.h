/* The quadratic program by an interior point: interior_point.py, step for step; and qp.py. */

static const double START_SLACK = 0.1, TO_BOUNDARY = 0.995, GAP = 1e-9, ROW_ERROR = 1e-9;
static const int MAX_STEPS = 50;

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

/* The active set first, the interior point where that goes round, polished by the active set. */
static void solve_qp(Qp *qp) {
    if (active_set(qp)) return;
    interior_point(qp);
    Answer rough = qp->answer;
    if (!active_set(qp)) qp->answer = rough;
}
