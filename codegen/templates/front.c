/* @title
 *
 * Written by pen-mhe codegen; the loop below is the one that it runs itself. */
#if defined PEN_MHE_HOSTED && !defined _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 199309L
#endif

#include "@prefix.h"

#include <math.h>
#include <stddef.h>

@functions
#define @{entry}_step @{prefix}_@{entry}_step
#define @{entry}_batch @{prefix}_@{entry}_batch
typedef @{prefix}_real real;
typedef int integer;
@generated
