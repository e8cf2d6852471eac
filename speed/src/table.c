/* Tables: the trees of types, which `rtgen.runtime.marshalling.tables` describes as tuples. */
#include "codec.h"
#include <structmember.h>

PyObject *numeric_array = NULL;

static void table_dealloc(Table *self) {
    PyObject_GC_UnTrack(self);
    for (Py_ssize_t i = 0; i < self->count; i++) {
        Node *node = &self->nodes[i];
        for (Py_ssize_t j = 0; j < node->count && node->members; j++) Py_XDECREF(node->members[j].name);
        PyMem_Free(node->members);
        PyMem_Free(node->labels);
        PyMem_Free(node->lengths);
        PyMem_Free(node->enumerators);
        Py_XDECREF(node->type);
        Py_XDECREF(node->first);
        Py_XDECREF(node->second);
    }
    PyMem_Free(self->nodes);
    Py_TYPE(self)->tp_free((PyObject *)self);
}

static int table_traverse(Table *self, visitproc visit, void *arg) {
    for (Py_ssize_t i = 0; i < self->count; i++) {
        Py_VISIT(self->nodes[i].type);
        Py_VISIT(self->nodes[i].first);
        Py_VISIT(self->nodes[i].second);
    }
    return 0;
}

static int refuse(const char *message) {
    PyErr_SetString(PyExc_ValueError, message);
    return -1;
}

static int number_of(PyObject *part, const char *name, Py_ssize_t absent, Py_ssize_t *number) {
    PyObject *value = PyDict_GetItemString(part, name);
    if (value == NULL || value == Py_None) {
        *number = absent;
        return 0;
    }
    *number = PyLong_AsSsize_t(value);
    return *number == -1 && PyErr_Occurred() ? -1 : 0;
}

static int node_of(Table *self, PyObject *part, const char *name, const Node **node) {
    Py_ssize_t index;
    if (number_of(part, name, -1, &index)) return -1;
    if (index >= self->count) return refuse("no such node");
    *node = index < 0 ? NULL : &self->nodes[index];
    return 0;
}

/* The offset of an attribute's slot, or -1: `__slots__` of a base of msgspec.Struct. */
Py_ssize_t slot_of(PyTypeObject *type, PyObject *name) {
    PyObject *found = _PyType_Lookup(type, name);
    if (found == NULL || !Py_IS_TYPE(found, &PyMemberDescr_Type)) return -1;
    PyMemberDef *member = ((PyMemberDescrObject *)found)->d_member;
    return member->type == T_OBJECT_EX ? member->offset : -1;
}

static int set_members(Table *self, Node *node, PyObject *part) {
    PyObject *members = PyDict_GetItemString(part, "members");
    if (members == NULL) return 0;
    if (!PyTuple_Check(members)) return refuse("members are a tuple");
    Py_ssize_t count = PyTuple_GET_SIZE(members);
    node->members = PyMem_Calloc(count ? count : 1, sizeof(Member));
    if (node->members == NULL) return PyErr_NoMemory(), -1;
    node->count = count;
    for (Py_ssize_t i = 0; i < count; i++) {
        Member *member = &node->members[i];
        PyObject *name;
        Py_ssize_t index;
        int optional, key, must_understand;
        unsigned long id, header;
        if (!PyArg_ParseTuple(PyTuple_GET_ITEM(members, i), "Unkkppp", &name, &index, &id, &header,
                              &optional, &key, &must_understand)) return -1;
        if (index < 0 || index >= self->count) return refuse("no such node");
        member->name = Py_NewRef(name);
        member->node = &self->nodes[index];
        member->id = (uint32_t)id;
        member->header = (uint32_t)header;
        member->optional = (unsigned char)optional;
        member->key = (unsigned char)key;
        member->must_understand = (unsigned char)must_understand;
        member->offset = -1;
        if (!node->plain) continue;
        member->offset = slot_of((PyTypeObject *)node->type, name);
        if (member->offset < 0) node->plain = 0;
    }
    return 0;
}

static int set_labels(Table *self, Node *node, PyObject *part) {
    PyObject *labels = PyDict_GetItemString(part, "labels");
    if (labels == NULL) return 0;
    if (!PyTuple_Check(labels)) return refuse("labels are a tuple");
    Py_ssize_t count = PyTuple_GET_SIZE(labels);
    node->labels = PyMem_Calloc(count ? count : 1, sizeof(Label));
    if (node->labels == NULL) return PyErr_NoMemory(), -1;
    for (Py_ssize_t i = 0; i < count; i++) {
        long long number;
        Py_ssize_t index;
        if (!PyArg_ParseTuple(PyTuple_GET_ITEM(labels, i), "Ln", &number, &index)) return -1;
        if (index < 0 || index >= self->count) return refuse("no such node");
        node->labels[i].number = number;
        node->labels[i].node = &self->nodes[index];
    }
    node->bound = count;
    return 0;
}

