/* The time of the kernel. */

#include <errno.h>
#include <time.h>

#include "tKernel_tecsgen.h"

ER
eKernel_delay( RELTIM time )
{
    struct timespec left = { time / 1000, time % 1000 * 1000000L };

    while( nanosleep( &left, &left ) != 0 && errno == EINTR )
        ;
    return E_OK;
}

ER
eKernel_getTime( SYSTIM *time )
{
    struct timespec now;

    clock_gettime( CLOCK_MONOTONIC, &now );
    *time = ( SYSTIM )now.tv_sec * 1000000 + now.tv_nsec / 1000;
    return E_OK;
}
