from rtgen.runtime import Component


class Still(Component):
    pass
