from house.components.fans import FansBase


class Fans(FansBase):
    pass
