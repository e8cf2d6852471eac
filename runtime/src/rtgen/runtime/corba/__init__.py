"""Service calls between processes over omniORB (CORBA 2.6, GIOP 1.2).

Importing it requires omniORBpy: the extra `corba`.
"""
