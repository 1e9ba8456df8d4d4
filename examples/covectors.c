/* covectors.c: planes in 2, 3 and 4 dimensions under a matrix, with whole numbers, so that nothing
 * is rounded: the coefficients of a plane go through the cofactors. The guide shows these numbers.
 */
#include <stdio.h>

enum { MOST = 4 };
typedef long matrix[MOST][MOST]; /* rows, then columns */

/* Laplace's expansion along the first row. */
static long determinant(int n, matrix m) {
    if (n == 0) return 1;
    long sum = 0;
    for (int column = 0; column < n; ++column) {
        matrix minor;
        for (int i = 1; i < n; ++i)
            for (int k = 0, to = 0; k < n; ++k)
                if (k != column) minor[i - 1][to++] = m[i][k];
        sum += (column % 2 ? -1 : 1) * m[0][column] * determinant(n - 1, minor);
    }
    return sum;
}

static long cofactor(int n, matrix m, int row, int column) {
    matrix minor;
    for (int i = 0, down = 0; i < n; ++i) {
        if (i == row) continue;
        for (int k = 0, across = 0; k < n; ++k)
            if (k != column) minor[down][across++] = m[i][k];
        ++down;
    }
    return ((row + column) % 2 ? -1 : 1) * determinant(n - 1, minor);
}

static void print_row(const char *name, int n, const long *v) {
    printf("  %-18s", name);
    for (int i = 0; i < n; ++i) printf(" %3ld", v[i]);
    printf("\n");
}

static void multiply(int n, matrix m, const long *v, long *out) {
    for (int i = 0; i < n; ++i) {
        out[i] = 0;
        for (int k = 0; k < n; ++k) out[i] += m[i][k] * v[k];
    }
}

static long dot(int n, const long *a, const long *b) {
    long sum = 0;
    for (int i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

/* The plane a . x = 0 before, and the same points after M. */
static void show(int n, matrix m) {
    const long plane[MOST] = {1, 1, 1, 1};
    matrix cof;
    long through_m[MOST], through_cof[MOST], wrong = 0, right = 0;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) cof[i][k] = cofactor(n, m, i, k);
    multiply(n, m, plane, through_m);
    multiply(n, cof, plane, through_cof);
    /* The plane is spanned by e_k - e_0, for k from 1 up. */
    for (int k = 1; k < n; ++k) {
        long edge[MOST] = {-1}, moved[MOST], size;
        edge[k] = 1;
        multiply(n, m, edge, moved);
        size = dot(n, through_m, moved);
        wrong += size < 0 ? -size : size;
        size = dot(n, through_cof, moved);
        right += size < 0 ? -size : size;
    }
    printf("%d dimensions, det M = %ld\n", n, determinant(n, m));
    print_row("plane", n, plane);
    print_row("through M", n, through_m);
    printf("  %-18s %3ld\n", "error", wrong);
    print_row("through cof(M)", n, through_cof);
    printf("  %-18s %3ld\n", "error", right);
}

int main(void) {
    matrix two = {{2, 1}, {0, 1}};
    matrix three = {{2, 1, 0}, {0, 1, 0}, {0, 0, 3}};
    matrix four = {{2, 1, 0, 0}, {0, 1, 0, 0}, {0, 0, 3, 0}, {1, 0, 0, 1}};
    matrix flat = {{1, 0, 1}, {0, 1, 1}, {0, 0, 0}};
    show(2, two);
    show(3, three);
    show(4, four);
    show(3, flat);
    return 0;
}
