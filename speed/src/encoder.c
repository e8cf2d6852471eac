/* Appends values to octets, as `rtgen.runtime.marshalling.source.encoder` does. */
#include "codec.h"
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { PID_EXTENDED = 0x3F01, PID_LIST_END = 0x3F02, SHORT_MUST_UNDERSTAND = 0x4000 };
#define LONG_MUST_UNDERSTAND 0x40000000u

static int grow(Writer *w, Py_ssize_t size) {
    if (size > PY_SSIZE_T_MAX / 4 - w->position) return PyErr_NoMemory(), -1;
    Py_ssize_t capacity = w->position + size + w->position / 2 + 64;
    if (w->octets == NULL) {
        w->octets = PyBytes_FromStringAndSize(NULL, capacity);
        if (w->octets == NULL) return -1;
        memcpy(PyBytes_AS_STRING(w->octets), w->few, w->position);
    } else if (_PyBytes_Resize(&w->octets, capacity)) {
        return -1;
    }
    w->at = PyBytes_AS_STRING(w->octets);
    w->capacity = capacity - PADDING;
    return 0;
}

ALWAYS int reserve(Writer *w, Py_ssize_t size) {
    return w->capacity - w->position >= size ? 0 : grow(w, size);
}

/* Pads to a multiple of `align`, and reserves that many octets after it. */
ALWAYS int begin(Writer *w, Py_ssize_t align, Py_ssize_t size) {
    Py_ssize_t padding = (w->base - w->position) & (align - 1);
    if (reserve(w, size + 8)) return -1;
    if (padding) {
        memset(w->at + w->position, 0, 8);
        w->position += padding;
    }
    return 0;
}

/* The same without a branch, which would often be predicted wrongly after a text. */
ALWAYS int begin_text(Writer *w, Py_ssize_t size) {
    if (reserve(w, size + 8)) return -1;
    memset(w->at + w->position, 0, 4);
    w->position += (w->base - w->position) & 3;
    return 0;
}

ALWAYS void store32(char *at, uint32_t n, int swap) {
    if (swap) n = swap32(n);
    memcpy(at, &n, 4);
}

ALWAYS void store16(char *at, uint16_t n, int swap) {
    if (swap) n = swap16(n);
    memcpy(at, &n, 2);
}

ALWAYS int put_count(Writer *w, Py_ssize_t count) {
    if ((uint64_t)count > UINT32_MAX || begin(w, 4, 4)) return -1;
    store32(w->at + w->position, (uint32_t)count, w->swap);
    w->position += 4;
    return 0;
}

static int put_octets(Writer *w, const char *octets, Py_ssize_t count) {
    if (reserve(w, count)) return -1;
    memcpy(w->at + w->position, octets, count);
    w->position += count;
    return 0;
}

/* Returns whether an integer has one digit, and so needs no call. */
ALWAYS int is_small(PyObject *value, long long *number) {
#if PY_VERSION_HEX >= 0x030C0000
    if (!PyUnstable_Long_IsCompact((PyLongObject *)value)) return 0;
    *number = PyUnstable_Long_CompactValue((PyLongObject *)value);
#else
    Py_ssize_t size = Py_SIZE(value);
    if (size < -1 || size > 1) return 0;
    *number = size ? size * (long long)((PyLongObject *)value)->ob_digit[0] : 0;
#endif
    return 1;
}

