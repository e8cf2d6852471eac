/* Reads values from octets, as `rtgen.runtime.marshalling.source.decoder` does.
 *
 * Each read is preceded by a comparison with the octets that are left.
 */
#include "codec.h"

#define EMPTY_ELEMENTS 65536
#define MEMBER_ID 0x0FFFFFFFu
#define LONG_IMPLEMENTATION 0x80000000u
#define LONG_MUST_UNDERSTAND 0x40000000u

/* Skips padding; fails unless that many octets follow. */
ALWAYS int begin(Reader *r, Py_ssize_t align, Py_ssize_t size) {
    r->position += (r->base - r->position) & (align - 1);
    return size <= r->end - r->position ? 0 : -1;
}

ALWAYS uint16_t load16(const unsigned char *at, int swap) {
    uint16_t n;
    memcpy(&n, at, 2);
    return swap ? swap16(n) : n;
}

ALWAYS uint32_t load32(const unsigned char *at, int swap) {
    uint32_t n;
    memcpy(&n, at, 4);
    return swap ? swap32(n) : n;
}

ALWAYS uint64_t load64(const unsigned char *at, int swap) {
    uint64_t n;
    memcpy(&n, at, 8);
    return swap ? swap64(n) : n;
}

ALWAYS int take_count(Reader *r, Py_ssize_t *count) {
    if (begin(r, 4, 4)) return -1;
    uint32_t n = load32(r->data + r->position, r->swap);
    r->position += 4;
    *count = (Py_ssize_t)n;
    return *count >= 0 ? 0 : -1;
}

#define FEWEST (-5)
#define SMALL 262

static PyObject *small_numbers[SMALL];  /* as the interpreter has them */

int add_numbers(void) {
    for (long i = 0; i < SMALL; i++)
        if ((small_numbers[i] = PyLong_FromLong(FEWEST + i)) == NULL) return -1;
    return 0;
}

ALWAYS PyObject *integer(int64_t number) {
    uint64_t place = (uint64_t)number - FEWEST;
    return place < SMALL ? Py_NewRef(small_numbers[place]) : PyLong_FromLongLong(number);
}

ALWAYS PyObject *load(int kind, const unsigned char *at, int swap) {
    switch (kind) {
    case INT8: return integer((int8_t)*at);
    case UINT8: return integer(*at);
    case INT16: return integer((int16_t)load16(at, swap));
    case UINT16: return integer(load16(at, swap));
    case INT32: return integer((int32_t)load32(at, swap));
    case UINT32: return integer(load32(at, swap));
    case INT64: return integer((int64_t)load64(at, swap));
    case UINT64: return PyLong_FromUnsignedLongLong(load64(at, swap));
    case FLOAT32: {
        uint32_t bits = load32(at, swap);
        if ((bits & 0x7F800000u) != 0x7F800000u) {  /* finite */
            float single;
            memcpy(&single, &bits, 4);
            return PyFloat_FromDouble(single);
        }
        double number = PyFloat_Unpack4((const char *)at, swap ? !PY_LITTLE_ENDIAN : PY_LITTLE_ENDIAN);
        return number == -1.0 && PyErr_Occurred() ? NULL : PyFloat_FromDouble(number);
    }
    default: {
        uint64_t bits = load64(at, swap);
        double number;
        memcpy(&number, &bits, 8);
        return PyFloat_FromDouble(number);
    }
    }
}

static PyObject *load_number(int kind, const unsigned char *at, int swap) {
    return load(kind, at, swap);
}

static PyObject *load_keyed(const Node *node, const unsigned char *at, int swap) {
    if (node->enumerators != NULL && (node->form == UINT32 || node->form == INT32)) {
        uint32_t place = load32(at, swap);
        return place < node->enumerator_count ? Py_XNewRef(node->enumerators[place]) : NULL;
    }
    PyObject *number = load_number(node->form, at, swap);
    if (number == NULL) return NULL;
    PyObject *found = NULL;
    if (node->kind == FLAGS && node->bound < 64) {
        unsigned long long bits = PyLong_AsUnsignedLongLong(number);
        if (bits >> node->bound) goto done;
    }
    found = Py_XNewRef(PyDict_GetItemWithError(node->first, number));
    if (found == NULL && node->kind == FLAGS && !PyErr_Occurred()) found = PyObject_CallOneArg(node->type, number);
done:
    Py_DECREF(number);
    return found;
}

