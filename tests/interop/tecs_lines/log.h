/* Uses a type of t_stddef.h without including it, as headers of kernels do. */
typedef struct {
    uint_t kind;
    int position[2];
} LOG_RECORD;
