/* Estimates from a recording: reads the CSV that pen-mhe estimate reads, and writes one row per
 * instant. An example of how @prefix.h is called; the library itself needs no files. */

#include "@prefix.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST_LINE 65536
#define MOST_CELLS 1024
#define TIME (-1)
#define UNUSED (-2)

/* Headers of a recording, what they give, and the factor to SI. */
static const struct { const char *header; int reading; double factor; } columns[] = @columns;
static const char *const readings[] = @readings;
static const struct { unsigned bit; const char *label; } statuses[] = @statuses;

static char line[LONGEST_LINE];
static int reading_of[MOST_CELLS];
static double factor_of[MOST_CELLS];
static @{prefix}_state state;
static @{prefix}_estimate estimate;

/* What people read: where it stands, and its standard deviation, or the square of that. */
#define STATE(at) &estimate.mean[at], &estimate.covariance[(at) * (@{PREFIX}_N_X + 1)], 1
#define DERIVED(at) &estimate.derived[at], &estimate.derived_std[at], 0
static const struct {
    const char *name;
    const @{prefix}_real *value, *spread;
    int squared;
} shown[] = @shown;
static const size_t n_shown = sizeof shown / sizeof *shown;

static int fail(const char *path, long row, const char *column, const char *what)
{
    if (row > 0)
        fprintf(stderr, "recording %s: row %ld, column %s: %s\n", path, row, column, what);
    else
        fprintf(stderr, "recording %s: %s%s%s\n", path, column, *column ? ": " : "", what);
    return 1;
}

/* Cut the next cell off a line; 0 where there is none. */
static char *next_cell(char **rest)
{
    char *cell = *rest;
    if (cell == 0) return 0;
    char *end = cell + strcspn(cell, ",\r\n");
    *rest = *end == ',' ? end + 1 : 0;
    *end = 0;
    return cell;
}

/* Find what each column gives; returns how many there are, 0 after a message. */
static int read_header(const char *path)
{
    static const unsigned char mark[] = {0xEF, 0xBB, 0xBF}; /* UTF-8, as some programs begin */
    int given[@{PREFIX}_N_Y + 1] = {0}, n = 0;
    char *rest = memcmp(line, mark, sizeof mark) == 0 ? line + sizeof mark : line, *cell;
    for (; (cell = next_cell(&rest)) != 0; n++) {
        if (n == MOST_CELLS) return fail(path, 0, "", "more columns than this program takes"), 0;
        reading_of[n] = UNUSED;
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
            if (strcmp(cell, columns[i].header) != 0) continue;
            reading_of[n] = columns[i].reading;
            factor_of[n] = columns[i].factor;
            if (given[1 + reading_of[n]]++) return fail(path, 0, cell, "is given twice"), 0;
        }
    }
    if (!given[0]) return fail(path, 0, "time_s", "column is missing"), 0;
    for (int i = 0; i < @{PREFIX}_N_Y; i++)
        if (!given[1 + i]) return fail(path, 0, readings[i], "column is missing"), 0;
    return n;
}

/* Read a row; returns whether it could be read. Empty cells are NaN. */
static int read_row(const char *path, long row, int n, double *time_s, @{prefix}_real *y)
{
    char *rest = line;
    for (int i = 0; i < n; i++) {
        const char *cell = next_cell(&rest);
        if (cell == 0) return fail(path, row, "", "has fewer cells than the header"), 0;
        if (reading_of[i] == UNUSED) continue;
        char *end;
        const double value = strtod(cell, &end);
        const int empty = *cell == 0, is_time = reading_of[i] == TIME;
        const char *name = is_time ? "time" : readings[reading_of[i]];
        if (!empty && (*end != 0 || !isfinite(value)))
            return fail(path, row, name, "is not a finite number"), 0;
        if (is_time && empty) return fail(path, row, name, "is empty"), 0;
        if (is_time)
            *time_s = rint(value * factor_of[i] * @per_tick) / @per_tick;
        else
            y[reading_of[i]] = empty ? NAN : (@{prefix}_real)(value * factor_of[i]);
    }
    return 1;
}

static void write_header(FILE *output)
{
    fputs("time_s", output);
    for (size_t i = 0; i < n_shown; i++) fprintf(output, ",%s", shown[i].name);
    for (size_t i = 0; i < n_shown; i++) fprintf(output, ",%s_std", shown[i].name);
    fputs(",status,iterations,step_time_s\n", output);
}

static void write_estimate(FILE *output)
{
    fprintf(output, "%.@{time_digits}f", estimate.time_s);
    for (size_t i = 0; i < n_shown; i++) fprintf(output, ",%.@{digits}g", (double)*shown[i].value);
    for (size_t i = 0; i < n_shown; i++) {
        const double spread = (double)*shown[i].spread;
        fprintf(output, ",%.@{digits}g", shown[i].squared ? sqrt(spread) : spread);
    }
    char separator = ',';
    for (size_t i = 0; i < sizeof statuses / sizeof *statuses; i++) {
        if (!(estimate.status & statuses[i].bit)) continue;
        fprintf(output, "%c%s", separator, statuses[i].label);
        separator = '+';
    }
    if (estimate.status == 0) fputs(",@solved", output);
    fprintf(output, ",%d,%.@{digits}g\n", estimate.iterations, (double)estimate.step_time_s);
}

static int run(const char *path, FILE *input, FILE *output)
{
    if (!fgets(line, sizeof line, input)) return fail(path, 0, "", "is empty");
    const int n = read_header(path);
    if (n == 0) return 1;
    write_header(output);
    @{prefix}_init(&state);
    double before = -INFINITY;
    for (long row = 1; fgets(line, sizeof line, input); row++) {
        double time_s = NAN;
        @{prefix}_real y[@{PREFIX}_N_Y];
        if (!strchr(line, '\n') && !feof(input)) return fail(path, row, "", "is too long");
        if (!read_row(path, row, n, &time_s, y)) return 1;
        if (!(time_s > before))
            return fail(path, row, "time", "does not follow the one before");
        before = time_s;
        int present = 0;
        for (int i = 0; i < @{PREFIX}_N_Y; i++) present = present || !isnan(y[i]);
        if (!present) continue;
        @{prefix}_step(&state, time_s, y, &estimate);
        write_estimate(output);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: %s recording.csv estimates.csv\n", argv[0]);
        return 2;
    }
    FILE *input = fopen(argv[1], "r");
    if (!input) return fail(argv[1], 0, "", "cannot be read");
    FILE *output = fopen(argv[2], "w");
    if (!output) {
        fclose(input);
        fprintf(stderr, "estimates %s: cannot be written\n", argv[2]);
        return 1;
    }
    const int failed = run(argv[1], input, output);
    fclose(input);
    if (fclose(output) != 0) {
        fprintf(stderr, "estimates %s: cannot be written\n", argv[2]);
        return 1;
    }
    return failed;
}
