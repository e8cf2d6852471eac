/* What the parts of rtgen-speed share: nodes of a type's table, and the calls on them.
 *
 * A function that fails returns -1 or NULL, with or without an exception: the codec then leaves the
 * value or the octets to the Python function, which raises the error or takes what is rare.
 */
#ifndef RTGEN_SPEED_CODEC_H
#define RTGEN_SPEED_CODEC_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#pragma GCC visibility push(hidden)  /* calls between the parts need no table of symbols */
#endif

#define MAX_DEPTH 100
/* Deeper values are left to Python, whose recursion limit holds. */

enum Kind {
    INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, FLOAT32, FLOAT64,
    BOOLEAN, CHARACTER, WIDE_CHARACTER, UNIT, ENUMERATOR, FLAGS, HOOK,
    NUMBERS, TEXT, WORDS, REPEAT, MAP, STRUCT, UNION, DELIMITED, OPTIONAL, LIST, PARAMETER, ANY,
    KINDS
};

enum Text { OCTETS, CHARACTERS, STRING, WIDE_STRING, UNITS };

enum Form { AS_LIST, AS_ARRAY, AS_MAKER };

typedef struct Node Node;

typedef struct {
    PyObject *name;       /* the attribute */
    Py_ssize_t offset;    /* of the slot in a plain class */
    const Node *node;
    uint32_t id, header;  /* of a member in a list */
    unsigned char optional, key, must_understand;
} Member;

typedef struct {
    int64_t number;
    const Node *node;
} Label;

struct Node {
    unsigned char kind;
    unsigned char form;     /* enum Form or Text; kind of the integer of an enumerator or flags */
    unsigned char align;
    unsigned char shared;   /* values cannot change: copies share them */
    unsigned char plain;    /* `type` is a class whose slots are read, and filled without a call */
    unsigned char unset;    /* None may stand for the value when it is copied */
    char code;              /* of buffers with the numbers */
    unsigned char version;  /* of XCDR, of a list */
    Py_ssize_t size;        /* octets of an atom */
    Py_ssize_t bound;       /* most items or octets, or -1 */
    Py_ssize_t length;      /* items of an array, or -1 */
    Py_ssize_t minimum;     /* least octets of an item; of numbers in arrays the most that are a list */
    const Node *child, *key;
    uint32_t id;
    unsigned char must_understand;
    Py_ssize_t count;
    Member *members;
    Label *labels;
    const Node *otherwise;
    Py_ssize_t dimensions;
    Py_ssize_t *lengths;
    PyObject *type, *first, *second;
    PyObject **enumerators; /* by number, if all are small; `first` owns them */
    Py_ssize_t enumerator_count;
};

typedef struct {
    PyObject_HEAD
    Py_ssize_t count;
    Node *nodes;
} Table;

enum Mode { ENCODE, DECODE, DECODE_PREFIX, READ, COPY };

typedef struct {
    PyObject_HEAD
    vectorcallfunc call;
    Table *table;
    const Node *root;
    enum Mode mode;
    int identifier;         /* of the payload's representation in big-endian order, or -1 */
    int again;              /* a decoder's `cls` is its first argument */
    Py_ssize_t likely;      /* octets that the next value is likely to need, or 0 */
    PyObject *make;         /* returns the Python function */
    PyObject *function;     /* that function, or NULL */
    PyObject *name;
} Codec;

#define PADDING 4           /* of a payload: that many octets after `capacity` are free */

typedef struct {
    char *at;               /* the octets so far, in `few` or in `octets` */
    Py_ssize_t position, capacity;
    Py_ssize_t base;        /* alignment counts from here */
    int swap, little, depth;
    PyObject *octets;
    char few[2048];
} Writer;

typedef struct {
    const unsigned char *data;
    Py_ssize_t position, end, base;
    int swap, little, depth;
} Reader;

/* What an `any` needs of the runtime: its class, and for each byte order (big, little) the entries of
 * types by their identity, and by the octets of their type codes; the functions add entries. */
typedef struct {
    PyObject *class, *heads[2], *make_head, *types[2], *make_type;
    Py_ssize_t type_offset, value_offset;
} Anys;

extern Anys anys;
extern PyTypeObject Table_Type, Codec_Type;
extern PyObject *numeric_array; /* rtgen's array class, set by the runtime */