/* Stores a number of a kind of at most FLOAT64 at `at`. */
ALWAYS int store(int kind, char *at, PyObject *value, int swap) {
    if (kind == FLOAT32 || kind == FLOAT64) {
        double number;
        if (PyFloat_Check(value)) number = PyFloat_AS_DOUBLE(value);
        else if (PyLong_CheckExact(value) || PyBool_Check(value)) {
            number = PyLong_AsDouble(value);
            if (number == -1.0 && PyErr_Occurred()) return -1;
        } else return -1;
        if (kind == FLOAT64) {
            uint64_t bits;
            memcpy(&bits, &number, 8);
            if (swap) bits = swap64(bits);
            memcpy(at, &bits, 8);
            return 0;
        }
        float single = (float)number;
        if (single - single == 0.0f) {  /* finite */
            uint32_t bits;
            memcpy(&bits, &single, 4);
            store32(at, bits, swap);
            return 0;
        }
        return PyFloat_Pack4(number, at, swap ? !PY_LITTLE_ENDIAN : PY_LITTLE_ENDIAN);
    }
    if (!PyLong_Check(value)) return -1;
    if (kind == UINT64) {
        unsigned long long number = PyLong_AsUnsignedLongLong(value);
        if (number == (unsigned long long)-1 && PyErr_Occurred()) return -1;
        uint64_t bits = number;
        if (swap) bits = swap64(bits);
        memcpy(at, &bits, 8);
        return 0;
    }
    long long number;
    if (!is_small(value, &number)) {
        int overflow;
        number = PyLong_AsLongLongAndOverflow(value, &overflow);
        if (overflow || (number == -1 && PyErr_Occurred())) return -1;
    }
    if (kind == INT64) {
        uint64_t bits = (uint64_t)number;
        if (swap) bits = swap64(bits);
        memcpy(at, &bits, 8);
    } else if (kind == INT32 || kind == UINT32) {
        if (kind == INT32 ? number < INT32_MIN || number > INT32_MAX : number < 0 || number > UINT32_MAX) return -1;
        store32(at, (uint32_t)number, swap);
    } else if (kind == INT16 || kind == UINT16) {
        if (kind == INT16 ? number < INT16_MIN || number > INT16_MAX : number < 0 || number > UINT16_MAX) return -1;
        store16(at, (uint16_t)number, swap);
    } else {
        if (kind == INT8 ? number < INT8_MIN || number > INT8_MAX : number < 0 || number > UINT8_MAX) return -1;
        *at = (char)number;
    }
    return 0;
}

static int store_number(int kind, char *at, PyObject *value, int swap) {
    switch (kind) {
    case INT8: return store(INT8, at, value, swap);
    case UINT8: return store(UINT8, at, value, swap);
    case INT16: return store(INT16, at, value, swap);
    case UINT16: return store(UINT16, at, value, swap);
    case INT32: return store(INT32, at, value, swap);
    case UINT32: return store(UINT32, at, value, swap);
    case INT64: return store(INT64, at, value, swap);
    case UINT64: return store(UINT64, at, value, swap);
    case FLOAT32: return store(FLOAT32, at, value, swap);
    default: return store(FLOAT64, at, value, swap);
    }
}

static int store_enumerator(const Node *node, char *at, PyObject *value, int swap) {
    if ((PyObject *)Py_TYPE(value) != node->type) {
        if (!PyLong_CheckExact(value)) return -1;
        value = PyDict_GetItemWithError(node->first, value);
        if (value == NULL) return -1;
    }
    return store_number(node->form, at, value, swap);
}

static int store_flags(const Node *node, char *at, PyObject *value, int swap) {
    if (!PyLong_Check(value)) return -1;
    unsigned long long number = PyLong_AsUnsignedLongLong(value);
    if (number == (unsigned long long)-1 && PyErr_Occurred()) return -1;
    if (node->bound < 64 && number >> node->bound) return -1;
    return store_number(node->form, at, value, swap);
}

static int store_hooked(const Node *node, Writer *w, PyObject *value) {
    PyObject *octets = PyObject_CallFunctionObjArgs(node->first, value, w->little ? Py_True : Py_False, NULL);
    if (octets == NULL) return -1;
    int failed = !PyBytes_Check(octets) || PyBytes_GET_SIZE(octets) != node->size;
    if (!failed) memcpy(w->at + w->position, PyBytes_AS_STRING(octets), node->size);
    Py_DECREF(octets);
    return failed ? -1 : 0;
}