static PyObject *load_hooked(const Node *node, const unsigned char *at, int little) {
    PyObject *octets = PyBytes_FromStringAndSize((const char *)at, node->size);
    if (octets == NULL) return NULL;
    PyObject *value = PyObject_CallFunctionObjArgs(node->second, octets, little ? Py_True : Py_False, NULL);
    Py_DECREF(octets);
    return value;
}

static PyObject *load_atom(Reader *r, const Node *node, const unsigned char *at) {
    switch (node->kind) {
    case BOOLEAN: return *at > 1 ? NULL : Py_NewRef(*at ? Py_True : Py_False);
    case CHARACTER: return PyUnicode_FromOrdinal(*at);
    case WIDE_CHARACTER:
    case UNIT: {
        if (node->kind == WIDE_CHARACTER && at[0] != 2) return NULL;
        int unit = node->kind == UNIT ? load16(at, r->swap) : at[1] << 8 | at[2];
        return unit >= 0xD800 && unit < 0xE000 ? NULL : PyUnicode_FromOrdinal(unit);
    }
    case ENUMERATOR:
    case FLAGS: return load_keyed(node, at, r->swap);
    case HOOK: return load_hooked(node, at, r->little);
    default: return load_number(node->kind, at, r->swap);
    }
}

#define TAKE(kind, size) \
    case kind: \
        if (begin(r, node->align, size)) return NULL; \
        r->position += size; \
        return load(kind, r->data + r->position - size, r->swap)

ALWAYS PyObject *take_atom(Reader *r, const Node *node) {
    switch (node->kind) {
    TAKE(UINT8, 1);
    TAKE(INT16, 2);
    TAKE(UINT16, 2);
    TAKE(INT32, 4);
    TAKE(UINT32, 4);
    TAKE(INT64, 8);
    TAKE(FLOAT32, 4);
    TAKE(FLOAT64, 8);
    default: break;
    }
    if (begin(r, node->align, node->size)) return NULL;
    const unsigned char *at = r->data + r->position;
    r->position += node->size;
    return load_atom(r, node, at);
}

#define LOAD_ALL(kind, size) \
    for (Py_ssize_t i = 0; i < count; i++, at += size) { \
        PyObject *item = load(kind, at, swap); \
        if (item == NULL) return -1; \
        PyList_SET_ITEM(list, i, item); \
    } \
    return 0

static int load_numbers(int kind, PyObject *list, Py_ssize_t count, const unsigned char *at, int swap) {
    switch (kind) {
    case INT8: LOAD_ALL(INT8, 1);
    case UINT8: LOAD_ALL(UINT8, 1);
    case INT16: LOAD_ALL(INT16, 2);
    case UINT16: LOAD_ALL(UINT16, 2);
    case INT32: LOAD_ALL(INT32, 4);
    case UINT32: LOAD_ALL(UINT32, 4);
    case INT64: LOAD_ALL(INT64, 8);
    case UINT64: LOAD_ALL(UINT64, 8);
    case FLOAT32: LOAD_ALL(FLOAT32, 4);
    default: LOAD_ALL(FLOAT64, 8);
    }
}

/* A list of atoms whose octets are at the position. */
static PyObject *load_items(Reader *r, const Node *atom, Py_ssize_t count) {
    PyObject *list = PyList_New(count);
    if (list == NULL) return NULL;
    const unsigned char *at = r->data + r->position;
    r->position += count * atom->size;
    if (atom->kind <= FLOAT64) {
        if (load_numbers(atom->kind, list, count, at, r->swap)) Py_CLEAR(list);
        return list;
    }
    for (Py_ssize_t i = 0; i < count; i++, at += atom->size) {
        PyObject *item = load_atom(r, atom, at);
        if (item == NULL) {
            Py_DECREF(list);
            return NULL;
        }
        PyList_SET_ITEM(list, i, item);
    }
    return list;
}

