/* The log of the board: lines on standard error. */

#include <stdarg.h>
#include <stdio.h>

#include "tSysLog_tecsgen.h"

ER
eSysLog_write( uint_t priority, const char_t *text )
{
    fprintf( stderr, "%u: %s\n", priority, text );
    return E_OK;
}

void
board_log( uint_t priority, const char *form, ... )
{
    char    text[256];
    va_list values;

    va_start( values, form );
    vsnprintf( text, sizeof text, form, values );
    va_end( values );
    eSysLog_write( priority, text );
}
