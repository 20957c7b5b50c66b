/* The Kalman filter: filter.py, sample by sample, in C.

   Before this file stand the number of UNKNOWNS and where in them INERTIA (6), MOMENTUM (3), FIELD
   (FIELDS) and APPENDAGE (3) begin, and PAIRS, the indices of J's six numbers. All memory is the
   caller's or on the stack. */

typedef struct {
    double mean[UNKNOWNS], P[UNKNOWNS][UNKNOWNS];
    double t;
    double torque_map[3][FIELDS];      /* d tau_N / d field at time t */
    double deflection[3];
} Estimate;

typedef struct {
    double noise;                      /* of the balance, Nms, 1 sigma */
    double flexibility;                /* sigma of c over the mean inertia, rad/s */
    double correlation_time, deflection_time, quiet;
    double walk[UNKNOWNS];             /* growth of the variances in a second */
} Process;

typedef struct {
    double t, torque_map[3][FIELDS], H[3][UNKNOWNS], wheel_momentum[3], omega[3], known_torque[3];
} Sample;

static void inertia(const Estimate *e, double J[3][3]) {
    for (int i = 0; i < 6; i++)
        J[PAIRS[i][0]][PAIRS[i][1]] = J[PAIRS[i][1]][PAIRS[i][0]] = e->mean[INERTIA + i];
}

/* A X = B with pivots by rows; columns of B are replaced by those of X. */
static void solve3(double A[3][3], int columns, double B[3][columns]) {
    for (int c = 0; c < 3; c++) {
        int pivot = c;
        for (int r = c + 1; r < 3; r++)
            if (fabs(A[r][c]) > fabs(A[pivot][c])) pivot = r;
        for (int j = 0; j < 3; j++) { double s = A[c][j]; A[c][j] = A[pivot][j]; A[pivot][j] = s; }
        for (int j = 0; j < columns; j++) {
            double s = B[c][j]; B[c][j] = B[pivot][j]; B[pivot][j] = s;
        }
        for (int r = c + 1; r < 3; r++) {
            double factor = A[r][c] / A[c][c];
            for (int j = c; j < 3; j++) A[r][j] -= factor * A[c][j];
            for (int j = 0; j < columns; j++) B[r][j] -= factor * B[c][j];
        }
    }
    for (int r = 2; r >= 0; r--)
        for (int j = 0; j < columns; j++) {
            for (int k = r + 1; k < 3; k++) B[r][j] -= A[r][k] * B[k][j];
            B[r][j] /= A[r][r];
        }
}

/* h_N moved by known torque and the field's, c decayed, all less certain. */
static void time_update(Estimate *e, const Process *process, const Sample *s) {
    double dt = s->t - e->t, keep = exp(-dt / process->correlation_time);
    double J[3][3], move[3][FIELDS], moved[3][UNKNOWNS] = {{0.0}};
    inertia(e, J);
    double deviation = process->flexibility * (J[0][0] + J[1][1] + J[2][2]) / 3.0;
    for (int i = 0; i < 3; i++) e->mean[MOMENTUM + i] += dt * s->known_torque[i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < FIELDS; j++) {
            move[i][j] = 0.5 * dt * (e->torque_map[i][j] + s->torque_map[i][j]);
            e->mean[MOMENTUM + i] += move[i][j] * e->mean[FIELD + j];
            for (int c = 0; c < UNKNOWNS; c++) moved[i][c] += move[i][j] * e->P[FIELD + j][c];
        }
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < UNKNOWNS; c++) e->P[MOMENTUM + i][c] += moved[i][c];
    for (int r = 0; r < UNKNOWNS; r++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < FIELDS; j++) e->P[r][MOMENTUM + i] += e->P[r][FIELD + j] * move[i][j];
    for (int r = 0; r < UNKNOWNS; r++) e->P[r][r] += process->walk[r] * dt;
    for (int i = APPENDAGE; i < APPENDAGE + 3; i++) {
        e->mean[i] *= keep;
        for (int c = 0; c < UNKNOWNS; c++) e->P[i][c] *= keep;
        for (int r = 0; r < UNKNOWNS; r++) e->P[r][i] *= keep;
        e->P[i][i] += (1.0 - keep * keep) * deviation * deviation;
    }
    e->t = s->t;
    memcpy(e->torque_map, s->torque_map, sizeof e->torque_map);
}

/* The balance H mean = -A (Js Omega) was measured. Joseph's form, right for any gain:
   P <- (1 - G H) P (1 - G H)' + noise^2 G G'. */
static void measurement_update(Estimate *e, const Process *process, const Sample *s) {
    double variance = process->noise * process->noise;
    double HP[3][UNKNOWNS] = {{0.0}}, S[3][3], G[3][UNKNOWNS], error[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < UNKNOWNS; j++)
            if (s->H[i][j] != 0.0)
                for (int c = 0; c < UNKNOWNS; c++) HP[i][c] += s->H[i][j] * e->P[j][c];
    for (int i = 0; i < 3; i++) {
        error[i] = s->wheel_momentum[i];
        for (int j = 0; j < UNKNOWNS; j++) error[i] += s->H[i][j] * e->mean[j];
        for (int k = 0; k < 3; k++) {
            S[i][k] = i == k ? variance : 0.0;
            for (int j = 0; j < UNKNOWNS; j++) S[i][k] += HP[i][j] * s->H[k][j];
        }
    }
    memcpy(G, HP, sizeof G);
    solve3(S, UNKNOWNS, G);            /* the gain's transpose */
    const double *w = s->omega;
    if (sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) < process->quiet)
        for (int i = 0; i < 3; i++) memset(&G[i][INERTIA], 0, 6 * sizeof(double));
    for (int i = 0; i < 3; i++)
        for (int r = 0; r < UNKNOWNS; r++) {
            e->mean[r] -= G[i][r] * error[i];
            for (int c = 0; c < UNKNOWNS; c++) e->P[r][c] -= G[i][r] * HP[i][c];
        }
    double back[3][UNKNOWNS];          /* H P of the half-updated P, less the noise's part */
    for (int i = 0; i < 3; i++)
        for (int r = 0; r < UNKNOWNS; r++) {
            back[i][r] = -variance * G[i][r];
            for (int j = 0; j < UNKNOWNS; j++) back[i][r] += e->P[r][j] * s->H[i][j];
        }
    for (int i = 0; i < 3; i++)
        for (int r = 0; r < UNKNOWNS; r++)
            for (int c = 0; c < UNKNOWNS; c++) e->P[r][c] -= back[i][r] * G[i][c];
    for (int r = 0; r < UNKNOWNS; r++)
        for (int c = 0; c < r; c++) e->P[r][c] = e->P[c][r] = 0.5 * (e->P[r][c] + e->P[c][r]);
}

void filter_samples(int count, const Sample *samples, const Process *process, Estimate *e) {
    for (int k = 0; k < count; k++) {
        double dt = samples[k].t - e->t, before[3], J[3][3], c[3][1];
        memcpy(before, &e->mean[APPENDAGE], sizeof before);
        time_update(e, process, &samples[k]);
        measurement_update(e, process, &samples[k]);
        for (int i = 0; i < 3; i++) c[i][0] = 0.5 * (before[i] + e->mean[APPENDAGE + i]);
        inertia(e, J);
        solve3(J, 1, c);
        double left = exp(-dt / process->deflection_time);
        for (int i = 0; i < 3; i++) e->deflection[i] = left * e->deflection[i] - dt * c[i][0];
    }
}
