/* Copies values, as `rtgen.runtime.marshalling.source.copier` does: what cannot change is shared. */
#include "codec.h"

static PyObject *copy_rows(PyObject *value, Py_ssize_t dimensions) {
    if (!PyList_CheckExact(value)) return NULL;
    Py_ssize_t count = PyList_GET_SIZE(value);
    if (dimensions <= 1) return PyList_GetSlice(value, 0, count);
    PyObject *list = PyList_New(count);
    for (Py_ssize_t i = 0; list != NULL && i < count; i++) {
        PyObject *row = copy_rows(PyList_GET_ITEM(value, i), dimensions - 1);
        if (row == NULL) Py_CLEAR(list);
        else PyList_SET_ITEM(list, i, row);
    }
    return list;
}

static PyObject *copy_numbers(const Node *node, PyObject *value) {
    if (PyList_CheckExact(value)) return copy_rows(value, node->form == AS_LIST ? node->dimensions : 1);
    if (numeric_array == NULL || (PyObject *)Py_TYPE(value) != numeric_array || node->form == AS_LIST) return NULL;
    PyObject *code = PyObject_GetAttrString(value, "typecode");
    PyObject *made = code == NULL ? NULL : PyObject_CallFunctionObjArgs(numeric_array, code, value, NULL);
    Py_XDECREF(code);
    return made;
}

static PyObject *copy_repeated(const Node *node, PyObject *value, int depth) {
    if (!PyList_CheckExact(value)) return NULL;
    Py_ssize_t count = PyList_GET_SIZE(value);
    if (node->child->shared) return PyList_GetSlice(value, 0, count);
    PyObject *list = PyList_New(count);
    for (Py_ssize_t i = 0; list != NULL && i < count; i++) {
        PyObject *item = i < PyList_GET_SIZE(value) ? Py_NewRef(PyList_GET_ITEM(value, i)) : NULL;
        PyObject *made = item == NULL ? NULL : copy(node->child, item, depth);
        Py_XDECREF(item);
        if (made == NULL) Py_CLEAR(list);
        else PyList_SET_ITEM(list, i, made);
    }
    return list;
}

static PyObject *copy_map(const Node *node, PyObject *value, int depth) {
    if (!PyDict_CheckExact(value)) return NULL;
    if (node->child->shared) return PyDict_Copy(value);
    PyObject *map = PyDict_New(), *key, *item;
    Py_ssize_t place = 0;
    while (map != NULL && PyDict_Next(value, &place, &key, &item)) {
        Py_INCREF(key);
        Py_INCREF(item);
        PyObject *made = copy(node->child, item, depth);
        if (made == NULL || PyDict_SetItem(map, key, made)) Py_CLEAR(map);
        Py_XDECREF(made);
        Py_DECREF(key);
        Py_DECREF(item);
    }
    return map;
}

#define FEW 32

/* Structs, unions and lists; `branch` is the node of a union's value. */
static PyObject *copy_members(const Node *node, PyObject *value, int depth) {
    if ((PyObject *)Py_TYPE(value) != node->type || !node->plain) return NULL;
    PyObject *few[FEW], **values = few, *made = NULL;
    if (node->count > FEW) {
        values = PyMem_Calloc(node->count, sizeof(PyObject *));
        if (values == NULL) return PyErr_NoMemory();
    }
    Py_ssize_t i;
    for (i = 0; i < node->count; i++) {
        const Node *inner = node->members[i].node;
        PyObject *part = Py_XNewRef(*(PyObject **)((char *)value + node->members[i].offset));
        if (node->kind == UNION && i == 1) {
            int64_t number;
            inner = union_number(values[0], &number) ? NULL : branch_of(node, number);
            PyErr_Clear();  /* of a number that no label has */
            if (inner == NULL && part != Py_None) Py_CLEAR(part);
        }
        int shared = part == NULL || inner == NULL || inner->shared || (part == Py_None && node->members[i].optional);
        values[i] = shared ? Py_XNewRef(part) : copy(inner, part, depth);
        Py_XDECREF(part);
        if (values[i] == NULL) break;
    }
    if (i == node->count) made = instance(node, values);
    else while (i--) Py_DECREF(values[i]);
    if (values != few) PyMem_Free(values);
    return made;
}

