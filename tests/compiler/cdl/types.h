#include <stdint.h>
#define COUNT 3
#define PACKED __attribute__((packed))
typedef int ER;
typedef ER ER_UINT;
typedef int ID;
typedef int PRI;
typedef struct PACKED board {
    unsigned char version[COUNT * 2];
    struct { int x; } inside;
    unsigned flag : 3;
    struct board *next;
} Board;
static inline void hold(void) { __asm__ volatile("wfi"); if (1) { } }
extern int table[], call(int a) __attribute__((noreturn));
enum colour { RED, GREEN = 5, BLUE };
