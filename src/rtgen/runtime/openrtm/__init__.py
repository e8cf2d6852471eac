"""What generated modules for OpenRTM-aist-Python use; it needs omniORBpy."""
