/* What data ports do for each sample in one thread, as `rtgen.runtime.ports.data_ports` does.
 *
 * What is rare (another class, a full buffer that refuses, an empty one) is left to Python.
 */
#include "codec.h"
#include <stddef.h>

static PyTypeObject *deque_type = NULL;
static PyCFunction deque_popleft = NULL;
static PyObject *move_name = NULL, *write_moved_name = NULL, *overwritten_name = NULL, *spare_name = NULL;

/* The way of a sample into the buffer of a connection: `DataConnector.short_way`. */
typedef struct {
    PyObject_HEAD
    vectorcallfunc call;
    PyTypeObject *type;     /* of the samples */
    PyObject *samples, *snapshot, *send, *buffer, *append, *drop, *done, *reader;
    Py_ssize_t spare;       /* offset of the attribute of `reader` with a sample that nothing else refers to, or -1 */
    PyCFunction add;        /* of `append`, if that is a method of C */
    const Node *copied;     /* of `snapshot`, if that is a codec */
    Py_ssize_t length;
    int overwrites;
} Way;

static PyObject **slot(PyObject *self, Py_ssize_t offset) { return (PyObject **)((char *)self + offset); }

static PyObject *snapshot_of(Way *self, PyObject *value) {
    if (self->copied != NULL) {
        PyObject *spare = NULL;
        if (self->spare >= 0) {
            spare = *slot(self->reader, self->spare);
            *slot(self->reader, self->spare) = NULL;
        }
        PyObject *made = copy_over(self->copied, value, spare);
        if (made != NULL) return made;
        if (PyErr_Occurred()) {
            if (!PyErr_ExceptionMatches(PyExc_Exception)) return NULL;
            PyErr_Clear();
        }
    }
    return PyObject_CallOneArg(self->snapshot, value);
}

/* Removes the oldest sample, and counts it. */
static int overwrite(Way *self) {
    PyObject *dropped = PyObject_CallNoArgs(self->drop);
    Py_XDECREF(dropped);
    PyObject *before = dropped == NULL ? NULL : PyObject_GetAttr(self->buffer, overwritten_name);
    PyObject *one = before == NULL ? NULL : PyLong_FromLong(1);
    PyObject *count = one == NULL ? NULL : PyNumber_Add(before, one);
    int failed = count == NULL || PyObject_SetAttr(self->buffer, overwritten_name, count);
    Py_XDECREF(before);
    Py_XDECREF(one);
    Py_XDECREF(count);
    return failed ? -1 : 0;
}

static PyObject *send(Way *self, PyObject *value) {
    int full = Py_SIZE(self->samples) >= self->length;
    if (Py_TYPE(value) != self->type || (full && !self->overwrites)) return PyObject_CallOneArg(self->send, value);
    PyObject *sample = snapshot_of(self, value), *added = NULL;
    if (sample == NULL) return NULL;
    if (!full || !overwrite(self))
        added = self->add != NULL ? self->add(self->samples, sample) : PyObject_CallOneArg(self->append, sample);
    Py_DECREF(sample);
    if (added == NULL) return NULL;
    Py_DECREF(added);
    return Py_NewRef(self->done);
}

static PyObject *way_call(PyObject *self, PyObject *const *args, size_t nargsf, PyObject *names) {
    if (PyVectorcall_NARGS(nargsf) == 1 && names == NULL) return send((Way *)self, args[0]);
    return PyErr_SetString(PyExc_TypeError, "one sample is needed"), NULL;
}

static int way_traverse(Way *self, visitproc visit, void *arg) {
    Py_VISIT(self->type);
    Py_VISIT(self->samples);
    Py_VISIT(self->snapshot);
    Py_VISIT(self->send);
    Py_VISIT(self->buffer);
    Py_VISIT(self->append);
    Py_VISIT(self->drop);
    Py_VISIT(self->done);
    Py_VISIT(self->reader);
    return 0;
}

/* There is no `tp_clear`: a cycle of references leads over the connection, which can be cleared. */
static void way_dealloc(Way *self) {
    PyObject_GC_UnTrack(self);
    Py_CLEAR(self->type);
    Py_CLEAR(self->samples);
    Py_CLEAR(self->snapshot);
    Py_CLEAR(self->send);
    Py_CLEAR(self->buffer);
    Py_CLEAR(self->append);
    Py_CLEAR(self->drop);
    Py_CLEAR(self->done);
    Py_CLEAR(self->reader);
    Py_TYPE(self)->tp_free((PyObject *)self);
}