/* Stores an atom at the position, for which its octets are reserved. */
static int store_atom(Writer *w, const Node *node, PyObject *value) {
    char *at = w->at + w->position;
    switch (node->kind) {
    case BOOLEAN:
        if (!PyBool_Check(value)) return -1;
        *at = value == Py_True;
        return 0;
    case CHARACTER:
        if (!PyUnicode_CheckExact(value) || PyUnicode_GET_LENGTH(value) != 1 || PyUnicode_READ_CHAR(value, 0) > 0xFF) return -1;
        *at = (char)PyUnicode_READ_CHAR(value, 0);
        return 0;
    case WIDE_CHARACTER:
    case UNIT: {
        if (!PyUnicode_CheckExact(value) || PyUnicode_GET_LENGTH(value) != 1) return -1;
        Py_UCS4 unit = PyUnicode_READ_CHAR(value, 0);
        if (unit > 0xFFFF || (unit >= 0xD800 && unit < 0xE000)) return -1;
        if (node->kind == UNIT) {
            store16(at, (uint16_t)unit, w->swap);
        } else {
            at[0] = 2;
            at[1] = (char)(unit >> 8);
            at[2] = (char)unit;
        }
        return 0;
    }
    case ENUMERATOR: return store_enumerator(node, at, value, w->swap);
    case FLAGS: return store_flags(node, at, value, w->swap);
    case HOOK: return store_hooked(node, w, value);
    default: return store_number(node->kind, at, value, w->swap);
    }
}

#define PUT(kind, size) \
    case kind: \
        if (begin(w, node->align, size) || store(kind, w->at + w->position, value, w->swap)) return -1; \
        w->position += size; \
        return 0

ALWAYS int put_atom(Writer *w, const Node *node, PyObject *value) {
    switch (node->kind) {
    PUT(UINT8, 1);
    PUT(INT16, 2);
    PUT(UINT16, 2);
    PUT(INT32, 4);
    PUT(UINT32, 4);
    PUT(INT64, 8);
    PUT(FLOAT32, 4);
    PUT(FLOAT64, 8);
    default:
        if (begin(w, node->align, node->size) || store_atom(w, node, value)) return -1;
        w->position += node->size;
        return 0;
    }
}

#define STORE_ALL(kind, size) \
    for (Py_ssize_t i = 0; i < count; i++, at += size) \
        if (store(kind, at, items[i], swap)) return -1; \
    return 0

/* Stores numbers at `at`; no Python code runs meanwhile that could change the list. */
static int store_numbers(int kind, char *at, PyObject **items, Py_ssize_t count, int swap) {
    switch (kind) {
    case INT8: STORE_ALL(INT8, 1);
    case UINT8: STORE_ALL(UINT8, 1);
    case INT16: STORE_ALL(INT16, 2);
    case UINT16: STORE_ALL(UINT16, 2);
    case INT32: STORE_ALL(INT32, 4);
    case UINT32: STORE_ALL(UINT32, 4);
    case INT64: STORE_ALL(INT64, 8);
    case UINT64: STORE_ALL(UINT64, 8);
    case FLOAT32: STORE_ALL(FLOAT32, 4);
    default: STORE_ALL(FLOAT64, 8);
    }
}

static int put_items(Writer *w, const Node *atom, PyObject *items) {
    Py_ssize_t count = PySequence_Fast_GET_SIZE(items);
    if (!count) return 0;
    if (count > PY_SSIZE_T_MAX / 32 || begin(w, atom->align, count * atom->size)) return -1;
    if (atom->kind <= FLOAT64) {
        if (store_numbers(atom->kind, w->at + w->position, PySequence_Fast_ITEMS(items), count, w->swap)) return -1;
        w->position += count * atom->size;
        return 0;
    }
    for (Py_ssize_t i = 0; i < count; i++) {
        if (PySequence_Fast_GET_SIZE(items) != count) return -1;
        PyObject *item = Py_NewRef(PySequence_Fast_GET_ITEM(items, i));
        int failed = store_atom(w, atom, item);
        Py_DECREF(item);
        if (failed) return -1;
        w->position += atom->size;
    }
    return 0;
}

