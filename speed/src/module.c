/* Codecs: callables that take the place of the functions compiled from Python text.
 *
 * What a table does not cover (a value of another class, a number out of range, octets that are not
 * of the type) is left to the Python function of the same kind, so that errors are its.
 */
#include "codec.h"
#include <stddef.h>

static PyObject *little_endian_name = NULL;

static int codec_traverse(Codec *self, visitproc visit, void *arg) {
    Py_VISIT(self->table);
    Py_VISIT(self->make);
    Py_VISIT(self->function);
    return 0;
}

static int codec_clear(Codec *self) {
    Py_CLEAR(self->make);
    Py_CLEAR(self->function);
    return 0;
}

static void codec_dealloc(Codec *self) {
    PyObject_GC_UnTrack(self);
    codec_clear(self);
    Py_CLEAR(self->table);
    Py_CLEAR(self->name);
    Py_TYPE(self)->tp_free((PyObject *)self);
}

static PyObject *function_of(Codec *self) {
    if (self->function == NULL) {
        if (self->make == NULL) return PyErr_SetString(PyExc_RuntimeError, "the codec was collected"), NULL;
        PyObject *made = PyObject_CallNoArgs(self->make);
        if (made == NULL) return NULL;
        if (self->function == NULL) self->function = Py_NewRef(made);
        Py_DECREF(made);
    }
    return Py_NewRef(self->function);
}

/* Calls the Python function, unless something else than a failure of the codec happened. */
NEVER PyObject *in_python(Codec *self, PyObject *const *args, size_t count, PyObject *names) {
    if (PyErr_Occurred()) {
        if (!PyErr_ExceptionMatches(PyExc_Exception)) return NULL;
        PyErr_Clear();
    }
    PyObject *function = function_of(self);
    if (function == NULL) return NULL;
    PyObject *result = PyObject_Vectorcall(function, args, count, names);
    Py_DECREF(function);
    return result;
}

#define SPARE 32

/* Values of a type mostly need as many octets as the one before: those are written where they stay. */
static int begin_writing(Writer *w, int little, Py_ssize_t likely) {
    w->octets = likely ? PyBytes_FromStringAndSize(NULL, likely) : NULL;
    if (likely && w->octets == NULL) return -1;
    w->at = likely ? PyBytes_AS_STRING(w->octets) : w->few;
    w->capacity = (likely ? likely : (Py_ssize_t)sizeof w->few) - PADDING;
    w->position = w->base = w->depth = 0;
    w->little = little;
    w->swap = little != PY_LITTLE_ENDIAN;
    return 0;
}

static PyObject *written(Writer *w, int identifier) {
    if (identifier >= 0) {
        Py_ssize_t padding = -(w->position - 4) & 3;
        char head[4] = {0, (char)(identifier | w->little), 0, (char)padding};
        memcpy(w->at, head, 4);
        memset(w->at + w->position, 0, padding);
        w->position += padding;
    }
    if (w->octets == NULL) return PyBytes_FromStringAndSize(w->at, w->position);
    Py_ssize_t spare = PyBytes_GET_SIZE(w->octets) - w->position;
    if (spare > SPARE || !w->position) {
        if (_PyBytes_Resize(&w->octets, w->position)) return NULL;
    } else {
        Py_SET_SIZE((PyVarObject *)w->octets, w->position);
        w->at[w->position] = 0;
    }
    PyObject *octets = w->octets;
    w->octets = NULL;
    return octets;
}

static PyObject *encode(Codec *self, PyObject *value, int little) {
    Writer w;
    if (begin_writing(&w, little, self->likely)) return NULL;
    if (self->identifier >= 0) w.position = w.base = 4;
    PyObject *octets = NULL;
    if (!put(&w, self->root, value)) {
        octets = written(&w, self->identifier);
        self->likely = w.position < (Py_ssize_t)sizeof w.few ? w.position + SPARE : 0;
    }
    Py_XDECREF(w.octets);
    return octets;
}

/* Opens bytearrays and views of octets; others are left to Python. */
static int open_octets(PyObject *data, Py_buffer *view) {
    if (PyByteArray_CheckExact(data)) return PyObject_GetBuffer(data, view, PyBUF_SIMPLE);
    if (!PyMemoryView_Check(data) || PyObject_GetBuffer(data, view, PyBUF_FULL_RO)) return -1;
    int fits = view->ndim == 1 && view->itemsize == 1 && view->format != NULL && !strcmp(view->format, "B") &&
               (view->strides == NULL || view->strides[0] == 1) && view->suboffsets == NULL;
    if (!fits) PyBuffer_Release(view);
    return fits ? 0 : -1;
}

