/* Sizes of the model: constants where a stage is compiled for them, else the structure's. A row of an
 * array named P_ is as long as LD says, a multiple of QUAD, with zeros behind its n_x numbers. */

#include <math.h>
#include <string.h>

#ifdef N_X
#define LD ((N_X + QUAD - 1) / QUAD * QUAD)
#else
#define N_X (m->n_x)
#define N_W (m->n_w)
#define N_R (m->n_r)
#define LD (m->stride)
#endif

#define P_SIZE (LD * LD)

/* A row of a lower triangle, row behind row. */
#define ROW(triangle, i) ((triangle) + (i) * ((i) + 1) / 2)
