/* The smallest program that uses all of an export, to measure it. */
#include "@prefix.h"

@{prefix}_state state;
@{prefix}_estimate estimate;
static const @{prefix}_real readings[@{PREFIX}_N_Y];

double @{prefix}_seconds(void);
double @{prefix}_seconds(void) { return 0; }

int main(void)
{
    @{prefix}_init(&state);
    return @{prefix}_step(&state, 0, readings, &estimate);
}
