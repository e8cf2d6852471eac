/* Tasks as threads. The program is here, too: it starts the tasks that are to run at once. */

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tTask_tecsgen.h"

static void *
run( void *argument )
{
    CELLCB *p_cellcb = argument;

    cBody_main();
    return NULL;
}

ER
eTask_activate( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    return pthread_create( &VAR_thread, NULL, run, p_cellcb ) == 0 ? E_OK : E_NOMEM;
}

int
main( void )
{
    CELLCB *p_cellcb;
    int     i;

    FOREACH_CELL( i, p_cellcb )
        if( ATTR_taskAttribute & TA_ACT && eTask_activate( p_cellcb ) != E_OK ){
            perror( "a task cannot be started" );
            return EXIT_FAILURE;
        }
    END_FOREACH_CELL
    pthread_exit( NULL );
}