/* Returns the numbers of a buffer if they have the machine's own format. */
static int view_of(PyObject *value, const Node *node, Py_buffer *view) {
    const char *name = Py_TYPE(value)->tp_name;
    if ((PyObject *)Py_TYPE(value) != numeric_array && strcmp(name, "array.array") && strcmp(name, "numpy.ndarray")) return -1;
    if (PyObject_GetBuffer(value, view, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS)) return -1;
    const char *format = view->format;
    int fits = 0;
    if (format != NULL && format[0] && !format[1] && view->itemsize == node->child->size) {
        const char *kinds = node->child->kind >= FLOAT32 ? "fd" : node->child->kind & 1 ? "BHILQN" : "bhilqn";
        fits = strchr(kinds, format[0]) != NULL;
    }
    if (!fits) PyBuffer_Release(view);
    return fits ? 0 : -1;
}

static int put_view(Writer *w, const Node *node, Py_buffer *view) {
    const Node *atom = node->child;
    if (!view->len) return 0;
    if (begin(w, atom->align, view->len)) return -1;
    char *at = w->at + w->position;
    memcpy(at, view->buf, view->len);
    if (w->swap) swap_all(at, view->len / atom->size, atom->size);
    w->position += view->len;
    return 0;
}

static int put_rows(Writer *w, const Node *node, PyObject *value, Py_ssize_t depth) {
    if (!PyList_CheckExact(value) && !PyTuple_CheckExact(value)) return -1;
    if (PySequence_Fast_GET_SIZE(value) != node->lengths[depth]) return -1;
    if (depth + 1 == node->dimensions) return put_items(w, node->child, value);
    for (Py_ssize_t i = 0; i < node->lengths[depth]; i++) {
        if (PySequence_Fast_GET_SIZE(value) != node->lengths[depth]) return -1;
        PyObject *row = Py_NewRef(PySequence_Fast_GET_ITEM(value, i));
        int failed = put_rows(w, node, row, depth + 1);
        Py_DECREF(row);
        if (failed) return -1;
    }
    return 0;
}

static int put_numbers(Writer *w, const Node *node, PyObject *value) {
    if (PyList_CheckExact(value) || PyTuple_CheckExact(value)) {
        if (node->dimensions) return put_rows(w, node, value, 0);
        Py_ssize_t count = PySequence_Fast_GET_SIZE(value);
        if ((node->bound >= 0 && count > node->bound) || put_count(w, count)) return -1;
        return put_items(w, node->child, value);
    }
    if (node->child->kind > FLOAT64) return -1;
    Py_buffer view;
    if (view_of(value, node, &view)) return -1;
    int failed = view.ndim != (node->dimensions ? node->dimensions : 1);
    for (Py_ssize_t i = 0; !failed && i < node->dimensions; i++) failed = view.shape[i] != node->lengths[i];
    if (!failed && !node->dimensions) {
        Py_ssize_t count = view.len / node->child->size;
        failed = (node->bound >= 0 && count > node->bound) || put_count(w, count);
    }
    if (!failed) failed = put_view(w, node, &view);
    PyBuffer_Release(&view);
    return failed ? -1 : 0;
}

static int put_latin(Writer *w, const Node *node, PyObject *value) {
    if (!PyUnicode_CheckExact(value) || PyUnicode_KIND(value) != PyUnicode_1BYTE_KIND) return -1;
    Py_ssize_t count = PyUnicode_GET_LENGTH(value);
    if (node->length >= 0 ? count != node->length : (node->bound >= 0 && count > node->bound) || put_count(w, count)) return -1;
    return put_octets(w, (const char *)PyUnicode_1BYTE_DATA(value), count);
}

static int put_bytes(Writer *w, const Node *node, PyObject *value) {
    const char *octets;
    if (PyBytes_CheckExact(value)) octets = PyBytes_AS_STRING(value);
    else if (PyByteArray_CheckExact(value)) octets = PyByteArray_AS_STRING(value);
    else return -1;
    Py_ssize_t count = Py_SIZE(value);
    if (node->length >= 0 ? count != node->length : (node->bound >= 0 && count > node->bound) || put_count(w, count)) return -1;
    return put_octets(w, octets, count);
}

