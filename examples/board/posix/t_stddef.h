/* Types and codes of ITRON kernels, under the name by which tecsgen's library includes them. */
#ifndef T_STDDEF_H
#define T_STDDEF_H

#include <stdint.h>

#ifdef TECSGEN
typedef int pthread_mutex_t;
typedef unsigned long pthread_t;
#else
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#endif

typedef int int_t;
typedef unsigned int uint_t;
typedef long long_t;
typedef unsigned long ulong_t;
typedef uint8_t bool_t;
typedef float float32_t;
typedef double double64_t;

typedef int_t ER;
typedef int_t ER_UINT;
typedef int_t ER_INT;
typedef int_t PRI;
typedef int_t TMO;
typedef uint_t ATR;
typedef uint_t RELTIM;
typedef uint64_t SYSTIM;
typedef ulong_t SIZE;

#define E_OK    0
#define E_PAR   (-17)
#define E_ID    (-18)
#define E_NOMEM (-33)
#define E_OBJ   (-41)
#define E_CLS   (-52)
#define E_BOVR  (-58)

#define ERCD( main, sub ) ((ER) (((unsigned) (sub) << 8) | ((unsigned) (main) & 0xFFU)))
#define MERCD( code ) ((ER) (int8_t) (code))
#define SERCD( code ) ((ER) ((code) >> 8))

#define TA_NULL 0U
#define TA_ACT  1U
#define TMO_FEVR (-1)

#define LOG_INFO 6U
void board_log( uint_t priority, const char *form, ... );
#define syslog board_log

#endif
