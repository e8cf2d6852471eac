from rtgen.runtime import Component
from rtgen.runtime.library.canopen import ObjectDictionary, SdoAbort


class Objects(ObjectDictionary):
    def read(self, index, subindex):
        raise SdoAbort(0x06090011, "no such subindex")

    def write(self, index, subindex, value):
        pass

    def get(self, index, subindex):
        raise NotImplementedError

    def set(self, index, subindex, value):
        pass


class Node(Component):
    def __init__(self, name=None):
        super().__init__(name)
        self.add_provider("sdo", "objects", ObjectDictionary).set_servant(Objects())
