/* Values of `any`: after the octets of a type code, which are kept with the table of their type. */
#include "codec.h"

Anys anys;

int put_aligned(Writer *, const char *octets, Py_ssize_t count);
Py_ssize_t type_code_size(Reader *);

/* Returns the entry of a key, a new reference; `make` adds it, or returns None. */
static PyObject *entry_of(PyObject *table, PyObject *key, PyObject *make, PyObject *argument, int little) {
    PyObject *entry = Py_XNewRef(PyDict_GetItemWithError(table, key));
    if (entry == NULL && !PyErr_Occurred())
        entry = PyObject_CallFunctionObjArgs(make, argument, little ? Py_True : Py_False, NULL);
    if (entry == NULL) return NULL;
    PyObject *codec = PyTuple_Check(entry) && PyTuple_GET_SIZE(entry) == 3 ? PyTuple_GET_ITEM(entry, 2) : NULL;
    if (codec != NULL && (codec == Py_None || Py_IS_TYPE(codec, &Codec_Type))) return entry;
    Py_DECREF(entry);
    return NULL;
}

static int put_content(Writer *w, PyObject *type, PyObject *value) {
    PyObject *key = PyLong_FromVoidPtr(type);
    if (key == NULL) return -1;
    PyObject *entry = entry_of(anys.heads[w->little], key, anys.make_head, type, w->little);
    Py_DECREF(key);
    if (entry == NULL) return -1;
    PyObject *head = PyTuple_GET_ITEM(entry, 1), *codec = PyTuple_GET_ITEM(entry, 2);
    int failed = PyTuple_GET_ITEM(entry, 0) != type || !PyBytes_Check(head) ||
                 put_aligned(w, PyBytes_AS_STRING(head), PyBytes_GET_SIZE(head));
    if (!failed) failed = codec == Py_None ? value != Py_None : put(w, ((Codec *)codec)->root, value);
    Py_DECREF(entry);
    return failed ? -1 : 0;
}

int put_any(Writer *w, PyObject *value) {
    if (anys.class == NULL || (PyObject *)Py_TYPE(value) != anys.class) return -1;
    PyObject *type = Py_XNewRef(*(PyObject **)((char *)value + anys.type_offset));
    PyObject *inner = Py_XNewRef(*(PyObject **)((char *)value + anys.value_offset));
    int failed = type == NULL || inner == NULL || put_content(w, type, inner);
    Py_XDECREF(type);
    Py_XDECREF(inner);
    return failed ? -1 : 0;
}

static PyObject *any_of(PyObject *type, PyObject *value) {
    PyTypeObject *class = (PyTypeObject *)anys.class;
    PyObject *made = class->tp_alloc(class, 0);
    if (made == NULL) {
        Py_DECREF(value);
        return NULL;
    }
    *(PyObject **)((char *)made + anys.type_offset) = Py_NewRef(type);
    *(PyObject **)((char *)made + anys.value_offset) = value;
    return made;
}

PyObject *take_any(Reader *r) {
    if (anys.class == NULL) return NULL;
    Py_ssize_t size = type_code_size(r);
    PyObject *key = size < 0 ? NULL : PyBytes_FromStringAndSize((const char *)r->data + r->position, size);
    if (key == NULL) return NULL;
    PyObject *entry = entry_of(anys.types[r->little], key, anys.make_type, key, r->little), *value = NULL;
    Py_DECREF(key);
    if (entry == NULL) return NULL;
    r->position += size;
    PyObject *codec = PyTuple_GET_ITEM(entry, 2);
    value = codec == Py_None ? Py_NewRef(Py_None) : take(r, ((Codec *)codec)->root);
    if (value != NULL) value = any_of(PyTuple_GET_ITEM(entry, 0), value);
    Py_DECREF(entry);
    return value;
}
