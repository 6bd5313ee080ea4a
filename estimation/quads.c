/* Vectors of QUAD numbers. Behind estimation/arrays.c. */

typedef real quad __attribute__((vector_size(QUAD * sizeof(real)), aligned(sizeof(real)), may_alias));

/* Macros: a function that returns a quad has another interface on each processor. */
#define AT(a) (*(const quad *)(a))
#define PUT(a, value) (*(quad *)(a) = (value))
#define ALL(a) ((quad){(a), (a), (a), (a)})

#ifdef __has_builtin
#if __has_builtin(__builtin_shufflevector)
#define SHUFFLES
#endif
#endif
/* The transpose of a block of quads, `to` with rows of `width`. */
static inline void turn(const quad from[QUAD], real *to, integer width)
{
#ifdef SHUFFLES
    const quad a = __builtin_shufflevector(from[0], from[1], 0, 4, 2, 6);
    const quad b = __builtin_shufflevector(from[0], from[1], 1, 5, 3, 7);
    const quad c = __builtin_shufflevector(from[2], from[3], 0, 4, 2, 6);
    const quad d = __builtin_shufflevector(from[2], from[3], 1, 5, 3, 7);
    PUT(to, __builtin_shufflevector(a, c, 0, 1, 4, 5));
    PUT(to + width, __builtin_shufflevector(b, d, 0, 1, 4, 5));
    PUT(to + 2 * width, __builtin_shufflevector(a, c, 2, 3, 6, 7));
    PUT(to + 3 * width, __builtin_shufflevector(b, d, 2, 3, 6, 7));
#else
    for (integer i = 0; i < QUAD; i++)
        for (integer j = 0; j < QUAD; j++) to[j * width + i] = from[i][j];
#endif
}