ALWAYS int put_utf8(Writer *w, const Node *node, const char *octets, Py_ssize_t count) {
    if ((node->bound >= 0 && count + 1 > node->bound) || count >= UINT32_MAX || begin_text(w, 4 + count + 1)) return -1;
    char *at = w->at + w->position;
    store32(at, (uint32_t)count + 1, w->swap);
    if (copy_few(at + 4, octets, count) & HAS_NUL) return -1;
    at[4 + count] = 0;
    w->position += 4 + count + 1;
    return 0;
}

NEVER int put_encoded(Writer *w, const Node *node, PyObject *value) {
    PyObject *octets = PyUnicode_AsUTF8String(value);
    if (octets == NULL) return -1;
    int failed = put_utf8(w, node, PyBytes_AS_STRING(octets), PyBytes_GET_SIZE(octets));
    Py_DECREF(octets);
    return failed;
}

static int put_string(Writer *w, const Node *node, PyObject *value) {
    if (!PyUnicode_CheckExact(value)) return -1;
    if (!PyUnicode_IS_COMPACT_ASCII(value)) return put_encoded(w, node, value);
    return put_utf8(w, node, (const char *)PyUnicode_1BYTE_DATA(value), PyUnicode_GET_LENGTH(value));
}

ALWAYS void store_unit(char *at, Py_ssize_t place, uint16_t unit, int swap, int words) {
    if (words) store32(at + 4 * place, unit, swap);
    else store16(at + 2 * place, unit, swap);
}

/* Stores the UTF-16 units of a string, each in two or four octets; returns their number or -1. */
ALWAYS Py_ssize_t units_of(int kind, const void *data, Py_ssize_t length, char *at, int swap, int words) {
    Py_ssize_t units = 0;
    for (Py_ssize_t i = 0; i < length; i++) {
        Py_UCS4 each = PyUnicode_READ(kind, data, i);
        if (!each || (each >= 0xD800 && each < 0xE000)) return -1;
        if (each > 0xFFFF) {
            store_unit(at, units++, (uint16_t)(0xD800 + ((each - 0x10000) >> 10)), swap, words);
            each = 0xDC00 + ((each - 0x10000) & 0x3FF);
        }
        store_unit(at, units++, (uint16_t)each, swap, words);
    }
    return units;
}

static Py_ssize_t store_units(char *at, PyObject *value, int swap, int words) {
    Py_ssize_t length = PyUnicode_GET_LENGTH(value);
    const void *data = PyUnicode_DATA(value);
    switch (PyUnicode_KIND(value)) {
    case PyUnicode_1BYTE_KIND:
        if (scan(data, length) & HAS_NUL) return -1;
        for (Py_ssize_t i = 0; i < length; i++) store_unit(at, i, ((const Py_UCS1 *)data)[i], swap, words);
        return length;
    case PyUnicode_2BYTE_KIND:
        if (swap || words) return units_of(PyUnicode_2BYTE_KIND, data, length, at, swap, words);
        return units_of(PyUnicode_2BYTE_KIND, data, length, at, 0, 0);
    default: return units_of(PyUnicode_4BYTE_KIND, data, length, at, swap, words);
    }
}

/* Begins a `wstring` of that many units with its count and a byte order mark; returns where the units go. */
ALWAYS char *begin_wide(Writer *w, const Node *node, Py_ssize_t length) {
    Py_ssize_t count = 2 + 2 * length;
    if (length > PY_SSIZE_T_MAX / 32 || (node->bound >= 0 && count > node->bound) || count > UINT32_MAX) return NULL;
    if (begin_text(w, 4 + count)) return NULL;
    char *at = w->at + w->position + 6;
    store32(at - 6, (uint32_t)count, w->swap);
    store16(at - 2, 0xFEFF, 0);
    w->position += 4 + count;
    return at;
}

