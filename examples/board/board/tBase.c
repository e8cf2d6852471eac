/* The base: calls of the robot, and the loop that turns the wheels and follows the base. */

#include <math.h>
#include <string.h>

#include "tBase_tecsgen.h"

static double64_t *
parameter( CELLCB *p_cellcb, const char_t *name )
{
    if( strncmp( name, "limit", TEXT_SIZE ) == 0 )
        return &VAR_limit;
    if( strncmp( name, "ramp", TEXT_SIZE ) == 0 )
        return &VAR_ramp;
    return NULL;
}

ER
eBase_identify( CELLIDX idx, char_t *name )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    strncpy( name, ATTR_name, TEXT_SIZE );  /* all of it is sent */
    return E_OK;
}

ER
eBase_setParameter( CELLIDX idx, const char_t *name, double64_t *value )
{
    CELLCB     *p_cellcb = GET_CELLCB( idx );
    double64_t *place = parameter( p_cellcb, name );
    double64_t  wanted = *value;
    ER          code = E_OK;

    if( place == NULL )
        return E_OBJ;
    cLock_wait();
    *value = *place;
    if( wanted > 0.0 && isfinite( wanted ) )
        *place = wanted;
    else
        code = E_PAR;
    cLock_signal();
    return code;
}

ER
eBase_drive( CELLIDX idx, const double64_t *speed, int32_t count, struct tagOdometry *odometry )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );
    ER      code = count == WHEELS ? E_OK : E_PAR;
    int     i;

    cLock_wait();
    for( i = 0; i < count; i++ )
        if( ! ( fabs( speed[i] ) <= VAR_limit ) )   /* nor is it a NaN */
            code = E_PAR;
    if( code == E_OK && VAR_odometry.stopped )
        code = E_OBJ;
    if( code == E_OK )
        memcpy( VAR_wanted, speed, sizeof VAR_wanted );
    *odometry = VAR_odometry;
    cLock_signal();
    return code;
}

ER
eBase_getOdometry( CELLIDX idx, struct tagOdometry *odometry )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    cLock_wait();
    *odometry = VAR_odometry;
    cLock_signal();
    return E_OK;
}

ER
eBase_getTrace( CELLIDX idx, uint8_t wheel, double64_t *speed, int32_t *count )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );
    int32_t room = *count;

    *count = 0;
    if( wheel >= WHEELS )
        return E_ID;
    cLock_wait();
    *count = room < VAR_traced ? room : VAR_traced;
    memcpy( speed, VAR_trace[wheel] + TRACE_SIZE - *count, ( size_t )*count * sizeof *speed );
    cLock_signal();
    return E_OK;
}

void
eBase_stop( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    cLock_wait();
    VAR_odometry.stopped = true;
    memset( VAR_wanted, 0, sizeof VAR_wanted );
    cLock_signal();
}

ER
eBase_release( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    cLock_wait();
    VAR_odometry.stopped = false;
    cLock_signal();
    return E_OK;
}

/* Appends to the traces of both wheels; of full ones the oldest speed goes. */
static void
trace( CELLCB *p_cellcb, const double64_t *speed )
{
    int i;

    if( VAR_traced < TRACE_SIZE )
        VAR_traced++;
    for( i = 0; i < WHEELS; i++ ){
        memmove( VAR_trace[i], VAR_trace[i] + 1, sizeof VAR_trace[i] - sizeof VAR_trace[i][0] );
        VAR_trace[i][TRACE_SIZE - 1] = speed[i];
    }
}

/* Turns the wheels for a time [s], and follows where they take the base. */
static void
move( CELLCB *p_cellcb, double64_t time )
{
    struct tagOdometry *o = &VAR_odometry;
    double64_t speed[WHEELS], way[WHEELS], forwards;
    int32_t    count;
    int        i;

    for( i = 0; i < WHEELS; i++ ){
        speed[i] = cWheel_turn( i, VAR_wanted[i], VAR_ramp, time );
        count = cWheel_getCount( i );
        way[i] = ( count - o->count[i] ) * 2.0 * M_PI * ATTR_radius / ATTR_encoder;
        o->count[i] = count;
    }
    trace( p_cellcb, speed );
    forwards = ( way[0] + way[1] ) / 2.0;
    o->heading += ( way[1] - way[0] ) / ATTR_tread;
    o->x += forwards * cos( o->heading );
    o->y += forwards * sin( o->heading );
}

void
eControl_main( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );
    SYSTIM  start, before, now;

    getTime( &start );
    for( before = start;; before = now ){
        delay( ATTR_period );
        getTime( &now );
        cLock_wait();
        VAR_odometry.time = ( uint32_t )( ( now - start ) / 1000 );
        move( p_cellcb, ( now - before ) * 1e-6 );
        cLock_signal();
    }
}
