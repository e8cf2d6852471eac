from rtgen.runtime import Component

raise RuntimeError("no fan here")


class Fan(Component):
    pass
