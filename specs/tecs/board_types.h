/* The types of board.cdl that CDL does not have itself. */

#ifndef BOARD_TYPES_H
#define BOARD_TYPES_H

#ifdef TECSGEN
/* Whoever reads this for CDL has only to know that ER is a type. */
typedef int ER;
#else
#include <kernel.h>
#endif

#endif /* BOARD_TYPES_H */