/* Stores eight octets as units, and returns whether NUL is among them. */
ALWAYS int store_eight(char *at, const char *data) {
#ifdef __SSE2__
    __m128i octets = _mm_loadl_epi64((const __m128i *)data);
    _mm_storeu_si128((__m128i *)at, _mm_unpacklo_epi8(octets, _mm_setzero_si128()));
#else
    for (int i = 0; i < 8; i++) {
        at[2 * i] = data[i];
        at[2 * i + 1] = 0;
    }
#endif
    return seen_in(load_word(data)) & HAS_NUL;
}

/* A `wstring` of eight or more characters up to U+00FF. */
static int put_narrow(Writer *w, const Node *node, const char *data, Py_ssize_t length) {
    char *at = begin_wide(w, node, length);
    if (at == NULL) return -1;
    Py_ssize_t last = length - 8;
    int refused = store_eight(at + 2 * last, data + last);
    for (Py_ssize_t i = 0; i < last; i += 8) refused |= store_eight(at + 2 * i, data + i);
    return refused ? -1 : 0;
}

/* Returns the highest bit of each unit that is zero, and of some after such a one. */
ALWAYS uint64_t zeros(uint64_t word) {
    return (word - 0x0001000100010001u) & ~word & 0x8000800080008000u;
}

/* Stores four units; returns 0 unless NUL or a surrogate is among them. */
ALWAYS uint64_t store_four(char *at, const char *data) {
    const uint64_t tops = 0xF800F800F800F800u, surrogates = 0xD800D800D800D800u;
    uint64_t word = load_word(data);
    memcpy(at, &word, 8);
    return zeros(word) | zeros((word & tops) ^ surrogates);
}

/* A `wstring` of four or more characters up to U+FFFF. */
static int put_fours(Writer *w, const Node *node, const char *data, Py_ssize_t length) {
    char *at = begin_wide(w, node, length);
    if (at == NULL) return -1;
    Py_ssize_t last = 2 * (length - 4);
    uint64_t refused = store_four(at + last, data + last);
    for (Py_ssize_t i = 0; i < last; i += 8) refused |= store_four(at + i, data + i);
    return refused ? -1 : 0;
}

NEVER int put_units(Writer *w, const Node *node, PyObject *value) {
    Py_ssize_t length = PyUnicode_GET_LENGTH(value), place = w->position, mark = 0;
    int words = node->kind == WORDS, swap = w->swap;
    if (length > PY_SSIZE_T_MAX / 32 || begin(w, 4, 4 + 2 + 8 * length)) return -1;
    place = w->position;
    char *at = w->at + place + 4;
    if (!words && node->form == WIDE_STRING) {
        swap = !PY_LITTLE_ENDIAN;
        if (length) {
            at[0] = (char)0xFF;
            at[1] = (char)0xFE;
            mark = 2;
        }
    }
    Py_ssize_t units = store_units(at + mark, value, swap, words);
    Py_ssize_t octets = mark + units * (words ? 4 : 2), count = words ? units : octets;
    if (units < 0 || (node->bound >= 0 && count > node->bound) || (uint64_t)count > UINT32_MAX) return -1;
    store32(w->at + place, (uint32_t)count, w->swap);
    w->position += 4 + octets;
    return 0;
}

static int put_wide(Writer *w, const Node *node, PyObject *value) {
    if (!PyUnicode_CheckExact(value)) return -1;
    Py_ssize_t length = PyUnicode_GET_LENGTH(value);
    if (PY_LITTLE_ENDIAN && node->kind == TEXT && node->form == WIDE_STRING) {
        int kind = PyUnicode_KIND(value);
        if (kind == PyUnicode_1BYTE_KIND && length >= 8) return put_narrow(w, node, PyUnicode_DATA(value), length);
        if (kind == PyUnicode_2BYTE_KIND && length >= 4) return put_fours(w, node, PyUnicode_DATA(value), length);
    }
    return put_units(w, node, value);
}

ALWAYS int put_text(Writer *w, const Node *node, PyObject *value) {
    switch (node->form) {
    case OCTETS: return put_bytes(w, node, value);
    case CHARACTERS: return put_latin(w, node, value);
    case STRING: return put_string(w, node, value);
    default: return put_wide(w, node, value);
    }
}