static PyObject *load_rows(Reader *r, const Node *node, Py_ssize_t depth) {
    if (depth + 1 == node->dimensions) return load_items(r, node->child, node->lengths[depth]);
    PyObject *list = PyList_New(node->lengths[depth]);
    for (Py_ssize_t i = 0; list != NULL && i < node->lengths[depth]; i++) {
        PyObject *row = load_rows(r, node, depth + 1);
        if (row == NULL) Py_CLEAR(list);
        else PyList_SET_ITEM(list, i, row);
    }
    return list;
}

/* Appends octets to an array without a copy of them, and swaps its numbers. */
static int fill(PyObject *array, const Node *node, const unsigned char *at, Py_ssize_t size, int swap) {
    PyObject *view = PyMemoryView_FromMemory((char *)at, size, PyBUF_READ);
    PyObject *result = view == NULL ? NULL : PyObject_CallMethod(array, "frombytes", "O", view);
    Py_XDECREF(view);
    if (result == NULL) return -1;
    Py_DECREF(result);
    if (!swap) return 0;
    Py_buffer numbers;
    if (PyObject_GetBuffer(array, &numbers, PyBUF_WRITABLE)) return -1;
    swap_all(numbers.buf, numbers.len / node->child->size, node->child->size);
    PyBuffer_Release(&numbers);
    return 0;
}

/* Numbers as an array of rtgen. */
static PyObject *array_of(const Node *node, const unsigned char *at, Py_ssize_t size, int swap) {
    PyObject *code = PyUnicode_FromOrdinal(node->code);
    PyObject *made = code == NULL || numeric_array == NULL ? NULL : PyObject_CallOneArg(numeric_array, code);
    Py_XDECREF(code);
    if (made != NULL && size && fill(made, node, at, size, swap)) Py_CLEAR(made);
    return made;
}

static PyObject *take_numbers(Reader *r, const Node *node) {
    Py_ssize_t count = node->length, size = node->child->size;
    if (!node->dimensions && (take_count(r, &count) || (node->bound >= 0 && count > node->bound))) return NULL;
    if (count && (count > (r->end - r->position) / size || begin(r, node->child->align, count * size))) return NULL;
    if (node->dimensions > 1 && node->form == AS_LIST) return load_rows(r, node, 0);
    int is_short = node->form == AS_ARRAY && !node->dimensions && count <= node->minimum;
    if (node->form == AS_LIST || is_short) return load_items(r, node->child, count);
    const unsigned char *at = r->data + r->position;
    r->position += count * size;
    if (node->form == AS_ARRAY) return array_of(node, at, count * size, r->swap);
    PyObject *octets = PyByteArray_FromStringAndSize((const char *)at, count * size);
    if (octets == NULL) return NULL;
    if (r->swap) swap_all(PyByteArray_AS_STRING(octets), count, size);
    PyObject *made = PyObject_CallOneArg(node->first, octets);
    Py_DECREF(octets);
    return made;
}

/* A string of UTF-16 units without NUL: `each` is the size of a unit, 2 or 4. */
ALWAYS PyObject *text_from(const unsigned char *at, Py_ssize_t count, int each, int swap) {
    Py_UCS4 most = 0, nul = 0, pairs = 0;
    for (Py_ssize_t i = 0; i < count; i++) {  /* without a branch, so that it is vectorized */
        Py_UCS4 unit = each == 2 ? load16(at + 2 * i, swap) : load32(at + 4 * i, swap);
        nul |= unit == 0;
        pairs |= (unit & 0xFFFFF800) == 0xD800;
        most |= unit;
    }
    if (nul || most > 0xFFFF) return NULL;
    if (pairs && each == 2) {
        int order = (PY_LITTLE_ENDIAN ? !swap : swap) ? -1 : 1;
        return PyUnicode_DecodeUTF16((const char *)at, 2 * count, "strict", &order);
    }
    if (pairs) return NULL;
    PyObject *text = PyUnicode_New(count, most);
    if (text == NULL) return NULL;
    Py_UCS1 *narrow = PyUnicode_DATA(text);
    Py_UCS2 *wide = PyUnicode_DATA(text);
    if (most < 0x100)
        for (Py_ssize_t i = 0; i < count; i++) narrow[i] = (Py_UCS1)(each == 2 ? load16(at + 2 * i, swap) : load32(at + 4 * i, swap));
    else
        for (Py_ssize_t i = 0; i < count; i++) wide[i] = (Py_UCS2)(each == 2 ? load16(at + 2 * i, swap) : load32(at + 4 * i, swap));
    return text;
}

