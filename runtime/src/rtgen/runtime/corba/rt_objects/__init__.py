"""Components as RTObjects (OMG RTC 1.0, SDO 1.1) over CORBA, compatible with OpenRTM-aist 2.x.

System editors, rtshell and components of OpenRTM can show, connect, configure and control them.
"""
