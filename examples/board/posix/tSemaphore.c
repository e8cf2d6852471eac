/* A semaphore of one, by a mutex. */

#include "tSemaphore_tecsgen.h"

ER
eSemaphore_signal( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    return pthread_mutex_unlock( &VAR_mutex ) == 0 ? E_OK : E_OBJ;
}

ER
eSemaphore_wait( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    return pthread_mutex_lock( &VAR_mutex ) == 0 ? E_OK : E_OBJ;
}
