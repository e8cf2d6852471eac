"""DDS by Eclipse Cyclone DDS: a medium of `rtgen.runtime.distribution` (extra `dds`)."""