static PyObject *text_of_units(const unsigned char *at, Py_ssize_t count, int each, int swap) {
    if (each == 4) return text_from(at, count, 4, swap);
    return swap ? text_from(at, count, 2, 1) : text_from(at, count, 2, 0);
}

static PyObject *wide_text(const Node *node, const unsigned char *at, Py_ssize_t size) {
    int little = 0;
    if (size >= 2 && ((at[0] == 0xFF && at[1] == 0xFE) || (at[0] == 0xFE && at[1] == 0xFF))) {
        little = at[0] == 0xFF;
        at += 2;
        size -= 2;
    }
    if (size & 1 || (node->bound >= 0 && size > node->bound - 2)) return NULL;
    return text_of_units(at, size / 2, 2, PY_LITTLE_ENDIAN ? !little : little);
}

static PyObject *take_string(Reader *r, const Node *node) {
    Py_ssize_t count;
    if (take_count(r, &count) || (node->bound >= 0 && count > node->bound) || count > r->end - r->position) return NULL;
    if (!count) return PyUnicode_New(0, 0);
    const char *octets = (const char *)r->data + r->position;
    r->position += count--;
    int seen = octets[count] ? HAS_NUL : scan(octets, count);
    if (seen & HAS_NUL) return NULL;
    if (seen || count < 2) return PyUnicode_DecodeUTF8(octets, count, "strict");
    PyObject *text = PyUnicode_New(count, 127);
    if (text != NULL) copy_few((char *)PyUnicode_1BYTE_DATA(text), octets, count);
    return text;
}

static PyObject *take_text(Reader *r, const Node *node) {
    if (node->form == STRING) return take_string(r, node);
    Py_ssize_t count = node->length;
    if (count < 0 && (take_count(r, &count) || (node->bound >= 0 && count > node->bound))) return NULL;
    if (count > r->end - r->position) return NULL;
    const unsigned char *at = r->data + r->position;
    const char *octets = (const char *)at;
    r->position += count;
    switch (node->form) {
    case OCTETS: return PyBytes_FromStringAndSize(octets, count);
    case CHARACTERS: return PyUnicode_DecodeLatin1(octets, count, "strict");
    case WIDE_STRING: return wide_text(node, at, count);
    default: return count & 1 ? NULL : text_of_units(at, count / 2, 2, r->swap);
    }
}

static PyObject *take_words(Reader *r, const Node *node) {
    Py_ssize_t count;
    if (take_count(r, &count) || (node->bound >= 0 && count > node->bound)) return NULL;
    if (count > (r->end - r->position) / 4) return NULL;
    const unsigned char *at = r->data + r->position;
    r->position += 4 * count;
    return text_of_units(at, count, 4, r->swap);
}

/* What `take` returns, with fewer calls. */
ALWAYS PyObject *take_member(Reader *r, const Node *node) {
    if (node->kind == OPTIONAL) {
        if (r->end - r->position < 1 || r->data[r->position] > 1) return NULL;
        if (!r->data[r->position++]) return Py_NewRef(Py_None);
        node = node->child;
    }
    if (node->kind <= HOOK) return take_atom(r, node);
    return node->kind == TEXT ? take_text(r, node) : take(r, node);
}

/* Takes the count of a collection, and compares it with the octets that are left. */
static int take_repetitions(Reader *r, const Node *node, Py_ssize_t *count) {
    *count = node->length;
    if (node->length >= 0) return 0;
    if (take_count(r, count) || (node->bound >= 0 && *count > node->bound)) return -1;
    Py_ssize_t most = node->minimum ? (r->end - r->position) / node->minimum : EMPTY_ELEMENTS;
    return *count > most ? -1 : 0;
}

static PyObject *take_repeated(Reader *r, const Node *node) {
    Py_ssize_t count;
    if (take_repetitions(r, node, &count)) return NULL;
    if (node->length >= 0 && node->minimum && count > (r->end - r->position) / node->minimum) return NULL;
    PyObject *list = PyList_New(count);
    if (list == NULL) return NULL;
    for (Py_ssize_t i = 0; i < count; i++) {
        PyObject *item = take(r, node->child);
        if (item == NULL) {
            Py_DECREF(list);
            return NULL;
        }
        PyList_SET_ITEM(list, i, item);
    }
    return list;
}

