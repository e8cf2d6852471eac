"""Service calls over omniORB, between processes, by the descriptors of generated interfaces.

Importing it needs omniORBpy: the extra `corba`.
"""
