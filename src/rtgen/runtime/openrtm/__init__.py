"""What modules and systems on OpenRTM-aist-Python share; it needs omniORBpy."""
