"""The types of the IDL files that come with rtgen: `rtc`, `canopen`; generated, never edited.

`tests/compiler/types/test_library.py --update-golden` renews them.
"""
