"""Makes the OpenRTM of `make test-openrtm` importable like an installed one, in every process.

Its folder and those of its .pth file are appended after the standard library, where OpenRTM's own
`uuid` does no harm; PYTHONPATH would put them before it.
"""

from __future__ import annotations

import os
import site

site.addsitedir(os.environ["OPENRTM_SITE"])
