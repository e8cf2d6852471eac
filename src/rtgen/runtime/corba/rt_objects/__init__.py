"""Components as RTObjects of OMG RTC 1.0 and SDO 1.1, as OpenRTM-aist 2.x has them over CORBA.

System editors, rtshell and components of OpenRTM see, connect, configure and steer them.
"""