/* What `put` does, with fewer calls. */
ALWAYS int put_member(Writer *w, const Node *node, PyObject *value) {
    if (node->kind == OPTIONAL) {
        if (reserve(w, 1)) return -1;
        w->at[w->position++] = value != Py_None;
        if (value == Py_None) return 0;
        node = node->child;
    }
    if (node->kind <= HOOK) return put_atom(w, node, value);
    return node->kind == TEXT ? put_text(w, node, value) : put(w, node, value);
}

static int put_repeated(Writer *w, const Node *node, PyObject *value) {
    if (!PyList_CheckExact(value) && !PyTuple_CheckExact(value)) return -1;
    Py_ssize_t count = PySequence_Fast_GET_SIZE(value);
    if (node->length >= 0 ? count != node->length : (node->bound >= 0 && count > node->bound) || put_count(w, count)) return -1;
    for (Py_ssize_t i = 0; i < count; i++) {
        if (PySequence_Fast_GET_SIZE(value) != count) return -1;
        PyObject *item = Py_NewRef(PySequence_Fast_GET_ITEM(value, i));
        int failed = put_member(w, node->child, item);
        Py_DECREF(item);
        if (failed) return -1;
    }
    return 0;
}

static int put_map(Writer *w, const Node *node, PyObject *value) {
    if (!PyDict_CheckExact(value)) return -1;
    Py_ssize_t count = PyDict_GET_SIZE(value), place = 0;
    if ((node->bound >= 0 && count > node->bound) || put_count(w, count)) return -1;
    PyObject *key, *item;
    Py_ssize_t seen = 0;
    while (PyDict_Next(value, &place, &key, &item)) {
        Py_INCREF(key);
        Py_INCREF(item);
        int failed = ++seen > count || put_member(w, node->key, key) || put_member(w, node->child, item);
        Py_DECREF(key);
        Py_DECREF(item);
        if (failed || PyDict_GET_SIZE(value) != count) return -1;
    }
    return seen == count ? 0 : -1;
}

/* Returns a new reference to an attribute of a value. */
ALWAYS PyObject *attribute(const Node *node, const Member *member, PyObject *value) {
    if (!node->plain) return PyObject_GetAttr(value, member->name);
    return Py_XNewRef(*(PyObject **)((char *)value + member->offset));
}

static int put_struct(Writer *w, const Node *node, PyObject *value) {
    if ((PyObject *)Py_TYPE(value) != node->type) return -1;
    for (Py_ssize_t i = 0; i < node->count; i++) {
        PyObject *inner = attribute(node, &node->members[i], value);
        if (inner == NULL) return -1;
        int failed = put_member(w, node->members[i].node, inner);
        Py_DECREF(inner);
        if (failed) return -1;
    }
    return 0;
}

static int put_union(Writer *w, const Node *node, PyObject *value) {
    if ((PyObject *)Py_TYPE(value) != node->type) return -1;
    PyObject *discriminator = attribute(node, &node->members[0], value);
    PyObject *inner = discriminator == NULL ? NULL : attribute(node, &node->members[1], value);
    int64_t number;
    int failed = inner == NULL || put(w, node->child, discriminator) || union_number(discriminator, &number);
    if (!failed) {
        const Node *branch = branch_of(node, number);
        failed = branch == NULL ? inner != Py_None : put(w, branch, inner);
    }
    Py_XDECREF(discriminator);
    Py_XDECREF(inner);
    return failed ? -1 : 0;
}

/* Reserves the length before a value; `put_length` stores it. */
ALWAYS int begin_length(Writer *w, Py_ssize_t *start) {
    if (begin(w, 4, 4)) return -1;
    w->position += 4;
    *start = w->position;
    return 0;
}

ALWAYS int put_length(Writer *w, Py_ssize_t start) {
    if ((uint64_t)(w->position - start) > UINT32_MAX) return -1;
    store32(w->at + start - 4, (uint32_t)(w->position - start), w->swap);
    return 0;
}

