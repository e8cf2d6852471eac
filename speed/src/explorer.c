/* Explores a type with changed octets, many thousands a call; only in a module built with the sanitizers
 * (`tests/sanitized.py`), of which this text is a part.
 */

enum { CHANGES = 40, LONGEST = 1000 };
enum Outcome { REFUSED, VALUES, READ_ONLY, OUTCOMES };

typedef struct {
    uint64_t chance;
    int little;
    Py_ssize_t length;
    unsigned char octets[LONGEST + 80];
} Changed;

static uint32_t below(Changed *c, uint32_t bound) {
    c->chance ^= c->chance << 13;
    c->chance ^= c->chance >> 7;
    c->chance ^= c->chance << 17;
    return (uint32_t)((c->chance >> 32) * bound >> 32);
}

static void put_in_place(Changed *c, Py_ssize_t place, Py_ssize_t removed, const void *octets, Py_ssize_t count) {
    Py_ssize_t rest = c->length - place - removed;
    if (rest < 0) rest = 0;
    memmove(c->octets + place + count, c->octets + c->length - rest, rest);
    memcpy(c->octets + place, octets, count);
    c->length = place + count + rest < LONGEST ? place + count + rest : LONGEST;
}

static void put_counted(Changed *c, Py_ssize_t place, uint32_t count, const char *octets, Py_ssize_t size) {
    char block[64] = {0};
    uint32_t number = c->little != PY_LITTLE_ENDIAN ? swap32(count) : count;
    memcpy(block, &number, 4);
    if (octets != NULL) memcpy(block + 4, octets, count);
    put_in_place(c, place, 4, block, 4 + size);
}

/* Makes a change: a count with octets for its elements, a number, a string, or a few octets anywhere. */
static void change(Changed *c) {
    static const uint32_t counts[] = {0, 0, 1, 1, 1, 2, 3, 4, 5, 8, 255, 1 << 16, INT32_MAX, 1u << 31, UINT32_MAX};
    static const unsigned char sizes[] = {0, 1, 2, 3, 4, 7, 8, 12, 16, 20, 24, 32, 40, 48, 56};
    static const char *const texts[] = {"", "a", "abc", "\xe3\x81\x82", "\xff"};
    static const unsigned char edges[] = {0, 1, 4, 0x7f, 0x80, 0xff};
    Py_ssize_t place = below(c, (uint32_t)c->length + 1), whole = place & ~(Py_ssize_t)3;
    unsigned char few[8];
    switch (below(c, 10)) {
    case 0:
    case 1:
    case 2: put_counted(c, whole, 1 + below(c, 3), NULL, sizes[below(c, 15)]); break;
    case 3: put_counted(c, whole, counts[below(c, 15)], NULL, 0); break;
    case 4: {
        const char *text = texts[below(c, 5)];
        uint32_t size = (uint32_t)strlen(text) + 1;
        put_counted(c, whole, size, text, (size + 3) & ~3u);
        break;
    }
    case 5:
    case 6: {
        Py_ssize_t count = 1 + below(c, 8), removed = below(c, 2) ? 0 : count;
        for (Py_ssize_t i = 0; i < count; i++) few[i] = (unsigned char)below(c, 256);
        put_in_place(c, place, removed, few, count);
        break;
    }
    case 7: put_in_place(c, place, (Py_ssize_t)1 << below(c, 4), few, 0); break;
    case 8: c->length = place; break;
    default: put_in_place(c, place, 1, edges + below(c, 6), 1);
    }
}

/* Decodes octets in a block of their very length. */
static PyObject *exact(Codec *decoder, const void *octets, Py_ssize_t count, int little) {
    unsigned char *block = malloc(count);
    if (block == NULL && count) return PyErr_NoMemory();
    memcpy(block, octets, count);
    Reader r = {block, 0, count, 0, little != PY_LITTLE_ENDIAN, little, 0};
    PyObject *value = take(&r, decoder->root);
    if (value != NULL && r.position != r.end) Py_CLEAR(value);
    free(block);
    return value;
}

/* Returns whether another value, if there is one, is encoded as these octets; takes the reference. */
static int same_octets(Codec *encoder, PyObject *value, PyObject *octets, int little) {
    PyObject *again = value == NULL ? NULL : encode(encoder, value, little);
    Py_XDECREF(value);
    if (again == NULL) PyErr_Clear();
    int same = again == NULL || PyObject_RichCompareBool(again, octets, Py_EQ);
    Py_XDECREF(again);
    return same;
}

/* Returns what became of octets: one of the outcomes, or -1 with an exception. */
static int outcome_of(Codec *decoder, Codec *encoder, Codec *copier, Changed *c) {
    PyObject *value = exact(decoder, c->octets, c->length, c->little);
    if (value == NULL) return REFUSED;
    PyObject *octets = encode(encoder, value, c->little);
    int same = 1;
    if (octets != NULL) {
        PyObject *read = exact(decoder, PyBytes_AS_STRING(octets), PyBytes_GET_SIZE(octets), c->little);
        same = same_octets(encoder, read, octets, c->little) &&
               same_octets(encoder, copy(copier->root, value, 0), octets, c->little);
        if (!same) PyErr_Format(PyExc_AssertionError, "%U: another value of %R", decoder->name, octets);
    }
    Py_DECREF(value);
    Py_XDECREF(octets);
    return !same ? -1 : octets == NULL ? READ_ONLY : VALUES;
}

static PyObject *explore(PyObject *module, PyObject *args) {
    Codec *decoder, *encoder, *copier;
    Py_buffer least;
    Py_ssize_t inputs, outcomes[OUTCOMES] = {0};
    unsigned long long seed;
    Changed c;
    if (!PyArg_ParseTuple(args, "O!O!O!y*pKn", &Codec_Type, &decoder, &Codec_Type, &encoder, &Codec_Type, &copier, &least,
                          &c.little, &seed, &inputs)) return NULL;
    c.chance = seed * 0x9E3779B97F4A7C15u + 1;
    Py_ssize_t length = least.len < LONGEST ? least.len : LONGEST;
    unsigned char grown[LONGEST];
    for (Py_ssize_t i = 0; i < inputs; i++) {
        if (i % CHANGES == 0) {
            memcpy(grown, least.buf, length);
            c.length = length;
        }
        Py_ssize_t before = c.length;
        memcpy(c.octets, grown, before);
        change(&c);
        int outcome = outcome_of(decoder, encoder, copier, &c);
        if (PyErr_Occurred()) {
            if (outcome < 0 || !PyErr_ExceptionMatches(PyExc_Exception)) break;
            PyErr_Clear();
        }
        outcomes[outcome]++;
        if (outcome == REFUSED) c.length = before;
        else memcpy(grown, c.octets, c.length);
    }
    PyBuffer_Release(&least);
    if (PyErr_Occurred()) return NULL;
    return Py_BuildValue("nnn", outcomes[REFUSED], outcomes[VALUES], outcomes[READ_ONLY]);
}