#define CACHED_KEYS 256
#define LONGEST_KEY 32

static PyObject *cached_keys[CACHED_KEYS];

/* A string that is a key of a map; keys come again and again, and a string keeps its hash. */
static PyObject *take_key(Reader *r, const Node *node) {
    Py_ssize_t before = r->position, count;
    if (node->kind != TEXT || node->form != STRING) return take(r, node);
    if (take_count(r, &count) || count > r->end - r->position) return NULL;
    const char *octets = (const char *)r->data + r->position;
    r->position = before;
    if (count < 9 || count > LONGEST_KEY + 1 || octets[count - 1]) return take_text(r, node);
    uint64_t hash = count;
    for (Py_ssize_t i = 0; i < count - 8; i += 8) hash = (hash ^ load_word(octets + i)) * 0x9E3779B97F4A7C15u;
    hash = (hash ^ load_word(octets + count - 8)) * 0x9E3779B97F4A7C15u;
    PyObject **place = &cached_keys[hash >> 56], *key = *place;
    if (key != NULL && PyUnicode_GET_LENGTH(key) == count - 1 && !memcmp(PyUnicode_1BYTE_DATA(key), octets, count - 1) &&
        (node->bound < 0 || count <= node->bound)) {
        begin(r, 4, 4);
        r->position += 4 + count;
        return Py_NewRef(key);
    }
    key = take_text(r, node);
    if (key != NULL && PyUnicode_IS_COMPACT_ASCII(key)) {
        PyObject *older = *place;
        *place = Py_NewRef(key);
        Py_XDECREF(older);
    }
    return key;
}

#if PY_VERSION_HEX < 0x030D0000
#define MOST_PRESIZED 1024
static PyObject *new_map(Py_ssize_t count) { return _PyDict_NewPresized(count < MOST_PRESIZED ? count : MOST_PRESIZED); }
#else
static PyObject *new_map(Py_ssize_t count) { return PyDict_New(); }
#endif

static PyObject *take_map(Reader *r, const Node *node) {
    Py_ssize_t count;
    if (take_repetitions(r, node, &count)) return NULL;
    PyObject *map = new_map(count);
    for (Py_ssize_t i = 0; map != NULL && i < count; i++) {
        PyObject *key = take_key(r, node->key);
        PyObject *item = key == NULL ? NULL : take_member(r, node->child);
        if (item == NULL || PyDict_SetItem(map, key, item)) Py_CLEAR(map);
        Py_XDECREF(key);
        Py_XDECREF(item);
    }
    if (map != NULL && PyDict_GET_SIZE(map) != count) Py_CLEAR(map);
    return map;
}

/* Structs with more members are made by a list of their values on the heap. */
#define FEW 32

/* Returns a place for the values of members, which is `few` unless they are more; NULL if there is none. */
ALWAYS PyObject **places(const Node *node, PyObject **few) {
    PyObject **values = node->count > FEW ? PyMem_Malloc(node->count * sizeof(PyObject *)) : few;
    if (values == NULL) PyErr_NoMemory();
    return values;
}

static PyObject *take_struct(Reader *r, const Node *node) {
    PyObject *few[FEW], **values = places(node, few), *made = NULL;
    Py_ssize_t i;
    if (values == NULL) return NULL;
    for (i = 0; i < node->count; i++) {
        values[i] = take_member(r, node->members[i].node);
        if (values[i] == NULL) break;
    }
    if (i == node->count) made = instance(node, values);
    else while (i--) Py_DECREF(values[i]);
    if (values != few) PyMem_Free(values);
    return made;
}

static PyObject *take_union(Reader *r, const Node *node) {
    int64_t number;
    PyObject *values[2] = {take(r, node->child), NULL};
    if (values[0] == NULL) return NULL;
    if (!union_number(values[0], &number)) {
        const Node *branch = branch_of(node, number);
        values[1] = branch == NULL ? Py_NewRef(Py_None) : take(r, branch);
    }
    if (values[1] != NULL) return instance(node, values);
    Py_DECREF(values[0]);
    return NULL;
}

