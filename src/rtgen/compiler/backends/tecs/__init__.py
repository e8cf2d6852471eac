"""Back end for TECS: the files of joins through rtgen's plug-in."""