static PyObject *way_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
    static char *names[] = {"type", "samples", "length", "overwrites", "snapshot", "send", "buffer", "drop", "done", "reader", NULL};
    Way given;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!O!npOOOOOO", names, &PyType_Type, &given.type, deque_type, &given.samples,
                                     &given.length, &given.overwrites, &given.snapshot, &given.send, &given.buffer,
                                     &given.drop, &given.done, &given.reader)) return NULL;
    PyObject *append = PyObject_GetAttrString(given.samples, "append");
    Way *self = append == NULL ? NULL : (Way *)type->tp_alloc(type, 0);
    if (self == NULL) return Py_XDECREF(append), NULL;
    self->call = way_call;
    self->type = (PyTypeObject *)Py_NewRef(given.type);
    self->samples = Py_NewRef(given.samples);
    self->length = given.length;
    self->overwrites = given.overwrites;
    self->snapshot = Py_NewRef(given.snapshot);
    self->send = Py_NewRef(given.send);
    self->buffer = Py_NewRef(given.buffer);
    self->drop = Py_NewRef(given.drop);
    self->done = Py_NewRef(given.done);
    self->reader = Py_NewRef(given.reader);
    self->spare = slot_of(Py_TYPE(given.reader), spare_name);
    self->append = append;
    if (PyCFunction_CheckExact(append) && PyCFunction_GET_FLAGS(append) == METH_O) self->add = PyCFunction_GET_FUNCTION(append);
    Codec *codec = (Codec *)given.snapshot;
    if (Py_IS_TYPE(given.snapshot, &Codec_Type) && codec->mode == COPY) self->copied = codec->root;
    return (PyObject *)self;
}

static PyTypeObject Way_Type = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "rtgen_speed.Way",
    .tp_basicsize = sizeof(Way),
    .tp_dealloc = (destructor)way_dealloc,
    .tp_vectorcall_offset = offsetof(Way, call),
    .tp_call = PyVectorcall_Call,
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_HAVE_VECTORCALL,
    .tp_doc = "Puts snapshots of samples into the buffer of a connection.",
    .tp_traverse = (traverseproc)way_traverse,
    .tp_new = way_new,
};

enum PortMethod { WRITE, PORT_READ, IS_NEW };

/* A method of ports, in the place of a function. */
typedef struct {
    PyObject_HEAD
    vectorcallfunc call;
    PyTypeObject *class;
    PyObject *function;
    Py_ssize_t slot, last, spare;  /* offsets of the attributes */
    Py_ssize_t sole;        /* references to an argument that one variable refers to, or 0 */
    enum PortMethod kind;
} Method;

/* Returns the result, or NULL without an exception if the function has to be called. */
static PyObject *write_sample(Method *self, PyObject *const *args, PyObject *names) {
    PyObject *port = args[0], *value = args[1], *way = *slot(port, self->slot);
    if (way == NULL) return NULL;
    if (names != NULL) {
        if (PyTuple_GET_SIZE(names) != 1 || PyUnicode_Compare(PyTuple_GET_ITEM(names, 0), move_name)) return NULL;
        int moves = PyObject_IsTrue(args[2]);
        if (moves < 0) return NULL;
        if (moves && Py_REFCNT(value) <= self->sole) return PyObject_CallMethodOneArg(port, write_moved_name, value);
    }
    Py_INCREF(way);
    PyObject *result = Py_IS_TYPE(way, &Way_Type) ? send((Way *)way, value) : PyObject_CallOneArg(way, value);
    Py_DECREF(way);
    return result;
}

static PyObject *method_call(PyObject *callable, PyObject *const *args, size_t nargsf, PyObject *names) {
    Method *self = (Method *)callable;
    Py_ssize_t given = PyVectorcall_NARGS(nargsf);
    PyObject *result = NULL, *samples;
    if (given == (self->kind == WRITE ? 2 : 1) && PyObject_TypeCheck(args[0], self->class)) {
        if (self->kind == WRITE) {
            result = write_sample(self, args, names);
        } else if (names == NULL) {
            samples = *slot(args[0], self->slot);
            if (samples == NULL || !Py_IS_TYPE(samples, deque_type) || !Py_SIZE(samples)) {
            } else if (self->kind == IS_NEW) {
                result = Py_NewRef(Py_True);
            } else if ((result = deque_popleft(samples, NULL)) != NULL) {
                PyObject **last = slot(args[0], self->last), *before = *last;
                *last = Py_NewRef(result);
                if (before != NULL && Py_REFCNT(before) == 1 && self->spare >= 0) {
                    last = slot(args[0], self->spare);
                    Py_XSETREF(*last, before);
                } else {
                    Py_XDECREF(before);
                }
            }
        }
    }
    return result != NULL || PyErr_Occurred() ? result : PyObject_Vectorcall(self->function, args, nargsf, names);
}