/* Whether `old`, a part of a sample that nothing else refers to, can become the copy of `value`. */
ALWAYS int is_reusable(const Node *node, PyObject *value, PyObject *old) {
#ifdef Py_GIL_DISABLED
    return 0;  /* references of other threads are not counted */
#endif
    if (old == NULL || Py_REFCNT(old) != 1 || !Py_IS_TYPE(old, Py_TYPE(value))) return 0;
    if (node->kind == STRUCT)
        return (PyObject *)Py_TYPE(value) == node->type && node->plain && !Py_TYPE(value)->tp_dictoffset && !Py_TYPE(value)->tp_weaklistoffset;
    int is_flat = node->kind == NUMBERS ? node->form != AS_LIST || node->dimensions <= 1 : node->kind == REPEAT && node->child->shared;
    return is_flat && PyList_CheckExact(value) && PyList_GET_SIZE(value) == PyList_GET_SIZE(old);
}

/* Copies into `old`, whose reference is passed on, what it can; else makes a copy. */
static PyObject *copy_into(const Node *node, PyObject *value, PyObject *old, int depth) {
    if (depth > MAX_DEPTH || !is_reusable(node, value, old)) {
        PyObject *made = copy(node, value, depth);
        Py_XDECREF(old);
        return made;
    }
    if (node->kind != STRUCT) {
        for (Py_ssize_t i = 0; i < PyList_GET_SIZE(value) && i < PyList_GET_SIZE(old); i++) {
            PyObject *before = PyList_GET_ITEM(old, i);
            PyList_SET_ITEM(old, i, Py_NewRef(PyList_GET_ITEM(value, i)));
            Py_DECREF(before);
        }
        return old;
    }
    for (Py_ssize_t i = 0; i < node->count; i++) {
        const Member *member = &node->members[i];
        PyObject *part = Py_XNewRef(*(PyObject **)((char *)value + member->offset));
        PyObject **slot = (PyObject **)((char *)old + member->offset), *before = *slot;
        *slot = NULL;
        if (part == NULL) return Py_XDECREF(before), Py_DECREF(old), NULL;
        if (member->node->shared || (part == Py_None && member->optional)) {
            *slot = part;
            Py_XDECREF(before);
            continue;
        }
        *slot = copy_into(member->node, part, before, depth + 1);
        Py_DECREF(part);
        if (*slot == NULL) return Py_DECREF(old), NULL;
    }
    return old;
}

/* Returns a copy. `spare` is a sample that only the caller refers to, or NULL: its reference is passed on. */
PyObject *copy_over(const Node *node, PyObject *value, PyObject *spare) { return copy_into(node, value, spare, 0); }

PyObject *copy(const Node *node, PyObject *value, int depth) {
    if (node->shared) return Py_NewRef(value);
    if (depth > MAX_DEPTH) return NULL;
    switch (node->kind) {
    case TEXT: return PyBytes_CheckExact(value) ? Py_NewRef(value) : NULL;
    case NUMBERS: return copy_numbers(node, value);
    case REPEAT: return copy_repeated(node, value, depth + 1);
    case MAP: return copy_map(node, value, depth + 1);
    case STRUCT:
    case UNION:
    case LIST:
        if (value == Py_None && node->unset) return Py_NewRef(Py_None);
        return copy_members(node, value, depth + 1);
    case DELIMITED: return copy(node->child, value, depth + 1);
    case OPTIONAL: return value == Py_None ? Py_NewRef(value) : copy(node->child, value, depth + 1);
    default: return NULL;
    }
}