static int set_lengths(Node *node, PyObject *part) {
    PyObject *lengths = PyDict_GetItemString(part, "lengths");
    if (lengths == NULL) return 0;
    if (!PyTuple_Check(lengths)) return refuse("lengths are a tuple");
    node->dimensions = PyTuple_GET_SIZE(lengths);
    node->lengths = PyMem_Calloc(node->dimensions + 1, sizeof(Py_ssize_t));
    if (node->lengths == NULL) return PyErr_NoMemory(), -1;
    for (Py_ssize_t i = 0; i < node->dimensions; i++) {
        node->lengths[i] = PyLong_AsSsize_t(PyTuple_GET_ITEM(lengths, i));
        if (node->lengths[i] <= 0) return refuse("lengths are positive");
    }
    return 0;
}

#define MAX_ENUMERATORS 256

/* Makes the table of enumerators by number, unless one is negative or large. */
static int set_enumerators(Node *node) {
    PyObject *key, *member;
    Py_ssize_t place = 0, most = -1;
    while (PyDict_Next(node->first, &place, &key, &member)) {
        Py_ssize_t number = PyLong_AsSsize_t(key);
        if (number == -1 && PyErr_Occurred()) return -1;
        if (number < 0 || number >= MAX_ENUMERATORS) return 0;
        if (number > most) most = number;
    }
    node->enumerators = PyMem_Calloc(most + 1 > 0 ? most + 1 : 1, sizeof(PyObject *));
    if (node->enumerators == NULL) return PyErr_NoMemory(), -1;
    node->enumerator_count = most + 1;
    for (place = 0; PyDict_Next(node->first, &place, &key, &member);)
        node->enumerators[PyLong_AsSsize_t(key)] = member;
    return 0;
}

static int set_node(Table *self, Node *node, PyObject *part) {
    Py_ssize_t kind, form, align, plain, unset, version, id, must, code, shared;
    if (!PyDict_Check(part)) return refuse("nodes are dicts");
    if (number_of(part, "kind", KINDS, &kind) || number_of(part, "form", 0, &form) ||
        number_of(part, "align", 1, &align) || number_of(part, "plain", 0, &plain) ||
        number_of(part, "unset", 0, &unset) || number_of(part, "version", 0, &version) ||
        number_of(part, "shared", 0, &shared) ||
        number_of(part, "id", 0, &id) || number_of(part, "must_understand", 0, &must) ||
        number_of(part, "code", 0, &code) || number_of(part, "size", 0, &node->size) ||
        number_of(part, "bound", -1, &node->bound) || number_of(part, "length", -1, &node->length) ||
        number_of(part, "minimum", 0, &node->minimum) || node_of(self, part, "child", &node->child) ||
        node_of(self, part, "key", &node->key) || node_of(self, part, "otherwise", &node->otherwise))
        return -1;
    if (kind < 0 || kind >= KINDS) return refuse("no such kind");
    if (align != 1 && align != 2 && align != 4 && align != 8) return refuse("no such alignment");
    node->kind = (unsigned char)kind;
    node->form = (unsigned char)form;
    node->align = (unsigned char)align;
    node->plain = (unsigned char)plain;
    node->shared = (unsigned char)shared;
    node->unset = (unsigned char)unset;
    node->version = (unsigned char)version;
    node->code = (char)code;
    node->id = (uint32_t)id;
    node->must_understand = (unsigned char)must;
    node->type = Py_XNewRef(PyDict_GetItemString(part, "type"));
    node->first = Py_XNewRef(PyDict_GetItemString(part, "first"));
    node->second = Py_XNewRef(PyDict_GetItemString(part, "second"));
    if (plain && (node->type == NULL || !PyType_Check(node->type))) return refuse("a class is needed");
    return set_members(self, node, part) || set_labels(self, node, part) || set_lengths(node, part) ? -1 : 0;
}

/* What the functions rely on, so that no table leads them astray. */
static int check_node(const Node *node) {
    int needs_child = node->kind == NUMBERS || (node->kind >= REPEAT && node->kind <= MAP) ||
                      (node->kind >= UNION && node->kind <= OPTIONAL) || node->kind == PARAMETER;
    if (needs_child && node->child == NULL) return refuse("a node is missing");
    if (node->kind == NUMBERS && node->child->kind > HOOK) return refuse("atoms are needed");
    if (node->kind == MAP && node->key == NULL) return refuse("a key is missing");
    if (node->kind == STRUCT || node->kind == LIST || node->kind == UNION) {
        if (node->type == NULL || node->members == NULL) return refuse("members are missing");
        if (node->kind == UNION && (node->count != 2 || node->labels == NULL)) return refuse("two members are needed");
    }
    if (node->kind == ENUMERATOR && (node->type == NULL || node->first == NULL || !PyDict_Check(node->first) ||
                                     node->form > UINT64)) return refuse("enumerators are missing");
    if (node->kind == ENUMERATOR && set_enumerators((Node *)node)) return -1;
    if (node->kind == FLAGS && (node->type == NULL || node->form > UINT64)) return refuse("flags are missing");
    if (node->kind == HOOK && (node->first == NULL || node->second == NULL || node->size <= 0)) return refuse("hooks are missing");
    if (node->kind == NUMBERS && node->form != AS_LIST && node->child->kind > FLOAT64) return refuse("numbers are needed");
    if (node->kind == NUMBERS && node->form == AS_MAKER && node->first == NULL) return refuse("a maker is missing");
    return 0;
}

