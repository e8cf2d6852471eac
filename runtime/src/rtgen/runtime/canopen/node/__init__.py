"""A CANopen device (CiA 301): its object dictionary, its node, and the component around them."""