static PyObject *decode(Codec *self, PyObject *data, Py_ssize_t offset, int little) {
    Py_buffer view;
    if (PyBytes_Check(data)) {  /* the caller has a reference, and the octets stay as they are */
        view.obj = NULL;
        view.buf = PyBytes_AS_STRING(data);
        view.len = PyBytes_GET_SIZE(data);
    } else if (open_octets(data, &view)) {
        return NULL;
    }
    Reader r = {view.buf, offset, view.len, 0, little != PY_LITTLE_ENDIAN, little, 0};
    PyObject *value = offset < 0 || offset > view.len ? NULL : take(&r, self->root);
    if (value != NULL && self->mode == DECODE && r.position != r.end) Py_CLEAR(value);
    if (value != NULL && self->mode == READ) value = Py_BuildValue("Nn", value, r.position);
    if (view.obj != NULL) PyBuffer_Release(&view);
    return value;
}

static int is_true(PyObject *value) { return value == Py_True ? 1 : value == Py_False ? 0 : PyObject_IsTrue(value); }

/* Returns whether the octets are little-endian, from the argument after `count` others; -1 if the
 * arguments are others. */
static int order_of(PyObject *const *args, Py_ssize_t given, Py_ssize_t count, PyObject *names) {
    Py_ssize_t named = names == NULL ? 0 : PyTuple_GET_SIZE(names);
    if (given == count && !named) return 1;
    if (given + named != count + 1 || named > 1) return -1;
    if (named) {
        PyObject *name = PyTuple_GET_ITEM(names, 0);
        if (name != little_endian_name && PyUnicode_Compare(name, little_endian_name)) return -1;
    }
    return is_true(args[count]);
}

static PyObject *codec_call(PyObject *callable, PyObject *const *args, size_t nargsf, PyObject *names) {
    Codec *self = (Codec *)callable;
    Py_ssize_t given = PyVectorcall_NARGS(nargsf);
    PyObject *result = NULL;
    int little;
    if (self->mode == ENCODE && given == 1 && names == NULL) {
        result = encode(self, args[0], 1);
        return result != NULL ? result : in_python(self, args, nargsf, names);
    }
    switch (self->mode) {
    case ENCODE:
        little = order_of(args, given, 1, names);
        if (little >= 0) result = encode(self, args[0], little);
        break;
    case DECODE:
    case DECODE_PREFIX:
        little = order_of(args, given, 2, names);
        if (little >= 0 && (!self->again || args[0] == self->root->type ||
                            (self->root->kind == DELIMITED && args[0] == self->root->child->type)))
            result = decode(self, args[1], 0, little);
        break;
    case READ:
        if (given == 3 && names == NULL && PyLong_Check(args[1])) {
            little = is_true(args[2]);
            Py_ssize_t offset = PyLong_AsSsize_t(args[1]);
            if (little >= 0 && !(offset == -1 && PyErr_Occurred())) result = decode(self, args[0], offset, little);
        }
        break;
    case COPY:
        if (given == 1 && names == NULL) result = copy(self->root, args[0], 0);
        break;
    }
    return result != NULL ? result : in_python(self, args, nargsf, names);
}

static PyObject *codec_get(PyObject *self, PyObject *object, PyObject *type) {
    return object == NULL || object == Py_None ? Py_NewRef(self) : PyMethod_New(self, object);
}

static PyObject *codec_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
    static char *names[] = {"table", "root", "mode", "identifier", "bound", "name", "make", NULL};
    PyObject *table, *name, *make;
    Py_ssize_t root;
    int mode, identifier, bound;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!niipUO", names, &Table_Type, &table, &root, &mode, &identifier,
                                     &bound, &name, &make)) return NULL;
    if (root < 0 || root >= ((Table *)table)->count || mode < ENCODE || mode > COPY)
        return PyErr_SetString(PyExc_ValueError, "no such node or mode"), NULL;
    Codec *self = (Codec *)type->tp_alloc(type, 0);
    if (self == NULL) return NULL;
    self->call = codec_call;
    self->table = (Table *)Py_NewRef(table);
    self->root = &self->table->nodes[root];
    self->mode = mode;
    self->identifier = identifier;
    self->again = bound;
    self->name = Py_NewRef(name);
    self->make = Py_NewRef(make);
    return (PyObject *)self;
}

static PyObject *codec_repr(Codec *self) { return PyUnicode_FromFormat("<codec %U in C>", self->name); }

static PyObject *codec_function(Codec *self, void *closure) { return function_of(self); }

static PyObject *codec_name(Codec *self, void *closure) { return Py_NewRef(self->name); }

static PyObject *call(PyObject *self, PyObject *const *args, Py_ssize_t given, PyObject *names) {
    return codec_call(self, args, given, names);
}

static PyMethodDef direct = {"call", (PyCFunction)(void (*)(void))call, METH_FASTCALL | METH_KEYWORDS, NULL};

static PyObject *codec_direct(Codec *self, void *closure) { return PyCFunction_New(&direct, (PyObject *)self); }