/* A member's value in XCDR1, whose alignment counts from its beginning; None has no octets. */
static int put_parameter(Writer *w, const Node *node, uint32_t flags, PyObject *value, int in_list) {
    if (begin(w, 4, 12)) return -1;
    store16(w->at + w->position, PID_EXTENDED | SHORT_MUST_UNDERSTAND, w->swap);
    store16(w->at + w->position + 2, 8, w->swap);
    store32(w->at + w->position + 4, flags, w->swap);
    w->position += 12;
    Py_ssize_t start = w->position, base = w->base;
    if (value != Py_None || in_list) {
        w->base = start;
        if (put(w, node, value) || (in_list && begin(w, 4, 0))) return -1;
        w->base = base;
    }
    return put_length(w, start);
}

static int put_listed(Writer *w, const Node *node, const Member *member, PyObject *value) {
    if (member->optional && value == Py_None) return 0;
    if (node->version == 1) {
        uint32_t flags = member->id | (member->must_understand ? LONG_MUST_UNDERSTAND : 0);
        return put_parameter(w, member->node, flags, value, 1);
    }
    if (begin(w, 4, 4)) return -1;
    store32(w->at + w->position, member->header, w->swap);
    w->position += 4;
    if ((member->header >> 28 & 7) != 4) return put_member(w, member->node, value);
    Py_ssize_t start;
    return begin_length(w, &start) || put(w, member->node, value) || put_length(w, start) ? -1 : 0;
}

static int put_list(Writer *w, const Node *node, PyObject *value) {
    if ((PyObject *)Py_TYPE(value) != node->type) return -1;
    for (Py_ssize_t i = 0; i < node->count; i++) {
        PyObject *inner = attribute(node, &node->members[i], value);
        if (inner == NULL) return -1;
        int failed = put_listed(w, node, &node->members[i], inner);
        Py_DECREF(inner);
        if (failed) return -1;
    }
    if (node->version == 2) return 0;
    if (begin(w, 4, 4)) return -1;
    store16(w->at + w->position, PID_LIST_END | SHORT_MUST_UNDERSTAND, w->swap);
    store16(w->at + w->position + 2, 0, w->swap);
    w->position += 4;
    return 0;
}

static int put_delimited(Writer *w, const Node *node, PyObject *value) {
    Py_ssize_t start;
    if (begin_length(w, &start)) return -1;
    return (node->child->kind == STRUCT ? put_struct(w, node->child, value) : put(w, node->child, value)) || put_length(w, start) ? -1 : 0;
}

NEVER int put_nested(Writer *w, const Node *node, PyObject *value) {
    switch (node->kind) {
    case TEXT: return put_text(w, node, value);
    case WORDS: return put_wide(w, node, value);
    case NUMBERS: return put_numbers(w, node, value);
    case REPEAT: return put_repeated(w, node, value);
    case MAP: return put_map(w, node, value);
    case STRUCT: return put_struct(w, node, value);
    case UNION: return put_union(w, node, value);
    case LIST: return put_list(w, node, value);
    case OPTIONAL: return put_member(w, node, value);
    case PARAMETER: {
        uint32_t flags = node->id | (node->must_understand ? LONG_MUST_UNDERSTAND : 0);
        return put_parameter(w, node->child, flags, value, 0);
    }
    case ANY: return put_any(w, value);
    default: return -1;
    }
}

/* Appends octets that begin at a multiple of 4. */
int put_aligned(Writer *w, const char *octets, Py_ssize_t count) {
    return begin(w, 4, 0) ? -1 : put_octets(w, octets, count);
}

int put(Writer *w, const Node *node, PyObject *value) {
    if (node->kind <= HOOK) return put_atom(w, node, value);
    if (node->kind == TEXT) return put_text(w, node, value);
    if (++w->depth > MAX_DEPTH) return -1;
    int failed = node->kind == STRUCT ? put_struct(w, node, value) : node->kind == DELIMITED ? put_delimited(w, node, value) : put_nested(w, node, value);
    w->depth--;
    return failed;
}