typedef struct {
    uint32_t id;
    int must_understand, ends;
    Py_ssize_t stop;
} Header;

/* DDS-XTypes 1.3, 7.4.3.4.2; `next_member` of layouts/headers.py. */
static int take_member_header(Reader *r, Py_ssize_t end, Header *header) {
    static const int sizes[] = {1, 4, 8};
    if (begin(r, 4, 4)) return -1;
    uint32_t number = load32(r->data + r->position, r->swap);
    uint32_t code = number >> 28 & 7;
    int64_t size = (int64_t)1 << code;
    r->position += 4;
    if (code >= 4) {
        if (r->end - r->position < 4) return -1;
        size = load32(r->data + r->position, r->swap);
        if (code == 4) r->position += 4;
        else size = 4 + size * sizes[code - 5];
    }
    if (size > end - r->position) return -1;
    header->id = number & MEMBER_ID;
    header->must_understand = number >> 31;
    header->ends = 0;
    header->stop = r->position + (Py_ssize_t)size;
    return 0;
}

/* DDS-XTypes 1.3, 7.4.1.2; `next_parameter` of layouts/headers.py. */
static int take_parameter_header(Reader *r, Header *header) {
    if (begin(r, 4, 4)) return -1;
    uint32_t pid = load16(r->data + r->position, r->swap), size = load16(r->data + r->position + 2, r->swap);
    r->position += 4;
    header->must_understand = (pid & 0x4000) != 0;
    header->ends = 0;
    uint32_t masked = pid & ~0x4000u;
    if (masked == 0x3F02) {
        header->ends = 1;
        return 0;
    }
    if (masked == 0x3F01) {
        if (size != 8 || r->end - r->position < 8) return -1;
        uint32_t flags = load32(r->data + r->position, r->swap);
        size = load32(r->data + r->position + 4, r->swap);
        r->position += 8;
        header->must_understand = (flags & LONG_MUST_UNDERSTAND) != 0;
        masked = flags & (MEMBER_ID | LONG_IMPLEMENTATION);
    } else if (masked == 0x3F03) {
        masked = LONG_IMPLEMENTATION;
    } else if (masked & 0x8000) {
        masked = (masked & ~0x8000u) | LONG_IMPLEMENTATION;
    }
    if ((int64_t)size > r->end - r->position) return -1;
    header->id = masked;
    header->stop = r->position + (Py_ssize_t)size;
    return 0;
}

/* The value of a parameter, whose octets are all that it sees, and which it fills except for padding. */
static PyObject *take_content(Reader *r, const Node *node, Py_ssize_t stop, Py_ssize_t padding) {
    Py_ssize_t end = r->end, base = r->base;
    r->base = r->position;
    r->end = stop;
    PyObject *value = take(r, node);
    if (value != NULL && (r->position > stop || stop - r->position > padding)) Py_CLEAR(value);
    r->position = stop;
    r->base = base;
    r->end = end;
    return value;
}

static PyObject *take_parameter(Reader *r, const Node *node) {
    Header header;
    if (take_parameter_header(r, &header) || header.ends || header.id != node->id) return NULL;
    if (r->position == header.stop) return Py_NewRef(Py_None);
    return take_content(r, node->child, header.stop, 0);
}

static const Member *member_of(const Node *node, uint32_t id, Py_ssize_t *likely) {
    for (Py_ssize_t i = 0, place = *likely; i < node->count; i++, place++) {
        if (place == node->count) place = 0;
        if (node->members[place].id == id) {
            *likely = place + 1;
            return &node->members[place];
        }
    }
    return NULL;
}

static int take_listed(Reader *r, const Node *node, Py_ssize_t end, PyObject **values) {
    Py_ssize_t likely = 0;
    for (;;) {
        Header header;
        if (node->version == 2) {
            if (r->position >= end) return r->position == end ? 0 : -1;
            if (take_member_header(r, end, &header)) return -1;
        } else {
            if (take_parameter_header(r, &header)) return -1;
            if (header.ends) return 0;
        }
        const Member *member = member_of(node, header.id, &likely);
        if (member == NULL) {
            if (header.must_understand) return -1;
            r->position = header.stop;
            continue;
        }
        PyObject **value = &values[member - node->members];
        if (*value != NULL) return -1;
        if (node->version == 1) *value = take_content(r, member->node, header.stop, 3);
        else *value = take_member(r, member->node);
        if (*value == NULL || r->position != header.stop) return -1;
    }
}

