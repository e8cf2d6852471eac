/* A wheel that is computed, for trying the board on a PC. */

#include <math.h>

#include "tSimulatedWheel_tecsgen.h"

double64_t
eWheel_turn( CELLIDX idx, double64_t speed, double64_t ramp, double64_t time )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    VAR_speed += fmax( -ramp * time, fmin( ramp * time, speed - VAR_speed ) );
    VAR_angle += VAR_speed * time;
    return VAR_speed;
}

int32_t
eWheel_getCount( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    return ( int32_t )floor( VAR_angle / ( 2.0 * M_PI ) * ATTR_encoder );
}