static PyGetSetDef codec_attributes[] = {
    {"direct", (getter)codec_direct, NULL, "A function with the same calls, which the interpreter has fewer steps for.", NULL},
    {"__wrapped__", (getter)codec_function, NULL, "The function in Python.", NULL},
    {"__name__", (getter)codec_name, NULL, NULL, NULL},
    {NULL, NULL, NULL, NULL, NULL},
};

PyTypeObject Codec_Type = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "rtgen_speed.Codec",
    .tp_basicsize = sizeof(Codec),
    .tp_dealloc = (destructor)codec_dealloc,
    .tp_vectorcall_offset = offsetof(Codec, call),
    .tp_repr = (reprfunc)codec_repr,
    .tp_call = PyVectorcall_Call,
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_HAVE_VECTORCALL | Py_TPFLAGS_METHOD_DESCRIPTOR,
    .tp_doc = "An encoder, decoder or copier of a type.",
    .tp_traverse = (traverseproc)codec_traverse,
    .tp_clear = (inquiry)codec_clear,
    .tp_getset = codec_attributes,
    .tp_descr_get = codec_get,
    .tp_new = codec_new,
};

static PyObject *set_numeric_array(PyObject *module, PyObject *class) {
    PyObject *before = numeric_array;
    numeric_array = Py_NewRef(class);
    Py_XDECREF(before);
    Py_RETURN_NONE;
}

static PyObject *set_any(PyObject *module, PyObject *args) {
    Anys given = {0};
    if (anys.class != NULL) Py_RETURN_NONE;
    if (!PyArg_ParseTuple(args, "O!(O!O!)O(O!O!)O", &PyType_Type, &given.class, &PyDict_Type, &given.heads[0], &PyDict_Type,
                          &given.heads[1], &given.make_head, &PyDict_Type, &given.types[0], &PyDict_Type, &given.types[1],
                          &given.make_type)) return NULL;
    PyObject *type = PyUnicode_FromString("type"), *value = PyUnicode_FromString("value");
    given.type_offset = type == NULL ? -1 : slot_of((PyTypeObject *)given.class, type);
    given.value_offset = value == NULL ? -1 : slot_of((PyTypeObject *)given.class, value);
    Py_XDECREF(type);
    Py_XDECREF(value);
    if (given.type_offset < 0 || given.value_offset < 0) return PyErr_SetString(PyExc_TypeError, "no slots"), NULL;
    for (int i = 0; i < 2; i++) {
        Py_INCREF(given.heads[i]);
        Py_INCREF(given.types[i]);
    }
    Py_INCREF(given.class);
    Py_INCREF(given.make_head);
    Py_INCREF(given.make_type);
    anys = given;
    Py_RETURN_NONE;
}

#ifdef RTGEN_EXPLORER
#include "explorer.c"
#endif

static PyMethodDef functions[] = {
#ifdef RTGEN_EXPLORER
    {"explore", explore, METH_VARARGS, "Decodes changed octets; returns how many were refused, values, and values not encoded."},
#endif
    {"set_any", set_any, METH_VARARGS, "Sets the class of `any`, and the tables and makers of its types."},
    {"set_numeric_array", set_numeric_array, METH_O, "Sets the class of arrays of numbers."},
    {NULL, NULL, 0, NULL},
};

static const char *const kinds[KINDS] = {
    "INT8", "UINT8", "INT16", "UINT16", "INT32", "UINT32", "INT64", "UINT64", "FLOAT32", "FLOAT64",
    "BOOLEAN", "CHARACTER", "WIDE_CHARACTER", "UNIT", "ENUMERATOR", "FLAGS", "HOOK",
    "NUMBERS", "TEXT", "WORDS", "REPEAT", "MAP", "STRUCT", "UNION", "DELIMITED", "OPTIONAL", "LIST", "PARAMETER", "ANY",
};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, .m_name = "rtgen_speed", .m_size = -1, .m_methods = functions,
    .m_doc = "Encoders, decoders and copiers of rtgen's types.",
};

PyMODINIT_FUNC PyInit_rtgen_speed(void) {
    if (PyType_Ready(&Table_Type) || PyType_Ready(&Codec_Type)) return NULL;
    little_endian_name = PyUnicode_InternFromString("little_endian");
    PyObject *module = PyModule_Create(&definition);
    if (module == NULL || little_endian_name == NULL) return NULL;
    int failed = PyModule_AddObjectRef(module, "Table", (PyObject *)&Table_Type) ||
                 PyModule_AddObjectRef(module, "Codec", (PyObject *)&Codec_Type) ||
                 PyModule_AddIntConstant(module, "INTERFACE", 3) || add_ports(module) || add_numbers();
    for (int kind = 0; kind < KINDS && !failed; kind++) failed = PyModule_AddIntConstant(module, kinds[kind], kind);
    if (!failed) return module;
    Py_DECREF(module);
    return NULL;
}