static PyObject *table_new(PyTypeObject *type, PyObject *args, PyObject *kwargs) {
    PyObject *parts;
    if (kwargs != NULL && PyDict_GET_SIZE(kwargs)) return PyErr_SetString(PyExc_TypeError, "no keywords"), NULL;
    if (!PyArg_ParseTuple(args, "O!", &PyList_Type, &parts)) return NULL;
    Table *self = (Table *)type->tp_alloc(type, 0);
    if (self == NULL) return NULL;
    Py_ssize_t count = PyList_GET_SIZE(parts);
    self->nodes = PyMem_Calloc(count ? count : 1, sizeof(Node));
    if (self->nodes == NULL) {
        Py_DECREF(self);
        return PyErr_NoMemory();
    }
    self->count = count;
    int failed = 0;
    for (Py_ssize_t i = 0; i < count && !failed; i++) failed = set_node(self, &self->nodes[i], PyList_GET_ITEM(parts, i));
    for (Py_ssize_t i = 0; i < count && !failed; i++) failed = check_node(&self->nodes[i]);
    if (failed) {
        Py_DECREF(self);
        return NULL;
    }
    return (PyObject *)self;
}

PyTypeObject Table_Type = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "rtgen_speed.Table",
    .tp_basicsize = sizeof(Table),
    .tp_dealloc = (destructor)table_dealloc,
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC,
    .tp_traverse = (traverseproc)table_traverse,
    .tp_doc = "The tree of a type in a format.",
    .tp_new = table_new,
};

void swap_all(char *at, Py_ssize_t count, Py_ssize_t size) {
    for (Py_ssize_t i = 0; i < count; i++, at += size) {
        if (size == 2) {
            uint16_t n;
            memcpy(&n, at, 2);
            n = swap16(n);
            memcpy(at, &n, 2);
        } else if (size == 4) {
            uint32_t n;
            memcpy(&n, at, 4);
            n = swap32(n);
            memcpy(at, &n, 4);
        } else if (size == 8) {
            uint64_t n;
            memcpy(&n, at, 8);
            n = swap64(n);
            memcpy(at, &n, 8);
        }
    }
}

int union_number(PyObject *discriminator, int64_t *number) {
    if (PyLong_Check(discriminator)) {
        int overflow;
        long long value = PyLong_AsLongLongAndOverflow(discriminator, &overflow);
        if (overflow > 0) {  /* the labels of uint64 have the same bits */
            unsigned long long large = PyLong_AsUnsignedLongLong(discriminator);
            if (PyErr_Occurred()) return -1;
            value = (long long)large;
            *number = value;
            return 0;
        }
        if (overflow || (value == -1 && PyErr_Occurred())) return -1;
        *number = value;
        return 0;
    }
    if (PyUnicode_Check(discriminator) && PyUnicode_GET_LENGTH(discriminator) == 1) {
        *number = PyUnicode_READ_CHAR(discriminator, 0);
        return 0;
    }
    return -1;
}

const Node *branch_of(const Node *node, int64_t number) {
    for (Py_ssize_t i = 0; i < node->bound; i++)
        if (node->labels[i].number == number) return node->labels[i].node;
    return node->otherwise;
}

/* A new instance, to which the references in `values` are given; they are released on failure.
 * What refers to nothing that can be in a cycle is not tracked: so do constructors of msgspec.Struct,
 * whose setters track an instance later. */
PyObject *instance(const Node *node, PyObject **values) {
    PyTypeObject *type = (PyTypeObject *)node->type;
    PyObject *made;
    Py_ssize_t count = node->count;
    if (node->plain) {
        unsigned long traits = PyType_IS_GC(type) ? 0 : Py_TPFLAGS_HAVE_GC;
        for (Py_ssize_t i = 0; i < count; i++) traits |= Py_TYPE(values[i])->tp_flags;
        if (traits & Py_TPFLAGS_HAVE_GC) {
            made = type->tp_alloc(type, 0);
        } else {
            made = PyObject_GC_New(PyObject, type);
            if (made != NULL) memset(made + 1, 0, type->tp_basicsize - sizeof(PyObject));
        }
        if (made != NULL) {
            for (Py_ssize_t i = 0; i < count; i++) *(PyObject **)((char *)made + node->members[i].offset) = values[i];
            return made;
        }
    } else {
        made = PyObject_Vectorcall(node->type, values, count, NULL);
    }
    for (Py_ssize_t i = 0; i < count; i++) Py_DECREF(values[i]);
    return made;
}
