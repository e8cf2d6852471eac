/* The board's end of a TCP connection. */

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tTcpServer_tecsgen.h"

ER
eC1_flush( CELLIDX idx, TMO tmo )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );
    int32_t sent = 0;
    ssize_t n;

    ( void )tmo;
    while( sent < VAR_filled ){
        n = send( VAR_connection, VAR_buffer + sent, ( size_t )( VAR_filled - sent ), MSG_NOSIGNAL );
        if( n <= 0 )
            return E_CLS;
        sent += ( int32_t )n;
    }
    VAR_filled = 0;
    return E_OK;
}

ER
eC1_send( CELLIDX idx, const int8_t *buf, int16_t size, TMO tmo )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    for( ; size > 0; size-- ){
        if( VAR_filled == BUFFER_SIZE && eC1_flush( idx, tmo ) != E_OK )
            return E_CLS;
        VAR_buffer[VAR_filled++] = *buf++;
    }
    return E_OK;
}

ER_UINT
eC1_receive( CELLIDX idx, int8_t *buf, int16_t size, TMO tmo )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    ( void )tmo;
    if( recv( VAR_connection, buf, ( size_t )size, MSG_WAITALL ) != size )
        return E_CLS;
    return size;
}

ER
eC1_end_receive( CELLIDX idx )
{
    ( void )idx;
    return E_OK;
}

ER
eC1_reset( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    VAR_filled = 0;
    return E_OK;
}

/* Listens, and says where: a port of 0 is any free one. */
static int
listen_on( uint16_t port )
{
    struct sockaddr_in address = { .sin_family = AF_INET, .sin_port = htons( port ),
                                   .sin_addr.s_addr = htonl( INADDR_LOOPBACK ) };
    socklen_t size = sizeof address;
    int       listener = socket( AF_INET, SOCK_STREAM, 0 ), yes = 1;

    if( listener < 0
        || setsockopt( listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes ) != 0
        || bind( listener, ( struct sockaddr * )&address, size ) != 0
        || listen( listener, 4 ) != 0
        || getsockname( listener, ( struct sockaddr * )&address, &size ) != 0 ){
        perror( "the board cannot listen" );
        exit( EXIT_FAILURE );
    }
    printf( "listening 127.0.0.1:%d\n", ntohs( address.sin_port ) );
    fflush( stdout );
    return listener;
}

ER
eOpener_open( CELLIDX idx )
{
    CELLCB     *p_cellcb = GET_CELLCB( idx );
    const char *given = getenv( "BOARD_PORT" );
    int         yes = 1;

    if( VAR_listener < 0 )
        VAR_listener = listen_on( given ? ( uint16_t )atoi( given ) : ( uint16_t )ATTR_portNo );
    VAR_connection = accept( VAR_listener, NULL, NULL );
    if( VAR_connection < 0 )
        return E_OBJ;
    setsockopt( VAR_connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes );
    return eC1_reset( idx );
}

ER
eOpener_close( CELLIDX idx )
{
    CELLCB *p_cellcb = GET_CELLCB( idx );

    close( VAR_connection );
    VAR_connection = -1;
    return E_OK;
}
