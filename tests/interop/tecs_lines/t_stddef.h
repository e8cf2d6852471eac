/* The kernel's types, under the name by which tecsgen's library includes them. */
#ifndef T_STDDEF_H
#define T_STDDEF_H

#include <stdint.h>

typedef signed int int_t;
typedef unsigned int uint_t;
typedef short short_t;
typedef unsigned short ushort_t;
typedef long long_t;
typedef unsigned long ulong_t;

typedef int_t ER;
typedef int_t ER_UINT;
typedef int_t ER_INT;
typedef int_t PRI;
typedef int_t TMO;
typedef uint_t ATR;
typedef uint_t RELTIM;
typedef ulong_t SIZE;

#endif
