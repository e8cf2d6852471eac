"""The PYTHONPATH that makes a folder of packages importable as Python's `site` would.

`python site_path.py FOLDER` prints it: the folder, and what its .pth files add, which
OpenRTM-aist-Python needs for its IDL stubs, and PYTHONPATH alone would not read.
"""

from __future__ import annotations

import os
import site
import sys
from pathlib import Path


def main() -> None:
    """Prints the search path of the folder that the command line names."""
    known = len(sys.path)
    site.addsitedir(str(Path(sys.argv[1]).resolve()))
    print(os.pathsep.join(sys.path[known:]))


if __name__ == "__main__":
    main()