int put(Writer *, const Node *, PyObject *);
PyObject *take(Reader *, const Node *);
PyObject *copy(const Node *, PyObject *, int depth);
PyObject *copy_over(const Node *, PyObject *, PyObject *spare);
int union_number(PyObject *discriminator, int64_t *number);
const Node *branch_of(const Node *, int64_t number);
Py_ssize_t slot_of(PyTypeObject *, PyObject *name);
int put_any(Writer *, PyObject *);
PyObject *take_any(Reader *);
PyObject *instance(const Node *, PyObject **values);
int add_ports(PyObject *module);
int add_numbers(void);

#if defined(_MSC_VER)
#define ALWAYS static __forceinline
#define NEVER static __declspec(noinline)
#else
#define ALWAYS static inline __attribute__((always_inline))
#define NEVER static __attribute__((noinline))
#endif

ALWAYS uint16_t swap16(uint16_t n) { return (uint16_t)(n << 8 | n >> 8); }
ALWAYS uint32_t swap32(uint32_t n) {
    return (uint32_t)swap16((uint16_t)n) << 16 | swap16((uint16_t)(n >> 16));
}
ALWAYS uint64_t swap64(uint64_t n) {
    return (uint64_t)swap32((uint32_t)n) << 32 | swap32((uint32_t)(n >> 32));
}

ALWAYS uint64_t load_word(const void *at) {
    uint64_t word;
    memcpy(&word, at, 8);
    return word;
}

enum { HAS_NUL = 1, HAS_HIGH = 2 };

ALWAYS int seen_in(uint64_t word) {
    const uint64_t ones = 0x0101010101010101u, highs = 0x8080808080808080u;
    int high = (word & highs) != 0, nul = ((word - ones) & ~word & highs) != 0;
    return high * HAS_HIGH | nul * HAS_NUL;
}

/* Up to seven octets and copies of some of them: words or octets that overlap. */
ALWAYS uint64_t word_of(const char *octets, Py_ssize_t count) {
    uint32_t first, last;
    if (count < 4) {
        const unsigned char *at = (const unsigned char *)octets;
        return (uint64_t)at[count / 2] << 8 | (uint64_t)at[count - 1] << 16 | at[0] * 0x0101010101000001u;
    }
    memcpy(&first, octets, 4);
    memcpy(&last, octets + count - 4, 4);
    return (uint64_t)last << 32 | first;
}

/* Returns whether NUL and octets beyond ASCII are among the octets. */
ALWAYS int scan(const char *octets, Py_ssize_t count) {
    uint64_t word;
    int seen = 0;
    if (count < 8) return count ? seen_in(word_of(octets, count)) : 0;
    for (Py_ssize_t i = 0; i < count - 8; i += 8) {
        memcpy(&word, octets + i, 8);
        seen |= seen_in(word);
    }
    memcpy(&word, octets + count - 8, 8);
    return seen | seen_in(word);
}

/* `memcpy` of octets that are mostly few; returns what `scan` does. */
ALWAYS int copy_few(char *at, const char *octets, Py_ssize_t count) {
    if (count > 32 || !count) {
        memcpy(at, octets, count);
        return scan(octets, count);
    }
    if (count < 8) {
        uint64_t word = word_of(octets, count);
        if (count < 4) {
            at[0] = (char)word;
            at[count / 2] = (char)(word >> 8);
            at[count - 1] = (char)(word >> 16);
        } else {
            uint32_t few = (uint32_t)word, last = (uint32_t)(word >> 32);
            memcpy(at, &few, 4);
            memcpy(at + count - 4, &last, 4);
        }
        return seen_in(word);
    }
    uint64_t first = load_word(octets), last = load_word(octets + count - 8);
    int seen = seen_in(first) | seen_in(last);
    if (count > 16) {
        uint64_t second = load_word(octets + 8), third = load_word(octets + count - 16);
        seen |= seen_in(second) | seen_in(third);
        memcpy(at + 8, &second, 8);
        memcpy(at + count - 16, &third, 8);
    }
    memcpy(at, &first, 8);
    memcpy(at + count - 8, &last, 8);
    return seen;
}

void swap_all(char *at, Py_ssize_t count, Py_ssize_t size);

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#endif