static PyObject *method_get(PyObject *self, PyObject *object, PyObject *type) {
    return object == NULL || object == Py_None ? Py_NewRef(self) : PyMethod_New(self, object);
}

static int method_traverse(Method *self, visitproc visit, void *arg) {
    Py_VISIT(self->class);
    Py_VISIT(self->function);
    return 0;
}

static void method_dealloc(Method *self) {
    PyObject_GC_UnTrack(self);
    Py_CLEAR(self->class);
    Py_CLEAR(self->function);
    Py_TYPE(self)->tp_free((PyObject *)self);
}

static PyObject *method_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
    static char *names[] = {"class", "kind", "function", "slot", "last", "sole", NULL};
    PyTypeObject *class;
    PyObject *function, *name, *last;
    Py_ssize_t sole;
    int kind;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!iOUUn", names, &PyType_Type, &class, &kind, &function, &name, &last,
                                     &sole)) return NULL;
    Py_ssize_t place = slot_of(class, name), place_of_last = slot_of(class, last);
    if (place < 0 || place_of_last < 0 || kind < WRITE || kind > IS_NEW)
        return PyErr_SetString(PyExc_ValueError, "no such slot or method"), NULL;
    Method *self = (Method *)type->tp_alloc(type, 0);
    if (self == NULL) return NULL;
    self->call = method_call;
    self->class = (PyTypeObject *)Py_NewRef(class);
    self->function = Py_NewRef(function);
    self->slot = place;
    self->last = place_of_last;
    self->spare = kind == PORT_READ ? slot_of(class, spare_name) : -1;
    self->sole = sole;
    self->kind = (enum PortMethod)kind;
    return (PyObject *)self;
}

static PyObject *method_wrapped(Method *self, void *closure) { return Py_NewRef(self->function); }

static PyObject *method_attribute(Method *self, void *name) { return PyObject_GetAttrString(self->function, name); }

static PyGetSetDef method_attributes[] = {
    {"__wrapped__", (getter)method_wrapped, NULL, "The function in Python.", NULL},
    {"__doc__", (getter)method_attribute, NULL, NULL, "__doc__"},
    {"__name__", (getter)method_attribute, NULL, NULL, "__name__"},
    {"__qualname__", (getter)method_attribute, NULL, NULL, "__qualname__"},
    {"__module__", (getter)method_attribute, NULL, NULL, "__module__"},
    {NULL, NULL, NULL, NULL, NULL},
};

static PyTypeObject Method_Type = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "rtgen_speed.Method",
    .tp_basicsize = sizeof(Method),
    .tp_dealloc = (destructor)method_dealloc,
    .tp_vectorcall_offset = offsetof(Method, call),
    .tp_call = PyVectorcall_Call,
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_HAVE_VECTORCALL | Py_TPFLAGS_METHOD_DESCRIPTOR,
    .tp_traverse = (traverseproc)method_traverse,
    .tp_getset = method_attributes,
    .tp_descr_get = method_get,
    .tp_new = method_new,
};

/* Adds the types to the module. */
int add_ports(PyObject *module) {
    PyObject *collections = PyImport_ImportModule("collections");
    PyObject *deque = collections == NULL ? NULL : PyObject_GetAttrString(collections, "deque");
    PyObject *popleft = deque == NULL ? NULL : PyObject_GetAttrString(deque, "popleft");
    Py_XDECREF(collections);
    if (popleft == NULL || !PyType_Check(deque) || !Py_IS_TYPE(popleft, &PyMethodDescr_Type)) return -1;
    deque_type = (PyTypeObject *)deque;
    deque_popleft = ((PyMethodDescrObject *)popleft)->d_method->ml_meth;
    Py_DECREF(popleft);
    move_name = PyUnicode_InternFromString("move");
    write_moved_name = PyUnicode_InternFromString("_write_moved");
    overwritten_name = PyUnicode_InternFromString("overwritten");
    spare_name = PyUnicode_InternFromString("_spare");
    if (spare_name == NULL || move_name == NULL || write_moved_name == NULL || overwritten_name == NULL) return -1;
    if (PyType_Ready(&Way_Type) || PyType_Ready(&Method_Type)) return -1;
    return PyModule_AddObjectRef(module, "Way", (PyObject *)&Way_Type) ||
           PyModule_AddObjectRef(module, "Method", (PyObject *)&Method_Type) ? -1 : 0;
}
