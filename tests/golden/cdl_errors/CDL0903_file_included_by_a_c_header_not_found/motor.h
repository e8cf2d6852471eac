#include <stdint.h>
#include <board/registers.h>
typedef int Speed;