/* An instance with the members that were there; the class has defaults for the others. */
static PyObject *partial_instance(const Node *node, PyObject **values) {
    PyObject *keywords = PyDict_New(), *none = PyTuple_New(0), *made = NULL;
    int failed = keywords == NULL || none == NULL;
    for (Py_ssize_t i = 0; i < node->count && !failed; i++)
        if (values[i] != NULL) failed = PyDict_SetItem(keywords, node->members[i].name, values[i]);
    if (!failed) made = PyObject_Call(node->type, none, keywords);
    Py_XDECREF(keywords);
    Py_XDECREF(none);
    for (Py_ssize_t i = 0; i < node->count; i++) Py_XDECREF(values[i]);
    return made;
}

static PyObject *take_list(Reader *r, const Node *node, Py_ssize_t end) {
    PyObject *few[FEW], **values = places(node, few), *made = NULL;
    if (values == NULL) return NULL;
    for (Py_ssize_t i = 0; i < node->count; i++) values[i] = NULL;
    int failed = end > r->end || take_listed(r, node, end, values), whole = 1;
    for (Py_ssize_t i = 0; i < node->count; i++) {
        whole &= values[i] != NULL;
        failed |= values[i] == NULL && node->members[i].key;
    }
    if (!failed) made = whole ? instance(node, values) : partial_instance(node, values);
    else for (Py_ssize_t i = 0; i < node->count; i++) Py_XDECREF(values[i]);
    if (values != few) PyMem_Free(values);
    return made;
}

static PyObject *take_delimited(Reader *r, const Node *node) {
    Py_ssize_t size;
    if (take_count(r, &size) || size > r->end - r->position) return NULL;
    Py_ssize_t end = r->position + size;
    if (node->child->kind == LIST) return take_list(r, node->child, end);
    PyObject *value = node->child->kind == STRUCT ? take_struct(r, node->child) : take(r, node->child);
    if (value != NULL && r->position != end) Py_CLEAR(value);
    return value;
}

NEVER PyObject *take_nested(Reader *r, const Node *node) {
    switch (node->kind) {
    case WORDS: return take_words(r, node);
    case NUMBERS: return take_numbers(r, node);
    case REPEAT: return take_repeated(r, node);
    case MAP: return take_map(r, node);
    case STRUCT: return take_struct(r, node);
    case UNION: return take_union(r, node);
    case LIST: return node->version == 1 ? take_list(r, node, r->end) : NULL;
    case DELIMITED: return take_delimited(r, node);
    case OPTIONAL: return take_member(r, node);
    case PARAMETER: return take_parameter(r, node);
    case ANY: return take_any(r);
    default: return NULL;
    }
}

/* Returns the size of the type code at the position, which becomes a multiple of 4; -1 if there is none. */
Py_ssize_t type_code_size(Reader *r) {
    enum { OBJREF = 14, STRING_CODE = 18, WSTRING_CODE = 27, FIXED_CODE = 28, NATIVE = 31, EVENT = 36 };
    if (begin(r, 4, 4)) return -1;
    const unsigned char *at = r->data + r->position;
    uint32_t kind = load32(at, r->swap);
    Py_ssize_t left = r->end - r->position;
    if (kind > EVENT) return -1;
    if (kind < OBJREF || (kind > 22 && kind < WSTRING_CODE)) return 4;
    if (left < 8) return -1;
    if (kind == STRING_CODE || kind == WSTRING_CODE || kind == FIXED_CODE) return 8;
    uint32_t size = load32(at + 4, r->swap);
    return kind != NATIVE && (int64_t)size <= left - 8 ? 8 + (Py_ssize_t)size : -1;
}

PyObject *take(Reader *r, const Node *node) {
    if (node->kind <= HOOK) return take_atom(r, node);
    if (node->kind == TEXT) return take_text(r, node);
    if (++r->depth > MAX_DEPTH) return NULL;
    PyObject *value = node->kind == STRUCT ? take_struct(r, node) : take_nested(r, node);
    r->depth--;
    return value;
}
